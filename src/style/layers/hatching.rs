//! Hatching: which marks are drawn, in which direction, and from which darkness. Its passes are in
//! `src/tones/hatching`, and in `src/tones/fractal_hatching` for `scale = "add"`.

use std::path::PathBuf;

use super::{Channels, Fading, Ink, LayerBehaviour, Margins, RecipeSource, Trace, TracedSet};
use crate::gpu::wgsl::shared::mark_normal::BLOCK_PX;
use crate::gpu::wgsl::surface::bend_axis::REACH as AXIS_REACH;
use crate::style::marks::{self, Recipe};
use crate::style::parameters::{Range, choices, parameters};
use crate::style::{Color, StyleError};

/// Largest number of sets of marks.
pub(crate) const MAX_SETS: usize = 4;

parameters! {
    /// Tones drawn as hatching marks.
    pub struct Hatching {
        /// Colour of the marks.
        ink called "Ink colour": Color = Color::default();
        /// How marks keep their size on the picture while the camera moves closer.
        zoom as "scale" called "Marks while zooming": Zoom = Zoom::Blend;
        /// Share of the requested darkness that marks reproduce; useful where colour reproduces the rest; 0 draws none.
        share called "Share of darkness": f32 = 1.0 => Range::Within(0.0, 1.0), zero "none";
        /// Width of the transition at a mark's edge, in tone (0 to 1); 0 looks like a pen, 0.1 like a pencil.
        softness called "Softness of marks": f32 = 0.0 => Range::Within(0.0, 0.5);
        /// The land is smoothed to this size for the direction of marks; land seen at a grazing angle is smoothed more.
        form_px called "Smoothing of land": f32 = 12.0 => Range::Within(1.0, 256.0);
        /// On gentler slopes the direction of marks follows land that is smoothed up to four times more; 0 turns this
        /// off.
        calm_deg called "Smoother below slope": f32 = 0.0 => Range::Within(0.0, 45.0), zero "off";
        /// Fraction of the ink that remains in full haze; how many marks remain is set by `haze.faintest_tone`.
        faintest called "Ink in full haze": f32 = 1.0 => Range::Within(0.0, 1.0);
        /// Whether marks grow or shrink slightly so that their mean ink matches the requested tone everywhere.
        balance called "Balance of ink": bool = true;
        /// Sets of marks, each of one kind; they are sorted by `from`.
        sets: Vec<MarkSet> => Range::Entries(1, MAX_SETS);
    }
}

choices! {
    /// How marks keep their size on the picture while the camera moves closer.
    pub enum Zoom {
        /// Marks of two scales fade into each other.
        Blend,
        /// Moving closer only adds marks and removes none.
        Add,
    }
}

