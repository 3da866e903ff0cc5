//! Tests tonal art maps: nested tones with the right means everywhere, on textures without seams, the same on every
//! machine, with marks of the recipe's width and spacing, and read from a cache that may be damaged.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use crate::tests::common::full;
use crate::tests::helpers::tones::{are_nested, mean_error, tone};
use hachure::file::atomic;
use hachure::style::StyleError;
use hachure::style::marks::{Kind, Recipe, names};
use hachure::tones::tonal_art_map::{TonalArtMap, read_or_make};

/// Checksum of [`SMALL`]'s map on every machine.
const HERE: u32 = 820_939_493;

/// A recipe that never changes, so that the bits of its map are known.
const SMALL: &str = r#"
description = "for tests"
kind = "dash"
side_px = 128
seed = 7
length_px = 20.0
width_px = 2.0
spacing_px = 7.0
wobble_px = 1.0
taper = 0.5
jitter = 0.5
swell = 0.3
pressure = 0.5
grain = 0.1
"#;

fn recipe(name: &str) -> Recipe {
    Recipe::load(name, Path::new("")).unwrap()
}

/// Returns every shipped recipe with its map, generated once; in the fast tier one recipe of lines and one of dots.
fn maps() -> &'static [(&'static str, Recipe, TonalArtMap)] {
    static MAPS: OnceLock<Vec<(&'static str, Recipe, TonalArtMap)>> = OnceLock::new();
    MAPS.get_or_init(|| {
        let make = |name: &'static str| {
            let recipe = recipe(name);
            let begin = std::time::Instant::now();
            let map = TonalArtMap::make(&recipe).unwrap();
            println!("{name}: made in {:.2} s", begin.elapsed().as_secs_f64());
            (name, recipe, map)
        };
        names().into_iter().filter(|name| full() || ["line", "stipple"].contains(name)).map(make).collect()
    })
}

#[test]
fn tones_are_nested() {
    for (name, _, map) in maps() {
        let mut tones: Vec<_> = (0..=32).map(|i| tone(map, i as f32 / 32.0)).collect();
        assert!(are_nested(&tones), "{name}");
        assert!(tones[0].iter().all(|ink| !ink) && tones[32].iter().all(|ink| *ink), "{name}");
        // Planted: two swapped tones.
        tones.swap(9, 10);
        assert!(!are_nested(&tones), "{name}: a swap was not detected");
    }
}

#[test]
fn tones_have_their_means() {
    for (name, _, map) in maps() {
        let error = mean_error(map);
        assert!(error < 0.005, "{name}: means are off by {error}");
        // Planted: unequalised thresholds, which crowd around their middle.
        let mut crowded = map.clone();
        crowded.thresholds.iter_mut().for_each(|threshold| *threshold = 64 + *threshold / 2);
        assert!(mean_error(&crowded) > 0.005, "{name}");
    }
}

/// Returns sums over windows of `side` along one axis of a square of numbers, which wraps around.
fn summed(values: &[f64], size: usize, side: usize, step: usize, line: usize) -> Vec<f64> {
    let mut sums = vec![0.0; values.len()];
    for i in 0..size {
        let at = |j: usize| values[i * line + j % size * step];
        let mut sum: f64 = (0..side).map(at).sum();
        for j in 0..size {
            sums[i * line + j * step] = sum;
            sum += at(j + side) - at(j);
        }
    }
    sums
}

/// Returns the largest difference between a window's mean and the darkness, over all positions and nine tones. A sharp
/// window is the square of 64 × 64 pixels itself. A soft one has the same size (its standard deviation) but no edges;
/// where an edge cuts marks, it counts parts of them.
fn window_error(map: &TonalArtMap, is_soft: bool) -> f64 {
    let size = map.side_px as usize;
    let sides: &[usize] = if is_soft { &[37, 37, 37] } else { &[64] };
    let mut most: f64 = 0.0;
    for i in 1..10 {
        let darkness = f64::from(i) / 10.0;
        let mut means: Vec<f64> =
            tone(map, darkness as f32).into_iter().map(|ink| if ink { 1.0 } else { 0.0 }).collect();
        for side in sides {
            means = summed(&means, size, *side, 1, size);
            means = summed(&means, size, *side, size, 1);
            means.iter_mut().for_each(|sum| *sum /= (side * side) as f64);
        }
        most = means.iter().map(|mean| (mean - darkness).abs()).fold(most, f64::max);
    }
    most
}

