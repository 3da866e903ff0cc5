//! Finds holes (no-data samples and spikes that touch each other, also at corners), and decides whether they are
//! filled.

use super::Way;
use crate::source::reader::Window;

/// A hole that is to be filled: the ascending indices of its samples in the window in which it was found.
pub(super) struct Hole {
    pub samples: Vec<u32>,
    /// Bounding box of the samples, in columns and rows of that window.
    pub left: u32,
    pub top: u32,
    pub width: u32,
    pub height: u32,
}

/// Returns the holes that have a sample in `within` and are to be filled. `spikes` must be ascending.
pub(super) fn find(heights_m: &[f32], spikes: &[u32], around: Window, within: Window, way: &Way) -> Vec<Hole> {
    let mut open: Vec<bool> = heights_m.iter().map(|height_m| !height_m.is_finite()).collect();
    spikes.iter().for_each(|&spike| open[spike as usize] = true);
    let (left, top) = (within.x - around.x, within.y - around.y);
    let mut holes = Vec::new();
    for y in top..top + within.height {
        for x in left..left + within.width {
            let start = y * around.width + x;
            if open[start as usize] {
                let hole = flood(&mut open, around, start);
                let is_small = hole.width.max(hole.height) <= way.limits.extent;
                if is_small && is_closed(&hole, around, way.size) && !is_wide(&hole, around, way.limits.width) {
                    holes.push(hole);
                }
            }
        }
    }
    holes
}

/// Removes the hole around a sample from `open` and returns it.
fn flood(open: &mut [bool], around: Window, start: u32) -> Hole {
    let (mut left, mut top) = (around.width, around.height);
    let (mut right, mut bottom) = (0, 0);
    let mut samples = vec![start];
    open[start as usize] = false;
    let mut next = 0;
    while next < samples.len() {
        let (x, y) = (samples[next] % around.width, samples[next] / around.width);
        next += 1;
        (left, right) = (left.min(x), right.max(x));
        (top, bottom) = (top.min(y), bottom.max(y));
        for row in y.saturating_sub(1)..(y + 2).min(around.height) {
            for column in x.saturating_sub(1)..(x + 2).min(around.width) {
                let index = row * around.width + column;
                if std::mem::take(&mut open[index as usize]) {
                    samples.push(index);
                }
            }
        }
    }
    samples.sort_unstable();
    Hole { samples, left, top, width: right - left + 1, height: bottom - top + 1 }
}

/// Returns whether land is on all sides: the hole does not touch the border of the grid.
fn is_closed(hole: &Hole, around: Window, size: [u32; 2]) -> bool {
    let (x, y) = (around.x + hole.left, around.y + hole.top);
    x > 0 && y > 0 && x + hole.width < size[0] && y + hole.height < size[1]
}

/// Returns whether a hole contains a square of more than `most` samples. The largest square that ends at a sample is
/// one more than the smallest of those that end to the left of it, above it, and both.
fn is_wide(hole: &Hole, around: Window, most: u32) -> bool {
    if hole.width.min(hole.height) <= most {
        return false;
    }
    let row_size = hole.width as usize + 1;
    let mut sides = vec![0u32; row_size * (hole.height as usize + 1)];
    hole.samples.iter().any(|sample| {
        let (x, y) = (sample % around.width - hole.left, sample / around.width - hole.top);
        let at = (y as usize + 1) * row_size + x as usize + 1;
        sides[at] = 1 + sides[at - 1].min(sides[at - row_size]).min(sides[at - row_size - 1]);
        sides[at] > most
    })
}
