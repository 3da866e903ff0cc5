//! Temporal anti-aliasing: when frames are samples of one picture, and where in a pixel each samples it.
//!
//! Both eyes of a stereo pair sample at the same point of the sequence. So two eyes at one position draw the same
//! picture, and eyes that are exchanged exchange their pictures.

use glam::DVec2;

use crate::composite::temporal_aa::{self, Plan};
use crate::picture::supersampling;
use crate::scene::Light;
use crate::scene::view::{Rig, View};
use crate::style::Style;

/// Number of samples after which a picture at rest is finished.
pub(crate) const SAMPLES_AT_REST: u32 = 64;

/// How successive frames are anti-aliased.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Antialias {
    /// Each frame is a picture of its own.
    #[default]
    None,
    /// Each frame is a sample of the picture ([`crate::composite::temporal_aa`]).
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

/// The history of temporal anti-aliasing.
#[derive(Default)]
pub(super) struct Samples {
    pub(super) antialias: Antialias,
    /// The last frame; `None` before the first and without temporal anti-aliasing.
    last: Option<Last>,
    /// Number of frames that were samples.
    frames: usize,
    /// Number of successive frames, up to the last, that were further samples of the same picture.
    frames_at_rest: u32,
    /// Whether the last frame continued the mean.
    has_history: bool,
}

/// The eyes, style and light of the last frame.
struct Last {
    rig: Rig,
    style: Style,
    light: Light,
    /// Allowed error of the mesh, in pixels.
    error_px: f64,
}

impl Last {
    /// Returns whether a frame with these eyes and this style is at rest: both are the same, and no eye moves.
    fn is_alike(&self, rig: &Rig, style: &Style) -> bool {
        let rests = |eye: &View| eye.pose == eye.previous && eye.lens == eye.previous_lens;
        self.style == *style && continues(&self.rig, rig) && rig.eyes.iter().all(rests)
    }
}

/// The eyes, style and light of the next frame.
pub(super) struct SampleInputs<'a> {
    pub rig: &'a Rig,
    pub style: &'a Style,
    pub light: &'a Light,
    /// Allowed error of the mesh, in pixels.
    pub error_px: f64,
    /// Whether tiles arrive, strokes fade in or out, or trees sway.
    pub changes: bool,
    /// Whether pictures of another size continue those of the last frame.
    pub has_room: bool,
}

impl Samples {
    /// Sets the number of the next frame.
    pub(super) fn begin_at(&mut self, frame: u64) {
        self.frames = usize::try_from(frame).unwrap_or_default();
    }

    /// Returns by how much the content of the next frame is displaced, in pixels. A frame that rebuilds strokes is not
    /// displaced, because the visible parts of edges would then differ from frame to frame.
    pub(super) fn jitter_px(&self, rig: &Rig, style: &Style, strokes_settle: bool) -> DVec2 {
        let rebuilds_strokes = style.strokes().is_some()
            && (strokes_settle || !self.last.as_ref().is_some_and(|last| last.is_alike(rig, style)));
        if self.antialias == Antialias::None || rebuilds_strokes {
            return DVec2::ZERO;
        }
        supersampling::jitter_px(1 + self.frames as u32 % SAMPLES_AT_REST)
    }

    /// Plans how a frame uses the previous frames, and records it as the last one. Returns `None` without temporal
    /// anti-aliasing.
    pub(super) fn plan(&mut self, inputs: &SampleInputs<'_>) -> Option<Plan> {
        if self.antialias == Antialias::None {
            self.last = None;
            return None;
        }
        let continued = |last: &Last| {
            let is_seen = continues(&last.rig, inputs.rig) || (inputs.has_room && follows(&last.rig, inputs.rig));
            last.style.is_edit_of(inputs.style) && is_seen
        };
        let last = self.last.take().filter(continued);
        let is_edited = last.as_ref().is_some_and(|last| last.style != *inputs.style);
        let rests = !inputs.changes
            && last.as_ref().is_some_and(|last| {
                let is_lit_alike = last.light == *inputs.light && last.error_px == inputs.error_px;
                is_lit_alike && last.is_alike(inputs.rig, inputs.style)
            });
        self.frames_at_rest = if rests { self.frames_at_rest + 1 } else { 0 };
        self.frames += 1;
        let has_history = last.is_some();
        let history = last.as_ref().and_then(|last| last.rig.eyes.first()).or(inputs.rig.eyes.first());
        let history_px = history.map_or([1, 1], |eye| eye.part.size_px);
        self.has_history = has_history;
        // A style is large and rarely changes, so the stored one is moved rather than cloned.
        let unchanged = last.filter(|_| !is_edited);
        let style = unchanged.map_or_else(|| inputs.style.clone(), |last| last.style);
        self.last = Some(Last { rig: inputs.rig.clone(), style, light: *inputs.light, error_px: inputs.error_px });
        Some(Plan { frame: self.frames, has_history, history_px, frames_at_rest: self.frames_at_rest, is_edited })
    }

    /// Returns whether the last frame continued the mean of the frames before it.
    pub(super) fn continues(&self) -> bool {
        self.has_history
    }

    /// Returns whether the next frame of the same view would change the picture.
    pub(super) fn is_settling(&self) -> bool {
        self.antialias == Antialias::Temporal && self.frames_at_rest < SAMPLES_AT_REST
    }

    /// Returns whether the last frame was a further sample of the same picture.
    pub(super) fn rests(&self) -> bool {
        self.frames_at_rest > 0
    }

    /// Returns the index in [`temporal_aa::HISTORY`] that the last frame wrote, if it was a sample.
    pub(super) fn written(&self) -> Option<usize> {
        self.last.is_some().then_some(self.frames % temporal_aa::HISTORY.len())
    }

    /// Discards the history.
    pub(super) fn forget(&mut self) {
        self.last = None;
        self.frames_at_rest = 0;
    }
}

/// Returns whether each eye of `rig` continues from the pose, lens and time that the last frame drew, in a picture of the
/// same size.
fn continues(last: &Rig, rig: &Rig) -> bool {
    let is_alike = |(last, eye): (&View, &View)| last.part == eye.part && last.picture_px == eye.picture_px;
    follows(last, rig) && last.eyes.iter().zip(&rig.eyes).all(is_alike)
}

/// Returns whether each eye of `rig` continues from the pose, lens and time that the last frame drew.
pub(super) fn follows(last: &Rig, rig: &Rig) -> bool {
    let is_next = |(last, eye): (&View, &View)| {
        last.pose == eye.previous && last.lens == eye.previous_lens && last.clock.now_s == eye.clock.before_s
    };
    last.eyes.len() == rig.eyes.len() && last.eyes.iter().zip(&rig.eyes).all(is_next)
}
