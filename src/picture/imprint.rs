//! What a picture says of how it was drawn, so that it can be drawn again: `hachure render --like`.
//!
//! It is a TOML document, one for all formats ([`crate::file::imprint`] says where it stands). The style is in it as a
//! whole, with those of its recipes that are files, because a file may change later. Worlds and pictures of marks stand
//! in it by the names that were given: no path is made absolute, and of addresses only what is no secret is kept.
//!
//! ```toml
//! version = 1                  # of this text, 2 of a map, 3 with a title, a focus or given water: a reader refuses what is newer
//! hachure = "0.1.0"            # who wrote it
//! world = "mountain.tif"       # as on the command line; without it, the embedded world
//! camera = "0,-2000,+300,0,-10,50"
//! sun = "315,40"               # azimuth and elevation in degrees
//! size = [1280, 720]           # in pixels, of one eye
//! dpi = 300.0                  # without it, a pixel of the style is a pixel
//! style = """…"""              # all of a style file
//! marks = { "mine.toml" = """…""" }      # recipes that the style names, and that are files
//! textures = { "mine.toml" = """…""" }
//! ```

use std::collections::BTreeMap;
use std::path::Path;

use glam::{DMat4, DVec3, DVec4};
use serde::{Deserialize, Serialize};

use crate::file::imprint::Matrices;
use crate::file::toml_text::{self, TomlError, Wrong};
use crate::file::{FileError, imprint};
use crate::remote;
use crate::scene::Sun;
use crate::scene::camera::Camera;
use crate::scene::view::{NEAR_M, Pose};
use crate::style::{Style, StyleError, StyleFiles};

/// Of the text. Another key that changes the drawing needs another version: 2 has maps, 3 titles, `focus` and `water`.
const VERSION: u32 = 3;
/// Of a map without any of these.
const VERSION_WITH_MAP: u32 = 2;
/// Of a text with none of them: older readers know all of it.
const FIRST_VERSION: u32 = 1;

/// Why a file's imprint is of no use. One line that names the file and the cause.
#[derive(Debug, thiserror::Error)]
pub enum ImprintError {
    /// There is none, or it cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// It is no such text.
    #[error("{} (its imprint)", .0)]
    Toml(#[from] TomlError),
    /// It was written by a later hachure.
    #[error(
        "cannot read {}: its imprint has version {version}, and this hachure knows {VERSION}; it was written by hachure {}",
        crate::file::message::named(name),
        crate::file::message::shown(hachure)
    )]
    Newer {
        /// The file.
        name: String,
        /// Of its imprint.
        version: u32,
        /// Who wrote it.
        hachure: String,
    },
    /// Its style does not hold.
    #[error("{} (the style of its imprint)", .0)]
    Style(#[from] StyleError),
}

/// How a picture was drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Imprint {
    /// As on the command line; none is the embedded world.
    pub world: Option<String>,
    /// As it was given, so that a height above ground stays one over another world.
    pub camera: Camera,
    /// In degrees.
    pub sun: Sun,
    /// As it was before [`Style::scaled`].
    pub style: Style,
    /// Of one eye.
    pub size_px: [u32; 2],
    /// Dots in an inch of paper.
    pub dpi: Option<f64>,
    /// All that has no part in most pictures.
    pub more: More,
}

/// What a picture was drawn with beside its style and its view, where that is not the default. Texts are as the command
/// line has them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct More {
    /// Of a scene with wind.
    pub time_s: Option<f64>,
    /// Of each pixel.
    pub samples: Option<u32>,
    /// In pixels.
    pub lod_error: Option<f64>,
    /// Heights that are voids.
    pub nodata: Option<f64>,
    /// Of heights in colours.
    pub encoding: Option<String>,
    /// Which eyes.
    pub eyes: Option<String>,
    /// How far apart they are.
    pub ipd: Option<String>,
    /// Where their axes meet.
    pub convergence: Option<f64>,
    /// Of `--map`; the camera is then the nearest that there is.
    pub map: Option<String>,
    /// Below the picture.
    pub title: Option<String>,
    /// Of `--focus`.
    pub focus: Option<String>,
    /// Of `--water`.
    pub water: Option<String>,
    /// Of `--show`.
    pub show: Option<String>,
    /// Of an SVG.
    pub paper: Option<String>,
    /// In millimetres.
    pub margin: Option<f64>,
    /// Of an SVG.
    pub tolerance_px: Option<f64>,
    /// How many draw an SVG.
    pub pens: Option<usize>,
    /// Of a film: its camera path.
    pub path: Option<String>,
    /// Of a film.
    pub fps: Option<f64>,
}

