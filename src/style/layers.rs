//! The ink layers of a style: everything that is drawn over the tones, from the bottom to the top.
//!
//! A style file lists its layers as `[[layers]]`, each with a `kind`. A layer describes itself to the rest of the
//! program by the values that the methods of [`LayerBehaviour`] return: its inks ([`Ink`]), the pass that draws it
//! ([`InkPass`]), and how far around a pixel its ink depends on other pixels ([`Margins`]). The composite, SVG and
//! GeoJSON files, AOV channels, lettering, margins of picture parts and scaling for paper iterate over these values, so
//! they need no list of the kinds. Only `frame/passes.rs` has one, of the pictures that kinds with passes of their own
//! draw.
//!
//! To add a kind, write `layers/KIND.rs` with its parameters and its [`LayerBehaviour`], write its shader
//! `shaders/layers/KIND.wgsl`, register it in this file (a `mod` line, and a line in `layer_kinds!`, at its place in
//! the order), name it in `finish` of `frame/passes.rs`, and add a row to the table in `docs/styles.md`.
//!
//! Why: `docs/decisions/ink-layers.md`.

mod cuts;
mod drainage;
mod features;
mod form;
mod ground;
pub mod hatching;
mod height_lines;
mod ink;
mod lines;
#[cfg(any(feature = "window", feature = "headset"))]
mod order;
mod rims;
mod rows;
mod source;
mod strokes;
mod tone_lines;
mod water;

use std::ops::Deref;

use serde::{Deserialize, Deserializer};
use toml_edit::{ArrayOfTables, Item, Table, value};

#[cfg(test)]
pub(crate) use cuts::CUT_INK;
pub use cuts::{Cuts, PlaneFamily};
pub use drainage::{Drainage, DrainageLines, DrainageViews};
pub(crate) use features::GRATICULE;
pub use features::{FeatureKinds, Features};
pub(crate) use form::key_in_document;
pub(super) use form::{add_missing_layer, keys_of_layers, migrated, with_layers};
#[cfg(test)]
pub(crate) use ground::GROUND_INK;
pub use ground::Ground;
pub(crate) use hatching::Hatching;
#[cfg(test)]
pub(crate) use height_lines::HEIGHT_INK;
pub(crate) use height_lines::{HEIGHT_LINES, LINES_PER_INDEX};
pub use height_lines::{HeightLines, HeightsOf};
pub(crate) use ink::{
    Channels, Fading, Ink, InkPass, LandOfPass, LayerBehaviour, MAX_INKS, Margins, StyleInk, Trace, TracedSet,
};
pub(crate) use lines::Measure;
pub use lines::{Detector, Epsilon, Lines, Stereo};
#[cfg(any(feature = "window", feature = "headset"))]
pub(super) use order::number_headers;
#[cfg(any(feature = "window", feature = "headset"))]
pub(crate) use order::{LayerEdit, with_layer_edit};
pub use rims::Rims;
pub use rows::Rows;
pub(crate) use source::RecipeSource;
pub use strokes::Strokes;
pub use tone_lines::{ToneLight, ToneLines};
pub use water::Water;

use super::parameters::{Definition, Range, Setting, ValueKind};
use super::{Color, Style};
use crate::file::toml_text::Wrong;

