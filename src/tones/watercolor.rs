//! Watercolour: washes that run and settle. See `shaders/tones/watercolor.wgsl`.

use glam::DVec3;

use super::TONE_FORMAT;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};
pub(crate) use crate::gpu::wgsl::shared::wobble::Anchor;
pub(crate) use crate::gpu::wgsl::tones::watercolor::Watercolor as WatercolorUniform;
use crate::style::Watercolor;

/// Side of a block, in metres; `shaders/shared/wobble.wgsl` gives the reason.
const BLOCK_M: f64 = 4096.0;

impl Anchor {
    fn new(camera_m: DVec3) -> Self {
        let blocks = (camera_m / BLOCK_M).floor();
        let rest_m = (camera_m - blocks * BLOCK_M).as_vec3().to_array();
        Self { blocks: blocks.as_ivec3().to_array(), pad_a: 0, rest_m, pad_b: 0 }
    }
}

/// Colour after the washes have run, and the requested tone.
pub(crate) const WASHED: TargetKind = TargetKind::storage(
    "washed",
    TONE_FORMAT,
    Group::Tones.shows("Colour of the tones after washes of watercolour have run"),
);

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The style's watercolour settings.
    pub watercolor: &'a Watercolor,
    /// The rig's origin in the world, to which positions are relative.
    pub origin_m: DVec3,
    pub distance: &'a Target,
    /// Colour and tone before the washes run.
    pub tone: &'a Target,
    pub washed: &'a Target,
}

/// Applies the washes to the visible surface.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let &Watercolor { edge, edge_px, granulation, flow, warp_px } = inputs.watercolor;
    let [pad_a, pad_b, pad_c] = [0.0; 3];
    let uniform = WatercolorUniform { edge, edge_px, granulation, flow, warp_px, pad_a, pad_b, pad_c };
    let resources = [
        ("view", inputs.view.clone()),
        ("watercolor", recorder.uniform("watercolor", &uniform)),
        ("anchor", recorder.uniform("anchor", &Anchor::new(inputs.origin_m))),
        ("distance_m", inputs.distance.into()),
        ("tone", inputs.tone.into()),
        ("washed", inputs.washed.into()),
    ];
    recorder.pixels("tones/watercolor", inputs.washed.size_px(), &resources);
}
