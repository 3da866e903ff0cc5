//! Lines from curvature: contours and suggestive contours, computed per pixel. See `shaders/lines/curvature.wgsl`.
//!
//! Why: `docs/decisions/curvature.md`.

use crate::gpu::bind::Resource;
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};
use crate::gpu::wgsl::lines::curvature::CurvatureLines;
use crate::lines::strokes::texture::StrokeTexture;
use crate::style::Curvature;

/// Line strength: 0 no line, 1 full.
pub(crate) const CURVATURE_LINE: TargetKind = TargetKind::storage("curvature line", wgpu::TextureFormat::R32Float);

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    pub style: &'a Curvature,
    /// Surface ids: trees have no curvature.
    pub surface_id: &'a Target,
    pub position: &'a Target,
    pub normal: &'a Target,
    pub radial: &'a Target,
    /// Lines of trees, or a 1 × 1 picture that holds zero.
    pub tree_line: &'a Target,
    pub line: &'a Target,
}

/// Draws the lines.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let style = inputs.style;
    let lines = CurvatureLines {
        width_px: style.width_px,
        suggestive_px: style.width_px * style.suggestive,
        least_rise: style.rise,
        most_facing: style.facing_deg.to_radians().cos(),
        taper: style.taper,
        warp_px: style.warp_px,
        warp_length_px: style.warp_length_px,
    };
    let texture = style.texture.as_ref().and_then(|recipe| StrokeTexture::of(recorder, recipe));
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("curvature_lines", recorder.uniform("curvature lines", &lines)),
        ("surface_id", inputs.surface_id.into()),
        ("position", inputs.position.into()),
        ("normal", inputs.normal.into()),
        ("radial", inputs.radial.into()),
        ("tree_line", inputs.tree_line.into()),
        ("line", inputs.line.into()),
    ];
    let definitions: &[&str] = if texture.is_some() { &["TEXTURED"] } else { &[] };
    resources.extend(texture.iter().flat_map(|texture| texture.resources()));
    recorder.pixels(Compute { name: "lines/curvature", definitions }, inputs.line.size_px(), &resources);
}
