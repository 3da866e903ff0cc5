//! How the members of a mosaic are opened that is drawn as it is.

use std::path::{Path, PathBuf};

use super::MosaicGrid;
use crate::source::{OpenOptions, VoidMode, open_reader_with};

/// Members may share so many rows or columns and still lie side by side: one, as tiles of SRTM do.
const SHARED_SAMPLES: i64 = 1;

/// The options with which each member is opened. Only those that no other overlaps are filled: a void of the others may
/// be land in one that lies under them.
pub fn member_options(files: &[PathBuf], options: &OpenOptions) -> Vec<OpenOptions> {
    if files.len() < 2 || options.voids == VoidMode::Holes {
        return vec![*options; files.len()];
    }
    let bare = OpenOptions { voids: VoidMode::Holes, ..*options };
    let apart = rectangles(files, &bare).map(|all| {
        let overlap = |a: &[i64; 4], b: &[i64; 4]| {
            (0..2).all(|axis| a[axis + 2].min(b[axis + 2]) - a[axis].max(b[axis]) > SHARED_SAMPLES)
        };
        let is_apart = |i: usize| (0..all.len()).all(|other| other == i || !overlap(&all[i], &all[other]));
        (0..all.len()).map(is_apart).collect::<Vec<bool>>()
    });
    let apart = apart.unwrap_or_else(|| vec![false; files.len()]);
    apart.into_iter().map(|is_apart| if is_apart { *options } else { bare }).collect()
}

/// Columns and rows from and to of each member in one lattice; none where they have none in common. What cannot be opened
/// is told by whoever opens it next.
fn rectangles(files: &[PathBuf], bare: &OpenOptions) -> Option<Vec<[i64; 4]>> {
    let open = |file: &PathBuf| open_reader_with(Path::new(file), bare).ok();
    let readers = files.iter().map(open).collect::<Option<Vec<_>>>()?;
    let places: Vec<_> = readers.iter().map(|reader| (reader.georeference(), reader.size())).collect();
    let grid = MosaicGrid::new(&places).ok()?;
    let rectangle = |(placed, (_, size)): (&super::Placed, &(_, [u32; 2]))| {
        let [x, y] = placed.shift()?;
        Some([x, y, x + i64::from(size[0]), y + i64::from(size[1])])
    };
    grid.members.iter().zip(&places).map(rectangle).collect()
}