/// Returns a map with thresholds ranked over the whole texture only.
fn ranked(side_px: u32, values: &[f32]) -> TonalArtMap {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut thresholds = vec![0; values.len()];
    for (rank, place) in order.into_iter().enumerate() {
        thresholds[place] = (rank * 256 / values.len()) as u8;
    }
    TonalArtMap { side_px, thresholds }
}

#[test]
fn tones_are_right_in_every_window() {
    for (name, _, map) in maps() {
        let [sharp, soft] = [false, true].map(|is_soft| window_error(map, is_soft));
        println!("{name}: windows of 64 px differ by {sharp:.4} at most, soft ones by {soft:.4}");
        assert!(soft < 0.025, "{name}: {soft}");
        // A line of spacing s that an edge just cuts is s / 4 / 64 of the window at mid tone, whatever the rest is; in
        // light tones s is 20 px.
        assert!(sharp < 0.05, "{name}: {sharp}");
        // Tones of windows hardly depend on the marks, so the planted errors are tested with three kinds only.
        if !["line", "stipple", "cross"].contains(name) {
            continue;
        }
        // Planted: right over the texture, but darker in some parts than in others.
        let side = map.side_px as usize;
        let hill = |at: usize| ((at % side) as f32 / side as f32 - 0.5).abs() * 60.0;
        let values = map.thresholds.iter().enumerate();
        let values: Vec<f32> = values.map(|(at, t)| f32::from(*t) + hill(at) + hill(at / side)).collect();
        let uneven = ranked(map.side_px, &values);
        assert!(mean_error(&uneven) < 0.005, "{name}: the planted error must affect only windows");
        assert!(window_error(&uneven, true) > 0.025 && window_error(&uneven, false) > 0.05, "{name}");
        // Planted: one quarter is slightly darker.
        let mut darker = map.clone();
        let is_quarter = |at: usize| at % side < side / 2 && at / side < side / 2;
        darker.thresholds.iter_mut().enumerate().filter(|(at, _)| is_quarter(*at)).for_each(|(_, t)| *t -= *t / 6);
        assert!(window_error(&darker, true) > 0.025 && window_error(&darker, false) > 0.05, "{name}");
    }
}

/// Returns the mean differences between each line of texels and the next, and between the last and the first. `step` is
/// the distance between lines.
fn steps(map: &TonalArtMap, lines: usize, step: usize, along: usize) -> Vec<f64> {
    let side = map.side_px as usize;
    let difference = |line: usize| {
        let at = |line: usize, i: usize| f64::from(map.thresholds[line * step + i * along]);
        (0..side).map(|i| (at(line, i) - at((line + 1) % lines, i)).abs()).sum::<f64>() / side as f64
    };
    (0..lines).map(difference).collect()
}

/// Returns whether the first `lines` columns or rows repeat with a seam.
fn has_seam(map: &TonalArtMap, lines: usize, are_rows: bool) -> bool {
    let side = map.side_px as usize;
    let (step, along) = if are_rows { (side, 1) } else { (1, side) };
    let steps = steps(map, lines, step, along);
    let (seam, inside) = steps.split_last().unwrap();
    *seam > inside.iter().copied().fold(0.0, f64::max)
}