/// Generates [`Layer`] and the accessors of [`Style`] from the list of kinds.
macro_rules! layer_kinds {
    ($(
        $(#[doc = $help:literal])+
        $name:literal $kind:ident $(, called $label:literal)?: $get:ident, $get_mut:ident, $set:ident, at most $max:literal;
    )+) => {
        /// An ink layer of a style.
        #[expect(clippy::large_enum_variant, reason = "a style has few layers")]
        #[derive(Clone, Debug, PartialEq, Deserialize)]
        pub enum Layer {
            $(
                $(#[doc = $help])+
                #[serde(rename = $name)]
                $kind($kind),
            )+
        }

        /// The name of each kind, and how many layers of it a style may have.
        const KINDS: &[(&str, usize)] = &[$(($name, $max)),+];

        impl Layer {
            /// Returns the kind, as written in a style file.
            pub fn kind(&self) -> &'static str {
                match self {
                    $(Self::$kind(_) => $name,)+
                }
            }

            /// Returns the layer in the form that the rest of the program uses for all kinds.
            pub(crate) fn behaviour(&self) -> &dyn LayerBehaviour {
                match self {
                    $(Self::$kind(layer) => layer,)+
                }
            }

            pub(crate) fn behaviour_mut(&mut self) -> &mut dyn LayerBehaviour {
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
            vec![$(
                Definition::of::<$kind>($name, concat!($($help),+), &[], Range::Any, None).with_label(&[$($label)?])
            ),+]
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
                #[cfg(test)]
                #[allow(dead_code, reason = "tests replace only some kinds")]
                pub(crate) fn $get_mut(&mut self) -> Option<&mut $kind> {
                    self.layers.iter_mut().find_map(|layer| match layer {
                        Layer::$kind(layer) => Some(layer),
                        _ => None,
                    })
                }

                /// Replaces all layers of this kind with one, or with none. If there was none, the new one is inserted
                /// according to the order of kinds.
                #[cfg(test)]
                #[allow(dead_code, reason = "tests replace only some kinds")]
                pub(crate) fn $set(&mut self, layer: Option<$kind>) {
                    self.layers.replace($name, layer.map(Layer::$kind));
                }
            )+
        }
    };
}

// The order of kinds, from the bottom to the top. Styles with sections instead of a list of layers are drawn in this
// order, and a layer of a kind that a style lacks is inserted according to it.
layer_kinds! {
    /// Lines from shading, found in a shaded image of the scene.
    "tone_lines" ToneLines: tone_lines, tone_lines_mut, set_tone_lines, at most 1;
    /// Contour lines of height.
    "height_lines" HeightLines, called "Contour lines": lowest_height_lines, lowest_height_lines_mut, set_height_lines, at most 4;
    /// Tones drawn as hatching marks.
    "hatching" Hatching: hatching, hatching_mut, set_hatching, at most 1;
    /// Lines where parallel planes cut the land; hatching of the same style then applies only to models and trees.
    "cuts" Cuts: lowest_cuts, lowest_cuts_mut, set_cuts, at most 4;
    /// Rows of hachures on the land; hatching of the same style then applies only to models and trees.
    "rows" Rows, called "Rows of hachures": rows, rows_mut, set_rows, at most 1;
    /// Tufts of grass and stones on land near the eye.
    "ground" Ground, called "Grass and stones": lowest_ground, lowest_ground_mut, set_ground, at most 2;
    /// Streams or ridge lines, which follow from how the land drains.
    "drainage" Drainage, called "Streams and ridges": lowest_drainage, lowest_drainage_mut, set_drainage, at most 2;
    /// Lakes and the sea; without this layer they are drawn as land.
    "water" Water: water, water_mut, set_water, at most 1;
    /// Dashed outlines of no-data areas; a style that does not list this layer has it with its default values.
    "rims" Rims, called "Rims of no-data": rims, rims_mut, set_rims, at most 1;
    /// Lines that are detected in images of the surface.
    "lines" Lines: lines, lines_mut, set_lines, at most 1;
    /// Pen strokes along contours.
    "strokes" Strokes: strokes, strokes_mut, set_strokes, at most 1;
    /// Points, lines and areas from files, draped on the land.
    "features" Features: lowest_features, lowest_features_mut, set_features, at most 4;
}

/// Distance from the shore, in pixels, up to which [`Style::to_find_water`] knows it.
const FARTHEST_SHORE_PX: f32 = 90.0;

/// The ink layers of a style, from the bottom to the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers(Vec<Layer>);

impl Default for Layers {
    fn default() -> Self {
        Self::with_rims(Vec::new())
    }
}

impl Deref for Layers {
    type Target = [Layer];

    fn deref(&self) -> &[Layer] {
        &self.0
    }
}

impl Layers {
    /// Returns the layers, with rims added if they have none.
    fn with_rims(layers: Vec<Layer>) -> Self {
        let mut layers = Self(layers);
        if !layers.iter().any(|layer| matches!(layer, Layer::Rims(_))) {
            layers.replace("rims", Rims::default_value().map(Layer::Rims));
        }
        layers
    }

    /// Returns only the layers that say where water is.
    pub(super) fn of_water(&self) -> Self {
        Self::with_rims(self.0.iter().filter(|layer| matches!(layer, Layer::Water(_))).cloned().collect())
    }

    /// Replaces all layers of a kind with `new`, which is inserted in place of the lowest of them, or, if there was
    /// none, according to the order of kinds.
    fn replace(&mut self, name: &str, new: Option<Layer>) {
        let is_above = |layer: &Layer| rank(layer.kind()) > rank(name);
        let lowest = self.0.iter().position(|layer| layer.kind() == name);
        let index = lowest.or_else(|| self.0.iter().position(is_above)).unwrap_or(self.0.len());
        let (mut below, mut above) = (self.0[..index].to_vec(), self.0[index..].to_vec());
        above.retain(|layer| layer.kind() != name);
        below.extend(new);
        below.append(&mut above);
        self.0 = below;
    }

    /// Returns the key of a layer: its kind, followed by a number from the second layer of the kind on, as in
    /// `cuts[1]`.
    pub(crate) fn key(&self, index: usize) -> String {
        keyed(self.0[index].kind(), self.number(index))
    }

    /// Returns the layers, whose values may be changed.
    pub fn iter_mut(&mut self) -> std::slice::IterMut<'_, Layer> {
        self.0.iter_mut()
    }

    /// Returns the number of a layer among those of its kind: 0 for the lowest.
    pub(crate) fn number(&self, index: usize) -> usize {
        let name = self.0[index].kind();
        self.0[..index].iter().filter(|layer| layer.kind() == name).count()
    }
}

