//! The curve that fits the tones to the picture, from frame to frame ([`crate::tones::fit`]).

use super::antialias::follows;
use crate::gpu::recorder::Recorder;
use crate::gpu::{Gpu, GpuError};
use crate::scene::Light;
use crate::scene::tone_curve::ToneCurve;
use crate::scene::view::Rig;
use crate::style::{Relief, Shading, Style, Tone};
use crate::tones::fit::{FitMemory, Follows, FrameFit};
use crate::tones::masses::{self, FrameMasses, Masses};

/// The curve of a renderer, and what the last frame was lit by.
#[derive(Default)]
pub(super) struct Tones {
    memory: FitMemory,
    last: Option<(Rig, Lit)>,
    /// The masses of the next frames; `None` if each eye computes its own.
    given_masses: Option<Masses>,
    /// Time in which the curve still follows a view that is at rest, in seconds.
    settles_s: f64,
}

/// Time after which the curve of a view at rest has arrived, in seconds.
const ARRIVES_S: f64 = 4.0;

/// All that sets the tones of a view; another one is another drawing.
#[derive(PartialEq)]
struct Lit {
    tone: Tone,
    shading: Shading,
    relief: Option<Relief>,
    light: Light,
}

/// The eyes, style and light of the next frame.
pub(super) struct TonesInputs<'a> {
    pub(super) rig: &'a Rig,
    pub(super) style: &'a Style,
    pub(super) light: &'a Light,
    /// Time since the last frame, in seconds.
    pub(super) step_s: f64,
    /// Whether tiles of this view have arrived or are missing.
    pub(super) land_changes: bool,
}

impl Tones {
    /// Returns whether the curve still moves while the view is at rest.
    pub(super) fn is_settling(&self) -> bool {
        self.settles_s > 0.0
    }

    /// Lets the next frame measure its curve without regard to the last one.
    pub(super) fn forget(&mut self) {
        self.memory.forget();
    }

    /// Returns the curve of the next frame; `None` if the style's tones are not fitted. The curve follows that of the
    /// last frame if the eyes do, and style and light are the same.
    pub(super) fn frame(&mut self, recorder: &mut Recorder<'_>, inputs: &TonesInputs<'_>) -> Option<FrameFit> {
        let &TonesInputs { rig, style, light, step_s, land_changes } = inputs;
        if !style.fits_tones() || self.memory.given.is_some() {
            (self.last, self.settles_s) = (None, 0.0);
            return self.memory.frame(recorder, style, Follows { begins: true, step_s });
        }
        // The haze and the focus that an eye sees change while it flies.
        let lit = || Lit {
            tone: style.tone.clone(),
            shading: style.light.clone(),
            relief: style.relief.clone(),
            light: Light { haze_m: 0.0, focus: None, ..*light },
        };
        let continues = self.last.as_ref().is_some_and(|(last, last_lit)| follows(last, rig) && *last_lit == lit());
        let fit = self.memory.frame(recorder, style, Follows { begins: !continues, step_s });
        let moves = rig.eyes.iter().any(|eye| eye.pose != eye.previous || eye.lens != eye.previous_lens);
        self.settles_s = match continues {
            _ if land_changes => ARRIVES_S,
            true if moves => ARRIVES_S,
            true => (self.settles_s - step_s).max(0.0),
            false => 0.0,
        };
        self.last = Some((rig.clone(), lit()));
        fit
    }

    /// Returns the masses of the next frame; `None` if they are not edited.
    pub(super) fn masses(&self, recorder: &mut Recorder<'_>, rig: &Rig, style: &Style) -> Option<FrameMasses> {
        let given = self.given_masses.as_ref().filter(|_| style.edited_masses().is_some());
        given.map(|masses| FrameMasses::Given(masses.upload(recorder))).or_else(|| FrameMasses::of(rig, style))
    }
}

impl super::Renderer {
    /// Sets the curve that fits the tones of the next frames; with `None`, the default, it is measured.
    pub(crate) fn set_tone_curve(&mut self, curve: Option<ToneCurve>) {
        self.tones.memory.given = curve;
    }

    /// Reads the curve that fitted the tones of the last frame; `None` if they were not fitted.
    ///
    /// # Errors
    /// [`GpuError::Readback`].
    pub(crate) fn tone_curve(&self, gpu: &Gpu) -> Result<Option<ToneCurve>, GpuError> {
        self.tones.memory.read(gpu)
    }

    /// Sets the masses of the next frames; with `None`, the default, each eye computes those of what it sees.
    pub(crate) fn set_masses(&mut self, masses: Option<Masses>) {
        self.tones.given_masses = masses;
    }

    /// Reads the masses of the last frame, a whole picture of one eye; `None` if no frame has computed any.
    ///
    /// # Errors
    /// [`GpuError::Readback`].
    pub(crate) fn masses(&self, gpu: &Gpu, picture_px: [u32; 2]) -> Result<Option<Masses>, GpuError> {
        masses::read(gpu, &self.pools.buffers, picture_px)
    }
}
