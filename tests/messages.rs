//! What the program says when something is wrong, as a newcomer reads it: one line that names the thing and the cause,
//! in the words of the field, with nothing in it that a terminal would obey.

#![allow(clippy::unwrap_used, reason = "the helpers of tests may panic as the tests do")]

use std::error::Error;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use hachure::file::message::chain;
use hachure::mesh::MeshError;
use hachure::pyramid::PyramidError;
use hachure::remote::RemoteError;
use hachure::scene::path::PathError;
use hachure::scene::scene_file::SceneError;
use hachure::source::{GeoreferenceError, SourceError};
use hachure::style::{Style, StyleError};
use hachure::tiles::terrain::TerrainError;
use hachure::world::WorldError;

/// Words of the program's own language, which say nothing to its users.
const OF_RUST: [&str; 18] = [
    "u8",
    "u16",
    "u32",
    "u64",
    "usize",
    "i32",
    "i64",
    "f32",
    "f64",
    "Option",
    "Vec<",
    "struct",
    "enum",
    "tuple",
    "variant",
    "expected a",
    "unwrap",
    "panicked",
];

/// What is wrong with what the program says of arguments that it refuses.
fn flaw(stderr: &str, longest: usize) -> Option<String> {
    let Some(line) = stderr.strip_suffix('\n').and_then(|line| line.strip_prefix("hachure: ")) else {
        return Some("it is no line of the program".to_owned());
    };
    if line.chars().any(char::is_control) {
        return Some("it has control characters, or several lines".to_owned());
    }
    let words: Vec<&str> = line.split(|it: char| !it.is_ascii_alphanumeric()).collect();
    let is_there = |word: &&&str| words.contains(*word) || (word.contains([' ', '<']) && line.contains(**word));
    if let Some(word) = OF_RUST.iter().find(is_there) {
        return Some(format!("{word} is a word of Rust"));
    }
    let length = line.chars().count();
    (length >= longest).then(|| format!("it has {length} characters"))
}

#[test]
fn the_checker_finds_flaws() {
    for (text, flawed) in [
        ("hachure: a.tif: is empty\n", false),
        ("hachure: a.tif: is empty", true),
        ("a.tif: is empty\n", true),
        ("hachure: a.tif\nis empty\n", true),
        ("hachure: \u{1b}[31ma.tif: is empty\n", true),
        ("hachure: seed: invalid type, f32 is wanted\n", true),
        ("hachure: expected an equals, found an identifier\n", true),
        ("hachure: width32 and structure are words of the field\n", false),
        (&format!("hachure: {}\n", "a".repeat(200)), true),
    ] {
        assert_eq!(flaw(text, 200).is_some(), flawed, "{text}");
    }
}

struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn file(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        fs::write(&path, bytes).unwrap();
        path
    }

    fn hachure(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_hachure"))
            .args(arguments)
            .current_dir(self.0.path())
            .env("HACHURE_CACHE", self.0.path().join("cache"))
            .env("XDG_RUNTIME_DIR", self.0.path())
            .env_remove("RUST_LOG")
            // There is no display for tests.
            .env_remove("DISPLAY")
            .env_remove("WAYLAND_DISPLAY")
            .output()
            .unwrap()
    }

    /// Runs the program, which must refuse with `status` and say all of `words`, in one good line.
    fn refused(&self, arguments: &[&str], status: i32, words: &[&str]) {
        self.refused_within(arguments, status, words, 200);
    }

    fn refused_within(&self, arguments: &[&str], status: i32, words: &[&str], longest: usize) {
        let output = self.hachure(arguments);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{arguments:?}: {said}");
        assert!(output.stdout.is_empty(), "{arguments:?} prints something");
        assert_eq!(flaw(&said, longest), None, "{arguments:?}: {said}");
        for word in words {
            assert!(said.contains(word), "{arguments:?} does not say {word}: {said}");
        }
    }
}

