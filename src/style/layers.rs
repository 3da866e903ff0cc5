//! The ink layers of a style: everything that is drawn over the tones, from the bottom to the top.
//!
//! A style file lists its layers as `[[layers]]`, each with a `kind`. A layer describes itself to the rest of the
//! program by values ([`InkKind`]): its inks ([`Ink`]), the pass that draws it ([`InkPass`]), and how far its ink
//! depends on the picture around it ([`Reach`]). The composite, SVG and GeoJSON files, AOV channels, lettering, margins
//! of picture parts and scaling for paper iterate over these values, so they need no list of the kinds.
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

pub use cuts::{CUT_INK, Cuts, PlaneFamily};
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

/// Largest number of inks of a frame. The composite binds a picture for each, besides position, tone and sky, and a
/// device need not offer more than 16 pictures to a shader.
pub const MOST_INKS: usize = 12;

/// Ink of one colour that a layer draws. A layer has one ink or several; all of them are channels of the picture that
/// the layer's passes write.
#[derive(Clone, Debug, PartialEq)]
pub struct Ink {
    /// Identifier for scripts: the id of the layer in an SVG file, and the property `layer` in a GeoJSON file.
    pub id: &'static str,
    /// Label for people.
    pub label: String,
    /// Colour; `None` means that of lettering ([`Style::lettering_ink`]).
    pub color: Option<Color>,
    /// Which channels of the layer's picture hold the ink.
    pub channels: Channels,
    /// How the ink fades with distance and away from the focus.
    pub fading: Fading,
    /// Whether the ink reproduces the requested tone. The AOV channel `hatch` contains the inks that do.
    pub makes_tone: bool,
    /// Whether this is a main ink of the drawing: lettering may take its colour, and a vector file may consist of it
    /// alone. Shorelines and outlines of no-data areas, which only accompany a drawing, are not.
    pub is_main: bool,
    /// How the ink becomes lines in a vector file.
    pub trace: Trace,
}

/// The channels of a picture that hold an ink, each 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channels {
    /// The channel with this index.
    One(usize),
    /// The first channels, this many and at most three: one for each family of lines. The families cross each other.
    Crossed(usize),
}

/// How ink fades with distance and away from the focus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fading {
    /// The ink fades with the surface below it.
    OnSurface {
        /// Fraction of the ink that remains in full haze.
        faintest: f32,
        /// How many times farther than tones the ink reaches into the haze.
        reach: f32,
        /// Whether the amount of ink follows the tone. Tones already lose contrast away from the focus, so such ink
        /// itself fades less there.
        follows_tone: bool,
    },
    /// The ink fades with the nearest surface around it: detected lines cover both sides of an edge.
    OnNearest {
        /// Fraction of the ink that remains in full haze.
        faintest: f32,
        /// How many times farther than tones the lines reach into the haze.
        reach: f32,
    },
    /// The layer's own passes have already faded the ink.
    Done,
}

/// How ink becomes lines in a vector file.
#[derive(Clone, Debug, PartialEq)]
pub enum Trace {
    /// The ink is left out; the text names it in the report of what a vector file lacks.
    LeftOut(&'static str),
    /// Lines are traced in the picture of the ink, each family of [`Channels::Crossed`] separately.
    Picture,
    /// Sets of hatching marks are drawn and traced separately.
    Sets(Vec<Set>),
    /// The marks of rows are read back as lines, without tracing.
    Rows {
        /// Distance between neighbouring marks, in pixels.
        spacing_px: f32,
    },
    /// The strokes are read back as lines, without tracing.
    Strokes,
}

/// A set of hatching marks.
#[derive(Clone, Debug, PartialEq)]
pub struct Set {
    /// Label for people.
    pub label: String,
    /// Whether the marks are dots; then each is traced as a dot, not along its length.
    pub is_of_dots: bool,
}

/// A pass over the pixels of an eye that draws the ink of a layer. Its shader binds the uniform `rules` and the output
/// `ink`; it may also bind `view`, `surface_id`, `position`, `normal`, `tone` (its fourth channel is the requested
/// tone), `water` (a single texel in a style without water), and the terrain.
pub struct InkPass {
    /// Name of the shader, which is also that of the pass.
    pub shader: &'static str,
    /// Bytes of the uniform `rules`, in the layout of the shader's struct.
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
    /// Colour of the ink, or of lettering if the ink has none of its own.
    pub color: Color,
    pub ink: Ink,
}

impl InkLayer {
    /// Returns an identifier for scripts that is unique within the style. `part` is the number of a family of lines or
    /// of a set of marks, from 1.
    pub fn id(&self, part: Option<usize>) -> String {
        let part = part.map_or(String::new(), |part| format!("-{part}"));
        let number = if self.number > 0 { format!("-layer-{}", self.number + 1) } else { String::new() };
        format!("{}{part}{number}", self.ink.id)
    }
}

/// The description of a layer, on which the rest of the program relies instead of on its kind.
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

