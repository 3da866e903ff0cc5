//! Imprints: metadata in a picture that says how it was drawn, so that `hachure render --like` can redraw it.
//!
//! An imprint is a TOML document, the same for all formats ([`crate::file::imprint`] says where it is stored). It
//! contains the complete style and those of its recipes that are files, because a file may change later. Worlds and
//! images of marks are stored by the names that were given: paths are not made absolute, and of addresses only the part
//! that is not secret is stored.
//!
//! ```toml
//! version = 1                  # of this format, from 1 to 8; a reader rejects newer ones
//! hachure = "0.1.0"            # version of the program that wrote it
//! world = "mountain.tif"       # as on the command line; without it, the built-in world
//! camera = "0,-2000,+300,0,-10,50"
//! sun = "315,40"               # azimuth and elevation in degrees
//! size = [1280, 720]           # in pixels, of one eye
//! dpi = 300.0                  # without it, pixel lengths of the style are not scaled
//! style = """…"""              # a complete style file
//! marks = { "mine.toml" = """…""" }      # recipes of the style that are files
//! textures = { "mine.toml" = """…""" }
//! ```

use std::collections::BTreeMap;
use std::path::Path;

use glam::{DMat4, DVec4};
use serde::{Deserialize, Serialize};

use crate::file::frame_rate::FrameRate;
use crate::file::imprint::Matrices;
use crate::file::toml_text::{self, TomlError, Wrong};
use crate::file::{FileError, imprint};
use crate::remote;
use crate::scene::Sun;
use crate::scene::camera::Camera;
use crate::scene::ranges;
use crate::scene::view::{Lens, NEAR_M, View};
use crate::style::{Style, StyleError, StyleFiles};

/// Newest version of the format. A new key that changes the drawing requires a new version ([`More::version`]).
const VERSION: u32 = 13;

/// Why the imprint of a file cannot be used. The message is one line with the file and the cause.
#[derive(Debug, thiserror::Error)]
pub enum ImprintError {
    /// The file has no imprint, or cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// The imprint is not valid TOML, or has wrong keys or values.
    #[error("{} (its imprint)", .0)]
    Toml(#[from] TomlError),
    /// The imprint was written by a newer hachure.
    #[error(
        "cannot read {}: its imprint has version {version}, this hachure reads up to {VERSION}; it was written by hachure {}",
        crate::file::message::named(name),
        crate::file::message::shown(hachure)
    )]
    Newer {
        /// Path of the file.
        name: String,
        /// Version of the imprint.
        version: u32,
        /// Version of the program that wrote it.
        hachure: String,
    },
    /// The style in the imprint cannot be loaded.
    #[error("{} (the style of its imprint)", .0)]
    Style(#[from] StyleError),
}

/// All settings with which a picture was drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Imprint {
    /// World, as on the command line; `None` is the built-in world.
    pub world: Option<String>,
    /// Camera, as it was given: a height above ground stays relative to the ground, also in another world.
    pub camera: Camera,
    /// Direction of the sun, in degrees.
    pub sun: Sun,
    /// Style before [`Style::scaled`].
    pub style: Style,
    /// Size of the picture of one eye, in pixels.
    pub size_px: [u32; 2],
    /// Dots per inch of paper.
    pub dpi: Option<f64>,
    /// Settings that most pictures do not have.
    pub more: More,
}

