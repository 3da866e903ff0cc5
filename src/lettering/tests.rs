use super::*;
use crate::tests::common::full;

#[test]
fn every_line_of_the_table_is_a_letter() {
    let text = include_str!("letters.txt");
    let holds = |text: &str| table(text).len() == text.lines().filter(|line| !line.starts_with('#')).count();
    assert!(holds(text) && LETTERS.len() > 190);
    assert!(!holds(&text.replacen(",", ";", 1)) || text.find(',') < text.find("U+"), "planted: damage");
    assert!(!holds(&text.replace("U+0041 18 9,21", "U+0041 18 9;21")), "planted: damage");
    // ASCII and Latin-1 are complete, except for the soft hyphen, which is invisible.
    let latin = (0x20..0x7f).chain(0xa0..0x100).filter(|code| *code != 0xad).filter_map(char::from_u32);
    let missing: Vec<char> = latin.filter(|character| !LETTERS.contains_key(character)).collect();
    assert!(missing.is_empty(), "{missing:?}");
    // Letters are on the baseline, have plausible heights, and stay within their advance.
    let of = |character: char| LETTERS[&character].strokes.concat();
    let high = |points: &[DVec2]| points.iter().map(|point| point.y).fold(f64::MIN, f64::max);
    assert!((high(&of('H')) - 1.0).abs() < 1e-9 && high(&of('É')) > 1.2 && high(&of('x')) < 0.7);
    for (character, letter) in LETTERS.iter() {
        let inside = |point: &DVec2| point.x >= -0.01 && point.x <= letter.advance + 0.01 && point.y.abs() < 1.5;
        assert!(letter.strokes.concat().iter().all(inside), "{character}");
    }
}

#[test]
fn characters_without_a_letter_are_replaced_and_reported_once() {
    let none = Fonts::of(fontdb::Database::new());
    let line = Line::with("  Mont\tBlanc \n 山 é 山 Ж", Setting::default(), || &none);
    assert_eq!(line.text(), "Mont Blanc ? é ? ?");
    assert_eq!(line.replaced, ['山', 'Ж']);
    assert!(Line::new("Gruss aus Zürich – Säntis").replaced.is_empty());
}

#[test]
fn long_texts_shrink_and_are_then_cut() {
    let line = Line::new("Grosser Aletschgletscher");
    let width = line.width();
    assert_eq!(line.fitted(4.0 * width, 3.0, 1.0), (line.clone(), 3.0));
    let (same, height) = line.fitted(2.0 * width, 3.0, 1.0);
    assert!(same == line && (height - 2.0).abs() < 1e-9);
    let (cut, height) = line.fitted(0.5 * width, 3.0, 1.0);
    assert!(cut.text().ends_with('…') && cut.text().starts_with("Grosser") && height == 1.0, "{}", cut.text());
    assert!(cut.width() <= 0.5 * width && cut.width() > 0.4 * width);
    assert_eq!(line.fitted(0.1, 3.0, 1.0).0.text(), "");
    // The result is the same as by trying each shorter text; a text of a megabyte is cut as fast as it is read.
    let words = Line::new("Am  Ende der Welt");
    for room in (0..60).map(|tenths| 0.1 * f64::from(tenths)) {
        let (cut, _) = words.fitted(room, 1.0, 1.0);
        let shorter = (0..words.text().chars().count()).rev().map(|count| {
            let begin: String = words.text().chars().take(count).collect();
            Line::new(&format!("{}…", begin.trim_end()))
        });
        let expected = shorter.clone().find(|line| line.width() <= room).map_or(String::new(), |line| line.text);
        assert_eq!(cut.text(), expected, "{room}");
    }
    let start = std::time::Instant::now();
    let long: String = (0..1 << 20).filter_map(|i| char::from_u32(0x4e00 + i % 60_000)).collect();
    let none = Fonts::of(fontdb::Database::new());
    let (cut, _) = Line::with(&long, Setting::default(), || &none).fitted(1000.0, 3.0, 1.0);
    assert!(cut.text().ends_with('…') && start.elapsed().as_secs_f64() < 5.0, "{:?}", start.elapsed());
}

/// Returns a line in a typeface on a machine without fonts.
fn set(text: &str, font: Own, spacing: f64) -> Line {
    let none = Fonts::of(fontdb::Database::new());
    Line::with(text, Setting { font: Some(font), spacing }, || &none)
}

