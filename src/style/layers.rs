//! The ink layers of a style: everything that is drawn over the tones, from the bottom to the top.
//!
//! A style file lists its layers as `[[layers]]`, each with a `kind`. What the rest of the program needs to know about a
//! layer is a value: its inks ([`Ink`]), the pass that draws it ([`InkPass`]), and how far it reaches. The composite, SVG
//! and GeoJSON files, AOV channels, lettering, margins of picture parts and scaling for paper iterate over these values,
//! so they know no kinds.
//!
//! To add a kind, write `layers/KIND.rs` with its parameters and its [`InkKind`], write its shader
//! `shaders/layers/KIND.wgsl`, and register it in this file: a `mod` line, and a line in `layer_kinds!`.
//!
//! Why: `docs/decisions/ink-layers.md`.

mod cuts;
mod form;
pub mod hatching;
mod height_lines;
mod lines;
mod rims;
mod rows;
mod strokes;
mod tone_lines;
mod water;

use std::ops::{Deref, DerefMut};
use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::{Deserialize, Deserializer};
use toml_edit::{ArrayOfTables, Item, Table, value};

pub use cuts::{CUT_INK, CutLayer, Cuts};
pub(crate) use form::written_key;
pub(super) use form::{add_missing_layer, keys_of_layers, migrated, with_layers};
pub use hatching::Hatching;
pub use height_lines::{HEIGHT_INK, HeightLines};
pub use lines::{Detector, Epsilon, Lines, Stereo};
pub use rims::Rims;
pub use rows::Rows;
pub use strokes::Strokes;
pub use tone_lines::{ToneLight, ToneLines};
pub use water::Water;

use super::held::StyleFiles;
use super::parameters::{Definition, Range, Setting, ValueKind};
use super::{Color, Style, StyleError, marks, texture};
use crate::file::toml_text::Wrong;
use crate::gpu::target::TargetKind;

/// Largest number of layers of a style: the composite binds the ink of each, and a device need not offer more than 16
/// pictures to a shader.
pub const MOST_LAYERS: usize = 11;

/// Ink of one colour, which a layer puts on the paper. A layer has one ink or several; all of them are channels of the
/// picture that the layer's pass writes.
#[derive(Clone, Debug, PartialEq)]
pub struct Ink {
    /// Id for scripts: that of the layer in an SVG, and the `layer` of a GeoJSON.
    pub id: &'static str,
    /// Label for people.
    pub label: String,
    /// Colour; `None` is the colour of lettering.
    pub color: Option<Color>,
    /// Which channels of the layer's picture hold the ink.
    pub channels: Channels,
    /// How the ink fades with distance and away from the focus.
    pub fading: Fading,
    /// Whether the ink reproduces the requested tone, so that it counts for the AOV channel `hatch`.
    pub makes_tone: bool,
    /// Whether the drawing consists of it: lettering takes its colour, and it is enough for a file of lines. Shores and
    /// outlines of no-data areas accompany a drawing.
    pub is_main: bool,
    /// How the ink becomes lines in a vector file.
    pub trace: Trace,
}

/// The channels of a picture that hold an ink, each 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channels {
    /// One channel.
    One(usize),
    /// The first channels, one for each of several families of lines that cross each other; at most three.
    Crossed(usize),
}

/// How ink fades with distance and away from the focus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fading {
    /// Ink fades as the surface that it lies on.
    OnSurface {
        /// Fraction of the ink that remains in full haze.
        faintest: f32,
        /// How many times farther than tones the ink reaches into the haze.
        reach: f32,
        /// Whether the amount of ink follows the tone, which has already lost its share of the focus.
        follows_tone: bool,
    },
    /// Detected lines cover both sides of an edge and fade as the nearer of the two.
    OnNearest {
        /// Fraction of the ink that remains in full haze.
        faintest: f32,
        /// How many times farther than tones the lines reach into the haze.
        reach: f32,
    },
    /// The layer's own passes have faded the ink.
    Done,
}

