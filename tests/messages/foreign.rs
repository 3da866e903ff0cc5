//! Tests arguments, file names and file contents that are long or contain control characters of a terminal.

use crate::Place;
use crate::toml::{STYLE, WORLD};

#[test]
fn foreign_texts_are_cut_and_escaped() {
    let place = Place::new();
    let red = "red\u{1b}[31m\n.tif";
    place.file(red, "junk");
    let escaped = "red\\u{1b}[31m\\n.tif";
    for arguments in
        [&["info", red][..], &["render", red, "-o", "o.png"], &["bake", red, "-o", "o.tif"], &["render", "-o", red]]
    {
        let status = if arguments[1] == "-o" { 2 } else { 1 };
        place.refused(arguments, status, &[escaped]);
    }
    // An existing file, in what is printed and in warnings.
    place.file("red\u{1b}[31m.r16", [1; 128]);
    let output = place.hachure(&["info", "red\u{1b}[31m.r16"]);
    let printed = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
    assert!(output.status.success() && printed.contains("WARN"), "{printed}");
    assert!(!printed.contains('\u{1b}') && printed.contains("red\\u{1b}[31m.r16: a raw heightmap"), "{printed}");

    let long = "x".repeat(5000);
    for (arguments, status) in [
        (&["render", "-o", "o.png", "--size", &long][..], 2),
        (&["render", "-o", "o.png", "--style", &long], 2),
        (&["render", "-o", "o.png", "--camera", &long], 2),
        (&["render", "-o", "o.exr", "--aov", &long], 2),
        (&["render", "-o", &long], 2),
        (&["render", "-o", "o.png", &format!("--{long}")], 2),
        (&["styles", &long], 2),
        (&["render", &long, "-o", "o.png"], 1),
        (&["info", &long], 1),
    ] {
        place.refused_within(arguments, status, &["x…x"], 260);
    }
    // The end of a long name is kept, because it distinguishes files.
    let deep = format!("{}ridge.tif", "deep/".repeat(60));
    place.refused(&["info", &deep], 1, &["deep/ridge.tif: cannot be opened"]);

    for text in [
        format!("[world]\n\"{long}\" = 3\n"),
        format!("[world]\ndem = \"\\u001b{long}\"\n"),
        format!("{WORLD}[sun]\nazimuth_deg = \"\\u001b{long}\"\n"),
        format!("{STYLE}[paper]\ncolor = \"\\u001b{long}\"\n"),
        format!("{STYLE}[strokes]\nwidth_px = 1\ntexture = \"\\u001b{long}\"\n"),
        format!("{STYLE}[[hatching.layers]]\nmarks = \"\\u001b{long}\"\n"),
    ] {
        place.file("f.toml", &text);
        place.refused_within(&["info", "f.toml"], 1, &["…"], 260);
    }
    place.file("f.toml", format!("{WORLD}[camera]\nstart = \"\\u001b{long}\"\n"));
    place.refused_within(&["info", "f.toml"], 1, &["f.toml:", "but this has 1"], 260);
}
