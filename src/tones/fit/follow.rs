//! Moves the curve of the tones toward the one that fits the picture. See `shaders/tones/fit/follow.wgsl`.

use super::Follows;
use crate::gpu::buffer::Buffer;
use crate::gpu::recorder::Recorder;
use crate::gpu::wgsl::tones::fit::follow::Follow;
use crate::style::Toon;

/// Time in which the curve goes 63 % of the way, in seconds.
const SETTLES_S: f64 = 1.2;
/// Largest change of a tone in a frame, and in a second.
const MOST_IN_FRAME: f64 = 0.012;
const MOST_PER_S: f64 = 0.3;
/// Largest change of the middle distance in a frame, and in a second, in octaves: a tone changes by 0.006 at most, because
/// land loses a third of its darkness within 1.75 octaves.
const MOST_OCTAVES_IN_FRAME: f64 = 0.02;
const MOST_OCTAVES_PER_S: f64 = 0.6;
/// The light is spread by no more than this factor: in flat land, differences that nobody sees would become tones.
const MOST_SPREAD: f32 = 2.5;

/// How far shares may be from those of the style where slopes are drawn as planes.
const GIVE: f32 = 0.12;

/// Moves `curve` by the `counts` of the frame.
pub(super) fn run(
    recorder: &mut Recorder<'_>,
    toon: &Toon,
    planes: bool,
    follows: Follows,
    counts: &Buffer,
    curve: &Buffer,
) {
    let Follows { begins, step_s } = follows;
    let placed = toon.placed();
    let within = |in_frame: f64, per_s: f64| in_frame.min(per_s * step_s) as f32;
    let follow = Follow {
        dark_share: toon.dark_share,
        white_share: toon.white_share,
        least_span: (placed.high - placed.low) / MOST_SPREAD,
        part: (1.0 - (-step_s / SETTLES_S).exp()) as f32,
        most: within(MOST_IN_FRAME, MOST_PER_S),
        most_octaves: within(MOST_OCTAVES_IN_FRAME, MOST_OCTAVES_PER_S),
        begins: u32::from(begins),
        give: if planes { GIVE } else { 0.0 },
    };
    let resources = [
        ("follow", recorder.uniform("follow", &follow)),
        ("tone_counts", counts.binding()),
        ("tone_curve", curve.binding()),
    ];
    recorder.groups("tones/fit/follow", [1, 1], &resources);
}
