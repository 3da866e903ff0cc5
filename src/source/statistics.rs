//! Computes the lowest and highest height and the number of no-data samples of a grid of any size, by windows: memory
//! depends on the window, not on the grid. Heights that are known without reading, such as the blocks that a sparse
//! file leaves out, are not read.

use std::path::Path;

use rayon::prelude::*;

use super::reader::{HeightReader, Window};
use super::voids::{self, Filled, FilledSamples};
use super::{Progress, SourceError};

/// Largest number of samples in a window, unless blocks are larger: 4 MiB of heights.
const WINDOW_SAMPLES: u64 = 1 << 20;
/// Largest number of samples in all windows that are read at a time, unless a single one has more.
const SAMPLES_AT_ONCE: u64 = 1 << 24;

/// Statistics of the heights of a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics {
    /// The lowest height in metres.
    pub min_m: f32,
    /// The highest height in metres.
    pub max_m: f32,
    /// Column and row of the highest sample; of several, the first one of the first row.
    pub highest: Option<[u32; 2]>,
    /// Samples without a height.
    pub void_samples: u64,
    /// First column and row with a height, and the last.
    pub bounds: Option<[[u32; 2]; 2]>,
    /// Number of no-data samples that are filled, and of spikes that are replaced, if the reader fills holes.
    pub filled: FilledSamples,
    /// Lowest and highest height with the filled samples, in metres, if any are filled: a filled summit may be higher
    /// than all samples around it.
    pub filled_m: Option<[f32; 2]>,
}

impl Statistics {
    /// The statistics of no samples; `f32::min` and `max` return the other operand for NaN.
    const NONE: Self = Self {
        min_m: f32::NAN,
        max_m: f32::NAN,
        highest: None,
        void_samples: 0,
        bounds: None,
        filled: FilledSamples { voids: 0, spikes: 0 },
        filled_m: None,
    };

    fn of(heights_m: &[f32], window: Window) -> Self {
        let mut found = heights_m.iter().fold(Self::NONE, |found, &height_m| Self {
            min_m: found.min_m.min(height_m),
            max_m: found.max_m.max(height_m),
            void_samples: found.void_samples + u64::from(height_m.is_nan()),
            ..found
        });
        for (row, heights_m) in (window.y..).zip(heights_m.chunks_exact(window.width.max(1) as usize)) {
            let is_height = |height_m: &f32| !height_m.is_nan();
            let ends = heights_m.iter().position(is_height).zip(heights_m.iter().rposition(is_height));
            let of_row = ends.map(|(first, last)| [[window.x + first as u32, row], [window.x + last as u32, row]]);
            found.bounds = joined(found.bounds, of_row);
            if found.highest.is_none()
                && let Some(column) = heights_m.iter().position(|height_m| *height_m == found.max_m)
            {
                found.highest = Some([window.x + column as u32, row]);
            }
        }
        found
    }

    fn of_constant(height_m: f32, window: Window) -> Self {
        if height_m.is_nan() {
            return Self { void_samples: samples(window), ..Self::NONE };
        }
        let last = [window.x + window.width - 1, window.y + window.height - 1];
        let first = [window.x, window.y];
        Self { min_m: height_m, max_m: height_m, highest: Some(first), bounds: Some([first, last]), ..Self::NONE }
    }

    fn with(self, other: Self) -> Self {
        Self {
            min_m: self.min_m.min(other.min_m),
            max_m: self.max_m.max(other.max_m),
            highest: higher(&self, &other),
            void_samples: self.void_samples + other.void_samples,
            bounds: joined(self.bounds, other.bounds),
            filled: self.filled,
            filled_m: self.filled_m,
        }
    }
}

/// Returns the place of the higher one of the highest samples of two windows.
fn higher(a: &Statistics, b: &Statistics) -> Option<[u32; 2]> {
    let (Some(of_a), Some(of_b)) = (a.highest, b.highest) else { return a.highest.or(b.highest) };
    let is_first = [of_a[1], of_a[0]] <= [of_b[1], of_b[0]];
    let is_a = a.max_m > b.max_m || (a.max_m == b.max_m && is_first);
    Some(if is_a { of_a } else { of_b })
}

/// Returns the bounds of two areas.
fn joined(a: Option<[[u32; 2]; 2]>, b: Option<[[u32; 2]; 2]>) -> Option<[[u32; 2]; 2]> {
    let (Some([low_a, high_a]), Some([low_b, high_b])) = (a, b) else { return a.or(b) };
    Some([[0, 1].map(|i| low_a[i].min(low_b[i])), [0, 1].map(|i| high_a[i].max(high_b[i]))])
}

