//! When frames are samples of one picture, and where in their pixels the samples lie.
//!
//! Both eyes of a pair have the same point of the sequence: eyes at one place draw one picture, and eyes that are
//! exchanged exchange theirs.

use glam::DVec2;

use crate::composite::temporal_aa::{self, Plan};
use crate::picture::supersampling;
use crate::scene::Light;
use crate::scene::view::{Rig, View};
use crate::style::Style;

/// Samples of a picture at rest; then it is done.
pub const SAMPLES_AT_REST: u32 = 64;

/// How frames that follow each other smooth their edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Antialias {
    /// Each stands for itself.
    #[default]
    None,
    /// Each is a sample of the picture ([`crate::composite::temporal_aa`]).
    Temporal,
}

impl std::fmt::Display for Antialias {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::None => "none",
            Self::Temporal => "temporal",
        })
    }
}

impl std::str::FromStr for Antialias {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "none" => Ok(Self::None),
            "temporal" => Ok(Self::Temporal),
            _ => Err("it must be none or temporal".to_owned()),
        }
    }
}

/// What the frames before leave to the next one.
#[derive(Default)]
pub(super) struct Samples {
    pub(super) antialias: Antialias,
    last: Option<Last>,
    frames: usize,
    frames_at_rest: u32,
    /// Whether the last frame continued the mean.
    has_history: bool,
}

/// What was drawn last.
struct Last {
    rig: Rig,
    style: Style,
    light: Light,
    error_px: f64,
}

impl Last {
    /// Whether the eyes and the style are those of a frame that rests.
    fn is_alike(&self, rig: &Rig, style: &Style) -> bool {
        let rests = |eye: &View| eye.pose == eye.previous && eye.lens == eye.previous_lens;
        self.style == *style && continues(&self.rig, rig) && rig.eyes.iter().all(rests)
    }
}

/// What a frame draws.
pub(super) struct Asked<'a> {
    pub rig: &'a Rig,
    pub style: &'a Style,
    pub light: &'a Light,
    /// That the mesh was allowed.
    pub error_px: f64,
    /// Tiles or strokes come or go, or trees sway.
    pub changes: bool,
}

impl Samples {
    /// By how much the content of the next frame is moved. One that makes strokes anew is not: what is seen of edges
    /// would be another part of them from frame to frame.
    pub(super) fn jitter_px(&self, rig: &Rig, style: &Style, strokes_settle: bool) -> DVec2 {
        let makes_strokes = style.strokes().is_some()
            && (strokes_settle || !self.last.as_ref().is_some_and(|last| last.is_alike(rig, style)));
        if self.antialias == Antialias::None || makes_strokes {
            return DVec2::ZERO;
        }
        supersampling::jitter_px(1 + self.frames as u32 % SAMPLES_AT_REST)
    }

    /// What the frame makes of those before it; the next one follows on it. None where frames stand for themselves.
    pub(super) fn plan(&mut self, asked: &Asked<'_>) -> Option<Plan> {
        if self.antialias == Antialias::None {
            self.last = None;
            return None;
        }
        let continued = |last: &Last| last.style.is_edit_of(asked.style) && continues(&last.rig, asked.rig);
        let last = self.last.take().filter(continued);
        let is_edited = last.as_ref().is_some_and(|last| last.style != *asked.style);
        let rests = !asked.changes
            && last.as_ref().is_some_and(|last| {
                let is_lit_alike = last.light == *asked.light && last.error_px == asked.error_px;
                is_lit_alike && last.is_alike(asked.rig, asked.style)
            });
        self.frames_at_rest = if rests { self.frames_at_rest + 1 } else { 0 };
        self.frames += 1;
        let has_history = last.is_some();
        self.has_history = has_history;
        // A style is large, and mostly the same.
        let unchanged = last.filter(|_| !is_edited);
        let style = unchanged.map_or_else(|| asked.style.clone(), |last| last.style);
        self.last = Some(Last { rig: asked.rig.clone(), style, light: *asked.light, error_px: asked.error_px });
        Some(Plan { frame: self.frames, has_history, frames_at_rest: self.frames_at_rest, is_edited })
    }

    /// Returns whether the last frame had a history.
    pub(super) fn continues(&self) -> bool {
        self.has_history
    }

    /// Whether the next frame of the same view would make another picture.
    pub(super) fn is_settling(&self) -> bool {
        self.antialias == Antialias::Temporal && self.frames_at_rest < SAMPLES_AT_REST
    }

    /// Whether the last frame was a further sample of the same picture.
    pub(super) fn rests(&self) -> bool {
        self.frames_at_rest > 0
    }

    /// Which of the histories the last frame wrote.
    pub(super) fn writes(&self) -> Option<usize> {
        self.last.is_some().then_some(self.frames % temporal_aa::HISTORY.len())
    }

    /// The next frame is the first.
    pub(super) fn forget(&mut self) {
        self.last = None;
        self.frames_at_rest = 0;
    }
}

/// Whether eyes follow on those that were drawn last.
fn continues(last: &Rig, rig: &Rig) -> bool {
    let follows = |(last, eye): (&View, &View)| {
        let is_next = last.pose == eye.previous && last.lens == eye.previous_lens;
        is_next && last.clock.now_s == eye.clock.before_s && last.part == eye.part && last.picture_px == eye.picture_px
    };
    last.eyes.len() == rig.eyes.len() && last.eyes.iter().zip(&rig.eyes).all(follows)
}
