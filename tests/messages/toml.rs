//! Tests scenes, styles, recipes and sidecar files with mistakes.

use crate::Place;

pub(crate) const WORLD: &str = "[world]\nprocedural = { seed = 1 }\n";
pub(crate) const STYLE: &str = "name = \"x\"\ndescription = \"y\"\n[tone]\nkind = \"plain\"\n";

#[test]
fn toml_has_places_and_near_names() {
    let place = Place::new();
    place.file("hut.obj", "v 0 0 0\nv 1 0 0\n# far\nv 0 1 0\nf 1 2 9\n");
    place.file("mine.toml", "description = \"\"\nkind = \"dash\"\nlenght_px = 3\n");
    place.file("stack.toml", "description = \"\"\nkind = \"stack\"\nimages = [\"light.png\"]\n");
    place.file("tool.toml", "description = \"\"\n\n[tile]\nalong_px = 1.5\n");
    for (text, words) in [
        (
            format!("vertical_exageration = 2\n{WORLD}"),
            "f.toml:1:1: unknown key \"vertical_exageration\"; did you mean \"vertical_exaggeration\"?",
        ),
        (
            WORLD.replace("procedural", "proceduarl"),
            "f.toml:2:1: unknown key \"world.proceduarl\"; did you mean \"procedural\"?",
        ),
        (WORLD.replace("1", "-1"), "f.toml:2:23: world.procedural.seed must be a whole number"),
        (
            format!("{WORLD}[sun]\nazimuth_deg = \"north\"\n"),
            "f.toml:4:15: sun.azimuth_deg must be a number, but \"north\" is text",
        ),
        (format!("{WORLD}[sun]\nelevation_deg = 99\n"), "f.toml:4:17: sun.elevation_deg: it must be between"),
        ("\n[world]\ndem = \"\"\n".to_owned(), "f.toml:3:7: world: dem is empty"),
        ("\n[world]\n".to_owned(), "f.toml:2:1: world: it needs dem"),
        ("[world]\ndem = 3\n".to_owned(), "f.toml:2:7: world.dem: it must be a file name or a list of file names"),
        (
            format!("{WORLD}[[meshes]]\nfile = \"hut.obj\"\nat = [1, 2]\n"),
            "f.toml:5:6: meshes.at must be a list of 3, but it has 2",
        ),
        (
            format!("{WORLD}[[meshes]]\nfile = \"hut.obj\"\nat = [1, 2, \"+0\"]\n"),
            "f.toml: cannot read the mesh hut.obj: line 5: the face uses vertex 9, but there are 3",
        ),
        (format!("{WORLD}[sun\n"), "f.toml:3:5: unclosed table"),
        (format!("{WORLD}[camera]\nstart = \"tour\n"), ": the text is not closed with a quotation mark on its line"),
        (format!("{WORLD}[camera]\nstart = 'tour\n"), ": the text is not closed with a quotation mark on its line"),
        (
            "[world]\ndem = \"a\\u001b[31m.tif\"\n[[meshes]]\nfile = \"b.obj\"\nat = [1, 2, 3]\n".to_owned(),
            "f.toml: a\\u{1b}[31m.tif, b.obj do not exist",
        ),
        (
            format!("{STYLE}[strokes]\nwidth_px = \"thin\"\n"),
            "f.toml:6:12: strokes.width_px must be a number, but \"thin\" is text",
        ),
        (
            format!("{STYLE}[strokes]\nwidth = 3\n"),
            "f.toml:6:1: unknown key \"strokes.width\"; did you mean \"width_px\"?",
        ),
        (
            format!("{STYLE}[strokes]\nquality = 3\n"),
            "f.toml:6:1: unknown key \"strokes.quality\"; hachure styles show NAME --all lists the keys of a style",
        ),
        (format!("{STYLE}[strokes]\nwidth_px = 99\n"), "f.toml:6:12: strokes.width_px is 99, not between 0.5 and 64"),
        (
            format!("{STYLE}[paper]\ncolor = \"white\"\n"),
            "f.toml:6:9: paper.color: \"white\" is not a colour of the form",
        ),
        (STYLE.replace("plain", "toone"), "f.toml:4:8: tone.kind cannot be \"toone\""),
        (
            STYLE.replace("plain", "toon") + "steps = \"many\"\ndarkest = 0\n",
            "f.toml:5:9: tone.steps must be a whole number",
        ),
        // A number with 300 digits is cut.
        (
            STYLE.replace("plain", "toon") + "steps = 1e300\ndarkest = 0\n",
            "tone must be a whole number, 0 or more, but 1000",
        ),
        (
            format!("{STYLE}[[hatching.layers]]\nmarks = \"line\"\n[[hatching.layers]]\nmarks = \"line\"\nfrom = 2\n"),
            "f.toml:9:8: hatching.layers.from is 2",
        ),
        (
            format!("{STYLE}[[hatching.layers]]\nmarks = \"lien\"\n"),
            "f.toml:6:9: hatching.layers.marks: lien: no such marks; did you mean \"line\"?",
        ),
        (
            format!("{STYLE}[[hatching.layers]]\nmarks = \"mine.toml\"\n"),
            "f.toml:6:9: mine.toml:3:1: unknown key \"lenght_px\"; did you mean \"length_px\"?",
        ),
        (
            format!("{STYLE}[strokes]\nwidth_px = 3\ntexture = \"tool.toml\"\n"),
            "f.toml:7:11: tool.toml:4:12: tile.along_px must be a whole number",
        ),
        (
            format!("{STYLE}[strokes]\nwidth_px = 3\ntexture = \"crayon\"\n"),
            "f.toml:7:11: strokes.texture: crayon: no such stroke texture; available: pen, brush, pencil, charcoal, dry-ink",
        ),
        (
            format!("{STYLE}[strokes]\nwidth_px = 3\ntexture = \"none.toml\"\n"),
            "f.toml:7:11: none.toml: cannot read the stroke texture: ",
        ),
        // The second layer in the text is the first one of the style, which sorts its layers.
        (
            format!(
                "{STYLE}[[hatching.layers]]\nmarks = \"line\"\nfrom = 0.5\n[[hatching.layers]]\nmarks = \"stack.toml\"\n"
            ),
            "f.toml:9:9: light.png: cannot read the picture: ",
        ),
    ] {
        place.file("f.toml", &text);
        place.refused(&["info", "f.toml"], 1, &[words]);
    }
    // Sidecar files.
    place.file("h.r16", [0; 32]);
    for (text, words) in [
        ("spacing = 3\n", "h.r16.toml:1:1: unknown key \"spacing\"; did you mean \"spacing_m\"?"),
        ("width = 4\nheight = \"x\"\n", "h.r16.toml:2:10: height must be a whole number"),
        ("endian = \"middle\"\n", "h.r16.toml:1:10: endian cannot be \"middle\"; available: little, big"),
    ] {
        place.file("h.r16.toml", text);
        place.refused(&["info", "h.r16"], 1, &[words]);
    }
}
