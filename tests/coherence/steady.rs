//! How steady lines are that take over, against lines that are made anew.

use glam::DVec3;
use hachure::measure::report::Metrics;
use hachure::measure::temporal::{TemporalTotals, compare, read_drawn};
use hachure::scene::view::{Pose, Rig};
use hachure::style::{self, Style};

use crate::common::World;
use crate::{Flight, mountains, pose, strokes};

/// How steady a style's flight is, over so many frames after the first.
fn steadiness(world: &mut World, style: Style, poses: &[Pose]) -> Metrics {
    let mut flight = Flight::new(world, style);
    let mut totals = TemporalTotals::default();
    let mut before = None;
    for pose in poses {
        let (view, ..) = flight.draw(world, *pose);
        let now = read_drawn(&world.gpu, &flight.frame, &Rig::mono(view), 0, &flight.style).unwrap();
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
        // Planted: where nothing is taken over, it is noticed. (Slip is measured against the same stroke alone.)
        assert!(anew["identity_change"].unwrap() > 0.5);
    }
}
