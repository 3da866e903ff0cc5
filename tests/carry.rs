//! Strokes from frame to frame: they stay where they are, take over from those before, come and go along themselves,
//! and are never more than the budget allows.
#![allow(clippy::unwrap_used, reason = "a test fails by it")]

mod common;

use std::collections::HashMap;

use common::World;
use glam::{DVec2, DVec3, Vec2, Vec3};
use hachure::frame::{Frame, Light, Requirements};
use hachure::gpu::readback::read_as;
use hachure::lines::strokes::samples::{MOST_SAMPLES, SPACING_PX, Sample, SampleCounts};
use hachure::measure::report::Metrics;
use hachure::measure::temporal::{TemporalTotals, compare, read_drawn};
use hachure::source::{Silent, procedural};
use hachure::style::{self, Style};
use hachure::surface::view::{Part, Pose, View};

const SIZE_PX: [u32; 2] = [320, 180];
/// A slow flight: a metre and an eighth of a degree in a frame.
const START: &str = "-300,-2500,+350,20,-6,60";
const STEP_M: f64 = 1.0;

/// Mountains of the embedded world's kind, smaller.
fn mountains() -> Option<World> {
    World::new(procedural::generate_sized(1, 512, 24.0, &Silent), 1.0)
}

fn strokes(change: impl FnOnce(&mut style::Strokes)) -> Style {
    let mut style = Style::load("strokes").unwrap();
    change(style.strokes.as_mut().unwrap());
    style
}

fn light() -> Light {
    Light { to_sun: DVec3::Z, haze_m: 30_000.0, haze_srgb: None }
}

/// The pose of a frame of the flight.
fn pose(world: &World, frame: u32) -> Pose {
    let mut pose = world.pose(START);
    pose.position_m += DVec3::new(0.3, 1.0, 0.0).normalize() * (STEP_M * f64::from(frame));
    let turn = glam::DQuat::from_rotation_z(-0.125_f64.to_radians() * f64::from(frame));
    for axis in [&mut pose.forward, &mut pose.right, &mut pose.up] {
        *axis = turn * *axis;
    }
    pose
}

struct Flight {
    style: Style,
    frame: Frame,
    last: Option<View>,
}

impl Flight {
    fn new(world: &World, style: Style) -> Self {
        let frame = Frame::new(&world.gpu, Requirements::of(&style), SIZE_PX).unwrap();
        Self { style, frame, last: None }
    }

    /// A frame of the slow flight.
    fn fly(&mut self, world: &mut World, frame: u32) -> (View, SampleCounts, Vec<Sample>) {
        let pose = pose(world, frame);
        self.draw(world, pose)
    }

    fn draw(&mut self, world: &mut World, pose: Pose) -> (View, SampleCounts, Vec<Sample>) {
        let previous = self.last.map_or(pose, |last| last.pose);
        let view = View { pose, previous, picture_px: SIZE_PX, part: Part::whole(SIZE_PX) };
        self.last = Some(view);
        self.frame.render(&world.gpu, &mut world.terrain, &view, &self.style, &light());
        world.gpu.wait();
        world.gpu.check().unwrap();
        let (counts, samples) = self.frame.strokes().unwrap().samples().read(&world.gpu).unwrap();
        (view, counts, samples)
    }
}

/// How steady a style's flight is, over so many frames after the first.
fn steadiness(world: &mut World, style: Style, poses: &[Pose]) -> Metrics {
    let mut flight = Flight::new(world, style);
    let mut totals = TemporalTotals::default();
    let mut before = None;
    for pose in poses {
        let (view, ..) = flight.draw(world, *pose);
        let now = read_drawn(&world.gpu, &flight.frame, &view, &flight.style).unwrap();
        if let Some(before) = &before {
            totals.add(compare(before, &now).unwrap());
        }
        before = Some(now);
    }
    totals.metrics().unwrap()
}

/// The slow flight over mountains of ours, and one over a real one.
fn flights() -> Vec<(&'static str, World, Vec<Pose>)> {
    let mut flights = Vec::new();
    if let Some(world) = mountains() {
        let poses = (0..=40).map(|frame| pose(&world, frame)).collect();
        flights.push(("procedural", world, poses));
    }
    if let Some(world) = World::real("dem/geotiff/mt_rainier_90m.tif", 1.0) {
        let start = world.pose("-19800,30500,+500,0,3,50");
        let at = |frame: u32| {
            let moved = DVec3::new(0.3, 1.0, 0.0) * (1.3 * f64::from(frame));
            Pose { position_m: start.position_m + moved, ..start }
        };
        let poses = (0..=40).map(at).collect();
        flights.push(("Rainier", world, poses));
    }
    flights
}

