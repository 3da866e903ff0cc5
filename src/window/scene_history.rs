//! The history of the scene: the changes of [`Settings`] that can be undone, apart from the choice of the style.
//!
//! Once a frame, the settings are compared with those of the frame before ([`SceneHistory::note`]), so no control has to
//! report what it does. A step restores one value and leaves the others as they are: some change by themselves, such as
//! the distance between the eyes that follows the land.

#[cfg(test)]
mod tests;

use super::settings::{SCALES, Settings};
use crate::frame::Antialias;
use crate::ladder::Quality;
use crate::studio::history::{StepName, next_turn};

/// Largest number of steps that can be undone; the oldest is dropped.
const MAX_STEPS: usize = 100;

/// A value of the scene with steps of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SceneValue {
    Sun,
    Haze,
    Focus,
    Exaggeration,
    SeaLevel,
    TreeSeed,
    WorldSeed,
    TerrainError,
    Antialias,
    Resolution,
    Quality,
    Eyes,
    EyeDistance,
    Convergence,
}

impl SceneValue {
    const ALL: [Self; 14] = [
        Self::Sun,
        Self::Haze,
        Self::Focus,
        Self::Exaggeration,
        Self::SeaLevel,
        Self::TreeSeed,
        Self::WorldSeed,
        Self::TerrainError,
        Self::Antialias,
        Self::Resolution,
        Self::Quality,
        Self::Eyes,
        Self::EyeDistance,
        Self::Convergence,
    ];

    /// Returns whether the value is the same in two settings.
    fn is_alike(self, a: &Settings, b: &Settings) -> bool {
        match self {
            Self::Sun => a.sun == b.sun,
            Self::Haze => a.haze_m == b.haze_m,
            Self::Focus => a.focus == b.focus,
            Self::Exaggeration => a.exaggeration == b.exaggeration,
            Self::SeaLevel => a.sea_level_m == b.sea_level_m,
            Self::TreeSeed => a.tree_seed == b.tree_seed,
            Self::WorldSeed => a.world_seed == b.world_seed,
            Self::TerrainError => a.lod_error_px == b.lod_error_px,
            Self::Antialias => a.antialias == b.antialias,
            Self::Resolution => a.scale == b.scale,
            Self::Quality => a.quality == b.quality,
            Self::Eyes => a.eyes == b.eyes,
            // A distance that follows the land is not the user's.
            Self::EyeDistance => a.follows_land == b.follows_land && (a.follows_land || a.pair.ipd_m == b.pair.ipd_m),
            Self::Convergence => a.pair.convergence_m == b.pair.convergence_m,
        }
    }

    fn copy(self, from: &Settings, to: &mut Settings) {
        match self {
            Self::Sun => to.sun = from.sun,
            Self::Haze => to.haze_m = from.haze_m,
            Self::Focus => to.focus = from.focus,
            Self::Exaggeration => to.exaggeration = from.exaggeration,
            Self::SeaLevel => to.sea_level_m = from.sea_level_m,
            Self::TreeSeed => to.tree_seed = from.tree_seed,
            Self::WorldSeed => to.world_seed = from.world_seed,
            Self::TerrainError => to.lod_error_px = from.lod_error_px,
            Self::Antialias => to.antialias = from.antialias,
            Self::Resolution => to.scale = from.scale,
            Self::Quality => to.quality = from.quality,
            Self::Eyes => to.eyes = from.eyes,
            Self::EyeDistance => (to.follows_land, to.pair.ipd_m) = (from.follows_land, from.pair.ipd_m),
            Self::Convergence => to.pair.convergence_m = from.pair.convergence_m,
        }
    }

