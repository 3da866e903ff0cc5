//! Tests reading height files: every encoding and every odd file, compared with what GDAL reads.
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a test may panic, and writes to scratch folders")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use hachure::source::{self, Encoding, HeightGrid, OpenOptions, Progress, Silent, SourceError};

/// Returns the folder of the real data, or `None` with a printed reason.
fn data_folder() -> Option<PathBuf> {
    let folder = std::env::var_os("HACHURE_TEST_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data"), PathBuf::from);
    if folder.join("dem").is_dir() {
        return Some(folder);
    }
    println!("skipped: no real data at {}", folder.display());
    None
}

fn files_below(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}

/// Opens a file, and checks that the result keeps the guarantees of `source::open`.
fn open_checked(path: &Path) -> Result<HeightGrid, SourceError> {
    let start = Instant::now();
    // Its colours may be GSI's as well, so that it needs the option.
    let encoding = path.ends_with("rainier_mapbox_rgb.png").then_some(Encoding::Mapbox);
    let options = OpenOptions { encoding, ..OpenOptions::default() };
    assert!(encoding.is_none() || source::open(path, &Silent).is_err(), "{}: was guessed", path.display());
    let result = source::open_reader_with(path, &options).and_then(|reader| source::read_all(&*reader, path, &Silent));
    let time = start.elapsed();
    assert!(time < Duration::from_secs(30), "{}: {time:?}", path.display());
    match &result {
        Ok(grid) => {
            assert!(grid.width >= 2 && grid.height >= 2);
            assert_eq!(grid.heights_m.len(), grid.width as usize * grid.height as usize, "{}", path.display());
            let finite = grid.heights_m.iter().filter(|height| !height.is_nan());
            assert!(finite.clone().count() > 0, "{}", path.display());
            assert!(finite.into_iter().all(|height| height.abs() <= 1e6), "{}", path.display());
            assert!(grid.georeference.crs_from_grid.iter().all(|value| value.is_finite()), "{}", path.display());
        }
        Err(error) => {
            let message = error.to_string();
            // The message may name the data file of a header, which has another extension.
            let file_stem = path.file_stem().unwrap().to_string_lossy();
            assert!(message.contains(&*file_stem), "{message}");
            assert!(!message.contains('\n'), "{message}");
            // A failure inside a decoder is a bug, even though the caller gets an error and not a panic.
            assert!(!message.contains("its decoder failed"), "{message}");
        }
    }
    result
}

/// Returns the number of no-data samples, the sum and the weighted sum, as `tests/golden/heights.csv` defines them.
fn checksums(grid: &HeightGrid) -> (usize, f64, f64) {
    let (mut voids, mut sum, mut weighted_sum) = (0, 0.0, 0.0);
    for (index, height) in grid.heights_m.iter().enumerate() {
        if height.is_nan() {
            voids += 1;
        } else {
            sum += f64::from(*height);
            weighted_sum += f64::from(*height) * (index % 97 + 1) as f64;
        }
    }
    (voids, sum, weighted_sum)
}

struct Golden {
    size: (u32, u32),
    voids: usize,
    sums: [f64; 2],
    first_sample: [f64; 2],
}

fn golden() -> BTreeMap<&'static str, Golden> {
    let lines = include_str!("../../tests/golden/heights.csv").lines().filter(|line| !line.starts_with('#')).skip(1);
    let parse = |line: &'static str| {
        let fields: Vec<&str> = line.split(',').collect();
        let number = |index: usize| fields[index].parse::<f64>().unwrap();
        let size = (number(1) as u32, number(2) as u32);
        let (sums, first_sample) = ([number(4), number(5)], [number(6), number(7)]);
        (fields[0], Golden { size, voids: number(3) as usize, sums, first_sample })
    };
    lines.map(parse).collect()
}

