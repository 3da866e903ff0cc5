//! Tests that marks run where their style says: toward an azimuth, down the slope, along the contour lines of height.

use glam::{DVec2, DVec3};

use crate::tests::common::full;
use crate::tests::hatching::grain::{Land, Off, Window, between_deg};
use crate::tests::hatching::plane::style;
use hachure::style::Style;

/// Cameras that look from above, across and from near.
const CAMERAS: [&str; 4] =
    ["200,-250,1300,0,-90,50", "-900,-1300,900,35,-35,50", "150,-500,+220,340,-30,60", "-350,120,+60,80,-40,60"];

/// Returns the direction of marks on the map, given the gradient of the land.
type Wanted = fn(DVec2) -> DVec2;

const FIXED_DEG: f64 = 33.0;

/// On slopes less steep than this, directions that follow the land fall back to a fixed direction.
const LEVEL: f64 = 0.14;

/// Windows within which the direction changes by more than this are skipped.
const MAX_BEND_DEG: f64 = 20.0;

/// Returns the allowed deviation from the wanted direction, in degrees, at the median and at the 90th percentile.
/// Directions that follow the land have charts at every 11.25 degrees, a quarter of which is the deviation at the
/// median. Marks with ends have sides that point elsewhere.
fn allowed_deg(marks: &str, has_charts: bool) -> [f64; 2] {
    match (marks, has_charts) {
        ("line", false) => [1.0, 2.5],
        ("line", true) => [2.0, 5.0],
        _ => [3.0, 8.0],
    }
}

fn layer(marks: &str, direction: &str, angle_deg: f64) -> String {
    format!("[[hatching.layers]]\nmarks = \"{marks}\"\ndirection = \"{direction}\"\nangle_deg = {angle_deg}\n")
}

fn to_fixed(_: DVec2) -> DVec2 {
    DVec2::from_angle((90.0 - FIXED_DEG).to_radians())
}

fn windows(land: &mut Land, style: &Style) -> Vec<Window> {
    CAMERAS.iter().flat_map(|camera| land.shoot(camera, style).windows()).collect()
}

/// Returns the wanted tangent, rotated by `turn_deg`, or none where the land is level or bends much within the window.
fn wanted(land: &Land, window: &Window, to: Wanted, turn_deg: f64) -> Option<DVec3> {
    let tangent = |at_m: DVec3| {
        let rise = land.rise(at_m);
        let to = DVec2::from_angle(turn_deg.to_radians()).rotate(to(rise).normalize());
        (rise.length() > LEVEL).then(|| land.tangent(at_m, to))
    };
    let middle = tangent(window.place_m)?;
    let bends = |corner_m: &DVec3| tangent(*corner_m).is_none_or(|to| between_deg(to, middle) > MAX_BEND_DEG);
    (!window.corners_m.iter().any(bends)).then_some(middle)
}

/// Returns the scales and marks with which a test draws one of its directions: all, or in the fast tier one of them,
/// which depends on the number of the direction.
fn drawn_with(number: usize) -> impl Iterator<Item = (&'static str, &'static str)> {
    let all = [("blend", "line"), ("add", "hachure"), ("add", "line"), ("blend", "hachure")];
    all.into_iter().cycle().skip(number).take(if full() { all.len() } else { 1 })
}

#[test]
fn marks_run_where_the_style_says() {
    let Some(mut land) = Land::hill(1.0) else { return };
    let ways: [(&str, f64, Wanted); 5] = [
        ("fixed", FIXED_DEG, to_fixed),
        ("slope", 0.0, |rise| rise),
        ("contour", 0.0, |rise| rise.perp()),
        // Angles are clockwise, as azimuths are.
        ("slope", -40.0, |rise| DVec2::from_angle(40_f64.to_radians()).rotate(rise)),
        ("contour", 30.0, |rise| DVec2::from_angle(-30_f64.to_radians()).rotate(rise.perp())),
    ];
    for (number, (direction, angle_deg, to)) in ways.into_iter().enumerate() {
        for (scale, marks) in drawn_with(number) {
            let style = style(scale, 0.35, &layer(marks, direction, angle_deg));
            let windows = windows(&mut land, &style);
            let off = |to, turn_deg| Off::of(&windows, |window| wanted(&land, window, to, turn_deg));
            let right = off(to, 0.0);
            println!("{scale} {marks} {direction} {angle_deg}: {right:.2?}");
            let has_charts = direction == "slope" || angle_deg != 0.0 && direction != "fixed";
            let allowed_deg = allowed_deg(marks, has_charts);
            assert!(right.holds(allowed_deg), "{scale} {marks} {direction} {angle_deg}: directions deviate: {right:?}");
            for turn_deg in [20.0, -20.0, 10.0] {
                let planted = off(to, turn_deg);
                assert!(!planted.holds(allowed_deg), "a planted rotation of {turn_deg}° was not detected: {planted:?}");
            }
            let (fall, level): (Wanted, Wanted) = (|rise| rise, |rise| rise.perp());
            let swapped = off(if direction == "slope" { level } else { fall }, 0.0);
            assert!(
                !swapped.holds(allowed_deg),
                "{scale} {marks} {direction}: swapping fall and contour was not detected: {swapped:?}"
            );
        }
    }
}

