//! The `[hatching]` section of a style: which marks are drawn, in which direction, and from which darkness.

use std::path::{Path, PathBuf};

use super::marks::{self, Recipe};
use super::parameters::{Range, choices, parameters};
use super::{Color, StyleError};

/// Largest number of layers.
pub const MOST_LAYERS: usize = 4;

parameters! {
    /// Tones drawn as hatching marks.
    pub struct Hatching {
        /// Colour of the marks.
        ink: Color = Color::default();
        /// How marks keep their size on the picture while the camera moves closer.
        scale: Scale = Scale::Blend;
        /// Softness of a mark's edge, as a range of tones; 0 looks like a pen, 0.1 like a pencil.
        softness: f32 = 0.0 => Range::Within(0.0, 0.5);
        /// The land is smoothed to this size for the direction of marks; land seen at a grazing angle is smoothed more.
        form_px: f32 = 12.0 => Range::Within(1.0, 256.0);
        /// On gentler slopes the direction of marks follows coarser land, by up to two levels; 0 turns this off.
        calm_deg: f32 = 0.0 => Range::Within(0.0, 45.0);
        /// Fraction of the ink that remains in full haze; how many marks remain is set by `haze.faintest_tone`.
        faintest: f32 = 1.0 => Range::Within(0.0, 1.0);
        /// Whether marks grow or shrink slightly so that their mean ink matches the requested tone everywhere.
        balance: bool = true;
        /// One kind of mark each; the layers are sorted by `from`.
        layers: Vec<Layer> => Range::Entries(1, MOST_LAYERS);
    }
}

choices! {
    /// How marks keep their size on the picture.
    pub enum Scale {
        /// Marks of two scales fade into each other.
        Blend,
        /// Moving closer only adds marks and removes none.
        Add,
    }
}

parameters! {
    /// A layer of one kind of mark.
    pub struct Layer {
        /// Recipe of the marks: a built-in name, or a file (`.toml`) relative to the style.
        marks: String;
        /// Direction of the marks.
        direction: Direction = Direction::Fixed;
        /// Azimuth of fixed marks, clockwise from north; for other directions, the angle that is added to them.
        angle_deg: f32 = 0.0 => Range::Within(-360.0, 360.0);
        /// Azimuth of slope marks on flat land, clockwise from north.
        level_deg: f32 = 0.0 => Range::Within(-360.0, 360.0);
        /// Darkness from which the layer is drawn.
        from: f32 = 0.0 => Range::Within(0.0, 0.99);
        /// Scale factor of the marks relative to their recipe.
        size: f32 = 1.0 => Range::Within(0.25, 8.0);
        /// Range of slopes on which the layer is drawn.
        slope_deg: [f32; 2] = [0.0, 90.0] => Range::Span(0.0, 90.0);
    } beside {
        /// The loaded recipe of `marks`.
        recipe: Option<Recipe>;
    }
}

choices! {
    /// Direction of hatching marks.
    pub enum Direction {
        /// A fixed azimuth.
        Fixed,
        /// Down the slope, like hachures on a map.
        Slope,
        /// Along the contour lines of height.
        Contour,
        /// Away from the eye: dots stay round on land seen at a grazing angle.
        Sight,
        /// Along the direction of greatest curvature; with an angle of 90, along that of least curvature.
        Curvature,
    }
}

impl Hatching {
    /// Returns whether the marks of any layer follow the curvature of the land.
    pub fn follows_curvature(&self) -> bool {
        self.layers.iter().any(|layer| layer.direction == Direction::Curvature)
    }
}

impl Layer {
    /// Loads the recipe of the marks and checks its images; `folder` is the base of a relative path.
    pub(super) fn complete(&mut self, folder: &Path) -> Result<(), StyleError> {
        let recipe = Recipe::load(&self.marks, folder)?;
        marks::check_pictures(&recipe)?;
        self.recipe = Some(recipe);
        Ok(())
    }

    /// Returns the files that the layer is read from; `folder` is the folder of the style.
    pub(super) fn files(&self, folder: &Path) -> impl Iterator<Item = PathBuf> {
        let images = self.recipe.iter().flat_map(|recipe| recipe.images.iter().cloned());
        marks::file(&self.marks, folder).into_iter().chain(images)
    }
}
