//! Maps of tiles of the land that are computed once and reused by all eyes and later frames.

use super::FrameInputs;
use crate::gpu::recorder::Recorder;
use crate::surface::{lakes, land, rows};

/// Computes the planned horizon maps, water maps and blocks of hachures that the style needs.
pub(super) fn make(recorder: &mut Recorder<'_>, inputs: &FrameInputs<'_>) {
    let (terrain, style) = (&inputs.world.terrain, inputs.style);
    let heights = &terrain.resources();
    match terrain.horizon_maps() {
        Some(tiles) if style.needs_horizons() => land::horizons::run(recorder, heights, tiles),
        None if style.needs_horizons() && recorder.prewarms() => land::horizons::prewarm(recorder),
        _ => {}
    }
    if let Some(tiles) = terrain.water_maps().filter(|_| style.water().is_some()) {
        lakes::make(recorder, heights, tiles, inputs.world.given_water());
    }
    if let Some(plan) = inputs.rows {
        rows::make(recorder, plan, heights);
    }
}
