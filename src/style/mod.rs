//! Styles: the layers and colours of a drawing. A style file is TOML; passes run only for the sections that it has.

pub(crate) mod color;
#[cfg(any(feature = "window", feature = "headset"))]
pub(crate) mod controls;
mod curvature;
#[cfg(any(feature = "window", feature = "headset"))]
pub(crate) mod differences;
mod error;
pub(crate) mod extends;
#[cfg(any(feature = "window", feature = "headset"))]
pub(crate) mod families;
mod focus;
mod held;
mod image;
pub(crate) mod images;
pub(crate) mod layers;
pub mod marks;
mod on_maps;
pub(crate) mod parameters;
mod recipes;
mod relief;
pub(crate) mod scale;
pub(crate) mod set;
pub(crate) mod sky;
pub mod texture;
pub(crate) mod tone;

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use crate::file::input::{LARGEST_STYLE_BYTES, read_text};
use crate::file::toml_text::Wrong;
pub use color::Color;
pub use curvature::Curvature;
pub use error::StyleError;
pub use focus::Focus;
pub(crate) use held::StyleFiles;
pub use image::Image;
use layers::RecipeSource;
pub(crate) use layers::StyleInk;
pub use layers::{
    Cuts, Detector, Drainage, DrainageLines, DrainageViews, Epsilon, FeatureKinds, Features, Ground, HeightLines,
    HeightsOf, Layer, Layers, Lines, PlaneFamily, Rims, Rows, Stereo, Strokes, ToneLight, ToneLines, Water, hatching,
};
use parameters::{Range, choices, parameters};
pub use relief::{Relief, ReliefKind};
pub use sky::{CloudForm, Sky};
pub use tone::{Attribute, Ramp, Shading, Stop, Tone, Toon, Watercolor};

/// Name and text of each built-in style (preset).
const PRESETS: &[(&str, &str)] = &[
    ("plain", include_str!("presets/plain.toml")),
    ("ink", include_str!("presets/ink.toml")),
    ("lsa", include_str!("presets/lsa.toml")),
    ("sobel", include_str!("presets/sobel.toml")),
    ("strokes", include_str!("presets/strokes.toml")),
    ("roystan", include_str!("presets/roystan.toml")),
    ("pen", include_str!("presets/pen.toml")),
    ("brush", include_str!("presets/brush.toml")),
    ("dry-ink", include_str!("presets/dry-ink.toml")),
    ("charcoal", include_str!("presets/charcoal.toml")),
    ("pencil-lines", include_str!("presets/pencil-lines.toml")),
    ("hachures", include_str!("presets/hachures.toml")),
    ("rock", include_str!("presets/rock.toml")),
    ("crosshatch", include_str!("presets/crosshatch.toml")),
    ("stipple", include_str!("presets/stipple.toml")),
    ("pencil", include_str!("presets/pencil.toml")),
    ("engraving", include_str!("presets/engraving.toml")),
    ("woodcut", include_str!("presets/woodcut.toml")),
    ("wash", include_str!("presets/wash.toml")),
    ("hokusai", include_str!("presets/hokusai.toml")),
    ("night", include_str!("presets/night.toml")),
    ("orange", include_str!("presets/orange.toml")),
    ("cartoon", include_str!("presets/cartoon.toml")),
    ("green", include_str!("presets/green.toml")),
    ("panorama", include_str!("presets/panorama.toml")),
    ("suggestive", include_str!("presets/suggestive.toml")),
    ("tone-lines", include_str!("presets/tone-lines.toml")),
    ("relief", include_str!("presets/relief.toml")),
];

/// Name and text of each preset that extends one of [`PRESETS`].
const VARIANTS: &[(&str, &str)] = &[
    ("crosshatch-curvature", include_str!("presets/crosshatch-curvature.toml")),
    ("green-curvature", include_str!("presets/green-curvature.toml")),
    ("orange-curvature", include_str!("presets/orange-curvature.toml")),
    ("lsa-base", include_str!("presets/lsa-base.toml")),
    ("lsa-full", include_str!("presets/lsa-full.toml")),
];