/// Further settings of a picture that differ from their defaults. Text values are as on the command line.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct More {
    /// Time in seconds, in a scene with wind.
    pub time_s: Option<f64>,
    /// Samples per pixel.
    pub samples: Option<u32>,
    /// Allowed height error of the level of detail, in pixels.
    pub lod_error: Option<f64>,
    /// Additional no-data value, in metres.
    pub nodata: Option<f64>,
    /// Encoding of heights stored as colours.
    pub encoding: Option<String>,
    /// Value of `--voids`.
    pub voids: Option<String>,
    /// Memory for tiles, in MiB: with too little, coarser tiles are drawn.
    pub tile_memory: Option<u64>,
    /// Value of `--height-scale`.
    pub height_scale: Option<f64>,
    /// Value of `--height-offset`.
    pub height_offset: Option<f64>,
    /// Value of `--height-unit`.
    pub height_unit: Option<String>,
    /// Value of `--tile-rows`.
    pub tile_rows: Option<String>,
    /// Value of `--exaggeration`.
    pub exaggeration: Option<f64>,
    /// Value of `--haze`.
    pub haze: Option<f64>,
    /// Value of `--sea-level`.
    pub sea_level: Option<String>,
    /// Value of `--trees`.
    pub trees: Option<String>,
    /// Value of `--seed`.
    pub seed: Option<u32>,
    /// Value of `--eyes`.
    pub eyes: Option<String>,
    /// Distance between the eyes.
    pub ipd: Option<String>,
    /// Distance at which the axes of the eyes meet.
    pub convergence: Option<f64>,
    /// Value of `--map`; `camera` is then the most similar perspective camera.
    pub map: Option<String>,
    /// Title below the picture.
    pub title: Option<String>,
    /// The number N of the scale 1 : N of a map.
    pub map_scale: Option<f64>,
    /// Credits in the title block.
    pub credits: Option<String>,
    /// Whether the title block has a legend.
    pub legend: Option<bool>,
    /// Whether a map has a frame.
    pub frame: Option<bool>,
    /// Value of `--peaks`.
    pub peaks: Option<u32>,
    /// Value of `--saddles`.
    pub saddles: Option<u32>,
    /// Value of `--lakes`.
    pub lakes: Option<u32>,
    /// File of `--names`.
    pub names: Option<String>,
    /// Value of `--name-layer`.
    pub name_layer: Option<String>,
    /// Value of `--name-when`.
    pub name_when: Option<String>,
    /// Value of `--name-field`.
    pub name_field: Option<String>,
    /// Value of `--focus`.
    pub focus: Option<String>,
    /// Value of `--water`.
    pub water: Option<String>,
    /// Files of `--layer`.
    pub layers: Option<Vec<String>>,
    /// Value of `--graticule`.
    pub graticule: Option<String>,
    /// Images of `--drape`.
    pub drape: Option<Vec<String>>,
    /// Value of `--show`.
    pub show: Option<String>,
    /// Paper of an SVG.
    pub paper: Option<String>,
    /// Margin of an SVG's paper, in millimetres.
    pub margin: Option<f64>,
    /// Tolerance of the curves of an SVG, in pixels.
    pub tolerance_px: Option<f64>,
    /// Number of pens of an SVG.
    pub pens: Option<usize>,
    /// Camera path of a film.
    pub path: Option<String>,
    /// Frames per second of a film.
    pub fps: Option<FrameRate>,
    /// Value of `--frames` of a film.
    pub frames: Option<String>,
    /// Value of `--warm-up` of a part of a film.
    pub warm_up: Option<u64>,
    /// Value of `--antialias`, for a film or its frames.
    pub antialias: Option<String>,
    /// The curve that fitted the tones to the picture ([`crate::scene::tone_curve::ToneCurve`]).
    pub tone_curve: Option<String>,
}

impl More {
    /// Returns the version of the format that a reader must know to draw the same picture: 2 added maps; 3 titles,
    /// `focus` and `water`; 4 `voids`, `tile_memory`, `antialias`, `frames`, rates that are fractions, and how heights
    /// are read; 5 `exaggeration`; 6 `haze`; 7 `sea_level`, `trees` and `seed`; 8 `tone_curve`; 9
    /// `frame`; 10 `credits`, `legend` and `map_scale`; 11 `peaks`, `names` and what begins with `name_`;
    /// 12 `layers` and `graticule`; 13 `drape`, `saddles` and `lakes`.
    fn version(&self) -> u32 {
        const HEIGHTS: u32 = 4;
        const EXAGGERATED: u32 = 5;
        const HAZY: u32 = 6;
        let reads_as_usual = self.height_scale.is_none()
            && self.height_offset.is_none()
            && self.height_unit.is_none()
            && self.tile_rows.is_none();
        const GENERATED: u32 = 7;
        const FITTED: u32 = 8;
        const FRAMED: u32 = 9;
        const TITLED: u32 = 10;
        const NAMED: u32 = 11;
        const LAYERED: u32 = 12;
        match self {
            _ if self.drape.is_some() || self.saddles.is_some() || self.lakes.is_some() => VERSION,
            _ if self.layers.is_some() || self.graticule.is_some() => LAYERED,
            _ if self.peaks.is_some() || self.names.is_some() => NAMED,
            _ if self.credits.is_some() || self.map_scale.is_some() || self.legend.is_some() => TITLED,
            _ if self.frame.is_some() => FRAMED,
            _ if self.tone_curve.is_some() => FITTED,
            _ if self.sea_level.is_some() || self.trees.is_some() || self.seed.is_some() => GENERATED,
            _ if self.haze.is_some() => HAZY,
            _ if self.exaggeration.is_some() => EXAGGERATED,
            _ if !reads_as_usual => HEIGHTS,
            Self { frames: Some(_), .. } | Self { fps: Some(FrameRate::Fraction(..)), .. } => HEIGHTS,
            Self { voids: None, tile_memory: None, antialias: None, title: None, focus: None, water: None, .. } => {
                if self.map.is_some() {
                    2
                } else {
                    1
                }
            }
            Self { voids: None, tile_memory: None, antialias: None, .. } => 3,
            _ => HEIGHTS,
        }
    }

