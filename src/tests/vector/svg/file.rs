//! Tests the contents of SVG files: layers, paper, faint ink, empty drawings, and no invalid numbers.

use std::path::Path;

use hachure::file::svg::{Layer, Stroke, Text, Unit, write_svg};
use hachure::lines::strokes::polylines::EdgeKind;
use hachure::vector::DrawingReport;
use hachure::vector::sheet::Sheet;
use kurbo::{Affine, BezPath, Point, Shape};
use roxmltree::Document;

use super::{SIZE_PX, drawing, hill, read, settings, strokes_of, written, written_layers};
use crate::tests::common::full;
use crate::tests::vector::polyline;

const LAYERS: [&str; 6] = ["contours", "borders", "creases", "suggestive-contours", "ridges", "valleys"];

#[test]
fn layers_are_kinds() {
    let Some(mut world) = hill() else { return };
    let mut counts = |change: &dyn Fn(&mut hachure::style::Strokes)| {
        let drawn = strokes_of(&mut world, "0,-1450,+160,0,-6,50", change);
        let (text, report) = written(&drawn.polylines, &settings(Sheet::pixels(SIZE_PX)));
        let paths = read(&text);
        let of = |layer: &str| paths.iter().filter(|read| read.layer == layer).count();
        let ours = LAYERS.map(of);
        let reported =
            [report.contours, report.borders, report.creases, report.suggestive, report.ridges, report.valleys];
        assert_eq!(ours.map(|count| count as u64), reported);
        let kinds = EdgeKind::ALL.map(|kind| drawn.polylines.iter().filter(|line| line.kind == kind).count());
        assert_eq!(ours, kinds);
        let order: Vec<&str> = paths.iter().map(|read| read.layer.as_str()).collect();
        assert!(order.is_sorted_by_key(|layer| LAYERS.iter().position(|it| it == layer)));
        ours
    };
    let plain = counts(&|_| {});
    assert!(plain[0] > 0 && plain[1] > 0 && plain[2..] == [0; 4], "{plain:?}");
    let creases = counts(&|strokes| (strokes.borders, strokes.crease_deg) = (false, Some(3.0)));
    assert!(creases[1] == 0 && creases[2] > 0, "{creases:?}");
    let suggest = |strokes: &mut hachure::style::Strokes| {
        (strokes.suggestive_px, strokes.suggestive_rise) = (Some(2.0), 1e-4);
    };
    let ridges = |strokes: &mut hachure::style::Strokes| {
        (strokes.ridge_px, strokes.ridge_bend, strokes.valley_width) = (Some(2.0), 1e-3, 0.5);
    };
    let [suggested, found] = if full() {
        [counts(&suggest), counts(&ridges)]
    } else {
        let both = |strokes: &mut hachure::style::Strokes| {
            suggest(strokes);
            ridges(strokes);
        };
        [counts(&both); 2]
    };
    assert!(suggested[3] > 0 && found[4] > 0 && found[5] > 0, "{suggested:?} {found:?}");
}