/// Reads all samples of a reader, one window at a time; `path` is the name in errors. For a reader that fills holes,
/// these are the statistics of the unfilled file, plus the number of filled samples.
///
/// # Errors
/// Passes on the errors of the reader; returns [`SourceError::AllNoData`] for a grid without a single height.
pub fn statistics(reader: &dyn HeightReader, path: &Path, progress: &dyn Progress) -> Result<Statistics, SourceError> {
    let mut found = of_file(reader.filled().map_or(reader, Filled::bare), path, progress)?;
    if let Some(filled) = reader.filled().filter(|_| found.void_samples > 0) {
        let range_m;
        (found.filled, range_m) = voids::count(filled, &|done| progress.report("filling holes", done))?;
        let is_filled = found.filled != FilledSamples::default();
        found.filled_m = is_filled.then(|| [found.min_m.min(range_m[0]), found.max_m.max(range_m[1])]);
    }
    Ok(found)
}

fn of_file(reader: &dyn HeightReader, path: &Path, progress: &dyn Progress) -> Result<Statistics, SourceError> {
    let [width, height] = reader.size();
    let whole = Window::whole([width, height]);
    let is_serial = reader.is_serial();
    let mut found = Statistics::NONE;
    let (mut done, mut group_samples) = (0u64, 0);
    let mut group = Vec::new();
    // A stack: the first of two parts is pushed last, so that windows come from the top down.
    let mut waiting = vec![whole];
    loop {
        let next = waiting.pop();
        if let Some(window) = next {
            if let Some(height_m) = reader.known_m(window) {
                found = found.with(Statistics::of_constant(height_m, window));
                done += samples(window);
                continue;
            }
            if samples(window) > WINDOW_SAMPLES
                && let Some([first, second]) = split(window, reader.block(), is_serial)
            {
                waiting.extend([second, first]);
                continue;
            }
            group.push(window);
            group_samples += samples(window);
        }
        // The group must not grow beyond the limit by another window of the largest size.
        let is_full = group_samples + WINDOW_SAMPLES > SAMPLES_AT_ONCE;
        if is_full || next.is_none() {
            found = found.with(read(reader, &group, is_serial)?);
            done += group_samples;
            group_samples = 0;
            group.clear();
            progress.report("reading heights", done as f32 / samples(whole) as f32);
        }
        if next.is_none() {
            break;
        }
    }
    match found.min_m.is_nan() {
        true => Err(SourceError::AllNoData { path: path.into() }),
        false => Ok(found),
    }
}

fn samples(window: Window) -> u64 {
    u64::from(window.width) * u64::from(window.height)
}

fn read(reader: &dyn HeightReader, windows: &[Window], is_serial: bool) -> Result<Statistics, SourceError> {
    let of = |window: &Window| Ok(Statistics::of(&reader.read(*window)?, *window));
    match is_serial {
        true => windows.iter().try_fold(Statistics::NONE, |found, window| Ok(found.with(of(window)?))),
        false => windows.par_iter().map(of).try_reduce(|| Statistics::NONE, |a, b| Ok(a.with(b))),
    }
}

/// Splits a window into two parts, in the order of the file. They meet at a block border; a single block is split by
/// rows, but only if its parts are read one after the other.
fn split(window: Window, [columns, rows]: [u32; 2], is_serial: bool) -> Option<[Window; 2]> {
    let across = window.width.div_ceil(columns.max(1));
    let down = window.height.div_ceil(rows.max(1));
    // A window of several blocks begins at a block border, so that its blocks are counted from its own corner.
    let (width, height) = match (across, down) {
        (1, 1) if is_serial && window.height > 1 => (window.width, window.height / 2),
        (1, 1) => return None,
        // Strips, and rows of a stream, are not split.
        _ if down >= across => (window.width, down / 2 * rows),
        _ => (across / 2 * columns, window.height),
    };
    let first = Window { width, height, ..window };
    let second = match height < window.height {
        true => Window { y: window.y + height, height: window.height - height, ..window },
        false => Window { x: window.x + width, width: window.width - width, ..window },
    };
    Some([first, second])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns all windows into which a grid is split.
    fn leaves(size: [u32; 2], block: [u32; 2], is_serial: bool) -> Vec<Window> {
        let mut waiting = vec![Window::whole(size)];
        let mut leaves = Vec::new();
        while let Some(window) = waiting.pop() {
            match split(window, block, is_serial) {
                Some([first, second]) => waiting.extend([second, first]),
                None => leaves.push(window),
            }
        }
        leaves
    }

    #[test]
    fn a_grid_is_taken_apart_into_its_blocks() {
        for (size, block) in [([1000, 700], [256, 256]), ([1000, 700], [1000, 16]), ([33, 1000], [16, 1000])] {
            let found = leaves(size, block, false);
            let expected = size[0].div_ceil(block[0]) * size[1].div_ceil(block[1]);
            assert_eq!(found.len(), expected as usize, "{size:?} {block:?}");
            assert_eq!(found.iter().map(|it| samples(*it)).sum::<u64>(), u64::from(size[0] * size[1]));
            assert!(found.iter().all(|it| it.x % block[0] == 0 && it.y % block[1] == 0));
        }
    }

    #[test]
    fn serial_files_are_read_from_the_top_down() {
        let found = leaves([100, 1000], [100, 64], true);
        assert!(found.windows(2).all(|pair| pair[0].y + pair[0].height == pair[1].y), "{found:?}");
        assert_eq!(found.len(), 1000);
    }
}
