//! `[[meshes]]` of a scene: models and where each is placed: once, at the positions of a list ([`super::mesh_list`]),
//! or by a rule ([`Scatter`]) that is evaluated on the terrain when the scene opens.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::Deserialize;

use super::camera::LARGEST_COORDINATE_M;
use super::forest::exaggerated_slope_deg;
use super::scene_file::UpToml;
use crate::file::message::quoted;
use crate::mesh::placed::MAX_INSTANCES;

/// A model and where it is placed.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshPlacement {
    /// Path of the OBJ file.
    pub file: PathBuf,
    /// One position, a list or a rule.
    pub positions: MeshPositions,
    /// Rotation, clockwise from above, in degrees. Rotations from a list or a rule are added to it.
    pub yaw_deg: f64,
    /// Metres per unit of the file. Scales from a list or a rule are multiplied with it.
    pub scale: f64,
    /// Whether the file's z axis points up; otherwise y points up and z south.
    pub z_up: bool,
}

/// The places of the copies of a model.
#[derive(Clone, Debug, PartialEq)]
pub enum MeshPositions {
    /// One copy at a given position.
    At(MeshPlace),
    /// One copy for each row of a CSV file.
    Listed(PathBuf),
    /// Copies scattered by a rule.
    Scattered(Scatter),
    /// One copy with the middle of its box in the middle of the world and its lowest vertex on the ground, at the scale
    /// that suits its size: a model that is opened by itself.
    Middle,
}

/// The position of a model's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshPlace {
    /// East, north, up in the world's frame, in metres. z is relative to the ground if
    /// [`MeshPlace::height_above_ground`].
    pub at_m: DVec3,
    /// Whether z is relative to the ground (it was given as `+h`).
    pub height_above_ground: bool,
}

/// A rule that scatters copies of a model evenly over the land.
#[derive(Clone, Debug, PartialEq)]
pub struct Scatter {
    pub density: Density,
    /// West, south, east and north limits, in the world's frame, in metres.
    pub within_m: [f64; 4],
    /// Lowest and highest ground on which copies are placed, in metres.
    pub heights_m: [f64; 2],
    /// Steepest ground on which copies are placed, in degrees; `None` means no limit.
    pub steepest_deg: Option<f64>,
    /// Seed of the random generator; each seed gives different positions.
    pub seed: u32,
    /// Smallest and largest scale.
    pub scale: [f64; 2],
    /// Smallest and largest rotation, clockwise from above, in degrees.
    pub turn_deg: [f64; 2],
    /// Height of the model's origin above the ground, in metres.
    pub up_m: f64,
}

/// The number of copies that a rule places.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Density {
    /// Copies per hectare, before limits of height and slope remove some.
    PerHa(f64),
    /// Total number of copies, as far as limits of height and slope leave room for them.
    Count(u32),
}

impl Scatter {
    /// Largest number of points at which one rule may sample the terrain.
    pub(crate) const MAX_POINTS: u64 = 1 << 22;

    /// Returns the rule that places copies where this one does, on land that is `factor` times as high.
    #[must_use]
    pub(crate) fn exaggerated(&self, factor: f64) -> Self {
        Self {
            heights_m: self.heights_m.map(|height_m| height_m * factor),
            steepest_deg: self.steepest_deg.map(|slope_deg| exaggerated_slope_deg(slope_deg, factor)),
            ..self.clone()
        }
    }

