//! An installed program without its source tree has built-in scenes and camera paths.

use std::path::Path;
use std::process::{Command, Output};

use hachure::file::png::read_rgba8;

use super::{Place, checked_in, full};

/// Runs a copy of the program in the root of the file system.
fn installed(place: &Place, arguments: &[&str]) -> Output {
    let copy = place.path("hachure");
    if !copy.exists() {
        std::fs::copy(env!("CARGO_BIN_EXE_hachure"), &copy).unwrap();
    }
    Command::new(&copy)
        .args(arguments)
        .current_dir("/")
        .env("HACHURE_CACHE", &place.cache)
        .env("XDG_RUNTIME_DIR", place.path(""))
        .env_remove("RUST_LOG")
        .output()
        .unwrap()
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned()
}

#[test]
fn an_installed_program_lists_its_scenes_and_paths() {
    let place = Place::empty();
    for (name, expected) in [
        ("hut", "mesh      hut.obj: "),
        ("continent", "continent 1, 327680 × 327680 samples"),
        ("continent_small", "continent 1, 2048 × 2048 samples"),
        ("forest", "the procedural world, seed 1"),
        ("ascent", "a camera path"),
        ("tour", "a camera path"),
        ("valley", "a camera path"),
    ] {
        let output = installed(&place, &["info", name]);
        assert!(output.status.success() && text(&output).contains(expected), "{name}: {}", text(&output));
    }
    // An unknown name gives the list of built-in scenes; a name that looks like a file does not.
    let output = installed(&place, &["render", "hutch", "-o", place.path("a.png").to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    let names = "hutch: there is no such file; the built-in scenes are continent, continent_small, forest, hut";
    assert_eq!(text(&output).trim_end(), format!("hachure: {names}; did you mean \"hut\"?"));
    let output = installed(&place, &["render", "hut.toml", "-o", place.path("a.png").to_str().unwrap()]);
    assert_eq!(text(&output).trim_end(), "hachure: hut.toml: there is no such file");
}

#[test]
fn a_file_of_the_same_name_comes_first() {
    let place = Place::empty();
    place.file("hut", "no heights at all");
    assert!(place.error(&["render", "hut", "-o", "a.png"]).starts_with("hut: "));
    place.file("tour", "t,x,y\n");
    assert!(place.error(&["info", "tour"]).starts_with("tour"));
}

#[test]
fn a_scene_inside_draws_as_its_file_does() {
    if hachure::gpu::Gpu::open(&hachure::gpu::device::AdapterWish::Best).is_err() {
        println!("skipped: no GPU");
        return;
    }
    let place = Place::with_built_in_land();
    let mut pictures = Vec::new();
    let scene_file = checked_in("terrain/hut.toml");
    for (world, name) in [("hut", "inside.png"), (scene_file.as_str(), "file.png"), ("", "without.png")] {
        let path = place.path(name);
        let style = if full() { "ink" } else { "plain" };
        let mut arguments = vec!["render", "--size", "96x54", "--style", style, "-o", path.to_str().unwrap()];
        arguments.extend(Some(world).filter(|world| !world.is_empty()));
        let output = installed(&place, &arguments);
        assert!(output.status.success(), "{world}: {}", text(&output));
        pictures.push(read_rgba8(Path::new(&path)).unwrap());
    }
    assert!(pictures[0] == pictures[1], "the built-in scene and terrain/hut.toml give different pictures");
    // Planted error: the scene without its huts.
    assert!(pictures[0] != pictures[2]);
}
