//! The border of the picture: strokes run off it, and land that enters the picture has its strokes at once.

use hachure::frame::Renderer;
use hachure::gpu::readback::read_as;
use hachure::lines::strokes::stroke::INK;
use hachure::scene::view::{Pose, View};
use hachure::style::Style;

use crate::tests::coherence::{Flight, SIZE_PX, mountains, strokes};
use crate::tests::common::draw::{NOON, draw};
use crate::tests::common::{World, full};

const BORDER_PX: usize = 6;

/// Reads the ink of strokes, in row order.
fn ink(world: &World, renderer: &Renderer) -> Vec<f64> {
    let ink = renderer.target(&INK).unwrap();
    let halves: Vec<u16> = read_as(&world.gpu, ink, [0, 0], ink.size_px()).unwrap();
    halves.into_iter().map(|bits| half::f16::from_bits(bits).to_f64()).collect()
}

fn sum(ink: &[f64], width: usize, is_counted: impl Fn(usize, usize) -> bool) -> f64 {
    ink.iter().enumerate().filter(|(i, _)| is_counted(i % width, i / width)).map(|(_, ink)| ink).sum()
}

/// Returns the pose and size of a picture that shows a quarter more in both directions and whose middle is the picture
/// of `SIZE_PX`.
fn wider(pose: Pose) -> (Pose, [u32; 2]) {
    let tangent = (0.5 * pose.fov_rad).tan() * 1.25;
    (Pose { fov_rad: 2.0 * tangent.atan(), ..pose }, SIZE_PX.map(|side| side / 4 * 5))
}

#[test]
fn strokes_run_off_the_sheet() {
    let Some(mut world) = mountains() else { return };
    let style = strokes(|_| {});
    let [width, height] = SIZE_PX.map(|side| side as usize);
    let is_outer = |x: usize, y: usize| x.min(y).min(width - 1 - x).min(height - 1 - y) < BORDER_PX;
    let (mut own, mut expected, mut tapered) = (0.0, 0.0, 0.0);
    let cameras = ["-300,-2500,+350,20,-6,60", "900,-1800,+250,-70,-8,60", "0,3000,+400,170,-10,50"];
    let (count, least) = if full() { (3, 50.0) } else { (2, 30.0) };
    for camera in cameras.into_iter().take(count) {
        let pose = world.pose(camera);
        let mut drawn = |pose: Pose, size_px: [u32; 2]| {
            let mut renderer = Renderer::new(&world.gpu).unwrap();
            renderer.set_only_strokes(!full());
            draw(&world.gpu, &mut world.surfaces, &mut renderer, &View::whole(pose, pose, size_px), &style, &NOON);
            ink(&world, &renderer)
        };
        let sheet = drawn(pose, SIZE_PX);
        let (wider_pose, wider_px) = wider(pose);
        let [wide, high] = wider_px.map(|side| side as usize);
        let (left, top) = ((wide - width) / 2, (high - height) / 2);
        let whole = drawn(wider_pose, wider_px);
        let cut: Vec<f64> = (0..width * height).map(|i| whole[(top + i / width) * wide + left + i % width]).collect();
        own += sum(&sheet, width, is_outer);
        expected += sum(&cut, width, is_outer);
        // Planted error: ends that taper toward the border.
        let from_border = |x: usize, y: usize| x.min(y).min(width - 1 - x).min(height - 1 - y) as f64;
        let pale = sheet.iter().enumerate().map(|(i, ink)| ink * (from_border(i % width, i / width) / 6.0).min(1.0));
        tapered += sum(&pale.collect::<Vec<f64>>(), width, is_outer);
    }
    println!("ink of the outer {BORDER_PX} px: {:.3} of the ink that a wider picture has there", own / expected);
    let is_whole = |ink: f64| (ink / expected - 1.0).abs() <= 0.1;
    assert!(
        expected > least && is_whole(own) && !is_whole(tapered),
        "ink at the border {own}, in a wider picture {expected}, tapered {tapered}"
    );
}

/// Returns the pose of one frame of a turn to the right by 30 degrees per second.
pub fn turned(world: &World, frame: u32) -> Pose {
    let mut pose = world.pose("-300,-2500,+350,-40,-6,60");
    let turn = glam::DQuat::from_rotation_z(-1_f64.to_radians() * f64::from(frame));
    for axis in [&mut pose.forward, &mut pose.right, &mut pose.up] {
        *axis = turn * *axis;
    }
    pose
}

/// Measures, during a turn, the ink of each fifth of the picture from left to right, relative to rebuilt strokes; the
/// sixth number is the last fifth with its outer eight columns left blank.
fn turn(world: &mut World, style: &Style) -> [f64; 6] {
    let mut flight = Flight::new(world, style.clone());
    let mut rebuilding = Renderer::new(&world.gpu).unwrap();
    rebuilding.set_only_strokes(!full());
    let width = SIZE_PX[0] as usize;
    let mut sums = [[0.0; 2]; 6];
    for frame in 0..if full() { 32 } else { 20 } {
        let pose = turned(world, frame);
        flight.draw(world, pose);
        if frame > 6 && frame % 3 == 1 {
            let carried = ink(world, &flight.renderer);
            // A cut, so nothing is carried over.
            let view = View::whole(pose, pose, SIZE_PX);
            draw(&world.gpu, &mut world.surfaces, &mut rebuilding, &view, style, &NOON);
            let rebuilt = ink(world, &rebuilding);
            for (fifth, sums) in sums.iter_mut().enumerate() {
                for (sum_of, (ink, right)) in sums.iter_mut().zip([(&carried, width - 8), (&rebuilt, width)]) {
                    let right = if fifth == 5 { right } else { width };
                    *sum_of += sum(ink, width, |x, _| x * 5 / width == fifth.min(4) && x < right);
                }
            }
        }
    }
    sums.map(|[carried, rebuilt]| carried / rebuilt)
}

#[test]
fn land_that_enters_the_picture_has_its_strokes() {
    let Some(mut world) = mountains() else { return };
    let fifths = turn(&mut world, &strokes(|_| {}));
    println!("ink of carried strokes in fifths from left to right: {fifths:.3?} of the ink of rebuilt strokes");
    let is_there = |ink: f64| (ink - 1.0).abs() <= 0.06;
    assert!(
        fifths[..5].iter().all(|ink| is_there(*ink)) && !is_there(fifths[5]),
        "ink in fifths relative to rebuilt strokes: {fifths:?}"
    );
}
