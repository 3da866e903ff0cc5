//! Styles: what a drawing is made of. A style file is TOML; what it does not name, its passes do not run.

pub mod color;
pub mod marks;
pub mod texture;

use std::path::Path;

use serde::Deserialize;

pub use color::Color;

/// The styles that come with the program, by name.
const PRESETS: &[(&str, &str)] = &[
    ("plain", include_str!("presets/plain.toml")),
    ("ink", include_str!("presets/ink.toml")),
    ("sobel", include_str!("presets/sobel.toml")),
    ("strokes", include_str!("presets/strokes.toml")),
    ("roystan", include_str!("presets/roystan.toml")),
    ("pen", include_str!("presets/pen.toml")),
    ("brush", include_str!("presets/brush.toml")),
    ("dry-ink", include_str!("presets/dry-ink.toml")),
    ("charcoal", include_str!("presets/charcoal.toml")),
    ("pencil-lines", include_str!("presets/pencil-lines.toml")),
];

/// A style that is not there or does not hold.
#[derive(Debug, thiserror::Error)]
pub enum StyleError {
    /// Neither a preset nor a file.
    #[error("{name}: no such style; there is {}, or the path of a style file (.toml)", names().join(", "))]
    Unknown {
        /// As given.
        name: String,
    },
    /// The file cannot be read.
    #[error("{path}: cannot read the style")]
    Read {
        /// The file.
        path: String,
        /// Why.
        #[source]
        source: std::io::Error,
    },
    /// Neither a stroke texture of the program nor a file.
    #[error("{name}: no such stroke texture; there is {}, or the path of a file (.toml)", texture::names().join(", "))]
    UnknownTexture {
        /// As given.
        name: String,
    },
    /// The stroke texture's file cannot be read.
    #[error("{path}: cannot read the stroke texture")]
    ReadTexture {
        /// The file.
        path: String,
        /// Why.
        #[source]
        source: std::io::Error,
    },
    /// Neither marks of the program nor a file.
    #[error("{name}: no such marks; there is {}, or the path of a file (.toml)", marks::names().join(", "))]
    UnknownMarks {
        /// As given.
        name: String,
    },
    /// The marks' file cannot be read.
    #[error("{path}: cannot read the marks")]
    ReadMarks {
        /// The file.
        path: String,
        /// Why.
        #[source]
        source: std::io::Error,
    },
    /// A picture of marks does not hold.
    #[error("{path}: {cause}")]
    MarkImage {
        /// The picture.
        path: String,
        /// What, in one line.
        cause: String,
    },
    /// The text is not a style, not a stroke texture, or not marks.
    #[error("{name}: {cause}")]
    Parse {
        /// The file or preset.
        name: String,
        /// What and where, in one line.
        cause: String,
    },
}

/// A style.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Style {
    /// For people and reports.
    pub name: String,
    /// In a line.
    pub description: String,
    /// Which lines; none draws none.
    pub lines: Option<Lines>,
    /// Pen strokes along contours; none draws none.
    pub strokes: Option<Strokes>,
    /// How light becomes colour.
    pub tone: Tone,
    /// What it is drawn on.
    #[serde(default)]
    pub paper: Paper,
    /// Above the horizon.
    #[serde(default)]
    pub sky: Sky,
    /// In the distance.
    #[serde(default)]
    pub haze: Haze,
}

/// Lines of a style.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lines {
    /// What finds them.
    pub detector: Detector,
    /// ε of LSA contours.
    #[serde(default)]
    pub epsilon: Epsilon,
    /// Errors at which a line begins and is full.
    pub ramp: [f32; 2],
    /// Strength of the line-density filter: 0 is off, 2 the paper's.
    #[serde(default)]
    pub density: f32,
    /// Whether stairs are smoothed.
    #[serde(default = "yes")]
    pub antialias: bool,
    /// Their colour.
    #[serde(default)]
    pub ink: Color,
    /// What is left of a line in full haze, 0 to 1.
    #[serde(default)]
    pub faintest: f32,
    /// How much farther than tones lines reach into the haze.
    #[serde(default = "one")]
    pub reach: f32,
}