/// The texts of [`VARIANTS`] with all that they extend.
static WHOLE_VARIANTS: LazyLock<Vec<String>> = LazyLock::new(|| {
    let whole = |(name, text): &(&str, &str)| extends::whole(name, text).unwrap_or_else(|_| (*text).to_owned());
    VARIANTS.iter().map(whole).collect()
});

parameters! {
    /// A style: the layers, colours and light of a drawing.
    pub struct Style {
        /// Name of the style, as shown in lists and reports.
        name: String;
        /// One-line description of the style.
        description: String;
        /// Values that differ on maps, each as KEY=VALUE, such as "light.shadow=0".
        on_maps: Vec<set::SetValue> = Vec::new() => Range::Entries(0, 64);
        /// Ink layers, from the bottom to the top.
        layers: Layers;
        /// Settings of `detector = "curvature"`: contours and suggestive contours by the curvature of the land.
        curvature: Curvature;
        /// How light becomes tone and colour.
        tone: Tone;
        /// How the land is lit, for toon tones and for hatching.
        light: Shading;
        /// Light that emphasises relief; without this section the light is not modified.
        relief: Option<Relief>;
        /// What is made of images on the land (`--drape`): colour, and darker tones.
        image: Image;
        /// Tones that look like watercolour; without this section tones are not modified.
        watercolor called "Watercolour": Option<Watercolor>;
        /// The paper on which the picture is drawn.
        paper: Paper;
        /// The sky above the horizon.
        sky: Sky;
        /// Bends the land for views from high above.
        panorama: Panorama;
        /// Haze: how distant land fades.
        haze: Haze;
        /// The region of strongest contrast; without this section contrast is the same everywhere.
        focus: Option<Focus>;
    } loaded {
        /// All files that the style was read from: its own, those of its recipes, and their images. A preset has none.
        files: Vec<PathBuf>;
    }
}

parameters! {
    /// The paper, its margin and its border.
    pub struct Paper {
        /// Colour of the paper; all other colours are multiplied by it.
        color called "Paper colour": Color = Color::WHITE;
        /// Visibility of the grain of the paper.
        grain: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// Width of the blank margin, which covers the edges of the picture.
        margin_px: f32 = 0.0 => Range::Within(0.0, 1000.0);
        /// Width of the border line around the picture, inside the margin; 0 draws none.
        border_px called "Border width": f32 = 0.0 => Range::Within(0.0, 64.0), zero "none";
        /// Colour of the border line.
        border called "Border colour": Color = Color::default();
        /// Height of additional blank paper at the bottom, next to the margin: room for a title block.
        foot_px called "Title block height": f32 = 0.0 => Range::Within(0.0, 4000.0);
        /// Letters of the title block and of the frame of a map; a drawing for pens has strokes.
        typeface: Typeface = Typeface::Strokes;
    }
}

choices! {
    /// The letters of a title block and of the frame of a map.
    pub enum Typeface {
        /// Lines of one width, as a pen plotter draws them.
        Strokes,
        /// EB Garamond, a serif as in old atlases.
        Serif,
        /// Clear Sans, a plain sans serif.
        Sans,
        /// Titles in capitals of Old Standard, as engraved on maps of the 19th century; small letters as in serif.
        Capitals,
    }
}

impl Paper {
    /// Returns whether the paper has a margin, a foot or a border.
    pub(crate) fn is_bordered(&self) -> bool {
        self.margin_px > 0.0 || self.border_px > 0.0 || self.foot_px > 0.0
    }
}

