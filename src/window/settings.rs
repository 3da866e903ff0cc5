//! Settings that can be changed during a flight.

use std::collections::BTreeMap;

use crate::frame::Antialias;
use crate::ladder::Quality;
use crate::scene::stereo::{Eyes, HYPERSTEREO, Pair};
use crate::scene::view::{Rig, View};
use crate::scene::{SceneFocus, Sun};
use crate::studio::document::StyleDocument;
use crate::style::{self, Style};

/// Sizes of the picture as fractions of the window's size.
pub(super) const SCALES: [f64; 3] = [1.0, 0.75, 0.5];

/// Samples per pixel of a screenshot, if the window smooths edges.
const SCREENSHOT_SAMPLES: u32 = 16;
/// Time constant of the distance between the eyes: after this time 63 % of a change is reached.
const FOLLOWS_IN_S: f64 = 0.8;

/// Settings of the panel, apart from the camera's.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Settings {
    /// Index into [`Styles`].
    pub style: usize,
    /// Index into [`SCALES`].
    pub scale: usize,
    /// Smoothing of edges.
    pub antialias: Antialias,
    /// The exactness with which the picture is drawn, within the other settings.
    pub quality: Quality,
    /// Largest error of the drawn surface.
    pub lod_error_px: f64,
    /// Position of the sun.
    pub sun: Sun,
    /// Distance at which haze has removed 63 % of the contrast.
    pub haze_m: f64,
    /// Factor on all heights; the land follows once it is read again.
    pub exaggeration: f64,
    /// Height of the sea, if there is one: land at or below it is water.
    pub sea_level_m: Option<f64>,
    /// Seed of the forest, if there are trees; the land follows once no control is dragged.
    pub tree_seed: Option<u32>,
    /// Seed of the land, if it is grown from one; the world follows once no control is dragged.
    pub world_seed: Option<u32>,
    /// The area of full contrast, if the scene or the user places one.
    pub focus: Option<SceneFocus>,
    /// Eyes that are shown.
    pub eyes: Eyes,
    /// The stereo pair.
    pub pair: Pair,
    /// Whether the distance between the eyes follows the distance to the nearest land.
    pub follows_land: bool,
}

impl Settings {
    /// Returns the size of one eye's picture in a window of `window_px`, at the window's own resolution.
    pub(super) fn eye_px(&self, [width, height]: [u32; 2]) -> [u32; 2] {
        [if self.eyes == Eyes::SideBySide { width.div_ceil(2) } else { width }, height]
    }

    /// Returns the size of one eye's picture in a window of `window_px`.
    pub(super) fn picture_px(&self, window_px: [u32; 2]) -> [u32; 2] {
        self.scaled_px(window_px, self.scale())
    }

    /// Returns the size of one eye's picture that is `scale` times as large as it is in a window of `window_px`.
    pub(super) fn scaled_px(&self, window_px: [u32; 2], scale: f64) -> [u32; 2] {
        self.eye_px(window_px).map(|side| ((f64::from(side) * scale).round() as u32).max(1))
    }

    /// Returns the pixels of the picture per pixel of the window, in each direction.
    pub(super) fn scale(&self) -> f64 {
        SCALES[self.scale]
    }

    /// Returns the samples per pixel of a screenshot.
    pub(super) fn samples(&self) -> u32 {
        if self.antialias == Antialias::Temporal { SCREENSHOT_SAMPLES } else { 1 }
    }

    /// Returns the eyes for a camera; `before` is the stereo pair of the previous frame.
    pub(super) fn rig(&self, camera: &View, before: &Pair) -> Rig {
        if self.eyes == Eyes::Mono { Rig::mono(*camera) } else { self.pair.rig_after(before, camera) }
    }

