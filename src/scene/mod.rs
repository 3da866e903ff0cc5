//! Scenes: camera, camera path, views and stereo rigs, light, and the scene file.

pub(crate) mod anaglyph;
pub mod camera;
pub(crate) mod earth;
pub(crate) mod embedded;
mod feature_files;
mod image_files;
pub(crate) mod focus;
pub mod forest;
pub(crate) mod forest_cover;
pub(crate) mod frustum;
pub(crate) mod lone_model;
pub mod look;
pub mod map;
pub(crate) mod mesh_list;
pub(crate) mod meshes;
pub(crate) mod overrides;
pub mod path;
pub(crate) mod ranges;
pub mod reach;
pub(crate) mod scene_file;
pub mod stereo;
pub(crate) mod sun_time;
pub mod tone_curve;
pub mod view;
mod water_files;
pub(crate) mod wind;

use std::path::PathBuf;
use std::str::FromStr;

use camera::Camera;
pub use earth::Earth;
pub use feature_files::{FeatureFile, Graticule};
pub use focus::{Focus, FocusAbout, SceneFocus};
pub use forest::Forest;
pub use forest_cover::{CoverClass, CoverFiles};
use glam::DVec3;
pub use image_files::ImageFile;
pub use lone_model::LoneModel;
pub use meshes::{Density, MeshPlace, MeshPlacement, MeshPositions, Scatter};
pub use scene_file::SceneError;
pub use sun_time::{LatLon, Moment, SunTime, SunTimeError};
pub use water_files::WaterFiles;
pub use wind::Wind;

use crate::source::{OpenOptions, VoidMode};

/// The content of a picture: everything that determines it, except the style.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The scene file that defines the scene; `None` if there is no file.
    pub file: Option<PathBuf>,
    /// The built-in scene that defines it, if it is one.
    pub(crate) embedded: Option<&'static embedded::EmbeddedScene>,
    /// The source of the heights.
    pub world: World,
    /// Direction of the sunlight.
    pub sun: Sun,
    /// Date and place from which the sun is computed; replaces `sun` once the heights are open.
    pub sun_time: Option<SunTime>,
    pub haze: Haze,
    /// Place with the strongest contrast; `None` leaves it to the style.
    pub focus: Option<SceneFocus>,
    /// The camera at the start of a flight; `None` picks a view from the world's extent.
    pub start: Option<Camera>,
    /// Curvature of the earth; `None` draws a flat map.
    pub earth: Option<Earth>,
    /// Factor on all heights; 1 is true to scale.
    pub vertical_exaggeration: f64,
    /// Models placed on the land.
    pub meshes: Vec<MeshPlacement>,
    /// The places and species of trees.
    pub forest: Option<Forest>,
    /// Wind that moves the trees; `None` is still air.
    pub wind: Option<Wind>,
    /// Land at or below this height is sea, in metres in the file's heights; `None`: only level areas are water.
    pub sea_level_m: Option<f64>,
    /// Files that mark water, in addition to the water that is found in the heights.
    pub water: WaterFiles,
    /// Files of points, lines and areas that are drawn on the land.
    pub features: Vec<FeatureFile>,
    /// Images on the land; the last one is drawn over the others.
    pub images: Vec<ImageFile>,
    /// Lines of equal coordinates that are drawn on the land.
    pub graticule: Option<Graticule>,
    /// Properties of the height files that the files themselves do not declare.
    pub heights: OpenOptions,
}

/// The source of a scene's heights.
#[derive(Clone, Debug, PartialEq)]
pub enum World {
    /// A DEM file or a baked pyramid.
    File(PathBuf),
    /// The URL of a DEM or a baked pyramid.
    Url(String),
    /// The embedded procedural world.
    Procedural {
        /// Seed of the random generator; each seed gives a different world.
        seed: u32,
    },
    /// Several DEMs in one world; of those with equal spacing, an earlier one takes precedence.
    Files(Vec<PathBuf>),
    /// The procedural continent, or a square cut from its middle.
    Continent {
        /// Seed of the random generator; each seed gives a different continent.
        seed: u32,
        /// Samples along each side.
        size_samples: u32,
        /// Distance between samples in metres; values other than 10 stretch the land horizontally.
        spacing_m: f64,
    },
    /// A model that is opened by itself, on flat ground.
    Model(LoneModel),
    /// Heights in memory, which a caller of the library has given; a scene cannot open them.
    Memory,
}

/// The direction of sunlight, a distant light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Azimuth, clockwise from north, in degrees.
    pub azimuth_deg: f64,
    /// Elevation above the horizon, in degrees, −90 to 90.
    pub elevation_deg: f64,
}

/// Haze that reduces contrast with distance d: the share taken is 1 − exp(−(d / distance_m)²), so near land stays
/// clear.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Haze {
    /// Distance at which haze has taken 63 % of the contrast, in metres; `None` means [`Haze::distance_over_m`].
    pub distance_m: Option<f64>,
    /// Colour that distant land fades to, sRGB-encoded, 0 to 1; `None` means the style's paper.
    pub color_srgb: Option<[f32; 3]>,
}

