//! `src/frame_passes.md` says what the code does: passes and their order, pictures, buffers, formats, conditions.
//!
//! The list is held against the shaders as they are composed, the constants of the formats, and the text of `frame.rs`,
//! `frame/passes.rs` and `frame/targets.rs`. Planted errors show that each column is looked at.

use std::collections::{BTreeMap, BTreeSet};

use hachure::frame::Requirements;
use hachure::gpu::shader::{SHADERS, compose};
use hachure::style::Detector;
use hachure::style::hatching::Scale;
use hachure::{composite, lines, surface, tiles, tones};
use naga::{AddressSpace, ImageClass, StorageAccess, TypeInner};

const LIST: &str = include_str!("../src/frame_passes.md");
const FRAME: &str = include_str!("../src/frame.rs");
const PASSES: &str = include_str!("../src/frame/passes.rs");
const TARGETS: &str = include_str!("../src/frame/targets.rs");
const TERRAIN: &str = include_str!("../src/surface/terrain.rs");
const MESHES: &str = include_str!("../src/surface/meshes.rs");
const ID_IMAGE: &str = include_str!("../src/lines/strokes/id_image.rs");
const BALANCE: &str = include_str!("../src/tones/balance.rs");
const STROKE: &str = include_str!("../src/lines/strokes/stroke.rs");

/// The conditions of `Passes::adapt`, in words.
const CONDITIONS: &[(&str, &str)] = &[
    ("requirements.meshes", "the scene has meshes"),
    ("requirements.motion", "motion is wanted"),
    ("detector == Some(Detector::Lsa)", "lines by LSA"),
    ("detector == Some(Detector::Sobel)", "lines by Sobel"),
    ("detector == Some(Detector::Roystan)", "lines by Roystan"),
    ("detector.is_some()", "lines"),
    ("requirements.antialias", "lines are anti-aliased"),
    ("requirements.seen", "shadows or occlusion"),
    ("requirements.watercolor", "watercolour"),
    ("requirements.hatching.is_some()", "hatching"),
    ("hatching == Some(Scale::Blend)", "hatching that blends"),
    ("hatching == Some(Scale::Add)", "hatching that adds"),
    ("requirements.balance_px > 0", "hatching is balanced"),
    ("requirements.toon", "the tone is toon"),
    ("!requirements.toon", "the tone is not toon"),
];

/// Stands where a picture has its format.
const BUFFER: &str = "buffer";

/// One row, of the list or of the code. Pictures stand with their formats.
#[derive(Clone, Debug, Default, PartialEq)]
struct Row {
    pass: String,
    pictures: BTreeMap<String, String>,
    buffers: BTreeSet<String>,
    writes: BTreeMap<String, String>,
    exists: String,
}

/// The value of a constant that `targets.rs` names.
fn format(constant: &str) -> String {
    let format = match constant {
        "DEPTH_FORMAT" => surface::terrain::DEPTH_FORMAT,
        "ID_FORMAT" => surface::terrain::ID_FORMAT,
        "POSITION_FORMAT" => surface::resolve::POSITION_FORMAT,
        "NORMAL_FORMAT" => surface::resolve::NORMAL_FORMAT,
        "MOTION_FORMAT" => surface::motion::MOTION_FORMAT,
        "ERRORS_FORMAT" => lines::detector::ERRORS_FORMAT,
        "INK_FORMAT" => lines::strokes::stroke::INK_FORMAT,
        "LINE_FORMAT" => lines::threshold::LINE_FORMAT,
        "FORM_FORMAT" => surface::form::FORM_FORMAT,
        "COVER_FORMAT" => tones::balance::COVER_FORMAT,
        "SUMS_FORMAT" => tones::balance::SUMS_FORMAT,
        "MARKS_FORMAT" => tones::balance::MARKS_FORMAT,
        "TONE_FORMAT" => tones::TONE_FORMAT,
        "PICTURE_FORMAT" => composite::PICTURE_FORMAT,
        _ => panic!("targets.rs has a picture of {constant}, which this test does not know"),
    };
    format!("{format:?}")
}

