//! ASCII grids: a header of keywords, then one number for each sample, by rows from the north.
//!
//! - ESRI: `ncols nrows xllcorner|xllcenter yllcorner|yllcenter cellsize [NODATA_value]` in any order and case ("Esri
//!   ASCII raster format", ArcGIS Desktop help); GDAL adds `dx`, `dy` for cells that are not square. A `.prj` sidecar
//!   file gives the CRS.
//! - GRASS: `north: south: east: west: rows: cols: [null:]`; no-data is `*` (manual of r.in.ascii). North, south, east
//!   and west are the outer edges.
//!
//! Values may be broken over lines in any way. A text has no index, so the whole grid is read into memory.

use std::path::Path;

use super::SourceError;
use super::memory::{self, MemoryReader};
use super::place::{self, cannot_open, inconsistent};
use super::prj;
use super::samples::{Meaning, SampleType, Tally, WarnOnce};
use super::text::Words;
use crate::file::message::quoted;

/// The values of the header's keywords.
#[derive(Debug, Default)]
struct Header {
    columns: Option<u32>,
    rows: Option<u32>,
    /// Whether the keyword was `…center` instead of `…corner`, for x and y.
    is_centre: [bool; 2],
    lower_left: [Option<f64>; 2],
    cell: [Option<f64>; 2],
    no_data: Option<f64>,
    /// North, south, east, west.
    edges: [Option<f64>; 4],
}

/// Reads a grid of either kind.
pub(super) fn open(path: &Path) -> Result<MemoryReader, SourceError> {
    let file_bytes = std::fs::metadata(path).map_err(cannot_open(path))?.len();
    let mut words = Words::open(path)?;
    let header = read_header(path, &mut words)?;
    let (Some(width), Some(height)) = (header.columns, header.rows) else {
        return Err(inconsistent(path, "its header does not say how many columns and rows it has"));
    };
    let size = [width, height];
    place::check_size(path, size)?;
    // Each sample takes at least a digit and a space, the last one only a digit.
    let samples = u64::from(width) * u64::from(height);
    if samples > file_bytes.div_ceil(2) {
        return Err(inconsistent(path, format!("{width}×{height} samples do not fit in {file_bytes} bytes")));
    }
    memory::check_count(path, size)?;
    let crs_from_grid = header.crs_from_grid(path, size)?;
    let (keys, prj) = prj::keys(path, crs_from_grid, size)?;
    let georeference = place::locate(path, crs_from_grid, keys, size)?;

    let mut heights_m = memory::room(path, size, samples)?;
    let meaning = Meaning::metres(SampleType::F64, header.no_data);
    let mut tally = Tally::default();
    for index in 0..samples {
        let value = match words.next()? {
            Some("*") => f64::NAN,
            Some(word) => super::text::number(word).ok_or_else(|| {
                inconsistent(path, format!("sample {} is {}, which is not a number", index + 1, quoted(word)))
            })?,
            None => return Err(inconsistent(path, format!("it is truncated: it has {index} of {samples} samples"))),
        };
        heights_m.push(meaning.height_m(value, &mut tally));
    }
    WarnOnce::default().warn(path, &tally);
    if words.next()?.is_some() {
        tracing::warn!("{}: has more than {width}×{height} samples; the rest is ignored", path.display());
    }
    let files: Vec<&Path> = std::iter::once(path).chain(prj.as_deref()).collect();
    let identity = place::identity(&files, "");
    Ok(MemoryReader { path: path.into(), size, heights_m, unit_m: 1.0, georeference, identity })
}

fn read_header(path: &Path, words: &mut Words) -> Result<Header, SourceError> {
    let mut header = Header::default();
    loop {
        let Some(word) = words.next()? else { return Err(inconsistent(path, "it ends in its header")) };
        let keyword = word.to_ascii_lowercase();
        if !keyword.starts_with(|c: char| c.is_ascii_alphabetic()) || keyword == "nan" {
            words.put_back();
            return Ok(header);
        }
        if keyword == "null:" || keyword == "type:" || keyword == "multiplier:" {
            header.set_grass(path, &keyword, words)?;
            continue;
        }
        let value = words.number(&format!("{keyword} in its header"))?;
        let count = || {
            let is_count = value >= 1.0 && value <= f64::from(u32::MAX) && value.fract() == 0.0;
            is_count.then_some(value as u32).ok_or_else(|| inconsistent(path, format!("its {keyword} is {value:?}")))
        };
        match keyword.as_str() {
            "ncols" | "cols:" => header.columns = Some(count()?),
            "nrows" | "rows:" => header.rows = Some(count()?),
            "xllcorner" => header.lower_left[0] = Some(value),
            "yllcorner" => header.lower_left[1] = Some(value),
            "xllcenter" => (header.lower_left[0], header.is_centre[0]) = (Some(value), true),
            "yllcenter" => (header.lower_left[1], header.is_centre[1]) = (Some(value), true),
            "cellsize" => header.cell = [Some(value); 2],
            "dx" => header.cell[0] = Some(value),
            "dy" => header.cell[1] = Some(value),
            "nodata_value" | "nodata" => header.no_data = Some(value),
            "north:" => header.edges[0] = Some(value),
            "south:" => header.edges[1] = Some(value),
            "east:" => header.edges[2] = Some(value),
            "west:" => header.edges[3] = Some(value),
            _ => return Err(inconsistent(path, format!("its header has the unknown keyword {}", quoted(&keyword)))),
        }
    }
}

impl Header {
    fn set_grass(&mut self, path: &Path, keyword: &str, words: &mut Words) -> Result<(), SourceError> {
        let value = words.next()?.unwrap_or_default().to_owned();
        match keyword {
            "null:" => self.no_data = super::text::number(&value),
            "multiplier:" if super::text::number(&value) != Some(1.0) => {
                return Err(SourceError::Unsupported { path: path.into(), what: format!("a multiplier of {value}") });
            }
            _ => {}
        }
        Ok(())
    }

    fn crs_from_grid(&self, path: &Path, size: [u32; 2]) -> Result<[f64; 6], SourceError> {
        let [width, height] = size.map(f64::from);
        if let [Some(north), Some(south), Some(east), Some(west)] = self.edges {
            let step = [(east - west) / width, (north - south) / height];
            return Ok(place::north_up([west + 0.5 * step[0], north - 0.5 * step[1]], step));
        }
        let ([Some(x), Some(y)], [Some(dx), Some(dy)]) = (self.lower_left, self.cell) else {
            return Err(inconsistent(path, "its header gives no position or no cell size"));
        };
        let half = self.is_centre.map(|is_centre| if is_centre { 0.0 } else { 0.5 });
        Ok(place::north_up([x + half[0] * dx, y + (height - 1.0 + half[1]) * dy], [dx, dy]))
    }
}
