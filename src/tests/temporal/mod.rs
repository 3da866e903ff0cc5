//! Tests the measures of steadiness between frames on drawings whose truth is known: lines at points of a world of a
//! plane and a wall, seen by a moving eye. A last test measures a real drawing.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;

mod identity;

use common::random;
use glam::{DQuat, DVec2, DVec3};
use hachure::frame::{Light, Renderer};
use hachure::measure::temporal::{
    DrawnFrame, LINE_INK, PairMeasures, Share, StrokePictures, TemporalError, TemporalTotals, compare, count_strokes,
    read_drawn,
};
use hachure::scene::view::{Pose, Rig, View};
use hachure::source::{Silent, procedural};
use hachure::style::Style;

const SIZE_PX: [u32; 2] = [240, 160];

/// Returns an eye that looks north.
fn eye(position_m: DVec3, turned_px: f64) -> View {
    let mut view = View::whole(
        Pose { position_m, forward: DVec3::Y, right: DVec3::X, up: DVec3::Z, fov_rad: 0.8 },
        Pose { position_m, forward: DVec3::Y, right: DVec3::X, up: DVec3::Z, fov_rad: 0.8 },
        SIZE_PX,
    );
    let turn = DQuat::from_rotation_z(turned_px / view.focal_px());
    (view.pose.forward, view.pose.right) = (turn * DVec3::Y, turn * DVec3::X);
    view
}

/// A plane at height 0, and on it a wall that faces south: 80 m wide, 25 m high, 200 m to the north.
#[derive(Clone, Copy)]
struct Scene {
    wall: bool,
}

impl Scene {
    /// Returns the depth at which a ray, given at unit depth, meets the scene.
    fn meet(self, eye_m: DVec3, ray: DVec3) -> Option<f64> {
        let wall = (200.0 - eye_m.y) / ray.y;
        let at = eye_m + ray * wall;
        if self.wall && at.x.abs() <= 40.0 && (0.0..=25.0).contains(&at.z) {
            return Some(wall);
        }
        let plane = -eye_m.z / ray.z;
        (ray.z < 0.0).then_some(plane)
    }
}

/// A line between two points of the world.
#[derive(Clone, Copy)]
struct Line {
    ends_m: [DVec3; 2],
    id: u32,
    /// The parameter at the line's beginning, and its growth per metre.
    along: [f64; 2],
    width_px: f64,
    /// Offset at which the line is drawn, in pixels.
    off_px: DVec2,
}

impl Line {
    fn new(a: [f64; 3], b: [f64; 3]) -> Self {
        Self { ends_m: [a.into(), b.into()], id: 1, along: [0.0, 1.0], width_px: 2.0, off_px: DVec2::ZERO }
    }

    /// Returns a line along the upper edge of the wall.
    fn on_the_wall() -> Self {
        Self::new([-38.0, 200.0, 25.0], [38.0, 200.0, 25.0])
    }

    /// Returns a line on the plane in front of the wall, at an angle to both axes of the ground.
    fn on_the_ground() -> Self {
        Self { id: 2, ..Self::new([-30.0, 110.0, 0.0], [35.0, 170.0, 0.0]) }
    }
}

/// Returns the brightness of the scene at a point; `None` is the sky.
fn brightness(at_m: Option<DVec3>) -> f64 {
    // The pattern fades with distance, where pixels could not resolve it.
    at_m.map_or(0.5, |at| 0.5 + 0.4 * (at.x / 25.0).sin() * (at.y / 60.0).cos() * (-(at.y / 300.0).powi(2)).exp())
}