    /// Moves the distance between the eyes towards its target, if it follows the land; returns whether it is still
    /// moving. It takes two to three seconds from end to end: a sudden change of depth is unpleasant to look at.
    pub(super) fn follow_land(&mut self, nearest_m: f64, step_s: f64) -> bool {
        if self.eyes == Eyes::Mono || !self.follows_land {
            return false;
        }
        let wanted_m = HYPERSTEREO * nearest_m;
        let rate = (wanted_m / self.pair.ipd_m.max(1e-6)).ln();
        let moves = rate.abs() > 0.05;
        if moves {
            self.pair.ipd_m = self.pair.ipd_m.max(1e-6) * (rate * (1.0 - (-step_s / FOLLOWS_IN_S).exp())).exp();
        }
        moves
    }

    /// Chooses a finer (1) or coarser (−1) picture.
    pub(super) fn step_scale(&mut self, step: i32) {
        self.scale = self.scale.saturating_add_signed(-step as isize).min(SCALES.len() - 1);
    }

    /// Goes `step` styles forward in the list, wrapping around at its ends.
    pub(super) fn step_style(&mut self, step: i32, styles: usize) {
        self.style = (self.style as i64 + i64::from(step)).rem_euclid(styles as i64) as usize;
    }
}

/// The styles to choose from: the presets, the style of the command line, and those that were saved.
pub(super) struct Styles {
    /// The styles as they are drawn, edits included.
    list: Vec<Style>,
    /// Name of the preset or path of the file of each style.
    names: Vec<String>,
    /// The styles that have been opened for editing, by their index in the list.
    documents: BTreeMap<usize, StyleDocument>,
    /// Whether the world has features of files, and a graticule, which every style draws then.
    features: [bool; 2],
}

impl Styles {
    /// Loads the presets and the style `asked`; also returns its index in the list.
    ///
    /// # Errors
    /// Fails if `asked` is not a valid style.
    pub(super) fn with(asked: &str) -> Result<(Self, usize), style::StyleError> {
        let names = style::names();
        let list = names.iter().map(|name| Style::load(name)).collect::<Result<Vec<_>, _>>()?;
        let names: Vec<String> = names.into_iter().map(str::to_owned).collect();
        let mut styles = Self { list, names, documents: BTreeMap::new(), features: [false; 2] };
        let place = match styles.names.iter().position(|name| *name == asked) {
            Some(place) => place,
            None => styles.add(StyleDocument::open(asked)?),
        };
        Ok((styles, place))
    }

    /// Adds a style that is open for editing, and returns its index. A style of the same file is replaced.
    pub(super) fn add(&mut self, document: StyleDocument) -> usize {
        let known = self.names.iter().position(|name| name == document.name());
        let index = known.unwrap_or(self.list.len());
        if known.is_none() {
            self.names.push(document.name().to_owned());
            self.list.push(self.drawn(document.drawn()));
        }
        self.documents.insert(index, document);
        self.refresh(index);
        index
    }

    /// Opens a style for editing, if it is not open. Returns whether it was opened now.
    ///
    /// # Errors
    /// Fails if its file is not valid any more.
    pub(super) fn open(&mut self, index: usize) -> Result<bool, style::StyleError> {
        if self.documents.contains_key(&index) {
            return Ok(false);
        }
        self.documents.insert(index, StyleDocument::open(&self.names[index])?);
        Ok(true)
    }

    /// Returns a style that is open for editing.
    pub(super) fn document(&self, index: usize) -> Option<&StyleDocument> {
        self.documents.get(&index)
    }

    /// Returns a style that is open for editing; after a change, [`Styles::refresh`] must be called.
    pub(super) fn document_mut(&mut self, index: usize) -> Option<&mut StyleDocument> {
        self.documents.get_mut(&index)
    }

    /// Returns the styles that are open for editing, with their indices.
    pub(super) fn documents(&self) -> impl Iterator<Item = (usize, &StyleDocument)> {
        self.documents.iter().map(|(index, document)| (*index, document))
    }

    /// Takes the changes of a document into the list.
    pub(super) fn refresh(&mut self, index: usize) {
        if let Some(document) = self.documents.get(&index) {
            self.list[index] = self.drawn(document.drawn());
        }
    }

