//! Comparison of a file with the grid that it should contain.

use std::path::Path;

use hachure::source::{self, HeightGrid, Silent};

use crate::dem::Dem;
use crate::write;

/// Describes the first difference.
pub(crate) fn compare(grid: &HeightGrid, dem: &Dem, crs_from_grid: [f64; 6]) -> Result<(), String> {
    if [grid.width as usize, grid.height as usize] != [dem.width, dem.height] {
        return Err(format!("the grid has {}×{} samples", grid.width, grid.height));
    }
    for (index, (ours, expected)) in grid.heights_m.iter().zip(dem.expected()).enumerate() {
        if !(ours.is_nan() && expected.is_nan() || *ours == expected) {
            return Err(format!("sample {index} is {ours}, not {expected}"));
        }
    }
    for (ours, expected) in grid.georeference.crs_from_grid.iter().zip(crs_from_grid) {
        if (ours - expected).abs() > 1e-12 * expected.abs().max(1.0) {
            return Err(format!("the grid is at {:?}, expected {crs_from_grid:?}", grid.georeference.crs_from_grid));
        }
    }
    Ok(())
}

/// Opens a file and compares it with the grid that was written to it.
pub(crate) fn check(path: &Path, dem: &Dem, crs_from_grid: [f64; 6]) -> HeightGrid {
    let grid = source::open(path, &Silent).unwrap_or_else(|error| panic!("{error}"));
    compare(&grid, dem, crs_from_grid).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    grid
}

#[test]
fn planted_errors_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let dem = Dem::new(40, 30, 3);
    let path = folder.path().join("dem.bil");
    let place = write::ehdr(&path, &dem, "I");
    check(&path, &dem, place);
    let bytes = std::fs::read(&path).unwrap();

    let found = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        compare(&source::open(&path, &Silent).unwrap(), &dem, place).unwrap_err()
    };
    let swapped: Vec<u8> = bytes.chunks(2).flat_map(|pair| [pair[1], pair[0]]).collect();
    assert!(found(&swapped).contains("sample"));
    let flipped: Vec<u8> = bytes.chunks(80).rev().flatten().copied().collect();
    assert!(found(&flipped).contains("sample"));
    let mut one_row = bytes.clone();
    one_row[5 * 80..6 * 80].reverse();
    one_row[5 * 80..6 * 80].chunks_mut(2).for_each(<[u8]>::reverse);
    assert!(
        found(&one_row).starts_with("sample 2"),
        "the first difference must be in row 5, whose first sample is 200"
    );

    std::fs::write(&path, &bytes).unwrap();
    let header = std::fs::read_to_string(path.with_extension("hdr")).unwrap();
    std::fs::write(path.with_extension("hdr"), header.replace("XDIM 30", "XDIM 31")).unwrap();
    let moved = compare(&source::open(&path, &Silent).unwrap(), &dem, place).unwrap_err();
    assert!(moved.starts_with("the grid is at"), "{moved}");
}
