//! The steadiness of carried strokes, compared with strokes that are rebuilt in every frame.

use glam::DVec3;
use hachure::measure::report::Metrics;
use hachure::measure::temporal::{DrawnFrame, TemporalTotals, compare, read_drawn};
use hachure::scene::view::{Pose, Rig};
use hachure::style::{self, Style};

use crate::tests::coherence::sheet::turned;
use crate::tests::coherence::{Flight, SIZE_PX, mountains, pose, strokes};
use crate::tests::common::{World, full};

/// Largest fraction of the line that may flicker in a turn of 30 degrees per second.
const MAX_FLICKER: f64 = 5e-4;

/// Measures how steady a style is along `poses`.
fn steadiness(world: &mut World, style: Style, poses: &[Pose]) -> Metrics {
    steadiness_of(world, style, poses, |_, _| ())
}

/// Measures the same, with each frame passed through `change` after it is drawn.
fn steadiness_of(world: &mut World, style: Style, poses: &[Pose], change: impl Fn(usize, &mut DrawnFrame)) -> Metrics {
    let mut flight = Flight::new(world, style);
    // What is measured includes the picture.
    flight.renderer.set_only_strokes(false);
    let mut totals = TemporalTotals::default();
    let mut before = None;
    for (frame, pose) in poses.iter().enumerate() {
        let (view, ..) = flight.draw(world, *pose);
        let mut now = read_drawn(&world.gpu, &flight.renderer, &Rig::mono(view), 0, &flight.style).unwrap();
        change(frame, &mut now);
        if let Some(before) = &before {
            totals.add(compare(before, &now).unwrap());
        }
        before = Some(now);
    }
    totals.metrics().unwrap()
}

/// Returns the slow flight over procedural mountains, and one over a real mountain.
fn flights() -> Vec<(&'static str, World, Vec<Pose>)> {
    let mut flights = Vec::new();
    let frames = if full() { 40 } else { 16 };
    if let Some(world) = mountains() {
        let poses = (0..=frames).map(|frame| pose(&world, frame)).collect();
        flights.push(("procedural", world, poses));
    }
    if let Some(world) = World::real("dem/geotiff/mt_rainier_90m.tif", 1.0) {
        let start = world.pose("-19800,30500,+500,0,3,50");
        let at = |frame: u32| {
            let moved = DVec3::new(0.3, 1.0, 0.0) * (1.3 * f64::from(frame));
            Pose { position_m: start.position_m + moved, ..start }
        };
        let poses = (0..=frames).map(at).collect();
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
        let rebuilt = fly("rebuilt", |own| (own.update_every, own.carry) = (1, false));
        if full() {
            fly("thesis", |own| (own.update_every, own.carry) = (10, false));
        }
        let each = fly("each frame", |own| own.update_every = 1);
        let ours = fly("default", |_| {});
        let ratio = |metrics: &Metrics, name: &str| metrics[name].unwrap() / rebuilt[name].unwrap();
        for flicker in ["flicker", "flicker_ink"] {
            // Over smooth land hardly any pixel flickers, and so few cannot be compared.
            if rebuilt[flicker].unwrap() > 1e-3 {
                assert!(ratio(&ours, flicker) <= 0.25, "{flicker}: {}", ratio(&ours, flicker));
                assert!(ratio(&each, flicker) <= 0.5, "{flicker}: {}", ratio(&each, flicker));
            }
        }
        for metrics in [&ours, &each] {
            assert!((0.9..=1.1).contains(&ratio(metrics, "line_coverage")), "{}", ratio(metrics, "line_coverage"));
            assert!(metrics["slip_px_p50"].unwrap() < 0.5 && metrics["identity_change"].unwrap() < 0.25);
        }
        // Planted error: strokes without carry-over are noticed. (Slip is measured against the same stroke alone.)
        assert!(rebuilt["identity_change"].unwrap() > 0.5);
    }
}

#[test]
fn a_turn_brings_its_strokes_with_it() {
    let Some(mut world) = mountains() else { return };
    let poses: Vec<Pose> = (0..=if full() { 30 } else { 10 }).map(|frame| turned(&world, frame)).collect();
    let mut flickers = |poses: &[Pose], change: &dyn Fn(usize, &mut DrawnFrame)| {
        let metrics = steadiness_of(&mut world, strokes(|_| {}), poses, change);
        let [all, coverage] = ["flicker", "line_coverage"].map(|name| metrics[name].unwrap());
        println!("in a turn {:.4} % of the line flickers, coverage {:.2} %", 100.0 * all, 100.0 * coverage);
        assert!(coverage > 0.01, "{coverage}");
        all
    };
    let is_still = |flicker: f64| flicker <= MAX_FLICKER;
    assert!(is_still(flickers(&poses, &|_, _| ())));
    // Planted error: in every second frame the land that has entered the picture has no strokes yet.
    let width = SIZE_PX[0] as usize;
    let late = |frame: usize, drawn: &mut DrawnFrame| {
        if frame % 2 == 1 {
            drawn.ink.as_mut().unwrap().chunks_mut(width).for_each(|row| row[width - 6..].fill(0.0));
        }
    };
    let few = if full() { poses.len() } else { 4 };
    assert!(!is_still(flickers(&poses[..few], &late)));
}
