//! A layer as the rest of the program sees it: its inks, the pass that draws it, and its margins.

use std::path::PathBuf;

use glam::DVec3;

use super::RecipeSource;
use crate::gpu::target::TargetKind;
use crate::style::{Color, StyleError};

/// Largest number of inks of a frame. The composite binds a picture for each, besides position, tone and sky, and a
/// device need not offer more than 16 pictures to a shader.
pub(crate) const MAX_INKS: usize = 13;

/// Ink of one colour that a layer draws. A layer has one ink or several; all of them are channels of the picture that
/// the layer's passes write.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Ink {
    /// Identifier for scripts: the id of the layer in an SVG file, and the property `layer` in a GeoJSON file.
    pub id: &'static str,
    /// Label for people.
    pub label: String,
    /// Colour; `None` means that of lettering ([`Style::lettering_ink`](crate::style::Style::lettering_ink)).
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
pub(crate) enum Channels {
    /// The channel with this index, 0 to 3.
    One(usize),
    /// The first `n` channels (1 to 3), one for each family of lines. The families cross each other.
    Crossed(usize),
}

/// How ink fades with distance and away from the focus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Fading {
    /// The ink fades with the surface below it.
    OnSurface {
        /// Fraction of the ink that remains in full haze.
        faintest: f32,
        /// How many times farther than tones the ink reaches into the haze.
        reach: f32,
        /// Whether the amount of ink follows the tone. Such ink already fades with the tone away from the focus, so it
        /// is itself faded there only by the square root of the focus.
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
    AlreadyFaded,
}

/// How ink becomes lines in a vector file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Trace {
    /// The ink is left out; the text names it in the report of what a vector file lacks.
    LeftOut(&'static str),
    /// Lines are traced in the picture of the ink, each family of [`Channels::Crossed`] separately.
    Picture,
    /// Sets of hatching marks are drawn and traced separately.
    Sets(Vec<TracedSet>),
    /// The marks of rows are read back as lines, without tracing.
    Rows {
        /// Distance between neighbouring marks, in pixels.
        spacing_px: f32,
    },
    /// The strokes are read back as lines, without tracing.
    Strokes,
}

/// Description of a set of hatching marks, for tracing.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TracedSet {
    /// Label for people.
    pub label: String,
    /// Whether the marks are dots; then each is traced as a dot, not along its length.
    pub is_of_dots: bool,
}

/// A pass over the pixels of an eye that draws the ink of a layer. Its shader binds the uniform `rules` and the output
/// `ink`; it may also bind `view`, `surface_id`, `position`, `normal`, `tone` (its fourth channel is the requested
/// tone), `water` (a single texel in a style without water), and the terrain.
pub(crate) struct InkPass {
    /// Name of the shader, which is also that of the pass.
    pub shader: &'static str,
    /// Bytes of the uniform `rules`, in the layout of the shader's struct.
    pub rules: Vec<u8>,
    /// The picture that the pass writes.
    pub ink: &'static TargetKind,
}

/// An ink of a style with its layer.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct StyleInk {
    /// Index of the layer in [`Style::layers`](crate::style::Style); `None` for the ink of the sky.
    pub layer: Option<usize>,
    /// Number of the layer among those of its kind: 0 for the lowest.
    pub number: usize,
    /// Colour of the ink, or of lettering if `ink` has no colour.
    pub color: Color,
    /// The ink as the layer describes it.
    pub ink: Ink,
}

impl StyleInk {
    /// Returns an identifier for scripts that is unique within the style. `part` is the number of a family of lines or
    /// of a set of marks, from 1.
    pub(crate) fn id(&self, part: Option<usize>) -> String {
        let part = part.map_or(String::new(), |part| format!("-{part}"));
        let number = if self.number > 0 { format!("-layer-{}", self.number + 1) } else { String::new() };
        format!("{}{part}{number}", self.ink.id)
    }
}

/// The land on which the pass of a layer draws.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LandOfPass {
    /// The rig's origin in the world, to which positions on the GPU are relative.
    pub origin_m: DVec3,
    /// The factor by which heights are drawn.
    pub exaggeration: f64,
    /// Height of the surface of the sea that the scene names, as it is drawn.
    pub sea_level_m: Option<f64>,
}

/// A layer as the rest of the program sees it, whatever its kind.
pub(crate) trait LayerBehaviour {
    /// Returns the inks of the layer, from the bottom to the top; none if it draws nothing.
    fn inks(&self) -> Vec<Ink>;

    /// Returns the pass that draws the layer. `frame/passes.rs` draws layers of kinds that have none.
    fn pass(&self, _land: LandOfPass) -> Option<InkPass> {
        None
    }

    /// Returns how far around a pixel its ink depends on other pixels, as margins of a part of a large picture.
    fn margins(&self) -> Margins {
        Margins::default()
    }

    /// Returns the name of the layer in a summary of the style; `None` omits it.
    fn summary(&self) -> Option<String> {
        None
    }

    /// Returns the name of what a vector file cannot show of the layer, apart from inks that are [left
    /// out](Trace::LeftOut).
    fn missing_in_vectors(&self) -> Option<&'static str> {
        None
    }

    /// Returns the name of what keeps its size in pixels when the style is scaled for paper; `None` if nothing does.
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

/// The margins of a part of a large picture that a layer needs, because the ink of a pixel depends on other pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Margins {
    /// The margin that the layer needs by itself; the largest of all layers counts.
    pub margin_px: u32,
    /// A width that is added to the usual margin of a part; the widths of all layers are added up.
    pub added_px: u32,
}
