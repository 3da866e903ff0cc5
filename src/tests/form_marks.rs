//! Hatching marks follow the form of the land: on gentle, rough land they follow the general slope, and on steep land
//! they do not change.
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use crate::tests::common;

use common::draw::{NOON, draw, floats, still};
use common::{World, grid_of, quantile, random};
use hachure::frame::Renderer;
use hachure::style::Style;
use hachure::surface::mark_normal::MARK_NORMAL;

const SIZE_PX: [u32; 2] = [480, 270];
/// A view as a map, 10 m per pixel.
const MAP: &str = "0,0,+3700,0,-90,40";

/// Returns a slope that rises to the east, with bumps of 80 m and 160 m, a tenth as high as wide. Where the slope is
/// gentle, the bumps determine the direction downhill; where it is steep, the slope does.
fn world(slope_deg: f64) -> Option<World> {
    let rise = slope_deg.to_radians().tan();
    let bumps_m = move |x_m: f64, y_m: f64| {
        let octave = |size_m: f64, seed: i64| {
            let (u, v) = (x_m / size_m, y_m / size_m);
            let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
            let (s, t) = (smooth(u - u.floor()), smooth(v - v.floor()));
            let at = |i: i64, j: i64| random(u.floor() as i64 + i + seed, v.floor() as i64 + j);
            let row = |j: i64| at(0, j) * (1.0 - s) + at(1, j) * s;
            0.1 * size_m * (row(0) * (1.0 - t) + row(1) * t)
        };
        octave(80.0, 0) + octave(160.0, 5000)
    };
    World::new(grid_of(2049, 2049, 10.0, move |x_m, y_m| rise * x_m + bumps_m(x_m, y_m)), 1.0)
}

/// Returns the normals of all blocks, and the 90th percentile of the angles between marks and west, the direction
/// downhill, in degrees.
fn marks(world: &mut World, form_px: f64, calm_deg: f64) -> (Vec<[f32; 4]>, f64) {
    let text = format!(
        "name = \"marks\"\ndescription = \"\"\n[hatching]\nform_px = {form_px}\ncalm_deg = {calm_deg}\n\
         [[hatching.layers]]\nmarks = \"hachure\"\ndirection = \"slope\"\n\
         [tone]\nkind = \"toon\"\nsteps = 0\ndarkest = 0\nlightest = 1\n"
    );
    let style = Style::parse("marks", &text).unwrap();
    let view = still(world.pose(MAP), SIZE_PX);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, &style, &NOON);
    let normals: Vec<[f32; 4]> = floats(&world.gpu, renderer.target(&MARK_NORMAL).unwrap());
    let angle_deg = |[x, y, ..]: &[f32; 4]| f64::from(y.atan2(-x).to_degrees().abs());
    let mut angles: Vec<f64> = normals.iter().filter(|texel| texel[3] > 0.0).map(angle_deg).collect();
    assert!(angles.len() > 4000, "only {} blocks show land", angles.len());
    let turned = quantile(&mut angles, 0.9);
    (normals, turned)
}

#[test]
fn marks_on_gentle_land_run_as_the_land_does() {
    let Some(mut gentle) = world(5.0) else { return };
    let turned = |world: &mut World, form_px, calm_deg| marks(world, form_px, calm_deg).1;
    let (of_pebbles, of_form, calm) =
        (turned(&mut gentle, 1.0, 0.0), turned(&mut gentle, 12.0, 0.0), turned(&mut gentle, 12.0, 17.0));
    println!(
        "one mark in ten turns by more than {of_pebbles:.1}° on the ground, {of_form:.1}° on the form, {calm:.1}° with calm"
    );
    // Planted errors: the ground itself, and the form without calm.
    assert!(
        of_pebbles > 60.0 && of_form > 9.0,
        "marks turn by {of_pebbles}° on the ground and {of_form}° without calm, too little to test calm"
    );
    assert!(calm < 6.0, "marks turn by {calm}° with calm, expected less than 6°");
}

#[test]
fn steep_land_keeps_its_own_marks() {
    let Some(mut steep) = world(35.0) else { return };
    let (without, with) = (marks(&mut steep, 12.0, 0.0).0, marks(&mut steep, 12.0, 17.0).0);
    let same = without.iter().zip(&with).filter(|(a, b)| a == b).count() as f64 / with.len() as f64;
    println!("a fraction of {same:.3} of the marks on steep land is the same with calm and without");
    assert!(same > 0.97, "only {same} of the marks on steep land are the same with calm");
    // Planted error: calm up to the slope of this land.
    let too_far = marks(&mut steep, 12.0, 45.0).0;
    let same = without.iter().zip(&too_far).filter(|(a, b)| a == b).count() as f64 / with.len() as f64;
    assert!(same < 0.9, "{same} of the marks are the same although calm reaches this slope");
}
