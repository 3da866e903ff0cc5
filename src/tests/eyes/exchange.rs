//! Exchanged eyes have exchanged pictures, and two eyes at one position see what one eye sees, bit for bit.

use hachure::composite::PICTURE;
use hachure::gpu::readback::read;

use super::*;
use crate::tests::common::hill::Hill;
use crate::tests::common::{World, full, preset, presets};

const SIZE_PX: [u32; 2] = [128, 72];

fn pictures(world: &mut World, style: &Style, rig: &Rig) -> Vec<Vec<u8>> {
    let frame = frame_of(&world.gpu, &mut world.surfaces, style, rig);
    let picture = |eye| read(&world.gpu, frame.eye_target(eye, &PICTURE).unwrap(), [0, 0], SIZE_PX).unwrap();
    (0..rig.eyes.len()).map(picture).collect()
}

#[test]
fn exchanged_eyes_exchange_their_pictures_and_eyes_at_one_place_are_one_eye() {
    let Some(mut world) = World::new(Hill::square(321, 10.0).1, 1.0) else { return };
    let pose = world.pose("900,-900,+20,315,3,60");
    // In the fast tier lines that agree, strokes that are the same, and marks whose ink is balanced for both eyes.
    let names = if full() { presets() } else { vec!["lsa", "crosshatch"] };
    for name in names {
        let style = preset(name);
        let mono = pictures(&mut world, &style, &Rig::mono(View::whole(pose, pose, SIZE_PX)));
        let [pair, exchanged, together] =
            [0.1, -0.1, 0.0].map(|ipd_m| pictures(&mut world, &style, &rig(pose, ipd_m, SIZE_PX)));
        assert!(
            pair[0] == exchanged[1] && pair[1] == exchanged[0],
            "{name}: exchanged eyes do not have exchanged pictures"
        );
        assert!(
            together[0] == mono[0] && together[1] == mono[0],
            "{name}: two eyes at one position differ from one eye"
        );
        // Planted errors: both eyes have the same picture, and eyes a tenth of a metre apart.
        assert!(pair[0] != pair[1], "{name}: both eyes have the same picture");
        assert!(pair[0] != mono[0], "{name}: a distance of 0.1 m between the eyes changes nothing");
    }
}
