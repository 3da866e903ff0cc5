//! Reading height files: every encoding, every odd file, and where the samples lie.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use hachure::source::{self, HeightGrid, Silent, SourceError};

/// The folder of the real data, or `None` with a word on why not.
fn data_folder() -> Option<PathBuf> {
    let folder = std::env::var_os("HACHURE_TEST_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data"), PathBuf::from);
    if !folder.join("dem").is_dir() {
        println!("skipped: no real data at {}", folder.display());
        return None;
    }
    Some(folder)
}

fn files_below(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() { folders.push(path) } else { files.push(path) }
        }
    }
    files.sort();
    files
}

fn open(path: &Path) -> Result<HeightGrid, SourceError> {
    source::open(path, &Silent)
}

fn is_tiff(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending == "tif" || ending == "tiff")
}

/// The message and its causes, one line each.
fn story(error: &SourceError) -> String {
    let mut story = error.to_string();
    let mut cause = std::error::Error::source(error);
    while let Some(error) = cause {
        story += &format!(" ← {error}");
        cause = error.source();
    }
    story
}

fn statistics(grid: &HeightGrid) -> (f32, f32, usize) {
    let heights = grid.heights_m.iter().copied().filter(|height| !height.is_nan());
    let (low, high) = heights.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)));
    (low, high, grid.heights_m.iter().filter(|height| height.is_nan()).count())
}

#[test]
fn odd_files_give_an_error_or_sane_heights() {
    let Some(data) = data_folder() else { return };
    let mut counts = [0, 0];
    for folder in ["dem_odd", "obj", "obj_odd", "dem"] {
        for path in files_below(&data.join(folder)) {
            let file_name = path.file_name().unwrap().to_string_lossy().into_owned();
            let start = Instant::now();
            let result = open(&path);
            let time = start.elapsed();
            assert!(time < Duration::from_secs(5), "{file_name}: {time:?}");
            match result {
                Ok(grid) => {
                    counts[0] += 1;
                    assert_eq!(grid.heights_m.len(), grid.width as usize * grid.height as usize, "{file_name}");
                    let (low, high, voids) = statistics(&grid);
                    assert!(low >= -1e6 && high <= 1e6 && low <= high, "{file_name}: {low}..{high}");
                    println!("{} {}x{} {low}..{high} {voids} voids {:?}", path.display(), grid.width, grid.height, grid.georeference.crs);
                }
                Err(error) => {
                    counts[1] += 1;
                    let message = error.to_string();
                    println!("{}", story(&error));
                    assert!(message.contains(&file_name), "{message}");
                    assert!(!message.contains('\n'), "{message}");
                }
            }
        }
    }
    println!("{counts:?} {}", is_tiff(Path::new("a.tif")));
}