/// The pictures by the names of their fields, with their formats.
fn target_formats() -> BTreeMap<String, String> {
    let made = [
        ("heights", tiles::atlas::HEIGHTS_FORMAT),
        ("seen_tiles", tiles::horizon_maps::HORIZON_MAP_FORMAT),
        ("ramp", tones::TONE_FORMAT),
        ("brush_tile", lines::strokes::texture::TILE_FORMAT),
    ];
    let mut formats: BTreeMap<String, String> =
        made.into_iter().map(|(name, format)| (name.to_owned(), format!("{format:?}"))).collect();
    for line in TARGETS.lines().chain(ID_IMAGE.lines()).chain(STROKE.lines()).chain(BALANCE.lines()) {
        let Some((field, made)) = line.trim().split_once(": ") else { continue };
        let is_made = ["Target::storage(", "Target::attachment(", "storage("].iter().any(|how| made.contains(how));
        let constant =
            made.split(|c: char| !(c.is_ascii_uppercase() || c == '_')).find(|word| word.ends_with("_FORMAT"));
        if let (true, Some(constant)) = (is_made, constant) {
            formats.insert(field.to_owned(), format(constant));
        }
    }
    formats
}

/// The text between `begin` and the next line that is `end`.
fn body<'a>(text: &'a str, begin: &str, end: &str) -> &'a str {
    let start = text.find(begin).unwrap_or_else(|| panic!("{begin} is gone"));
    let text = &text[start..];
    &text[..text.find(end).unwrap_or_else(|| panic!("{begin} has no end"))]
}

/// The words that follow `prefix` in `text`, each once, in the order of their first mention.
fn mentions(text: &str, prefix: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    for (at, _) in text.match_indices(prefix) {
        let before = text[..at].chars().next_back().unwrap_or(' ');
        let word: String =
            text[at + prefix.len()..].chars().take_while(|c| c.is_ascii_lowercase() || *c == '_').collect();
        if !before.is_alphanumeric() && before != '_' && !words.contains(&word) {
            words.push(word);
        }
    }
    words
}

/// The passes in drawing order: the fields of `Passes` that `Frame::render` mentions, by itself or through a method.
fn drawing_order() -> Vec<String> {
    let render = body(FRAME, "pub fn render(", "\n    }\n");
    let mut order: Vec<String> = Vec::new();
    for name in mentions(render, "passes.") {
        let method = format!("pub fn {name}(");
        let inner =
            if PASSES.contains(&method) { mentions(body(PASSES, &method, "\n    }\n"), "self.") } else { vec![name] };
        for name in inner {
            if !order.contains(&name) {
                order.push(name);
            }
        }
    }
    order
}

/// The condition under which each pass exists, in words.
fn conditions() -> BTreeMap<String, String> {
    let adapt = body(PASSES, "pub fn adapt(", "\n    }\n");
    adapt
        .split("keep(&mut self.")
        .skip(1)
        .map(|kept| {
            let mut arguments = kept.splitn(3, ", ");
            let (field, code) = (arguments.next().unwrap_or_default(), arguments.next().unwrap_or_default());
            let words = CONDITIONS.iter().find(|(known, _)| *known == code);
            (field.to_owned(), words.unwrap_or_else(|| panic!("no words for the condition {code}")).1.to_owned())
        })
        .collect()
}

