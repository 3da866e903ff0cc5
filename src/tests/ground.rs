//! Tests marks of the ground: they are where their material is, belong to places of the world, and become fewer with
//! distance.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;

use common::draw::{draw, floats, north_west, still};
use common::{World, full, grid_of};
use glam::DVec2;
use hachure::frame::Renderer;
use hachure::scene::view::Pose;
use hachure::style::Style;
use hachure::style::layers::GROUND_INK;

const SIZE_PX: [u32; 2] = [480, 270];

fn style(keys: &str) -> Style {
    let text = format!(
        "name = \"ground\"\ndescription = \"\"\n[tone]\nkind = \"toon\"\nsteps = 0\ndarkest = 0.2\n[[layers]]\nkind = \"ground\"\n{keys}"
    );
    Style::parse("ground", &text).unwrap()
}

/// Returns a plane that rises to the north by an angle.
fn slope(rise_deg: f64, base_m: f64) -> Option<World> {
    let rise = rise_deg.to_radians().tan();
    World::new(grid_of(129, 129, 10.0, move |_, y| base_m + rise * y), 0.0)
}

fn ink_of(world: &mut World, pose: Pose, style: &Style) -> Vec<f64> {
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    draw(&world.gpu, &mut world.surfaces, &mut renderer, &still(pose, SIZE_PX), style, &north_west());
    let ink = floats::<1>(&world.gpu, renderer.target(&GROUND_INK).unwrap());
    ink.into_iter().map(|[ink]| f64::from(ink)).collect()
}

fn sum(ink: &[f64]) -> f64 {
    ink.iter().sum()
}

#[test]
fn each_slope_has_the_marks_of_its_material() {
    // The same camera above planes: what differs is the material alone.
    let keys = "lit = 1.0\ndark = 1.0\ngrass_m = 9000.0\nsnow_m = 9500.0\n";
    let snowy = "lit = 1.0\ndark = 1.0\nsnow_m = -400.0\n";
    let drawn = |world: &mut World, keys: &str| {
        let pose = world.pose("0,0,+300,0,-89,50");
        ink_of(world, pose, &style(keys))
    };
    // In the fast tier stones alone: other tests have grass.
    let all = [(28.0, "rock_deg = 0.0\n"), (12.0, "stones_deg = 0.0\n")];
    for (rise_deg, without) in all.into_iter().take(if full() { 2 } else { 1 }) {
        let Some(mut world) = slope(rise_deg, 0.0) else { return };
        let own = drawn(&mut world, keys);
        let other = drawn(&mut world, &format!("{keys}{without}"));
        let differ = own.iter().zip(&other).map(|(a, b)| (a - b).abs()).sum::<f64>();
        println!("{rise_deg} degrees: {:.0} px of ink, {differ:.0} differ with {without:?}", sum(&own));
        assert!(sum(&own) > 300.0);
        // Planted: the limits of another material.
        assert!(differ > 0.5 * sum(&own));
        // Snow covers grass and stones.
        assert_eq!(sum(&drawn(&mut world, snowy)), 0.0);
    }
    // Plains and rock have nothing.
    let [mut level, mut rock] = [0.0, 45.0].map(|rise_deg| slope(rise_deg, 0.0).unwrap());
    assert_eq!(sum(&drawn(&mut level, keys)), 0.0);
    assert_eq!(sum(&drawn(&mut rock, keys)), 0.0);
    assert!(sum(&drawn(&mut rock, &format!("{keys}rock_deg = 90.0\n"))) > 500.0);
}

#[test]
fn marks_stay_at_their_places_on_the_land() {
    let Some(mut world) = slope(12.0, 0.0) else { return };
    let style = style("lit = 1.0\ndark = 1.0\n");
    let pose = world.pose("0,0,+200,0,-89.9,50");
    let before = ink_of(&mut world, pose, &style);
    let shift_m = DVec2::new(7.3, 0.0);
    let aside = Pose { position_m: pose.position_m + shift_m.extend(0.0), ..pose };
    let after = ink_of(&mut world, aside, &style);
    // From straight above, land moves by the shift times the focal length over the height.
    let [width, height] = SIZE_PX.map(|side| side as usize);
    let correlation = |step: usize| {
        let pairs = (0..height).flat_map(|y| (step..width).map(move |x| (y * width + x, y * width + x - step)));
        let pairs: Vec<[f64; 2]> = pairs.map(|(a, b)| [before[a], after[b]]).collect();
        let mean = |i: usize| pairs.iter().map(|pair| pair[i]).sum::<f64>() / pairs.len() as f64;
        let means = [mean(0), mean(1)];
        let of = |i: usize, j: usize| pairs.iter().map(|p| (p[i] - means[i]) * (p[j] - means[j])).sum::<f64>();
        of(0, 1) / (of(0, 0) * of(1, 1)).sqrt()
    };
    let (best, found) = (0..60).map(|step| (step, correlation(step))).max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    let wanted_px = still(pose, SIZE_PX).focal_px() * shift_m.x / 200.0;
    println!("best at {best} px ({wanted_px:.1} px by the camera), correlation {found:.2}");
    assert!((best as f64 - wanted_px).abs() < 2.0 && found > 0.6);
    // Planted: marks that are fixed to the sheet.
    assert!(correlation(0) < 0.3);
}

#[test]
fn far_land_has_fewer_marks_and_then_none() {
    let Some(mut world) = slope(12.0, 0.0) else { return };
    let style = style("lit = 1.0\ndark = 1.0\nfarthest_m = 2.0\n");
    let mut ink = |height_m: f64| {
        let pose = world.pose(&format!("0,0,+{height_m},0,-89,50"));
        sum(&ink_of(&mut world, pose, &style))
    };
    let [near, middle, far] = [60.0, 350.0, 700.0].map(&mut ink);
    println!("{near:.0}, {middle:.0} and {far:.0} px of ink");
    assert!(near > 1.5 * middle && middle > 0.0 && far == 0.0);
}