/// Returns the key of a layer by its kind and its number among layers of the kind, from 0: `cuts`, then `cuts[1]`.
fn keyed(name: &str, number: usize) -> String {
    if number > 0 { format!("{name}[{number}]") } else { name.to_owned() }
}

/// Returns how many layers of a kind a style may have.
#[cfg(any(feature = "window", feature = "headset"))]
pub(crate) fn most_of_kind(name: &str) -> usize {
    KINDS.iter().find(|(known, _)| *known == name).map_or(0, |(_, max)| *max)
}

/// Returns the names of the kinds of layers, from the bottom to the top.
pub(crate) fn layer_names() -> impl Iterator<Item = &'static str> + Clone {
    KINDS.iter().map(|(name, _)| *name)
}

/// Returns the position of a kind in the order of kinds, from the bottom to the top.
pub(super) fn rank(kind: &str) -> Option<usize> {
    KINDS.iter().position(|(known, _)| *known == kind)
}

/// Returns whether a style may have layers of this kind.
pub(super) fn is_kind(name: &str) -> bool {
    rank(name).is_some()
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

    fn default_value() -> Option<Self> {
        Some(Self::default())
    }

    fn check(&self, key: &str, _: &Range) -> Result<(), Wrong> {
        // A layer without an ink may have one on a map. In a style with strokes but without detected lines, trees may
        // need an ink for their lines.
        let inks: usize = self.iter().map(|layer| layer.behaviour().inks().len().max(1)).sum();
        let has = |kind: &str| self.iter().any(|layer| layer.kind() == kind);
        let inks = inks + usize::from(has("strokes") && !has("lines"));
        if inks > MAX_INKS {
            let words = format!(
                " have {inks} inks; at most {MAX_INKS} are allowed (tone_lines has two; rims and the lines of trees \
                 count even if they are not listed)"
            );
            return Err(Wrong::new(key, words));
        }
        for (index, layer) in self.iter().enumerate() {
            let key = self.key(index);
            let max = KINDS.iter().find(|(name, _)| *name == layer.kind()).map_or(0, |(_, max)| *max);
            if self.number(index) >= max {
                let allowed = if max == 1 { "one layer".to_owned() } else { format!("{max} layers") };
                return Err(Wrong::new(key, format!(": a style has at most {allowed} of this kind")));
            }
            layer.check(&key)?;
        }
        Ok(())
    }

    fn scale_lengths(&mut self, factor: f32, _: Option<&str>, _: &Range) {
        self.iter_mut().for_each(|layer| {
            layer.scale_lengths(factor);
            layer.behaviour_mut().scale_marks(factor);
        });
    }

    fn item(&self) -> Option<Item> {
        let table = |layer: &Layer| {
            let mut table = Table::new();
            table.insert("kind", value(layer.kind()));
            for (key, item) in layer.item()?.into_table().ok()? {
                table.insert(&key, item);
            }
            Some(table)
        };
        Some(Item::ArrayOfTables(self.iter().filter_map(table).collect::<ArrayOfTables>()))
    }
}

impl Style {
    /// Returns the style without the layers for which `is_left_out` is true of their key, which may be `cuts[1]`.
    #[cfg(any(feature = "window", feature = "headset"))]
    #[must_use]
    pub(crate) fn without_layers(mut self, is_left_out: impl Fn(&str) -> bool) -> Self {
        let keys: Vec<String> = (0..self.layers.len()).map(|index| self.layers.key(index)).collect();
        let mut keys = keys.iter();
        self.layers.0.retain(|_| !keys.next().is_some_and(|key| is_left_out(key)));
        self
    }

