//! A picture at rest converges to the mean of its samples.

use glam::DVec3;
use hachure::frame::{Antialias, Renderer, SAMPLES_AT_REST};
use hachure::scene::view::{Pose, View};
use hachure::style::Style;

use crate::tests::antialias::{SIZE_PX, apart, picture, supersampled};
use crate::tests::common::World;
use crate::tests::common::draw::{draw, north_west};

/// Time between frames, in seconds.
const STEP_S: f64 = 1.0 / 30.0;

fn flies(renderer: &mut Renderer, world: &mut World, style: &Style, previous: Pose, pose: Pose) {
    let view = View::whole(previous, pose, SIZE_PX);
    draw(&world.gpu, &mut world.surfaces, renderer, &view, style, &north_west());
}

#[test]
fn a_picture_at_rest_converges() {
    let Some(mut world) = crate::tests::antialias::rough() else { return };
    for name in ["lsa", "strokes"] {
        let style = Style::load(name).unwrap();
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        renderer.set_antialias(Antialias::Temporal);
        renderer.set_step_s(STEP_S);
        let mut pose = world.pose(crate::tests::antialias::VIEW);
        let mut previous = pose;
        for _ in 0..6 {
            flies(&mut renderer, &mut world, &style, previous, pose);
            previous = pose;
            pose.position_m += DVec3::new(3.0, 7.0, 1.0);
        }
        pose = previous;
        let on_the_way = picture(&world, &renderer);
        let mut frames = 0;
        while renderer.is_settling() {
            flies(&mut renderer, &mut world, &style, pose, pose);
            frames += 1;
            assert!(frames < 200, "{name} does not settle");
        }
        let at_rest = picture(&world, &renderer);
        // The reference continues the strokes that the renderer drew.
        renderer.set_step_s(0.0);
        let truth = supersampled(&mut world, &mut Some(renderer), &style, pose, SIZE_PX, SAMPLES_AT_REST);
        let mut one = Renderer::new(&world.gpu).unwrap();
        flies(&mut one, &mut world, &style, pose, pose);
        let off = [&at_rest, &on_the_way, &picture(&world, &one)].map(|picture| apart(picture, &truth));
        println!("{name}: after {frames} frames, differences at rest, in motion, and of a single frame: {off:.5?}");
        // The tolerance is 1/255 of linear light. Planted error: a picture that was not at rest.
        assert!(off[0] < 1.0 / 255.0 && off[1] > 2.0 * off[0], "{name}: at rest, in motion, single frame: {off:?}");
    }
}
