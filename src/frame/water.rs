//! The water of an eye: where it is, and what it looks like.

use super::FrameInputs;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, Targets};
use crate::surface::water::{self, WATER};
use crate::tones::water::{self as look, WATER_INK, WATERED};

/// What an eye sees.
pub(super) struct AtEye<'a> {
    /// `View`.
    pub(super) view: &'a Resource,
    pub(super) position: &'a Target,
    /// Of a style with water.
    pub(super) water: Option<&'a Target>,
    /// Of the land.
    pub(super) tone: &'a Target,
}

/// Tones with water, and ink of its shores and lines.
pub(super) struct Watered {
    pub(super) tone: Target,
    pub(super) ink: Target,
}

/// Where an eye sees water; none in a style without.
pub(super) fn find(
    recorder: &mut Recorder<'_>,
    inputs: &FrameInputs<'_>,
    view: &Resource,
    [surface_id, position]: [&Target; 2],
    targets: &mut Targets,
) -> Option<Target> {
    let style = inputs.style.water()?;
    let terrain = &inputs.world.terrain.water_map_resources()?;
    let water = targets.whole(recorder.gpu(), &WATER);
    water::run(recorder, &water::Inputs { view, terrain, style, surface_id, position, water: &water });
    Some(water)
}

/// None in a style without water.
pub(super) fn draw(
    recorder: &mut Recorder<'_>,
    inputs: &FrameInputs<'_>,
    eye: &AtEye<'_>,
    targets: &mut Targets,
) -> Option<Watered> {
    let style = inputs.style.water()?;
    let &AtEye { view, position, water, tone } = eye;
    let water = water?;
    let [watered, ink] = [&WATERED, &WATER_INK].map(|kind| targets.whole(recorder.gpu(), kind));
    let drawn = look::Inputs {
        view,
        style,
        sky: &inputs.style.sky,
        terrain: &inputs.world.terrain.uniform(),
        position,
        water,
        tone,
        watered: &watered,
        water_ink: &ink,
    };
    look::run(recorder, &drawn);
    Some(Watered { tone: watered, ink })
}