    /// Returns the style with layers of default values for what it does not draw: features, and a graticule. A style
    /// with its largest number of inks stays as it is.
    #[must_use]
    pub(crate) fn with_features(mut self, [has_features, has_graticule]: [bool; 2]) -> Self {
        let own = |layer: &Layer| match layer {
            Layer::Features(layer) => Some(layer.is_of_graticule()),
            _ => None,
        };
        let has = |style: &Self, of_graticule: bool| style.layers.iter().any(|layer| own(layer) == Some(of_graticule));
        let ink = self.lettering_ink();
        let graticule = Features::of_graticule(ink).filter(|_| has_graticule && !has(&self, true));
        let features = Features::default_value().filter(|_| has_features && !has(&self, false));
        // If there is room for one only, it is that of the features.
        let room = MAX_INKS.saturating_sub(self.inks().len());
        let graticule = graticule.filter(|_| room > usize::from(features.is_some()));
        let added = graticule.into_iter().chain(features.filter(|_| room > 0));
        self.layers.0.extend(added.map(Layer::Features));
        self
    }

    /// Returns a style that draws no lines or marks, and whose water knows the distance from its shore.
    #[must_use]
    pub(crate) fn to_find_water(&self) -> Self {
        let mut style = self.of_tones();
        let water = Water::default_value().map(|water| Water { deep_px: FARTHEST_SHORE_PX, ..water });
        style.layers.replace("water", water.map(Layer::Water));
        style
    }

    /// Returns the style without tints of areas, which a drawing of lines cannot have, and if `has_hatching` is false
    /// without their hatching, too.
    #[must_use]
    pub(crate) fn without_area_tints(mut self, has_hatching: bool) -> Self {
        for layer in self.layers.iter_mut() {
            if let Layer::Features(features) = layer {
                features.fill = if features.has_tint() || !has_hatching { 0.0 } else { features.fill };
            }
        }
        self
    }

    /// Returns the style without layers of these kinds, which are named as in a style file.
    #[cfg(test)]
    #[must_use]
    pub(crate) fn without(mut self, kinds: &[&str]) -> Self {
        self.layers.0.retain(|layer| !kinds.contains(&layer.kind()));
        self
    }

    /// Returns the inks of the style, from the bottom to the top.
    pub(crate) fn inks(&self) -> Vec<StyleInk> {
        let lettering = self.lettering_ink();
        self.numbered_inks()
            .map(|(layer, number, ink)| StyleInk { layer, number, color: ink.color.unwrap_or(lettering), ink })
            .collect()
    }

    /// Returns each ink with the index of its layer and the layer's number among those of its kind.
    fn numbered_inks(&self) -> impl DoubleEndedIterator<Item = (Option<usize>, usize, Ink)> {
        let of_sky = self.sky.lines().into_iter().map(|ink| (None, 0, ink));
        let of_layers = self.layers.iter().enumerate().flat_map(|(index, layer)| {
            let number = self.layers.number(index);
            layer.behaviour().inks().into_iter().map(move |ink| (Some(index), number, ink))
        });
        of_sky.chain(of_layers)
    }

    /// Returns the colour of lettering (the title, the scale bar and the text next to it) on bare paper: that of the
    /// topmost main ink, or of the border, that has enough contrast to the paper; otherwise black or white.
    pub(crate) fn lettering_ink(&self) -> Color {
        self.ink_on(self.paper.color)
    }

    /// Returns the colour of lettering in the sky of a view: that of [`Style::ink_on`] for the middle of the sky's
    /// colours, or for paper where the sky has none.
    pub(crate) fn ink_on_sky(&self) -> Color {
        if !(self.sky.is_drawn() && self.sky.has_colors()) {
            return self.lettering_ink();
        }
        let [top, bottom] = [self.sky.zenith, self.sky.horizon].map(Color::srgb);
        self.ink_on(Color::from_srgb([0, 1, 2].map(|k| 0.5 * (top[k] + bottom[k]))))
    }

    /// Returns the colour of lettering on a colour: that of the topmost main ink, or of the border, that has enough
    /// contrast to it; otherwise black or white.
    pub(crate) fn ink_on(&self, paper: Color) -> Color {
        let inks = self.numbered_inks().rev().filter(|(_, _, ink)| ink.is_main).filter_map(|(_, _, ink)| ink.color);
        let border = (self.paper.border_px > 0.0).then_some(self.paper.border);
        let visible = inks.chain(border).find(|ink| has_contrast(*ink, paper));
        visible.unwrap_or(if brightness(paper) > 0.5 { Color::default() } else { Color::WHITE })
    }
}

/// Least difference in brightness between lettering and paper, as a fraction of that between black and white.
const MIN_CONTRAST: f32 = 0.4;

fn has_contrast(ink: Color, paper: Color) -> bool {
    (brightness(ink) - brightness(paper)).abs() > MIN_CONTRAST
}

/// Returns the mean of the sRGB channels of a colour, 0 to 1.
fn brightness(color: Color) -> f32 {
    color.srgb().iter().sum::<f32>() / 3.0
}