    /// Says whether the world has features of files, and a graticule.
    pub(super) fn set_features(&mut self, features: [bool; 2]) {
        if std::mem::replace(&mut self.features, features) == features {
            return;
        }
        for index in 0..self.list.len() {
            let style = match self.documents.get(&index) {
                Some(document) => document.drawn(),
                // A file that has been broken in the meantime keeps its style.
                None => Style::load(&self.names[index]).unwrap_or_else(|_| self.list[index].clone()),
            };
            self.list[index] = self.drawn(style);
        }
    }

    fn drawn(&self, style: Style) -> Style {
        style.with_features(self.features)
    }

    /// Returns the name of a preset, or the path of a file.
    pub(super) fn name(&self, index: usize) -> &str {
        &self.names[index]
    }

    /// Returns the name of a preset, or the path of a file that does not depend on the current folder.
    pub(super) fn lasting_name(&self, index: usize) -> String {
        lasting(&self.names[index])
    }

    /// Returns the index of the style with a name or path.
    pub(super) fn place_of(&self, name: &str) -> Option<usize> {
        let name = lasting(name);
        self.names.iter().position(|known| lasting(known) == name)
    }

    /// Returns all styles; there is at least one.
    pub(super) fn list(&self) -> &[Style] {
        &self.list
    }
}

/// Returns a path that does not depend on the current folder; names of presets stay.
fn lasting(name: &str) -> String {
    match style::preset_text(name) {
        Some(_) => name.to_owned(),
        None => std::path::absolute(name).map_or_else(|_| name.to_owned(), |path| path.display().to_string()),
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(crate) fn settings() -> Settings {
        let (eyes, pair) = (Eyes::Mono, Pair::default());
        let sun = Sun::default();
        let antialias = Antialias::None;
        let (style, scale, lod_error_px, haze_m, follows_land) = (0, 0, 1.0, 1000.0, false);
        let (exaggeration, focus, sea_level_m, tree_seed, world_seed) = (1.0, None, None, None, None);
        Settings {
            style,
            scale,
            quality: Quality::AsSet,
            antialias,
            lod_error_px,
            sun,
            haze_m,
            exaggeration,
            sea_level_m,
            tree_seed,
            world_seed,
            focus,
            eyes,
            pair,
            follows_land,
        }
    }

    #[test]
    fn steps_stay_in_their_lists() {
        let mut settings = settings();
        settings.step_scale(1);
        assert_eq!(settings.scale, 0);
        (0..9).for_each(|_| settings.step_scale(-1));
        assert_eq!(settings.picture_px([641, 1]), [321, 1]);
        settings.step_style(-1, 4);
        assert_eq!(settings.style, 3);
        settings.step_style(1, 4);
        assert_eq!(settings.style, 0);
    }

    #[test]
    fn eyes_follow_the_land_slowly() {
        let mut settings = settings();
        assert!(!settings.follow_land(3000.0, 0.1), "a single eye has no distance to adapt");
        settings.eyes = Eyes::SideBySide;
        assert_eq!(settings.picture_px([641, 10]), [321, 10]);
        settings.follows_land = true;
        let mut before_m = settings.pair.ipd_m;
        let mut frames = 0;
        while settings.follow_land(3000.0, 1.0 / 30.0) {
            assert!(settings.pair.ipd_m > before_m && settings.pair.ipd_m < 1.4 * before_m);
            before_m = settings.pair.ipd_m;
            frames += 1;
        }
        assert!((30..300).contains(&frames), "{frames}");
        assert!((settings.pair.ipd_m / 100.0 - 1.0).abs() < 0.06, "{}", settings.pair.ipd_m);
    }

    #[test]
    fn every_preset_exists_and_the_requested_one_is_found() {
        let (styles, place) = Styles::with("ink").unwrap();
        assert_eq!(styles.list().len(), style::names().len());
        assert_eq!(style::names()[place], "ink");
        assert!(Styles::with("no such style").is_err());
    }
}
