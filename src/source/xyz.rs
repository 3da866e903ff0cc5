//! XYZ: one line per point with easting, northing and height. The points must form a complete regular grid by rows, as
//! GDAL and mapping agencies write it. Separators are spaces, tabs, commas or semicolons; the first line may hold
//! names. Numbers may have decimal commas, unless commas separate them.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use super::SourceError;
use super::memory::{self, MemoryReader};
use super::place::{self, cannot_open, inconsistent, unclear};
use super::prj;
use super::samples::{Meaning, SampleType, Tally, WarnOnce};
use super::text::number;

/// Largest length of a line in bytes.
const MAX_LINE_BYTES: u64 = 4096;
/// Largest number of points in a row.
const MAX_COLUMNS: usize = 1 << 24;
/// Largest deviation of a point from its position in the grid, as a fraction of the spacing.
const TOLERANCE: f64 = 0.01;

/// Returns whether a text begins as XYZ does; `is_whole` is true if the text is the whole file.
pub(super) fn is_beginning(text: &str, is_whole: bool) -> bool {
    let end = if is_whole { text.len() } else { text.rfind('\n').unwrap_or(0) };
    let lines: Vec<&str> = text[..end].lines().filter(|line| !line.trim().is_empty()).collect();
    lines.len() > 3 && lines[1..].iter().all(|line| point(line).is_some())
}

fn point(line: &str) -> Option<[f64; 3]> {
    let line = line.trim_start_matches('\u{feff}');
    // Where semicolons or spaces separate three numbers, a comma between digits is a decimal comma.
    let is_inside = |word: &str| word.trim_matches(',').contains(',');
    let words = || line.split(|c: char| c.is_whitespace() || c == ';').filter(|it| !it.is_empty());
    let has_decimal_commas = words().nth(2).is_some() && words().take(3).any(is_inside);
    let point = if has_decimal_commas {
        three(words(), number)?
    } else {
        let words = line.split(|c: char| c.is_whitespace() || matches!(c, ',' | ';')).filter(|it| !it.is_empty());
        three(words, |word| word.parse().ok())?
    };
    (point[0].is_finite() && point[1].is_finite()).then_some(point)
}

fn three<'a>(mut words: impl Iterator<Item = &'a str>, number: impl Fn(&str) -> Option<f64>) -> Option<[f64; 3]> {
    let mut next = || number(words.next()?);
    Some([next()?, next()?, next()?])
}

/// The columns and rows of the grid, collected as points arrive.
#[derive(Default)]
struct Grid {
    /// Eastings of the first row.
    eastings: Vec<f64>,
    /// Northing of the first point of each row.
    northings: Vec<f64>,
    count: usize,
}

impl Grid {
    /// Adds the next point; returns false if it does not continue a complete grid by rows.
    fn take(&mut self, x: f64, y: f64) -> bool {
        let Some(&row_y) = self.northings.last() else {
            self.eastings.push(x);
            self.northings.push(y);
            self.count = 1;
            return true;
        };
        let width = self.eastings.len();
        if self.northings.len() == 1 && y == row_y {
            if width == MAX_COLUMNS {
                return false;
            }
            self.eastings.push(x);
        } else {
            let column = self.count % width;
            let spacing = (self.eastings[width - 1] - self.eastings[0]).abs() / (width as f64 - 1.0);
            // A single column means a grid by columns, which is not supported.
            if width < 2 || (x - self.eastings[column]).abs() > TOLERANCE * spacing {
                return false;
            }
            match column {
                0 => self.northings.push(y),
                _ if (y - row_y).abs() > TOLERANCE * spacing => return false,
                _ => {}
            }
        }
        self.count += 1;
        true
    }
}

/// Returns the first number and the spacing of evenly spaced numbers.
fn even(numbers: &[f64]) -> Option<[f64; 2]> {
    let (first, last) = (*numbers.first()?, *numbers.last()?);
    let step = (last - first) / (numbers.len() as f64 - 1.0);
    let is_even =
        |(index, number): (usize, &f64)| (number - (first + index as f64 * step)).abs() <= TOLERANCE * step.abs();
    (step != 0.0 && step.is_finite() && numbers.iter().enumerate().all(is_even)).then_some([first, step])
}

/// Reserves an eighth more memory instead of doubling it: the number of points is only known at the end.
fn grow(path: &Path, heights_m: &mut Vec<f32>) -> Result<(), SourceError> {
    if heights_m.len() as u64 >= memory::MAX_SAMPLES {
        return Err(unclear(path, "has more points than can be read at once; convert it to GeoTIFF"));
    }
    let more = heights_m.len() / 8 + (1 << 16);
    let needed_bytes = 4 * (heights_m.len() + more) as u64;
    heights_m.try_reserve_exact(more).map_err(|_| memory::lacking(path, [heights_m.len() as u32, 1], needed_bytes))
}

/// Reads a grid.
pub(super) fn open(path: &Path) -> Result<MemoryReader, SourceError> {
    let irregular =
        || unclear(path, "its points are not a complete regular grid by rows; convert it to GeoTIFF (gdal_grid)");
    let mut reader = BufReader::with_capacity(1 << 18, File::open(path).map_err(cannot_open(path))?);
    let (mut grid, mut heights_m, mut tally) = (Grid::default(), Vec::new(), Tally::default());
    let meaning = Meaning::metres(SampleType::F64, None);
    let mut line = Vec::new();
    for number in 0_u64.. {
        line.clear();
        reader.by_ref().take(MAX_LINE_BYTES).read_until(b'\n', &mut line).map_err(cannot_open(path))?;
        if line.is_empty() {
            break;
        }
        if line.len() as u64 == MAX_LINE_BYTES {
            return Err(inconsistent(path, format!("line {} is longer than any point", number + 1)));
        }
        let line = String::from_utf8_lossy(&line);
        if line.trim().is_empty() {
            continue;
        }
        let Some([x, y, z]) = point(&line) else {
            if number == 0 {
                continue;
            }
            return Err(inconsistent(path, format!("line {} is not a point", number + 1)));
        };
        if !grid.take(x, y) {
            return Err(irregular());
        }
        if heights_m.len() == heights_m.capacity() {
            grow(path, &mut heights_m)?;
        }
        heights_m.push(meaning.height_m(z, &mut tally));
    }
    WarnOnce::default().warn(path, &tally);
    let (Ok(width), Ok(height)) = (u32::try_from(grid.eastings.len()), u32::try_from(grid.northings.len())) else {
        return Err(irregular());
    };
    let size = [width, height];
    place::check_size(path, size)?;
    if heights_m.len() != width as usize * height as usize {
        return Err(inconsistent(path, "it is truncated: its last row is incomplete"));
    }
    let [x0, dx] = even(&grid.eastings).ok_or_else(irregular)?;
    let [y0, dy] = even(&grid.northings).ok_or_else(irregular)?;
    let crs_from_grid = [x0, dx, 0.0, y0, 0.0, dy];
    let (keys, prj) = prj::keys(path, crs_from_grid, size)?;
    let georeference = place::locate(path, crs_from_grid, keys, size)?;
    let files: Vec<&Path> = std::iter::once(path).chain(prj.as_deref()).collect();
    let identity = place::identity(&files, "");
    Ok(MemoryReader { path: path.into(), size, heights_m, unit_m: 1.0, georeference, identity })
}
