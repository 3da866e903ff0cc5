//! Successive frames with temporal anti-aliasing: lines do not flicker, stay sharp, and leave no ghosts behind.

use glam::{DQuat, DVec3};
use hachure::frame::{Antialias, Renderer};
use hachure::measure::temporal::{TemporalTotals, compare, read_drawn};
use hachure::scene::view::{Pose, Rig, View};
use hachure::style::Style;

use crate::tests::antialias::{SIZE_PX, VIEW, apart, picture, sharpness, small_px, supersampled};
use crate::tests::common::draw::{draw, north_west};
use crate::tests::common::{World, full};

/// Samples of each pixel in the reference picture that a frame should match.
const SAMPLES: u32 = 16;
/// The first frames, which have too little history to be steady; they are not measured.
const SETTLING: u32 = 12;
/// A camera near the ground.
const LOW: &str = "-300,-2500,+60,20,-4,60";

/// Returns the pose of one frame of a slow path: a metre and an eighth of a degree per frame, as in `--lib tests::coherence`.
/// In the fast tier, it sees the middle of the view with pixels of the same size.
fn slow(world: &World, frame: u32) -> Pose {
    let mut pose = world.pose(VIEW);
    if !full() {
        pose.fov_rad = 2.0 * (0.5 * (0.5 * pose.fov_rad).tan()).atan();
    }
    pose.position_m += DVec3::new(0.3, 1.0, 0.0).normalize() * f64::from(frame);
    let turn = DQuat::from_rotation_z(-0.125_f64.to_radians() * f64::from(frame));
    for axis in [&mut pose.forward, &mut pose.right, &mut pose.up] {
        *axis = turn * *axis;
    }
    pose
}

struct Flown {
    totals: TemporalTotals,
    picture: Vec<[f64; 4]>,
    last: Pose,
}

fn fly(world: &mut World, style: &Style, antialias: Antialias, frames: u32) -> Flown {
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    renderer.set_antialias(antialias);
    let (mut totals, mut before) = (TemporalTotals::default(), None);
    // Without anti-aliasing, a frame of lines has no history.
    let first = if full() || antialias == Antialias::Temporal { 0 } else { SETTLING };
    let mut last = slow(world, first.saturating_sub(1));
    for number in first..frames {
        let pose = slow(world, number);
        let view = View::whole(std::mem::replace(&mut last, pose), pose, small_px());
        let rig = renderer.jittered(&Rig::mono(view), style);
        draw_rig(world, &mut renderer, style, &rig);
        if number >= SETTLING {
            let drawn = read_drawn(&world.gpu, &renderer, &rig, 0, style).unwrap();
            if let Some(before) = &before {
                totals.add(compare(before, &drawn).unwrap());
            }
            before = Some(drawn);
        }
    }
    Flown { totals, picture: picture(world, &renderer), last }
}

fn draw_rig(world: &mut World, renderer: &mut Renderer, style: &Style, rig: &Rig) {
    let prepared = hachure::frame::prepare(&world.gpu, &mut world.surfaces, rig, style, &north_west());
    renderer.render_rig(&world.gpu, &world.surfaces, &prepared, rig, style, &north_west()).unwrap();
    world.gpu.check().unwrap();
}

/// Blurs the picture: each pixel becomes the mean of itself and the two to its right.
fn blurred(picture: &[[f64; 4]]) -> Vec<[f64; 4]> {
    picture
        .windows(3)
        .map(|three| std::array::from_fn(|i| three.iter().map(|pixel| pixel[i]).sum::<f64>() / 3.0))
        .collect()
}

