//! Tests error messages as a newcomer reads them: one line that names the thing and the cause, in words of the field,
//! without control characters.

#![allow(clippy::unwrap_used, reason = "the helpers of tests may panic")]

mod errors;
mod foreign;
mod misuse;
mod toml;
mod warnings;

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use hachure::file::atomic;

/// Words of the programming language, which mean nothing to users.
const OF_RUST: [&str; 19] = [
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
    "expected a ",
    "expected an ",
    "unwrap",
    "panicked",
];

/// Returns the flaw of an error message, if it has one.
fn flaw(stderr: &str, longest: usize) -> Option<String> {
    let Some(line) = stderr.strip_suffix('\n').and_then(|line| line.strip_prefix("hachure: ")) else {
        return Some("it is not a line of the program".to_owned());
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
        atomic::write(&path, bytes.as_ref()).unwrap();
        path
    }

    fn hachure(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_hachure"))
            .args(arguments)
            .current_dir(self.0.path())
            .env("HACHURE_CACHE", self.0.path().join("cache"))
            .env("XDG_RUNTIME_DIR", self.0.path())
            .env_remove("RUST_LOG")
            // Tests have no display.
            .env_remove("DISPLAY")
            .env_remove("WAYLAND_DISPLAY")
            .output()
            .unwrap()
    }

    /// Runs the program, which must fail with `status` and one good line that contains all of `words`.
    fn refused(&self, arguments: &[&str], status: i32, words: &[&str]) {
        self.refused_within(arguments, status, words, 200);
    }

    fn refused_within(&self, arguments: &[&str], status: i32, words: &[&str], longest: usize) {
        let output = self.hachure(arguments);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{arguments:?}: {said}");
        assert!(output.stdout.is_empty(), "{arguments:?} must not print to standard output");
        assert_eq!(flaw(&said, longest), None, "{arguments:?}: {said}");
        for word in words {
            assert!(said.contains(word), "{arguments:?}: the message lacks {word}: {said}");
        }
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
        (&["bench", "s.toml", "--path", "junk.csv", "-o", "d"], &["junk.csv", "not UTF-8 text (line 2)"]),
        (&["info", "junk.csv"], &["junk.csv", "UTF-8"]),
        (&["render", "n.toml", "-o", "o.png"], &["n.toml: a.tif"]),
        (&["info", "n.toml"], &["n.toml: a.tif, b.tif do not exist"]),
        (&["info", "utf16.toml"], &["utf16.toml", "UTF-8"]),
        (&["render", "none.toml", "-o", "o.png"], &["none.toml: there is no such file"]),
        (&["render", "-o", "o.png", "--water", "none.geojson"], &["none.geojson: there is no such file"]),
        (&["render", "model.obj", "-o", "o.png"], &["cannot read the mesh model.obj: it has no faces"]),
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
