//! `[[features]]` of a scene: files of points, lines and areas, and `graticule`. [`crate::draped`] reads them.

use std::fmt::{Display, Formatter};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use serde::Deserialize;

/// A file of features that are drawn on the land.
#[derive(Clone, Debug, PartialEq)]
pub struct FeatureFile {
    /// A GeoJSON, GPX, CSV, GeoPackage or FlatGeobuf file.
    pub path: PathBuf,
    /// The layer of the file; `None` reads all of its layers.
    pub layer: Option<String>,
}

/// An entry of `[[features]]` of a scene file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FeatureToml {
    file: String,
    layer: Option<String>,
}

/// `graticule` of a scene file: degrees, or a distance with its unit.
#[derive(Deserialize)]
#[serde(untagged, expecting = "it must be a number of degrees, or a distance such as \"6'\" or \"1000m\"")]
pub(super) enum GraticuleToml {
    Degrees(f64),
    Text(String),
}

impl GraticuleToml {
    pub(super) fn text(self) -> String {
        match self {
            Self::Degrees(degrees) => degrees.to_string(),
            Self::Text(text) => text,
        }
    }
}

impl FeatureToml {
    /// Returns the file of an entry of the scene file `scene`; the error is the key and what is wrong with it.
    pub(super) fn file(&self, scene: &Path) -> Result<FeatureFile, (&'static str, &'static str)> {
        match self.file.as_str() {
            "" => Err(("features.file", "it is empty")),
            name if name.contains("://") => Err(("features.file", "it must be a local file, not a URL")),
            name => {
                Ok(FeatureFile { path: scene.parent().unwrap_or(Path::new("")).join(name), layer: self.layer.clone() })
            }
        }
    }
}

/// Lines of equal coordinates on the land, and their distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Graticule {
    /// Meridians and parallels on WGS 84, in degrees.
    Degrees(f64),
    /// Lines of the grid of the heights' projection, in metres.
    Metres(f64),
}

/// Least distance in degrees, a metre on the ground, and in metres.
const LEAST: f64 = 1e-5;
/// Endings of a distance, with the factor to degrees or metres.
const DEGREES: [(&str, f64); 5] =
    [("°", 1.0), ("'", 1.0 / 60.0), ("′", 1.0 / 60.0), ("\"", 1.0 / 3600.0), ("″", 1.0 / 3600.0)];
const METRES: [(&str, f64); 2] = [("km", 1000.0), ("m", 1.0)];

impl FromStr for Graticule {
    type Err = String;

    /// Parses `0.1`, `0.1°`, `6'`, `30"`, `1000m` or `1km`.
    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        let number = |(ending, factor): &(&str, f64)| {
            let number = text.strip_suffix(ending)?.trim().parse::<f64>().ok()? * factor;
            (number.is_finite() && number >= LEAST).then_some(number)
        };
        let degrees = DEGREES.iter().chain([&("", 1.0)]).find_map(number).map(Self::Degrees);
        let metres = METRES.iter().find_map(number).map(Self::Metres);
        metres.or(degrees).filter(|graticule| !matches!(graticule, Self::Degrees(step) if *step > 90.0)).ok_or_else(
            || {
                "it must be a distance in degrees from 0.00001 to 90, such as 0.1, 6' or 30\", or in metres, such as 1000m or 1km"
                    .to_owned()
            },
        )
    }
}

impl Display for Graticule {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Degrees(step) => write!(f, "{step}"),
            Self::Metres(step_m) => write!(f, "{step_m}m"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_have_units() {
        for (text, expected) in [
            ("0.1", Some(Graticule::Degrees(0.1))),
            ("6'", Some(Graticule::Degrees(0.1))),
            ("36\"", Some(Graticule::Degrees(0.01))),
            ("6′", Some(Graticule::Degrees(0.1))),
            ("1e-300", None),
            ("2°", Some(Graticule::Degrees(2.0))),
            ("1000m", Some(Graticule::Metres(1000.0))),
            ("1.5 km", Some(Graticule::Metres(1500.0))),
            ("0", None),
            ("-1", None),
            ("91", None),
            ("nan", None),
            ("1 mile", None),
            ("", None),
        ] {
            assert_eq!(text.parse().ok(), expected, "{text}");
            let again = expected.map(|graticule: Graticule| graticule.to_string().parse());
            assert_eq!(again, expected.map(Ok), "{text}");
        }
    }
}
