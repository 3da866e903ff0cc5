//! Water's tint, its shore and its lines. See `shaders/tones/water.wgsl`.
//!
//! Why: `docs/decisions/water.md`.

use super::TONE_FORMAT;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Cx;
use crate::gpu::target::{Target, TargetKind};
use crate::gpu::wgsl::tones::water::WaterLook;
use crate::style::Water;

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
pub fn run(cx: &mut Cx<'_>, inputs: &Inputs<'_>) {
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
        pad: 0.0,
    };
    let resources = [
        ("view", inputs.view.clone()),
        ("water_look", cx.uniform("water look", &look)),
        ("position", inputs.position.into()),
        ("water", inputs.water.into()),
        ("tone", inputs.tone.into()),
        ("watered", inputs.watered.into()),
        ("water_ink", inputs.water_ink.into()),
    ];
    cx.pixels("tones/water", inputs.tone.size_px(), &resources);
}
