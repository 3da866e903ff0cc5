//! Styles: what a drawing is made of. A style file is TOML; what it does not name, its passes do not run.

pub mod color;
mod curvature;
mod cuts;
mod error;
mod focus;
pub mod hatching;
mod height_lines;
mod held;
mod lines;
pub mod marks;
pub mod parameters;
mod recipes;
mod relief;
mod rims;
mod rows;
pub mod scale;
pub mod sky;
mod strokes;
pub mod texture;
pub mod tone;
mod tone_lines;
mod water;

use std::path::{Path, PathBuf};

use crate::file::input::{LARGEST_STYLE_BYTES, read_text};
use crate::file::toml_text::Wrong;
pub use color::Color;
pub use curvature::Curvature;
pub use cuts::{CutLayer, Cuts};
pub use error::StyleError;
pub use focus::Focus;
pub use height_lines::HeightLines;
pub use held::StyleFiles;
pub use lines::{Detector, Epsilon, Lines, Stereo};
use parameters::{Range, parameters};
pub use relief::{Relief, ReliefKind};
pub use rims::Rims;
pub use rows::Rows;
pub use sky::Sky;
pub use strokes::Strokes;
pub use tone::{Attribute, Ramp, Shading, Stop, Tone, Toon, Watercolor};
pub use tone_lines::{ToneLight, ToneLines};
pub use water::Water;

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

parameters! {
    /// A style.
    pub struct Style {
        /// Name of the style, for people and reports.
        name: String;
        /// What the style draws, in a line.
        description: String;
        /// Lines that are found in pictures of the surface; without the section none are drawn.
        lines: Option<Lines>;
        /// Lines by the curvature of the land.
        curvature: Curvature;
        /// Lines from the tones of the shaded picture; without the section none are drawn.
        tone_lines: Option<ToneLines>;
        /// Pen strokes along contours; without the section none are drawn.
        strokes: Option<Strokes>;
        /// How light becomes tone and colour.
        tone: Tone;
        /// How light falls, for tones in steps and for marks.
        light: Shading;
        /// Light that brings out relief; without the section light falls as it does.
        relief: Option<Relief>;
        /// Tones that run and settle as water and pigment do; without the section they stay as they are.
        watercolor: Option<Watercolor>;
        /// Tones made of marks; without the section none are drawn.
        hatching: Option<hatching::Hatching>;
        /// Rows of hachures on the land; hatching of the same style is then for models and trees.
        rows: Option<Rows>;
        /// Lines that planes cut out of the land; hatching of the same style is then for models and trees.
        cuts: Option<Cuts>;
        /// Lines of equal height; without the section none are drawn.
        height_lines: Option<HeightLines>;
        /// Lakes and the sea, where heights show them; without the section they are land.
        water: Option<Water>;
        /// Lines around holes in the heights.
        rims: Rims;
        /// The sheet that is drawn on.
        paper: Paper;
        /// What is above the horizon.
        sky: Sky;
        /// Bends the land for views from high above.
        panorama: Panorama;
        /// What distance does.
        haze: Haze;
        /// Where the strongest contrast is; without the section it is the same everywhere.
        focus: Option<Focus>;
    } beside {
        /// All files that it was read from: its own, those of its recipes, and their pictures. A preset has none.
        files: Vec<PathBuf>;
    }
}

/// Between letters and their paper, of the difference between black and white.
const LEAST_CONTRAST: f32 = 0.4;

/// As it is written: the mean of a colour's parts.
fn lightness(color: Color) -> f32 {
    color.srgb().iter().sum::<f32>() / 3.0
}

parameters! {
    /// The sheet.
    pub struct Paper {
        /// Colour of the sheet, which multiplies every colour.
        color: Color = Color::WHITE;
        /// How much of the sheet's grain shows.
        grain: f32 = 0.0 => Range::Within(0.0, 1.0);
        /// Bare paper along the edges of the sheet, over the picture.
        margin_px: f32 = 0.0 => Range::Within(0.0, 1000.0);
        /// Width of the line around the picture, within the margin; 0 is none.
        border_px: f32 = 0.0 => Range::Within(0.0, 64.0);
        /// Colour of that line.
        border: Color = Color::default();
        /// Bare paper below the picture beside the margin, over the picture: room for a title block.
        foot_px: f32 = 0.0 => Range::Within(0.0, 4000.0);
    }
}