#[test]
fn lines_that_take_over_are_four_times_as_still() {
    for (place, mut world, poses) in flights() {
        let mut fly = |name: &str, change: fn(&mut style::Strokes)| {
            let metrics = steadiness(&mut world, strokes(change), &poses);
            let of = |name: &str| metrics[name].unwrap();
            println!(
                "{place}, {name}: flicker {:.3} %, by ink {:.3} %, coverage {:.2} %, births {:.2}, deaths {:.2}, slip \
                 {:.3} px, identity {:.1} %, E_warp {:.5}",
                100.0 * of("flicker"),
                100.0 * of("flicker_ink"),
                100.0 * of("line_coverage"),
                of("births_per_frame"),
                of("deaths_per_frame"),
                of("slip_px_p50"),
                100.0 * of("identity_change"),
                of("e_warp")
            );
            metrics
        };
        let anew = fly("anew", |own| (own.update_every, own.carry) = (1, false));
        fly("thesis", |own| (own.update_every, own.carry) = (10, false));
        let each = fly("each frame", |own| own.update_every = 1);
        let ours = fly("default", |_| {});
        let ratio = |metrics: &Metrics, name: &str| metrics[name].unwrap() / anew[name].unwrap();
        for flicker in ["flicker", "flicker_ink"] {
            // Over smooth land hardly a pixel flickers, and its few cannot be held against each other.
            if anew[flicker].unwrap() > 1e-3 {
                assert!(ratio(&ours, flicker) <= 0.25, "{flicker}: {}", ratio(&ours, flicker));
                assert!(ratio(&each, flicker) <= 0.5, "{flicker}: {}", ratio(&each, flicker));
            }
        }
        for metrics in [&ours, &each] {
            assert!((0.9..=1.1).contains(&ratio(metrics, "line_coverage")), "{}", ratio(metrics, "line_coverage"));
            assert!(metrics["slip_px_p50"].unwrap() < 0.5 && metrics["identity_change"].unwrap() < 0.25);
        }
        // Planted: where nothing is taken over, it is noticed.
        assert!(anew["slip_px_p50"].unwrap() > 1.0 && anew["identity_change"].unwrap() > 0.5);
    }
}

/// Camera-relative metres on the picture of a view, by f64.
fn place_px(view: &View, at_m: [f32; 3]) -> DVec2 {
    view.place_px(Vec3::from(at_m).as_dvec3()).unwrap()
}

#[test]
fn between_updates_strokes_stick_to_the_world() {
    let Some(mut world) = mountains() else { return };
    let mut flight = Flight::new(&world, strokes(|_| {}));
    let (first, counts, samples) = flight.fly(&mut world, 0);
    assert!(counts.samples > 500 && counts.samples as usize == samples.len());
    for frame in 1..4 {
        let (view, now, moved) = flight.fly(&mut world, frame);
        assert_eq!(now, counts, "no update");
        let step_m = first.pose.position_m - view.pose.position_m;
        let far_px = |there: &dyn Fn(&Sample) -> DVec2| {
            let pairs = samples.iter().zip(&moved);
            pairs.map(|(old, new)| (there(old) - Vec2::from(new.px).as_dvec2()).length()).fold(0.0, f64::max)
        };
        // Lines of a first frame are not held by anything.
        let with_world = |old: &Sample| view.place_px(Vec3::from(old.position_m).as_dvec3() + step_m).unwrap();
        assert!(far_px(&with_world) < 0.05, "{}", far_px(&with_world));
        // Planted: with the picture.
        assert!(far_px(&|old| Vec2::from(old.px).as_dvec2()) > 0.4);
    }
}

