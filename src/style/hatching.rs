//! Hatching of a style: which marks, where they point, and from which darkness on.

use std::path::{Path, PathBuf};

use super::marks::{self, Recipe};
use super::parameters::{Range, choices, parameters};
use super::{Color, StyleError};

/// Layers, at most.
pub const MOST_LAYERS: usize = 4;

parameters! {
    /// Tones made of marks.
    pub struct Hatching {
        /// Colour of the marks.
        ink: Color = Color::default();
        /// How marks keep their size while the camera comes nearer.
        scale: Scale = Scale::Blend;
        /// Width of a mark's border in tones; 0 is a pen's, 0.1 a pencil's.
        softness: f32 = 0.0 => Range::Within(0.0, 0.5);
        /// Marks follow the land's form at this scale; land that is seen at a flat angle has a coarser one.
        form_px: f32 = 12.0 => Range::Within(1.0, 256.0);
        /// Marks on land that slopes less than this follow a coarser form, by two levels at most; 0 is nowhere.
        calm_deg: f32 = 0.0 => Range::Within(0.0, 45.0);
        /// What is left of the ink of marks in full haze; that there are fewer of them is `haze.faintest_tone`.
        faintest: f32 = 1.0 => Range::Within(0.0, 1.0);
        /// Whether marks grow or shrink a little, so that their mean ink is the tone wherever one looks.
        balance: bool = true;
        /// Marks of one kind each; layers are sorted by `from`.
        layers: Vec<Layer> => Range::Entries(1, MOST_LAYERS);
    }
}

choices! {
    /// How marks keep their size.
    pub enum Scale {
        /// Marks of two scales hand over to each other.
        Blend,
        /// Coming nearer only ever adds marks.
        Add,
    }
}

parameters! {
    /// Marks of one kind.
    pub struct Layer {
        /// What is drawn: marks of the program, or a recipe beside the style (`.toml`).
        marks: String;
        /// Where marks point.
        direction: Direction = Direction::Fixed;
        /// Azimuth of fixed marks, clockwise from north; others turn by this from what they follow.
        angle_deg: f32 = 0.0 => Range::Within(-360.0, 360.0);
        /// Azimuth of slope marks where the land is level.
        level_deg: f32 = 0.0 => Range::Within(-360.0, 360.0);
        /// Darkness from which on the layer takes part.
        from: f32 = 0.0 => Range::Within(0.0, 0.99);
        /// How many times larger marks are than their recipe has them.
        size: f32 = 1.0 => Range::Within(0.25, 8.0);
        /// The layer is on slopes from the first of these to the second.
        slope_deg: [f32; 2] = [0.0, 90.0] => Range::Span(0.0, 90.0);
    } beside {
        /// What `marks` means.
        recipe: Option<Recipe>;
    }
}

choices! {
    /// Where marks point.
    pub enum Direction {
        /// To a fixed azimuth.
        Fixed,
        /// Down the slope, as hachures on a map.
        Slope,
        /// Along the contour lines of height.
        Contour,
        /// Away from the eye: dots stay round on land that is seen at a flat angle.
        Sight,
        /// Around the greatest bend of the form; with an angle of 90, along the least.
        Curvature,
    }
}

impl Hatching {
    /// Whether marks of some layer follow the land's curvature.
    pub fn follows_curvature(&self) -> bool {
        self.layers.iter().any(|layer| layer.direction == Direction::Curvature)
    }
}

impl Layer {
    /// Loads the marks, and looks at their pictures; files lie in `folder`.
    pub(super) fn complete(&mut self, folder: &Path) -> Result<(), StyleError> {
        let recipe = Recipe::load(&self.marks, folder)?;
        marks::check_pictures(&recipe)?;
        self.recipe = Some(recipe);
        Ok(())
    }

    /// The files that the layer is read from, if the style's lies in `folder`.
    pub(super) fn files(&self, folder: &Path) -> impl Iterator<Item = PathBuf> {
        let images = self.recipe.iter().flat_map(|recipe| recipe.images.iter().cloned());
        marks::file(&self.marks, folder).into_iter().chain(images)
    }
}
