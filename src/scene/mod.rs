//! What is looked at and from where: camera, camera path, views and rigs of eyes, light, scene file.

pub mod anaglyph;
pub mod camera;
pub mod earth;
pub mod embedded;
pub mod focus;
pub mod forest;
pub mod forest_cover;
pub mod frustum;
pub mod map;
pub mod mesh_list;
pub mod meshes;
pub mod path;
pub mod reach;
pub mod scene_file;
pub mod stereo;
pub mod sun_time;
pub mod view;
mod water_files;
pub mod wind;

use std::path::PathBuf;
use std::str::FromStr;

use camera::Camera;
pub use focus::{Focus, SceneFocus};
pub use forest::Forest;
pub use forest_cover::{CoverClass, CoverFiles};
use glam::DVec3;
pub use meshes::{Density, MeshPlace, MeshPlacement, Scatter, Stands};
pub use sun_time::SunTime;
pub use water_files::WaterFiles;
pub use wind::Wind;

use crate::source::{OpenOptions, VoidMode};

/// Everything that decides what is drawn, but for the style.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The scene file that says all this; none where nobody wrote one.
    pub file: Option<PathBuf>,
    /// The scene of the program that says it.
    pub embedded: Option<&'static embedded::EmbeddedScene>,
    /// The terrain.
    pub world: World,
    /// The light.
    pub sun: Sun,
    /// When the sun is to stand where it stands, in place of `sun`, which follows from it when the heights are open.
    pub sun_time: Option<SunTime>,
    /// The air.
    pub haze: Haze,
    /// Where the strongest contrast is; none means that the style says it, if anybody does.
    pub focus: Option<SceneFocus>,
    /// Where a flight starts; none means a view that the world's extent suggests.
    pub start: Option<Camera>,
    /// The curvature of the earth; none is a flat map.
    pub earth: Option<earth::Earth>,
    /// What heights are multiplied by; 1 is true to nature.
    pub vertical_exaggeration: f64,
    /// What stands on the land.
    pub meshes: Vec<MeshPlacement>,
    /// Trees.
    pub forest: Option<Forest>,
    /// What moves them, if anything does.
    pub wind: Option<Wind>,
    /// Land that is no higher is the sea, in metres as the file has heights; none is no sea but where it is level.
    pub sea_level_m: Option<f64>,
    /// Files that say where water is, beside what heights show.
    pub water: WaterFiles,
    /// What is said of height files that do not say it themselves.
    pub heights: OpenOptions,
}

/// Where the heights come from.
#[derive(Clone, Debug, PartialEq)]
pub enum World {
    /// A DEM file or a baked pyramid.
    File(PathBuf),
    /// The address of one.
    Url(String),
    /// The embedded procedural world.
    Procedural {
        /// Another seed is another world.
        seed: u32,
    },
    /// Several DEMs in one world, in order of their precedence among equal spacings.
    Files(Vec<PathBuf>),
    /// The procedural continent, or a square from its middle.
    Continent {
        /// Another seed is another continent.
        seed: u32,
        /// Samples along a side.
        size_samples: u32,
        /// Metres between them; other than 10 stretches the land.
        spacing_m: f64,
    },
}

/// A distant light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Where it stands, clockwise from north, in degrees.
    pub azimuth_deg: f64,
    /// Above the horizon, in degrees, −90 to 90.
    pub elevation_deg: f64,
}

/// Air that takes contrast with distance d: a share of 1 − exp(−(d / distance_m)²), clear near and hazy far.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Haze {
    /// The distance at which haze has taken 63 %, in metres; none means [`Haze::distance_over_m`].
    pub distance_m: Option<f64>,
    /// What distance fades to, as sRGB-encoded red, green, blue of 0 to 1; none means the style's paper.
    pub color_srgb: Option<[f32; 3]>,
}

impl Default for Scene {
    /// The procedural world, light from the north-west as maps have it, no exaggeration.
    fn default() -> Self {
        Self::of_world(World::Procedural { seed: 1 })
    }
}

impl Scene {
    /// A world with everything else at its default: what a bare DEM means on the command line.
    pub fn of_world(world: World) -> Self {
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
            heights: OpenOptions { voids: VoidMode::Fill, ..OpenOptions::default() },
        }
    }
}

/// The scene's light and air, as a frame needs them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Unit, in the world.
    pub to_sun: DVec3,
    /// Distance at which haze has taken 63 %.
    pub haze_m: f64,
    /// What distance fades to, in sRGB of 0 to 1; none means the style's.
    pub haze_srgb: Option<[f32; 3]>,
    /// Where the strongest contrast is.
    pub focus: Option<Focus>,
}

/// Haze of clear air: two thirds of the contrast are gone at this distance.
const CLEAR_AIR_M: f64 = 30_000.0;
/// Height in which air becomes thinner by a factor of e, in metres.
const THINNING_M: f64 = 8000.0;

impl Light {
    /// The same for an eye that is `height_m` above the highest land: air thins with height, so a map's view from above
    /// is clear. Haze reaches farther by what a ray from the land has less of air than a level one.
    pub fn from_above(self, height_m: f64) -> Self {
        let t = (height_m / THINNING_M).max(1e-6);
        Self { haze_m: self.haze_m * t / -(-t).exp_m1(), ..self }
    }
}

impl Scene {
    /// The lists of places where its models stand.
    pub fn mesh_lists(&self) -> impl Iterator<Item = &PathBuf> {
        self.meshes.iter().filter_map(|mesh| match &mesh.stands {
            Stands::Listed(list) => Some(list),
            Stands::At(_) | Stands::Scattered(_) => None,
        })
    }

    /// The light over a world of `extent_m` (east, north).
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

    /// `315,40`.
    fn from_str(text: &str) -> Result<Self, String> {
        let within = |text: &str, most: f64| text.trim().parse().ok().filter(|number| (-most..=most).contains(number));
        let sun = text.split_once(',').and_then(|(azimuth, elevation)| {
            Some(Self { azimuth_deg: within(azimuth, 360.0)?, elevation_deg: within(elevation, 90.0)? })
        });
        sun.ok_or_else(|| "it must be an azimuth from -360 to 360 and an elevation from -90 to 90, like 315,40".to_owned())
    }
}

impl Sun {
    /// The unit vector from the ground toward the sun, in the world's frame.
    pub fn direction(&self) -> DVec3 {
        let (sin_azimuth, cos_azimuth) = self.azimuth_deg.to_radians().sin_cos();
        let (sin_elevation, cos_elevation) = self.elevation_deg.to_radians().sin_cos();
        DVec3::new(sin_azimuth * cos_elevation, cos_azimuth * cos_elevation, sin_elevation)
    }
}

impl Haze {
    /// The distance in use over a world of `extent_m` (east, north): the one given, else 0.45 of the extent's diagonal,
    /// so that mountains in the middle stand clear before those at the far edge, and 30 km at most, which is clear air:
    /// a large world has near, middle and far as a small one has.
    pub fn distance_over_m(&self, extent_m: [f64; 2]) -> f64 {
        self.distance_m.unwrap_or_else(|| (0.45 * extent_m[0].hypot(extent_m[1])).clamp(1.0, CLEAR_AIR_M))
    }
}