    /// Checks every number against the range of its option. Texts are parsed like those of the command line.
    ///
    /// # Errors
    /// Returns the key, and what its value must be.
    fn check(&self) -> Result<(), (&'static str, String)> {
        // Without `..`, so that a new key is not forgotten.
        let Self {
            time_s,
            samples,
            lod_error,
            nodata,
            height_scale,
            height_offset,
            exaggeration,
            haze,
            seed,
            tile_memory,
            convergence,
            margin,
            tolerance_px,
            pens,
            map_scale,
            fps,
            warm_up,
            encoding: _,
            height_unit: _,
            tile_rows: _,
            sea_level: _,
            trees: _,
            voids: _,
            eyes: _,
            ipd: _,
            map: _,
            title: _,
            peaks,
            saddles,
            lakes,
            names: _,
            name_layer: _,
            name_when: _,
            name_field: _,
            credits: _,
            legend: _,
            frame: _,
            focus: _,
            water: _,
            layers: _,
            graticule: _,
            drape: _,
            show: _,
            paper: _,
            path: _,
            frames: _,
            antialias: _,
            tone_curve: _,
        } = self;
        let numbers = [
            ("time_s", *time_s, ranges::TIME_S),
            ("peaks", peaks.map(f64::from), ranges::PEAKS),
            ("saddles", saddles.map(f64::from), ranges::PEAKS),
            ("lakes", lakes.map(f64::from), ranges::PEAKS),
            ("samples", samples.map(f64::from), ranges::SAMPLES),
            ("lod_error", *lod_error, ranges::LOD_ERROR_PX),
            ("nodata", *nodata, ranges::NO_DATA_M),
            ("height_scale", *height_scale, ranges::HEIGHT_SCALE_M),
            ("height_offset", *height_offset, ranges::HEIGHT_OFFSET_M),
            ("exaggeration", *exaggeration, ranges::EXAGGERATION),
            ("haze", *haze, ranges::HAZE_M),
            ("seed", seed.map(f64::from), ranges::SEED),
            ("tile_memory", tile_memory.map(|mib| mib as f64), ranges::TILE_MEMORY_MIB),
            ("convergence", *convergence, ranges::CONVERGENCE_M),
            ("margin", *margin, ranges::MARGIN_MM),
            ("tolerance_px", *tolerance_px, ranges::TOLERANCE_PX),
            ("pens", pens.map(|pens| pens as f64), ranges::PENS),
            ("map_scale", *map_scale, ranges::MAP_SCALE),
            ("fps", fps.map(FrameRate::per_second), ranges::FPS),
            ("warm_up", warm_up.map(|frames| frames as f64), ranges::WARM_UP_FRAMES),
        ];
        let wrong = numbers.into_iter().find(|(_, number, range)| number.is_some_and(|number| !range.holds(number)));
        wrong.map_or(Ok(()), |(key, _, range)| Err((key, range.rule())))
    }
}

