//! Rows of hachures of an eye, and where the textures of marks lie beside them.

use super::FrameInputs;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, Targets};
use crate::style::hatching::Hatching;
use crate::surface::rows::{balance, choice, marks, off_land, proposals, ribbons, rooms};

/// The hatching that a frame draws: where the land has rows or cut lines, a texture is for what stands on it.
pub(super) fn drawn_hatching<'a>(inputs: &FrameInputs<'a>) -> Option<&'a Hatching> {
    let has_standing = inputs.world.meshes().is_some() || inputs.world.forest().is_some();
    inputs.style.hatching().filter(|_| !inputs.style.has_land_lines() || has_standing)
}

/// Where hatching lies, if the land has rows or cut lines: a position without the land.
pub(super) fn place_beside(
    recorder: &mut Recorder<'_>,
    inputs: &FrameInputs<'_>,
    view: &Resource,
    [surface_id, position]: [&Target; 2],
    targets: &mut Targets,
) -> Option<Target> {
    if !inputs.style.has_land_lines() {
        return None;
    }
    let place = targets.whole(recorder.gpu(), &off_land::PLACE_OFF_LAND);
    off_land::run(recorder, view, surface_id, position, &place);
    Some(place)
}

/// Ink of rows, in the tones that are asked for.
pub(super) fn draw(
    recorder: &mut Recorder<'_>,
    inputs: &FrameInputs<'_>,
    view: &Resource,
    [surface_id, position, tone]: [&Target; 3],
    targets: &mut Targets,
) -> Option<Target> {
    let plan = inputs.rows?;
    let heights = &inputs.world.terrain.resources();
    let proposals = &proposals::run(recorder, &proposals::Inputs { view, terrain: heights, plan, position });
    let places = choice::run(recorder, view, plan, proposals, tone.size_px());
    let inks = rooms::run(recorder, plan, &places, tone);
    let gains = &balance::run(recorder, view, plan, &inks, [position, tone]);
    let marks = &marks::run(recorder, &marks::Inputs { view, plan, proposals, gains, tone });
    let ink = targets.whole(recorder.gpu(), &ribbons::ROW_INK);
    ribbons::run(recorder, &ribbons::Inputs { view, plan, marks, position, surface_id, ink: &ink });
    Some(ink)
}