parameters! {
    /// A panorama in the manner of H. C. Berann: the land is bent as on a small globe, so that near land is seen from
    /// above and far land from the side (Patterson 2000, "A View from on High").
    pub struct Panorama {
        /// Angle of the horizon below horizontal, reached by bending the land away from the eye; maps are never bent.
        horizon_deg called "Dip of horizon": f32 = 0.0 => Range::Within(0.0, 60.0);
    }
}

impl Panorama {
    /// Returns the cosine and sine of the angle of the horizon below horizontal.
    pub(crate) fn horizon(&self) -> [f32; 2] {
        [self.horizon_rad().cos() as f32, self.horizon_rad().sin() as f32]
    }

    /// Returns the angle of the horizon below horizontal, in radians.
    pub(crate) fn horizon_rad(&self) -> f64 {
        f64::from(self.horizon_deg).to_radians()
    }
}

parameters! {
    /// Haze: how distant land fades.
    pub struct Haze {
        /// Colour that distant land fades to.
        color called "Haze colour": Color = Color::WHITE;
        /// Fraction of a tone that remains in full haze.
        faintest_tone called "Tone in full haze": f32 = 0.0 => Range::Within(0.0, 1.0);
    }
}

/// Sum of the linear channels below which haze counts as dark, as in night scenes, where bare paper would look bright.
const DARK_HAZE: f32 = 0.9;

/// Returns the names of the presets.
pub fn names() -> Vec<&'static str> {
    PRESETS.iter().chain(VARIANTS).map(|(name, _)| *name).collect()
}

/// Returns the TOML text of a preset. The text of a preset that extends another one has every parameter.
pub fn preset_text(name: &str) -> Option<&'static str> {
    // Variants are looked up last: what they extend is looked up here.
    PRESETS.iter().find(|(known, _)| *known == name).map(|(_, text)| *text).or_else(|| {
        let number = VARIANTS.iter().position(|(known, _)| *known == name)?;
        WHOLE_VARIANTS.get(number).map(String::as_str)
    })
}

impl Style {
    /// Returns whether two styles have the same name and the same kinds of layers in the same order, so that one is the
    /// other with changed values.
    pub(crate) fn is_edit_of(&self, other: &Self) -> bool {
        let kinds = |style: &Self| style.layers.iter().map(Layer::kind).collect::<Vec<_>>();
        self.name == other.name && kinds(self) == kinds(other)
    }

    /// Returns whether tones use the own colours of trees and models.
    pub(crate) fn needs_local_colors(&self) -> bool {
        self.tone.local_color() > 0.0
    }

    /// Returns the style for a map on which a pixel of the unscaled style is `pixel_m` metres: with the values that it
    /// has on maps, without effects that depend on the position of the eye (as in
    /// [`Scene::for_map`](crate::scene::Scene::for_map)), and with streams and ridge lines. Contour lines of height get
    /// an interval for the map's scale.
    ///
    /// # Errors
    /// A value of `on_maps` that the style cannot have. Files with such values are refused when they are read.
    pub fn for_map(self, pixel_m: f64) -> Result<Self, StyleError> {
        let mut style = self.on_map()?;
        style.layers.iter_mut().for_each(|layer| layer.behaviour_mut().prepare_for_map(pixel_m));
        let focus = style.focus.take().filter(|focus| focus.distance_m.is_none());
        Ok(Self { panorama: Panorama { horizon_deg: 0.0 }, focus, ..style })
    }

