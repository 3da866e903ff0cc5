//! Tests that styles, scenes, recipes, camera paths and models are read only from regular files of a bounded size, and
//! from pipes that the shell has opened.

#![cfg(target_os = "linux")]

use std::fs;
use std::io::Write;
use std::os::unix::net::UnixListener;
use std::process::{Command, Stdio};

use crate::place::{PATH, Place, finished};

/// Returns every kind of input: its name, and the arguments with which the command line reads it.
fn uses(place: &Place, input: &str) -> Vec<(&'static str, Vec<String>)> {
    let words = |text: &str| text.split(' ').map(str::to_owned).collect::<Vec<String>>();
    let hatched = place.text(&["styles", "show", "stipple"]);
    let marks = hatched.replace("\"dots\"\nsize", &format!("\"{input}\"\nsize"));
    place.file("marks.toml", &marks);
    place.file("stack-style.toml", hatched.replace("\"dots\"\nsize", "\"stack.toml\"\nsize"));
    place.file("stack.toml", format!("description = \"\"\nkind = \"stack\"\nimages = [\"{input}\"]\n"));
    let stroked =
        place.text(&["styles", "show", "pen"]).replace("texture = \"pen\"", &format!("texture = \"{input}\""));
    assert!(stroked.contains(input), "{stroked}");
    place.file("stroked.toml", stroked);
    place.file(
        "scene.toml",
        format!("[world]\nprocedural = {{}}\n[[meshes]]\nfile = \"{input}\"\nat = [0, 0, 0]\n")
            .replace("{}", "{ seed = 1 }"),
    );
    vec![
        ("style", words(&format!("styles check {input}"))),
        ("style", words(&format!("render -o x.png --style {input}"))),
        ("scene", words(&format!("render {input} -o x.png"))),
        ("path", words(&format!("render -o %d.png --path {input}"))),
        ("path", words(&format!("bench --path {input} -o out"))),
        ("marks", words("styles check marks.toml")),
        ("strokes", words("styles check stroked.toml")),
        ("picture", words("styles check stack-style.toml")),
        ("mesh", words("info scene.toml --trust-scene")),
    ]
}

fn refused(place: &Place, arguments: &[String]) -> String {
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let line = place.error(&arguments);
    assert!(line.len() < 300, "{line}");
    line
}

#[test]
fn what_is_no_file_is_reported_by_its_name() {
    let place = Place::empty();
    let pipe = place.path("pipe.toml");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let _listener = UnixListener::bind(place.path("socket.toml")).unwrap();
    fs::create_dir(place.path("folder.toml")).unwrap();
    std::os::unix::fs::symlink("/dev/zero", place.path("zero.toml")).unwrap();
    for (input, what) in [
        ("pipe.toml", "it is a named pipe"),
        ("socket.toml", "it is a socket"),
        ("folder.toml", "it is a folder"),
        ("zero.toml", "it is a device"),
    ] {
        for (kind, arguments) in uses(&place, input) {
            let line = refused(&place, &arguments);
            assert!(line.contains(input) && line.contains(what), "{kind}, {arguments:?}: {line}");
        }
    }
    assert!(place.error(&["bench", "--path", "/dev/zero", "-o", "out"]).contains("it is a device"));
    place.geotiff("dem.tif", 0);
    fs::rename(&pipe, place.path("dem.tif.tiles")).unwrap();
    for arguments in [&["info", "dem.tif"][..], &["render", "dem.tif", "-o", "x.png"]] {
        let line = place.error(arguments);
        assert!(line.contains("dem.tif.tiles") && line.contains("it is a named pipe"), "{line}");
    }
    assert!(place.error(&["styles", "check", "/dev/stdin"]).contains("it is a device"));
}

#[test]
fn what_is_too_long_is_reported_with_its_size() {
    let place = Place::empty();
    // Sparse files, which take no room on the disk.
    let long = |name: &str, mebibytes: u64| {
        let file = fs::File::create_new(place.path(name)).unwrap();
        file.set_len((mebibytes << 20) + 1).unwrap();
    };
    long("1.toml", 1);
    long("16.toml", 16);
    long("512.toml", 512);
    for (input, limit, kinds) in [
        ("1.toml", "it has 2 MiB, but at most 1 MiB can be read", &["style", "marks", "strokes"][..]),
        ("16.toml", "it has 17 MiB, but at most 16 MiB can be read", &["scene", "path"]),
        ("512.toml", "it has 513 MiB, but at most 512 MiB can be read", &["mesh"]),
    ] {
        for (kind, arguments) in uses(&place, input) {
            if kinds.contains(&kind) {
                let line = refused(&place, &arguments);
                assert!(line.contains(input) && line.contains(limit), "{kind}, {arguments:?}: {line}");
            }
        }
    }
}

#[test]
fn what_is_no_text_is_reported() {
    let place = Place::empty();
    place.file("latin.toml", b"name = \"x\"\n# \xe9t\xe9\n");
    for (kind, arguments) in uses(&place, "latin.toml") {
        if !["picture", "mesh"].contains(&kind) {
            let line = refused(&place, &arguments);
            assert!(line.contains("latin.toml") && line.contains("it is not UTF-8 text (line 2)"), "{kind}: {line}");
        }
    }
}

/// Tests `hachure … <(generate)` and `generate | hachure … /dev/stdin`, where the shell has opened a pipe that ends.
#[test]
fn pipes_of_the_shell_are_read() {
    let place = Place::empty();
    let with_stdin = |arguments: &[&str], text: &str| {
        let mut child = place.command(arguments).stdin(Stdio::piped()).spawn().unwrap();
        let mut stdin = child.stdin.take().unwrap();
        let text = text.to_owned();
        // The program may fail before it has read everything.
        let writer = std::thread::spawn(move || stdin.write_all(text.as_bytes()).is_ok());
        let output = finished(child, arguments);
        (output, writer.join().unwrap())
    };
    let style = place.text(&["styles", "show", "ink"]);
    let (output, _) = with_stdin(&["styles", "check", "/dev/stdin"], &style);
    assert!(output.status.success(), "{output:?}");
    let (output, _) = with_stdin(&["styles", "check", "/dev/fd/0"], &style.replace("tone", "tune"));
    assert!(!output.status.success());
    // The path is valid, so the error is about the world.
    for command in ["render nowhere.tif -o %d.png --path /dev/stdin", "bench nowhere.tif -o out --path /dev/stdin"] {
        let arguments: Vec<&str> = command.split(' ').collect();
        let line = String::from_utf8(with_stdin(&arguments, PATH).0.stderr).unwrap();
        assert!(line.contains("nowhere.tif") && !line.contains("stdin"), "{line}");
    }
    for command in ["render -o %d.png --path /dev/stdin", "bench -o out --path /dev/stdin"] {
        let arguments: Vec<&str> = command.split(' ').collect();
        let line = String::from_utf8(with_stdin(&arguments, "t,x\n").0.stderr).unwrap();
        assert!(line.contains("stdin"), "{line}");
    }
    // A pipe that does not end is read up to the limit.
    let (output, whole) = with_stdin(&["styles", "check", "/dev/stdin"], &"#\n".repeat(1 << 20));
    let line = String::from_utf8(output.stderr).unwrap();
    assert!(line.contains("it has more than the limit of 1 MiB") && !whole, "{line}");
}