impl Paper {
    /// Whether it has a margin, a foot or a border.
    pub fn is_bordered(&self) -> bool {
        self.margin_px > 0.0 || self.border_px > 0.0 || self.foot_px > 0.0
    }
}

parameters! {
    /// A panorama as H. C. Berann painted them: the land is bent as on a small globe, so that near land is seen from above
    /// and far land behind it from the side (Patterson 2000, "A View from on High").
    pub struct Panorama {
        /// How far below level the horizon lies, by bending the land away from the eye; 0, and any map, is as it is.
        horizon_deg: f32 = 0.0 => Range::Within(0.0, 60.0);
    }
}

impl Panorama {
    /// Cosine and sine of how far below level the horizon lies.
    pub fn horizon(&self) -> [f32; 2] {
        [self.horizon_rad().cos() as f32, self.horizon_rad().sin() as f32]
    }

    /// How far below level the horizon lies.
    pub fn horizon_rad(&self) -> f64 {
        f64::from(self.horizon_deg).to_radians()
    }
}

parameters! {
    /// What distance does.
    pub struct Haze {
        /// What far things fade to.
        color: Color = Color::WHITE;
        /// What is left of a tone in full haze.
        faintest_tone: f32 = 0.0 => Range::Within(0.0, 1.0);
    }
}

/// The haze of a picture of the night has less light, red, green and blue together: bare paper would shine in it.
const DARK_HAZE: f32 = 0.9;

/// The names of the presets.
pub fn names() -> Vec<&'static str> {
    PRESETS.iter().map(|(name, _)| *name).collect()
}

/// The text of a preset.
pub fn preset_text(name: &str) -> Option<&'static str> {
    PRESETS.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
}

impl Style {
    /// Whether tones have the own colours of trees and models.
    pub fn asks_for_local_colors(&self) -> bool {
        self.tone.local_color() > 0.0
    }

    /// The same for a map, a pixel of whose unscaled style is as large as that: without what depends on where the eye
    /// stands, as [`Scene::for_map`](crate::scene::Scene::for_map), and with lines of equal height at its scale.
    #[must_use]
    pub fn for_map(self, pixel_m: f64) -> Self {
        let height_lines = self.height_lines.map(|lines| lines.for_map(pixel_m));
        let focus = self.focus.filter(|focus| focus.distance_m.is_none());
        Self { panorama: Panorama { horizon_deg: 0.0 }, height_lines, focus, ..self }
    }

    /// The lines of equal height that it draws.
    pub fn drawn_height_lines(&self) -> Option<&HeightLines> {
        self.height_lines.as_ref().filter(|lines| lines.interval_m > 0.0)
    }

    /// Of letters on bare paper: the first of the style's inks that is dark enough on it, or light enough.
    pub fn lettering_ink(&self) -> Color {
        let paper = lightness(self.paper.color);
        let lines = [
            self.strokes.as_ref().map(|strokes| strokes.ink),
            self.mark_ink(),
            self.lines.as_ref().map(|lines| lines.ink),
            self.tone_lines.as_ref().map(|lines| lines.ink),
            self.height_lines.as_ref().map(|lines| lines.ink),
            (self.paper.border_px > 0.0).then_some(self.paper.border),
        ];
        let seen = lines.into_iter().flatten().find(|ink| (lightness(*ink) - paper).abs() > LEAST_CONTRAST);
        seen.unwrap_or(if paper > 0.5 { Color::default() } else { Color::WHITE })
    }

    /// Whether marks of its land are lines, so that hatching is for what stands on it.
    pub fn has_land_lines(&self) -> bool {
        self.rows.is_some() || self.cuts.is_some()
    }