/// Like [`allowed_deg`], for lines on a plane.
const STRAIGHT_DEG: [f64; 2] = [0.8, 1.5];

#[test]
fn lines_along_contours_are_straight_on_gentle_slopes() {
    for tilt_deg in [3.5_f64, 8.0, 20.0, 40.0] {
        let rise = DVec2::new(0.3, 0.954) * tilt_deg.to_radians().tan();
        let Some(mut land) = Land::new(321, 10.0, move |x, y| rise.dot(DVec2::new(x, y))) else { return };
        for scale in ["blend", "add"] {
            let shot = land.shoot("0,0,600,0,-80,50", &style(scale, 0.35, &layer("line", "contour", 0.0)));
            let off = Off::of(&shot.windows(), |window| Some(land.tangent(window.place_m, rise.perp())));
            println!("{scale} on {tilt_deg} degrees: {off:.2?}");
            assert!(off.holds(STRAIGHT_DEG), "{scale} on {tilt_deg} degrees: directions deviate: {off:?}");
            let askew = DVec2::from_angle(0.05).rotate(rise.perp());
            let planted = Off::of(&shot.windows(), |window| Some(land.tangent(window.place_m, askew)));
            assert!(!planted.holds(STRAIGHT_DEG), "a planted rotation of three degrees was not detected: {planted:?}");
        }
    }
}

/// Direction of the rulings of the folds, near an azimuth at which directions of lines wrap around.
const RULING: DVec2 = DVec2::new(0.087, 0.996);
const FOLD_M: f64 = 700.0;

/// On land that is folded along [`RULING`] and otherwise an inclined plane, the direction of least curvature is along
/// the rulings, which are straight.
#[test]
fn marks_follow_how_folds_bend() {
    let rise = DVec2::new(0.15, 0.2);
    let height_m = move |x: f64, y: f64| {
        let at_m = DVec2::new(x, y);
        rise.dot(at_m) + 0.08 * FOLD_M * (std::f64::consts::TAU / FOLD_M * RULING.perp_dot(at_m)).sin()
    };
    let Some(mut land) = Land::new(641, 10.0, height_m) else { return };
    let least: Wanted = |_| RULING;
    // At right angles to the rulings on the land, not on the map.
    let greatest: Wanted = |rise| rise.extend(-1.0).cross(RULING.extend(RULING.dot(rise))).truncate();
    // Between a crest and a hollow the curvature is 0.
    let is_bent = |window: &Window| {
        let phase = std::f64::consts::TAU / FOLD_M * RULING.perp_dot(window.place_m.truncate());
        phase.sin().abs() > 0.3
    };
    for (number, (angle_deg, to, other)) in [(0.0, greatest, least), (90.0, least, greatest)].into_iter().enumerate() {
        for (scale, marks) in drawn_with(number) {
            let style = style(scale, 0.35, &layer(marks, "curvature", angle_deg));
            // The last camera is left out: it is so near that the land looks flat to it.
            let windows: Vec<Window> =
                CAMERAS[..3].iter().flat_map(|camera| land.shoot(camera, &style).windows()).collect();
            let off = |to, turn_deg| {
                Off::of(&windows, |window| wanted(&land, window, to, turn_deg).filter(|_| is_bent(window)))
            };
            let right = off(to, 0.0);
            println!("{scale} {marks} by curvature, turned by {angle_deg}: {right:.2?}");
            // Charts are farther apart where the land is steep.
            let allowed_deg = allowed_deg(marks, true).map(|deg| 1.3 * deg);
            assert!(right.holds(allowed_deg), "{scale} {marks} {angle_deg}: directions deviate: {right:?}");
            for turn_deg in [20.0, -20.0, 10.0] {
                let planted = off(to, turn_deg);
                assert!(!planted.holds(allowed_deg), "a planted rotation of {turn_deg}° was not detected: {planted:?}");
            }
            let swapped = off(other, 0.0);
            assert!(
                !swapped.holds(allowed_deg),
                "{scale} {marks} {angle_deg}: swapping the two directions was not detected: {swapped:?}"
            );
            // Marks that ran down the slope would not follow the folds.
            let slope = off(|rise| rise, 0.0);
            assert!(
                !slope.holds(allowed_deg),
                "{scale} {marks} {angle_deg}: directions of the slope were not detected as wrong: {slope:?}"
            );
        }
    }
}