impl Default for Scene {
    /// Returns the procedural world with light from the north-west, as is usual on maps, and no exaggeration.
    fn default() -> Self {
        Self::of_world(World::Procedural { seed: 1 })
    }
}

impl Scene {
    /// Returns a scene of a world with everything else at its default, as for a bare DEM on the command line.
    pub(crate) fn of_world(world: World) -> Self {
        Self {
            file: None,
            embedded: None,
            world,
            sun: Sun::default(),
            sun_time: None,
            haze: Haze::default(),
            focus: None,
            start: None,
            earth: None,
            vertical_exaggeration: 1.0,
            meshes: Vec::new(),
            forest: None,
            wind: None,
            sea_level_m: None,
            water: WaterFiles::default(),
            features: Vec::new(),
            images: Vec::new(),
            graticule: None,
            heights: OpenOptions { voids: VoidMode::Fill, ..OpenOptions::default() },
        }
    }
}

/// Light and haze of a scene, as a frame needs them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Unit vector from the ground toward the sun, in the world's frame.
    pub to_sun: DVec3,
    /// Distance at which haze has taken 63 % of the contrast, in metres.
    pub haze_m: f64,
    /// Colour that distant land fades to, sRGB-encoded, 0 to 1; `None` means the style's.
    pub haze_srgb: Option<[f32; 3]>,
    /// Place with the strongest contrast.
    pub focus: Option<Focus>,
}

/// Distance at which clear air has taken 63 % of the contrast, in metres.
const CLEAR_AIR_M: f64 = 30_000.0;
/// Scale height of the atmosphere: air density falls by a factor of e over it, in metres.
const THINNING_M: f64 = 8000.0;

impl Light {
    /// Returns the light for an eye `height_m` above the highest land. Air thins with height, so a map seen from far
    /// above is clear: haze reaches farther by the ratio of the air along a level ray to the air along a ray from the
    /// land.
    pub(crate) fn for_eye_above(self, height_m: f64) -> Self {
        let t = (height_m / THINNING_M).max(1e-6);
        Self { haze_m: self.haze_m * t / -(-t).exp_m1(), ..self }
    }
}

impl Scene {
    /// Returns the CSV files that list positions of the scene's models.
    pub(crate) fn mesh_lists(&self) -> impl Iterator<Item = &PathBuf> {
        self.meshes.iter().filter_map(|mesh| match &mesh.positions {
            MeshPositions::Listed(list) => Some(list),
            MeshPositions::At(_) | MeshPositions::Scattered(_) | MeshPositions::Middle => None,
        })
    }

    /// Returns the light over a world of `extent_m` (east, north).
    pub fn light(&self, extent_m: [f64; 2]) -> Light {
        Light {
            to_sun: self.sun.direction(),
            haze_m: self.haze.distance_over_m(extent_m),
            haze_srgb: self.haze.color_srgb,
            focus: self.focus.as_ref().map(SceneFocus::focus),
        }
    }
}

impl Default for Sun {
    fn default() -> Self {
        Self { azimuth_deg: 315.0, elevation_deg: 40.0 }
    }
}

impl FromStr for Sun {
    type Err = String;

    /// Parses `AZIMUTH,ELEVATION` in degrees, like `315,40`.
    fn from_str(text: &str) -> Result<Self, String> {
        let sun = text.split_once(',').and_then(|(azimuth, elevation)| {
            Some(Self {
                azimuth_deg: ranges::AZIMUTH_DEG.parse(azimuth.trim()).ok()?,
                elevation_deg: ranges::ELEVATION_DEG.parse(elevation.trim()).ok()?,
            })
        });
        sun.ok_or_else(|| "it must be an azimuth (-360 to 360) and an elevation (-90 to 90), like 315,40".to_owned())
    }
}

impl Sun {
    /// Returns the unit vector from the ground toward the sun, in the world's frame.
    pub fn direction(&self) -> DVec3 {
        let (sin_azimuth, cos_azimuth) = self.azimuth_deg.to_radians().sin_cos();
        let (sin_elevation, cos_elevation) = self.elevation_deg.to_radians().sin_cos();
        DVec3::new(sin_azimuth * cos_elevation, cos_azimuth * cos_elevation, sin_elevation)
    }
}

impl Haze {
    /// Returns the haze distance over a world of `extent_m` (east, north), in metres: the scene's own, or else 0.45 of
    /// the extent's diagonal, so that mountains in the middle are clear against those at the far edge. It is at most 30
    /// km, which is clear air, so that a large world has a near, a middle and a far distance like a small one.
    pub(crate) fn distance_over_m(&self, extent_m: [f64; 2]) -> f64 {
        self.distance_m.unwrap_or_else(|| (0.45 * extent_m[0].hypot(extent_m[1])).clamp(1.0, CLEAR_AIR_M))
    }
}