#[test]
fn tiles_have_no_seam() {
    for (name, _, map) in maps() {
        for are_rows in [false, true] {
            let side = map.side_px as usize;
            assert!(!has_seam(map, side, are_rows), "{name}, rows: {are_rows}");
            // Planted: a texture that is cut off. Some cuts fit a regular grid. Rows along long marks differ inside as
            // much as at a cut, so a cut cannot be detected there.
            let is_told = !are_rows || ["stipple", "scribble", "dab", "halftone"].contains(name);
            let noticed = (1..=8).filter(|i| has_seam(map, side * 3 / 4 + 3 * i, are_rows)).count();
            let wanted = if *name == "halftone" { 3 } else { 8 };
            assert!(!is_told || noticed >= wanted, "{name}, rows: {are_rows}: only {noticed} of 8 cuts were detected");
        }
    }
}

/// Returns the mean width of marks, and the mean distance between them, across the marks.
fn across(map: &TonalArtMap, darkness: f32) -> [f32; 2] {
    let side = map.side_px as usize;
    let tone = tone(map, darkness);
    let ink = tone.iter().filter(|ink| **ink).count() as f32;
    let begins = |place: usize| tone[place] && !tone[(place + side * (side - 1)) % (side * side)];
    let marks = (0..tone.len()).filter(|place| begins(*place)).count() as f32;
    [ink / marks, (side * side) as f32 / marks]
}

/// Returns the distance at which rows are most alike, near `near_px`. Regular lines have such a period.
fn period_px(map: &TonalArtMap, darkness: f32, near_px: f32) -> usize {
    let side = map.side_px as usize;
    let tone = tone(map, darkness);
    let alike = |lag: usize| (0..tone.len()).filter(|at| tone[*at] && tone[(at + lag * side) % tone.len()]).count();
    ((0.6 * near_px) as usize..(1.7 * near_px) as usize).max_by_key(|lag| alike(*lag)).unwrap()
}

#[test]
fn marks_have_their_width_and_spacing() {
    let are_right = |recipe: &Recipe, [width_px, spacing_px]: [f32; 2]| {
        let is_near = |value: f32, asked: f32| (value / asked - 1.0).abs() < 0.25;
        is_near(width_px, recipe.width_px) && is_near(spacing_px, recipe.spacing_px)
    };
    for (name, recipe, map) in maps() {
        if !["line", "dash", "hachure", "pencil", "engraving"].contains(name) {
            continue;
        }
        let found = across(map, recipe.mid_darkness());
        println!("{name}: {found:.2?} px, requested {} and {}", recipe.width_px, recipe.spacing_px);
        assert!(are_right(recipe, found), "{name}: {found:?}");
        // Planted: every second row omitted, so marks are half as wide and half as far apart.
        let side = map.side_px as usize;
        let rows = (0..side).flat_map(|y| map.thresholds[2 * y % side * side..][..side].iter().copied());
        let pressed = TonalArtMap { side_px: map.side_px, thresholds: rows.collect() };
        assert!(!are_right(recipe, across(&pressed, recipe.mid_darkness())), "{name}");
        if *name == "engraving" {
            let [right, wrong] =
                [map, &pressed].map(|map| period_px(map, recipe.mid_darkness(), recipe.spacing_px) as f32);
            assert!((right / recipe.spacing_px - 1.0).abs() < 0.25, "{right}");
            assert!((wrong / recipe.spacing_px - 1.0).abs() > 0.25 || wrong == 6.0, "{wrong}");
        }
    }
}

/// Returns the largest number, over all tones, of pieces of ink or gaps along rows that are shorter than 7 px.
fn crumbs(map: &TonalArtMap) -> usize {
    let side = map.side_px as usize;
    let count = |darkness: f32| {
        let tone = tone(map, darkness);
        let ends = |place: &usize| {
            let after = |i: usize| tone[place / side * side + (place + i) % side];
            after(0) != after(1) && (2..8).any(|i| after(i) != after(1))
        };
        (0..tone.len()).filter(ends).count()
    };
    (1..10).map(|i| count(i as f32 / 10.0)).max().unwrap()
}