#[test]
fn misuse_is_told_in_one_line() {
    let place = Place::new();
    place.file("x.tif", "junk");
    place.file("p.csv", "t,x,y,z,yaw,pitch,fov\n0,0,0,+9,0,0,50\n");
    let render = ["render", "-o", "o.png"];
    let svg = ["render", "-o", "o.svg", "--style", "strokes"];
    let bench = ["bench", "--path", "p.csv", "-o", "out"];
    let cases: &[(&[&str], &[&str], &[&str])] = &[
        // Values.
        (&render, &["--fps", "0"], &["--fps", "\"0\"", "above 0"]),
        (&render, &["--fps", "-3"], &["--fps", "\"-3\""]),
        (&render, &["--fps", "fast"], &["--fps", "\"fast\"", "number"]),
        (&render, &["--fps", "1e9"], &["at most 1000"]),
        (&render, &["--lod-error", "0"], &["--lod-error", "above 0"]),
        (&render, &["--lod-error", "nan"], &["--lod-error", "\"nan\""]),
        (&render, &["--size", "10"], &["--size", "1280x720"]),
        (&render, &["--camera", "1,2"], &["--camera", "x,y,z,yaw,pitch,fov"]),
        (&render, &["--camera", "1,2,here,4,5,6"], &["z is `here`"]),
        (&render, &["--tile-memory", "0"], &["--tile-memory", "1 to 1048576"]),
        (&render, &["--tile-memory", "lots"], &["whole number"]),
        (&render, &["--eyes", "three"], &["--eyes", "mono"]),
        (&render, &["--aov", "depth"], &["--aov", ".exr", "o.png"]),
        (&["render", "-o", "o.exr"], &["--aov", "dept"], &["--aov dept", "depth"]),
        (&["render", "-o", "o.exr"], &["--aov", "lsa", "--style", "plain"], &["--aov lsa", "plain"]),
        (&svg, &["--paper", "a9"], &["--paper", "\"a9\"", "a4"]),
        (&svg, &["--paper", "a4", "--margin", "-1"], &["--margin", "\"-1\""]),
        (&svg, &["--paper", "a4", "--margin", "200"], &["--margin 200"]),
        (&svg, &["--tolerance-px", "0"], &["--tolerance-px", "0.01"]),
        (&render, &["--paper", "a4"], &["--paper", ".svg"]),
        (&render, &["--style", "inc"], &["inc: no such style; did you mean \"ink\"?"]),
        (&render, &["--style", "oil"], &["oil: no such style", "hachure styles"]),
        (&render, &["--style"], &["--style", "needs a value"]),
        (&bench, &["--styles", "ink,oil"], &["oil: no such style"]),
        (&bench, &["--lod-error", "-1"], &["--lod-error"]),
        (&bench, &["--sweep", "size"], &["\"--sweep\"", "hachure bench --help"]),
        (&bench, &["--frames", "0"], &["--frames", "1 to 1000000"]),
        (&["bake", "x.tif", "-o", "y.tif"], &["--max-error", "-1"], &["--max-error", "\"-1\""]),
        (&["bake", "x.tif", "-o", "y.tif"], &["--shard", "3/2"], &["--shard", "3/8"]),
        (&["bake", "x.tif", "-o", "y.tif"], &["--spacing", "0"], &["--spacing", "above 0"]),
        (&["bake", "x.tif", "-o", "y.tif"], &["--raw-size", "3"], &["--raw-size"]),
        (&["styles", "show"], &["pencl"], &["did you mean \"pencil\"?"]),
        // Outputs.
        (&["render", "x.tif"], &["-o", "o.gif"], &["o.gif", ".png"]),
        (&["render", "x.tif"], &["-o", "o"], &["o: an output ends in"]),
        (&["render", "x.tif"], &["-o", "%x.png", "--path", "p.csv"], &["%x.png", "%05d"]),
        (&["bake", "x.tif"], &["-o", "o.png"], &["o.png", ".tif"]),
        // One picture or many.
        (&["render", "x.tif"], &["-o", "o.mp4"], &["o.mp4", "--path"]),
        (&["render", "x.tif"], &["-o", "o%04d.png"], &["o%04d.png", "--path"]),
        (&["render", "x.tif", "--path", "p.csv"], &["-o", "o.png"], &["o.png", "%05d.png", "--camera"]),
        (&["render", "x.tif", "--path", "p.csv"], &["-o", "o.exr"], &["o.exr", "%05d.png"]),
        (&["render", "x.tif", "--path", "p.csv"], &["-o", "o.svg", "--style", "strokes"], &["o.svg", "%05d.png"]),
        (&["x.tif"], &["-o", "o.mp4"], &["-o", "hachure render"]),
        // Commands.
        (&["rendr"], &["x.tif"], &["\"rendr\"", "did you mean \"render\"?"]),
        (&["rendr"], &["x.tif", "-o", "o.png"], &["did you mean \"render\"?"]),
        (&["rendr"], &[], &["did you mean \"render\"?"]),
        (&["-v", "rendr"], &["x.tif"], &["did you mean \"render\"?"]),
        (&["--adapter", "software", "rendr"], &["x.tif"], &["did you mean \"render\"?"]),
        (&["x.tif"], &["y.tif"], &["\"y.tif\"", "too many"]),
        (&["styles"], &["chekc"], &["did you mean \"check\"?"]),
        (&["info"], &[], &["<FILE>", "missing"]),
        (&["info", "a.tif"], &["b.tif"], &["\"b.tif\"", "too many"]),
        (&["info"], &["https://me:hush@example.org/a.tif"], &["files of this machine"]),
        (&["bake"], &["https://example.org/a.tif", "-o", "o.tif"], &["files of this machine"]),
        (&["render"], &["x.tif"], &["--output", "missing"]),
        (&["bake"], &[], &["--output", "are missing"]),
        (&["render", "-o", "o.png"], &["--stile", "ink"], &["\"--stile\"", "--style"]),
        (&["render", "-o", "o.png"], &["-o", "p.png"], &["--output", "twice"]),
        (&["render", "-o", "o.mp4"], &["--path", "p.csv", "--camera", "0,0,9,0,0,50"], &["--path", "--camera"]),
        (&["--style", "ink", "render"], &["-o", "o.png"], &["--style", "hachure render"]),
        (&["x.tif", "render"], &["-o", "o.png"], &["x.tif", "hachure render"]),
        (&["render", ""], &["-o", "o.png"], &["WORLD is empty"]),
    ];
    for (start, rest, words) in cases {
        place.refused(&[*start, *rest].concat(), 2, words);
    }
    let left: Vec<_> = fs::read_dir(place.0.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left.len(), 2, "nothing was begun: {left:?}");
}

