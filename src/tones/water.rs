//! Water's tint, its shore and its lines. See `shaders/tones/water.wgsl`.
//!
//! Why: `docs/decisions/water.md`.

use super::TONE_FORMAT;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};
use crate::gpu::wgsl::tones::water::WaterLook;
use crate::style::{Sky, Water};

/// Colour and tone, with those of water.
pub const WATERED: TargetKind = TargetKind::storage("watered", TONE_FORMAT);
/// Ink of shores and water lines: 0 none, 1 full.
pub const WATER_INK: TargetKind = TargetKind::storage("water ink", wgpu::TextureFormat::R32Float);

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// How water looks.
    pub style: &'a Water,
    /// What is mirrored where no land is.
    pub sky: &'a Sky,
    /// For the earth's curvature.
    pub terrain: &'a Named,
    /// Of the surface.
    pub position: &'a Target,
    /// [`WATER`](crate::surface::water::WATER).
    pub water: &'a Target,
    /// Colours and tones of the land.
    pub tone: &'a Target,
    /// Out: the same with water.
    pub watered: &'a Target,
    /// Out.
    pub water_ink: &'a Target,
}

/// Draws the water that the inputs show.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let style = inputs.style;
    let look = WaterLook {
        tint: style.tint.linear(),
        shore_px: style.shore_px,
        line_px: style.line_px,
        spacing_px: style.spacing_px,
        growth: style.growth,
        paler: style.paler,
        lines: style.lines,
        rules: style.rules.into(),
        reach_px: style.reach_px(),
        mirror: style.mirror,
        strokes: u32::from(style.rules || style.lines > 0),
        sky_horizon: inputs.sky.horizon.linear(),
        sky_zenith: inputs.sky.zenith.linear(),
        ..WaterLook::default()
    };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("water_look", recorder.uniform("water look", &look)),
        ("position", inputs.position.into()),
        ("water", inputs.water.into()),
        ("tone", inputs.tone.into()),
        ("watered", inputs.watered.into()),
        ("water_ink", inputs.water_ink.into()),
    ];
    let mirrors = style.mirror > 0.0;
    resources.extend(mirrors.then(|| inputs.terrain.clone()));
    let definitions: &[&str] = if mirrors { &["MIRROR"] } else { &[] };
    recorder.pixels(Compute { name: "tones/water", definitions }, inputs.tone.size_px(), &resources);
}