/// Strokes of a style.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Strokes {
    /// Their colour.
    #[serde(default)]
    pub ink: Color,
    /// Their width in pixels.
    pub width_px: f32,
    /// What they are drawn with: one of [`texture::names`], or a file beside the style's (`.toml`). None is solid.
    #[serde(rename = "texture")]
    pub texture_name: Option<String>,
    /// What `texture_name` means.
    #[serde(skip)]
    pub texture: Option<texture::Recipe>,
    /// Over so many pixels they thin out at their ends.
    #[serde(default)]
    pub taper_px: f32,
    /// How much wider strokes are at bends, -1 to 1: 1 is twice the width at a right angle, below 0 they are thinner.
    #[serde(default)]
    pub curve_width: f32,
    /// How far the hand strays from the line, in pixels. What it does at a place of the world it does again.
    #[serde(default)]
    pub wobble_px: f32,
    /// Shorter strokes are left out: specks.
    #[serde(default = "four")]
    pub shortest_px: f32,
    /// How much wider near strokes are than far ones, 0 to 1.
    #[serde(default)]
    pub depth_width: f32,
    /// Pixels of the reference image per pixel of the picture, 1/4 to 1: what is seen of an edge is found at this scale.
    #[serde(default = "one")]
    pub resolution: f32,
    /// Ends this near in pixels may be joined.
    #[serde(default = "four")]
    pub join_px: f32,
    /// And those that turn by this angle at most, in degrees.
    #[serde(default = "sixty")]
    pub join_deg: f32,
    /// Edges that are sharper than this are drawn too, in degrees between their normals; none draws contours only.
    pub crease_deg: Option<f32>,
    /// Whether the border of the land is drawn.
    #[serde(default = "yes")]
    pub borders: bool,
    /// Strokes are made anew in each Nth frame; between, they move with the world.
    #[serde(default = "ten")]
    pub update_every: u32,
    /// Whether strokes take over from those of the frame before: identity, texture, pressure, part of the place.
    #[serde(default = "yes")]
    pub carry: bool,
    /// How long a stroke takes to come or go, in seconds, if it takes over from the frame before.
    #[serde(default = "fade_s")]
    pub fade_s: f32,
    /// How far the line of the frame before holds the new one in its place, 0 to 1.
    #[serde(default = "hold")]
    pub hold: f32,
    /// Length of all strokes together, at most, in pixels; the shortest are left out first.
    #[serde(default = "budget_px")]
    pub budget_px: f32,
    /// What is left of a stroke in full haze, 0 to 1.
    #[serde(default)]
    pub faintest: f32,
    /// How much farther than tones strokes reach into the haze.
    #[serde(default = "one")]
    pub reach: f32,
}

/// What finds lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Detector {
    /// Local Surface Approximation contours.
    Lsa,
    /// Sobel's operator on depth.
    Sobel,
    /// Roystan's outline.
    Roystan,
}

/// ε of the planarity term of LSA contours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Epsilon {
    /// 1e-5 m, as printed.
    Paper,
    /// A part of the pixel's size in the world.
    #[default]
    Footprint,
}

/// How light becomes colour.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "lowercase", tag = "kind")]
pub enum Tone {
    /// Blinn-Phong over an elevation tint.
    Plain,
    /// Steps.
    Toon(Toon),
}

/// Steps of light.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Toon {
    /// At least 2.
    pub steps: u32,
    /// Tone of the darkest step, 0 to 1.
    pub darkest: f32,
    /// Part of a step in which it fades to the next, 0 to 1.
    pub softness: f32,
}

/// The sheet.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Paper {
    /// Multiplies every colour.
    pub color: Color,
    /// How much of its grain shows, 0 to 1.
    pub grain: f32,
}

impl Default for Paper {
    fn default() -> Self {
        Self { color: Color::WHITE, grain: 0.0 }
    }
}

/// The sky's gradient.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Sky {
    /// High up.
    pub zenith: Color,
    /// Low down.
    pub horizon: Color,
}

impl Default for Sky {
    fn default() -> Self {
        Self { zenith: Color::WHITE, horizon: Color::WHITE }
    }
}

/// What distance does.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Haze {
    /// What far things fade to.
    pub color: Color,
    /// What is left of a tone in full haze, 0 to 1.
    pub faintest_tone: f32,
}

impl Default for Haze {
    fn default() -> Self {
        Self { color: Color::WHITE, faintest_tone: 0.0 }
    }
}

fn one() -> f32 {
    1.0
}

fn four() -> f32 {
    4.0
}

fn ten() -> u32 {
    10
}

fn fade_s() -> f32 {
    0.8
}

fn hold() -> f32 {
    0.7
}

fn budget_px() -> f32 {
    400_000.0
}

fn sixty() -> f32 {
    60.0
}

fn yes() -> bool {
    true
}

/// The names of the presets.
pub fn names() -> Vec<&'static str> {
    PRESETS.iter().map(|(name, _)| *name).collect()
}

/// The text of a preset.
pub fn preset_text(name: &str) -> Option<&'static str> {
    PRESETS.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