#[test]
fn lines_have_no_crumbs() {
    for (name, _, map) in maps().iter().filter(|(name, ..)| ["line", "engraving"].contains(name)) {
        // Where the precision of a byte ends, a piece may be cut.
        assert!(crumbs(map) <= 2, "{name}: {}", crumbs(map));
        // Planted: some thresholds that are too low.
        let mut crumbled = map.clone();
        crumbled.thresholds.iter_mut().step_by(997).for_each(|threshold| *threshold /= 2);
        assert!(crumbs(&crumbled) > 2, "{name}");
    }
}

#[test]
fn maps_are_the_same_everywhere() {
    let small = Recipe::parse("test", SMALL).unwrap();
    let bits = |recipe: &Recipe| crc32fast::hash(&TonalArtMap::make(recipe).unwrap().thresholds);
    let here = bits(&small);
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(pool.install(|| bits(&small)), here);
    }
    assert_eq!(here, HERE);
    // Planted: another seed gives another map.
    assert_ne!(bits(&Recipe { seed: 8, ..small }), here);
    // Generating a map twice gives the same bits.
    for name in ["line", "cross", "halftone"] {
        let recipe = Recipe { side_px: 128, ..recipe(name) };
        assert_eq!(bits(&recipe), bits(&recipe), "{name}");
    }
}

/// Returns the only file in a folder.
fn only_file(folder: &Path) -> PathBuf {
    let files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert_eq!(files.len(), 1, "{files:?}");
    files[0].clone()
}

#[test]
fn a_damaged_cache_is_rebuilt() {
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().join("marks");
    let small = Recipe::parse("test", SMALL).unwrap();
    let made = TonalArtMap::make(&small).unwrap();
    assert_eq!(read_or_make(&small, &cache).unwrap(), made);
    let path = only_file(&cache);
    let whole = std::fs::read(&path).unwrap();
    assert_eq!(read_or_make(&small, &cache).unwrap(), made);
    // The cache is read, not rebuilt: another map under the right name and checksum is returned.
    let other = Recipe { seed: 8, ..small.clone() };
    assert_ne!(read_or_make(&other, &cache).unwrap(), made);
    let other = std::fs::read_dir(&cache).unwrap().map(|entry| entry.unwrap().path()).find(|other| *other != path);
    let other = std::fs::read(other.unwrap()).unwrap();
    let planted = [&whole[..20], &other[20..]].concat();
    atomic::write(&path, &planted).unwrap();
    assert_ne!(read_or_make(&small, &cache).unwrap(), made, "the cache must be read");
    // A cache with any damage is rebuilt, and is intact afterwards.
    let flipped = |at: usize| {
        let mut bytes = whole.clone();
        bytes[at] ^= 4;
        bytes
    };
    let cuts = [0, 7, 8, 19, 27, 28, whole.len() - 1].map(|length| whole[..length].to_vec());
    let flips = [0, 9, 16, 22, 28, whole.len() - 1].map(flipped);
    let longer = [&whole[..], b"more"].concat();
    let all = cuts.into_iter().chain(flips).chain([longer, other]);
    for damaged in all.step_by(if full() { 1 } else { 3 }) {
        atomic::write(&path, &damaged).unwrap();
        assert_eq!(read_or_make(&small, &cache).unwrap(), made);
        assert_eq!(std::fs::read(&path).unwrap(), whole);
    }
    // A folder that cannot exist, because it would be inside a file.
    assert_eq!(read_or_make(&small, &path.join("below")).unwrap(), made);
}

