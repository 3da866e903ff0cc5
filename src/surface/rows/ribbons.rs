//! Draws marks. See `shaders/surface/rows/ribbons.wgsl`.

use super::RowPlan;
use super::marks::Marks;
use crate::gpu::bind::Resource;
use crate::gpu::pipelines::Draw;
use crate::gpu::recorder::{Attachments, Clears, Recorder};
use crate::gpu::target::{Target, TargetKind};
use crate::gpu::wgsl::surface::rows::ribbons::{BEHIND, BEHIND_PART};

/// It is blended, which 32 bits are not everywhere.
const INK_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R16Float;
/// Ink of rows: 0 none, 1 full.
pub const ROW_INK: TargetKind = TargetKind::attachment("row ink", INK_FORMAT);

/// Ink over ink would depend on the order of marks, which is chance.
const DARKER: wgpu::BlendComponent = wgpu::BlendComponent {
    src_factor: wgpu::BlendFactor::One,
    dst_factor: wgpu::BlendFactor::One,
    operation: wgpu::BlendOperation::Max,
};
const KIND: Draw = Draw {
    name: "surface/rows/ribbons",
    definitions: &[],
    fragment: "fragment",
    colors: [
        Some(wgpu::ColorTargetState {
            format: INK_FORMAT,
            blend: Some(wgpu::BlendState { color: DARKER, alpha: DARKER }),
            write_mask: wgpu::ColorWrites::ALL,
        }),
        None,
        None,
        None,
        None,
    ],
    depth: None,
    writes_depth: false,
    topology: wgpu::PrimitiveTopology::TriangleStrip,
};

/// What the pass reads and where it writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// How marks are drawn.
    pub plan: &'a RowPlan,
    /// What is drawn.
    pub marks: &'a Marks,
    /// Of what is seen.
    pub position: &'a Target,
    /// Tells the land from what stands on it.
    pub surface_id: &'a Target,
    /// [`ROW_INK`].
    pub ink: &'a Target,
}

/// Draws marks into the picture, which begins empty.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let resources = [
        ("view", inputs.view.clone()),
        ("rules", recorder.uniform("row rules", &inputs.plan.rules)),
        ("marks", inputs.marks.samples.binding()),
        ("position", inputs.position.into()),
        ("surface_id", inputs.surface_id.into()),
    ];
    let drawing = recorder.drawing(&KIND, &resources);
    let on = Attachments { colors: &[inputs.ink], depth: None, clears: Clears::All };
    recorder.render(KIND.name, &[&drawing], on, |pass| {
        drawing.set(pass);
        pass.draw_indirect(&inputs.marks.drawn.raw, 0);
    });
}

/// How far away a mark may be along the view axis that is seen on land so far away, as in the shader. `spacing` is that of
/// marks, by the distance.
pub fn allowed_m(land_m: f32, spacing: f32) -> f32 {
    land_m * (1.0 + BEHIND_PART) + BEHIND * spacing * land_m
}
