//! Each eye of a stereo pair leaves out the suggestive contours that the other eye does not have, and no others.

use glam::{DVec2, DVec3};
use hachure::frame::{self, Renderer};
use hachure::scene::stereo::Pair;
use hachure::scene::view::{Pose, Rig, View};
use hachure::style::Style;
use hachure::surface::edges::{EDGE_DRAW, EDGES, Edge, KIND_SUGGESTIVE};

use crate::tests::common::draw::{NOON, places_m};
use crate::tests::common::{World, full};
use crate::tests::curvature::suggestive::SIZE_PX;
use crate::tests::helpers::stroke_lines::missed;
use crate::tests::helpers::stroke_lines::strokes_left;

const VIEWS: [(&str, &str); 3] = [
    ("dem/geotiff/mt_rainier_90m.tif", "-8000,-12000,+900,30,-25,50"),
    ("dem/geotiff/mt_everest_90m.tif", "4000,-9000,+900,-15,-25,45"),
    ("dem/geotiff/N46E008_alps.tif", "0,0,+900,40,-25,50"),
];
/// Distance between the eyes: so large that some lines of the land belong to one eye only.
const APART_M: f64 = 200.0;
/// The limit of the pass.
const AGREE_PX: f64 = 1.5;

/// Returns where the picture of an eye shows a position, in pixels, and its depth along the view axis, in metres.
fn seen_at(pose: Pose, at_m: DVec3) -> (DVec2, f64) {
    let view = View::whole(pose, pose, SIZE_PX);
    let from_eye_m = at_m - pose.position_m;
    let depth_m = from_eye_m.dot(pose.forward);
    let middle_px = DVec2::from(SIZE_PX.map(f64::from)) * 0.5;
    let way = DVec2::new(from_eye_m.dot(pose.right), -from_eye_m.dot(pose.up));
    (middle_px + way * (view.focal_px() / depth_m), depth_m)
}

fn is_inside(px: DVec2, margin_px: f64) -> bool {
    let [width, height] = SIZE_PX.map(f64::from);
    px.cmpge(DVec2::splat(margin_px)).all() && px.x < width - margin_px && px.y < height - margin_px
}

/// The view of one eye: midpoints of its suggestive contours, and the world position of each pixel.
struct Alone {
    middles_m: Vec<DVec3>,
    places_m: Vec<Option<DVec3>>,
}

/// Draws the rig and reads back its last eye.
fn look(world: &mut World, style: &Style, rig: &Rig) -> Alone {
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    renderer.set_only_strokes(!full());
    let prepared = frame::prepare(&world.gpu, &mut world.surfaces, rig, style, &NOON);
    renderer.render_rig(&world.gpu, &world.surfaces, &prepared, rig, style, &NOON).unwrap();
    let count = strokes_left::<u32>(&world.gpu, &renderer, &EDGE_DRAW, 1)[0] as usize / 2;
    let edges: Vec<Edge> = strokes_left(&world.gpu, &renderer, &EDGES, count);
    let place_m = |at_m: [f32; 3]| DVec3::from(at_m.map(f64::from)) + rig.origin_m;
    let own = edges.iter().filter(|edge| edge.kind & 0xff == KIND_SUGGESTIVE);
    let middles_m = own.map(|edge| (place_m(edge.a_m) + place_m(edge.b_m)) * 0.5).collect();
    Alone { middles_m, places_m: places_m(&world.gpu, &renderer, rig.origin_m) }
}

#[test]
fn pairs_draw_what_is_a_suggestive_contour_for_both_eyes() {
    let mut style = crate::tests::curvature::style(12.0);
    // Long lines, so that partners do not end early because their rise is near the limit.
    style.strokes_mut().unwrap().suggestive_rise = 0.01;
    let mut lone_parts = [0.0; 2];
    for (file, camera) in VIEWS.into_iter().take(if full() { 3 } else { 1 }) {
        let Some(mut world) = World::filled(file, 1.0) else { return };
        let pose = world.pose(camera);
        let pair = Pair { ipd_m: APART_M, convergence_m: None }.rig(&View::whole(pose, pose, SIZE_PX));
        let last = pair.eyes[1].pose;
        assert!(pair.aside_m(1) > pair.aside_m(0), "the right eye must be drawn last");
        let kept = look(&mut world, &style, &pair);
        let first = pair.eyes[0].pose;
        let [other, own] =
            [first, last].map(|pose| look(&mut world, &style, &Rig::mono(View::whole(pose, pose, SIZE_PX))));
        // Midpoints in the picture of the last eye, where both eyes see the position.
        let shared = |middles_m: &[DVec3], margin_px: f64| -> Vec<DVec2> {
            let seen = middles_m.iter().filter_map(|at_m| {
                let (other_px, depth_m) = seen_at(first, *at_m);
                let (px, _) = seen_at(last, *at_m);
                let is_shared = is_inside(px, margin_px) && is_inside(other_px, margin_px);
                let number = || other_px.y as usize * SIZE_PX[0] as usize + other_px.x as usize;
                let found_m = is_shared.then(|| other.places_m[number()]).flatten()?;
                (found_m.distance(*at_m) < 0.01 * depth_m).then_some(px)
            });
            seen.collect()
        };
        // Partners may be nearer to the border.
        let [other, own, kept] =
            [(&other, 10.0), (&own, 24.0), (&kept, 24.0)].map(|(eye, margin_px)| shared(&eye.middles_m, margin_px));
        let lone = |places: &[DVec2]| missed(places, &other, 2.0 * AGREE_PX).len() as f64 / places.len() as f64;
        // A line with a partner within half of the limit must not be left out.
        let (near, lost) = {
            let apart = missed(&own, &other, 0.5 * AGREE_PX);
            let near: Vec<DVec2> = own.iter().filter(|px| !apart.contains(px)).copied().collect();
            let lost = missed(&near, &kept, 1.0).len();
            (near.len(), lost)
        };
        println!(
            "{file}: {} edges of one eye, {:.1} % without a partner; {} of the pair's, {:.1} %; of {near} with a near \
             partner {lost} are left out",
            own.len(),
            100.0 * lone(&own),
            kept.len(),
            100.0 * lone(&kept)
        );
        assert!(own.len() > 500 && kept.len() < own.len());
        // The lines of a single eye are what would be drawn without the test of agreement.
        lone_parts = [lone_parts[0] + lone(&own), lone_parts[1] + lone(&kept)];
        assert!((lost as f64) < 0.05 * near as f64, "{file}: {lost} of {near} lines with a near partner are left out");
    }
    assert!(
        lone_parts[1] < 0.7 * lone_parts[0],
        "fraction of lines without a partner, single eye and pair: {lone_parts:?}"
    );
}
