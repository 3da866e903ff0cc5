//! Points, lines and areas of files of features. Their passes are in `src/lines/draped`, and `src/draped` prepares them.

use std::path::PathBuf;

use super::{Channels, Fading, Ink, LayerBehaviour, RecipeSource, Trace};
use crate::features::when::When;
use crate::style::parameters::{Range, Setting, choices, parameters};
use crate::style::{Color, StyleError};

parameters! {
    /// Points, lines and areas from files (`--layer`), draped on the land. A style without such a layer draws
    /// all of them with the default values.
    pub struct Features {
        /// Name of a file without its ending, or of a layer in it; if it is empty, the features of all files are drawn.
        file called "File or layer": String = String::new();
        /// Condition on the attributes, such as `kind == 'path' and ele > 2000`; if it is empty, all are drawn.
        when called "Condition": String = String::new();
        /// Kinds of features that are drawn.
        of called "Kind of features": FeatureKinds = FeatureKinds::All;
        /// Colour of the lines and points.
        ink called "Ink colour": Color = Color::VERMILION;
        /// Width of lines, and of outlines of areas; 0 draws none.
        line_px called "Line width": f32 = 1.6 => Range::Within(0.0, 16.0), zero "none";
        /// Share of an area that ink covers: 0.2 is a light tint, and 0 leaves areas empty.
        fill called "Fill of areas": f32 = 0.2 => Range::Within(0.0, 1.0), zero "none";
        /// Approximate spacing of lines that hatch areas, at least 3; 0 gives an even tint instead.
        hatch_px called "Spacing in areas": f32 = 0.0 => Range::Within(0.0, 64.0), zero "even tint";
        /// Direction of the lines that hatch areas on the map, clockwise from north.
        hatch_deg called "Direction in areas": f32 = 45.0 => Range::Within(-360.0, 360.0);
        /// Diameter of points; 0 draws none.
        point_px called "Diameter of points": f32 = 6.0 => Range::Within(0.0, 64.0), zero "none";
        /// Approximate length of a dash.
        dash_px called "Dash length": f32 = 8.0 => Range::Within(1.0, 256.0);
        /// Approximate length of the gap between dashes; 0 draws solid lines.
        gap_px called "Gap length": f32 = 0.0 => Range::Within(0.0, 256.0), zero "none";
        /// Fraction of the ink that remains in full haze.
        faintest called "Ink in full haze": f32 = 0.4 => Range::Within(0.0, 1.0);
    }
}

choices! {
    /// Kinds of features.
    pub enum FeatureKinds {
        /// Points, lines and areas.
        All,
        /// Only points.
        Points,
        /// Only lines.
        Lines,
        /// Only areas and their outlines.
        Areas,
    }
}

/// Name of the lines of `--graticule`.
pub(crate) const GRATICULE: &str = "graticule";
/// Width of these lines.
const GRATICULE_PX: f32 = 0.6;

impl Features {
    /// Returns the layer that draws a graticule in a style without one.
    pub(super) fn of_graticule(ink: Color) -> Option<Self> {
        Some(Self { file: GRATICULE.to_owned(), ink, line_px: GRATICULE_PX, ..Self::default_value()? })
    }

    /// Returns whether areas have an even tint.
    pub(crate) fn has_tint(&self) -> bool {
        self.fill > 0.0 && self.hatch_px <= 0.0
    }

    /// Returns whether the layer draws a graticule.
    pub(super) fn is_of_graticule(&self) -> bool {
        self.file.eq_ignore_ascii_case(GRATICULE)
    }
}

impl LayerBehaviour for Features {
    fn inks(&self) -> Vec<Ink> {
        vec![Ink {
            id: "features",
            label: if self.file.is_empty() { "Features".to_owned() } else { format!("Features: {}", self.file) },
            color: Some(self.ink),
            channels: Channels::One(0),
            fading: Fading::OnSurface { faintest: self.faintest, reach: 1.0, follows_tone: false },
            makes_tone: false,
            is_main: false,
            trace: Trace::Picture,
        }]
    }

    fn summary(&self) -> Option<String> {
        Some(if self.file.is_empty() { "features".to_owned() } else { format!("features of {}", self.file) })
    }

    fn complete(&mut self, _source: RecipeSource<'_>) -> Result<Vec<PathBuf>, (String, StyleError)> {
        if !self.when.is_empty() {
            When::parse(&self.when).map_err(|error| ("when".to_owned(), StyleError::Condition(error.to_string())))?;
        }
        Ok(Vec::new())
    }
}
