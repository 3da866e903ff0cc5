//! Tests a sea that rises while a renderer draws, and trees at its shore.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::collections::BTreeSet;

use glam::DVec3;

use crate::composite::PICTURE;
use crate::frame::{Antialias, Renderer};
use crate::gpu::readback::read;
use crate::scene::Forest;
use crate::scene::forest::Form;
use crate::style::Style;
use crate::tests::common::draw::{draw, north_west, still};
use crate::tests::common::hill::Hill;
use crate::tests::common::{World, full, grid_of};
use crate::tests::helpers::forest::{drawn_trees, of};

const SIZE_PX: [u32; 2] = [128, 72];

/// Returns the feet of the trees that a camera above the hill sees, each once, in centimetres.
fn feet(world: &mut World, sea_level_m: Option<f64>) -> BTreeSet<[i64; 3]> {
    world.surfaces.set_sea_level(sea_level_m);
    let pose = world.pose("0,0,1500,0,-90,60");
    let trees = drawn_trees(world, &mut Renderer::new(&world.gpu).unwrap(), pose, SIZE_PX);
    let place = |at_m: DVec3| at_m.to_array().map(|along_m| (100.0 * along_m).round() as i64);
    trees.iter().map(|tree| place(tree.at_m)).collect()
}

#[test]
fn no_tree_grows_in_the_sea() {
    let Some(mut world) = World::new(Hill::square(321, 10.0).1, 0.02) else { return };
    let trees_per_ha = if full() { 20.0 } else { 6.0 };
    world.surfaces.set_forest(Some(Forest { seed: 3, ..of(Form::Conifer, trees_per_ha, 600.0) }));
    world.surfaces.set_tree_detail(4.0);
    let dry = feet(&mut world, None);
    let level_m = 60.0;
    let wet = feet(&mut world, Some(level_m));
    // The rule samples land that is 30 m wide, so that it is the same from near and far: on this hill it is off by less.
    let off_m = 1.0;
    let above = |feet: &BTreeSet<[i64; 3]>, level_m: f64| {
        feet.iter().filter(|foot| foot[2] as f64 > 100.0 * level_m).copied().collect::<BTreeSet<_>>()
    };
    println!("{} trees, {} of them above the sea", dry.len(), wet.len());
    assert!(wet.len() > 300 && wet.len() + 300 < dry.len());
    assert_eq!(above(&wet, level_m - off_m), wet, "a tree in the sea");
    assert_eq!(above(&wet, level_m + off_m), above(&dry, level_m + off_m), "a tree on land is gone");
    // Planted: without a sea, and with a lower one.
    assert_ne!(above(&dry, level_m - off_m), dry);
    let lower = feet(&mut world, Some(level_m - 10.0));
    assert_ne!(above(&lower, level_m - off_m), lower);
}

#[test]
fn a_picture_at_rest_begins_again_when_the_sea_rises() {
    let slope = |x_m: f64, y_m: f64| 0.08 * y_m + 12.0 * (x_m / 300.0).sin();
    let Some(mut world) = World::new(grid_of(129, 129, 15.0, slope), 1.0) else { return };
    let size_px = if full() { SIZE_PX } else { [64, 36] };
    let view = still(world.pose("0,-800,+400,0,-25,60"), size_px);
    let style = Style::load("lsa").unwrap();
    // Returns the picture at rest, or after this many frames.
    let rest = |world: &mut World, renderer: &mut Renderer, most: usize| {
        renderer.set_antialias(Antialias::Temporal);
        let mut frames = 0;
        while frames == 0 || renderer.is_settling() && frames < most {
            draw(&world.gpu, &mut world.surfaces, renderer, &view, &style, &north_west());
            frames += 1;
            assert!(frames < 200, "the picture does not come to rest");
        }
        (read(&world.gpu, renderer.target(&PICTURE).unwrap(), [0, 0], size_px).unwrap(), frames)
    };
    // The mean difference of the halves of two pictures.
    let difference = |a: &[u8], b: &[u8]| {
        let half = |bytes: &[u8]| half::f16::from_le_bytes([bytes[0], bytes[1]]).to_f64();
        let pairs = a.chunks(2).zip(b.chunks(2));
        pairs.map(|(a, b)| (half(a) - half(b)).abs()).sum::<f64>() / (a.len() / 2) as f64
    };
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let (dry, _) = rest(&mut world, &mut renderer, if full() { usize::MAX } else { 16 });
    world.surfaces.set_sea_level(Some(5.0));
    let (flooded, frames) = rest(&mut world, &mut renderer, usize::MAX);
    let mut fresh = Renderer::new(&world.gpu).unwrap();
    let (fresh, _) = rest(&mut world, &mut fresh, usize::MAX);
    let [of_fresh, of_dry] = [&fresh, &dry].map(|other| difference(&flooded, other));
    println!("{frames} frames; {of_fresh:.5} from a fresh picture, {of_dry:.5} from the dry one");
    // 64 samples again, not one more of the old picture.
    assert!(frames >= 64, "{frames} frames");
    assert!(of_fresh < 0.1 * of_dry && of_dry > 0.01);
}