#[test]
fn samples_are_where_they_say_and_evenly_apart() {
    let Some(mut world) = mountains() else { return };
    let mut flight = Flight::new(&world, strokes(|_| {}));
    for frame in 0..12 {
        let (view, counts, samples) = flight.fly(&mut world, frame);
        assert!(counts.fresh <= counts.samples && counts.strokes > 0);
        for pair in samples.windows(2).filter(|pair| pair[0].flags & Sample::LAST == 0) {
            assert!((place_px(&view, pair[0].position_m) - Vec2::from(pair[0].px).as_dvec2()).length() < 0.05);
            assert_eq!(pair[1].flags & Sample::FIRST, 0);
            // As far as they are held and moved, never farther.
            assert!(Vec2::from(pair[0].px).distance(Vec2::from(pair[1].px)) < SPACING_PX + 6.0);
        }
        let firsts = samples.iter().filter(|sample| sample.flags & Sample::FIRST != 0).count();
        let lasts = samples.iter().filter(|sample| sample.flags & Sample::LAST != 0).count();
        assert!(firsts == lasts && firsts >= counts.strokes as usize, "{firsts} {lasts} {counts:?}");
    }
}

#[test]
fn new_lines_grow_and_old_ones_shrink() {
    let Some(mut world) = mountains() else { return };
    let mut flight = Flight::new(&world, strokes(|own| own.update_every = 1));
    // A picture of its own is whole.
    let (_, _, samples) = flight.fly(&mut world, 0);
    assert!(samples.iter().all(|sample| sample.shown_px > 0.0));
    // What comes into view at the side, and what is not seen any more, takes its time.
    let (mut growing, mut fading) = (0, 0);
    for frame in 1..25 {
        let (_, _, samples) = flight.fly(&mut world, 4 * frame);
        growing += samples.iter().filter(|own| own.flags & Sample::FADING == 0 && own.shown_px <= 0.0).count();
        fading += samples.iter().filter(|own| own.flags & Sample::FADING != 0 && own.shown_px > 0.0).count();
    }
    assert!(growing > 50 && fading > 5, "{growing} {fading}");
    // At rest all of it ends.
    let rest = pose(&world, 96);
    let mut frames = 0;
    while flight.frame.is_settling() && frames < 200 {
        flight.draw(&mut world, rest);
        frames += 1;
    }
    let (_, _, samples) = flight.draw(&mut world, rest);
    assert!(frames > 10 && frames < 200, "{frames}");
    let hidden = samples.iter().filter(|own| own.shown_px <= 0.0 || own.flags & Sample::FADING != 0).count();
    // Under another stroke that lies on it, a stroke cannot find itself.
    assert!(hidden <= samples.len() / 100, "{hidden} of {}", samples.len());
}

#[test]
fn the_budget_leaves_out_the_shortest() {
    let Some(mut world) = mountains() else { return };
    let mut lengths = |budget_px: f32| {
        let mut flight = Flight::new(&world, strokes(|own| own.budget_px = budget_px));
        let (_, counts, samples) = flight.fly(&mut world, 0);
        let mut lengths: HashMap<u32, usize> = HashMap::new();
        samples.iter().for_each(|sample| *lengths.entry(sample.stroke).or_default() += 1);
        (counts, lengths)
    };
    let (all, every) = lengths(400_000.0);
    assert_eq!(all.left_out, 0);
    let (few, kept) = lengths(1000.0);
    assert!(few.samples <= 500 && few.samples > 250 && few.left_out > 0, "{few:?}");
    assert_eq!(few.strokes + few.left_out, all.strokes);
    // Those that are kept are the longest: to a quarter of an octave.
    let shortest = kept.values().min().unwrap();
    let longest_lost = every.iter().filter(|(stroke, _)| !kept.contains_key(stroke)).map(|(_, size)| size).max();
    assert!(*longest_lost.unwrap() as f64 <= *shortest as f64 * 1.3, "{longest_lost:?} {shortest}");
    // A budget for less than a single stroke cuts that one off.
    let (one, _) = lengths(100.0);
    assert!(one.samples <= 50 && one.samples > 1, "{one:?}");
}