#[test]
fn lines_flicker_half_as_much_and_stay_sharp() {
    let Some(mut world) = crate::tests::antialias::fine_rough() else { return };
    // Lines of a detector crawl and strokes do not. Half of the little that strokes flicker comes from strokes that
    // appear and disappear, which takes more frames and pixels than the fast tier draws.
    let width = small_px()[0] as usize;
    let (styles, frames) = if full() { (2, 44) } else { (1, 20) };
    for (name, most) in [("lsa", 0.5), ("strokes", 0.6)].into_iter().take(styles) {
        // The lines that remain under a cap on crowded lines are calmer, and anti-aliasing removes a little less than
        // half of their flicker; so this style has no cap.
        let style = crate::tests::common::all_lines(name);
        let [alone, together] =
            [Antialias::None, Antialias::Temporal].map(|antialias| fly(&mut world, &style, antialias, frames));
        let number = |flown: &Flown, name: &str| flown.totals.metrics().unwrap()[name].unwrap();
        for metric in ["flicker", "flicker_ink", "e_warp", "line_coverage"] {
            println!("{name}: {metric} {:.6} → {:.6}", number(&alone, metric), number(&together, metric));
        }
        let truth = supersampled(&mut world, &mut None, &style, together.last, small_px(), SAMPLES);
        let of_truth = sharpness(&truth, width);
        let sharp = [&alone.picture, &together.picture].map(|picture| sharpness(picture, width) / of_truth);
        println!("{name}: sharpness {:.3} and {:.3} of the supersampled picture's", sharp[0], sharp[1]);
        assert!(number(&together, "flicker") <= most * number(&alone, "flicker"), "{name}: frames flicker too much");
        assert!(number(&together, "e_warp") <= 0.7 * number(&alone, "e_warp"), "{name}: the warp error is too large");
        assert!(
            sharp[1] >= 0.8,
            "{name}: sharpness relative to the supersampled picture, expected at least 0.8: {sharp:?}"
        );
        // Planted errors: frames that cannot flicker less, and a blur by a pixel.
        assert!(number(&alone, "flicker") > 0.0, "{name}");
        assert!(sharpness(&blurred(&together.picture), width) < 0.8 * of_truth, "{name}");
    }
}

/// In a fast flight past near land, what enters the picture and what a ridge uncovers has no history.
#[test]
fn nothing_is_left_behind() {
    let Some(mut world) = crate::tests::antialias::rough() else { return };
    let style = Style::load("lsa").unwrap();
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    renderer.set_antialias(Antialias::Temporal);
    let mut one = Renderer::new(&world.gpu).unwrap();
    let mut previous = world.pose(LOW);
    let mut off = [0.0; 3];
    let mut stale = None;
    for number in 0..8 {
        let mut pose = world.pose(LOW);
        pose.position_m += pose.right * (30.0 * f64::from(number)) + pose.forward * (10.0 * f64::from(number));
        for renderer in [&mut renderer, &mut one] {
            let view = View::whole(previous, pose, SIZE_PX);
            draw(&world.gpu, &mut world.surfaces, renderer, &view, &style, &north_west());
        }
        previous = pose;
        let truth = supersampled(&mut world, &mut None, &style, pose, SIZE_PX, SAMPLES);
        let shown = picture(&world, &renderer);
        // Planted error: the picture of the previous frame.
        let stale = stale.replace(shown.clone()).unwrap_or_else(|| shown.clone());
        for (off, picture) in off.iter_mut().zip([&shown, &picture(&world, &one), &stale]) {
            *off += apart(picture, &truth) / 8.0;
        }
    }
    println!("difference from the supersampled picture {off:.4?}: temporal, single frame, previous frame");
    assert!(off[0] < 1.1 * off[1] && off[2] > 1.3 * off[0], "temporal, single frame, previous frame: {off:?}");
    // After a cut there is no history, so nothing of the previous position may be visible. Planted error: a view that
    // claims to continue the flight.
    let there = slow(&world, 0);
    let off = [there, previous].map(|before| {
        let mut cut = View::whole(before, there, SIZE_PX);
        let rig = renderer.jittered(&Rig::mono(cut), &style);
        draw_rig(&mut world, &mut renderer, &style, &rig);
        let shown = picture(&world, &renderer);
        cut.jitter_px = rig.eyes[0].jitter_px;
        let mut fresh = Renderer::new(&world.gpu).unwrap();
        fresh.set_antialias(Antialias::Temporal);
        draw_rig(&mut world, &mut fresh, &style, &Rig::mono(cut));
        // Return to the previous position.
        let back = renderer.jittered(&Rig::mono(View::whole(there, previous, SIZE_PX)), &style);
        draw_rig(&mut world, &mut renderer, &style, &back);
        apart(&shown, &picture(&world, &fresh))
    });
    println!("difference after a cut {off:.5?}: declared as a cut, declared as a continuation");
    assert!(off[0] < 1e-3 && off[1] > 1e-3, "declared as a cut, as a continuation: {off:?}");
}
