//! The water of an eye: where it is, and what it looks like.

use super::FrameInputs;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Cx;
use crate::gpu::target::{Target, Targets};
use crate::surface::water::{self, WATER};
use crate::tones::water::{self as look, WATER_INK, WATERED};

/// What an eye sees.
pub(super) struct AtEye<'a> {
    /// `View`.
    pub(super) view: &'a Resource,
    pub(super) surface_id: &'a Target,
    pub(super) position: &'a Target,
    /// Of the land.
    pub(super) tone: &'a Target,
}

/// The water that an eye sees.
pub(super) struct Watered {
    /// Tones with water.
    pub(super) tone: Target,
    /// Ink of its shores and lines.
    pub(super) ink: Target,
    /// [`WATER`].
    pub(super) water: Target,
}

/// None in a style without water.
pub(super) fn draw(
    cx: &mut Cx<'_>,
    inputs: &FrameInputs<'_>,
    eye: &AtEye<'_>,
    targets: &mut Targets,
) -> Option<Watered> {
    let style = inputs.style.water.as_ref()?;
    let &AtEye { view, surface_id, position, tone } = eye;
    let (gpu, world) = (cx.gpu(), inputs.world);
    let water = &targets.whole(gpu, &WATER);
    let terrain = &world.terrain.water_map_resources()?;
    water::run(cx, &water::Inputs { view, terrain, style, surface_id, position, water });
    let [watered, ink] = [&WATERED, &WATER_INK].map(|kind| targets.whole(gpu, kind));
    let drawn = look::Inputs {
        view,
        style,
        sky: &inputs.style.sky,
        terrain: &world.terrain.uniform(),
        position,
        water,
        tone,
        watered: &watered,
        water_ink: &ink,
    };
    look::run(cx, &drawn);
    Some(Watered { tone: watered, ink, water: water.clone() })
}