/// The least that a text of any version says.
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
    /// The text.
    pub fn text(&self) -> String {
        let StyleFiles { marks, textures } = self.style.recipe_files();
        let Sun { azimuth_deg, elevation_deg } = self.sun;
        // What stands behind the path of an address may be a key to it.
        let public = |world: &String| if world.contains("://") { remote::name_of(world) } else { world.clone() };
        let text = toml::to_string(&ImprintToml {
            version: match &self.more {
                More { title: None, focus: None, water: None, map: None, .. } => FIRST_VERSION,
                More { title: None, focus: None, water: None, .. } => VERSION_WITH_MAP,
                _ => VERSION,
            },
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

    /// Reads the text; `name` stands for the file in errors.
    ///
    /// # Errors
    /// A text that is no TOML, or not such a one; one of a later version.
    pub fn parse(name: &str, text: &str) -> Result<Self, ImprintError> {
        let VersionToml { version, hachure } = toml_text::read(name, text)?;
        if version > VERSION {
            return Err(ImprintError::Newer { name: name.to_owned(), version, hachure });
        }
        let found: ImprintToml = toml_text::read(name, text)?;
        let wrong = |key: &str, words: String| ImprintError::from(Wrong::new(key, words).in_text(name, text));
        if found.size.into_iter().any(|side| !(1..=1 << 20).contains(&side)) {
            return Err(wrong("size", format!(" must be from 1 to {}", 1 << 20)));
        }
        if found.dpi.is_some_and(|dpi| !(DPI_RANGE[0]..=DPI_RANGE[1]).contains(&dpi)) {
            return Err(wrong("dpi", format!(" must lie within {} to {}", DPI_RANGE[0], DPI_RANGE[1])));
        }
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

    /// Reads that of a PNG, EXR, SVG or MP4.
    ///
    /// # Errors
    /// [`ImprintError`].
    pub fn read(path: &Path) -> Result<Self, ImprintError> {
        Self::parse(&path.to_string_lossy(), &imprint::read(path)?)
    }
}

/// Dots in an inch that make sense.
pub const DPI_RANGE: [f64; 2] = [1.0, 10_000.0];

/// Where an eye is, for the attributes of an EXR.
pub fn matrices(pose: &Pose, size_px: [u32; 2]) -> Matrices {
    let turn = DMat4::from_cols(
        DVec4::from((pose.right, 0.0)),
        DVec4::from((pose.up, 0.0)),
        DVec4::from((-pose.forward, 0.0)),
        DVec4::W,
    );
    let camera_from_world = turn.transpose() * DMat4::from_translation(-pose.position_m);
    let focal = 1.0 / (0.5 * pose.fov_rad).tan();
    let aspect = f64::from(size_px[0]) / f64::from(size_px[1]);
    let scale = DMat4::from_scale(DVec3::new(focal / aspect, focal, 0.0));
    // z becomes the near plane's distance, and w the distance along the axis.
    let mut project = scale;
    project.w_axis = DVec4::new(0.0, 0.0, NEAR_M, 0.0);
    project.z_axis.w = -1.0;
    let by_rows = |matrix: DMat4| matrix.to_cols_array().map(|number| number as f32);
    // The columns of a matrix for column vectors are the rows of one for row vectors.
    Matrices { camera_from_world: by_rows(camera_from_world), ndc_from_world: by_rows(project * camera_from_world) }
}
