//! Land that nearer land hid has its strokes at once when it comes to light.

use std::collections::VecDeque;

use glam::{DVec3, Vec3};
use hachure::frame::Frame;
use hachure::gpu::readback::read_as;
use hachure::scene::view::{Pose, View};
use hachure::surface::POSITION;

use crate::checks::Updated;
use crate::common::draw::{NOON, draw};
use crate::sheet::ink;
use crate::{Flight, SIZE_PX, mountains, strokes};

/// Two fifths of a second: lines that grow are far from whole.
const FRAMES: usize = 12;
/// Ink of a line before it reaches so far over land behind.
const BESIDE_PX: i64 = 4;

/// Pixels of land that a picture before could not see for nearer land, apart from the edges of nearer land now.
fn came_to_light(position: &[[f32; 4]], view: &View, before: &Updated) -> Vec<bool> {
    let [width, height] = SIZE_PX.map(i64::from);
    let distance_m = |x: i64, y: i64| position[(y.clamp(0, height - 1) * width + x.clamp(0, width - 1)) as usize][3];
    let is_new = |pixel: usize| {
        let (at, x, y) = (position[pixel], pixel as i64 % width, pixel as i64 / width);
        let is_before = |offset: i64| {
            let [dx, dy] = [offset % 9 - BESIDE_PX, offset / 9 - BESIDE_PX];
            (0.01..0.8 * at[3]).contains(&distance_m(x + dx, y + dy))
        };
        at[3] > 0.0 && before.hid(view, Vec3::new(at[0], at[1], at[2])) && !(0..81).any(is_before)
    };
    (0..position.len()).map(is_new).collect()
}

#[test]
fn land_that_comes_to_light_has_its_strokes() {
    let Some(mut world) = mountains() else { return };
    let style = strokes(|_| {});
    let mut flight = Flight::new(&world, style.clone());
    let mut frame_anew = Frame::new(&world.gpu).unwrap();
    let mut pictures: VecDeque<Updated> = VecDeque::new();
    let (mut pixels, mut carried, mut anew, mut planted) = (0, 0.0, 0.0, 0.0);
    for number in 0..60 {
        let start = world.pose("-300,-2500,+60,20,-4,60");
        let pose = Pose { position_m: start.position_m + DVec3::Z * (5.0 * f64::from(number)), ..start };
        let (view, ..) = flight.draw(&mut world, pose);
        let now = Updated::of(&world, &flight.frame, view);
        if pictures.len() == FRAMES && number % 3 == 0 {
            let target = flight.frame.target(&POSITION).unwrap();
            let position: Vec<[f32; 4]> = read_as(&world.gpu, target, [0, 0], SIZE_PX).unwrap();
            let is_new = came_to_light(&position, &view, &pictures[0]);
            let of_carried = ink(&world, &flight.frame);
            // A cut: nothing is taken over.
            let cut = View::whole(pose, pose, SIZE_PX);
            draw(&world.gpu, &mut world.surfaces, &mut frame_anew, &cut, &style, &NOON);
            let of_anew = ink(&world, &frame_anew);
            for pixel in (0..is_new.len()).filter(|pixel| is_new[*pixel]) {
                pixels += 1;
                carried += of_carried[pixel];
                anew += of_anew[pixel];
                // A quarter of it is not there.
                planted += if pixel / 8 % 4 == 0 { 0.0 } else { of_carried[pixel] };
            }
        }
        pictures.push_back(now);
        if pictures.len() > FRAMES {
            pictures.pop_front();
        }
    }
    println!("{pixels} pixels came to light: {:.3} of the ink of strokes made anew, of {anew:.0}", carried / anew);
    let is_there = |ink: f64| (ink / anew - 1.0).abs() <= 0.1;
    assert!(anew > 100.0 && is_there(carried) && !is_there(planted), "{carried}, {anew}, {planted}");
}
