//! The scene file: TOML; every key is optional except the world. [`super::reach`] limits which files it may name.
//!
//! ```toml
//! vertical_exaggeration = 1.0
//!
//! [world]
//! dem = "mountain.tif"              # relative to the scene file, or a URL (https://…, s3://…)
//! # dem = ["a.tif", "b.tif"]        # several DEMs in one world; a folder means all DEMs in it
//! # nodata = -9999                  # additional no-data value, in metres
//! # voids = "holes"                 # keeps small holes; the default, "fill", closes them smoothly
//! # encoding = "gsi"                # terrain-RGB whose encoding nothing else says: "mapbox", "terrarium" or "gsi"
//! # height_unit = "ft"              # of a DEM that declares none: "m", "ft" or "us-ft"
//! # height_scale_m = 0.1            # metres per step of a heightmap or of a colour code
//! # height_offset_m = -100          # height of the value 0, in metres
//! # tile_rows = "tms"               # rows of web map tiles that count from the south; "xyz" from the north
//! # procedural = { seed = 1 }       # instead of dem
//! # continent = { seed = 1, size_samples = 327680, spacing_m = 10 }   # instead of dem; each key is optional
//!
//! [sun]
//! azimuth_deg = 315                 # clockwise from north
//! elevation_deg = 40
//! # date = "2026-06-21T09:30+02:00"   # computes both angles
//! # place = "46.55,7.98"            # latitude and longitude for date; default: the DEM's location
//!
//! [haze]
//! distance_m = 20000                # where haze has taken 63 %; default: 0.45 of the extent's diagonal, at most 30 km
//! color = "#dfe6ea"                 # default: the style's paper
//!
//! [focus]                           # where contrast is strongest; default: the style's
//! place = [1200, -300]              # east and north in metres, and optionally a height
//! radius_m = 2000                   # radius of full contrast
//! strength = 0.7                    # share of contrast lost far away, 0 to 1; default: 0.7
//!
//! [earth]
//! curvature = true                  # curves the map; default: a flat map
//! refraction = 0.13                 # coefficient of the air; default: 0
//!
//! [camera]
//! start = "0,-2000,+300,0,-10,50"   # x,y,z,yaw,pitch,fov
//!
//! [[meshes]]                        # once per model
//! file = "hut.obj"                  # relative to the scene file
//! at = [120, -40, "+0"]             # position of the file's origin: east, north, up; "+h" is above the ground
//! yaw_deg = 30                      # clockwise from above; default: 0
//! scale = 1                         # metres per unit of the file
//! up = "y"                          # or "z": the axis that points up in the file
//! # instead of at, for many copies:
//! # instances = "huts.csv"          # columns x, y and optionally z, yaw, scale: see `super::mesh_list`
//! # scatter = { count = 500, within = [-900, -900, 900, 900], heights_m = [800, 2000], steepest_deg = 25 }
//! #   per_ha instead of count; seed = 1; scale = [0.8, 1.2]; turn_deg = [0, 360]; up_m = 0 above the ground
//!
//! [water]
//! sea_level_m = 0                   # land at or below this height is sea; default: only level areas are water
//! # polygons = "lakes.geojson"      # additional water: polygons, in WGS 84 or the file's own CRS
//! # mask = "water.tif"              # additional water: every non-zero value of a raster
//! # only_given = true               # then level areas are not water
//!
//! [[features]]                      # points, lines and areas that are drawn on the land; a style's layer `features` says how
//! file = "paths.gpkg"               # GeoJSON, GPX, CSV, GeoPackage or FlatGeobuf
//! layer = "paths"                   # of a file with several; default: all of them
//!
//! [[images]]                        # on the land, one over the other; a style's `[image]` says what is made of them
//! file = "orthophoto.tif"           # GeoTIFF, PNG, WebP or JPEG
//!
//! [wind]                            # moves trees; default: still air
//! speed_m_s = 4                     # mean speed, at most 60; default: 5
//! from_deg = 240                    # direction it comes from, clockwise from north; default: 270
//!
//! [forest]                          # trees by rules; each key is optional
//! seed = 1
//! trees_per_ha = 300                # at most 625
//! tree_line_m = 2000                # default: trees grow at any height
//! raggedness_m = 80                 # of the tree line
//! steepest_deg = 38
//! height_m = 18                     # mean height of trees whose species has none of its own
//! mask = "mask.png"                 # density in grey, white is full; or a GeoTIFF
//! land_cover = "cover.tif"          # a GeoTIFF of classes, explained by `forest.classes`
//! canopy_height = "chm.tif"         # a GeoTIFF of tree heights in metres; below 2 m there are no trees
//!
//! [[forest.classes]]                # of land_cover; classes that are not listed have no trees
//! class = 43
//! density = 0.8                     # share of trees_per_ha; default: 1
//! mix = { conifer = 3, broadleaf = 1 }   # shares of forms; or of each species: species = [3, 1, 0]
//!
//! [[forest.species]]                # up to 8; default: a mixed forest
//! form = "conifer"                  # or "broadleaf", "birch", "snag"
//! # file = "oak.obj"                # instead of form: a model, scaled to height_m on average
//! # up = "y"                        # or "z": the axis that points up in the file
//! share = 6                         # of all trees, relative to the other shares
//! height_m = 22
//! low_m = 800                       # the species grows between these heights
//! high_m = 1900
//! aspect_deg = 0                    # slopes that face this way are preferred, clockwise from north
//! by_aspect = 0.7                   # strength of that preference, 0 to 1
//! by_hollow = 0.5                   # 1 prefers hollows, −1 ridges
//! color = "#3a5a2a"                 # of leaves and of model parts without a colour; default: the species' own
//! bark_color = "#6b503f"            # with form only
//! ```

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::camera::Camera;
use super::earth::Earth;
use super::feature_files::{FeatureToml, GraticuleToml};
use super::focus::FocusToml;
use super::forest::ForestToml;
use super::image_files::ImageToml;
use super::meshes::MeshToml;
use super::water_files::WaterToml;
use super::wind::WindToml;
use super::{Haze, Scene, Sun, SunTime, World, ranges};
use crate::file::input::{LARGEST_SCENE_BYTES, read_text};
use crate::file::message::{named, quoted};
use crate::file::toml_text::{self, TomlError, Wrong};
use crate::pyramid::store::continent_store::SMALLEST_SAMPLES;
use crate::source::continent::{SIZE_SAMPLES, SPACING_M};
use crate::source::{Encoding, HeightUnit, OpenOptions, TileRows, VoidMode};

