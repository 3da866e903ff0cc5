//! Colours that encode heights, and colours that are a picture.

use std::path::Path;

use hachure::source::{self, Encoding, HeightGrid, OpenOptions, Silent, SourceError};
use png::{BitDepth, ColorType};

use crate::write;

const SIZE: usize = 96;

/// Returns the height of hills that rise 3 to 9 metres per pixel.
fn height_m(column: usize, row: usize) -> f64 {
    700.0 + 200.0 * (column as f64 * 0.04).sin() + 90.0 * (row as f64 * 0.07 + column as f64 * 0.02).cos()
}

fn picture(path: &Path, colour: impl Fn(usize, usize) -> [u8; 3]) {
    let bytes: Vec<u8> = (0..SIZE * SIZE).flat_map(|index| colour(index % SIZE, index / SIZE)).collect();
    write::png(path, [SIZE, SIZE], ColorType::Rgb, BitDepth::Eight, &bytes);
}

fn packed(encoding: Encoding, column: usize, row: usize) -> [u8; 3] {
    let code = match encoding {
        Encoding::Mapbox => ((height_m(column, row) + 10_000.0) * 10.0) as u32,
        Encoding::Terrarium => ((height_m(column, row) + 32_768.0) * 256.0) as u32,
        Encoding::Gsi => (height_m(column, row) * 100.0) as u32,
    };
    [(code >> 16) as u8, (code >> 8) as u8, code as u8]
}

fn open(path: &Path, encoding: Option<Encoding>) -> Result<HeightGrid, SourceError> {
    let options = OpenOptions { encoding, ..OpenOptions::default() };
    source::read_all(&*source::open_reader_with(path, &options)?, path, &Silent)
}

fn is_right(grid: &HeightGrid) -> bool {
    let expected = |index: usize| height_m(index % SIZE, index / SIZE);
    grid.heights_m.iter().enumerate().all(|(index, height)| (f64::from(*height) - expected(index)).abs() < 0.11)
}

#[test]
fn carries_prove_heights() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    // Without a distance between samples, these hills could be gentler ones in GSI's steps.
    picture(&path, |column, row| packed(Encoding::Mapbox, column, row));
    let error = open(&path, None).unwrap_err().to_string();
    assert!(error.contains("mapbox (") && error.contains("gsi ("), "{error}");
    std::fs::write(folder.path().join("a.png.toml"), "spacing_m = 30").unwrap();
    for encoding in [Encoding::Mapbox, Encoding::Terrarium] {
        picture(&path, |column, row| packed(encoding, column, row));
        assert!(is_right(&open(&path, None).unwrap()), "{encoding:?}");
        // Planted error: a byte that runs the other way does not carry.
        picture(&path, |column, row| {
            let [red, green, blue] = packed(encoding, column, row);
            if encoding == Encoding::Mapbox { [red, green, 255 - blue] } else { [red, 255 - green, blue] }
        });
        assert!(open(&path, None).is_err(), "{encoding:?}");
    }
}

#[test]
fn pictures_prove_nothing_and_ask() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.png");
    let noise = |seed: usize| (seed.wrapping_mul(2_654_435_761) >> 13) as u8;
    let asks = |colour: &dyn Fn(usize, usize) -> [u8; 3]| {
        picture(&path, colour);
        let error = open(&path, None).unwrap_err().to_string();
        let name = path.display().to_string();
        assert!(
            error.starts_with(&name) && error.contains("--encoding") && error.contains("picture.png.toml"),
            "{error}"
        );
        assert!(error.len() - name.len() < 200, "{error}");
        error
    };
    // Dark blues and greens are heights of -10 km to 0 in the encoding `mapbox`.
    let blues = asks(&|column, row| [0, 90 + (column / 8) as u8, (row * 2) as u8]);
    assert!(blues.contains("--encoding mapbox or gsi ("), "{blues}");
    asks(&|column, _| [1, 30, column as u8]);
    asks(&|column, row| [1, 100 + noise(column * 97 + row) % 8, noise(row * 89 + column)]);
    // Greys and greens of a map are plausible heights in the encoding `terrarium`.
    let map = asks(&|column, row| [120 + (column / 12) as u8, 130 + (row / 2) as u8, 90]);
    assert!(map.contains("--encoding terrarium ("), "{map}");
    asks(&|column, row| [(column * 2) as u8, (row * 2) as u8, noise(column + row * 7)]);
    asks(&|_, _| [128, 0, 0]);
    // An encoding that is given is not questioned.
    let said = open(&path, Some(Encoding::Terrarium)).unwrap();
    assert!(said.heights_m.iter().all(|height| *height == 0.0));
    std::fs::write(folder.path().join("picture.png.toml"), "encoding = \"terrarium\"").unwrap();
    assert_eq!(open(&path, None).unwrap().heights_m, said.heights_m);
    let identity = |encoding| {
        let options = OpenOptions { encoding: Some(encoding), ..OpenOptions::default() };
        source::open_reader_with(&path, &options).unwrap().identity()
    };
    assert_ne!(identity(Encoding::Mapbox), identity(Encoding::Terrarium));
}

#[test]
fn the_drawings_of_the_documentation_are_no_heights() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    if root.join(".cargo_vcs_info.json").exists() {
        println!("skipped: a packed crate has no pictures of the documentation");
        return;
    }
    let folder = root.join("docs/pictures");
    let mut looked_at = 0;
    for path in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if path.extension().is_some_and(|ending| ending == "png") {
            assert!(open(&path, None).is_err(), "{} was read as heights", path.display());
            looked_at += 1;
        }
    }
    assert!(looked_at > 3);
}