#[test]
fn paper_has_its_size_and_its_margins() {
    let corners = [Point::new(0.0, 0.0), Point::new(640.0, 0.0), Point::new(640.0, 360.0), Point::new(0.0, 360.0)];
    let frame = [polyline(&corners, EdgeKind::Border, true)];
    for (paper, margin_mm, size_px, expected) in [
        ("a4", 10.0, [640, 360], [297.0, 210.0]),
        ("A4", 10.0, [360, 640], [210.0, 297.0]),
        ("a3", 0.0, [640, 640], [420.0, 297.0]),
        ("300x200.5", 25.0, [640, 360], [300.0, 200.5]),
        ("200.5x300", 25.0, [640, 360], [300.0, 200.5]),
    ] {
        let sheet = Sheet::paper(paper, margin_mm, size_px).unwrap();
        let scale = ((expected[0] - 2.0 * margin_mm) / f64::from(size_px[0]))
            .min((expected[1] - 2.0 * margin_mm) / f64::from(size_px[1]));
        let (text, report) = written(&frame, &settings(sheet));
        let document = Document::parse(&text).unwrap();
        let root = document.root_element();
        let [width, height] = expected;
        assert_eq!(root.attribute("width"), Some(format!("{width}mm").as_str()));
        assert_eq!(root.attribute("height"), Some(format!("{height}mm").as_str()));
        assert_eq!(root.attribute("viewBox"), Some(format!("0 0 {width} {height}").as_str()));
        let paths = read(&text);
        assert!((paths[0].width - 2.0 * scale).abs() < 1e-3);
        assert!((report.pen_down_px - 2000.0).abs() < 1e-6);
        let area = paths[0].path.bounding_box();
        assert!((area.width() - 640.0 * scale).abs() < 0.01 && (area.height() - 360.0 * scale).abs() < 0.01);
        if size_px == SIZE_PX {
            let margins = [area.x0, area.y0, width - area.x1, height - area.y1];
            assert!(margins.iter().all(|margin| *margin > margin_mm - 0.01), "{margins:?}");
            assert!((area.x0 + area.x1 - width).abs() < 0.01 && (area.y0 + area.y1 - height).abs() < 0.01);
            // Planted: a margin of another size.
            let other = Sheet::paper(paper, margin_mm + 1.0, size_px).unwrap();
            assert!((other.units_per_px - sheet.units_per_px).abs() > 1e-3);
        }
    }
    let (text, _) = written(&frame, &settings(Sheet::pixels(SIZE_PX)));
    assert!(text.contains("width=\"640px\" height=\"360px\" viewBox=\"0 0 640 360\""));
    for (paper, margin_mm, cause) in [
        ("a11", 10.0, "--paper \"a11\""),
        ("0x20", 10.0, "--paper"),
        ("NaNx20", 10.0, "--paper"),
        ("20", 10.0, "--paper"),
        ("a4", 105.0, "--margin 105"),
        ("a4", -1.0, "--margin -1"),
        ("a4", f64::NAN, "--margin NaN"),
    ] {
        let error = Sheet::paper(paper, margin_mm, SIZE_PX).unwrap_err();
        assert!(error.starts_with(cause) && !error.contains('\n'), "{error}");
    }
}

#[test]
fn faint_ink_looks_on_white_as_it_does_in_pictures() {
    let mut line = polyline(&[Point::new(10.0, 10.0), Point::new(90.0, 10.0)], EdgeKind::Contour, false);
    let mut look = |ink: f32| {
        line.points.iter_mut().for_each(|point| point.ink = ink);
        let opacity = read(&written(&[line.clone()], &settings(Sheet::pixels(SIZE_PX))).0)[0].opacity;
        // Mixed as an SVG viewer does, and mixed in linear light.
        let dark = 15.0 / 255.0;
        let shown = 1.0 + (dark - 1.0) * opacity;
        let [linear] = [((dark + 0.055_f64) / 1.055).powf(2.4)];
        let drawn = 1.055 * (1.0 + (linear - 1.0) * f64::from(ink)).powf(1.0 / 2.4) - 0.055;
        (opacity, shown, drawn)
    };
    for ink in [0.15, 0.5, 0.9, 1.0] {
        let (_, shown, drawn) = look(ink);
        assert!((shown - drawn).abs() < 2e-3, "{ink}: {shown} {drawn}");
    }
    assert_eq!(look(1.0).0, 1.0);
    // Planted: the ink itself as opacity would be much darker.
    assert!(look(0.5).0 < 0.4);
}

#[test]
fn nothing_to_draw_is_a_file_without_paths() {
    let Some(mut world) = hill() else { return };
    let drawn = strokes_of(&mut world, "0,0,+500,0,80,20", |_| {});
    let (text, report) = written(&drawn.polylines, &settings(Sheet::pixels(SIZE_PX)));
    assert!(read(&text).is_empty() && report == DrawingReport::default());
    let document = Document::parse(&text).unwrap();
    let of = |name: &str| document.descendants().find(|node| node.has_tag_name(name)).and_then(|node| node.text());
    assert_eq!((of("title"), of("desc")), (Some("hills & <\"valleys\">?"), Some("one two")));
}

