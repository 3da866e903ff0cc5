//! `hachure styles show NAME --all`: every parameter with its value, unit, range, default and help.

use serde_json::Value;

use crate::Place;

fn row<'a>(rows: &'a Value, key: &str) -> &'a Value {
    let rows = rows["parameters"].as_array().unwrap();
    rows.iter().find(|row| row["key"] == key).unwrap_or_else(|| panic!("no row {key}"))
}

#[test]
fn every_parameter_is_shown_with_its_value() {
    let place = Place::empty();
    let text = place.text(&["styles", "show", "strokes", "--all"]);
    let line = |begins: &str| {
        let lines = text.lines().filter(|line| line.starts_with(begins));
        let found: Vec<&str> = lines.collect();
        assert_eq!(found.len(), 1, "{begins}: {text}");
        found[0].split_whitespace().collect::<Vec<_>>().join(" ")
    };
    assert_eq!(line("* width_px"), "* width_px 2.6 px 0.5 to 64 required Width of a stroke.");
    assert!(line("* fade_s").starts_with("* fade_s 0.8 s 0 to 60 0.8 Time over"));
    assert!(line("  wobble_px").starts_with("wobble_px 0.0 px 0 to 16 0.0 How far"));
    assert!(line("  suggestive_px").starts_with("suggestive_px – px 1 to 256 – Draws suggestive"));
    assert!(line("  detector").starts_with("detector – lsa, sobel, roystan, curvature required Method that detects"));
    assert!(line("layer hatching, not in this style").ends_with("as hatching marks."));
    assert!(line("layer strokes:").ends_with("along contours."));
    assert!(line("[paper]").starts_with("[paper]: The paper on which the picture is drawn."));
    // Columns are aligned.
    let at = |begins: &str, word: &str| {
        let line = text.lines().find(|line| line.starts_with(begins)).unwrap();
        line[..line.find(word).unwrap()].chars().count()
    };
    assert_eq!(at("* width_px", "2.6"), at("  wobble_px", "0.0"));
    assert_eq!(at("* width_px", "Width of"), at("  crease_deg", "Edges"));
    assert!(text.lines().all(|line| line.trim_end() == line));

    // The JSON has the same content; exactly the keys of the preset are marked as set.
    let rows = place.json(&["styles", "show", "strokes", "--all", "--json"]);
    let width = row(&rows, "strokes.width_px");
    assert_eq!((&width["value"], &width["is_set"], &width["is_required"]), (&2.6.into(), &true.into(), &true.into()));
    assert_eq!((&width["unit"], &width["least"], &width["most"]), (&"px".into(), &0.5.into(), &64.0.into()));
    assert_eq!((&width["default"], &width["kind"]), (&Value::Null, &"number".into()));
    let wobble = row(&rows, "strokes.wobble_px");
    assert_eq!((&wobble["value"], &wobble["is_set"], &wobble["default"]), (&0.0.into(), &false.into(), &0.0.into()));
    assert_eq!(row(&rows, "lines.detector")["choices"][1], "sobel");
    assert_eq!(row(&rows, "lines.detector")["value"], Value::Null);
    let preset: toml::Table = place.text(&["styles", "show", "strokes"]).parse().unwrap();
    for row in rows["parameters"].as_array().unwrap() {
        let key = row["key"].as_str().unwrap();
        let (section, name) = key.rsplit_once('.').unwrap_or(("", key));
        let layers = preset["layers"].as_array().unwrap().iter().filter_map(toml::Value::as_table);
        let mut layers = layers.filter(|layer| layer["kind"].as_str() == Some(section));
        let table = match section {
            // A layer has a row of its own.
            "" => Some(&preset).filter(|preset| preset.contains_key(key)).or_else(|| {
                let mut layers = preset["layers"].as_array().unwrap().iter().filter_map(toml::Value::as_table);
                layers.rfind(|layer| layer["kind"].as_str() == Some(key))
            }),
            _ => layers.next().or_else(|| preset.get(section).and_then(|it| it.as_table())),
        };
        let is_there = table.is_some_and(|table| table.contains_key(name) || table.get("kind") == Some(&key.into()));
        assert_eq!(row["is_set"], is_there, "{key}");
    }
}

#[test]
fn a_file_is_shown_as_it_is_read() {
    let place = Place::empty();
    // The layers of a style are sorted, and the marks of keys that are set move with them.
    let own = "name = \"own\"\ndescription = \"\"\npaper = { grain = 0.5 }\n[tone]\nkind = \"plain\"\n\
               [[hatching.layers]]\nmarks = \"line\"\nfrom = 0.5\nsize = 2\n[[hatching.layers]]\nmarks = \"dash\"\n";
    place.file("own.toml", own);
    let rows = place.json(&["styles", "show", "own.toml", "--all", "--json"]);
    for (key, value, is_set) in [
        ("hatching.sets[0].marks", Value::from("dash"), true),
        ("hatching.sets[0].size", 1.0.into(), false),
        ("hatching.sets[0].from", 0.0.into(), false),
        ("hatching.sets[1].size", 2.0.into(), true),
        ("hatching.sets[1].from", 0.5.into(), true),
        ("paper.grain", 0.5.into(), true),
        ("paper.color", "#ffffff".into(), false),
        ("tone.steps", Value::Null, false),
    ] {
        let row = row(&rows, key);
        assert_eq!((&row["value"], &row["is_set"]), (&value, &is_set.into()), "{key}");
    }
    let text = place.text(&["styles", "show", "own.toml", "--all"]);
    assert!(text.contains("\nlayer hatching, sets[1]: ") && text.contains("\n[paper]: "), "{text}");
    place.file("bad.toml", &own.replace("dash", "dish"));
    let error = place.error(&["styles", "show", "bad.toml", "--all"]);
    assert!(
        error.starts_with("bad.toml:11:9: hatching.layers.marks: dish: no such marks; did you mean \"dash\"?"),
        "{error}"
    );
    assert!(place.misuse(&["styles", "show", "oil", "--all"]).contains("no such style"));
}

#[test]
fn a_file_with_sections_is_shown_and_written_as_layers() {
    let place = Place::empty();
    let old =
        "name = \"own\"\ndescription = \"\"\n# a nib\n[strokes]\nwidth_px = 2.5 # thin\n[tone]\nkind = \"plain\"\n";
    place.file("own.toml", old);
    let shown = place.text(&["styles", "show", "own.toml"]);
    assert_eq!(shown, place.text(&["styles", "migrate", "own.toml"]));
    assert!(shown.contains("# a nib\n[[layers]]\nkind = \"strokes\"\nwidth_px = 2.5 # thin\n"), "{shown}");
    assert_eq!(std::fs::read_to_string(place.path("own.toml")).unwrap(), old, "the file itself must not change");
    place.text(&["styles", "migrate", "own.toml", "-o", "new.toml"]);
    assert_eq!(std::fs::read_to_string(place.path("new.toml")).unwrap().trim_end(), shown.trim_end());
    assert!(place.text(&["styles", "check", "new.toml"]).contains("valid"));
    // A file that exists is not overwritten, not even by itself.
    for taken in ["new.toml", "own.toml"] {
        let error = place.error(&["styles", "migrate", "own.toml", "-o", taken]);
        assert!(error.starts_with(&format!("{taken}: the file exists")), "{error}");
    }
    assert_eq!(std::fs::read_to_string(place.path("own.toml")).unwrap(), old);
    // A text that is not a style is not migrated.
    place.file("bad.toml", "name = 3\n[strokes]\n");
    assert!(place.error(&["styles", "migrate", "bad.toml"]).starts_with("bad.toml:1:8: name must be text"));
}
