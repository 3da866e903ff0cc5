//! Strokes continue in a picture of another size, if the textures have room for it.

use std::collections::HashSet;

use hachure::scene::view::View;

use crate::tests::coherence::{Flight, SIZE_PX, mountains, pose, strokes};
use crate::tests::common::draw::{NOON, draw};
use crate::tests::common::{World, full};

/// Draws a frame of the flight in a picture that is `scale` times as large, and returns the stroke of each of its samples,
/// and their mean half width in the smaller picture.
fn identities(flight: &mut Flight, world: &mut World, frame: u32, scale: f64) -> (Vec<u32>, f64) {
    let pose = pose(world, frame);
    let previous = flight.last.map_or(pose, |last| last.pose);
    let size_px = SIZE_PX.map(|side| (f64::from(side) * scale) as u32);
    let view = View::whole(previous, pose, size_px);
    flight.last = Some(view);
    let style = flight.style.scaled(scale);
    draw(&world.gpu, &mut world.surfaces, &mut flight.renderer, &view, &style, &NOON);
    let (_, samples) = flight.renderer.strokes().unwrap().samples().read(&world.gpu).unwrap();
    let half_width_px = samples.iter().map(|own| f64::from(own.half_width_px)).sum::<f64>() / samples.len() as f64;
    assert!(samples.iter().all(|own| own.px[0].is_finite() && own.half_width_px >= 0.0));
    (samples.iter().map(|own| own.stroke).collect(), half_width_px / scale)
}

#[test]
fn strokes_continue_in_another_size() {
    let Some(mut world) = mountains() else { return };
    let (first, count) = if full() { (0, 4) } else { (2, 2) };
    let mut kept = |room_px: Option<[u32; 2]>, scales: [f64; 2]| {
        let mut flight = Flight::new(&world, strokes(|own| own.update_every = 2));
        flight.renderer.set_room(room_px);
        (first..4).for_each(|frame| _ = identities(&mut flight, &mut world, frame, scales[0]));
        let (before, width_before_px) = identities(&mut flight, &mut world, 4, scales[0]);
        let (after, width_px) = identities(&mut flight, &mut world, 5, scales[1]);
        assert!((width_px / width_before_px - 1.0).abs() < 0.1, "{width_before_px} px, then {width_px} px");
        let before: HashSet<u32> = before.into_iter().collect();
        after.iter().filter(|stroke| before.contains(stroke)).count() as f64 / after.len() as f64
    };
    for scales in [[1.0, 0.5], [0.75, 1.0], [1.0, 0.75], [1.0, 1.0]].into_iter().take(count) {
        let (with, without) = (kept(Some(SIZE_PX), scales), kept(None, scales));
        println!(
            "{scales:?}: {:.1} % of the strokes' length continues, without room {:.1} %",
            100.0 * with,
            100.0 * without
        );
        assert!(with > 0.8, "{scales:?}: {with}");
        // Planted: without room the strokes begin again.
        assert!(scales[0] == scales[1] || without < 0.2, "{scales:?}: {without}");
    }
}