#[test]
fn every_file_of_the_collection_is_read_as_gdal_reads_it_or_refused() {
    let Some(data) = data_folder() else { return };
    let mut golden = golden();
    for folder in ["dem", "dem_odd", "obj", "obj_odd"] {
        for path in files_below(&data.join(folder)) {
            let name = path.strip_prefix(&data).unwrap().to_string_lossy().into_owned();
            match (open_checked(&path), golden.remove(name.as_str())) {
                (Ok(grid), Some(golden)) => {
                    let (voids, sum, weighted_sum) = checksums(&grid);
                    // JPEG decoders may round differently.
                    let tolerance = if name.contains("JPEG") { 1e-3 } else { 1e-9 };
                    assert_eq!(((grid.width, grid.height), voids), (golden.size, golden.voids), "{name}");
                    for (ours, theirs) in [sum, weighted_sum].into_iter().zip(golden.sums) {
                        assert!((ours - theirs).abs() <= tolerance * theirs.abs(), "{name}: {ours} but GDAL {theirs}");
                    }
                    let [x, _, _, y, ..] = grid.georeference.crs_from_grid;
                    for (ours, theirs) in [x, y].into_iter().zip(golden.first_sample) {
                        assert!(
                            (ours - theirs).abs() <= 1e-12 * theirs.abs() + 1e-9,
                            "{name}: {ours}, expected {theirs}"
                        );
                    }
                }
                (Ok(_), None) => panic!("{name}: was read, but has no reference in heights.csv"),
                (Err(error), Some(_)) => panic!("{error}"),
                (Err(_), None) => {}
            }
        }
    }
    assert!(golden.is_empty(), "files with a reference that were not found: {:?}", golden.keys());
}

#[test]
fn every_encoding_gives_the_same_heights() {
    let Some(data) = data_folder() else { return };
    let folder = data.join("dem/encodings_rainier");
    let bits = |grid: &HeightGrid| grid.heights_m.iter().map(|height| height.to_bits()).collect::<Vec<_>>();
    let reference = open_checked(&folder.join("strip_none_i16.tif")).unwrap();
    assert_eq!((reference.width, reference.height, checksums(&reference).0), (500, 400, 4199));
    let mut compared = 0;
    for path in files_below(&folder) {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        // These files are other grids of the same mountain.
        let is_other = ["utm", "webmercator", "scale"].iter().any(|prefix| name.starts_with(prefix));
        if !name.ends_with(".tif") || is_other {
            continue;
        }
        let grid = open_checked(&path).unwrap();
        assert!(bits(&grid) == bits(&reference), "{name}");
        assert_eq!(grid.georeference.crs_from_grid, reference.georeference.crs_from_grid, "{name}");
        compared += 1;
    }
    assert_eq!(compared, 16);
    let scaled = open_checked(&folder.join("scale_0.3048_f32.tif")).unwrap();
    for (scaled, height) in scaled.heights_m.iter().zip(&reference.heights_m) {
        assert!(scaled.is_nan() && height.is_nan() || (scaled - height * 0.3048).abs() < 1e-3);
    }
}

#[test]
fn what_is_no_height_file_is_called_by_its_name() {
    let scratch = tempfile::tempdir().unwrap();
    let message = |name: &str, bytes: &[u8]| {
        let path = scratch.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        open_checked(&path).unwrap_err().to_string()
    };
    assert!(message("empty.tif", b"").ends_with("empty.tif: is empty"));
    // The content decides, although the extension says TIFF.
    let jpeg = message("picture.tif", b"\xff\xd8\xff\xe0\0\x10JFIF");
    assert!(jpeg.contains("picture.tif: is a JPEG picture; hachure reads GeoTIFF"), "{jpeg}");
    assert!(message("png.tif", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR").contains("png.tif: is damaged"));
    assert!(message("grid.tif", b"NCOLS 2\nNROWS 2\n").contains("is damaged: it ends in its header"));
    assert!(message("short.tif", b"II*\0").contains("damaged or truncated"));
    assert!(message("noise", &[0; 100]).contains("is not a known format"));
    assert!(message("notes.txt", b"some words\nand more\n").contains("is a text file"));
    assert!(message("tile.hgt", &vec![0; 1201 * 1201 * 2]).contains("must give its position"));

    let absent = source::open(&scratch.path().join("absent.tif"), &Silent).unwrap_err();
    assert!(matches!(absent, SourceError::Open { .. }) && absent.to_string().contains("absent.tif"), "{absent}");
    assert!(std::error::Error::source(&absent).is_some());
    assert!(matches!(source::open(scratch.path(), &Silent), Err(SourceError::NotAFile { .. })));
}

#[test]
fn progress_runs_from_nothing_to_all() {
    struct Record(std::sync::Mutex<Vec<f32>>);
    impl Progress for Record {
        fn report(&self, _what: &str, done: f32) {
            self.0.lock().unwrap().push(done);
        }
    }
    let Some(data) = data_folder() else { return };
    let record = Record(std::sync::Mutex::default());
    source::open(&data.join("dem/geotiff/mt_rainier_90m.tif"), &record).unwrap();
    let reports = record.0.into_inner().unwrap();
    assert_eq!((reports.first(), reports.last()), (Some(&0.0), Some(&1.0)));
    assert!(reports.is_sorted());
}
