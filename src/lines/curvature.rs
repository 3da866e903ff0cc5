//! Lines from curvature: contours (silhouettes) and suggestive contours, computed per pixel. See
//! `shaders/lines/curvature.wgsl`.
//!
//! Why: `docs/decisions/curvature.md`.

use glam::DVec3;

use crate::gpu::bind::Resource;
use crate::gpu::buffer::BufferKind;
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};
use crate::gpu::wgsl::lines::curvature::{AXES, CurvatureLines};
use crate::lines::strokes::texture::{REPEATS_PX, StrokeTexture};
use crate::style::Curvature;
use crate::surface::ladder::{self, compass};

/// Position of the origin on each axis and level: the coordinates along lines.
const LINE_PHASES: BufferKind = BufferKind::storage("line phases");

/// Ink of the lines: 0 is none, 1 is full.
pub(crate) const CURVATURE_LINE: TargetKind = TargetKind::storage(
    "curvature line",
    wgpu::TextureFormat::R32Float,
    Group::Lines.shows("Lines that are found by the curvature of the land"),
);

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The section `[curvature]` of the style.
    pub settings: &'a Curvature,
    /// The rig's origin in the world, to which positions are relative.
    pub origin_m: DVec3,
    /// Surface ids, to leave out trees, which have no curvature.
    pub surface_id: &'a Target,
    pub distance: &'a Target,
    pub normal: &'a Target,
    /// The curvature toward the eye and its derivative ([`super::radial::RADIAL`]).
    pub radial: &'a Target,
    /// Lines of trees, from another detector; without trees [`crate::composite::NOTHING`].
    pub tree_line: &'a Target,
    /// The output, of kind [`CURVATURE_LINE`].
    pub line: &'a Target,
}

/// Writes the contours and suggestive contours of the land, and the lines of trees, to `line`.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let settings = inputs.settings;
    let texture = settings.texture.as_ref().and_then(|recipe| StrokeTexture::of(recorder, recipe));
    // A tile has a power of two as its length, and that of a picture is rounded, so whole tiles fit.
    let repeats_px = settings.texture.as_ref().map_or(REPEATS_PX, |recipe| REPEATS_PX.max(recipe.tile.along_px as f32));
    let lines = CurvatureLines {
        width_px: settings.width_px,
        suggestive_px: settings.width_px * settings.suggestive,
        min_rise: settings.rise,
        largest_cosine: settings.facing_deg.to_radians().cos(),
        taper: settings.taper,
        warp_px: settings.warp_px,
        // A whole number of waves fits where the coordinates begin again.
        warp_length_px: repeats_px / (repeats_px / settings.warp_length_px).round().max(1.0),
        level_count: ladder::LEVELS as i32,
        first_level: ladder::FIRST_LEVEL,
    };
    let phases = if settings.texture.is_some() || settings.warp_px > 0.0 {
        let axes: Vec<DVec3> = compass(AXES as usize).map(|to| to.extend(0.0)).chain([DVec3::Z]).collect();
        ladder::phases(&axes, inputs.origin_m, repeats_px.into())
    } else {
        vec![0.0]
    };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("curvature_lines", recorder.uniform("curvature lines", &lines)),
        ("surface_id", inputs.surface_id.into()),
        ("distance_m", inputs.distance.into()),
        ("normal", inputs.normal.into()),
        ("radial", inputs.radial.into()),
        ("tree_line", inputs.tree_line.into()),
        ("line", inputs.line.into()),
        ("line_phases", recorder.upload(&LINE_PHASES, &phases).binding()),
    ];
    // A texture may be growing still, while the pipeline can be compiled.
    let is_prewarmed = recorder.prewarms() && settings.texture.is_some();
    let definitions: &[&str] = if texture.is_some() || is_prewarmed { &["TEXTURED"] } else { &[] };
    resources.extend(texture.iter().flat_map(|texture| texture.resources()));
    recorder.pixels(Compute { name: "lines/curvature", definitions }, inputs.line.size_px(), &resources);
}
