//! Water has no curvature, whatever the form of the land there.

use hachure::frame::Renderer;
use hachure::style::Style;
use hachure::surface::curvature::SHAPE_NORMAL;
use hachure::surface::water::WATER;

use crate::tests::common::draw::{NOON, draw, floats, still};
use crate::tests::common::{World, all_lines, full, grid_of};
use crate::tests::curvature::SIZE_PX;

const LAKE_M: f64 = -20.0;

/// Returns the height of hills whose valleys hold lakes.
fn height_m(x_m: f64, y_m: f64) -> f64 {
    (120.0 * (x_m / 300.0).sin() * (y_m / 260.0).cos() + 0.05 * y_m).max(LAKE_M)
}

#[test]
fn lakes_do_not_bend() {
    let (samples, spacing_m) = if full() { (321, 10.0) } else { (161, 20.0) };
    let Some(mut world) = World::new(grid_of(samples, samples, spacing_m, height_m), 0.0) else { return };
    let pose = world.pose("0,-1400,700,0,-30,50");
    let mut style = all_lines("strokes");
    style.strokes_mut().unwrap().suggestive_px = Some(6.0);
    style.set_water(Style::load("strokes").unwrap().water().cloned());
    // The blocks of lakes, and how many of them have curvature.
    let mut lake: Option<Vec<usize>> = None;
    let wide = SIZE_PX[0].div_ceil(4) as usize + 1;
    let mut bent = |style: &Style| {
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        renderer.set_only_strokes(!full());
        draw(&world.gpu, &mut world.surfaces, &mut renderer, &still(pose, SIZE_PX), style, &NOON);
        let lake = lake.get_or_insert_with(|| {
            let water = floats::<1>(&world.gpu, renderer.target(&WATER).unwrap());
            let of_block = |pixel: usize| pixel / SIZE_PX[0] as usize / 4 * wide + pixel % SIZE_PX[0] as usize / 4;
            let is_middle =
                |pixel: &usize| pixel % SIZE_PX[0] as usize % 4 == 2 && pixel / SIZE_PX[0] as usize % 4 == 2;
            (0..water.len()).filter(is_middle).filter(|pixel| water[*pixel][0] > 0.0).map(of_block).collect()
        });
        let normals = floats::<4>(&world.gpu, renderer.target(&SHAPE_NORMAL).unwrap());
        (lake.iter().filter(|block| normals[**block][3] > 0.0).count(), lake.len())
    };
    let (found, count) = bent(&style);
    // Planted error: a style that ignores water.
    let (planted, _) = bent(&style.without(&["water"]));
    println!("{count} blocks of lakes: {found} have curvature; without water in the style, {planted}");
    assert!(count > 300 && found == 0 && planted == count);
}