    /// Returns the area within the limits, in hectares.
    pub(crate) fn area_ha(&self) -> f64 {
        let [west, south, east, north] = self.within_m;
        (east - west) * (north - south) * 1e-4
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MeshToml {
    file: String,
    at: Option<(f64, f64, HeightToml)>,
    instances: Option<String>,
    scatter: Option<ScatterToml>,
    #[serde(default)]
    yaw_deg: f64,
    #[serde(default = "same_size")]
    scale: f64,
    #[serde(default)]
    up: UpToml,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ScatterToml {
    per_ha: Option<f64>,
    count: Option<i64>,
    within: [f64; 4],
    heights_m: Option<[f64; 2]>,
    steepest_deg: Option<f64>,
    #[serde(default = "first_seed")]
    seed: u32,
    scale: Option<[f64; 2]>,
    turn_deg: Option<[f64; 2]>,
    up_m: Option<f64>,
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "z must be a number, or \"+h\" for h metres above the ground")]
enum HeightToml {
    Height(f64),
    Text(String),
}

fn same_size() -> f64 {
    1.0
}

fn first_seed() -> u32 {
    1
}

/// Allowed rotations of models, in degrees.
const TURNS_DEG: RangeInclusive<f64> = -360_000.0..=360_000.0;
/// Allowed scales of models.
const SCALES: RangeInclusive<f64> = 1e-6..=1e6;

/// Parses a height of a scene or of a list: metres, or `+h` above the ground. Returns it and whether it is above
/// ground.
pub(super) fn height_of(text: &str) -> Result<(f64, bool), String> {
    // As in cameras, `++5` is a typing error, not a number.
    let above = text.strip_prefix('+').filter(|number| !number.starts_with('+'));
    let found = above.map_or_else(|| text.parse().map(|z_m| (z_m, false)), |number| number.parse().map(|h| (h, true)));
    found.map_err(|_| format!("z is {}; it must be a number or \"+h\" (above ground)", quoted(text)))
}

/// A key and what is wrong with its value.
pub(super) type WrongKey = (String, String);

fn within(key: &str, value: f64, range: RangeInclusive<f64>) -> Result<f64, WrongKey> {
    let cause = || format!("it must be between {} and {}", range.start(), range.end());
    if range.contains(&value) { Ok(value) } else { Err((key.to_owned(), cause())) }
}

/// Checks position, rotation and scale of a model; the error is the key and what is wrong with it.
pub(super) fn check_stance(at_m: DVec3, yaw_deg: f64, scale: f64) -> Result<(), WrongKey> {
    if !(at_m.is_finite() && at_m.abs().max_element() <= LARGEST_COORDINATE_M) {
        return Err(("at".to_owned(), format!("each coordinate must be within ±{LARGEST_COORDINATE_M} m")));
    }
    within("yaw_deg", yaw_deg, TURNS_DEG)?;
    within("scale", scale, SCALES)?;
    Ok(())
}

impl MeshToml {
    /// Validates the entry; the error is the key and what is wrong with it.
    pub(super) fn checked(self, scene_path: &Path) -> Result<MeshPlacement, WrongKey> {
        let wrong = |key: &str, cause: String| (key.to_owned(), cause);
        if self.file.is_empty() {
            return Err(wrong("file", "it is empty".to_owned()));
        }
        let resolved = |name: &str| scene_path.parent().unwrap_or(Path::new("")).join(name);
        let file = resolved(&self.file);
        let positions = match (self.at, self.instances, self.scatter) {
            (Some((x_m, y_m, z)), None, None) => {
                let (z_m, height_above_ground) = match z {
                    HeightToml::Height(z_m) => (z_m, false),
                    // A plain number in quotes is rejected: it should be written as a number.
                    HeightToml::Text(text) => height_of(&text)
                        .and_then(|(z_m, is_above)| {
                            let cause =
                                || format!("z is {}; it must be a number or \"+h\" (above ground)", quoted(&text));
                            is_above.then_some((z_m, true)).ok_or_else(cause)
                        })
                        .map_err(|cause| wrong("at", cause))?,
                };
                MeshPositions::At(MeshPlace { at_m: DVec3::new(x_m, y_m, z_m), height_above_ground })
            }
            (None, Some(list), None) if list.is_empty() => return Err(wrong("instances", "it is empty".to_owned())),
            (None, Some(list), None) => MeshPositions::Listed(resolved(&list)),
            (None, None, Some(scatter)) => MeshPositions::Scattered(scatter.checked()?),
            (None, None, None) => {
                let cause = "it needs at = [x, y, \"+0\"], instances = \"LIST.csv\" or scatter = { … }";
                return Err(wrong("at", cause.to_owned()));
            }
            (at, list, scatter) => {
                let given = [("at", at.is_some()), ("instances", list.is_some()), ("scatter", scatter.is_some())];
                let given: Vec<&str> = given.iter().filter(|name| name.1).map(|name| name.0).collect();
                return Err(wrong(
                    given[1],
                    format!("it has both {}; only one of them is allowed", given.join(" and ")),
                ));
            }
        };
        let at_m = if let MeshPositions::At(place) = &positions { place.at_m } else { DVec3::ZERO };
        check_stance(at_m, self.yaw_deg, self.scale)?;
        let z_up = matches!(self.up, UpToml::Z);
        Ok(MeshPlacement { file, positions, yaw_deg: self.yaw_deg, scale: self.scale, z_up })
    }
}

impl ScatterToml {
    fn checked(&self) -> Result<Scatter, WrongKey> {
        let wrong = |key: &str, cause: String| Err((format!("scatter.{key}"), cause));
        let [west, south, east, north] = self.within;
        if !(self.within.iter().all(|along_m| along_m.abs() <= LARGEST_COORDINATE_M) && west < east && south < north) {
            let cause =
                format!("it must be [west, south, east, north] in metres, ascending, within ±{LARGEST_COORDINATE_M} m");
            return wrong("within", cause);
        }
        let density = match (self.per_ha, self.count) {
            (Some(per_ha), None) => Density::PerHa(within("scatter.per_ha", per_ha, 1e-6..=1e6)?),
            (None, Some(count)) => match u32::try_from(count) {
                Ok(count) if (1..=MAX_INSTANCES).contains(&u64::from(count)) => Density::Count(count),
                _ => return wrong("count", format!("it must be between 1 and {MAX_INSTANCES}")),
            },
            _ => return wrong("per_ha", "scatter needs either per_ha or count".to_owned()),
        };
        let range = |key: &str, given: Option<[f64; 2]>, usual: [f64; 2], range: RangeInclusive<f64>| {
            let [low, high] = given.unwrap_or(usual);
            if range.contains(&low) && range.contains(&high) && low <= high {
                return Ok([low, high]);
            }
            let cause =
                format!("it must be two numbers between {} and {}, the smaller one first", range.start(), range.end());
            Err((format!("scatter.{key}"), cause))
        };
        let scatter = Scatter {
            density,
            within_m: self.within,
            heights_m: range("heights_m", self.heights_m, [-1e6, 1e6], -1e6..=1e6)?,
            steepest_deg: self.steepest_deg.map(|deg| within("scatter.steepest_deg", deg, 0.0..=90.0)).transpose()?,
            seed: self.seed,
            scale: range("scale", self.scale, [1.0, 1.0], SCALES)?,
            turn_deg: range("turn_deg", self.turn_deg, [0.0, 360.0], TURNS_DEG)?,
            up_m: within("scatter.up_m", self.up_m.unwrap_or(0.0), -1e6..=1e6)?,
        };
        if let Density::PerHa(per_ha) = density
            && per_ha * scatter.area_ha() > Scatter::MAX_POINTS as f64
        {
            let points = per_ha * scatter.area_ha();
            return wrong(
                "per_ha",
                format!("it makes {points:.0} points to test, but at most {} are allowed", Scatter::MAX_POINTS),
            );
        }
        Ok(scatter)
    }
}