/// Tests that words are transparent text whose baseline begins, ends and turns where that of their letters does.
#[test]
fn words_lie_over_their_letters() {
    let text = |begin: [f64; 2], along: [f64; 2]| Text {
        words: "a & b".to_owned(),
        begin: Point::new(begin[0], begin[1]),
        along: kurbo::Vec2::new(along[0], along[1]),
        height: 7.0,
    };
    let settings = settings(Sheet { size: [100.0; 2], unit: Unit::Px, units_per_px: 1.0, origin: [0.0; 2] });
    let layer = |texts: Vec<Text>| Layer {
        kind: "mark",
        pen: None,
        id: "names".to_owned(),
        label: "Names".to_owned(),
        ink: None,
        strokes: Vec::new(),
        fills: Vec::new(),
        texts,
    };
    // The second reads upward; text without a length has none.
    let texts = vec![text([10.0, 20.0], [30.0, 0.0]), text([50.0, 60.0], [0.0, -40.0]), text([1.0, 1.0], [0.0, 0.0])];
    let file = written_layers(vec![layer(texts)], &settings);
    let document = Document::parse(&file).unwrap();
    let found: Vec<_> = document.descendants().filter(|node| node.has_tag_name("text")).collect();
    let of = |number: usize, name: &str| found[number].attribute(name).unwrap_or_default();
    assert_eq!((found.len(), found[0].text()), (2, Some("a & b")));
    assert_eq!([of(0, "x"), of(0, "y"), of(0, "textLength"), of(0, "transform")], ["10", "20", "30", ""]);
    assert_eq!([of(1, "textLength"), of(1, "transform")], ["40", "rotate(-90 50 60)"]);
    assert_eq!([of(0, "font-size"), of(0, "fill-opacity")], ["10", "0"]);
    // Twice as large and moved, as on paper; and the box around it.
    let placed = text([10.0, 20.0], [30.0, 0.0]).placed(Affine::translate((5.0, 0.0)) * Affine::scale(2.0));
    assert_eq!(placed, Text { height: 14.0, ..text([25.0, 40.0], [60.0, 0.0]) });
    assert_eq!(text([50.0, 60.0], [0.0, -40.0]).around(), kurbo::Rect::new(43.0, 20.0, 50.0, 60.0));
}

#[test]
fn what_is_no_number_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.svg");
    let stroke = Stroke { path: BezPath::from_svg("M1,2 L3,4").unwrap(), width: 1.0, opacity: 0.5, ink: None };
    let with = |stroke: Stroke| Layer {
        kind: "contour",
        pen: None,
        id: "contours".to_owned(),
        label: "Contours".to_owned(),
        ink: None,
        strokes: vec![stroke],
        fills: Vec::new(),
        texts: Vec::new(),
    };
    let settings = settings(Sheet { size: [1.0; 2], unit: Unit::Px, units_per_px: 1.0, origin: [0.0; 2] });
    let write = |stroke: Stroke, path: &Path| write_svg(path, &drawing(vec![with(stroke)], &settings), None);
    let mut nowhere = stroke.clone();
    nowhere.path.line_to((f64::NAN, 0.0));
    for bad in
        [nowhere, Stroke { width: f64::INFINITY, ..stroke.clone() }, Stroke { opacity: f64::NAN, ..stroke.clone() }]
    {
        let error = write(bad, &path).unwrap_err().to_string();
        assert!(error.contains("a.svg") && error.contains("not finite"), "{error}");
    }
    let error = write(stroke.clone(), Path::new("no-such-folder/a.svg")).unwrap_err().to_string();
    assert!(error.contains("no-such-folder/a.svg"), "{error}");
    assert_eq!(folder.path().read_dir().unwrap().count(), 0);
    write(stroke, &path).unwrap();
}
