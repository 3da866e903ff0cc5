//! Exchanged eyes have exchanged pictures, and two eyes at one position see what one eye sees, bit for bit.

use hachure::composite::PICTURE;
use hachure::gpu::readback::read;

use super::*;
use crate::tests::common::World;
use crate::tests::common::hill::Hill;

const SIZE_PX: [u32; 2] = [128, 72];

fn pictures(world: &mut World, style: &Style, rig: &Rig) -> Vec<Vec<u8>> {
    let frame = frame_of(&world.gpu, &mut world.surfaces, style, rig);
    let picture = |eye| read(&world.gpu, frame.eye_target(eye, &PICTURE).unwrap(), [0, 0], SIZE_PX).unwrap();
    (0..rig.eyes.len()).map(picture).collect()
}

#[test]
fn exchanged_eyes_exchange_their_pictures() {
    let Some(mut world) = World::new(Hill::square(321, 10.0).1, 1.0) else { return };
    let pose = world.pose("900,-900,+20,315,3,60");
    for name in hachure::style::names() {
        let style = Style::load(name).unwrap();
        let [before, after] = [1.0, -1.0].map(|ipd_m| pictures(&mut world, &style, &rig(pose, ipd_m, SIZE_PX)));
        assert!(
            before[0] == after[1] && before[1] == after[0],
            "{name}: exchanged eyes do not have exchanged pictures"
        );
        // Planted error: both eyes have the same picture.
        assert!(before[0] != after[0], "{name}: both eyes have the same picture");
    }
}

#[test]
fn eyes_at_one_place_are_one_eye() {
    let Some(mut world) = World::new(Hill::square(321, 10.0).1, 1.0) else { return };
    let pose = world.pose("900,-900,+20,315,3,60");
    for name in hachure::style::names() {
        let style = Style::load(name).unwrap();
        let mono = pictures(&mut world, &style, &Rig::mono(View::whole(pose, pose, SIZE_PX)));
        let pair = pictures(&mut world, &style, &rig(pose, 0.0, SIZE_PX));
        assert!(pair[0] == mono[0] && pair[1] == mono[0], "{name}: two eyes at one position differ from one eye");
        // Planted error: eyes a tenth of a metre apart.
        assert!(
            pictures(&mut world, &style, &rig(pose, 0.1, SIZE_PX))[0] != mono[0],
            "{name}: a distance of 0.1 m between the eyes changes nothing"
        );
    }
}