const TYPEFACES: [Own; 3] = [Own::Serif, Own::Sans, Own::Capitals];

#[test]
fn typefaces_have_the_letters_of_maps() {
    let names = "Zürich, Łódź, Ísafjörður, Αθήνα, Москва, Þingvellir, Şırnak, Kraków, Őrség, Čakovec, Київ, Groß, Iași";
    let signs = "1\u{2009}:\u{2009}50\u{2009}000 −12.5° 46°30′15″N × · – … © “” «» ‘’ % & ( ) / + = m km";
    for font in TYPEFACES {
        for text in [names, signs] {
            let line = set(text, font, 0.0);
            assert!(line.replaced.is_empty(), "{font:?}: {:?}", line.replaced);
            for character in text.chars().filter(|it| !it.is_whitespace()) {
                let areas = set(&character.to_string(), font, 0.0).areas(DVec2::ZERO, 10.0);
                assert_eq!(areas.len(), 1, "{font:?}: {character} has an outline");
            }
            assert!(line.strokes(DVec2::ZERO, 10.0).is_empty(), "{font:?}: no letter is one of strokes");
        }
        assert_eq!(set("山 Ж", font, 0.0).replaced, ['山'], "planted: a character that no typeface has");
    }
}

#[test]
fn letters_of_typefaces_are_kerned_and_spaced() {
    for font in TYPEFACES {
        let width = |text: &str| set(text, font, 0.0).width();
        for pair in ["AV", "To"] {
            let apart: f64 = pair.chars().map(|letter| width(&letter.to_string())).sum();
            assert!(width(pair) < apart - 0.02, "{font:?} {pair}: {} and apart {apart}", width(pair));
        }
        assert!((width("HH") - 2.0 * width("H")).abs() < 0.02, "planted: a pair that needs no kerning");
        let spaced = set("HIN", font, 0.5).width() - width("HIN");
        assert!((spaced - 1.0).abs() < 0.05, "{font:?}: two gaps of three letters, {spaced}");
        // Figures are as high as capitals and on the baseline, and thin blanks are thin.
        for digit in "0123456789".chars() {
            let [top, bottom] = set(&digit.to_string(), font, 0.0).areas(DVec2::ZERO, 1.0)[0].high_px();
            assert!((top + 1.0).abs() < 0.12 && bottom.abs() < 0.06, "{font:?} {digit}: {top} {bottom}");
        }
        let [thin, wide] = ["1\u{2009}2", "1 2"].map(|text| width(text) - width("12"));
        assert!(thin > 0.15 && thin < 0.9 * wide.max(0.36), "{font:?}: {thin} and {wide}");
    }
    assert_eq!(Line::title("Αθήνα, Zürich", Typeface::Capitals).text(), "ΑΘΗΝΑ, ZÜRICH");
    let [plain, capitals] = ["Alps", "ALPS"].map(|text| Line::title(text, Typeface::Serif).setting.spacing);
    assert!(plain == 0.0 && capitals > 0.1);
    // A text that is cut ends in an ellipsis of the typeface.
    let (cut, _) = Line::title("Grosser Aletschgletscher", Typeface::Sans).fitted(6.0, 1.0, 1.0);
    assert!(cut.text().ends_with('…') && cut.width() <= 6.0 && cut.strokes(DVec2::ZERO, 1.0).is_empty());
}

#[test]
fn pixels_are_covered_where_outlines_are() {
    // The fast tier looks at every second row of one typeface.
    let (typefaces, step) = if full() { (3, 1) } else { (1, 2) };
    for font in TYPEFACES.into_iter().take(typefaces) {
        let areas = set("Zürich ©8", font, 0.0).areas(DVec2::new(4.0, 44.0), 30.0);
        let boxes: Vec<_> = areas.iter().map(|area| kurbo::Shape::bounding_box(&area.curves)).collect();
        let unlike = |shift: f64| {
            let mut count = 0;
            for row in (0..56).step_by(step) {
                let mut covered = vec![0.0; 240];
                area::cover_areas(&areas, 0.0, f64::from(row), &mut covered);
                for (x, part) in covered.iter().enumerate() {
                    let inside = |dx: f64, dy: f64| {
                        let at = (x as f64 + dx + shift, f64::from(row) + dy);
                        let mut near = areas.iter().zip(&boxes).filter(|(_, around)| around.contains(at));
                        near.any(|(area, _)| kurbo::Shape::winding(&area.curves, at.into()) != 0)
                    };
                    let samples = (0..8).flat_map(|i| (0..8).map(move |j| (i, j)));
                    let inside =
                        samples.filter(|(i, j)| inside((f64::from(*i) + 0.5) / 8.0, (f64::from(*j) + 0.5) / 8.0));
                    count += usize::from((inside.count() as f32 / 64.0 - part).abs() > 0.12);
                }
            }
            count
        };
        let found = [unlike(0.0), unlike(0.5)];
        assert!(found[0] == 0 && found[1] > 100, "{font:?}: {found:?}; planted: moved by half a pixel");
    }
}

