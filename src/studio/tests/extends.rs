//! Tests style files that extend a preset: they have only differences, their errors have positions, and saving them
//! again changes nothing.

use super::{Random, open, presets};
use crate::file::atomic;
use crate::studio::document::{Reloaded, StyleDocument};
use crate::studio::rows::Row;
use crate::style::differences::{nearest_preset, written};
use crate::style::{Style, names, preset_text};
use crate::tests::common::full;

/// Edits a document at random.
fn edit(document: &mut StyleDocument, random: &mut Random, count: usize) {
    for _ in 0..count {
        if random.below(5) == 0 {
            let edit = random.layer_edit(document);
            let _ = document.edit_layers(&edit);
        } else {
            let rows: Vec<Row> = document.sections().iter().flat_map(|section| section.rows.clone()).collect();
            let row = &rows[random.below(rows.len())];
            let value = random.value(row);
            let _ = document.set(&row.key, value);
        }
        document.release();
    }
}

fn read(path: &std::path::Path) -> String {
    std::fs::read_to_string(path).unwrap()
}

#[test]
fn save_reload_save_gives_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random(4);
    let mut count = 0;
    for (number, name) in presets().into_iter().enumerate() {
        // In the fast tier each preset is saved once: without edits, with some, or as a style that extends another one.
        for round in (0..8).filter(|round| full() || *round == [0, 2, 7][number % 3]) {
            let mut document = open(name);
            edit(&mut document, &mut random, 3 * round);
            // Most styles extend the preset that they come from, some another one.
            let preset = if round == 7 { names()[random.below(names().len())] } else { name };
            let path = folder.path().join(format!("{name}-{round}.toml"));
            let mut saved = document.save_as(path.to_str().unwrap(), Some(preset)).unwrap();
            let text = read(&path);
            assert!(text.starts_with(&format!("extends = \"{preset}\"")), "{text}");
            let style = Style::read(&path).unwrap();
            let own = Style { name: style.name.clone(), files: style.files.clone(), ..document.style().clone() };
            assert_eq!(own, style, "{name} {round}: {text}");
            assert_eq!(saved.style(), &style);
            assert!(!saved.is_edited());
            saved.save().unwrap();
            assert_eq!(read(&path), text);
            let mut again = StyleDocument::open(path.to_str().unwrap()).unwrap();
            assert_eq!(again.style(), &style);
            again.save().unwrap();
            assert_eq!(read(&path), text);
            // Edits of a file that extends are written as differences, too.
            edit(&mut again, &mut random, 4);
            again.save().unwrap();
            let edited = read(&path);
            let style = Style::read(&path).unwrap();
            assert_eq!(again.style(), &style, "{name} {round}: {edited}");
            StyleDocument::open(path.to_str().unwrap()).unwrap().save().unwrap();
            assert_eq!(read(&path), edited);
            count += 1;
        }
    }
    assert!(count > if full() { 200 } else { 7 }, "{count}");
}