#[test]
fn options_of_all_commands_stand_anywhere() {
    let place = Place::new();
    place.file("s.toml", "[world]\nprocedural = { seed = 4 }\n");
    for arguments in [
        &["-v", "info", "s.toml"][..],
        &["info", "-v", "s.toml"],
        &["info", "s.toml", "-vv"],
        &["--adapter", "software", "info", "s.toml"],
        &["info", "--adapter", "software", "s.toml"],
        &["-v", "--adapter=software", "styles"],
    ] {
        let output = place.hachure(arguments);
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    }
    // Without a command they are a flight's, which asks for a display or begins with its world.
    place.refused(&["-v", "none.tif"], 1, &["none.tif: there is no such file"]);
    place.refused(&["none.tif", "--adapter", "software", "-v"], 1, &["none.tif: there is no such file"]);
    place.refused(&["--adapter", "software", "render", "none.tif", "-o", "o.png"], 1, &["none.tif"]);
    let help = String::from_utf8(place.hachure(&["--help"]).stdout).unwrap();
    assert!(help.contains("hachure [OPTIONS] [WORLD]") && help.contains("hachure [OPTIONS] <COMMAND>"), "{help}");
}

const WORLD: &str = "[world]\nprocedural = { seed = 1 }\n";
const STYLE: &str = "name = \"x\"\ndescription = \"y\"\n[tone]\nkind = \"plain\"\n";