#[test]
fn hands_stray_and_pens_widen_at_bends() {
    let Some(mut world) = mountains() else { return };
    let mut drawn = |change: fn(&mut style::Strokes)| {
        let mut flight = Flight::new(&world, strokes(change));
        flight.fly(&mut world, 0).2
    };
    let plain = drawn(|_| {});
    let apart = |samples: &[Sample]| -> Vec<f32> {
        let nearest = |own: &Sample| {
            plain.iter().map(|it| Vec2::from(it.px).distance(Vec2::from(own.px))).fold(f32::INFINITY, f32::min)
        };
        samples.iter().map(nearest).collect()
    };
    let mean = |values: &[f32]| values.iter().sum::<f32>() / values.len() as f32;
    let strayed = apart(&drawn(|own| own.wobble_px = 4.0));
    // As far as two octaves together reach, and half the way between samples.
    assert!(strayed.iter().all(|apart| *apart < 4.0 * 1.5 + 2.0), "{:?}", strayed.iter().copied().reduce(f32::max));
    assert!(mean(&strayed) > 0.6, "{}", mean(&strayed));
    // The same again, to the pixel: it is the place that says where the hand goes.
    let again = apart(&drawn(|own| own.wobble_px = 4.0));
    assert!((mean(&strayed) - mean(&again)).abs() < 1e-3);
    // Planted: a hand that does not stray.
    assert!(mean(&apart(&drawn(|_| {}))) < 0.01);

    let widths = |samples: &[Sample]| mean(&samples.iter().map(|own| own.half_width_px).collect::<Vec<_>>());
    let (wider, thinner) = (drawn(|own| own.curve_width = 1.0), drawn(|own| own.curve_width = -1.0));
    assert!(widths(&wider) > 1.01 * widths(&plain) && widths(&thinner) < 0.99 * widths(&plain));
    // Straight parts keep their width: most samples do.
    let same =
        wider.iter().filter(|own| plain.iter().any(|it| (it.half_width_px / own.half_width_px - 1.0).abs() < 0.01));
    assert!(same.count() > wider.len() / 2);
}

#[test]
fn extremes_are_finite() {
    let Some(mut world) = mountains() else { return };
    let cameras = [
        START,
        "-300,-2500,+350,20,-6,1",
        "-300,-2500,+350,20,-6,150",
        // In the midst of edges, below the ground, at the zenith, and where there is nothing.
        "0,0,+0.1,20,0,60",
        "0,0,-50,20,0,60",
        "0,0,+90000,20,-90,60",
        "0,0,+300,20,89,20",
    ];
    type Change = fn(&mut style::Strokes);
    let changes: [(&str, Change); 6] = [
        ("1 px", |own| own.width_px = 1.0),
        ("64 px", |own| (own.width_px, own.taper_px) = (64.0, 1000.0)),
        ("all of it", |own| (own.crease_deg, own.shortest_px, own.join_px) = (Some(0.0), 0.0, 16.0)),
        ("a quarter", |own| (own.resolution, own.fade_s, own.hold) = (0.25, 0.0, 1.0)),
        ("a shaky hand", |own| (own.wobble_px, own.curve_width) = (16.0, -1.0)),
        ("a texture", |own| own.texture = Some(Style::load("charcoal").unwrap().strokes.unwrap().texture.unwrap())),
    ];
    for (name, change) in changes {
        let mut flight = Flight::new(&world, strokes(change));
        let (mut most, mut empty) = (0, 0);
        for camera in cameras {
            let start = world.pose(camera);
            for step in 0..3 {
                let pose = Pose { position_m: start.position_m + DVec3::new(0.3, 0.1, 0.0) * f64::from(step), ..start };
                let (_, counts, samples) = flight.draw(&mut world, pose);
                assert!(counts.samples <= MOST_SAMPLES);
                most = most.max(counts.samples);
                empty += u32::from(counts.strokes == 0);
                for sample in &samples {
                    let numbers = [sample.pressure, sample.along_px, sample.half_width_px, sample.shown_px];
                    let all = sample.position_m.iter().chain(&sample.px).chain(&numbers).chain([&sample.depth_m]);
                    assert!(all.copied().all(f32::is_finite), "{name}, {camera}: {sample:?}");
                    assert!(sample.stroke != 0 && (0.0..=1.0).contains(&sample.pressure), "{sample:?}");
                }
                let ink = &flight.frame.targets().strokes.as_ref().unwrap().ink.ink;
                let ink: Vec<u16> = read_as(&world.gpu, ink, [0, 0], SIZE_PX).unwrap();
                let is_ink = |bits: u16| (0.0..=1.0).contains(&half::f16::from_bits(bits).to_f32());
                assert!(ink.into_iter().all(is_ink), "{name}, {camera}");
            }
        }
        assert!(most > 500 && empty > 0, "{name}: {most} samples at most, {empty} pictures without strokes");
    }
}