    /// Returns the name of the layer in a summary of the style; `None` omits it.
    fn summary(&self) -> Option<String> {
        None
    }

    /// Returns the name of what a vector file lacks of the layer, apart from inks that are [left out](Trace::LeftOut).
    fn missing_in_vectors(&self) -> Option<&'static str> {
        None
    }

    /// Returns the name of what keeps its size in pixels when the style is scaled for paper, if anything does.
    fn unscaled(&self) -> Option<&'static str> {
        None
    }

    /// Scales by `factor` what depends on the size of the picture but is not a parameter with the unit `px`; those are
    /// scaled by their definitions.
    fn scale_marks(&mut self, _factor: f32) {}

    /// Adapts the layer to the scale of a map whose pixels are `pixel_m` metres wide.
    fn prepare_for_map(&mut self, _pixel_m: f64) {}

    /// Completes a layer after parsing: loads its recipes and images, and sorts its lists. Returns the files that were
    /// read.
    ///
    /// # Errors
    /// The key within the layer, and the error.
    fn complete(&mut self, _source: RecipeSource<'_>) -> Result<Vec<PathBuf>, (String, StyleError)> {
        Ok(Vec::new())
    }
}

/// How far a layer's ink depends on the picture around it, in pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reach {
    /// The margin that the layer needs; the largest of all layers counts.
    pub margin_px: u32,
    /// A width that is added to the usual margin of a part, together with those of other layers.
    pub more_px: u32,
}

/// The source of a style's recipes.
#[derive(Clone, Copy)]
pub(crate) enum RecipeSource<'a> {
    /// Built-in recipes, and files relative to a folder.
    Folder(&'a Path),
    /// Built-in recipes, and texts that are stored in a picture.
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

                /// Replaces all layers of this kind with one, or with none. If there was none, the new one is inserted
                /// according to the order of kinds.
                pub fn $set(&mut self, layer: Option<$kind>) {
                    self.layers.replace($name, layer.map(Layer::$kind));
                }
            )+
        }
    };
}

// The order of kinds, from the bottom to the top. It is that of styles with sections instead of a list of layers, and
// of layers that are added to a style.
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

    /// Replaces all layers of a kind with `new`, which is inserted in place of the lowest of them, or, if there was
    /// none, according to the order of kinds.
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

    /// Returns the key of a layer: its kind, followed by a number from the second layer of the kind on, as in
    /// `cuts[1]`.
    pub(super) fn key(&self, index: usize) -> String {
        keyed(self.0[index].name(), self.number(index))
    }

    /// Returns how many layers of the same kind are below a layer.
    pub fn number(&self, index: usize) -> usize {
        let name = self.0[index].name();
        self.0[..index].iter().filter(|layer| layer.name() == name).count()
    }
}

/// Returns the key of the layer of a kind that has this number among layers of its kind.
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
        // Lines from shading have two inks, and trees have detected lines in a style that draws only strokes.
        let has = |name: &str| self.iter().any(|layer| layer.name() == name);
        let more = usize::from(has("tone_lines")) + usize::from(has("strokes") && !has("lines"));
        let inks = self.len() + more;
        if inks > MOST_INKS {
            let words = format!(
                " have {inks} inks, but a style can have {MOST_INKS}; outlines of no-data areas and the lines of trees \
                 count, and tone_lines has two"
            );
            return Err(Wrong::new(key, words));
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
