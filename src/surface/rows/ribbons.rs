//! Draws the marks of rows, each as a strip of triangles. See `shaders/surface/rows/ribbons.wgsl`.

use super::RowPlan;
use super::marks::Marks;
use crate::gpu::bind::Resource;
use crate::gpu::pipelines::{Draw, greatest};
use crate::gpu::recorder::{Attachments, Clears, Recorder};
use crate::gpu::target::{Group, Target, TargetKind};
use crate::gpu::wgsl::surface::rows::ribbons::{BEHIND, BEHIND_PART};

/// A format of 16 bits, because it is blended, which not every GPU supports for 32-bit floats.
const INK_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R16Float;
/// Ink of the rows, 0 to 1.
pub(crate) const ROW_INK: TargetKind =
    TargetKind::attachment("row ink", INK_FORMAT, Group::Ink.shows("Ink of rows of hachures"));

const KIND: Draw = Draw {
    colors: [greatest(INK_FORMAT), None, None, None, None],
    topology: wgpu::PrimitiveTopology::TriangleStrip,
    ..Draw::triangles("surface/rows/ribbons")
};

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The plan, for its rules uniform.
    pub plan: &'a RowPlan,
    /// The marks to draw.
    pub marks: &'a Marks,
    /// Position of the visible surface.
    pub distance: &'a Target,
    /// Surface ids, which separate the land from the objects on it.
    pub surface_id: &'a Target,
    pub ink: &'a Target,
}

/// Draws the marks into the cleared target.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let resources = [
        ("view", inputs.view.clone()),
        ("rules", recorder.uniform("row rules", &inputs.plan.rules)),
        ("marks", inputs.marks.samples.binding()),
        ("distance_m", inputs.distance.into()),
        ("surface_id", inputs.surface_id.into()),
    ];
    let drawing = recorder.drawing(&KIND, &resources);
    let on = Attachments { colors: &[inputs.ink], depth: None, clears: Clears::All };
    recorder.render(KIND.name, &[&drawing], on, |pass| {
        drawing.set(pass);
        pass.draw_indirect(&inputs.marks.drawn.raw, 0);
    });
}

/// Returns how far away a mark may be, along the view axis, to be visible on land at `land_m`, as in the shader.
/// `spacing` is the spacing of marks as a fraction of the distance.
pub(crate) fn allowed_m(land_m: f32, spacing: f32) -> f32 {
    land_m * (1.0 + BEHIND_PART) + BEHIND * spacing * land_m
}
