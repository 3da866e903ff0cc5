//! `hachure render -o out.svg`, as scripts use it.

use std::fs;

use roxmltree::Document;

use crate::{Place, full};

fn paths(text: &str) -> usize {
    let document = Document::parse(text).unwrap();
    document.descendants().filter(|node| node.has_tag_name("path")).count()
}

#[test]
fn strokes_are_written_as_paths() {
    let place = Place::with_built_in_land();
    let view = ["--size", "320x180", "--style", "strokes", "--camera", "0,-9600,3200,4,-9,42"];
    let render = |arguments: &[&'static str]| [&["render"][..], arguments, &view].concat();
    let report = place.json(&render(&["-o", "a.svg", "--json"]));
    let text = fs::read_to_string(place.path("a.svg")).unwrap();
    let svg = &report["svg"];
    let count = paths(&text);
    assert!(count > 20);
    assert_eq!(svg["strokes"], count);
    assert_eq!(report["mm_per_px"], serde_json::Value::Null);
    let number = |key: &str| svg[key].as_f64().unwrap();
    assert_eq!(number("contours") + number("borders") + number("creases"), count as f64);
    assert!(number("pen_up_px") < number("pen_up_unordered_px") && number("pen_down_px") > 500.0, "{svg}");
    let document = Document::parse(&text).unwrap();
    let content = |name: &str| document.descendants().find(|node| node.has_tag_name(name)).unwrap().text().unwrap();
    assert_eq!(content("title"), "hachure: strokes");
    assert!(
        content("desc").contains("style strokes") && content("desc").contains("within 0.25 px"),
        "{}",
        content("desc")
    );

    // A larger tolerance gives fewer curves. The line on the terminal has the same numbers.
    let said = place.text(&render(&["-o", "b.svg", "--tolerance-px", "3", "--paper", "a5", "--margin", "5"]));
    assert!(said.starts_with(&format!("{count} strokes (")) && said.lines().count() == 1, "{said}");
    assert!(said.contains(" mm, pen up ") && said.contains(" mm before ordering)"), "{said}");
    let coarse = fs::read_to_string(place.path("b.svg")).unwrap();
    assert_eq!(paths(&coarse), count);
    assert!(coarse.matches('C').count() < text.matches('C').count());
    assert!(coarse.contains("width=\"210mm\" height=\"148mm\" viewBox=\"0 0 210 148\""));

    // A PNG has no such numbers, and a view of the sky has no paths.
    assert_eq!(place.json(&render(&["-o", "a.png", "--json"]))["svg"], serde_json::Value::Null);
    let sky = place.text(&[
        "render",
        "-o",
        "sky.svg",
        "--style",
        "strokes",
        "--size",
        "64x36",
        "--camera",
        "0,0,+9000,0,80,20",
    ]);
    assert!(sky.starts_with("0 strokes"), "{sky}");
    assert_eq!(paths(&fs::read_to_string(place.path("sky.svg")).unwrap()), 0);
}

/// Returns the names of layers, and the widths, opacities and colours of the paths in each.
fn layers(text: &str) -> Vec<(String, Vec<[Option<String>; 3]>)> {
    let document = Document::parse(text).unwrap();
    let groups = document.descendants().filter(|node| node.has_tag_name("g"));
    let of_paths = |group: roxmltree::Node<'_, '_>| {
        let paths = group.children().filter(|node| node.has_tag_name("path"));
        paths
            .map(|path| {
                ["stroke-width", "stroke-opacity", "stroke"].map(|name| path.attribute(name).map(str::to_owned))
            })
            .collect()
    };
    groups.map(|group| (group.attribute("id").unwrap().to_owned(), of_paths(group))).collect()
}

#[test]
fn marks_are_written_as_paths() {
    let place = Place::with_built_in_land();
    let view = ["--size", "240x135", "--camera", "0,-9600,3200,4,-9,42"];
    let render = |arguments: &[&'static str]| [&["render"][..], arguments, &view].concat();
    let output = place.hachure(&render(&["-o", "a.svg", "--style", "crosshatch"]));
    let [said, warned] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    assert!(said.contains(" marks)") && !said.contains("pens"), "{said}");
    assert!(warned.contains(".svg: leaves out stroke textures"), "{warned}");
    let drawn = layers(&fs::read_to_string(place.path("a.svg")).unwrap());
    let names: Vec<&str> = drawn.iter().map(|(name, _)| name.as_str()).collect();
    assert!(names.starts_with(&["sky", "marks-1", "marks-2"]) && names.contains(&"contours"), "{names:?}");
    assert!(drawn.iter().all(|(_, paths)| !paths.is_empty()));

    // With --pens, each layer has one width, and no ink is faint.
    let report = place.json(&render(&["-o", "b.svg", "--style", "hachures", "--pens", "2", "--json"]));
    assert_eq!(report["svg"]["pens"].as_array().unwrap().len(), 2);
    assert!(report["svg"]["marks"].as_u64().unwrap() > 100, "{report}");
    for (name, paths) in layers(&fs::read_to_string(place.path("b.svg")).unwrap()) {
        assert!(
            ["hachures", "contours", "borders"].iter().any(|kind| name.starts_with(&format!("{kind}-pen-"))),
            "{name}"
        );
        assert!(paths.windows(2).all(|pair| pair[0] == pair[1]) && paths[0][1..] == [None, None], "{name}");
    }
    // --like draws the same again from the description in the file, as in `tests/imprint.rs`.
    if !full() {
        return;
    }
    place.text(&["render", "--like", "b.svg", "-o", "c.svg"]);
    let paths = |name: &str| layers(&fs::read_to_string(place.path(name)).unwrap());
    assert_eq!(paths("b.svg"), paths("c.svg"));
    // Planted error: another style.
    assert_ne!(paths("a.svg"), paths("c.svg"));
}

#[test]
fn frames_of_a_path_are_files() {
    let place = Place::with_built_in_land();
    place.file("path.csv", "t,x,y,z,yaw,pitch,fov\n0,0,-9600,3200,4,-9,42\n1,0,-9000,3200,4,-9,42\n");
    let arguments = ["render", "-o", "new/%02d.svg", "--style", "strokes", "--size", "160x90", "--path", "path.csv"];
    let printed = place.text(&[&arguments[..], &["--fps", "2"]].concat());
    let texts = ["00", "01", "02"].map(|name| fs::read_to_string(place.path(&format!("new/{name}.svg"))).unwrap());
    assert_eq!(fs::read_dir(place.path("new")).unwrap().count(), 3);
    assert!(texts[0] != texts[1] && texts[1] != texts[2]);
    let all: usize = texts.iter().map(|text| paths(text)).sum();
    assert!(printed.starts_with(&format!("{all} strokes")), "{printed}");
}

#[test]
fn wrong_options_are_one_line() {
    let place = Place::with_built_in_land();
    let strokes = ["render", "-o", "out.svg", "--style", "strokes"];
    for (more, name, cause) in [
        (&["--tolerance-px", "0"][..], "--tolerance-px \"0\"", "between"),
        (&["--tolerance-px", "NaN"], "--tolerance-px \"NaN\"", "between"),
        (&["--tolerance-px", "-1"], "--tolerance-px \"-1\"", "between"),
        (&["--paper", "b9"], "--paper", "WIDTHxHEIGHT"),
        (&["--paper", "a4", "--margin", "200"], "--margin 200", "297x210 mm"),
        (&["--margin", "5"], "--margin 5", "--paper"),
        (&["--pens", "4"], "--pens \"4\"", "from 1 to 3"),
        (&["--pens", "1", "--eyes", "anaglyph"], "--pens", "glasses"),
        (&["--aov", "depth"], "--aov", "out.svg"),
    ] {
        let line = place.misuse(&[&strokes[..], more].concat());
        assert!(line.contains(name) && line.contains(cause), "{more:?}: {line}");
    }
    for (size, cause) in [("60000x60000", "60000x60000 is too large"), ("8000x8000", "33554432 pixels")] {
        let line = place.error(&[&strokes[..], &["--size", size]].concat());
        assert!(line.contains("out.svg") && line.contains(cause), "{size}: {line}");
    }
    for (arguments, name, cause) in [
        (&["-o", "out.svg", "--style", "lsa"][..], "out.svg", "the style lsa has none"),
        (&["-o", "out/%d.svg", "--style", "plain", "--path", "p.csv"], "out/%d.svg", "the style plain has none"),
        (&["-o", "out.png", "--margin", "4"], "--margin", "only to an .svg"),
        (&["-o", "out.png", "--pens", "1"], "--pens", "only to an .svg, .pdf or .geojson"),
        (&["-o", "out.png", "--tolerance-px", "1"], "--tolerance-px", "only to an .svg, .pdf or .geojson"),
    ] {
        let line = place.misuse(&[&["render"][..], arguments].concat());
        assert!(line.contains(name) && line.contains(cause), "{arguments:?}: {line}");
    }
    let line = place.error(&["render", "-o", "nowhere/out.svg", "--style", "strokes"]);
    assert!(line.contains("out.svg") && line.contains("no folder"), "{line}");
    assert!(place.names().is_empty(), "{:?}", place.names());
}