parameters! {
    /// A set of marks of one kind.
    pub struct MarkSet {
        /// Recipe of the marks: a built-in name, or a file (`.toml`) relative to the style.
        marks called "Recipe of marks": String;
        /// Direction of the marks.
        direction: Direction = Direction::Fixed;
        /// Azimuth of fixed marks, clockwise from north; for other directions, the angle that is added to them.
        angle_deg called "Angle of marks": f32 = 0.0 => Range::Within(-360.0, 360.0);
        /// Azimuth of slope marks on flat land, clockwise from north.
        level_deg called "Azimuth on flat land": f32 = 0.0 => Range::Within(-360.0, 360.0);
        /// Darkness from which the set is drawn.
        from called "From darkness": f32 = 0.0 => Range::Within(0.0, 0.99);
        /// Scale factor of the marks relative to their recipe.
        size called "Size of marks": f32 = 1.0 => Range::Within(0.25, 8.0);
        /// Range of slopes on which the set is drawn.
        slope_deg called "Range of slopes": [f32; 2] = [0.0, 90.0] => Range::Span(0.0, 90.0);
    } loaded {
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

/// Side of a cell in which ink is averaged, in pixels, for marks of a `size` of 1. The cells are then averaged with a
/// Gaussian whose standard deviation is 1.6 cells, two spacings of marks.
const CELL_PX: u32 = 8;
/// Largest distance at which a cell influences a pixel, in cells: the Gaussian's reach, the cell itself, and the
/// distance between two cells.
const REACH_CELLS: u32 = 6;

impl Hatching {
    /// Returns the side of the cells in which the ink of the marks is averaged, in pixels; it grows with the largest
    /// marks.
    pub(crate) fn cell_px(&self) -> u32 {
        let largest = self.sets.iter().map(|set| set.size).fold(1.0, f32::max);
        CELL_PX * (largest.ceil() as u32).next_power_of_two()
    }

    /// Returns the step between the blocks that are averaged for the axis of curvature, in blocks: the average covers
    /// about two samples of the form, each `form_px` wide, to each side.
    pub(crate) fn axis_step(&self) -> i32 {
        (2.0 * self.form_px / (BLOCK_PX as u32 * AXIS_REACH as u32) as f32).round().max(1.0) as i32
    }

    /// Returns how far around a pixel its axis of curvature depends on the picture, in pixels; 0 if no marks follow
    /// curvature.
    fn axis_reach_px(&self) -> u32 {
        // Plus one block, because a pixel interpolates between its own block and the neighbouring one.
        if self.follows_curvature() { (self.axis_step() * AXIS_REACH + 1) as u32 * BLOCK_PX as u32 } else { 0 }
    }

    /// Returns whether the marks of any set follow the curvature of the land.
    pub(crate) fn follows_curvature(&self) -> bool {
        self.sets.iter().any(|set| set.direction == Direction::Curvature)
    }
}

impl LayerBehaviour for Hatching {
    fn inks(&self) -> Vec<Ink> {
        let set = |(number, set): (usize, &MarkSet)| TracedSet {
            label: format!("Hatching {number}, {}", set.marks),
            is_of_dots: set.recipe.as_ref().is_some_and(|recipe| recipe.kind.is_of_dots()),
        };
        vec![Ink {
            id: "marks",
            label: "Hatching".to_owned(),
            color: Some(self.ink),
            channels: Channels::One(0),
            fading: Fading::OnSurface { faintest: self.faintest, reach: 1.0, follows_tone: true },
            makes_tone: true,
            is_main: true,
            trace: Trace::Sets((1..).zip(&self.sets).map(set).collect()),
        }]
    }

    fn margins(&self) -> Margins {
        let balance_px = if self.balance { REACH_CELLS * self.cell_px() } else { 0 };
        Margins { margin_px: balance_px + self.axis_reach_px(), ..Margins::default() }
    }

    fn summary(&self) -> Option<String> {
        Some(match self.zoom {
            Zoom::Blend => "hatching".to_owned(),
            Zoom::Add => "hatching (additive)".to_owned(),
        })
    }

    fn scale_marks(&mut self, factor: f32) {
        for set in &mut self.sets {
            set.size = (set.size * factor).clamp(0.25, 8.0);
        }
    }

    fn complete(&mut self, source: RecipeSource<'_>) -> Result<Vec<PathBuf>, (String, StyleError)> {
        let mut files = Vec::new();
        for (number, set) in self.sets.iter_mut().enumerate() {
            set.complete(source).map_err(|error| (format!("sets[{number}].marks"), error))?;
            files.extend(set.files(source));
        }
        self.sets.sort_by(|a, b| a.from.total_cmp(&b.from));
        Ok(files)
    }
}

impl Hatching {
    /// Takes the loaded recipes of another version of the layer, which names the same ones.
    pub(in crate::style) fn take_recipes(&mut self, from: &Self) {
        self.sets.iter_mut().zip(&from.sets).for_each(|(set, from)| set.recipe.clone_from(&from.recipe));
        self.sets.sort_by(|a, b| a.from.total_cmp(&b.from));
    }
}

impl MarkSet {
    /// Loads the recipe of the marks and checks its images.
    fn complete(&mut self, source: RecipeSource<'_>) -> Result<(), StyleError> {
        let recipe = source.marks(&self.marks)?;
        marks::check_pictures(&recipe)?;
        self.recipe = Some(recipe);
        Ok(())
    }

    /// Returns the files that the set was read from.
    fn files(&self, source: RecipeSource<'_>) -> impl Iterator<Item = PathBuf> {
        let images = self.recipe.iter().flat_map(|recipe| recipe.images.iter().cloned());
        let own_file = match source {
            RecipeSource::Folder(folder) => marks::file(&self.marks, folder),
            RecipeSource::Embedded(_) => None,
        };
        own_file.into_iter().chain(images)
    }
}
