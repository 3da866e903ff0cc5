//! A picture at rest becomes the mean of its samples.

use glam::DVec3;
use hachure::frame::{Antialias, Frame, SAMPLES_AT_REST};
use hachure::picture::{PictureRequest, render};
use hachure::scene::view::{Pose, View};
use hachure::style::Style;

use crate::common::World;
use crate::common::draw::{draw, north_west};
use crate::{SIZE_PX, apart, picture};

/// From a frame to the next.
const STEP_S: f64 = 1.0 / 30.0;

fn flies(frame: &mut Frame, world: &mut World, style: &Style, previous: Pose, pose: Pose) {
    let view = View::whole(previous, pose, SIZE_PX);
    draw(&world.gpu, &mut world.surfaces, frame, &view, style, &north_west());
}

/// The picture of so many samples, of the strokes that `frame` drew.
fn supersampled(frame: Frame, world: &mut World, style: &Style, pose: Pose) -> Vec<[f64; 4]> {
    let request =
        PictureRequest { samples: SAMPLES_AT_REST, ..PictureRequest::still(pose, SIZE_PX, style, north_west()) };
    let mut texels = Vec::new();
    let mut frame = Some(frame);
    frame.as_mut().unwrap().set_step_s(0.0);
    render(&world.gpu, &mut frame, &mut world.surfaces, &request, |band| {
        texels.extend(band.picture.into_iter().map(|texel| texel.map(f64::from)));
        Ok::<_, ()>(())
    })
    .unwrap();
    texels
}

#[test]
fn a_picture_at_rest_converges() {
    let Some(mut world) = crate::rough() else { return };
    for name in ["ink", "strokes"] {
        let style = Style::load(name).unwrap();
        let mut frame = Frame::new(&world.gpu).unwrap();
        frame.set_antialias(Antialias::Temporal);
        frame.set_step_s(STEP_S);
        let mut pose = world.pose(crate::VIEW);
        let mut previous = pose;
        for _ in 0..6 {
            flies(&mut frame, &mut world, &style, previous, pose);
            previous = pose;
            pose.position_m += DVec3::new(3.0, 7.0, 1.0);
        }
        pose = previous;
        let on_the_way = picture(&world, &frame);
        let mut frames = 0;
        while frame.is_settling() {
            flies(&mut frame, &mut world, &style, pose, pose);
            frames += 1;
            assert!(frames < 200, "{name} does not settle");
        }
        let at_rest = picture(&world, &frame);
        let truth = supersampled(frame, &mut world, &style, pose);
        let mut one = Frame::new(&world.gpu).unwrap();
        flies(&mut one, &mut world, &style, pose, pose);
        let off = [&at_rest, &on_the_way, &picture(&world, &one)].map(|picture| apart(picture, &truth));
        println!("{name}: after {frames} frames at rest, on the way, and alone, off by {off:.5?}");
        // A 255th, of what is linear; and planted: what did not rest.
        assert!(off[0] < 1.0 / 255.0 && off[1] > 2.0 * off[0], "{name}: {off:?}");
    }
}
