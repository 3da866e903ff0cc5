//! Temporal anti-aliasing: the picture is the mean of frames that follow each other. See
//! `shaders/composite/temporal_aa.wgsl`.

use crate::gpu::Gpu;
use crate::gpu::bind::Resource;
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind, Targets};
pub(crate) use crate::gpu::wgsl::composite::temporal_aa::TemporalAa as TemporalAaUniform;
use crate::style::Style;

/// What the composite drew, without strokes: one sample of each pixel. Linear colour, and the ink of lines.
pub const SAMPLE: TargetKind = TargetKind::storage("sample", wgpu::TextureFormat::Rgba16Float);
/// The mean so far, of what [`SAMPLE`] holds. Frames take turns.
pub const HISTORY: [TargetKind; 2] = [
    TargetKind::storage("history of even frames", wgpu::TextureFormat::Rgba16Float),
    TargetKind::storage("history of odd frames", wgpu::TextureFormat::Rgba16Float),
];
/// Of the nearest surface within a pixel, log2 of its distance and how many frames count; and the ink of strokes.
pub const SEEN: [TargetKind; 2] = [
    TargetKind::storage("seen in even frames", wgpu::TextureFormat::Rgba16Float),
    TargetKind::storage("seen in odd frames", wgpu::TextureFormat::Rgba16Float),
];

/// When a rest begins, what was drawn on the way counts as so many samples of weight 1.
const BEFORE_REST: f32 = 3.0;
/// Samples of a rest weigh more from one to the next, up to this: the first ones go on from what was drawn on the way
/// without a jump, and in the end hardly anything of that is left.
const MOST_WEIGHT: f32 = 4.0;

/// What a frame makes of those before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Plan {
    /// Its number: even and odd ones take turns.
    pub frame: usize,
    /// There is a frame before, of a view that goes on in this one.
    pub has_history: bool,
    /// How many frames before had the same view of the same world.
    pub frames_at_rest: u32,
}

/// What the pass reads and where it writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// What of the frames before is of use.
    pub plan: Plan,
    /// Grain, and the ink of strokes.
    pub style: &'a Style,
    /// [`SAMPLE`].
    pub sample: &'a Target,
    /// Of the surface.
    pub position: &'a Target,
    /// From the frame before.
    pub motion: &'a Target,
    /// Of strokes, if the style has any.
    pub ink: Option<&'a Target>,
    /// Of the frame before, and of this one.
    pub histories: &'a Histories,
    /// Out: the picture.
    pub picture: &'a Target,
}

/// What an eye keeps of its last two frames.
pub struct Histories {
    before: [Target; 2],
    now: [Target; 2],
}

impl Histories {
    /// Of an eye's pictures.
    pub fn of(gpu: &Gpu, targets: &mut Targets, plan: Plan) -> Self {
        let mut of_frame = |frame: usize| [&HISTORY[frame], &SEEN[frame]].map(|kind| targets.whole(gpu, kind));
        Self { before: of_frame((plan.frame + 1) % 2), now: of_frame(plan.frame % 2) }
    }
}

/// The part of the mean that a frame of a rest is; 0 for one of a flight.
fn rest_weight(frames_at_rest: u32) -> f32 {
    let frames = frames_at_rest as f32;
    let rising = frames.min(MOST_WEIGHT);
    let sum = 0.5 * rising * (rising + 1.0) + MOST_WEIGHT * (frames - rising);
    rising / (BEFORE_REST + sum)
}

/// Adds a frame to the mean, and lays the grain of the paper and the strokes over it.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let uniform = TemporalAaUniform {
        has_history: u32::from(inputs.plan.has_history),
        rest_weight: rest_weight(inputs.plan.frames_at_rest),
        grain: inputs.style.paper.grain,
        stroke_ink: inputs.style.strokes.as_ref().map_or([0.0; 3], |strokes| strokes.ink.linear()),
        frame: (inputs.plan.frame % (1 << 16)) as i32,
        is_bordered: inputs.style.paper.is_bordered().into(),
        paper: inputs.style.paper.color.linear(),
        pad_paper: 0.0,
        border: inputs.style.paper.border.linear(),
        pad_border: 0.0,
        border_px: [inputs.style.paper.margin_px, inputs.style.paper.border_px],
        foot_px: inputs.style.paper.foot_px,
        pad_px: 0.0,
    };
    let Histories { before: [history_before, seen_before], now: [history, seen] } = inputs.histories;
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("temporal_aa", recorder.uniform("temporal aa", &uniform)),
        ("sample_picture", inputs.sample.into()),
        ("position", inputs.position.into()),
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
        assert!(left < 0.015, "of the way: {left}");
        let alike = weights.iter().filter(|weight| (**weight * 64.0 - 1.0).abs() < 0.2).count();
        assert!(alike > 50, "{weights:?}");
        assert!(rest_weight(1) <= 0.25, "a jump");
    }
}
