//! Chooses the options for opening the members of a mosaic that is drawn without baking.

use std::path::{Path, PathBuf};

use super::MosaicGrid;
use crate::source::{OpenOptions, VoidMode, open_reader_with};

/// Number of rows or columns that adjacent members may share: one, as tiles of SRTM do.
const SHARED_SAMPLES: i64 = 1;

/// Returns the options with which each member is opened. Holes are only filled in members that no other overlaps: a
/// no-data sample of an upper member may be land in a lower one.
pub(crate) fn member_options(files: &[PathBuf], options: &OpenOptions) -> Vec<OpenOptions> {
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

/// Returns the rectangle of each member in a common lattice (first column and row, then the ends); `None` if they have
/// no common lattice. Files that cannot be opened are reported when they are opened the next time.
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
