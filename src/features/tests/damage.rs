//! Damaged files give an error of one line, or fewer features; never a panic.

use super::super::Feature;
use super::{Folder, Random, differences, read_all, samples, writers};

/// Returns a file of every format.
fn files(folder: &Folder) -> Vec<(&'static str, Vec<u8>)> {
    let features = samples(true);
    let database = folder.path("whole.gpkg");
    writers::geopackage(&database, &features);
    vec![
        ("a.geojson", writers::geojson(&features).into_bytes()),
        ("a.gpx", writers::gpx(&features).into_bytes()),
        ("a.csv", writers::csv(&features, ';').into_bytes()),
        ("a.fgb", writers::flatgeobuf(&features, true, true)),
        ("a.gpkg", std::fs::read(database).unwrap()),
    ]
}

/// Reads a file that may be damaged; returns its features if it can be read.
fn attempt(folder: &Folder, name: &str, bytes: &[u8]) -> Option<Vec<Feature>> {
    let path = folder.write(name, bytes);
    match read_all(&path, None) {
        Ok((features, _)) => Some(features),
        Err(error) => {
            let text = error.to_string();
            assert!(text.starts_with(&format!("{}: ", path.display())), "{text}");
            assert!(!text.contains('\n') && text.chars().count() < 700, "{text}");
            None
        }
    }
}

#[test]
fn truncated_files_are_refused() {
    let folder = Folder::new();
    for (name, bytes) in files(&folder) {
        let whole = attempt(&folder, name, &bytes).unwrap();
        let step = if bytes.len() > 20_000 { 61 } else { 7 };
        for length in (0..bytes.len()).step_by(step).chain(bytes.len().saturating_sub(40)..bytes.len()) {
            let Some(found) = attempt(&folder, name, &bytes[..length]) else { continue };
            // The rows of a CSV file before its end are complete; the last may be cut anywhere.
            let is_whole = differences(&whole, &found).is_empty();
            assert!(is_whole || name == "a.csv" && found.len() <= whole.len(), "{name}, {length} bytes: {found:?}");
        }
    }
}

#[test]
fn changed_bytes_cause_no_panic() {
    let folder = Folder::new();
    let mut random = Random(0x2545_f491_4f6c_dd1d);
    for (name, bytes) in files(&folder) {
        let mut refused = 0;
        for _ in 0..1500 {
            let mut damaged = bytes.clone();
            for _ in 0..1 + random.below(6) {
                let place = match random.below(3) {
                    // Headers are most sensitive.
                    0 => random.below(damaged.len().min(600)),
                    _ => random.below(damaged.len()),
                };
                damaged[place] = match random.below(4) {
                    0 => 0xff,
                    1 => 0,
                    2 => damaged[place] ^ (1 << random.below(8)),
                    _ => random.next() as u8,
                };
            }
            refused += u32::from(attempt(&folder, name, &damaged).is_none());
        }
        assert!(refused > 100, "{name}: only {refused} refused");
    }
    assert_eq!(folder.names(), ["a.csv", "a.fgb", "a.geojson", "a.gpkg", "a.gpx", "whole.gpkg"], "no file is left");
}