/// How ink becomes lines in a vector file.
#[derive(Clone, Debug, PartialEq)]
pub enum Trace {
    /// Not at all; the text names what a vector file leaves out.
    LeftOut(&'static str),
    /// Lines are traced in the picture, each family of [`Channels::Crossed`] by itself.
    Picture,
    /// Sets of hatching marks are drawn and traced one by one.
    Sets(Vec<Set>),
    /// Marks of rows are known as lines.
    Rows {
        /// Distance between neighbouring marks, in pixels.
        spacing_px: f32,
    },
    /// Strokes are known as lines.
    Strokes,
}

/// A set of hatching marks.
#[derive(Clone, Debug, PartialEq)]
pub struct Set {
    /// Label for people.
    pub label: String,
    /// Whether the marks are dots, which are not traced along their length.
    pub is_of_dots: bool,
}

/// A pass over the pixels of an eye that draws the ink of a layer. The shader finds its uniform as `rules` and writes
/// `ink`; it may also bind `view`, `surface_id`, `position`, `normal`, `tone` (the requested tone is its fourth channel),
/// `water` (a single texel without water), and the terrain.
pub struct InkPass {
    /// Name of the shader, which is also that of the pass.
    pub shader: &'static str,
    /// Bytes of the uniform `rules`.
    pub rules: Vec<u8>,
    /// The picture that the pass writes.
    pub ink: &'static TargetKind,
}

/// An ink of a style with its layer.
#[derive(Clone, Debug, PartialEq)]
pub struct InkLayer {
    /// Index of the layer in [`Style::layers`]; `None` for the ink of the sky.
    pub layer: Option<usize>,
    /// How many layers of the same kind are below this one.
    pub number: usize,
    /// Linear RGB is [`Color::linear`].
    pub color: Color,
    pub ink: Ink,
}

impl InkLayer {
    /// Returns an id for scripts that no other ink of the style has; `part` is that of a family or a set, from 1 on.
    pub fn id(&self, part: Option<usize>) -> String {
        let part = part.map_or(String::new(), |part| format!("-{part}"));
        let number = if self.number > 0 { format!("-layer-{}", self.number + 1) } else { String::new() };
        format!("{}{part}{number}", self.ink.id)
    }
}

/// What the rest of the program needs to know about a kind of layer.
pub(crate) trait InkKind {
    /// Returns the inks of the layer, from the bottom to the top; none if it draws nothing.
    fn inks(&self) -> Vec<Ink>;

    /// Returns the pass that draws the layer. Kinds without one have passes of their own in `src/frame`. `origin_m` is
    /// the rig's origin in the world, to which positions on the GPU are relative.
    fn pass(&self, _origin_m: DVec3) -> Option<InkPass> {
        None
    }

    /// Returns how far from a pixel its ink depends on the picture, in pixels: the margin of a part of a large picture.
    fn reach_px(&self) -> Reach {
        Reach::default()
    }

    /// Returns what the layer is in a summary of the style; `None` leaves it out.
    fn summary(&self) -> Option<String> {
        None
    }

    /// Returns what a vector file leaves out of the layer, besides [`Trace::LeftOut`].
    fn missing_in_vectors(&self) -> Option<&'static str> {
        None
    }

    /// Returns what of the layer cannot be scaled for paper.
    fn unscaled(&self) -> Option<&'static str> {
        None
    }

    /// Multiplies what lengths with the unit `px` do not cover by `factor`.
    fn scale_marks(&mut self, _factor: f32) {}

    /// Changes what depends on the scale of a map whose pixels are `pixel_m` metres.
    fn prepare_for_map(&mut self, _pixel_m: f64) {}

    /// Loads recipes and images, and sorts what is sorted; returns the files that were read.
    ///
    /// # Errors
    /// The key within the layer, and what is wrong.
    fn complete(&mut self, _source: RecipeSource<'_>) -> Result<Vec<PathBuf>, (String, StyleError)> {
        Ok(Vec::new())
    }
}

/// How far a layer's ink depends on the picture around it, in pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reach {
    /// The margin that is enough for the layer by itself.
    pub margin_px: u32,
    /// What is added to the margin of every style.
    pub more_px: u32,
}

