//! The sidecar files of a raster: GDAL's `dem.tif.aux.xml`, and a world file such as `dem.tfw`.
//!
//! As in GDAL, the first takes precedence over the tags of a GeoTIFF, and a world file only counts if nothing else gives
//! a georeference. Pictures and raw files have no georeference of their own (`sidecar`).

use std::path::{Path, PathBuf};

use super::georeference::GeoTags;
use super::place::{self, ending, sibling, small_text};
use super::samples::{BandMetadata, Meaning, parse_no_data};
use super::{GeoKeys, masked, wkt};

/// Largest coordinate and step of a world file; no unit of any planet gives larger ones.
const MAX_COORDINATE: f64 = 1e12;

/// Returns the extensions of the world files of a raster, as GDAL has them: the first and the last letter of the
/// raster's own extension with a `w`, the whole extension with a `w`, and `wld`.
fn world_file_endings(path: &Path) -> Vec<String> {
    let own = ending(path);
    let mut endings = Vec::new();
    if let (Some(first), Some(last)) = (own.chars().next(), own.chars().last()) {
        endings.extend([format!("{first}{last}w"), format!("{own}w")]);
    }
    if own.starts_with("tif") {
        endings.extend(["tfw", "tifw", "tiffw"].map(str::to_owned));
    }
    endings.push("wld".to_owned());
    endings
}

/// Returns the world file of a raster, if it exists.
fn world_file(path: &Path) -> Option<PathBuf> {
    world_file_endings(path).iter().find_map(|ending| sibling(path, ending))
}

/// Returns the sample positions from the world file of a raster, and that file. An invalid one is ignored with a
/// warning.
pub(super) fn from_world_file(path: &Path) -> Option<([f64; 6], PathBuf)> {
    let world = world_file(path)?;
    let place = small_text(&world).ok().and_then(|text| parse_world_file(&text));
    if place.is_none() {
        tracing::warn!("{}: is not a valid world file and is ignored", world.display());
    }
    Some((place?, world))
}

/// The information from the sidecar files of a raster.
#[derive(Clone, Debug, Default)]
pub(super) struct TiffSidecars {
    /// The sidecar files that contain relevant information.
    pub files: Vec<PathBuf>,
    /// Transform for sample centres, as in [`super::georeference::Georeference`].
    crs_from_grid: Option<[f64; 6]>,
    world_file: Option<[f64; 6]>,
    geokeys: Option<GeoKeys>,
    no_data: Option<f64>,
    band: BandMetadata,
}

impl TiffSidecars {
    /// Reads the sidecar files of the raster at `path`. Invalid files are ignored with a warning. Other content of
    /// `.aux.xml`, such as statistics and other programs' metadata, is ignored.
    pub(super) fn of(path: &Path) -> Self {
        let mut found = Self::default();
        let mut aux = path.as_os_str().to_owned();
        aux.push(".aux.xml");
        let aux = PathBuf::from(aux);
        if aux.is_file() {
            match small_text(&aux) {
                Ok(text) if found.read_aux(&text) => found.files.push(aux),
                Ok(_) => {}
                Err(error) => tracing::warn!("{error}; it is ignored"),
            }
        }
        if let Some((place, world)) = from_world_file(path) {
            found.world_file = Some(place);
            found.files.push(world);
        }
        found
    }

    /// Returns the transform for sample centres of a raster that has none of its own.
    pub(super) fn own_place(&self) -> Option<[f64; 6]> {
        self.crs_from_grid.or(self.world_file)
    }

    /// Returns the keys of the CRS.
    pub(super) fn geokeys(&self) -> Option<&GeoKeys> {
        self.geokeys.as_ref()
    }

    /// Returns whether the steps of the samples are known: their scale, their offset or their unit.
    pub(super) fn knows_steps(&self) -> bool {
        self.band.scale.is_some() || self.band.offset.is_some() || self.band.metres_per_unit().is_some()
    }

    /// Returns whether the sidecar file changes the heights or their georeference.
    pub(super) fn overrules(&self) -> bool {
        self.crs_from_grid.is_some()
            || self.geokeys.is_some()
            || self.no_data.is_some()
            || self.band != BandMetadata::default()
    }

    /// Returns the transform of the grid, if a sidecar file or the tags give one, and replaces the CRS in `tags` if a
    /// sidecar file gives another.
    pub(super) fn place(&self, tags: &mut GeoTags) -> Option<[f64; 6]> {
        let of_tags = tags.crs_from_grid();
        if let Some(keys) = &self.geokeys {
            tags.geokeys = keys.clone();
        }
        self.crs_from_grid.or(of_tags).or(self.world_file)
    }

    /// Replaces the entries of `meaning` that a sidecar file gives.
    pub(super) fn overrule(&self, meaning: &mut Meaning) {
        meaning.no_data = self.no_data.or(meaning.no_data);
        meaning.scale = self.band.scale.unwrap_or(meaning.scale);
        meaning.offset = self.band.offset.unwrap_or(meaning.offset);
        meaning.has_unit |= self.band.metres_per_unit().is_some();
        meaning.metres_per_unit = self.band.metres_per_unit().unwrap_or(meaning.metres_per_unit);
    }

    /// Warns if the unit of the heights is none that is known.
    pub(super) fn warn_of_unit(&self, path: &Path) {
        self.band.warn_of_unit(path);
    }

