//! Lines from tone: the scene is shaded, the shading is blurred as wide as lines are, and its valleys, ridges and edges are
//! lines (Lee, Markosian, Lee and Hughes 2007, "Line drawings via abstracted shading").
//!
//! Why: `docs/decisions/tone-lines.md`.

pub mod along;
pub mod blur;
pub mod search;
pub mod tone_image;

use std::convert::Infallible;

use crate::gpu::Gpu;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Cx;
use crate::gpu::target::{Target, TargetKind, Targets};
use crate::style::ToneLines;

/// What lines are found in.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Which lines.
    pub style: &'a ToneLines,
    /// [`TONE_IMAGE`](tone_image::TONE_IMAGE).
    pub tone_image: &'a Target,
}

/// Where the lines of a style lie in the end.
pub fn ink_of(style: &ToneLines) -> &'static TargetKind {
    if style.shortest_px > 0.0 { &along::LONG_INK } else { &search::TONE_INK }
}

/// Finds the lines of a tone image: ink of dark lines and of highlight lines.
pub fn trace(cx: &mut Cx<'_>, inputs: &Inputs<'_>, targets: &mut Targets) -> Target {
    let &Inputs { view, style, tone_image } = inputs;
    let [across, blurred, tone_ink] =
        [&blur::ACROSS, &blur::BLURRED, &search::TONE_INK].map(|kind| targets.whole(cx.gpu(), kind));
    blur::run(cx, &blur::Inputs { view, style, tone_image, across: &across, blurred: &blurred });
    search::run(cx, &search::Inputs { view, style, tone_image, blurred: &blurred, tone_ink: &tone_ink });
    if style.shortest_px <= 0.0 {
        return tone_ink;
    }
    let long_ink = targets.whole(cx.gpu(), &along::LONG_INK);
    along::run(cx, &along::Inputs { view, style, tone_ink: &tone_ink, long_ink: &long_ink });
    long_ink
}

/// Reads pictures between pixels.
struct Bilinear(wgpu::Sampler);

impl Bilinear {
    fn new(gpu: &Gpu) -> Self {
        Self(gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("tone image"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        }))
    }
}

/// The sampler of the passes that read between pixels; made once.
fn bilinear(cx: &mut Cx<'_>) -> Resource {
    let Ok(sampler) = cx.kept(|_: &Bilinear| true, |gpu| Ok::<_, Infallible>(Bilinear::new(gpu)));
    Resource::Sampler(sampler.0.clone())
}