/// What TOML says; a mistake is told in one line, with its place.
fn from_toml<T: serde::de::DeserializeOwned>(name: &str, text: &str) -> Result<T, StyleError> {
    toml::from_str(text).map_err(|error| {
        let line = error.span().map_or(0, |span| text[..span.start.min(text.len())].matches('\n').count() + 1);
        StyleError::Parse { name: name.to_owned(), cause: format!("line {line}: {}", error.message()) }
    })
}

impl Strokes {
    fn check(&self) -> Result<(), String> {
        let within = |what: &str, value: f32, low: f32, high: f32| {
            let is_within = (low..=high).contains(&value);
            is_within.then_some(()).ok_or_else(|| format!("strokes.{what} is {value}, not between {low} and {high}"))
        };
        within("width_px", self.width_px, 0.5, 64.0)?;
        within("taper_px", self.taper_px, 0.0, 1000.0)?;
        within("shortest_px", self.shortest_px, 0.0, 1000.0)?;
        within("curve_width", self.curve_width, -1.0, 1.0)?;
        within("wobble_px", self.wobble_px, 0.0, 16.0)?;
        within("depth_width", self.depth_width, 0.0, 1.0)?;
        within("resolution", self.resolution, 0.25, 1.0)?;
        within("join_px", self.join_px, 1.0, 16.0)?;
        within("join_deg", self.join_deg, 0.0, 90.0)?;
        within("crease_deg", self.crease_deg.unwrap_or(0.0), 0.0, 180.0)?;
        within("faintest", self.faintest, 0.0, 1.0)?;
        within("fade_s", self.fade_s, 0.0, 60.0)?;
        within("hold", self.hold, 0.0, 1.0)?;
        within("budget_px", self.budget_px, 100.0, 500_000.0)?;
        if !(1..=1000).contains(&self.update_every) {
            return Err(format!("strokes.update_every is {}, not between 1 and 1000", self.update_every));
        }
        within("reach", self.reach, 1e-3, 1e6)
    }
}

impl Style {
    /// A preset by its name, or a style file by its path.
    ///
    /// # Errors
    /// [`StyleError`].
    pub fn load(name: &str) -> Result<Self, StyleError> {
        if let Some(text) = preset_text(name) {
            return Self::parse(name, text);
        }
        let path = Path::new(name);
        if path.extension().is_none_or(|extension| extension != "toml") {
            return Err(StyleError::Unknown { name: name.to_owned() });
        }
        let text =
            std::fs::read_to_string(path).map_err(|source| StyleError::Read { path: name.to_owned(), source })?;
        Self::parse(name, &text)
    }

    /// A style from its text; `name` is for errors, and a stroke texture that is a file lies beside it.
    ///
    /// # Errors
    /// [`StyleError`], but for [`StyleError::Unknown`] and [`StyleError::Read`].
    pub fn parse(name: &str, text: &str) -> Result<Self, StyleError> {
        let mut style: Self = from_toml(name, text)?;
        style.check().map_err(|cause| StyleError::Parse { name: name.to_owned(), cause })?;
        if let Some(strokes) = &mut style.strokes {
            let folder = Path::new(name).parent().unwrap_or(Path::new(""));
            let load = |texture: &String| texture::Recipe::load(texture, folder);
            strokes.texture = strokes.texture_name.as_ref().map(load).transpose()?;
        }
        Ok(style)
    }

    fn check(&self) -> Result<(), String> {
        let part = |what: &str, value: f32| {
            (0.0..=1.0).contains(&value).then_some(()).ok_or_else(|| format!("{what} is {value}, not between 0 and 1"))
        };
        if let Some(lines) = &self.lines {
            if !(lines.ramp[0] >= 0.0 && lines.ramp[1] > lines.ramp[0] && lines.ramp[1].is_finite()) {
                return Err(format!("lines.ramp is {:?}; it must rise, from 0 or more", lines.ramp));
            }
            if !(lines.density >= 0.0 && lines.density.is_finite()) {
                return Err(format!("lines.density is {}, not 0 or more", lines.density));
            }
            if !(lines.reach > 0.0 && lines.reach.is_finite()) {
                return Err(format!("lines.reach is {}, not above 0", lines.reach));
            }
            part("lines.faintest", lines.faintest)?;
        }
        if let Some(strokes) = &self.strokes {
            strokes.check()?;
        }
        if let Tone::Toon(toon) = &self.tone {
            if !(2..=64).contains(&toon.steps) {
                return Err(format!("tone.steps is {}, not between 2 and 64", toon.steps));
            }
            part("tone.darkest", toon.darkest)?;
            part("tone.softness", toon.softness)?;
        }
        part("paper.grain", self.paper.grain)?;
        part("haze.faintest_tone", self.haze.faintest_tone)
    }
}