#[test]
fn toml_has_places_and_near_names() {
    let place = Place::new();
    place.file("hut.obj", "v 0 0 0\nv 1 0 0\n# far\nv 0 1 0\nf 1 2 9\n");
    place.file("mine.toml", "description = \"\"\nkind = \"dash\"\nlenght_px = 3\n");
    place.file("tool.toml", "description = \"\"\n\n[tile]\nalong_px = 1.5\n");
    for (text, words) in [
        (
            format!("vertical_exageration = 2\n{WORLD}"),
            "f.toml:1:1: there is no key \"vertical_exageration\"; did you mean \"vertical_exaggeration\"?",
        ),
        (
            WORLD.replace("procedural", "proceduarl"),
            "f.toml:2:1: there is no key \"world.proceduarl\"; did you mean \"procedural\"?",
        ),
        (WORLD.replace("1", "-1"), "f.toml:2:23: world.procedural.seed must be a whole number"),
        (
            format!("{WORLD}[sun]\nazimuth_deg = \"north\"\n"),
            "f.toml:4:15: sun.azimuth_deg must be a number, and \"north\" is a text",
        ),
        (format!("{WORLD}[sun]\nelevation_deg = 99\n"), "f.toml:4:17: sun.elevation_deg: it must lie within"),
        ("[world]\ndem = 3\n".to_owned(), "f.toml:2:7: world.dem: it must be a file's name or a list of them"),
        (
            format!("{WORLD}[[meshes]]\nfile = \"hut.obj\"\nat = [1, 2]\n"),
            "f.toml:5:6: meshes.at must be a list of 3, and it has 2",
        ),
        (
            format!("{WORLD}[[meshes]]\nfile = \"hut.obj\"\nat = [1, 2, \"+0\"]\n"),
            "f.toml: cannot read the mesh hut.obj: line 5: the face names vertex 9, and there are 3",
        ),
        (format!("{WORLD}[sun\n"), "f.toml:3:5: unclosed table"),
        (
            "[world]\ndem = \"a\\u001b[31m.tif\"\n[[meshes]]\nfile = \"b.obj\"\nat = [1, 2, 3]\n".to_owned(),
            "f.toml: a\\u{1b}[31m.tif, b.obj are not there",
        ),
        (
            format!("{STYLE}[strokes]\nwidth_px = \"thin\"\n"),
            "f.toml:6:12: strokes.width_px must be a number, and \"thin\" is a text",
        ),
        (
            format!("{STYLE}[strokes]\nwidth = 3\n"),
            "f.toml:6:1: there is no key \"strokes.width\"; did you mean \"width_px\"?",
        ),
        (format!("{STYLE}[strokes]\nwidth_px = 99\n"), "f.toml:6:12: strokes.width_px is 99, not between 0.5 and 64"),
        (format!("{STYLE}[paper]\ncolor = \"white\"\n"), "f.toml:6:9: paper.color: \"white\" is not a colour like"),
        (STYLE.replace("plain", "toone"), "f.toml:4:8: tone.kind cannot be \"toone\""),
        (
            STYLE.replace("plain", "toon") + "steps = \"many\"\ndarkest = 0\n",
            "f.toml:5:9: tone.steps must be a whole number",
        ),
        (
            format!("{STYLE}[[hatching.layers]]\nmarks = \"line\"\n[[hatching.layers]]\nmarks = \"line\"\nfrom = 2\n"),
            "f.toml:9:8: hatching.layers.from is 2",
        ),
        (format!("{STYLE}[[hatching.layers]]\nmarks = \"lien\"\n"), "lien: no such marks; did you mean \"line\"?"),
        (
            format!("{STYLE}[[hatching.layers]]\nmarks = \"mine.toml\"\n"),
            "mine.toml:3:1: there is no key \"lenght_px\"; did you mean \"length_px\"?",
        ),
        (
            format!("{STYLE}[strokes]\nwidth_px = 3\ntexture = \"tool.toml\"\n"),
            "tool.toml:4:12: tile.along_px must be a whole number",
        ),
    ] {
        place.file("f.toml", &text);
        place.refused(&["info", "f.toml"], 1, &[words]);
    }
    // Side files.
    place.file("h.r16", [0; 32]);
    for (text, words) in [
        ("spacing = 3\n", "h.r16.toml:1:1: there is no key \"spacing\"; did you mean \"spacing_m\"?"),
        ("width = 4\nheight = \"x\"\n", "h.r16.toml:2:10: height must be a whole number"),
        ("endian = \"middle\"\n", "h.r16.toml:1:10: endian cannot be \"middle\"; there is little, big"),
    ] {
        place.file("h.r16.toml", text);
        place.refused(&["info", "h.r16"], 1, &[words]);
    }
}

