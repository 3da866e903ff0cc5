//! Tests asymmetric lenses and jitter.

use glam::{DVec2, DVec3};
use hachure::frame::Renderer;
use hachure::gpu::readback::read_as;
use hachure::scene::view::{Lens, Rig, View};
use hachure::style::Style;
use hachure::surface::motion::MOTION;

use crate::tests::rig::{SIZE_PX, START, World, draw_rig, hill};

/// Returns the point and the motion of each pixel; the point is 0 in the sky.
fn places(world: &mut World, view: View) -> (Vec<[f32; 4]>, Vec<[f32; 2]>) {
    let style = Style::load("plain").unwrap();
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    renderer.set_wants_motion(true);
    draw_rig(world, &mut renderer, &style, &Rig::mono(view));
    let places = renderer.places(&world.gpu, 0, [0, 0], SIZE_PX).unwrap().unwrap();
    (places, read_as(&world.gpu, renderer.target(&MOTION).unwrap(), [0, 0], SIZE_PX).unwrap())
}

/// Returns the part of pixels whose points differ by more than a hundredth of a pixel's width. The second picture is
/// read `shift` pixels to the right.
fn apart(a: &[[f32; 4]], b: &[[f32; 4]], shift: usize, focal_px: f64) -> f64 {
    let width = SIZE_PX[0] as usize;
    let mut differing = 0;
    for y in 0..SIZE_PX[1] as usize {
        for x in 0..width - shift {
            let (a, b) = (a[y * width + x], b[y * width + x + shift]);
            let [from, to] = [a, b].map(|at| DVec3::new(f64::from(at[0]), f64::from(at[1]), f64::from(at[2])));
            let same = from.distance(to) <= 0.01 * from.length().max(to.length()) / focal_px;
            differing += usize::from(!same);
        }
    }
    differing as f64 / ((width - shift) * SIZE_PX[1] as usize) as f64
}

#[test]
fn a_lens_that_is_not_symmetric_sees_its_part_of_a_wider_picture() {
    let Some(mut world) = hill() else { return };
    let pose = world.pose(START);
    let [width, height] = SIZE_PX.map(f64::from);
    let tangent = (0.5 * pose.fov_rad).tan();
    // The symmetric lens is the same when given by tangents.
    let symmetric = View::whole(pose, pose, SIZE_PX);
    let [left, up] = [tangent * width / height, tangent];
    let same = Lens { left, right: left, up, down: up };
    let by_tangents = View { lens: Some(same), previous_lens: Some(same), ..symmetric };
    assert!((by_tangents.focal_px() - symmetric.focal_px()).abs() < 1e-9);
    let (seen, _) = places(&mut world, symmetric);
    let focal_px = symmetric.focal_px();
    let differs = apart(&seen, &places(&mut world, by_tangents).0, 0, focal_px);
    assert!(differs < 0.002, "{differs}");
    // The lens is moved by 20 pixels and not stretched, so the left 20 columns show what was off-screen before.
    let step = 20.0 / focal_px;
    let turned = Lens { left: left + step, right: left - step, ..same };
    let view = View { lens: Some(turned), previous_lens: Some(turned), ..symmetric };
    let (shifted, motion) = places(&mut world, view);
    let differs = apart(&seen, &shifted, 20, focal_px);
    assert!(differs < 0.01, "{differs}");
    assert!(motion.iter().all(|[x, y]| x.hypot(*y) < 0.01), "an eye at rest must have no motion");
    // Planted: the symmetric lens.
    assert!(apart(&seen, &seen, 20, focal_px) > 0.5);
    // Pixels that are not square: the same land on half the width.
    let narrow = Lens { left: 2.0 * left, right: 2.0 * left, ..same };
    let view = View { lens: Some(narrow), ..symmetric };
    let place = view.place_px(view.ray(DVec2::new(3.0, 5.0))).unwrap();
    assert!(place.distance(DVec2::new(3.0, 5.0)) < 1e-9);
    let [narrow_px, wide_px] = [view, symmetric].map(|view| view.place_px(symmetric.ray(DVec2::ZERO)).unwrap().x);
    assert!((narrow_px - 0.25 * width).abs() < 1e-9 && wide_px.abs() < 1e-9, "{narrow_px} {wide_px}");
}

#[test]
fn jitter_moves_the_picture_and_is_no_motion() {
    let Some(mut world) = hill() else { return };
    let pose = world.pose(START);
    let still = View::whole(pose, pose, SIZE_PX);
    let (at_rest, _) = places(&mut world, still);
    let jittered = View { jitter_px: DVec2::new(1.0, 0.0), ..still };
    let (moved, motion) = places(&mut world, jittered);
    let focal_px = still.focal_px();
    let differs = apart(&at_rest, &moved, 1, focal_px);
    assert!(differs < 0.005, "{differs}");
    // Planted: without the shift most pixels show other points.
    assert!(apart(&at_rest, &moved, 0, focal_px) > 0.5);
    let worst = motion.iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f32::max);
    assert!(worst < 0.01, "{worst} px");
    // A step of the eye is motion all the same, and jitter does not change it.
    let mut before = pose;
    before.position_m -= pose.right * 2.0;
    let [plain, with_jitter] = [DVec2::ZERO, DVec2::new(1.0, 0.0)]
        .map(|jitter_px| places(&mut world, View { jitter_px, ..View::whole(before, pose, SIZE_PX) }).1);
    let width = SIZE_PX[0] as usize;
    let pairs = (0..plain.len()).filter(|i| i % width + 1 < width).map(|i| (plain[i], with_jitter[i + 1]));
    let off = pairs.filter(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]) > 0.02).count();
    assert!(off < plain.len() / 100, "{off}");
    assert!(plain.iter().any(|[x, _]| x.abs() > 0.2));
}
