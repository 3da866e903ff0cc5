//! Eyes close together and far apart, in front of a wall, in the ground, looking straight up and down, behind a cliff,
//! with fields of view of 1° and 150°: everything drawn is finite, and lines that both eyes see are not lost.

use hachure::lines::smooth::SMOOTHED;
use hachure::lines::stereo::agree::AGREED;

use super::*;
use crate::tests::common::draw::{floats, halves};
use crate::tests::common::{World, all_lines, full, grid_of};

const SIZE_PX: [u32; 2] = [160, 90];

/// Returns a plain with a wall of 200 m north of y = 0.
fn cliff() -> Option<World> {
    World::new(grid_of(257, 257, 4.0, |x, y| if y > 0.0 && x > -40.0 { 200.0 } else { 0.05 * x.sin() }), 1.0)
}

/// Name, camera, and distance between the eyes in metres.
const PLACES: [(&str, &str, f64); 10] = [
    ("eyes 1 mm apart", "0,-200,+20,0,5,60", 0.001),
    ("eyes 1 km apart", "0,-200,+20,0,5,60", 1000.0),
    ("a wall 0.2 m away", "30,-0.2,100,0,0,60", 0.065),
    ("in the ground", "30,60,100,0,0,60", 0.065),
    ("in the plain", "0,-200,-5,0,5,60", 0.065),
    ("straight up", "0,-200,+20,0,90,60", 0.5),
    ("straight down", "0,-200,+120,0,-90,60", 0.5),
    ("one eye behind a cliff", "-40,20,100,0,0,60", 2.0),
    ("a lens of 1 degree", "0,-200,+20,0,10,1", 0.065),
    ("a lens of 150 degrees", "0,-200,+20,0,5,150", 0.065),
];

/// Presets, each with the number of the only place where the fast tier draws it.
const PRESETS: [(&str, usize); 4] = [("lsa", 2), ("charcoal", 1), ("crosshatch", 6), ("wash", 7)];

#[test]
fn what_two_eyes_draw_is_finite_everywhere() {
    let Some(mut world) = cliff() else { return };
    let mut taken = 0.0;
    for (number, (place, camera, ipd_m)) in PLACES.into_iter().enumerate() {
        let rig = rig(world.pose(camera), ipd_m, SIZE_PX);
        let presets = PRESETS.into_iter().filter(|(_, only)| full() || *only == number);
        let presets = presets.map(|(name, _)| (Style::load(name).unwrap(), false));
        // What agreement between the eyes removes is seen without the limit on crowded lines.
        for (style, has_all_lines) in [(all_lines("lsa"), true)].into_iter().chain(presets) {
            let frame = frame_of(&world.gpu, &mut world.surfaces, &style, &rig);
            for eye in 0..2 {
                let picture = halves(&world.gpu, frame.eye_target(eye, &hachure::composite::PICTURE).unwrap());
                assert!(
                    picture.iter().flatten().all(|value| value.is_finite()),
                    "{place}, {}: a pixel is not finite",
                    style.name
                );
            }
            if !has_all_lines {
                continue;
            }
            for eye in 0..2 {
                let lines =
                    [&SMOOTHED, &AGREED].map(|kind| floats::<1>(&world.gpu, frame.eye_target(eye, kind).unwrap()));
                let sum = |line: &[[f32; 1]]| line.iter().map(|[ink]| f64::from(*ink)).sum::<f64>();
                let [all, left] = lines.each_ref().map(|line| sum(line));
                println!("{place}, eye {eye}: {left:.1} of {all:.1} pixels of line remain");
                assert!(
                    lines[1].iter().zip(&lines[0]).all(|(left, all)| (0.0..=all[0]).contains(&left[0])),
                    "{place}: agreement adds ink"
                );
                taken += all - left;
                // Lines on surfaces that only one eye sees remain.
                assert!(left >= 0.9 * all, "{place}: only {left} of {all} pixels of line remain");
            }
        }
    }
    // A pass that removes nothing would pass all other checks.
    assert!(taken > 1.0, "agreement removes only {taken} pixels of line");
}
