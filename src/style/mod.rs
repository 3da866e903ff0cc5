//! Styles: what a drawing is made of. A style file is TOML; what it does not name, its passes do not run.

pub mod color;
pub mod hatching;
mod lines;
pub mod marks;
mod strokes;
pub mod texture;
mod tone;

use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::file::input::{LARGEST_STYLE_BYTES, read_text};
use crate::file::message::{did_you_mean, named, shown};
use crate::file::toml_text::{self, TomlError};
pub use color::Color;
pub use lines::{Detector, Epsilon, Lines};
pub use strokes::Strokes;
pub use tone::{Attribute, Ramp, Shading, Stop, Tone, Toon, Watercolor};

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
    ("hachures", include_str!("presets/hachures.toml")),
    ("crosshatch", include_str!("presets/crosshatch.toml")),
    ("stipple", include_str!("presets/stipple.toml")),
    ("pencil", include_str!("presets/pencil.toml")),
    ("engraving", include_str!("presets/engraving.toml")),
    ("woodcut", include_str!("presets/woodcut.toml")),
    ("wash", include_str!("presets/wash.toml")),
];

/// A style that is not there or does not hold.
#[derive(Debug, thiserror::Error)]
pub enum StyleError {
    /// Neither a preset nor a file.
    #[error("{}: no such style{}", shown(name), hint(name, &names(), "`hachure styles` lists them"))]
    Unknown {
        /// As given.
        name: String,
    },
    /// The file cannot be read.
    #[error("{}: cannot read the style: {source}", named(path))]
    Read {
        /// The file.
        path: String,
        /// Why.
        #[source]
        source: std::io::Error,
    },
    /// Neither a stroke texture of the program nor a file.
    #[error("{}: no such stroke texture{}", shown(name), hint(name, &texture::names(), &there_is(&texture::names())))]
    UnknownTexture {
        /// As given.
        name: String,
    },
    /// The stroke texture's file cannot be read.
    #[error("{}: cannot read the stroke texture: {source}", named(path))]
    ReadTexture {
        /// The file.
        path: String,
        /// Why.
        #[source]
        source: std::io::Error,
    },
    /// Neither marks of the program nor a file.
    #[error("{}: no such marks{}", shown(name), hint(name, &marks::names(), &there_is(&marks::names())))]
    UnknownMarks {
        /// As given.
        name: String,
    },
    /// The marks' file cannot be read.
    #[error("{}: cannot read the marks: {source}", named(path))]
    ReadMarks {
        /// The file.
        path: String,
        /// Why.
        #[source]
        source: std::io::Error,
    },
    /// A picture of marks does not hold.
    #[error("{}: {cause}", named(path))]
    MarkImage {
        /// The picture.
        path: String,
        /// What, in one line.
        cause: String,
    },
    /// The text is not a style, not a stroke texture, or not marks.
    #[error(transparent)]
    Parse(#[from] TomlError),
}

/// What a name was meant to be, or where the known names are told.
fn hint(name: &str, known: &[&str], where_told: &str) -> String {
    let meant = did_you_mean(name, known.iter().copied());
    if meant.is_empty() { format!("; {where_told}, and a file ends with .toml") } else { meant }
}

fn there_is(names: &[&str]) -> String {
    format!("there is {}", names.join(", "))
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
    /// How light falls, for tones in steps and for marks.
    #[serde(default)]
    pub light: Shading,
    /// Tones that run and settle as water and pigment do; none lets them be.
    pub watercolor: Option<Watercolor>,
    /// Tones made of marks; none draws none.
    pub hatching: Option<hatching::Hatching>,
    /// What it is drawn on.
    #[serde(default)]
    pub paper: Paper,
    /// Above the horizon.
    #[serde(default)]
    pub sky: Sky,
    /// In the distance.
    #[serde(default)]
    pub haze: Haze,
    /// All files that it was read from: its own, those of its recipes, and their pictures. A preset has none.
    #[serde(skip)]
    pub files: Vec<PathBuf>,
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

fn yes() -> bool {
    true
}

/// Says which number is not what it may be.
fn within(what: &str, value: f32, low: f32, high: f32) -> Result<(), String> {
    (low..=high)
        .contains(&value)
        .then_some(())
        .ok_or_else(|| format!("{what} is {value}, not between {low} and {high}"))
}

/// The names of the presets.
pub fn names() -> Vec<&'static str> {
    PRESETS.iter().map(|(name, _)| *name).collect()
}

/// The text of a preset.
pub fn preset_text(name: &str) -> Option<&'static str> {
    PRESETS.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

/// A number that is not what it may be: `cause` begins with its key, whose place in the text is told.
fn misplaced(name: &str, text: &str, cause: &str) -> StyleError {
    let (key, rest) = cause.split_once(' ').unwrap_or((cause, ""));
    // The place tells which entry of a list it is.
    let told = key.split('[').map(|part| part.split_once(']').map_or(part, |(_, rest)| rest)).collect::<String>();
    toml_text::wrong(name, text, key, format!("{told} {rest}")).into()
}

impl Style {
    /// Whether tones ask what the land sees of the sun and of the sky.
    pub fn asks_for_horizons(&self) -> bool {
        matches!(self.tone, Tone::Toon(_)) && (self.light.shadow > 0.0 || self.light.occlusion > 0.0)
    }

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
        Self::read(path)
    }

    /// A style from a file, whatever its name ends with.
    ///
    /// # Errors
    /// [`StyleError`].
    pub fn read(path: &Path) -> Result<Self, StyleError> {
        let name = path.display().to_string();
        let text =
            read_text(path, LARGEST_STYLE_BYTES).map_err(|source| StyleError::Read { path: name.clone(), source })?;
        let mut style = Self::parse(&name, &text)?;
        style.files.push(path.to_owned());
        Ok(style)
    }

    /// A style from its text; `name` is for errors, and a stroke texture that is a file lies beside it.
    ///
    /// # Errors
    /// [`StyleError`], but for [`StyleError::Unknown`] and [`StyleError::Read`].
    pub fn parse(name: &str, text: &str) -> Result<Self, StyleError> {
        let mut style: Self = toml_text::read(name, text)?;
        style.check().map_err(|cause| misplaced(name, text, &cause))?;
        let folder = Path::new(name).parent().unwrap_or(Path::new(""));
        if let Some(hatching) = &mut style.hatching {
            hatching.check().map_err(|cause| misplaced(name, text, &cause))?;
            hatching.complete(folder)?;
            style.files.extend(hatching.layers.iter().flat_map(|layer| layer.files(folder)));
        }
        if let Some(strokes) = &mut style.strokes {
            let load = |texture: &String| texture::Recipe::load(texture, folder);
            strokes.texture = strokes.texture_name.as_ref().map(load).transpose()?;
            style.files.extend(strokes.texture_name.as_ref().and_then(|name| texture::file(name, folder)));
        }
        Ok(style)
    }

    fn check(&self) -> Result<(), String> {
        if let Some(lines) = &self.lines {
            lines.check()?;
        }
        if let Some(strokes) = &self.strokes {
            strokes.check()?;
        }
        if let Tone::Toon(toon) = &self.tone {
            toon.check()?;
        }
        if let Some(watercolor) = &self.watercolor {
            watercolor.check()?;
        }
        self.light.check()?;
        within("paper.grain", self.paper.grain, 0.0, 1.0)?;
        within("haze.faintest_tone", self.haze.faintest_tone, 0.0, 1.0)
    }
}
