//! Tests motion: the position of a pixel's content in the previous frame, compared with its projection in f64.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;
use crate::tests::helpers::styles::of_outlines;

use common::shot::{Shot, ink, shoot_style};
use common::{World, full, grid_of, rough_height_m};
use glam::{DQuat, DVec2, DVec3};
use hachure::picture::PartRule;
use hachure::scene::view::Pose;

const SIZE_PX: [u32; 2] = [320, 180];

/// Projects a vector from the eye (a direction or a point) to a picture of `pose`, in pixels.
fn project(pose: &Pose, way: DVec3) -> DVec2 {
    let [width, height] = SIZE_PX.map(f64::from);
    let focal_px = 0.5 * height / (0.5 * pose.fov_rad).tan();
    let ahead = way.dot(pose.forward);
    DVec2::new(0.5 * width + focal_px * way.dot(pose.right) / ahead, 0.5 * height - focal_px * way.dot(pose.up) / ahead)
}

/// Returns the largest distance between the channel and the projection, in pixels, and the number of pixels, each for
/// surface and sky. Only content in front of the previous eye counts.
fn worst_px(shot: &Shot, pose: &Pose, previous: &Pose) -> ([f64; 2], [usize; 2]) {
    let (mut worst, mut count) = ([0.0_f64; 2], [0; 2]);
    for pixel in 0..shot.depth_m.len() {
        let [x, y] = shot.place(pixel).map(|at| at as f64 + 0.5);
        let sky = shot.is_sky(pixel);
        let way = if sky { shot.ray(pixel) } else { pose.position_m + shot.position_m[pixel] - previous.position_m };
        // Content behind the previous eye, or to its side, has no previous position.
        if way.dot(previous.forward) < 0.05 * way.length() {
            continue;
        }
        let expected = DVec2::new(x, y) - project(previous, way);
        let off = (shot.motion_px[pixel] - expected).length();
        worst[usize::from(sky)] = worst[usize::from(sky)].max(off);
        count[usize::from(sky)] += 1;
    }
    (worst, count)
}

#[test]
fn motion_is_the_reprojection() {
    let Some(mut world) = World::new(grid_of(401, 401, 20.0, rough_height_m), 1.0) else { return };
    let mut renderer = None;
    let mut skies = 0;
    // Yaw, pitch, step (right, forward, up) in metres, zoom: from the previous frame to this one.
    let moves = [
        ("-300,-2500,+350,20,-6,60", 6.0, 3.0, [20.0, -15.0, 8.0], 1.1),
        ("200,300,+3,200,-1,90", 2.0, 1.0, [0.3, 0.8, 0.1], 1.0),
        // These are drawn in the long tier.
        ("-300,-2500,+350,20,-6,60", 0.0, 0.0, [0.0, 0.0, 0.0], 1.0),
        ("-300,-2500,+350,20,-6,60", 0.3, -0.2, [0.5, 3.0, 0.2], 1.0),
        ("0,-3900,3000,0,-25,20", -1.0, 0.5, [0.0, 60.0, 0.0], 1.0),
    ];
    let (drawn, part_px) = if full() { (5, 80) } else { (2, 160) };
    for (view, yaw_deg, pitch_deg, step_m, zoom) in moves.into_iter().take(drawn) {
        let pose = world.pose(view);
        let turn = DQuat::from_rotation_z(f64::to_radians(-yaw_deg));
        let tilt = DQuat::from_axis_angle(pose.right, f64::to_radians(pitch_deg));
        let previous = Pose {
            position_m: pose.position_m - (pose.right * step_m[0] + pose.forward * step_m[1] + pose.up * step_m[2]),
            forward: turn * tilt * pose.forward,
            right: turn * tilt * pose.right,
            up: turn * tilt * pose.up,
            fov_rad: pose.fov_rad * zoom,
        };
        let style = of_outlines(ink("footprint"));
        let shot = shoot_style(&mut world, &mut renderer, pose, previous, SIZE_PX, &style, &PartRule::default());
        let (worst, count) = worst_px(&shot, &pose, &previous);
        println!(
            "{view}: off by {:.5} px on {} pixels of surface, {:.5} px on {} of sky",
            worst[0], count[0], worst[1], count[1]
        );
        assert!(worst[0] <= 0.02 && worst[1] <= 0.02, "{view}: {worst:?} px");
        assert!(count[0] > 1000, "{view}: {count:?}");
        skies += count[1];
        // Planted: a previous eye rotated by another tenth of a pixel.
        let more = DQuat::from_axis_angle(pose.up, 0.1 / shot.focal_px());
        let turned = Pose { forward: more * previous.forward, right: more * previous.right, ..previous };
        let (worst, _) = worst_px(&shot, &pose, &turned);
        assert!(worst[0] > 0.02, "a rotation of a tenth of a pixel was not detected");
        // Parts that are rendered separately have the same motion, relative to the whole picture.
        let parts = PartRule { whole_px: 0, part_px, margin_px: 12 };
        let shot = shoot_style(&mut world, &mut renderer, pose, previous, SIZE_PX, &style, &parts);
        let (worst, _) = worst_px(&shot, &pose, &previous);
        println!("in parts: {:.5} px, {:.5} px", worst[0], worst[1]);
        assert!(worst[0] <= 0.02 && worst[1] <= 0.02, "{view} in parts: {worst:?} px");
    }
    assert!(skies > 1000, "{skies} pixels of sky");
}
