//! Tests views without water: once it is known that there is none, frames omit the passes of water, and their pictures
//! are the same to the bit.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;

use common::draw::{draw, north_west, still};
use common::{World, full, grid_of};
use hachure::composite::PICTURE;
use hachure::frame::Renderer;
use hachure::gpu::readback::read;
use hachure::scene::view::View;
use hachure::style::Style;

const SIZE_PX: [u32; 2] = [160, 90];
const CAMERA: &str = "0,-900,+250,0,-12,60";

/// Returns a style with water and lines by curvature, which water has not.
fn style() -> Style {
    let text = hachure::style::preset_text("lsa").unwrap();
    Style::parse("lsa", &text.replace("detector = \"lsa\"", "detector = \"curvature\"")).unwrap()
}

/// Returns a slope with a hollow, whose bottom is level if it has a lake.
fn land_m(has_lake: bool) -> impl Fn(f64, f64) -> f64 {
    move |x_m, y_m| {
        let hollow_m = 0.25 * x_m.hypot(y_m - 200.0);
        400.0 + if has_lake { hollow_m.max(60.0) } else { hollow_m + 0.02 * x_m }
    }
}

/// Draws a frame; returns its picture, and whether it ran passes of water.
fn frame(world: &mut World, renderer: &mut Renderer, view: &View) -> (Vec<u8>, bool) {
    renderer.set_traces(true);
    draw(&world.gpu, &mut world.surfaces, renderer, view, &style(), &north_west());
    world.gpu.wait();
    let runs = renderer.trace().iter().any(|pass| ["tones/water", "surface/lakes/seen"].contains(&pass.name));
    (read(&world.gpu, renderer.target(&PICTURE).unwrap(), [0, 0], SIZE_PX).unwrap(), runs)
}

/// Draws frames until the answer of the first one must have arrived; returns the last one.
fn settled(world: &mut World, renderer: &mut Renderer, view: &View) -> (Vec<u8>, bool) {
    (0..3).map(|_| frame(world, renderer, view)).last().unwrap()
}

#[test]
fn a_dry_view_is_drawn_without_passes_of_water_to_the_bit() {
    let (samples, spacing_m) = if full() { (257, 15.0) } else { (129, 30.0) };
    let Some(mut world) = World::new(grid_of(samples, samples, spacing_m, land_m(false)), 1.0) else { return };
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let view = still(world.pose(CAMERA), SIZE_PX);
    let (with, runs) = frame(&mut world, &mut renderer, &view);
    assert!(runs, "nothing is known of the first view");
    let (without, runs) = settled(&mut world, &mut renderer, &view);
    assert!(!runs && with == without);
    // A view of the same maps from elsewhere is known at once.
    let moved = still(world.pose("150,-850,+250,-8,-12,60"), SIZE_PX);
    let (without, runs) = frame(&mut world, &mut renderer, &moved);
    let mut fresh = Renderer::new(&world.gpu).unwrap();
    let (with, runs_anew) = frame(&mut world, &mut fresh, &moved);
    assert!(!runs && runs_anew && with == without);

    // The sea is switched on: the maps are recomputed, and are not known to be dry.
    world.surfaces.set_sea_level(Some(430.0));
    let (flooded, runs) = settled(&mut world, &mut renderer, &view);
    assert!(runs);
    let mut fresh = Renderer::new(&world.gpu).unwrap();
    assert!(flooded == frame(&mut world, &mut fresh, &view).0);
    // Planted: water in sight that counts as none.
    renderer.assume_dry();
    let (planted, runs) = frame(&mut world, &mut renderer, &view);
    assert!(!runs && planted != flooded);
}

#[test]
fn a_lake_in_sight_is_always_drawn() {
    let Some(mut world) = World::new(grid_of(257, 257, 15.0, land_m(true)), 1.0) else { return };
    let view = still(world.pose(CAMERA), SIZE_PX);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let (first, _) = frame(&mut world, &mut renderer, &view);
    let (later, runs) = settled(&mut world, &mut renderer, &view);
    assert!(runs && first == later);
    // Planted: a lake in sight that is treated as dry.
    renderer.assume_dry();
    let (planted, runs) = frame(&mut world, &mut renderer, &view);
    assert!(!runs && planted != first);
}