/// What the shader of a pass reads and writes.
fn row_of_shader(shader: &str, exists: &str, formats: &BTreeMap<String, String>) -> Row {
    let module = compose(shader).unwrap_or_else(|error| panic!("{error}"));
    let mut row = Row { pass: shader.to_owned(), exists: exists.to_owned(), ..Row::default() };
    for (_, variable) in module.global_variables.iter().filter(|(_, variable)| variable.binding.is_some()) {
        let name = variable.name.as_deref().unwrap_or_default();
        let name = name.split("X_naga_oil_mod_").next().unwrap_or(name).to_owned();
        let known = || formats.get(&name).unwrap_or_else(|| panic!("{shader} reads {name}, no target")).clone();
        match (&module.types[variable.ty].inner, variable.space) {
            (TypeInner::Image { class: ImageClass::Storage { format, access }, .. }, _) => {
                assert_eq!(*access, StorageAccess::STORE, "{shader}: {name}");
                row.writes.insert(name, format!("{format:?}"));
            }
            // It holds nothing.
            (TypeInner::Sampler { .. }, _) => {}
            (TypeInner::Image { .. }, _) => {
                row.pictures.insert(name.clone(), known());
            }
            (_, AddressSpace::Storage { access }) if access.contains(StorageAccess::STORE) => {
                row.writes.insert(name, BUFFER.to_owned());
            }
            (_, AddressSpace::Uniform | AddressSpace::Storage { .. }) => {
                row.buffers.insert(name);
            }
            other => panic!("{shader}: {name} is {other:?}, which the list has no column for"),
        }
    }
    row
}

/// The list as the code has it.
fn code() -> Vec<Row> {
    let formats = target_formats();
    let conditions = conditions();
    drawing_order()
        .into_iter()
        // They have a table of their own.
        .filter(|name| name != "strokes")
        .map(|name| {
            let ending = format!("/{name}");
            let shader = SHADERS.iter().map(|(shader, _)| *shader).find(|shader| shader.ends_with(&ending));
            let shader = shader.unwrap_or_else(|| panic!("the pass {name} has no shader of its name"));
            let exists = conditions.get(&name).map_or("always", String::as_str);
            let mut row = row_of_shader(shader, exists, &formats);
            let rasterised = [("surface/terrain", TERRAIN), ("surface/meshes", MESHES)];
            for (_, text) in rasterised.into_iter().filter(|(name, _)| *name == shader) {
                // It writes its attachments.
                for target in mentions(text, "&inputs.").into_iter().filter(|name| formats.contains_key(name)) {
                    row.writes.insert(target.clone(), formats[&target].clone());
                }
            }
            for (picture, format) in row.writes.iter().filter(|(_, format)| *format != BUFFER) {
                assert_eq!(formats.get(picture), Some(format), "{shader} writes {picture}");
            }
            row
        })
        .collect()
}

/// The cells of the table whose header has `columns` cells.
fn table(text: &str, columns: usize, first: &str) -> Vec<Vec<String>> {
    let rows = text.lines().filter(|line| line.starts_with('|')).map(|line| {
        let cells = line.trim_matches('|').split('|').map(|cell| cell.trim().to_owned());
        cells.collect::<Vec<_>>()
    });
    rows.filter(|cells| cells.len() == columns)
        .skip_while(|cells| cells[0] != first)
        .skip(1)
        .filter(|cells| !cells[0].starts_with("---"))
        .collect()
}

/// `` `name` Format, … ``
fn pictures(cell: &str) -> BTreeMap<String, String> {
    let parts = cell.split(", ").filter(|part| !part.is_empty());
    parts
        .map(|part| {
            let (name, format) = part.split_once(' ').unwrap_or((part, ""));
            (name.trim_matches('`').to_owned(), format.to_owned())
        })
        .collect()
}

/// As [`pictures`]; what has no format is a buffer.
fn written(cell: &str) -> BTreeMap<String, String> {
    let known = |format: String| if format.is_empty() { BUFFER.to_owned() } else { format };
    pictures(cell).into_iter().map(|(name, format)| (name, known(format))).collect()
}

fn buffers(cell: &str) -> BTreeSet<String> {
    cell.split(", ").map(|name| name.trim_matches('`').to_owned()).filter(|name| !name.is_empty()).collect()
}

