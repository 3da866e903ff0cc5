//! Rows of hachures of an eye, and the surfaces that hatching marks cover in a style with rows or cuts.

use super::FrameInputs;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, Targets};
use crate::style::hatching::Hatching;
use crate::surface::rows::{balance, choice, marks, off_land, proposals, ribbons, rooms};

/// Returns the hatching that a frame draws. If the land has rows or cut lines, hatching is only for models and trees,
/// and there is none in a world without them.
pub(super) fn drawn_hatching<'a>(inputs: &FrameInputs<'a>) -> Option<&'a Hatching> {
    let has_objects = inputs.world.meshes().is_some() || inputs.world.forest().is_some();
    let is_drawn = |hatching: &&Hatching| hatching.share > 0.0 && (!inputs.style.has_land_lines() || has_objects);
    inputs.style.hatching().filter(is_drawn)
}

/// Returns the positions at which hatching is drawn if the land has rows or cut lines: those of models and trees,
/// without the land.
pub(super) fn off_land_distance(
    recorder: &mut Recorder<'_>,
    inputs: &FrameInputs<'_>,
    view: &Resource,
    [surface_id, distance]: [&Target; 2],
    targets: &mut Targets,
) -> Option<Target> {
    if !inputs.style.has_land_lines() {
        return None;
    }
    let place = targets.whole(recorder.gpu(), &off_land::DISTANCE_OFF_LAND);
    off_land::run(recorder, view, surface_id, distance, &place);
    Some(place)
}

/// Draws the rows of hachures, in the requested tones, and returns their ink; `None` in a style without rows.
pub(super) fn draw(
    recorder: &mut Recorder<'_>,
    inputs: &FrameInputs<'_>,
    view: &Resource,
    [surface_id, distance, tone]: [&Target; 3],
    targets: &mut Targets,
) -> Option<Target> {
    let plan = inputs.rows?;
    let heights = &inputs.world.terrain.resources();
    let proposals = &proposals::run(recorder, &proposals::Inputs { view, terrain: heights, plan, distance });
    let places = choice::run(recorder, view, plan, proposals, tone.size_px());
    let inks = rooms::run(recorder, plan, &places, tone);
    let gains = &balance::run(recorder, view, plan, &inks, [distance, tone]);
    let marks = &marks::run(recorder, &marks::Inputs { view, plan, proposals, gains, tone });
    let ink = targets.whole(recorder.gpu(), &ribbons::ROW_INK);
    ribbons::run(recorder, &ribbons::Inputs { view, plan, marks, distance, surface_id, ink: &ink });
    Some(ink)
}
