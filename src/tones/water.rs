//! The tint of water, its shoreline and its water lines. See `shaders/tones/water.wgsl`.
//!
//! Why: `docs/decisions/water.md`.

use super::TONE_FORMAT;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};
use crate::gpu::wgsl::tones::water::WaterLook;
use crate::style::{Sky, Water};

/// [`TONE`](super::TONE) with water.
pub(crate) const WATERED: TargetKind =
    TargetKind::storage("watered", TONE_FORMAT, Group::Tones.shows("Colour of the tones with the tint of water"));
/// Ink of shorelines and water lines: 0 none, 1 full.
pub(crate) const WATER_INK: TargetKind = TargetKind::storage(
    "water ink",
    wgpu::TextureFormat::R32Float,
    Group::Ink.shows("Ink of shorelines and water lines"),
);

/// Inputs and outputs of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The style of water.
    pub style: &'a Water,
    /// The sky, which is mirrored where no land is.
    pub sky: &'a Sky,
    /// The `Terrain` uniform, for the earth's curvature.
    pub terrain: &'a Named,
    pub distance: &'a Target,
    pub water: &'a Target,
    /// Colour and tone of the land.
    pub tone: &'a Target,
    /// The output: colour and tone with water.
    pub watered: &'a Target,
    pub water_ink: &'a Target,
}

/// Draws the visible water.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
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
        deep_px: style.deep_px,
        deep: style.deep.linear(),
        sky_horizon: inputs.sky.horizon.linear(),
        sky_zenith: inputs.sky.zenith.linear(),
        ..WaterLook::default()
    };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("water_look", recorder.uniform("water look", &look)),
        ("distance_m", inputs.distance.into()),
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