#[test]
fn only_differences_are_written_and_comments_stay() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.toml");
    let text = "# My pen\nextends = \"pen\"\nname = \"mine\" # of course\n\n# bold\n[[layers]]\nkind = \"strokes\"\n\
                width_px = 3.50 # was 2.4\n\n[paper]\ngrain = 0.1\n";
    atomic::write(&path, text.as_bytes()).unwrap();
    let mut document = StyleDocument::open(path.to_str().unwrap()).unwrap();
    let pen = open("pen");
    let strokes = document.style().strokes().unwrap();
    assert_eq!((strokes.width_px, strokes.taper_px), (3.5, pen.style().strokes().unwrap().taper_px));
    assert_eq!(document.preset(), Some("pen"));
    document.save().unwrap();
    assert_eq!(read(&path), text);
    document.set("strokes.taper_px", 9.0).unwrap();
    document.set("light.wrap", 0.5).unwrap();
    document.set("paper.grain", f64::from(pen.style().paper.grain)).unwrap();
    document.save().unwrap();
    let wanted = text.replace("# was 2.4\n", "# was 2.4\ntaper_px = 9.0\n").replace("grain = 0.1\n", "");
    assert_eq!(read(&path), format!("{wanted}\n[light]\nwrap = 0.5\n"));
    // Back to what the preset has: a value with a comment stays.
    document.set("strokes.width_px", 2.4).unwrap();
    document.restore("strokes.texture").unwrap();
    document.save().unwrap();
    assert!(read(&path).contains("width_px = 2.4 # was 2.4"), "{}", read(&path));
    assert!(read(&path).contains("without = [\"strokes.texture\"]"), "{}", read(&path));
    assert_eq!(Style::read(&path).unwrap().strokes().unwrap().texture_name, None);
    // An editor changes the file.
    let edited = read(&path).replace("taper_px = 9.0", "taper_px = 8.0");
    atomic::write(&path, edited.as_bytes()).unwrap();
    assert_eq!(document.reload(Some(edited.clone())).unwrap(), Reloaded::Changed);
    assert_eq!(document.style().strokes().unwrap().taper_px, 8.0);
    document.set("strokes.taper_px", 7.0).unwrap();
    assert_eq!(document.reload(Some(edited.clone())).unwrap(), Reloaded::Unchanged);
    document.save().unwrap();
    assert_eq!(read(&path), edited.replace("taper_px = 8.0", "taper_px = 7.0"));
    // Planted: a file that another program has changed is not overwritten.
    atomic::write(&path, text.as_bytes()).unwrap();
    assert!(document.save().is_err());
}

#[test]
fn errors_have_line_and_column() {
    let error = |text: &str| Style::parse("x.toml", text).unwrap_err().to_string();
    for (text, wanted) in [
        ("extends = \"pne\"", "x.toml:1:11: extends: there is no preset \"pne\"; did you mean \"pen\"?"),
        ("\nextends = 3", "x.toml:2:11: extends must be the name of a preset, but 3 is a number"),
        ("extends = \"pen\"\nwithout = [\"watr\"]", "x.toml:2:12: without: the preset has no \"watr\""),
        ("extends = \"pen\"\norder = [\"water\"]", "x.toml:2:9: order must list all layers"),
        ("extends = \"pen\"\n[paper]\ngrain = 3", "x.toml:3:9: paper.grain is 3, not between 0 and 1"),
        ("extends = \"pen\"\n[paper]\ngrian = 0.5", "x.toml:3:1: unknown key"),
        ("extends = \"pen\"\n[[layers]]\nkind = \"strokes\"\nwidth_px = 900", "x.toml:4:12: strokes.width_px is 900"),
        ("extends = \"pen\"\n[strokes]\nwidth_px = 2", "x.toml:2:2: [strokes] cannot be used with [[layers]]"),
        ("extends = \"pen\"\n[[layers]]\nwidth_px = 2", "x.toml:2:1: the key \"layers.kind\" is missing"),
    ] {
        let found = error(text);
        assert!(found.starts_with(wanted) && !found.contains('\n'), "{found}\nnot: {wanted}");
    }
    // A preset itself, and one without any section.
    for name in presets() {
        let same = Style::parse("x.toml", &format!("extends = \"{name}\"")).unwrap();
        assert_eq!(same, Style::load(name).unwrap());
        let bare = written(name, name, preset_text(name).unwrap(), None).unwrap();
        assert_eq!(bare, format!("extends = \"{name}\"\n"));
        // A style is nearest to the preset that it is.
        assert_eq!(nearest_preset(name, preset_text(name).unwrap()), Some(name));
    }
    let key = crate::style::with_value("x.toml", "extends = \"pen\"", "strokes.width_px", 5.0).unwrap();
    assert_eq!(Style::parse("x.toml", &key).unwrap().strokes().unwrap().width_px, 5.0);
}