    /// Colour of its marks, if it has any: of rows or cut lines, where it has these and hatching.
    pub fn mark_ink(&self) -> Option<Color> {
        let of_land = self.rows.as_ref().map(|rows| rows.ink).or(self.cuts.as_ref().map(|cuts| cuts.ink));
        of_land.or(self.hatching.as_ref().map(|hatching| hatching.ink))
    }

    /// What its tones go to far from the focus, linear, before the paper.
    pub fn unfocused(&self) -> [f32; 3] {
        let own = self.focus.as_ref().and_then(|focus| focus.color);
        let haze = self.haze.color.linear();
        let is_dark = haze.iter().sum::<f32>() < DARK_HAZE;
        own.map_or(if is_dark { haze } else { [1.0; 3] }, |color| color.linear())
    }

    /// What is left of that in full haze.
    pub fn faintest_mark(&self) -> f32 {
        let of_land = self.rows.as_ref().map(|rows| rows.faintest).or(self.cuts.as_ref().map(|cuts| cuts.faintest));
        of_land.or(self.hatching.as_ref().map(|hatching| hatching.faintest)).unwrap_or(1.0)
    }

    /// The light that brings out relief, if its tones take it.
    pub fn drawn_relief(&self) -> Option<&Relief> {
        self.relief.as_ref().filter(|_| matches!(self.tone, Tone::Toon(_)))
    }

    /// Whether tones have the shadows that trees throw.
    pub fn asks_for_tree_shadows(&self) -> bool {
        matches!(self.tone, Tone::Toon(_)) && self.light.shadow > 0.0
    }

    /// Whether light falls on the form of the land.
    pub fn asks_for_form(&self) -> bool {
        let of_tones = matches!(self.tone, Tone::Toon(_)) && self.light.detail < 1.0;
        let of_lines = self.tone_lines.as_ref().is_some_and(|lines| lines.abstracted > 0.0);
        self.light.form_px > 0.0 && (of_tones || of_lines)
    }

    /// Whether crests are lighter than hollows.
    pub fn asks_for_crests(&self) -> bool {
        matches!(self.tone, Tone::Toon(_)) && self.light.crests > 0.0
    }

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

    /// A style from its text, with all that it names: recipes and their pictures. `name` is for errors, and files lie
    /// beside it.
    ///
    /// # Errors
    /// [`StyleError::Parse`] and [`StyleError::Named`].
    pub fn parse(name: &str, text: &str) -> Result<Self, StyleError> {
        let mut style: Self = parameters::read(name, text)?;
        let folder = Path::new(name).parent().unwrap_or(Path::new(""));
        let named = |key: &str, source: StyleError| StyleError::Named {
            place: Wrong::told(key, source.to_string()).in_text(name, text),
            source: Box::new(source),
        };
        if let Some(hatching) = &mut style.hatching {
            for (number, layer) in hatching.layers.iter_mut().enumerate() {
                layer.complete(folder).map_err(|error| named(&format!("hatching.layers[{number}].marks"), error))?;
                style.files.extend(layer.files(folder));
            }
            hatching.layers.sort_by(|a, b| a.from.total_cmp(&b.from));
        }
        if let Some(relief) = &mut style.relief {
            relief.complete(folder).map_err(|error| named("relief.environment", error))?;
            style.files.extend(relief.environment.clone());
        }
        if let Some(cuts) = &mut style.cuts {
            cuts.layers.sort_by(|a, b| a.from.total_cmp(&b.from));
        }
        style.curvature.complete(folder).map_err(|error| named("curvature.texture", error))?;
        style.files.extend(style.curvature.file(folder));
        if let Some(strokes) = &mut style.strokes {
            strokes.complete(folder).map_err(|error| named("strokes.texture", error))?;
            style.files.extend(strokes.files(folder));
        }
        Ok(style)
    }

    /// The style as a text with every parameter that has a value. The text reads back as an equal style.
    pub fn text(&self) -> String {
        parameters::text(self)
    }
}
