//! Temporal anti-aliasing: the picture is the mean of successive frames. See `shaders/composite/temporal_aa.wgsl`.

use crate::gpu::Gpu;
use crate::gpu::bind::Resource;
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind, Targets};
pub(crate) use crate::gpu::wgsl::composite::temporal_aa::TemporalAa as TemporalAaUniform;
use crate::style::Style;

/// One sample of each pixel, as composited without strokes. rgb: linear colour; a: the ink of lines.
pub(crate) const SAMPLE: TargetKind = TargetKind::storage(
    "sample",
    wgpu::TextureFormat::Rgba16Float,
    Group::Whole.shows("One sample of each pixel of the picture, without strokes"),
);
/// The running mean of [`SAMPLE`]. Even and odd frames alternate between the two targets.
pub(crate) const HISTORY: [TargetKind; 2] = [
    TargetKind::storage(
        "history of even frames",
        wgpu::TextureFormat::Rgba16Float,
        Group::Whole.shows("Mean of the samples of each pixel, in even frames"),
    ),
    TargetKind::storage(
        "history of odd frames",
        wgpu::TextureFormat::Rgba16Float,
        Group::Whole.shows("Mean of the samples of each pixel, in odd frames"),
    ),
];
/// Log2 of the distance of the nearest surface within a pixel, the number of frames that count, and the ink of strokes.
pub(crate) const SEEN: [TargetKind; 2] = [
    TargetKind::storage(
        "seen in even frames",
        wgpu::TextureFormat::Rgba16Float,
        Group::Whole.shows("Distance of each pixel, and how many samples count, in even frames"),
    ),
    TargetKind::storage(
        "seen in odd frames",
        wgpu::TextureFormat::Rgba16Float,
        Group::Whole.shows("Distance of each pixel, and how many samples count, in odd frames"),
    ),
];

/// Weight of the mean so far when the camera comes to rest, in samples of weight 1.
const BEFORE_REST: f32 = 3.0;
/// The weight of samples at rest rises from one to the next, up to this: the first ones continue the mean of the motion
/// without a jump, and in the end hardly anything of it is left.
const MAX_WEIGHT: f32 = 4.0;

/// Part of a difference between history and the neighbourhood in this frame that is retained on the same surface.
const KEPT: f32 = 0.85;

/// A frame's use of the previous frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Plan {
    /// Frame number: even and odd frames alternate between targets.
    pub frame: usize,
    /// Whether there is a previous frame, whose view continues in this one.
    pub has_history: bool,
    /// Size of the previous frame's pictures, in pixels.
    pub history_px: [u32; 2],
    /// Number of previous frames with the same view of the same world.
    pub frames_at_rest: u32,
    /// Whether a value of the style has changed since the previous frame. Then the colours of the previous frame are
    /// clamped to those that this frame has around a pixel.
    pub is_edited: bool,
}

/// Inputs and outputs of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// How the frame uses the previous frames.
    pub plan: Plan,
    /// The style, for the grain and the ink of strokes.
    pub style: &'a Style,
    pub sample: &'a Target,
    pub distance: &'a Target,
    /// Motion from the previous frame.
    pub motion: &'a Target,
    /// Ink of strokes, if the style has any.
    pub ink: Option<&'a Target>,
    /// Histories of the previous frame and of this one.
    pub histories: &'a Histories,
    pub picture: &'a Target,
}

/// The mean and the seen surfaces of an eye's last two frames.
pub(crate) struct Histories {
    before: [Target; 2],
    now: [Target; 2],
}

impl Histories {
    /// Allocates the histories of an eye.
    pub(crate) fn of(gpu: &Gpu, targets: &mut Targets, plan: Plan) -> Self {
        let mut of_frame = |frame: usize| [&HISTORY[frame], &SEEN[frame]].map(|kind| targets.whole(gpu, kind));
        Self { before: of_frame((plan.frame + 1) % 2), now: of_frame(plan.frame % 2) }
    }
}

/// Returns the weight of a frame at rest in the mean; 0 for a frame in motion.
fn rest_weight(frames_at_rest: u32) -> f32 {
    let frames = frames_at_rest as f32;
    let rising = frames.min(MAX_WEIGHT);
    let sum = 0.5 * rising * (rising + 1.0) + MAX_WEIGHT * (frames - rising);
    rising / (BEFORE_REST + sum)
}

/// Adds a frame to the mean, and draws the strokes and the grain of the paper over it.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let uniform = TemporalAaUniform {
        has_history: u32::from(inputs.plan.has_history),
        rest_weight: rest_weight(inputs.plan.frames_at_rest),
        grain: inputs.style.paper.grain,
        stroke_ink: inputs.style.strokes().map_or([0.0; 3], |strokes| strokes.ink.linear()),
        frame: (inputs.plan.frame % (1 << 16)) as i32,
        is_bordered: inputs.style.paper.is_bordered().into(),
        paper: inputs.style.paper.color.linear(),
        kept: if inputs.plan.is_edited { 0.0 } else { KEPT },
        border: inputs.style.paper.border.linear(),
        pad_border: 0.0,
        border_px: [inputs.style.paper.margin_px, inputs.style.paper.border_px],
        foot_px: inputs.style.paper.foot_px,
        pad_px: 0.0,
        history_px: inputs.plan.history_px.map(|side| side as f32),
        pad_history: [0.0; 2],
    };
    let Histories { before: [history_before, seen_before], now: [history, seen] } = inputs.histories;
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("temporal_aa", recorder.uniform("temporal aa", &uniform)),
        ("sample_picture", inputs.sample.into()),
        ("distance_m", inputs.distance.into()),
        ("motion", inputs.motion.into()),
        ("history_before", history_before.into()),
        ("seen_before", seen_before.into()),
        ("history", history.into()),
        ("seen", seen.into()),
        ("picture", inputs.picture.into()),
    ];
    let definitions: &[&str] = if inputs.ink.is_some() { &["STROKES"] } else { &[] };
    resources.extend(inputs.ink.map(|ink| ("ink", ink.into())));
    recorder.pixels(Compute { name: "composite/temporal_aa", definitions }, inputs.picture.size_px(), &resources);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rest_forgets_the_way_and_counts_its_samples_alike() {
        assert!(rest_weight(0) == 0.0);
        // Weights of the samples in the end.
        let mut left = 1.0;
        let mut weights = Vec::new();
        for frame in (1..=64).rev() {
            weights.push(left * rest_weight(frame));
            left *= 1.0 - rest_weight(frame);
        }
        assert!(left < 0.015, "weight of the motion: {left}");
        let alike = weights.iter().filter(|weight| (**weight * 64.0 - 1.0).abs() < 0.2).count();
        assert!(alike > 50, "{weights:?}");
        assert!(rest_weight(1) <= 0.25, "a jump");
    }
}