/// Where a style finds its recipes.
#[derive(Clone, Copy)]
pub(crate) enum RecipeSource<'a> {
    /// Built-in recipes, and files relative to a folder.
    Folder(&'a Path),
    /// Built-in recipes, and texts that a picture has stored.
    Held(&'a StyleFiles),
}

impl RecipeSource<'_> {
    /// Returns the recipe of hatching marks with this name.
    fn marks(self, name: &str) -> Result<marks::Recipe, StyleError> {
        let here = Path::new("");
        match self {
            Self::Folder(folder) => marks::Recipe::load(name, folder),
            Self::Held(held) => match held.marks.get(name) {
                Some(text) => marks::Recipe::parse(name, text),
                None if marks::file(name, here).is_none() => marks::Recipe::load(name, here),
                None => Err(StyleError::UnknownMarks { name: name.to_owned() }),
            },
        }
    }

    /// Returns the stroke texture with this name, if there is a name.
    pub(super) fn texture(self, name: Option<&str>) -> Result<Option<texture::Recipe>, StyleError> {
        let Some(name) = name else { return Ok(None) };
        let here = Path::new("");
        match self {
            Self::Folder(folder) => texture::Recipe::load(name, folder),
            Self::Held(held) => match held.textures.get(name) {
                Some(text) => texture::Recipe::parse(name, text),
                None if texture::file(name, here).is_none() => texture::Recipe::load(name, here),
                None => Err(StyleError::UnknownTexture { name: name.to_owned() }),
            },
        }
        .map(Some)
    }
}

