//! Near the land's border the form bends artificially, so no line of curvature is found there.

use glam::DVec2;
use hachure::frame::Renderer;
use hachure::surface::edges::{KIND_RIDGE, KIND_SUGGESTIVE, KIND_VALLEY};

use crate::tests::common::draw::{NOON, draw, still};
use crate::tests::common::{World, all_lines, grid_of};
use crate::tests::curvature::suggestive::{SIZE_PX, drawn};

const SPACING_M: f64 = 10.0;
const HALF_M: f64 = 800.0;
const HEIGHT_M: f64 = 3000.0;

#[test]
fn no_line_runs_straight_to_the_border() {
    let land = |x_m: f64, y_m: f64| 60.0 * (x_m / 90.0).sin() * (y_m / 110.0).cos() + 0.1 * x_m;
    let side = (2.0 * HALF_M / SPACING_M) as u32 + 1;
    let Some(mut world) = World::new(grid_of(side, side, SPACING_M, land), 0.2) else { return };
    let pose = world.pose(&format!("0,0,{HEIGHT_M},0,-90,40"));
    let view = still(pose, SIZE_PX);
    // Returns the number of points of lines, and their smallest distance from the border in pixels.
    let mut lines = |feature_px: f32| {
        let mut style = all_lines("strokes");
        style.set_water(None);
        let strokes = style.strokes_mut().unwrap();
        (strokes.suggestive_px, strokes.suggestive_rise, strokes.suggestive_deg) = (Some(feature_px), 0.01, 0.0);
        (strokes.ridge_px, strokes.ridge_bend) = (Some(feature_px), 0.02);
        (strokes.ridge_width, strokes.valley_width) = (1.0, 1.0);
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, &style, &NOON);
        let kinds = [KIND_SUGGESTIVE, KIND_RIDGE, KIND_VALLEY];
        let points: Vec<DVec2> =
            kinds.into_iter().flat_map(|kind| drawn(&world, &renderer, &view, pose, kind)).collect();
        let middle_px = 0.5 * DVec2::from(SIZE_PX.map(f64::from));
        let half_px = HALF_M * view.focal_px() / HEIGHT_M;
        let from_border = |px: &DVec2| half_px - (*px - middle_px).abs().max_element();
        (points.len(), points.iter().map(from_border).fold(f64::INFINITY, f64::min))
    };
    let (count, nearest_px) = lines(8.0);
    // Lines of a feature of 8 px belong to a level of 4 to 8 px, and stay 2.5 of its samples away.
    assert!(count > 200 && nearest_px > 9.0, "{count} points, one {nearest_px} px from the border");
    // Planted: lines of small features come close to it.
    let (count, nearest_px) = lines(1.0);
    assert!(count > 200 && nearest_px < 6.0, "{count} points, the nearest {nearest_px} px from the border");
}
