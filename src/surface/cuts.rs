//! Cut lines on the visible land. See `shaders/surface/cuts.wgsl`.
//!
//! Why: `docs/decisions/cuts.md`.

use glam::DVec3;

use crate::gpu::bind::{Named, Resource};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};
use crate::gpu::wgsl::surface::cuts::{CutLayer, CutRules};
use crate::style::Cuts;

/// Ink of the families of planes, one family per channel, 0 to 1.
pub const CUT_INK: TargetKind = TargetKind::storage("cut ink", wgpu::TextureFormat::Rgba16Float);

/// Period to which heights above a plane are reduced, in metres: a multiple of every smaller power of two, so a plane
/// of every spacing, and small enough for an f32 to keep millimetres.
const PERIOD_M: f64 = (1_u32 << 13) as f64;

/// Inputs and output of the pass.
pub struct Inputs<'a> {
    pub view: &'a Resource,
    /// Bindings of the terrain: height atlas and page table.
    pub terrain: &'a [Named],
    /// The families of planes and their lines.
    pub style: &'a Cuts,
    /// The rig's origin in the world, to which positions on the GPU are relative.
    pub origin_m: DVec3,
    /// Surface ids, which separate the land from the objects on it.
    pub surface_id: &'a Target,
    pub position: &'a Target,
    /// The requested tone.
    pub tone: &'a Target,
    /// [`CUT_INK`].
    pub cut_ink: &'a Target,
}

/// Draws the cut lines.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let style = inputs.style;
    let mut rules = CutRules {
        form_px: style.form_px,
        darkest: style.darkest,
        count: style.layers.len() as u32,
        ..CutRules::default()
    };
    for (drawn, layer) in rules.layers.iter_mut().zip(&style.layers) {
        let (sin_tilt, cos_tilt) = f64::from(layer.tilt_deg).to_radians().sin_cos();
        let (east, north) = f64::from(layer.azimuth_deg).to_radians().sin_cos();
        // The planes rise toward the azimuth, so their normals point away from it.
        let normal = DVec3::new(-sin_tilt * east, -sin_tilt * north, cos_tilt);
        *drawn = CutLayer {
            normal: normal.as_vec3().to_array(),
            phase_m: normal.dot(inputs.origin_m).rem_euclid(PERIOD_M) as f32,
            spacing_px: layer.spacing_px,
            level: layer.level_deg.to_radians().sin(),
            darkness_from: layer.from,
            ..CutLayer::default()
        };
    }
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("cut_rules", recorder.uniform("cut rules", &rules)),
        ("surface_id", inputs.surface_id.into()),
        ("position", inputs.position.into()),
        ("tone", inputs.tone.into()),
        ("cut_ink", inputs.cut_ink.into()),
    ];
    resources.extend(inputs.terrain.iter().cloned());
    recorder.pixels("surface/cuts", inputs.cut_ink.size_px(), &resources);
}