/// Generates [`Layer`] and the accessors of [`Style`] from the list of kinds.
macro_rules! layer_kinds {
    ($(
        $(#[doc = $help:literal])+
        $name:literal $kind:ident: $get:ident, $get_mut:ident, $set:ident, at most $most:literal;
    )+) => {
        /// An ink layer of a style.
        #[derive(Clone, Debug, PartialEq, Deserialize)]
        pub enum Layer {
            $(
                $(#[doc = $help])+
                #[serde(rename = $name)]
                $kind($kind),
            )+
        }

        /// The name of each kind, and how many layers of it a style may have.
        const KINDS: &[(&str, usize)] = &[$(($name, $most)),+];

        impl Layer {
            /// Returns the kind, as written in a style file.
            pub fn name(&self) -> &'static str {
                match self {
                    $(Self::$kind(_) => $name,)+
                }
            }

            pub(crate) fn kind(&self) -> &dyn InkKind {
                match self {
                    $(Self::$kind(layer) => layer,)+
                }
            }

            pub(crate) fn kind_mut(&mut self) -> &mut dyn InkKind {
                match self {
                    $(Self::$kind(layer) => layer,)+
                }
            }

            fn check(&self, key: &str) -> Result<(), Wrong> {
                match self {
                    $(Self::$kind(layer) => Setting::check(layer, key, &Range::Any),)+
                }
            }

            fn scale_lengths(&mut self, factor: f32) {
                match self {
                    $(Self::$kind(layer) => Setting::scale_lengths(layer, factor, None, &Range::Any),)+
                }
            }

            fn item(&self) -> Option<Item> {
                match self {
                    $(Self::$kind(layer) => Setting::item(layer),)+
                }
            }
        }

        fn definitions() -> Vec<Definition> {
            vec![$(Definition::of::<$kind>($name, concat!($($help),+), &[], Range::Any, None)),+]
        }

        impl Style {
            $(
                /// Returns the lowest layer of this kind.
                pub fn $get(&self) -> Option<&$kind> {
                    self.layers.iter().find_map(|layer| match layer {
                        Layer::$kind(layer) => Some(layer),
                        _ => None,
                    })
                }

                /// Returns the lowest layer of this kind.
                pub fn $get_mut(&mut self) -> Option<&mut $kind> {
                    self.layers.iter_mut().find_map(|layer| match layer {
                        Layer::$kind(layer) => Some(layer),
                        _ => None,
                    })
                }

                /// Replaces all layers of this kind by one, or by none. A new one is put where a style with sections
                /// has it.
                pub fn $set(&mut self, layer: Option<$kind>) {
                    self.layers.replace($name, layer.map(Layer::$kind));
                }
            )+
        }
    };
}

// From the bottom to the top: the order of styles with sections, and of layers that a file does not list.
layer_kinds! {
    /// Lines from shading, found in a shaded image of the scene.
    "tone_lines" ToneLines: tone_lines, tone_lines_mut, set_tone_lines, at most 1;
    /// Contour lines of height.
    "height_lines" HeightLines: height_lines, height_lines_mut, set_height_lines, at most 4;
    /// Tones drawn as hatching marks.
    "hatching" Hatching: hatching, hatching_mut, set_hatching, at most 1;
    /// Lines where parallel planes cut the land; hatching of the same style then applies only to models and trees.
    "cuts" Cuts: cuts, cuts_mut, set_cuts, at most 4;
    /// Rows of hachures on the land; hatching of the same style then applies only to models and trees.
    "rows" Rows: rows, rows_mut, set_rows, at most 1;
    /// Lakes and the sea; without this layer they are drawn as land.
    "water" Water: water, water_mut, set_water, at most 1;
    /// Dashed lines around no-data areas; a style that does not list this layer has it with its default values.
    "rims" Rims: rims, rims_mut, set_rims, at most 1;
    /// Lines that are detected in images of the surface.
    "lines" Lines: lines, lines_mut, set_lines, at most 1;
    /// Pen strokes along contours.
    "strokes" Strokes: strokes, strokes_mut, set_strokes, at most 1;
}

/// The ink layers of a style, from the bottom to the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers(Vec<Layer>);

impl Default for Layers {
    fn default() -> Self {
        Self::with_rims(Vec::new())
    }
}

impl Deref for Layers {
    type Target = Vec<Layer>;

    fn deref(&self) -> &Vec<Layer> {
        &self.0
    }
}

impl DerefMut for Layers {
    fn deref_mut(&mut self) -> &mut Vec<Layer> {
        &mut self.0
    }
}

impl Layers {
    /// Adds the outlines of no-data areas to layers that lack them.
    fn with_rims(layers: Vec<Layer>) -> Self {
        let mut layers = Self(layers);
        if !layers.iter().any(|layer| matches!(layer, Layer::Rims(_))) {
            layers.replace("rims", Rims::left_out().map(Layer::Rims));
        }
        layers
    }

    /// Replaces all layers of a kind by `new`, which takes the place of the lowest of them, or of layers of its kind in
    /// the order of kinds.
    fn replace(&mut self, name: &str, new: Option<Layer>) {
        let rank = |name: &str| KINDS.iter().position(|(known, _)| *known == name);
        let is_above = |layer: &Layer| rank(layer.name()) > rank(name);
        let held = self.0.iter().position(|layer| layer.name() == name);
        let place = held.or_else(|| self.0.iter().position(is_above)).unwrap_or(self.0.len());
        let (mut below, mut above) = (self.0[..place].to_vec(), self.0[place..].to_vec());
        above.retain(|layer| layer.name() != name);
        below.extend(new);
        below.append(&mut above);
        self.0 = below;
    }

    /// Returns the key of a layer: its kind, and from the second of the kind on the number, as in `cuts[1]`.
    pub(super) fn key(&self, index: usize) -> String {
        keyed(self.0[index].name(), self.number(index))
    }

    /// Returns how many layers of the same kind are below a layer.
    pub fn number(&self, index: usize) -> usize {
        let name = self.0[index].name();
        self.0[..index].iter().filter(|layer| layer.name() == name).count()
    }
}

/// Returns the key of a layer of a kind.
fn keyed(name: &str, number: usize) -> String {
    if number > 0 { format!("{name}[{number}]") } else { name.to_owned() }
}

/// Returns the names of the kinds of layers, from the bottom to the top.
pub fn layer_names() -> impl Iterator<Item = &'static str> + Clone {
    KINDS.iter().map(|(name, _)| *name)
}