/// Why a file is not a valid scene. One line that names the file, the position in it, the key and the cause.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file cannot be read.
    #[error("cannot read the scene {}: {cause}", named(path))]
    Open {
        /// Path of the scene file.
        path: PathBuf,
        #[source]
        cause: std::io::Error,
    },
    /// The file is not valid TOML, has an unknown key, or has a value out of range.
    #[error(transparent)]
    Toml(#[from] TomlError),
    /// A name that leads outside of what a scene may use without the user's trust: see [`super::reach::Reach`].
    #[error("{}: {key}: {} {what}; --trust-scene allows it", named(path), named(name))]
    Outside {
        /// Path of the scene file.
        path: PathBuf,
        /// The key with its section, like `world.dem`.
        key: &'static str,
        /// The name that the key holds, without passwords.
        name: String,
        /// Why the name is outside.
        what: &'static str,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileToml {
    world: WorldToml,
    #[serde(default)]
    sun: SunToml,
    #[serde(default)]
    haze: HazeToml,
    focus: Option<FocusToml>,
    #[serde(default)]
    earth: EarthToml,
    #[serde(default)]
    camera: CameraToml,
    #[serde(default)]
    meshes: Vec<MeshToml>,
    forest: Option<ForestToml>,
    wind: Option<WindToml>,
    #[serde(default)]
    water: WaterToml,
    #[serde(default)]
    features: Vec<FeatureToml>,
    #[serde(default)]
    images: Vec<ImageToml>,
    graticule: Option<GraticuleToml>,
    vertical_exaggeration: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WorldToml {
    dem: Option<DemToml>,
    nodata: Option<f64>,
    voids: Option<VoidMode>,
    encoding: Option<Encoding>,
    height_unit: Option<HeightUnit>,
    height_scale_m: Option<f64>,
    height_offset_m: Option<f64>,
    tile_rows: Option<TileRows>,
    procedural: Option<ProceduralToml>,
    continent: Option<ContinentToml>,
}

impl WorldToml {
    /// Returns how the DEM is read.
    ///
    /// # Errors
    /// Returns the key and the cause if a value is out of range, or if there is no DEM to which it applies.
    fn heights(&self) -> Result<OpenOptions, (&'static str, &'static str)> {
        let numbers = [
            ("world.nodata", self.nodata, ranges::NO_DATA_M, "it must be a finite height in metres"),
            ("world.height_scale_m", self.height_scale_m, ranges::HEIGHT_SCALE_M, "it must be finite and not 0"),
            ("world.height_offset_m", self.height_offset_m, ranges::HEIGHT_OFFSET_M, "it must be finite"),
        ];
        for (key, number, range, cause) in numbers {
            if number.is_some_and(|number| !range.holds(number)) {
                return Err((key, cause));
            }
        }
        let given = [
            ("world.nodata", self.nodata.is_some()),
            ("world.encoding", self.encoding.is_some()),
            ("world.height_unit", self.height_unit.is_some()),
            ("world.height_scale_m", self.height_scale_m.is_some()),
            ("world.height_offset_m", self.height_offset_m.is_some()),
            ("world.tile_rows", self.tile_rows.is_some()),
        ];
        if self.dem.is_none()
            && let Some((key, _)) = given.into_iter().find(|(_, is_given)| *is_given)
        {
            return Err((key, "it says how a dem is read, and this world has none"));
        }
        Ok(OpenOptions {
            no_data: self.nodata,
            voids: self.voids.unwrap_or(VoidMode::Fill),
            encoding: self.encoding,
            height_unit: self.height_unit,
            height_scale_m: self.height_scale_m,
            height_offset_m: self.height_offset_m,
            tile_rows: self.tile_rows,
            ..OpenOptions::default()
        })
    }
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "it must be a file name or a list of file names")]
enum DemToml {
    One(String),
    Several(Vec<String>),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ContinentToml {
    #[serde(default = "one")]
    seed: u32,
    size_samples: Option<u32>,
    spacing_m: Option<f64>,
}

fn one() -> u32 {
    1
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ProceduralToml {
    seed: u32,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct SunToml {
    azimuth_deg: Option<f64>,
    elevation_deg: Option<f64>,
    date: Option<String>,
    place: Option<String>,
}

impl SunToml {
    /// Returns the sun's date and place, if given; the error is the key and what is wrong with it.
    fn time(&self) -> Result<Option<SunTime>, (&'static str, String)> {
        let place = self.place.as_ref().map(|place| place.parse().map_err(|cause| ("sun.place", cause))).transpose()?;
        let Some(date) = &self.date else {
            return match place {
                Some(_) => Err(("sun.place", "it is only used with sun.date, which is missing".to_owned())),
                None => Ok(None),
            };
        };
        if self.azimuth_deg.is_some() || self.elevation_deg.is_some() {
            return Err(("sun.date", "it cannot be combined with azimuth_deg and elevation_deg".to_owned()));
        }
        Ok(Some(SunTime { moment: date.parse().map_err(|cause| ("sun.date", cause))?, place }))
    }
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct HazeToml {
    distance_m: Option<f64>,
    color: Option<String>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct EarthToml {
    #[serde(default)]
    curvature: bool,
    refraction: Option<f64>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct CameraToml {
    start: Option<String>,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "lowercase")]
pub(super) enum UpToml {
    #[default]
    Y,
    Z,
}

impl Scene {
    /// Reads a scene file. Relative paths in it are relative to its folder.
    ///
    /// # Errors
    /// A file that cannot be read or is not TOML; unknown keys; no world, or two; values out of range.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        let text = read_text(path, LARGEST_SCENE_BYTES);
        let text = text.map_err(|cause| SceneError::Open { path: path.to_owned(), cause })?;
        Self::parse(path, &text)
    }

    /// Parses a scene like [`Scene::read`], from text. `path` is the scene's file name, whether or not the file exists.
    ///
    /// # Errors
    /// The same as [`Scene::read`].
    pub fn parse(path: &Path, text: &str) -> Result<Self, SceneError> {
        let name = path.to_string_lossy();
        let file: FileToml = toml_text::read(&name, text)?;
        let wrong = |key: &str, cause: &str| -> SceneError {
            Wrong::new(key, format!(": {cause}")).in_text(&name, text).into()
        };

        let heights = file.world.heights().map_err(|(key, cause)| wrong(key, cause))?;
        let mut scene = Self::of_world(world(path, file.world).map_err(|wrong| wrong.in_text(&name, text))?);
        scene.file = Some(path.to_owned());
        let Sun { azimuth_deg, elevation_deg } = Sun::default();
        scene.heights = heights;
        scene.sun = Sun {
            azimuth_deg: file.sun.azimuth_deg.unwrap_or(azimuth_deg),
            elevation_deg: file.sun.elevation_deg.unwrap_or(elevation_deg),
        };
        scene.sun_time = file.sun.time().map_err(|(key, cause)| wrong(key, &cause))?;
        if !ranges::AZIMUTH_DEG.holds(scene.sun.azimuth_deg) {
            return Err(wrong("sun.azimuth_deg", "it must be between -360 and 360"));
        }
        if !ranges::ELEVATION_DEG.holds(scene.sun.elevation_deg) {
            return Err(wrong("sun.elevation_deg", "it must be between -90 and 90"));
        }
        if let Some(distance_m) = file.haze.distance_m
            && !(distance_m.is_finite() && distance_m > 0.0)
        {
            return Err(wrong("haze.distance_m", "it must be finite and greater than 0"));
        }
        let color_srgb = match &file.haze.color {
            Some(text) => Some(color(text).ok_or_else(|| wrong("haze.color", "it must be written as \"#rrggbb\""))?),
            None => None,
        };
        scene.haze = Haze { distance_m: file.haze.distance_m, color_srgb };
        let focus = file.focus.as_ref().map(FocusToml::checked);
        scene.focus = focus.transpose().map_err(|(key, cause)| wrong(key, cause))?;
        let refraction = file.earth.refraction.unwrap_or(0.0);
        if !(-1.0..1.0).contains(&refraction) {
            return Err(wrong("earth.refraction", "it must be at least -1 and less than 1"));
        }
        scene.earth = file.earth.curvature.then_some(Earth { refraction });
        if let Some(forest) = &file.forest {
            scene.forest = Some(forest.checked(path).map_err(|(key, cause)| wrong(&key, &cause))?);
        }
        if let Some(wind) = &file.wind {
            scene.wind = wind.checked().map_err(|(key, cause)| wrong(&key, &cause))?;
        }
        if file.water.sea_level_m.is_some_and(|level_m| !ranges::SEA_LEVEL_M.holds(level_m)) {
            return Err(wrong("water.sea_level_m", "it must be between -12000 and 9000"));
        }
        scene.sea_level_m = file.water.sea_level_m;
        scene.water = file.water.files(path).map_err(|(key, cause)| wrong(key, cause))?;
        let features = file.features.iter().map(|entry| entry.file(path));
        scene.features = features.collect::<Result<_, _>>().map_err(|(key, cause)| wrong(key, cause))?;
        let images = file.images.iter().map(|entry| entry.file(path));
        scene.images = images.collect::<Result<_, _>>().map_err(|(key, cause)| wrong(key, cause))?;
        let graticule = file.graticule.map(|graticule| graticule.text().parse()).transpose();
        scene.graticule = graticule.map_err(|cause: String| wrong("graticule", &cause))?;
        if let Some(text) = &file.camera.start {
            scene.start = Some(text.parse::<Camera>().map_err(|error| wrong("camera.start", &error.to_string()))?);
        }
        if let Some(factor) = file.vertical_exaggeration {
            if !ranges::EXAGGERATION.holds(factor) {
                return Err(wrong("vertical_exaggeration", "it must be more than 0 and at most 1000"));
            }
            scene.vertical_exaggeration = factor;
        }
        for (number, mesh) in file.meshes.into_iter().enumerate() {
            let placement = mesh.checked(path);
            let placement = placement.map_err(|(key, cause)| {
                let words = format!(" (mesh {}): {cause}", number + 1);
                Wrong::new(format!("meshes[{number}].{key}"), words).in_text(&name, text)
            })?;
            scene.meshes.push(placement);
        }
        Ok(scene)
    }
}

fn world(scene_path: &Path, world: WorldToml) -> Result<World, Wrong> {
    // An absolute path replaces the folder.
    let resolved = |name: &str| scene_path.parent().unwrap_or(Path::new("")).join(name);
    let wrong = |cause: String| Wrong::with_message("world", format!("world: {cause}"));
    let empty = || Wrong::with_message("world.dem", "world: dem is empty");
    match (world.dem, world.procedural, world.continent) {
        (None, None, None) => {
            Err(wrong("it needs dem = \"FILE\", procedural = { seed = 1 } or continent = {}".to_owned()))
        }
        (None, Some(procedural), None) => Ok(World::Procedural { seed: procedural.seed }),
        (None, None, Some(continent)) => self::continent(&continent),
        (Some(DemToml::One(dem)), None, None) if dem.is_empty() => Err(empty()),
        (Some(DemToml::One(dem)), None, None) if dem.contains("://") => Ok(World::Url(dem)),
        (Some(DemToml::One(dem)), None, None) => Ok(World::File(resolved(&dem))),
        (Some(DemToml::Several(dems)), None, None) => match dems.iter().find(|dem| dem.contains("://")) {
            _ if dems.is_empty() || dems.iter().any(String::is_empty) => Err(empty()),
            Some(url) => Err(wrong(format!("{}: a list of DEMs must hold local files only", quoted(url)))),
            None => Ok(World::Files(dems.iter().map(|dem| resolved(dem)).collect())),
        },
        (dem, procedural, continent) => {
            let names =
                [("dem", dem.is_some()), ("procedural", procedural.is_some()), ("continent", continent.is_some())];
            let given: Vec<&str> = names.iter().filter(|name| name.1).map(|name| name.0).collect();
            Err(wrong(format!("it has both {}; only one of them is allowed", given.join(" and "))))
        }
    }
}

fn continent(continent: &ContinentToml) -> Result<World, Wrong> {
    let wrong = |key: &str, least: f64, most: f64| {
        let key = format!("continent.{key}");
        Wrong::with_message(format!("world.{key}"), format!("world: {key} must be between {least} and {most}"))
    };
    let size_samples = continent.size_samples.unwrap_or(SIZE_SAMPLES);
    if !(SMALLEST_SAMPLES..=SIZE_SAMPLES).contains(&size_samples) {
        return Err(wrong("size_samples", SMALLEST_SAMPLES.into(), SIZE_SAMPLES.into()));
    }
    let spacing_m = continent.spacing_m.unwrap_or(SPACING_M);
    if !(0.1..=100.0).contains(&spacing_m) {
        return Err(wrong("spacing_m", 0.1, 100.0));
    }
    Ok(World::Continent { seed: continent.seed, size_samples, spacing_m })
}

/// Parses `#rrggbb` as three numbers, 0 to 1.
pub(super) fn color(text: &str) -> Option<[f32; 3]> {
    let digits = text.strip_prefix('#').filter(|d| d.len() == 6 && d.bytes().all(|byte| byte.is_ascii_hexdigit()))?;
    let number = u32::from_str_radix(digits, 16).ok()?;
    Some([16, 8, 0].map(|shift| f32::from((number >> shift) as u8) / 255.0))
}