    /// Returns the name of a step that leads to this value, such as "Sea level 300 m".
    fn step_name(self, settings: &Settings) -> String {
        match self {
            Self::Sun => {
                let [azimuth_deg, elevation_deg] =
                    [settings.sun.azimuth_deg, settings.sun.elevation_deg].map(|angle_deg| rounded(angle_deg, 1));
                format!("Sun at azimuth {azimuth_deg}°, elevation {elevation_deg}°")
            }
            Self::Haze => format!("Haze {} km", rounded(settings.haze_m / 1000.0, 1)),
            Self::Focus => settings.focus.map_or_else(
                || "No focus".to_owned(),
                |focus| {
                    let [radius_m, strength] = [rounded(focus.radius_m, 0), rounded(focus.strength, 2)];
                    format!("Focus of radius {radius_m} m, strength {strength}")
                },
            ),
            Self::Exaggeration => format!("Exaggeration {} ×", rounded(settings.exaggeration, 2)),
            Self::SeaLevel => match settings.sea_level_m {
                Some(level_m) => format!("Sea level {} m", rounded(level_m, 1)),
                None => "No sea".to_owned(),
            },
            Self::TreeSeed => {
                settings.tree_seed.map_or_else(|| "No trees".to_owned(), |seed| format!("Tree seed {seed}"))
            }
            Self::WorldSeed => format!("World seed {}", settings.world_seed.unwrap_or_default()),
            Self::TerrainError => format!("Terrain error {} px", rounded(settings.lod_error_px, 2)),
            Self::Antialias if settings.antialias == Antialias::None => "No smooth edges".to_owned(),
            Self::Antialias => "Smooth edges".to_owned(),
            Self::Resolution => format!("Resolution {}", SCALES[settings.scale]),
            Self::Quality => match settings.quality {
                Quality::Budget(ms) => format!("Frame time {} ms", rounded(ms, 1)),
                quality => format!("Quality: {}", quality.name()),
            },
            Self::Eyes => format!("Eyes: {}", settings.eyes),
            Self::EyeDistance if settings.follows_land => "Auto eye distance".to_owned(),
            Self::EyeDistance => format!("Eye distance {} m", rounded(settings.pair.ipd_m, 3)),
            Self::Convergence => match settings.pair.convergence_m {
                Some(distance_m) => format!("Convergence {} m", rounded(distance_m, 1)),
                None => "Convergence ∞".to_owned(),
            },
        }
    }
}

fn rounded(value: f64, digits: i32) -> f64 {
    let factor = 10_f64.powi(digits);
    (value * factor).round() / factor
}

/// A step that can be undone or redone.
#[derive(Clone, Debug)]
struct Step {
    value: SceneValue,
    name: String,
    /// Position of the last change, undo or redo of the step in the order of all histories.
    turn: u64,
    /// Settings with the value on the other side of the step: before it if it can be undone, after it if it can be redone.
    settings: Settings,
}

/// The steps of the scene.
#[derive(Debug)]
pub(super) struct SceneHistory {
    undo: Vec<Step>,
    redo: Vec<Step>,
    /// The settings whose changes have been noted.
    noted: Settings,
    /// Whether further changes of the same value belong to the last step, because a control is still held.
    is_open: bool,
}

impl SceneHistory {
    /// Begins a history without steps.
    pub(super) fn new(settings: &Settings) -> Self {
        Self { undo: Vec::new(), redo: Vec::new(), noted: settings.clone(), is_open: false }
    }

    /// Records the changes since the last call. While a control is held, or a number is typed, further changes of the same
    /// value belong to the same step; a step that has changed nothing in the end is forgotten.
    pub(super) fn note(&mut self, settings: &Settings, is_held: bool) {
        for value in SceneValue::ALL {
            if !value.is_alike(&self.noted, settings) {
                self.record(value, settings);
                value.copy(settings, &mut self.noted);
            }
        }
        // Values that change by themselves.
        self.noted.clone_from(settings);
        if !is_held {
            self.close();
        }
    }