/// Returns whether a style may have layers of this kind.
pub(super) fn is_kind(name: &str) -> bool {
    KINDS.iter().any(|(known, _)| *known == name)
}

impl<'de> Deserialize<'de> for Layers {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(Self::with_rims(Vec::deserialize(deserializer)?))
    }
}

impl Setting for Layers {
    fn kind() -> ValueKind {
        ValueKind::Layers(definitions())
    }

    fn left_out() -> Option<Self> {
        Some(Self::default())
    }

    fn check(&self, key: &str, _: &Range) -> Result<(), Wrong> {
        let count = self.len();
        if count > MOST_LAYERS {
            return Err(Wrong::new(key, format!(" has {count} entries, not at most {MOST_LAYERS}")));
        }
        for (index, layer) in self.iter().enumerate() {
            let key = self.key(index);
            let most = KINDS.iter().find(|(name, _)| *name == layer.name()).map_or(0, |(_, most)| *most);
            if self.number(index) >= most {
                let layers = if most == 1 { "one layer" } else { "layers" };
                let words = format!(": a style has at most {most} {layers} of this kind").replace("1 one", "one");
                return Err(Wrong::new(key, words));
            }
            layer.check(&key)?;
        }
        Ok(())
    }

    fn scale_lengths(&mut self, factor: f32, _: Option<&str>, _: &Range) {
        self.iter_mut().for_each(|layer| {
            layer.scale_lengths(factor);
            layer.kind_mut().scale_marks(factor);
        });
    }

    fn item(&self) -> Option<Item> {
        let table = |layer: &Layer| {
            let mut table = Table::new();
            table.insert("kind", value(layer.name()));
            for (key, item) in layer.item()?.into_table().ok()? {
                table.insert(&key, item);
            }
            Some(table)
        };
        Some(Item::ArrayOfTables(self.iter().filter_map(table).collect::<ArrayOfTables>()))
    }
}

impl Style {
    /// Returns the style without layers of these kinds, which are named as in a style file.
    #[must_use]
    pub fn without(mut self, kinds: &[&str]) -> Self {
        self.layers.retain(|layer| !kinds.contains(&layer.name()));
        self
    }

    /// Returns the inks of the style, from the bottom to the top.
    pub fn ink_layers(&self) -> Vec<InkLayer> {
        let lettering = self.lettering_ink();
        self.inks()
            .map(|(layer, number, ink)| InkLayer { layer, number, color: ink.color.unwrap_or(lettering), ink })
            .collect()
    }

    /// Returns each ink with the index of its layer and the layer's number among those of its kind.
    fn inks(&self) -> impl DoubleEndedIterator<Item = (Option<usize>, usize, Ink)> {
        let of_sky = self.sky.lines().into_iter().map(|ink| (None, 0, ink));
        let of_layers = self.layers.iter().enumerate().flat_map(|(index, layer)| {
            let number = self.layers.number(index);
            layer.kind().inks().into_iter().map(move |ink| (Some(index), number, ink))
        });
        of_sky.chain(of_layers)
    }

    /// Returns the colour of lettering on bare paper: the topmost ink of the drawing that has enough contrast to the
    /// paper.
    pub fn lettering_ink(&self) -> Color {
        let paper = self.paper.color;
        let own = self.inks().rev().filter(|(_, _, ink)| ink.is_main).filter_map(|(_, _, ink)| ink.color);
        let border = (self.paper.border_px > 0.0).then_some(self.paper.border);
        let seen = own.chain(border).find(|ink| has_contrast(*ink, paper));
        seen.unwrap_or(if lightness(paper) > 0.5 { Color::default() } else { Color::WHITE })
    }
}

/// Least difference in lightness between lettering and paper, as a fraction of that between black and white.
const LEAST_CONTRAST: f32 = 0.4;

fn has_contrast(ink: Color, paper: Color) -> bool {
    (lightness(ink) - lightness(paper)).abs() > LEAST_CONTRAST
}

/// Returns the mean of the sRGB channels of a colour, 0 to 1.
fn lightness(color: Color) -> f32 {
    color.srgb().iter().sum::<f32>() / 3.0
}