fn shoot(view: View, scene: Scene, lines: &[Line]) -> DrawnFrame {
    let pixels = (SIZE_PX[0] * SIZE_PX[1]) as usize;
    let eye_m = view.pose.position_m;
    let mut frame = DrawnFrame {
        view,
        origin_m: eye_m,
        position: vec![[0.0; 4]; pixels],
        ink: Some(vec![0.0; pixels]),
        strokes: Some(StrokePictures {
            id: vec![0; pixels],
            along_px: vec![f32::NAN; pixels],
            half_width_px: vec![f32::NAN; pixels],
            depth_m: vec![f32::NAN; pixels],
            identities_last: true,
            rebuilt: true,
        }),
        centres: None,
        marks: None,
        luma: vec![0.0; pixels],
        colors: vec![[0; 3]; pixels],
    };
    let strokes = frame.strokes.as_mut().unwrap();
    for (pixel, ink) in frame.ink.iter_mut().flatten().enumerate() {
        let centre = DVec2::new((pixel as u32 % SIZE_PX[0]) as f64, (pixel as u32 / SIZE_PX[0]) as f64) + 0.5;
        let ray = view.ray(centre);
        let depth_m = scene.meet(eye_m, ray);
        let way = depth_m.map(|depth_m| ray * depth_m);
        if let (Some(way), Some(depth_m)) = (way, depth_m) {
            let [x, y, z] = way.as_vec3().to_array();
            frame.position[pixel] = [x, y, z, depth_m as f32];
        }
        frame.luma[pixel] = brightness(way.map(|way| eye_m + way)) as f32;
        for line in lines {
            let [a, b] = line.ends_m.map(|end| view.place_px(end - eye_m).unwrap() + line.off_px);
            let part = ((centre - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            let coverage = 0.5 * line.width_px + 0.5 - centre.distance(a.lerp(b, part));
            // The parameter in the picture is not that in the world, because of perspective.
            let [near, far] = line.ends_m.map(|end| (end - eye_m).dot(view.pose.forward));
            let at = part * near / (part * near + (1.0 - part) * far);
            let place_m = line.ends_m[0].lerp(line.ends_m[1], at);
            let hidden = way.is_some_and(|way| (place_m - eye_m).length() > 1.02 * way.length());
            if coverage > 0.0 && !hidden {
                *ink = coverage.min(1.0) as f32;
                strokes.id[pixel] = line.id;
                strokes.along_px[pixel] = (line.along[0] + line.along[1] * (place_m - line.ends_m[0]).length()) as f32;
            }
        }
    }
    frame
}

const SCENE: Scene = Scene { wall: true };
const EYE_M: DVec3 = DVec3::new(0.0, 0.0, 45.0);

/// Compares two frames with the eye at rest or moved, and with the given lines.
fn pair(step_m: DVec3, turned_px: f64, before: &[Line], now: &[Line]) -> PairMeasures {
    let before = shoot(eye(EYE_M, 0.0), SCENE, before);
    compare(&before, &shoot(eye(EYE_M + step_m, turned_px), SCENE, now)).unwrap()
}

fn value(share: Share) -> f64 {
    share.value().unwrap()
}

/// Returns flicker: births and deaths, then births and deaths weighted by ink.
fn flicker(pair: &PairMeasures) -> [f64; 4] {
    let lines = pair.lines.as_ref().unwrap();
    [lines.births.lone, lines.deaths.lone, lines.births.lone_ink, lines.deaths.lone_ink].map(value)
}

/// Returns the median slip and its 95th percentile. The ends of lines have a constant parameter, so the maximum is
/// meaningless.
fn slip_px(pair: &PairMeasures) -> [f32; 2] {
    let mut slips_px = pair.strokes.as_ref().unwrap().slips_px.clone();
    slips_px.sort_by(f32::total_cmp);
    [slips_px[slips_px.len() / 2], slips_px[slips_px.len() * 95 / 100]]
}

/// Steps of the eye per frame in metres, and its turns in pixels.
const STEPS: [([f64; 3], f64); 5] =
    [([0.0; 3], 0.0), ([0.0; 3], 0.3), ([2.0, 0.0, 0.0], 0.0), ([0.0, 3.0, -0.3], 1.4), ([-4.0, -2.0, 0.5], -7.7)];

#[test]
fn lines_that_stay_in_their_place_are_steady() {
    for (step_m, turned_px) in STEPS {
        let lines = [Line::on_the_wall(), Line::on_the_ground()];
        let pair = pair(step_m.into(), turned_px, &lines, &lines);
        let [births, deaths, born_ink, dead_ink] = flicker(&pair);
        let [median_px, percentile_95_px] = slip_px(&pair);
        println!(
            "{step_m:?}: by ink {born_ink:.4}, {dead_ink:.4}; slip {median_px:.4} px, {percentile_95_px:.4} at 95 %"
        );
        assert_eq!([births, deaths], [0.0; 2], "{step_m:?}");
        assert!(born_ink < 0.01 && dead_ink < 0.01, "{step_m:?}: {born_ink} {dead_ink}");
        assert!(median_px < 0.05 && percentile_95_px < 0.3, "{step_m:?}: {median_px} {percentile_95_px}");
        let strokes = pair.strokes.unwrap();
        assert_eq!((strokes.born, strokes.died), (Share { part: 0.0, whole: 2.0 }, Share { part: 0.0, whole: 2.0 }));
        assert_eq!(value(strokes.identity_change.unwrap()), 0.0);
        let coverage = value(pair.lines.unwrap().coverage);
        assert!((0.005..0.05).contains(&coverage), "{coverage}");
    }
}

#[test]
fn the_same_frame_twice_is_exactly_steady() {
    let frame = shoot(eye(EYE_M, 0.0), SCENE, &[Line::on_the_wall(), Line::on_the_ground()]);
    let pair = compare(&frame, &frame).unwrap();
    assert_eq!(flicker(&pair), [0.0; 4]);
    assert!(pair.strokes.as_ref().unwrap().slips_px.iter().all(|slip_px| *slip_px == 0.0));
    assert_eq!(value(pair.e_warp), 0.0);
    assert_eq!(value(pair.lines.unwrap().births.masked), 0.0);
}

#[test]
fn a_line_that_is_dropped_flickers() {
    let (wall, ground) = (Line::on_the_wall(), Line::on_the_ground());
    let step_m = DVec3::new(1.0, 2.0, 0.0);
    let [births, deaths, ..] = flicker(&pair(step_m, 0.5, &[wall], &[wall, ground]));
    assert!(births > 0.3 && deaths == 0.0, "{births} {deaths}");
    let only = pair(step_m, 0.5, &[ground], &[wall]);
    assert_eq!(flicker(&only), [1.0; 4]);
    let strokes = only.strokes.unwrap();
    assert_eq!([value(strokes.born), value(strokes.died)], [1.0; 2]);
    assert!(strokes.slips_px.is_empty());
    // The flicker of an empty page is null, not 0.
    let empty = pair(step_m, 0.5, &[], &[]).lines.unwrap();
    assert_eq!((empty.births.lone.value(), empty.coverage.value()), (None, Some(0.0)));
}

#[test]
fn a_line_may_move_by_a_pixel_and_not_by_three() {
    for (step_m, turned_px) in [STEPS[0], STEPS[2]] {
        let line = Line { width_px: 0.6, ..Line::on_the_wall() };
        let moved = |px: f64| Line { off_px: DVec2::new(0.0, px), ..line };
        let of = |px: f64| flicker(&pair(step_m.into(), turned_px, &[line], &[moved(px)]));
        assert_eq!(of(1.0)[..2], [0.0; 2]);
        assert_eq!(of(3.0), [1.0; 4]);
        assert_eq!(of(-3.0)[..2], [1.0; 2]);
    }
}

#[test]
fn a_line_on_an_edge_moves_with_what_is_in_front() {
    let line = [Line::on_the_wall()];
    for step_m in [DVec3::new(0.0, 60.0, 0.0), DVec3::new(12.0, 0.0, 0.0), DVec3::new(0.0, 0.0, 12.0)] {
        let [mut before, mut now] = [EYE_M, EYE_M + step_m].map(|eye_m| shoot(eye(eye_m, 0.0), SCENE, &line));
        let steady = compare(&before, &now).unwrap();
        assert_eq!(flicker(&steady)[..2], [0.0; 2], "{step_m}");
        let masked = value(steady.lines.unwrap().births.masked);
        assert!(masked < 0.1, "{step_m}: {masked}");
        assert_eq!(value(steady.strokes.unwrap().born), 0.0);
        // Planted: the motion of what is behind the wall. In a sideways step the line slides along itself and is found
        // by its other parts.
        let behind = Scene { wall: false };
        for frame in [&mut before, &mut now] {
            frame.position = shoot(frame.view, behind, &[]).position;
        }
        let planted = flicker(&compare(&before, &now).unwrap());
        assert!(step_m.x != 0.0 || planted[0] > 0.9, "{step_m}: {planted:?}");
    }
}

#[test]
fn what_comes_to_light_is_masked() {
    // Lines behind the wall, which steps of the eye uncover to its side and above it.
    let lines_at = |y_m: [f64; 3]| y_m.map(|y_m| Line::new([-100.0, y_m, 0.0], [100.0, y_m, 0.0]));
    let (near, far) = (lines_at([270.0, 300.0, 330.0]), lines_at([380.0, 384.0, 388.0]));
    for (step_m, far) in [(DVec3::new(15.0, 0.0, 0.0), near), (DVec3::new(0.0, 0.0, 15.0), far)] {
        let [mut before, mut now] = [EYE_M, EYE_M + step_m].map(|eye_m| shoot(eye(eye_m, 0.0), SCENE, &far));
        let pair = compare(&before, &now).unwrap();
        let (lines, shares) = (pair.lines.unwrap(), flicker(&pair));
        let masked = [value(lines.births.masked), value(lines.deaths.masked)];
        println!("{step_m}: {masked:?} masked, flicker {shares:?}");
        assert!(shares[0] < 0.005 && shares[1] < 0.005, "{step_m}: {shares:?}");
        assert!(masked[0] > 0.02 && masked[0] < 0.9, "{step_m}: {masked:?}");
        // Planted: the wall that hid the lines is missing in the positions.
        for frame in [&mut before, &mut now] {
            frame.position = shoot(frame.view, Scene { wall: false }, &[]).position;
        }
        let planted = flicker(&compare(&before, &now).unwrap());
        assert!(planted[0] > 0.02, "{step_m}: {planted:?}");
    }
    // Lines that leave the picture are masked as well.
    let turned = pair(DVec3::ZERO, 110.0, &near, &near);
    assert!(value(turned.lines.unwrap().deaths.masked) > 0.3);
    assert_eq!(flicker(&turned)[..2], [0.0; 2]);
}

#[test]
fn e_warp_is_that_of_what_changed() {
    for (step_m, turned_px) in STEPS {
        let scene = Scene { wall: false };
        let before = shoot(eye(EYE_M, 0.0), scene, &[]);
        let mut now = shoot(eye(EYE_M + DVec3::from(step_m), turned_px), scene, &[]);
        let exact = compare(&before, &now).unwrap().e_warp;
        println!("{step_m:?}: E_warp {:.2e} on {} pixels", value(exact), exact.whole);
        assert!(value(exact) < 1e-5, "{step_m:?}: {}", value(exact));
        assert!(exact.whole > 0.75 * f64::from(SIZE_PX[0] * SIZE_PX[1]), "{}", exact.whole);
        // Planted: noise of a known strength, and an eye that turned by two more pixels.
        for (pixel, luma) in now.luma.iter_mut().enumerate() {
            *luma += 0.1 * (random(pixel as i64, 5) - 0.5) as f32;
        }
        let noisy = value(compare(&before, &now).unwrap().e_warp) - value(exact);
        assert!((noisy / (0.01 / 12.0) - 1.0).abs() < 0.1, "{noisy}");
        let mut turned = before.clone();
        turned.view = eye(EYE_M, 2.0);
        let now = shoot(eye(EYE_M + DVec3::from(step_m), turned_px), scene, &[]);
        let wrong = value(compare(&turned, &now).unwrap().e_warp);
        assert!(wrong > 5.0 * value(exact), "{step_m:?}: {wrong}");
    }
}

#[test]
fn what_was_not_measured_is_null() {
    let lines = [Line::on_the_wall()];
    let drawn = shoot(eye(EYE_M, 0.0), SCENE, &lines);
    let plain = DrawnFrame { ink: None, strokes: None, ..drawn.clone() };
    let pair = compare(&plain, &drawn).unwrap();
    assert_eq!((pair.lines, pair.strokes.clone()), (None, None));
    assert_eq!(TemporalTotals::default().metrics(), None);
    let mut totals = TemporalTotals::default();
    totals.add(pair);
    let metrics = totals.metrics().unwrap();
    let measured: Vec<&str> =
        metrics.iter().filter(|(_, value)| value.is_some()).map(|(name, _)| name.as_str()).collect();
    assert_eq!(measured, ["e_warp", "pairs"]);
    let cut = DrawnFrame { luma: vec![0.0; 7], ..drawn.clone() };
    assert_eq!(compare(&drawn, &cut), Err(TemporalError::Size));
}

#[test]
fn totals_are_over_all_pairs() {
    let (wall, ground) = (Line::on_the_wall(), Line { along: [0.7, 1.0], ..Line::on_the_ground() });
    let mut totals = TemporalTotals::default();
    totals.add(pair(DVec3::ZERO, 0.0, &[wall], &[wall, ground]));
    totals.add(pair(DVec3::ZERO, 0.0, &[wall, ground], &[wall, ground]));
    totals.add(pair(DVec3::ZERO, 0.0, &[wall, ground], &[wall, ground]));
    let metrics = totals.metrics().unwrap();
    let of = |name: &str| metrics[name].unwrap();
    assert_eq!((of("pairs"), of("births_per_frame"), of("deaths_per_frame")), (3.0, 1.0 / 3.0, 0.0));
    assert_eq!((of("strokes_per_frame"), of("slip_px_p95"), of("identity_change")), (2.0, 0.0, 0.0));
    assert!(of("flicker_births") > 0.1 && of("flicker_births") < 0.33 && of("flicker_deaths") == 0.0);
    assert!((of("flicker") - 0.5 * of("flicker_births")).abs() < 1e-12);
}

#[test]
fn a_place_is_where_its_ray_went_through() {
    for view in [eye(EYE_M, 0.0), eye(EYE_M, 33.0)] {
        for place in [[0.0, 0.0], [17.3, 99.1], [239.0, 3.0], [-40.0, 500.0]].map(DVec2::from) {
            let ray = view.ray(place);
            assert!((view.place_px(ray * 123.0).unwrap() - place).length() < 1e-9);
            assert!((view.place_px(ray + 0.01 * view.pose.right).unwrap() - place).length() > 1.0);
            assert_eq!(view.place_px(-ray), None);
        }
    }
}

#[test]
fn a_real_drawing_is_measured() {
    // The same seed as the built-in world, at a smaller size.
    let grid = procedural::generate_sized(1, 512, 24.0, &Silent);
    let Some(mut world) = common::World::new(grid, 1.0) else { return };
    let size_px = [320, 180];
    let light =
        Light { to_sun: DVec3::new(-0.5, 0.5, 0.7).normalize(), haze_m: 30_000.0, haze_srgb: None, focus: None };
    for name in ["strokes", "lsa", "plain"] {
        let style = Style::load(name).unwrap();
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let mut draw = |world: &mut common::World, camera: &str| {
            let pose = world.pose(camera);
            let view = View::whole(pose, pose, size_px);
            renderer.render(&world.gpu, &mut world.surfaces, &view, &style, &light).unwrap();
            world.gpu.wait();
            let strokes = count_strokes(&world.gpu, &renderer, &style).unwrap();
            (read_drawn(&world.gpu, &renderer, &Rig::mono(view), 0, &style).unwrap(), strokes)
        };
        let (before, strokes) = draw(&mut world, "-300,-2500,+350,20,-6,60");
        let (now, _) = draw(&mut world, "-300,-2490,+350,20.1,-6,60");
        let (again, _) = draw(&mut world, "-300,-2490,+350,20.1,-6,60");
        let totals = |before: &DrawnFrame, now: &DrawnFrame| {
            let mut totals = TemporalTotals::default();
            totals.add(compare(before, now).unwrap());
            totals.metrics().unwrap()
        };
        let moved = totals(&before, &now);
        println!("{name}: {moved:?}");
        assert!(moved.values().flatten().all(|value| value.is_finite() && *value >= 0.0), "{moved:?}");
        assert!(moved["e_warp"].unwrap() > 0.0);
        assert_eq!(moved["flicker"].is_some(), name != "plain");
        assert_eq!((strokes.is_some(), moved["slip_px_p50"].is_some()), (name == "strokes", name == "strokes"));
        assert!(moved["line_coverage"].is_none_or(|coverage| coverage > 0.01 && coverage < 0.5), "{moved:?}");
        assert!(moved["flicker"].is_none_or(|flicker| flicker < 0.2), "{moved:?}");
        if name == "strokes" {
            let seen = now.strokes.as_ref().unwrap();
            let lines = now.ink.as_ref().unwrap().iter().zip(&seen.along_px).filter(|(ink, _)| **ink >= LINE_INK);
            // Every line pixel of a stroke has a parameter.
            let (known, all) =
                lines.fold((0, 0), |(known, all), (_, along)| (known + i32::from(along.is_finite()), all + 1));
            assert!(f64::from(known) > 0.99 * f64::from(all), "{known} of {all}");
            assert!(strokes.unwrap() as f64 >= moved["strokes_per_frame"].unwrap(), "{strokes:?}");
        }
        // The same view drawn twice has no changes. Planted: a line picture of a rotated previous frame.
        let same = totals(&now, &again);
        for changed in ["flicker", "flicker_ink", "births_per_frame", "deaths_per_frame", "slip_px_p95", "e_warp"] {
            // Strokes are matched with those of the previous frame, which causes rounding.
            let most = if name == "strokes" { 1e-3 } else { 0.0 };
            assert!(same[changed].is_none_or(|value| value <= most), "{name}: {changed} {:?}", same[changed]);
        }
        if name != "plain" {
            let view = View { pose: world.pose("-300,-2490,+350,22,-6,60"), ..now.view };
            let planted = totals(&DrawnFrame { view, origin_m: view.pose.position_m, ..before.clone() }, &now);
            assert!(planted["flicker"].unwrap() > 2.0 * moved["flicker"].unwrap(), "{planted:?}");
        }
    }
}