#[test]
fn mistakes_give_an_error_of_one_line() {
    let spoil = |from: &str, to: &str| {
        assert!(SMALL.contains(from), "{from}");
        SMALL.replacen(from, to, 1)
    };
    let spoiled = [
        (spoil("taper", "tapir"), "mine.toml:10:1: unknown key \"tapir\"; did you mean \"taper\"?"),
        (spoil("kind = \"dash\"\n", ""), "the key \"kind\" is missing"),
        (spoil("\"dash\"", "\"spots\""), ":3:8: kind cannot be \"spots\""),
        (spoil("side_px = 128", "side_px = 100"), "side_px is 100, not a power of two from 64 to 1024"),
        (spoil("side_px = 128", "side_px = 2048"), "side_px is 2048"),
        (spoil("side_px = 128", "side_px = -1"), ":4:"),
        (spoil("length_px = 20.0", "length_px = 1e9"), "length_px is 1000000000, not between 1 and 400"),
        (spoil("width_px = 2.0", "width_px = 0.5"), "width_px is 0.5"),
        (spoil("width_px = 2.0", "width_px = 6.9"), "width_px is 6.9, more than 90 % of spacing_px, which is 7"),
        (spoil("spacing_px = 7.0", "spacing_px = inf"), "spacing_px is inf"),
        (spoil("wobble_px = 1.0", "wobble_px = -1.0"), "wobble_px is -1"),
        (spoil("taper = 0.5", "taper = 1.5"), "taper is 1.5, not between 0 and 1"),
        (spoil("jitter = 0.5", "jitter = nan"), "jitter is NaN"),
        (spoil("swell = 0.3", "swell = 2.0"), "swell is 2"),
        (spoil("pressure = 0.5", "pressure = -0.1"), "pressure is -0.1"),
        (spoil("grain = 0.1", "grain = 9.0"), "grain is 9"),
        (spoil("\"dash\"", "\"stack\""), "images has 0 entries, not 1 to 32"),
        (SMALL.to_owned() + "images = [\"a.png\"]", "images are given, but kind is not \"stack\""),
        ("[".to_owned(), ":1:"),
    ];
    for (text, cause) in spoiled {
        let error = Recipe::parse("mine.toml", &text).unwrap_err().to_string();
        assert!(error.starts_with("mine.toml:") && error.contains(cause), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
    let error = Recipe::load("crayon", Path::new("")).unwrap_err();
    assert!(matches!(error, StyleError::UnknownMarks { .. }));
    assert!(error.to_string().starts_with("crayon: no such marks; available: line, dash, hachure"), "{error}");
    let error = Recipe::load("nowhere.toml", Path::new("folder")).unwrap_err().to_string();
    let expected = format!("{}: cannot read the marks: ", Path::new("folder").join("nowhere.toml").display());
    assert!(error.starts_with(&expected), "{error}");
}

#[test]
fn no_recipe_breaks_the_generator() {
    // The ends of every range, in many combinations, on the smallest texture.
    let kinds =
        [Kind::Line, Kind::Dash, Kind::Stipple, Kind::Cross, Kind::Scribble, Kind::Dab, Kind::Halftone, Kind::Dots];
    for i in 0..if full() { 56_u32 } else { 8 } {
        let end =
            |bit: u32, low: f32, high: f32| if (i.wrapping_mul(0x9e37_79b9) >> bit) & 1 == 0 { low } else { high };
        let spacing_px = end(3, 2.0, 64.0);
        let recipe = Recipe {
            kind: kinds[i as usize % kinds.len()],
            side_px: 64,
            length_px: end(5, 1.0, 400.0),
            width_px: if end(7, 0.0, 1.0) == 0.0 { 1.0 } else { (0.9 * spacing_px).min(32.0) },
            spacing_px,
            wobble_px: end(9, 0.0, 16.0),
            taper: end(11, 0.0, 1.0),
            jitter: end(13, 0.0, 1.0),
            swell: end(15, 0.0, 1.0),
            pressure: end(17, 0.0, 1.0),
            grain: end(19, 0.0, 1.0),
            ..Recipe::parse("test", SMALL).unwrap()
        };
        let map = TonalArtMap::make(&recipe).unwrap();
        assert_eq!(map.thresholds.len(), 64 * 64);
        assert!(mean_error(&map) < 0.005, "{recipe:?}");
    }
}