#[test]
fn what_fails_names_the_file_and_the_scene() {
    let place = Place::new();
    place.file("junk.tif", b"II*\0junk");
    place.file("junk.csv", b"t,x,y,z,yaw,pitch,fov\n\xff\x1b,0,0,0,0,0,50\n");
    place.file("s.toml", "[world]\ndem = \"junk.tif\"\n");
    place.file("n.toml", "[world]\ndem = [\"a.tif\", \"b.tif\"]\n");
    place.file("utf16.toml", b"\xff\xfe[\0w\0");
    place.file("model.obj", "v 0 0 0\n");
    fs::create_dir(place.0.path().join("empty")).unwrap();
    for (arguments, words) in [
        (&["render", "s.toml", "-o", "o.png"][..], &["s.toml: junk.tif: is damaged"][..]),
        (&["bench", "s.toml", "--path", "junk.csv", "-o", "d"], &["junk.csv:2"]),
        (&["render", "n.toml", "-o", "o.png"], &["n.toml: a.tif"]),
        (&["info", "n.toml"], &["n.toml: a.tif, b.tif are not there"]),
        (&["info", "utf16.toml"], &["utf16.toml", "UTF-8"]),
        (&["render", "none", "-o", "o.png"], &["none: there is no such file"]),
        (&["render", "none.toml", "-o", "o.png"], &["none.toml: there is no such file"]),
        (&["render", "model.obj", "-o", "o.png"], &["model.obj: is an OBJ model"]),
        (&["render", "empty", "-o", "o.png"], &["empty: the folder holds no height files"]),
        (&["info", "junk.tif"], &["junk.tif: is damaged"]),
        (&["styles", "check", "empty"], &["empty: cannot read the style: "]),
        (&["styles", "check", "none.toml"], &["none.toml: cannot read the style: "]),
        (&["render", "s.toml", "-o", "no/o.png"], &["no/o.png", "no folder no"]),
        (&["render", "-o", "o.png", "--style", "none.toml"], &["none.toml: cannot read the style: "]),
    ] {
        place.refused(arguments, 1, words);
    }
}

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
    // A file that is there, in what is printed and in warnings.
    place.file("red\u{1b}[31m.r16", [1; 128]);
    let output = place.hachure(&["info", "red\u{1b}[31m.r16"]);
    let told = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
    assert!(output.status.success() && told.contains("WARN"), "{told}");
    assert!(!told.contains('\u{1b}') && told.contains("red\\u{1b}[31m.r16: a DEM"), "{told}");

    let long = "x".repeat(5000);
    for (arguments, status) in [
        (&["render", "-o", "o.png", "--size", &long][..], 2),
        (&["render", "-o", "o.png", "--style", &long], 2),
        (&["render", "-o", "o.png", "--camera", &long], 2),
        (&["render", "-o", "o.exr", "--aov", &long], 2),
        (&["render", "-o", &long], 2),
        (&["render", "-o", "o.png", &format!("--{long}")], 2),
        (&["styles", &long], 2),
        (&[&long, "y.tif"], 2),
        (&["info", &long], 1),
    ] {
        place.refused_within(arguments, status, &["x…x"], 260);
    }
    // The end of a long name is what tells files apart.
    let deep = format!("{}/ridge.tif", "deep/".repeat(60));
    place.refused(&["info", &deep], 1, &["deep/ridge.tif: cannot be opened"]);

    for text in [
        format!("[world]\n\"{long}\" = 3\n"),
        format!("[world]\ndem = \"\\u001b{long}\"\n"),
        format!("{WORLD}[sun]\nazimuth_deg = \"\\u001b{long}\"\n"),
        format!("{WORLD}[haze]\ncolor = \"\\u001b{long}\"\n"),
        format!("{WORLD}[camera]\nstart = \"\\u001b{long}\"\n"),
        format!("{STYLE}[paper]\ncolor = \"\\u001b{long}\"\n"),
        format!("{STYLE}[strokes]\nwidth_px = 1\ntexture = \"\\u001b{long}\"\n"),
        format!("{STYLE}[[hatching.layers]]\nmarks = \"\\u001b{long}\"\n"),
    ] {
        place.file("f.toml", &text);
        place.refused_within(&["info", "f.toml"], 1, &["…"], 260);
    }
}

