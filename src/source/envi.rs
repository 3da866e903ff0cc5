//! ENVI rasters: flat data and a header that begins with `ENVI` ("ENVI Header Files", L3Harris Geospatial
//! documentation). `map info` gives the georeference: one reference point of the grid, counted from 1 with whole
//! numbers at outer corners, and the cell size; `coordinate system string` is Well-Known Text.

use std::path::Path;

use super::flat::{Description, FlatReader, Strides};
use super::place::{self, inconsistent, small_text};
use super::samples::{Meaning, SampleType};
use super::text::number;
use super::tiff_sidecars::from_world_file;
use super::{GeoKeys, SourceError, prj, wkt};

/// The `name = value` fields of a header; a value in braces may span several lines.
struct Fields(Vec<(String, String)>);

impl Fields {
    fn parse(text: &str) -> Self {
        let mut fields = Vec::new();
        let mut lines = text.lines();
        while let Some(line) = lines.next() {
            let Some((name, value)) = line.split_once('=') else { continue };
            let mut value = value.trim().to_owned();
            if value.starts_with('{') {
                while !value.contains('}') {
                    let Some(line) = lines.next() else { break };
                    value.push(' ');
                    value.push_str(line.trim());
                }
                value = value.trim_matches(['{', '}', ' ']).to_owned();
            }
            fields.push((name.trim().to_ascii_lowercase(), value));
        }
        Self(fields)
    }

    fn text(&self, name: &str) -> Option<&str> {
        self.0.iter().find(|(field, _)| field == name).map(|(_, value)| value.as_str())
    }
}

/// Opens the data with its header.
pub(super) fn open(data: &Path, header: &Path) -> Result<FlatReader, SourceError> {
    let fields = Fields::parse(&small_text(header)?);
    let whole = |name: &str| match fields.text(name).map(str::parse::<u64>) {
        Some(Ok(value)) => Ok(Some(value)),
        Some(Err(_)) => Err(inconsistent(header, format!("its {name} is not a whole number"))),
        None => Ok(None),
    };
    let count = |name: &str| {
        let count = whole(name)?.and_then(|count| u32::try_from(count).ok());
        count.filter(|&count| count > 0).ok_or_else(|| inconsistent(header, format!("its {name} is missing or wrong")))
    };
    let size = [count("samples")?, count("lines")?];
    place::check_size(data, size)?;
    let bands = whole("bands")?.unwrap_or(1).max(1);
    let code = whole("data type")?.unwrap_or(0);
    let sample_type = match code {
        1 => SampleType::U8,
        2 => SampleType::I16,
        3 => SampleType::I32,
        4 => SampleType::F32,
        5 => SampleType::F64,
        12 => SampleType::U16,
        13 => SampleType::U32,
        14 => SampleType::I64,
        15 => SampleType::U64,
        _ => return Err(SourceError::Unsupported { path: data.into(), what: format!("ENVI data type {code}") }),
    };
    if whole("file compression")?.unwrap_or(0) != 0 {
        return Err(SourceError::Unsupported { path: data.into(), what: "a compressed ENVI file".to_owned() });
    }
    let sample_bytes = sample_type.bytes() as u64;
    let row = u64::from(size[0]) * sample_bytes;
    let all = |bytes: u64| bytes.checked_mul(bands).ok_or_else(|| inconsistent(header, "it has too many bands"));
    let offset = whole("header offset")?.unwrap_or(0);
    let interleave = fields.text("interleave").unwrap_or("bsq").to_ascii_lowercase();
    let strides = match interleave.as_str() {
        "bip" => Strides { offset, row: all(row)?, sample: all(sample_bytes)? },
        "bil" => Strides { offset, row: all(row)?, sample: sample_bytes },
        _ => Strides { offset, row, sample: sample_bytes },
    };
    let no_data = fields.text("data ignore value").and_then(number);
    let (crs_from_grid, keys) = place_of(&fields, data, size)?;
    let georeference = place::locate(data, crs_from_grid, keys, size)?;
    let described = Description {
        size,
        strides,
        is_big_endian: whole("byte order")?.unwrap_or(0) == 1,
        meaning: Meaning::metres(sample_type, no_data),
        georeference,
        identity: place::identity(&[data, header], ""),
    };
    FlatReader::new(data, None, described)
}

fn place_of(fields: &Fields, data: &Path, size: [u32; 2]) -> Result<([f64; 6], GeoKeys), SourceError> {
    let Some(map_info) = fields.text("map info") else {
        if let Some((place, _)) = from_world_file(data) {
            return Ok((place, prj::keys(data, place, size)?.0));
        }
        tracing::warn!("{}: has no georeference; a sample spacing of 1 m is assumed", data.display());
        return Ok((place::north_up([0.0; 2], [1.0; 2]), place::local_metres()));
    };
    let items: Vec<&str> = map_info.split(',').map(str::trim).collect();
    let numbers: Option<Vec<f64>> = items.get(1..7).and_then(|items| items.iter().map(|it| number(it)).collect());
    let Some(&[column, row, x, y, dx, dy]) = numbers.as_deref() else {
        return Err(inconsistent(data, "the map info of its header is incomplete"));
    };
    let rotation = items.iter().find_map(|item| item.strip_prefix("rotation=")).and_then(number).unwrap_or(0.0);
    if rotation != 0.0 {
        return Err(SourceError::Unsupported { path: data.into(), what: format!("a rotation by {rotation}°") });
    }
    let crs_from_grid = place::north_up([x + (1.5 - column) * dx, y - (1.5 - row) * dy], [dx, dy]);
    if let Some(keys) = fields.text("coordinate system string").and_then(wkt::keys) {
        return Ok((crs_from_grid, keys));
    }
    let projection = items[0].to_ascii_lowercase();
    let datum = items.iter().map(|item| item.to_ascii_lowercase());
    let geographic = datum
        .filter_map(|item| match item.as_str() {
            "wgs-84" => Some(4326),
            "north america 1983" => Some(4269),
            "north america 1927" => Some(4267),
            _ => None,
        })
        .next();
    let keys = match (projection.as_str(), geographic) {
        ("geographic lat/lon", geographic) => place::epsg(geographic.unwrap_or(4326), true),
        ("utm", Some(geographic)) => {
            let zone = items.get(7).and_then(|zone| zone.parse().ok()).unwrap_or(0);
            let is_north = !items.get(8).is_some_and(|it| it.eq_ignore_ascii_case("south"));
            match wkt::utm(zone, is_north, geographic) {
                Some(code) => place::epsg(code, false),
                None => prj::keys(data, crs_from_grid, size)?.0,
            }
        }
        _ => prj::keys(data, crs_from_grid, size)?.0,
    };
    Ok((crs_from_grid, keys))
}
