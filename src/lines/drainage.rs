//! Draws streams or ridge lines. See `shaders/lines/drainage.wgsl`.
//!
//! Why: `docs/decisions/drainage.md`.

use glam::DVec3;

use crate::drainage::DrawnLines;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::pipelines::{Draw, greatest};
use crate::gpu::recorder::{Attachments, Clears, Recorder};
use crate::gpu::target::{Group, Target, TargetKind};
use crate::gpu::wgsl::lines::drainage::DrainageRules;
use crate::style::Drainage;

/// 16 bits because it is blended, which not every GPU supports for 32-bit floats.
const INK_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R16Float;

/// Amount of ink: 0 none, 1 full.
pub(crate) const DRAINAGE_INK: TargetKind =
    TargetKind::attachment("drainage ink", INK_FORMAT, Group::Ink.shows("Ink of streams or ridge lines"));

const STRIPS: Draw =
    Draw { colors: [greatest(INK_FORMAT), None, None, None, None], ..Draw::triangles("lines/drainage") };

/// Distance by which a line may be behind the visible land, in distances of samples: between two points a line is
/// straight, and the land is not.
const BEHIND_SAMPLES: f32 = 0.5;

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The uniform of the terrain.
    pub terrain: Named,
    pub style: &'a Drainage,
    /// `None` until lines have been computed.
    pub lines: Option<&'a DrawnLines>,
    /// The rig's origin in the world.
    pub origin_m: DVec3,
    pub distance: &'a Target,
    /// [`WATER`](crate::surface::water::WATER), or a single texel in a style without water.
    pub water: &'a Target,
    /// [`DRAINAGE_INK`].
    pub ink: &'a Target,
}

/// Draws the lines on a cleared target.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let style = inputs.style;
    let origin_m = inputs.lines.map_or(DVec3::ZERO, |lines| lines.origin_m - inputs.origin_m);
    let rules = DrainageRules {
        origin_m: origin_m.as_vec3().to_array(),
        line_px: style.line_px,
        widest_px: style.widest_px.max(style.line_px),
        spacing_px: style.spacing_px,
        min_relief: style.gentlest_deg.to_radians().tan(),
        behind_m: inputs.lines.map_or(0.0, |lines| BEHIND_SAMPLES * lines.sample_m),
    };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("rules", recorder.uniform("drainage rules", &rules)),
        ("distance_m", inputs.distance.into()),
        ("water", inputs.water.into()),
        inputs.terrain.clone(),
    ];
    resources.extend(inputs.lines.map(|lines| ("points", lines.points.binding())));
    let segments = inputs.lines.map_or(0, |lines| lines.count.saturating_sub(1));
    let on = Attachments { colors: &[inputs.ink], depth: None, clears: Clears::All };
    if inputs.lines.is_none() && !recorder.prewarms() {
        recorder.render(STRIPS.name, &[], on, |_| {});
        return;
    }
    let drawing = recorder.drawing(&STRIPS, &resources);
    recorder.render(STRIPS.name, &[&drawing], on, |pass| {
        drawing.set(pass);
        pass.draw(0..6, 0..segments);
    });
}