#[test]
fn strokes_are_at_the_requested_positions() {
    let strokes = Line::new("H").strokes(DVec2::new(10.0, 100.0), 42.0);
    let points = strokes.concat();
    let [low, high] = [f64::min, f64::max].map(|pick| points.iter().map(|at| at.y).reduce(pick));
    assert_eq!([low, high], [Some(58.0), Some(100.0)]);
    assert!(points.iter().all(|at| at.x > 10.0 && at.x < 10.0 + 42.0 * Line::new("H").width()));
}

/// Fonts of the window's library, as those of a machine.
#[cfg(feature = "window")]
fn fonts() -> Fonts {
    let mut database = fontdb::Database::new();
    for font in egui::FontDefinitions::default().font_data.values() {
        database.load_font_data((*font.font).as_ref().to_vec());
    }
    Fonts::of(database)
}

#[cfg(feature = "window")]
#[test]
fn characters_that_the_table_lacks_come_from_fonts() {
    let fonts = fonts();
    let line = Line::with("Гора Elbrus, Łódź 山", Setting::default(), || &fonts);
    assert_eq!((line.text(), line.replaced.as_slice()), ("Гора Elbrus, Łódź ?", &['山'][..]));
    let (areas, strokes) = (line.areas(DVec2::ZERO, 10.0), line.strokes(DVec2::ZERO, 10.0));
    // Four letters of the first word, and two that Latin-1 does not have.
    assert_eq!(areas.len(), 6);
    assert!(strokes.len() > 12 && line.width() > 10.0 && line.width() < 30.0, "{}", line.width());
    // Letters are on the baseline, as high as those of the table.
    let [top, bottom] = areas[0].high_px();
    assert!((top + 10.0).abs() < 0.5 && bottom.abs() < 0.2, "{top} {bottom}");
    // Where there is no font, all are replaced.
    let none = Fonts::of(fontdb::Database::new());
    assert_eq!(Line::with("Гора Elbrus", Setting::default(), || &none).replaced, ['Г', 'о', 'р', 'а']);
    // A mark takes its letter along.
    let marked = Line::with("Ve\u{301}lo", Setting::default(), || &fonts);
    assert!(marked.replaced.is_empty() && !marked.areas(DVec2::ZERO, 1.0).is_empty());
    // Text that is too long is cut.
    let (cut, _) = Line::with(&"Гора ".repeat(9000), Setting::default(), || &fonts).fitted(100.0, 1.0, 1.0);
    assert!(cut.text().ends_with('…') && cut.width() <= 100.0 && cut.width() > 90.0, "{}", cut.width());
}

#[cfg(feature = "window")]
#[test]
fn text_that_runs_to_the_left_is_ordered() {
    let fonts = fonts();
    // Hebrew has no letters in these fonts, so its question marks show the order.
    let none = BTreeMap::new();
    let order = |text: &str| -> Vec<usize> {
        pieces(text, Some(&fonts), &none, 0.0).0.into_iter().map(|piece| piece.begin).collect()
    };
    assert_eq!(order("ab 12"), [0, 1, 2, 3, 4]);
    // A mark of direction makes the whole run to the left, except for the words and the number in it.
    assert_eq!(order("\u{200f}ab 12"), [3, 4, 5, 6, 7]);
    let (found, is_leftward) = pieces("\u{200f}! ab", Some(&fonts), &none, 0.0);
    assert!(is_leftward);
    let found: Vec<usize> = found.into_iter().map(|piece| piece.begin).collect();
    assert_eq!(found, [5, 6, 4, 3]);
}