    fn read_aux(&mut self, text: &str) -> bool {
        let numbers = |text: String| -> Option<Vec<f64>> { text.split(',').map(|it| it.trim().parse().ok()).collect() };
        if let Some(&[x, a, b, y, c, d]) = element(text, "GeoTransform").and_then(numbers).as_deref() {
            self.crs_from_grid = Some([x + 0.5 * (a + b), a, b, y + 0.5 * (c + d), c, d]);
        }
        self.geokeys = element(text, "SRS").and_then(|text| wkt::keys(&text).or_else(|| place::keys_of_code(&text)));
        let first_band = text
            .split("<PAMRasterBand ")
            .skip(1)
            .find(|rest| rest.split('>').next().is_some_and(|attributes| attributes.contains("band=\"1\"")));
        if let Some(band) = first_band.and_then(|band| band.split("</PAMRasterBand>").next()) {
            let number = |name: &str| element(band, name)?.trim().parse::<f64>().ok().filter(|it| it.is_finite());
            self.no_data = element(band, "NoDataValue").as_deref().and_then(parse_no_data);
            self.band = BandMetadata {
                scale: number("Scale").filter(|&scale| scale != 0.0),
                offset: number("Offset"),
                unit: element(band, "UnitType").map(|unit| unit.trim().to_ascii_lowercase()),
            };
        }
        self.overrules()
    }
}

/// Returns whether the heights of the GeoTIFF at `path` depend on sidecar files: then it cannot be drawn without
/// baking.
pub(crate) fn needs_sidecars(path: &Path) -> bool {
    masked::sidecar_mask(path).is_some() || TiffSidecars::of(path).overrules()
}

/// Returns the text of the first element with this name, without nested elements.
fn element(xml: &str, name: &str) -> Option<String> {
    let start = format!("<{name}");
    let rest = xml.match_indices(&start).map(|(at, _)| &xml[at + start.len()..]);
    let rest = rest.into_iter().find(|rest| rest.starts_with(['>', ' ', '\n']))?;
    let (attributes, rest) = rest.split_once('>')?;
    let text = if attributes.ends_with('/') { "" } else { rest.split('<').next()? };
    let plain = text.replace("&quot;", "\"").replace("&apos;", "'").replace("&lt;", "<").replace("&gt;", ">");
    Some(plain.replace("&amp;", "&")).filter(|text| !text.trim().is_empty())
}

/// Parses a world file of six numbers: the steps of x and y per column, the same per row, and the centre of the first
/// sample.
fn parse_world_file(text: &str) -> Option<[f64; 6]> {
    let words = text.trim_start_matches('\u{feff}').split_whitespace();
    let numbers: Option<Vec<f64>> = words.map(|word| word.replace(',', ".").parse().ok()).collect();
    let &[a, c, b, d, x, y] = numbers?.as_slice() else { return None };
    let is_place = [a, b, c, d, x, y].iter().all(|number| number.abs() < MAX_COORDINATE) && a * d - b * c != 0.0;
    is_place.then_some([x, a, b, y, c, d])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sidecars_give_position_and_sample_type() {
        let mut found = TiffSidecars::default();
        let text = r#"<PAMDataset><SRS dataAxisToSRSAxisMapping="1,2">PROJCS[&quot;x&quot;,UNIT["metre",1],AUTHORITY["EPSG","2056"]]</SRS>
            <GeoTransform> 1e1, 2.0, 0, 20, 0, -4</GeoTransform>
            <PAMRasterBand band="2"><NoDataValue>7</NoDataValue></PAMRasterBand>
            <PAMRasterBand band="1"><NoDataValue le_hex_equiv="0">-9999</NoDataValue><UnitType>ft</UnitType></PAMRasterBand>"#;
        assert!(found.read_aux(text));
        assert_eq!(found.crs_from_grid, Some([11.0, 2.0, 0.0, 18.0, 0.0, -4.0]));
        assert_eq!((found.no_data, found.band.metres_per_unit()), (Some(-9999.0), Some(0.3048)));
        assert_eq!(found.geokeys.and_then(|keys| keys.epsg), Some(2056));
        let mut by_code = TiffSidecars::default();
        assert!(by_code.read_aux("<PAMDataset><SRS>EPSG:32632</SRS></PAMDataset>"));
        assert_eq!(by_code.geokeys.and_then(|keys| keys.epsg), Some(32632));
        let mut statistics = TiffSidecars::default();
        assert!(!statistics.read_aux("<PAMDataset><PAMRasterBand band=\"1\"><Metadata/></PAMRasterBand></PAMDataset>"));
        assert!(!statistics.read_aux("<GeoTransform> 1, 2</GeoTransform><SRS/><PAMRasterBand band=\"1\">"));
        assert_eq!(
            parse_world_file("30\n0\n0\n-30\n594015\n5194985\n"),
            Some([594_015.0, 30.0, 0.0, 5_194_985.0, 0.0, -30.0])
        );
        assert_eq!(parse_world_file("some words"), None);
    }

    #[test]
    fn world_files_hold_a_place() {
        assert_eq!(
            parse_world_file("\u{feff}30\n0\n0\n-30\n500015\n5199985\n"),
            Some([500_015.0, 30.0, 0.0, 5_199_985.0, 0.0, -30.0])
        );
        assert_eq!(parse_world_file("30,5 0 0 -30,5 1 2"), Some([1.0, 30.5, 0.0, 2.0, 0.0, -30.5]));
        for invalid in ["30 0 0 -30 1", "0 0 0 0 1 2", "1e300 0 0 -30 1 2", "nan 0 0 -30 1 2", "30 30 30 30 1 2"] {
            assert_eq!(parse_world_file(invalid), None, "{invalid}");
        }
    }
}
