//! XYZ: one line per point with easting, northing and height. The points must form a complete regular grid by rows, as
//! GDAL and mapping agencies write it. Separators are spaces, tabs, commas or semicolons; the first line may hold
//! names, which give the order of the columns. Numbers may have decimal commas, unless commas separate them.

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
    let order = lines.first().and_then(|line| order(line)).unwrap_or(USUAL);
    lines.len() > 3 && lines[1..].iter().all(|line| point(line, order).is_some())
}

/// The columns of easting, northing and height, counted from 0.
type Order = [usize; 3];

/// The order without a header that says otherwise.
const USUAL: Order = [0, 1, 2];

/// Names of the three columns in a header, in lower case.
const NAMES: [&[&str]; 3] = [
    &["x", "e", "east", "easting", "lon", "long", "longitude", "lng", "x_coord", "xcoord", "coord_x"],
    &["y", "n", "north", "northing", "lat", "latitude", "y_coord", "ycoord", "coord_y"],
    &["z", "h", "height", "elevation", "elev", "alt", "altitude", "dem", "value", "heights", "z_coord", "zcoord"],
];

/// Returns the order of the columns that a header names; `None` if it does not name all of them, each once.
fn order(header: &str) -> Option<Order> {
    let header = header.trim_start_matches('\u{feff}').trim_start_matches('#').to_lowercase();
    let is_separator = |c: char| c.is_whitespace() || matches!(c, ',' | ';');
    let names: Vec<&str> =
        header.split(is_separator).map(|name| name.trim_matches(['"', '\''])).filter(|name| !name.is_empty()).collect();
    let place = |known: &[&str]| {
        let mut found = names.iter().enumerate().filter(|(_, name)| known.contains(name)).map(|(column, _)| column);
        found.next().filter(|_| found.next().is_none())
    };
    Some([place(NAMES[0])?, place(NAMES[1])?, place(NAMES[2])?])
}

fn point(line: &str, order: Order) -> Option<[f64; 3]> {
    let line = line.trim_start_matches('\u{feff}');
    // Where semicolons or spaces separate three numbers, a comma between digits is a decimal comma.
    let is_inside = |word: &str| word.trim_matches(',').contains(',');
    let words = || line.split(|c: char| c.is_whitespace() || c == ';').filter(|it| !it.is_empty());
    let has_decimal_commas = words().nth(2).is_some() && words().take(3).any(is_inside);
    let point = if has_decimal_commas {
        three(words(), order, number)?
    } else {
        let words = line.split(|c: char| c.is_whitespace() || matches!(c, ',' | ';')).filter(|it| !it.is_empty());
        three(words, order, |word| word.parse().ok())?
    };
    (point[0].is_finite() && point[1].is_finite()).then_some(point)
}

fn three<'a>(
    words: impl Iterator<Item = &'a str>,
    order: Order,
    number: impl Fn(&str) -> Option<f64>,
) -> Option<[f64; 3]> {
    let mut found = [None; 3];
    for (column, word) in words.enumerate().take(1 + order.into_iter().max()?) {
        if let Some(axis) = order.iter().position(|own| *own == column) {
            found[axis] = Some(number(word)?);
        }
    }
    Some([found[0]?, found[1]?, found[2]?])
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
    let (mut line, mut order) = (Vec::new(), USUAL);
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
        let Some([x, y, z]) = point(&line, order) else {
            if number == 0 {
                order = self::order(&line).unwrap_or(USUAL);
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;
    use crate::source::{Silent, open as open_grid};

    #[test]
    fn a_header_says_the_order_of_columns() {
        assert_eq!(order("lat,lon,elevation"), Some([1, 0, 2]));
        assert_eq!(order("\u{feff}\"id\";\"X\";\"Y\";\"Z\""), Some([1, 2, 3]));
        for header in ["a,b,c", "x,y", "x,lon,y,z", "1,2,3"] {
            assert_eq!(order(header), None, "{header}");
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        let rows = |header: &str, line: fn(f64, f64, f64) -> String| {
            let points =
                (0..12).map(|i| (500.0 + 10.0 * f64::from(i % 4), 900.0 - 10.0 * f64::from(i / 4), f64::from(i)));
            let text: String = points.map(|(x, y, z)| line(x, y, z) + "\n").collect();
            crate::file::atomic::write(&path, (header.to_owned() + "\n" + &text).as_bytes()).unwrap();
            open_grid(&path, &Silent).unwrap()
        };
        let usual = rows("x,y,z", |x, y, z| format!("{x},{y},{z}"));
        assert_eq!((usual.width, usual.height, usual.heights_m[5]), (4, 3, 5.0));
        for (header, line) in [
            ("y;x;z", (|x, y, z| format!("{y};{x};{z}")) as fn(f64, f64, f64) -> String),
            ("z x y", |x, y, z| format!("{z} {x} {y}")),
            ("id,northing,easting,height,name", |x, y, z| format!("7,{y},{x},{z},hut")),
        ] {
            let found = rows(header, line);
            assert_eq!(
                (found.width, found.georeference.crs_from_grid),
                (4, usual.georeference.crs_from_grid),
                "{header}"
            );
            assert_eq!(found.heights_m, usual.heights_m, "{header}");
        }
    }

    #[test]
    fn a_byte_order_mark_is_no_text() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.asc");
        let text = "\u{feff}ncols 2\r\nnrows 2\r\nxllcorner 0\r\nyllcorner 0\r\ncellsize 5\r\n1 2\r\n3 4\r\n";
        crate::file::atomic::write(&path, text.as_bytes()).unwrap();
        assert_eq!(open_grid(&path, &Silent).unwrap().heights_m, [1.0, 2.0, 3.0, 4.0]);
    }
}