    fn record(&mut self, value: SceneValue, settings: &Settings) {
        self.redo.clear();
        let (name, turn) = (value.step_name(settings), next_turn());
        if self.is_open
            && let Some(last) = self.undo.last_mut().filter(|last| last.value == value)
        {
            (last.name, last.turn) = (name, turn);
            return;
        }
        self.close();
        self.undo.push(Step { value, name, turn, settings: self.noted.clone() });
        if self.undo.len() > MAX_STEPS {
            self.undo.remove(0);
        }
        self.is_open = true;
    }

    fn close(&mut self) {
        if std::mem::take(&mut self.is_open)
            && self.undo.last().is_some_and(|last| last.value.is_alike(&last.settings, &self.noted))
        {
            self.undo.pop();
        }
    }

    /// Accepts settings that the program has changed, without recording a step.
    pub(super) fn follow(&mut self, settings: &Settings) {
        // Every setting but the style is a value of the scene: a new one must be added to `SceneValue`.
        let Settings {
            style: _,
            scale: _,
            quality: _,
            antialias: _,
            lod_error_px: _,
            sun: _,
            haze_m: _,
            exaggeration: _,
            sea_level_m: _,
            tree_seed: _,
            world_seed: _,
            focus: _,
            eyes: _,
            pair: _,
            follows_land: _,
        } = settings;
        self.noted.clone_from(settings);
    }

    /// Takes settings in which a value is again what it was, because the program could not follow a change of the user,
    /// and forgets the step of that change.
    pub(super) fn refuse(&mut self, value: SceneValue, settings: &Settings) {
        value.copy(settings, &mut self.noted);
        for steps in [&mut self.undo, &mut self.redo] {
            let newest = steps.iter().rposition(|step| step.value == value);
            if let Some(index) = newest.filter(|index| value.is_alike(&steps[*index].settings, settings)) {
                steps.remove(index);
            }
        }
    }

    /// Undoes the last step in the settings, all of whose changes have been noted. Returns the name of the step.
    pub(super) fn undo(&mut self, settings: &mut Settings) -> Option<String> {
        self.close();
        take(&mut self.undo, &mut self.redo, settings).inspect(|_| self.noted.clone_from(settings))
    }

    /// Repeats the step that was undone last. Returns the name of the step.
    pub(super) fn redo(&mut self, settings: &mut Settings) -> Option<String> {
        self.close();
        take(&mut self.redo, &mut self.undo, settings).inspect(|_| self.noted.clone_from(settings))
    }

    /// Returns the steps that [`SceneHistory::undo`] and [`SceneHistory::redo`] would take.
    pub(super) fn steps(&self) -> [Option<StepName<'_>>; 2] {
        [&self.undo, &self.redo].map(|steps| steps.last().map(|step| (step.turn, step.name.as_str())))
    }
}

fn take(from: &mut Vec<Step>, to: &mut Vec<Step>, settings: &mut Settings) -> Option<String> {
    let Step { value, name, settings: other, .. } = from.pop()?;
    to.push(Step { value, name: name.clone(), turn: next_turn(), settings: settings.clone() });
    value.copy(&other, settings);
    Some(name)
}

/// Returns whether a control is held or a text is typed, after the panels were laid out.
pub(super) fn is_held(context: &egui::Context) -> bool {
    context.egui_is_using_pointer() || context.text_edit_focused()
}

/// Returns whether the step of the scene was changed later than that of the style, so that it is undone or redone first.
pub(super) fn is_later(of_scene: Option<StepName<'_>>, of_style: Option<StepName<'_>>) -> bool {
    let turn = |(turn, _)| turn;
    of_scene.is_some() && of_scene.map(turn) > of_style.map(turn)
}

/// Returns the names of the steps that are undone and redone next, of the scene or of the style.
pub(super) fn next_names<'a>(
    of_scene: [Option<StepName<'a>>; 2],
    of_style: [Option<StepName<'a>>; 2],
) -> [Option<&'a str>; 2] {
    [0, 1].map(|side| {
        let (scene, style) = (of_scene[side], of_style[side]);
        if is_later(scene, style) { scene } else { style }.map(|(_, name)| name)
    })
}
