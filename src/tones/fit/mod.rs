//! Fits the tones of a style to the picture: the lightest part of the land in view becomes paper, and the darkest part is
//! drawn dark, as a draughtsman spreads the tones of gentle or steep land over the same sheet. Near land becomes lighter.
//!
//! [`measure`] counts the tones of the light on the land in view, and [`follow`] moves the curve toward the one that fits
//! them. All eyes have the curve of the leading one. A picture that is drawn in parts gets its curve from a small picture
//! of the whole ([`crate::picture::tones`]).
//!
//! Why: `docs/decisions/fitted-tones.md`.

pub(crate) mod follow;
pub(crate) mod measure;

use super::Inputs;
use crate::gpu::bind::Named;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;
use crate::gpu::wgsl::shared::tone_counts::WORDS;
use crate::gpu::wgsl::shared::tone_curve::{ToneCurve as ToneCurveUniform, ToneFit};
use crate::gpu::{Gpu, GpuError, readback};
use crate::scene::tone_curve::ToneCurve;
use crate::style::{Style, Tone, Toon};

/// The values that the two tones of a curve get in a smooth tone, from 0 (the darkest tone of the style) to 1 (the
/// lightest). At the second one, marks end.
const DARK: f32 = 0.25;
const PAPER: f32 = 0.97;

/// `ToneFit` is not a uniform, since passes already have three of these (`docs/decisions/software-drivers.md`).
const FIT: BufferKind = BufferKind::storage("tone fit");
const CURVE: BufferKind = BufferKind::storage("tone curve");
const GIVEN: BufferKind = BufferKind::storage("given tone curve");
const COUNTS: BufferKind = BufferKind::storage("tone counts");

/// The curve of a renderer, which persists from frame to frame.
#[derive(Default)]
pub(crate) struct FitMemory {
    /// The curve that the next frames have; `None` if they measure it.
    pub given: Option<ToneCurve>,
    /// The curve of the last frame.
    followed: Option<Buffer>,
    /// Whether the next frame measures its curve without regard to the last one.
    begins: bool,
}

/// The curve of a frame, and how it is found.
#[derive(Clone)]
pub(crate) struct FrameFit {
    pub curve: Buffer,
    /// How the curve follows the picture; `None` if it is given.
    pub follows: Option<Follows>,
}

/// How the curve of a frame continues that of the last frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Follows {
    /// Whether it is the curve that fits the frame, without regard to the last one.
    pub begins: bool,
    /// Time since the last frame, in seconds.
    pub step_s: f64,
}

impl FitMemory {
    /// Lets the next frame measure its curve without regard to the last one.
    pub(crate) fn forget(&mut self) {
        self.begins = true;
    }

    /// Returns the curve of the next frame; `None` if the style's tones are not fitted.
    pub(crate) fn frame(&mut self, recorder: &mut Recorder<'_>, style: &Style, follows: Follows) -> Option<FrameFit> {
        if !style.fits_tones() {
            self.followed = None;
            return None;
        }
        if let Some(curve) = self.given {
            return Some(FrameFit { curve: recorder.upload(&GIVEN, &[uniform_of(curve)]), follows: None });
        }
        let begins = std::mem::take(&mut self.begins) || follows.begins || self.followed.is_none();
        let curve =
            self.followed.get_or_insert_with(|| Buffer::with(recorder.gpu(), &CURVE, &[ToneCurveUniform::default()]));
        Some(FrameFit { curve: curve.clone(), follows: Some(Follows { begins, ..follows }) })
    }

    /// Reads the curve of the last frame; `None` if none has been measured.
    ///
    /// # Errors
    /// [`GpuError::Readback`].
    pub(crate) fn read(&self, gpu: &Gpu) -> Result<Option<ToneCurve>, GpuError> {
        if self.given.is_some() {
            return Ok(self.given);
        }
        let Some(followed) = &self.followed else { return Ok(None) };
        let curves = readback::read_buffer::<ToneCurveUniform>(gpu, &followed.raw, 1)?;
        Ok(curves.first().filter(|curve| curve.is_known != 0.0).map(|curve| ToneCurve {
            dark: curve.dark,
            white: curve.white,
            middle_m: curve.middle_octave.exp2(),
        }))
    }
}

fn uniform_of(curve: ToneCurve) -> ToneCurveUniform {
    let ToneCurve { dark, white, middle_m } = curve;
    ToneCurveUniform { dark, white, middle_octave: middle_m.log2(), is_known: 1.0 }
}

/// Measures the land that the leading eye sees, and moves the curve. `water` is a picture of the water, if there is any.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>, water: Option<&Target>, fit: &FrameFit) {
    let (Some(follows), Tone::Toon(toon)) = (fit.follows, &inputs.style.tone) else { return };
    let counts = recorder.buffer(&COUNTS, u64::from(4 * WORDS));
    recorder.reset_to_zero(&counts);
    measure::run(recorder, inputs, water, &counts);
    follow::run(recorder, toon, inputs.style.has_planes() && toon.steps > 0, follows, &counts, &fit.curve);
}

impl Toon {
    /// Returns the bindings of a tone that is fitted with `curve`.
    pub(super) fn fit_resources(&self, recorder: &mut Recorder<'_>, curve: &Buffer) -> [Named; 2] {
        let fit = self.placed();
        [("tone_curve", curve.binding()), ("tone_fit", recorder.upload(&FIT, &[fit]).binding())]
    }

    /// Returns the values that the two tones of a curve get. In a smooth tone they are near the ends, so that the darkest
    /// and the lightest land keep their form; in a stepped one, the inner ends of the first and the last step.
    fn placed(&self) -> ToneFit {
        let (low, high) = match self.steps {
            0 => (DARK, PAPER),
            // The last step of two begins where the first one ends.
            2 => (0.5, 1.0),
            steps => (1.0 / steps as f32, 1.0 - 1.0 / steps as f32),
        };
        ToneFit { low, high, recede: self.recede, pad: 0.0 }
    }
}