/// The keys that every version of the format has.
#[derive(Deserialize)]
struct VersionToml {
    version: u32,
    #[serde(default)]
    hachure: String,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ImprintToml {
    version: u32,
    hachure: String,
    world: Option<String>,
    camera: String,
    sun: String,
    size: [u32; 2],
    dpi: Option<f64>,
    style: String,
    #[serde(default, skip_serializing_if = "is_empty")]
    more: More,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    marks: BTreeMap<String, String>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    textures: BTreeMap<String, String>,
}

fn is_empty(more: &More) -> bool {
    *more == More::default()
}

impl Imprint {
    /// Returns the imprint as TOML text.
    pub fn text(&self) -> String {
        let StyleFiles { marks, textures } = self.style.recipe_files();
        let Sun { azimuth_deg, elevation_deg } = self.sun;
        // The part after the path of an address may be an access key.
        let public = |world: &String| if world.contains("://") { remote::name_of(world) } else { world.clone() };
        let text = toml::to_string(&ImprintToml {
            version: self.more.version(),
            hachure: env!("CARGO_PKG_VERSION").to_owned(),
            world: self.world.as_ref().map(public),
            camera: self.camera.to_string(),
            sun: format!("{azimuth_deg},{elevation_deg}"),
            size: self.size_px,
            dpi: self.dpi,
            style: self.style.text(),
            more: self.more.clone(),
            marks,
            textures,
        });
        text.expect("texts, numbers and tables of them are TOML")
    }

    /// Parses an imprint; errors begin with `name`, the name of the file.
    ///
    /// # Errors
    /// Invalid TOML, wrong keys or values, or a newer version.
    pub fn parse(name: &str, text: &str) -> Result<Self, ImprintError> {
        let VersionToml { version, hachure } = toml_text::read(name, text)?;
        if version > VERSION {
            return Err(ImprintError::Newer { name: name.to_owned(), version, hachure });
        }
        let found: ImprintToml = toml_text::read(name, text)?;
        let wrong = |key: &str, words: String| ImprintError::from(Wrong::new(key, words).in_text(name, text));
        if found.size.into_iter().any(|side| !ranges::SIDE_PX.holds(side.into())) {
            return Err(wrong("size", format!(": {}", ranges::SIDE_PX.rule())));
        }
        ranges::check_pixels(found.size).map_err(|rule| wrong("size", format!(": {rule}")))?;
        if found.dpi.is_some_and(|dpi| !ranges::DPI.holds(dpi)) {
            return Err(wrong("dpi", format!(": {}", ranges::DPI.rule())));
        }
        found.more.check().map_err(|(key, rule)| wrong(&format!("more.{key}"), format!(": {rule}")))?;
        let held = StyleFiles { marks: found.marks, textures: found.textures };
        Ok(Self {
            world: found.world,
            camera: found.camera.parse().map_err(|error| wrong("camera", format!(": {error}")))?,
            sun: found.sun.parse().map_err(|error| wrong("sun", format!(": {error}")))?,
            style: Style::parse_with(name, &found.style, &held)?,
            size_px: found.size,
            dpi: found.dpi,
            more: found.more,
        })
    }

    /// Reads the imprint of a picture or film.
    ///
    /// # Errors
    /// [`ImprintError`].
    pub fn read(path: &Path) -> Result<Self, ImprintError> {
        Self::parse(&path.to_string_lossy(), &imprint::read(path)?)
    }
}

/// Returns the matrices of an eye for the attributes of an EXR.
pub(crate) fn matrices(eye: &View) -> Matrices {
    let pose = &eye.pose;
    let turn = DMat4::from_cols(
        DVec4::from((pose.right, 0.0)),
        DVec4::from((pose.up, 0.0)),
        DVec4::from((-pose.forward, 0.0)),
        DVec4::W,
    );
    let camera_from_world = turn.transpose() * DMat4::from_translation(-pose.position_m);
    let Lens { left, right, up, down } = eye.lens.unwrap_or_else(|| {
        let up = (0.5 * pose.fov_rad).tan();
        let across = up * f64::from(eye.picture_px[0]) / f64::from(eye.picture_px[1]);
        Lens { left: across, right: across, up, down: up }
    });
    let [width, height] = [left + right, up + down];
    // z becomes the distance of the near plane, and w the distance along the axis, which a shifted lens does not see in
    // the middle of its picture.
    let project = DMat4::from_cols(
        DVec4::new(2.0 / width, 0.0, 0.0, 0.0),
        DVec4::new(0.0, 2.0 / height, 0.0, 0.0),
        DVec4::new((right - left) / width, (up - down) / height, 0.0, -1.0),
        DVec4::new(0.0, 0.0, NEAR_M, 0.0),
    );
    let by_rows = |matrix: DMat4| matrix.to_cols_array().map(|number| number as f32);
    // The columns of a matrix for column vectors are the rows of one for row vectors.
    Matrices { camera_from_world: by_rows(camera_from_world), ndc_from_world: by_rows(project * camera_from_world) }
}