/// How the list differs from the code; empty if it does not.
fn differences(list: &str) -> Vec<String> {
    let mut found = Vec::new();
    let listed: Vec<Row> = table(list, 6, "#")
        .into_iter()
        .enumerate()
        .map(|(i, cells)| {
            if cells[0] != (i + 1).to_string() {
                found.push(format!("row {} is numbered {}", i + 1, cells[0]));
            }
            Row {
                pass: cells[1].trim_matches('`').to_owned(),
                pictures: pictures(&cells[2]),
                buffers: buffers(&cells[3]),
                writes: pictures(&cells[4]),
                exists: cells[5].clone(),
            }
        })
        .collect();
    let code = code();
    for i in 0..listed.len().max(code.len()) {
        if listed.get(i) != code.get(i) {
            found.push(format!("row {}: the list says {:?}, the code {:?}", i + 1, listed.get(i), code.get(i)));
        }
    }

    // The passes of strokes stand in the table of their own.
    let formats = target_formats();
    let listed = table(list, 5, "step");
    let names: Vec<&str> = listed.iter().map(|cells| cells[1].trim_matches('`')).collect();
    if names != lines::strokes::PASSES {
        found.push(format!("for strokes the list has {names:?}, the code {:?}", lines::strokes::PASSES));
    }
    for (i, (cells, shader)) in listed.iter().zip(lines::strokes::PASSES).enumerate() {
        let mut row = row_of_shader(shader, "", &formats);
        let source = match *shader {
            "lines/strokes/id_image" => ID_IMAGE,
            "lines/strokes/stroke" => STROKE,
            _ => "",
        };
        for target in mentions(source, "drawn.").into_iter().filter(|name| formats.contains_key(name)) {
            row.writes.insert(target.clone(), formats[&target].clone());
        }
        let is_right = cells[0] == (i + 1).to_string()
            && row.pictures == pictures(&cells[2])
            && row.buffers == buffers(&cells[3])
            && row.writes == written(&cells[4]);
        if !is_right {
            found.push(format!("{shader}: the list says {cells:?}, the code {row:?}"));
        }
    }

    // The shaders that are no passes of the frame stand in the table of their own.
    let after: Vec<Vec<String>> = table(list, 4, "pass");
    let others: Vec<&str> =
        SHADERS.iter().map(|(name, _)| *name).filter(|name| code.iter().all(|row| row.pass != *name)).collect();
    let others: Vec<&str> = others.into_iter().filter(|name| !lines::strokes::PASSES.contains(name)).collect();
    let names: Vec<&str> = after.iter().map(|cells| cells[0].trim_matches('`')).collect();
    if names != others {
        found.push(format!("after the frame the list has {names:?}, the code {others:?}"));
    }
    for (cells, shader) in after.iter().zip(others) {
        let row = row_of_shader(shader, "", &formats);
        if row.pictures != pictures(&cells[1]) || row.buffers != buffers(&cells[2]) {
            found.push(format!("{shader}: the code has {row:?}"));
        }
    }
    found
}