    /// Returns the kinds of lines of drainage that are drawn: streams, ridge lines, both or none.
    pub(crate) fn drainage_lines(&self) -> impl Iterator<Item = DrainageLines> + '_ {
        self.layers.iter().filter_map(|layer| match layer {
            Layer::Drainage(layer) => layer.drawn_lines(),
            _ => None,
        })
    }

    /// Returns whether the land is drawn with rows or cut lines, so that hatching applies only to models and trees.
    pub(crate) fn has_land_lines(&self) -> bool {
        self.rows().is_some() || self.lowest_cuts().is_some()
    }

    /// Returns the linear colour that tones fade to far from the focus, before it is multiplied by the paper.
    pub(crate) fn unfocused(&self) -> [f32; 3] {
        let own = self.focus.as_ref().and_then(|focus| focus.color);
        let haze = self.haze.color.linear();
        let is_dark = haze.iter().sum::<f32>() < DARK_HAZE;
        own.map_or(if is_dark { haze } else { [1.0; 3] }, |color| color.linear())
    }

    /// Returns the light that emphasises relief, if the kind of tone supports it.
    pub(crate) fn drawn_relief(&self) -> Option<&Relief> {
        self.relief.as_ref().filter(|_| self.tone.uses_light())
    }

    /// Returns whether tones show shadows of trees.
    pub(crate) fn needs_tree_shadows(&self) -> bool {
        self.tone.uses_light() && self.light.shadow > 0.0
    }

    /// Returns whether the tones are fitted to the picture.
    pub(crate) fn fits_tones(&self) -> bool {
        matches!(&self.tone, Tone::Toon(toon) if toon.fit)
    }

    /// Returns the style without what does not matter to its tones: without lines, marks and watercolour.
    #[must_use]
    pub(crate) fn of_tones(&self) -> Self {
        Self { layers: self.layers.of_water(), watercolor: None, ..self.clone() }
    }

    /// Returns whether smoothed normals of the land are needed.
    pub(crate) fn needs_form(&self) -> bool {
        let of_tones = self.tone.uses_light() && self.light.detail < 1.0;
        let of_lines = self.tone_lines().is_some_and(|lines| lines.abstracted > 0.0);
        self.light.form_px > 0.0 && (of_tones || of_lines)
    }

    /// Returns whether light falls on slopes that are drawn together into planes.
    pub(crate) fn has_planes(&self) -> bool {
        self.needs_form() && self.light.planes_px > 0.0
    }

    /// Returns whether crests are drawn lighter than hollows.
    pub(crate) fn needs_crests(&self) -> bool {
        self.tone.uses_light() && self.light.crests > 0.0
    }

    /// Returns whether tones need horizon maps, for cast shadows or ambient occlusion.
    pub(crate) fn needs_horizons(&self) -> bool {
        self.tone.uses_light() && (self.light.shadow > 0.0 || self.light.occlusion > 0.0)
    }

    /// Loads a preset by its name, or a style file (`.toml`) by its path.
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

    /// Reads a style from a file, whatever the extension of its name.
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

    /// Parses a style and loads the recipes and images that it names. Errors begin with `name`, and paths in the style
    /// are relative to the folder of `name`.
    ///
    /// # Errors
    /// [`StyleError::Parse`] and [`StyleError::Named`].
    pub fn parse(name: &str, text: &str) -> Result<Self, StyleError> {
        Self::read_values(name, text)?.completed(name, text)
    }

    /// Does the same as [`Style::parse`] for an edit of the style `before`. An environment map that both name is not
    /// loaded again, because it may have many megabytes.
    ///
    /// # Errors
    /// The errors are those of [`Style::parse`].
    #[cfg(any(feature = "window", feature = "headset"))]
    pub(crate) fn parse_edit(name: &str, text: &str, before: &Self) -> Result<Self, StyleError> {
        let mut style = Self::read_values(name, text)?;
        let folder = Path::new(name).parent().unwrap_or(Path::new(""));
        let known = before.relief.as_ref().filter(|relief| relief.sky.is_some());
        let kept = style.relief.as_mut().zip(known).and_then(|(relief, known)| {
            let named = relief.environment.as_ref().map(|name| folder.join(name));
            let is_same = named.is_some() && named == known.environment;
            is_same.then(|| relief.environment.take()).flatten().map(|_| known)
        });
        let mut style = style.completed(name, text)?;
        if let (Some(kept), Some(relief)) = (kept, &mut style.relief) {
            (relief.environment, relief.sky) = (kept.environment.clone(), kept.sky.clone());
            // The order of files is that in which they are read.
            let at = before.files.iter().position(|file| Some(file) == kept.environment.as_ref());
            let at = at.unwrap_or(usize::MAX).min(style.files.len());
            style.files.splice(at..at, kept.environment.clone());
        }
        Ok(style)
    }

    /// Loads the recipes and images that a style names, and returns it. `name` and `text` are those of its file.
    fn completed(mut self, name: &str, text: &str) -> Result<Self, StyleError> {
        let folder = Path::new(name).parent().unwrap_or(Path::new(""));
        self.complete(RecipeSource::Folder(folder)).map_err(|(key, source)| {
            // Other errors begin with the name of a file.
            let wrong = match source {
                StyleError::UnknownMarks { .. } | StyleError::UnknownTexture { .. } | StyleError::Condition(_) => {
                    Wrong::new(key, format!(": {source}"))
                }
                _ => Wrong::with_message(key, source.to_string()),
            };
            StyleError::Named { place: parameters::in_text(wrong, name, text), source: Box::new(source) }
        })?;
        self.check_values_of_maps().map_err(|wrong| parameters::in_text(wrong, name, text))?;
        Ok(self)
    }

    /// Reads all values of a style in either form, and checks them; recipes and images are not loaded.
    fn read_values(name: &str, text: &str) -> Result<Self, StyleError> {
        Ok(parameters::read(name, text)?)
    }

    /// Loads the recipes and images that the style names.
    ///
    /// # Errors
    /// The key, and what is wrong.
    fn complete(&mut self, source: RecipeSource<'_>) -> Result<(), (String, StyleError)> {
        let keys: Vec<String> = (0..self.layers.len()).map(|index| self.layers.key(index)).collect();
        for (layer, key) in self.layers.iter_mut().zip(keys) {
            let files = layer.behaviour_mut().complete(source);
            self.files.extend(files.map_err(|(within, error)| (format!("{key}.{within}"), error))?);
        }
        let folder = match source {
            RecipeSource::Folder(folder) => folder,
            RecipeSource::Embedded(_) => Path::new(""),
        };
        if let Some(relief) = &mut self.relief {
            relief.complete(folder).map_err(|error| ("relief.environment".to_owned(), error))?;
            self.files.extend(relief.environment.clone());
        }
        let curvature = &mut self.curvature;
        curvature.texture = source
            .texture(curvature.texture_name.as_deref(), curvature.width_px)
            .map_err(|error| ("curvature.texture".to_owned(), error))?;
        if let RecipeSource::Folder(folder) = source {
            self.files.extend(self.curvature.files(folder));
        }
        Ok(())
    }

    /// Returns the style as TOML text with every parameter that has a value. Parsing the text gives an equal style.
    pub fn text(&self) -> String {
        parameters::text(self)
    }
}

/// Returns the text of a style file with another value at a key, such as `strokes.width_px`. Comments, order and all
/// other values are preserved; a missing section or key is added at the end. Errors begin with `name`, the name of the
/// file.
///
/// # Errors
/// Invalid TOML; a key that no parameter has; the index of a list entry that does not exist. The value itself is only
/// checked when the text is read.
pub fn with_value(name: &str, text: &str, key: &str, value: impl Into<toml_edit::Value>) -> Result<String, StyleError> {
    let text = &extends::whole(name, text)?;
    Ok(parameters::set::<Style>(name, text, key, value)?)
}

/// Returns the text of a style with its sections as `[[layers]]`, the current form; comments and all other text stay.
///
/// # Errors
/// [`StyleError`] of a text that is not a valid style.
pub fn migrated(name: &str, text: &str) -> Result<String, StyleError> {
    Style::read_values(name, text)?;
    // A text that is a valid style is TOML.
    Ok(layers::migrated(text).unwrap_or_else(|_| text.to_owned()))
}