/// Whether what an error says holds what its causes say, each once, and whether the program adds nothing to it.
fn tells_all(error: &(dyn Error + 'static)) -> Result<(), String> {
    let told = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        let words = error.to_string();
        if told.matches(&words).count() != 1 {
            return Err(format!("{told:?} does not say {words:?} once"));
        }
        cause = error.source();
    }
    if chain(error) == told { Ok(()) } else { Err(format!("{:?} is not {told:?}", chain(error))) }
}

#[derive(Debug, thiserror::Error)]
#[error("{words}")]
struct Planted {
    words: &'static str,
    source: io::Error,
}

#[test]
fn errors_tell_their_causes_once() {
    let path = || PathBuf::from("land/a.tif");
    let full = || io::Error::other("the disk is full");
    let open = || SourceError::Open { path: path(), source: full() };
    let remote = || RemoteError::Io { name: "b.tif".to_owned(), source: full() };
    let boxed = || -> Box<dyn Error + Send + Sync> { Box::new(Planted { words: "the block is odd", source: full() }) };
    let name = || "x".to_owned();
    let scene = || SceneError::Open { path: path(), cause: full() };
    let bad_scene = hachure::scene::Scene::parse(Path::new("s.toml"), "[world]\nx = 1\n").unwrap_err();
    let errors: Vec<Box<dyn Error>> = vec![
        Box::new(open()),
        Box::new(SourceError::Georeference { path: path(), source: GeoreferenceError::PixelSize }),
        Box::new(hachure::source::open(Path::new("none.tif"), &hachure::source::Silent).unwrap_err()),
        Box::new(remote()),
        Box::new(PyramidError::Io { path: path(), what: "writing", source: full() }),
        Box::new(PyramidError::Encode { path: path(), source: boxed() }),
        Box::new(PyramidError::Decode { path: path(), source: boxed() }),
        Box::new(PyramidError::from(remote())),
        Box::new(PyramidError::Unread { source: open() }),
        Box::new(PyramidError::from(open())),
        Box::new(PyramidError::Load(Box::new(open()))),
        Box::new(Style::load("none.toml").unwrap_err()),
        Box::new(StyleError::ReadTexture { path: name(), source: full() }),
        Box::new(StyleError::ReadMarks { path: name(), source: full() }),
        Box::new(Style::parse("x.toml", "name = 3").unwrap_err()),
        Box::new(scene()),
        Box::new(PathError::Open { path: path(), cause: full() }),
        Box::new(WorldError::from(bad_scene)),
        Box::new(WorldError::from(PyramidError::from(open()))),
        Box::new(WorldError::Terrain { name: name(), source: TerrainError::TooWide { width: 9, height: 9 } }),
        Box::new(WorldError::InScene { scene: "s.toml".into(), source: Box::new(PyramidError::from(open()).into()) }),
        Box::new(WorldError::from(MeshError::Read { path: path(), cause: name() })),
    ];
    for error in errors {
        tells_all(&*error).unwrap();
    }
    assert!(tells_all(&Planted { words: "the block is odd", source: full() }).is_err());
    assert!(tells_all(&Planted { words: "the disk is full: the disk is full", source: full() }).is_err());
}
