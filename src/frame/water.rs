//! The water of an eye: where it is, its colours and its ink.

use super::FrameInputs;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, Targets};
use crate::surface::water::{self, WATER};
use crate::tones::water::{self as look, WATER_INK, WATERED};

/// The pictures of an eye that water is drawn from.
pub(super) struct EyeInputs<'a> {
    pub(super) view: &'a Resource,
    pub(super) distance: &'a Target,
    /// [`WATER`], in a style with water.
    pub(super) water: Option<&'a Target>,
    /// Colour and tone of the land.
    pub(super) tone: &'a Target,
}

/// The pictures with water.
pub(super) struct Watered {
    /// Colour and tone of land and water.
    pub(super) tone: Target,
    /// Ink of shorelines and water lines.
    pub(super) ink: Target,
}

/// Computes the distance to the shore on the visible water. Returns `None` in a style without water, and if the view is
/// known to have none.
pub(super) fn find(
    recorder: &mut Recorder<'_>,
    inputs: &FrameInputs<'_>,
    view: &Resource,
    [surface_id, distance]: [&Target; 2],
    targets: &mut Targets,
) -> Option<Target> {
    let style = inputs.style.water().filter(|_| !inputs.is_dry)?;
    let terrain = &inputs.world.terrain;
    // A prewarming run binds nothing, so it needs no maps.
    let terrain = &terrain.water_map_resources().or_else(|| recorder.prewarms().then(|| terrain.resources()))?;
    let water = targets.whole(recorder.gpu(), &WATER);
    water::run(recorder, &water::Inputs { view, terrain, style, surface_id, distance, water: &water });
    Some(water)
}

/// Draws the tint and the lines of water. Returns `None` if there is no picture of water.
pub(super) fn draw(
    recorder: &mut Recorder<'_>,
    inputs: &FrameInputs<'_>,
    eye: &EyeInputs<'_>,
    targets: &mut Targets,
) -> Option<Watered> {
    let style = inputs.style.water()?;
    let &EyeInputs { view, distance, water, tone } = eye;
    let water = water?;
    let [watered, ink] = [&WATERED, &WATER_INK].map(|kind| targets.whole(recorder.gpu(), kind));
    let drawn = look::Inputs {
        view,
        style,
        sky: &inputs.style.sky,
        terrain: &inputs.world.terrain.uniform(),
        distance,
        water,
        tone,
        watered: &watered,
        water_ink: &ink,
    };
    look::run(recorder, &drawn);
    Some(Watered { tone: watered, ink })
}