#[test]
fn the_list_says_what_the_code_does() {
    let found = differences(LIST);
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn the_passes_of_a_style_are_those_of_the_list() {
    let code = code();
    for detector in [None, Some(Detector::Lsa), Some(Detector::Sobel), Some(Detector::Roystan)] {
        for switches in 0..1024 {
            let [antialias, toon, motion, has_strokes, meshes] = [1, 2, 4, 8, 16].map(|bit| switches & bit != 0);
            let [seen, watercolor, blends, adds, balances] = [32, 64, 128, 256, 512].map(|bit| switches & bit != 0);
            let hatching = match (blends, adds) {
                (false, false) => None,
                (true, false) => Some(Scale::Blend),
                (false, true) => Some(Scale::Add),
                (true, true) => continue,
            };
            if balances && hatching.is_none() {
                continue;
            }
            let strokes = has_strokes.then_some(64);
            let balance_px = if balances { 8 } else { 0 };
            let requirements = Requirements {
                detector,
                antialias,
                strokes,
                toon,
                seen,
                watercolor,
                hatching,
                balance_px,
                motion,
                meshes,
            };
            let exists = |row: &Row| match row.exists.as_str() {
                "always" => true,
                "motion is wanted" => motion,
                "the scene has meshes" => meshes,
                "lines by LSA" => detector == Some(Detector::Lsa),
                "lines by Sobel" => detector == Some(Detector::Sobel),
                "lines by Roystan" => detector == Some(Detector::Roystan),
                "lines" => detector.is_some(),
                "lines are anti-aliased" => antialias,
                "shadows or occlusion" => seen,
                "watercolour" => watercolor,
                "hatching" => hatching.is_some(),
                "hatching that blends" => blends,
                "hatching that adds" => adds,
                "hatching is balanced" => balances,
                "the tone is toon" => toon,
                "the tone is not toon" => !toon,
                other => panic!("{other} is no condition that this test knows"),
            };
            let mut listed: Vec<String> = code.iter().filter(|row| exists(row)).map(|row| row.pass.clone()).collect();
            if has_strokes {
                let mut put = |before: &str, passes: &[&str]| {
                    let at = listed.iter().position(|pass| pass.starts_with(before)).unwrap();
                    listed.splice(at..at, passes.iter().map(|pass| (*pass).to_owned()));
                };
                let (finding, others) = lines::strokes::PASSES.split_at(lines::strokes::FINDING);
                put("tones/", others);
                let (on_land, on_meshes) = finding.split_at(lines::strokes::FINDING_ON_LAND);
                put("surface/resolve", if meshes { on_meshes } else { &[] });
                put(if meshes { "surface/mesh_vertices" } else { "surface/resolve" }, on_land);
            }
            assert_eq!(requirements.passes(), listed, "{requirements:?}");
        }
    }
}

#[test]
fn a_planted_error_is_found() {
    let lines: Vec<&str> = LIST.lines().collect();
    let row = |pass: &str| lines.iter().position(|line| line.contains(&format!("| `{pass}` |"))).unwrap();
    let changed = |pass: &str, from: &str, to: &str| {
        let mut lines: Vec<String> = lines.iter().map(|line| (*line).to_owned()).collect();
        let line = &mut lines[row(pass)];
        assert!(line.contains(from), "{line} has no {from} to spoil");
        *line = line.replacen(from, to, 1);
        lines.join("\n")
    };
    let mut without = lines.clone();
    without.remove(row("lines/smooth"));
    let mut twice = lines.clone();
    twice.insert(row("lines/smooth"), lines[row("lines/smooth")]);
    let mut swapped = lines.clone();
    swapped.swap(row("tones/plain"), row("tones/toon"));
    let planted = [
        ("a format that is written", changed("surface/resolve", "`normal` Rgba32Float", "`normal` Rgba16Float")),
        ("a format that is read", changed("lines/threshold", "Rgba16Float", "Rgba32Float")),
        ("the format of an attachment", changed("surface/terrain", "R32Uint", "R32Float")),
        ("a picture that is not read", changed("tones/toon", "`normal`", "`position`")),
        ("a buffer that is not there", changed("lines/lsa", "`lsa`", "`lsb`")),
        ("a buffer less", changed("surface/resolve", ", `tile_rows`", "")),
        ("a buffer that is written", changed("surface/vertices", "`positions` buffer", "")),
        ("a picture that is not written", changed("lines/smooth", "`smoothed`", "`line`")),
        ("a wrong condition", changed("tones/plain", "not toon", "toon")),
        ("a wrong number", changed("lines/lsa", "| 10 |", "| 9 |")),
        ("a shader after the frame", changed("composite/present", "`picture`", "`tone`")),
        ("a row less", without.join("\n")),
        ("a row twice", twice.join("\n")),
        ("another order", swapped.join("\n")),
        ("no list at all", String::new()),
    ];
    for (what, list) in planted {
        assert!(!differences(&list).is_empty(), "{what} is not found");
    }
}
