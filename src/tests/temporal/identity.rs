//! Tests the identity of strokes and the parameter along them: slip of the parameter, and changes of identity.

use glam::{DVec2, DVec3};
use hachure::measure::temporal::{TemporalTotals, compare};

use crate::tests::temporal::{EYE_M, Line, SCENE, STEPS, eye, pair, shoot, slip_px, value};

#[test]
fn slip_is_the_motion_of_the_parameter() {
    let line = Line { along: [0.0, 1.3], ..Line::on_the_ground() };
    for (step_m, turned_px) in STEPS {
        let slipped = |by_px: f64| {
            let now = Line { along: [by_px, line.along[1]], ..line };
            slip_px(&pair(step_m.into(), turned_px, &[line], &[now]))[0]
        };
        // The ground's motion varies across the line.
        assert!(slipped(0.0) < 0.1, "{step_m:?}: {}", slipped(0.0));
        assert!((slipped(0.7) - 0.7).abs() < 0.1, "{step_m:?}: {}", slipped(0.7));
        assert!((slipped(-25.0) - 25.0).abs() < 0.5, "{step_m:?}: {}", slipped(-25.0));
    }
    // Motion of 0.3 px, with parameters fixed to the world, and, planted, fixed to the picture.
    let still = shoot(eye(EYE_M, 0.0), SCENE, &[line]);
    let mut moved = shoot(eye(EYE_M, 0.3), SCENE, &[line]);
    let slip = slip_px(&compare(&still, &moved).unwrap());
    assert!(slip[0] < 0.1 && slip[1] < 0.1, "{slip:?}");
    moved.strokes.as_mut().unwrap().along_px.clone_from(&still.strokes.as_ref().unwrap().along_px);
    let planted = slip_px(&compare(&still, &moved).unwrap());
    assert!(planted[0] > 0.2 && planted[0] < 0.5, "{planted:?}");
}

#[test]
fn another_identity_is_noticed() {
    let (line, other) = (Line::on_the_ground(), Line { id: 9, ..Line::on_the_ground() });
    let renamed = pair(DVec3::X, 0.0, &[line], &[other]);
    let strokes = renamed.strokes.as_ref().unwrap();
    assert_eq!((value(strokes.identity_change.unwrap()), value(strokes.born)), (1.0, 0.0));
    // Where identities do not last, their change is null, not 0.
    let [mut before, now] = [line, other].map(|line| shoot(eye(EYE_M, 0.0), SCENE, &[line]));
    before.strokes.as_mut().unwrap().identities_last = false;
    assert_eq!(compare(&before, &now).unwrap().strokes.unwrap().identity_change, None);
}

#[test]
fn strokes_side_by_side_are_told_apart() {
    // Distances so small that the nearest line pixel of the previous frame is often the other line's, and so large that
    // it never is.
    for (step_m, turned_px) in STEPS {
        for apart_px in [2.4, 7.0] {
            let line = Line::on_the_ground();
            let other = Line { id: 3, along: [90.0, 1.0], off_px: DVec2::new(0.0, apart_px), ..line };
            let of = |now: [Line; 2]| {
                let pair = pair(step_m.into(), turned_px, &[line, other], &now);
                let strokes = pair.strokes.as_ref().unwrap();
                // If no stroke keeps its identity, there is no slip.
                let slip = if strokes.slips_px.is_empty() { [f32::NAN; 2] } else { slip_px(&pair) };
                (slip, value(strokes.identity_change.unwrap()))
            };
            // Where the lines touch, one covers the fringe of the other.
            let (slip, changed) = of([line, other]);
            println!("{step_m:?}, {apart_px} px apart: slip {slip:?}, {changed:.4} changed");
            assert!(slip[0] < 0.1 && slip[1] < 1.0 && changed < 0.05, "{slip:?} {changed}");
            // Planted: the parameter moves.
            let slipped = [line, other].map(|of| Line { along: [of.along[0] + 5.0, 1.0], ..of });
            let (slip, changed) = of(slipped);
            assert!((slip[0] - 5.0).abs() < 0.2 && slip[1] > 4.0 && changed < 0.05, "{slip:?} {changed}");
            // Planted: the lines swap identities, and nothing else changes. Within reach of both lines it shows as
            // slip.
            let (slip, changed) = of([Line { id: other.id, ..line }, Line { id: line.id, ..other }]);
            assert!(changed > if apart_px > 5.0 { 0.99 } else { 0.3 }, "{changed}");
            assert!(apart_px > 5.0 || slip[0] > 50.0, "{slip:?}");
        }
    }
}

#[test]
fn turns_of_one_stroke_are_told_apart() {
    // Two parts of one stroke are side by side, with different parameters.
    let line = Line::on_the_ground();
    let turned = Line { along: [400.0, -1.0], off_px: DVec2::new(0.0, 2.4), ..line };
    for (step_m, turned_px) in STEPS {
        let of = |by_px: f64| {
            let now = [line, turned].map(|of| Line { along: [of.along[0] + by_px, of.along[1]], ..of });
            slip_px(&pair(step_m.into(), turned_px, &[line, turned], &now))
        };
        let (still, planted) = (of(0.0), of(20.0));
        assert!(still[0] < 0.1 && still[1] < 0.5, "{still:?}");
        assert!((planted[0] - 20.0).abs() < 0.5, "{planted:?}");
    }
}

#[test]
fn updates_are_distinguished_from_frames_between_them() {
    let (line, other) = (Line::on_the_ground(), Line { id: 9, ..Line::on_the_ground() });
    let frame = |lines: &[Line], rebuilt: bool| {
        let mut frame = shoot(eye(EYE_M, 0.0), SCENE, lines);
        frame.strokes.as_mut().unwrap().rebuilt = rebuilt;
        frame
    };
    let mut totals = TemporalTotals::default();
    totals.add(compare(&frame(&[line], true), &frame(&[line], false)).unwrap());
    let between = totals.metrics().unwrap();
    assert_eq!((between["flicker_between"], between["flicker_updates"]), (Some(0.0), None));
    totals.add(compare(&frame(&[line], false), &frame(&[other, Line::on_the_wall()], true)).unwrap());
    let metrics = totals.metrics().unwrap();
    let of = |name: &str| metrics[name].unwrap();
    assert_eq!((of("flicker_between"), of("identity_between"), of("identity_updates")), (0.0, 0.0, 1.0));
    assert!(of("flicker_updates") > 0.1, "{metrics:?}");
}
