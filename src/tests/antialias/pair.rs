//! Both eyes use the same sequence of samples.

use hachure::composite::PICTURE;
use hachure::frame::{Antialias, Renderer};
use hachure::gpu::readback::read;
use hachure::scene::stereo::Pair;
use hachure::scene::view::{Rig, View};
use hachure::style::Style;

use crate::tests::antialias::{VIEW, small_px};
use crate::tests::common::draw::north_west;
use crate::tests::common::{World, full};

/// Returns the pictures of all eyes after a few steps.
fn flown(world: &mut World, style: &Style, rig_of: impl Fn(&View) -> Rig) -> Vec<Vec<u8>> {
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    renderer.set_antialias(Antialias::Temporal);
    let mut previous = world.pose(VIEW);
    let mut eyes = 0;
    let steps = if full() { 4 } else { 2 };
    for step in 0..steps {
        let mut pose = world.pose(VIEW);
        pose.position_m += pose.forward * (4.0 * f64::from(step));
        let rig = rig_of(&View::whole(previous, pose, small_px()));
        eyes = rig.eyes.len();
        renderer.render_eyes(&world.gpu, &mut world.surfaces, &rig, style, &north_west()).unwrap();
        world.gpu.check().unwrap();
        previous = pose;
    }
    (0..eyes)
        .map(|eye| read(&world.gpu, renderer.eye_target(eye, &PICTURE).unwrap(), [0, 0], small_px()).unwrap())
        .collect()
}

#[test]
fn eyes_at_one_place_are_one_and_exchanged_ones_exchange() {
    let Some(mut world) = crate::tests::antialias::rough() else { return };
    for name in ["lsa", "strokes"].into_iter().take(if full() { 2 } else { 1 }) {
        let style = Style::load(name).unwrap();
        let pair = |ipd_m| Pair { ipd_m, convergence_m: None };
        let mono = flown(&mut world, &style, |view| Rig::mono(*view));
        let together = flown(&mut world, &style, |view| pair(0.0).rig(view));
        assert!(together.iter().all(|eye| *eye == mono[0]), "{name}: eyes at one position differ from the single eye");
        let apart = flown(&mut world, &style, |view| pair(20.0).rig(view));
        let exchanged = flown(&mut world, &style, |view| {
            let mut rig = pair(20.0).rig(view);
            rig.eyes.reverse();
            rig
        });
        assert!(
            apart[0] == exchanged[1] && apart[1] == exchanged[0],
            "{name}: exchanged eyes do not have exchanged pictures"
        );
        assert!(apart[0] != apart[1], "{name}: planted error, both eyes show the same picture");
    }
}
