//! Tests tonal art maps from drawn pictures: they are made nested and shown at their own darkness; invalid pictures are
//! reported in one line.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::path::{Path, PathBuf};

use crate::tests::helpers::tones::{are_nested, mean_error, tone};
use hachure::file::{atomic, png::write_rgba8};
use hachure::style::marks::{Recipe, check_pictures};
use hachure::style::{Style, StyleError};
use hachure::tones::tonal_art_map::TonalArtMap;

/// Writes a grey picture, and returns its path.
fn picture(folder: &Path, name: &str, side: u32, is_ink: impl Fn(u32, u32) -> bool) -> PathBuf {
    let pixel = |at: u32| if is_ink(at % side, at / side) { [20, 30, 40, 255] } else { [250, 245, 230, 255] };
    let rgba: Vec<u8> = (0..side * side).flat_map(pixel).collect();
    let path = folder.join(name);
    write_rgba8(&path, side, side, &rgba).unwrap();
    path
}

const STACK: &str = "description = \"drawn\"\nkind = \"stack\"\nimages = [\"a.png\", \"b.png\", \"c.png\"]\n";

#[test]
fn pictures_become_nested_tones() {
    let folder = tempfile::tempdir().unwrap();
    // The second picture lacks some marks of the first.
    let drawn: [fn(u32, u32) -> bool; 3] =
        [|_, y| y % 16 < 2, |x, y| y % 16 < 2 && x > 40 || y % 16 == 8, |x, y| (x + y) % 8 < 3];
    let nested = |i: usize, x: u32, y: u32| drawn[..=i].iter().any(|is_ink| is_ink(x, y));
    for (name, is_ink) in ["a.png", "b.png", "c.png"].into_iter().zip(drawn) {
        picture(folder.path(), name, 128, is_ink);
    }
    atomic::write(&folder.path().join("mine.toml"), STACK.as_bytes()).unwrap();
    let recipe = Recipe::load("mine.toml", folder.path()).unwrap();
    let map = TonalArtMap::cached(&recipe).unwrap();
    assert_eq!(map.side_px, 128);
    assert!(mean_error(&map) < 0.005);
    let pictures: Vec<Vec<bool>> =
        drawn.iter().map(|is_ink| (0..128 * 128).map(|at| is_ink(at % 128, at / 128)).collect()).collect();
    // Planted: the pictures themselves are not nested.
    assert!(!are_nested(&pictures));
    // A tone at a picture's own darkness shows its marks and those of all lighter pictures, to the precision of a byte.
    for (i, picture) in pictures.iter().enumerate() {
        let asked: Vec<bool> = (0..128 * 128).map(|at| nested(i, at % 128, at / 128)).collect();
        let darkness = asked.iter().filter(|ink| **ink).count() as f32 / asked.len() as f32;
        let found = tone(&map, darkness);
        let wrong = found.iter().zip(&asked).filter(|(a, b)| a != b).count();
        assert!(wrong <= asked.len() / 256 + 1, "{i}: {wrong}");
        let shown = found.iter().zip(picture).filter(|(a, b)| a != b).count();
        assert!(i == 0 || shown > asked.len() / 256 + 1, "{i}: the picture alone must differ from the nested tone");
    }
}

/// Returns the error message, if generating a map failed.
fn words(made: &Result<TonalArtMap, StyleError>) -> Result<(), String> {
    made.as_ref().map(|_| ()).map_err(ToString::to_string)
}

#[test]
fn broken_pictures_give_an_error_of_one_line() {
    let folder = tempfile::tempdir().unwrap();
    atomic::write(&folder.path().join("mine.toml"), STACK.as_bytes()).unwrap();
    let style =
        "name = \"x\"\ndescription = \"\"\n[tone]\nkind = \"plain\"\n[[hatching.layers]]\nmarks = \"mine.toml\"\n";
    let style_file = folder.path().join("style.toml");
    atomic::write(&style_file, style.as_bytes()).unwrap();
    let loaded = || Style::load(style_file.to_str().unwrap());
    let error = |cause: &str, name: &str| {
        let recipe = Recipe::load("mine.toml", folder.path()).unwrap();
        let error = TonalArtMap::make(&recipe).unwrap_err().to_string();
        // Loading a style that names these marks gives the same message, after the position where it names them.
        let by_style = loaded().unwrap_err().to_string();
        assert_eq!(by_style, format!("{}:6:9: {error}", style_file.display()));
        assert!(error.starts_with(&format!("{}: ", folder.path().join(name).display())), "{error}");
        assert!(error.contains(cause) && error.lines().count() == 1, "{error}");
    };
    error("cannot read the picture: ", "a.png");
    let good = picture(folder.path(), "a.png", 64, |x, _| x < 3);
    error("cannot read the picture: ", "b.png");
    picture(folder.path(), "b.png", 128, |x, _| x < 3);
    error("it is 128 px wide, but the first picture is 64", "b.png");
    picture(folder.path(), "b.png", 100, |x, _| x < 3);
    error("it is 100 × 100 px; pictures of marks must be square", "b.png");
    picture(folder.path(), "b.png", 32, |x, _| x < 3);
    error("it is 32 × 32 px", "b.png");
    // Files cut at every length and damaged at every byte: the result is an error in one line, or a map, and never a
    // panic.
    picture(folder.path(), "c.png", 64, |x, _| x < 9);
    picture(folder.path(), "b.png", 64, |x, _| x < 6);
    assert_eq!(loaded().unwrap().files.len(), 5, "the files must be the style, its recipe and three pictures");
    let whole = std::fs::read(&good).unwrap();
    let recipe = Recipe::load("mine.toml", folder.path()).unwrap();
    for at in 0..whole.len() {
        let mut flipped = whole.clone();
        flipped[at] ^= 0x41;
        for (bytes, is_cut) in [(&whole[..at], true), (&flipped[..], false)] {
            atomic::write(&folder.path().join("b.png"), bytes).unwrap();
            let made = TonalArtMap::make(&recipe);
            assert_eq!(check_pictures(&recipe).map_err(|error| error.to_string()), words(&made), "at {at}");
            match made {
                Ok(map) => assert!(map.side_px == 64 && (!is_cut || at + 12 >= whole.len()), "cut at {at}"),
                Err(error) => assert_eq!(error.to_string().lines().count(), 1, "{error}"),
            }
        }
    }
}
