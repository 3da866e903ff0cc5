//! Ridges and valleys compared with those of a ring of Gaussian profile, whose curvature along the radius is known.

use glam::{DVec2, DVec3};
use hachure::frame::Renderer;
use hachure::style::Style;
use hachure::surface::edges::{KIND_RIDGE, KIND_VALLEY};

use crate::tests::common::draw::{self, NOON, draw, still};
use crate::tests::common::{World, grid_of};
use crate::tests::curvature::suggestive::{SIZE_PX, drawn};
use crate::tests::helpers::stroke_lines::covered;

const RING_M: f64 = 700.0;
const WIDE_M: f64 = 200.0;
const SPACING_M: f64 = 12.0;

fn profile_m(away_m: f64) -> f64 {
    150.0 * (-((away_m - RING_M) / WIDE_M).powi(2)).exp()
}

/// Returns the curvature of the land across the ring; convex is positive.
fn bend(away_m: f64) -> f64 {
    let h = 0.01;
    let slope = (profile_m(away_m + h) - profile_m(away_m - h)) / (2.0 * h);
    let second = (profile_m(away_m + h) - 2.0 * profile_m(away_m) + profile_m(away_m - h)) / (h * h);
    -second / (1.0 + slope * slope).powf(1.5)
}

/// Returns the radii at which `value` has its maxima, in metres.
fn crests_m(value: impl Fn(f64) -> f64) -> Vec<f64> {
    let at_m = |i: u32| 300.0 + 0.1 * f64::from(i);
    let is_crest = |i: &u32| {
        let [before, own, after] = [i - 1, *i, i + 1].map(|i| value(at_m(i)));
        own > before && own >= after && own > 5e-4
    };
    (1..8000).filter(is_crest).map(at_m).collect()
}

fn circle(away_m: f64) -> impl Iterator<Item = DVec3> {
    let angles = (0..2000).map(|i| std::f64::consts::TAU * f64::from(i) / 2000.0);
    angles.map(move |angle| (DVec2::from_angle(angle) * away_m).extend(profile_m(away_m)))
}

fn style(change: impl Fn(&mut hachure::style::Strokes)) -> Style {
    let mut style = crate::tests::common::all_lines("strokes");
    style.set_water(None);
    let strokes = style.strokes_mut().unwrap();
    (strokes.ridge_px, strokes.ridge_bend) = (Some(1.0), 0.02);
    (strokes.ridge_width, strokes.valley_width) = (1.0, 1.0);
    change(strokes);
    style
}

#[test]
fn crests_of_curvature_are_ridges_and_valleys() {
    let land = |x_m: f64, y_m: f64| profile_m(x_m.hypot(y_m));
    let Some(mut world) = World::new(grid_of(180, 180, SPACING_M, land), 0.2) else { return };
    // Views from above and at an angle, in which the near half hides nothing.
    for camera in ["0,0,2600,0,-90,45", "0,-900,1900,0,-62,60"] {
        let pose = world.pose(camera);
        let view = still(pose, SIZE_PX);
        let mut edges = |style: &Style| {
            let mut renderer = Renderer::new(&world.gpu).unwrap();
            draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, style, &NOON);
            let places_m = draw::places_m(&world.gpu, &renderer, pose.position_m);
            ([KIND_RIDGE, KIND_VALLEY].map(|kind| drawn(&world, &renderer, &view, pose, kind)), places_m)
        };
        let (found, places_m) = edges(&style(|_| {}));
        let on_picture = |at_m: DVec3| {
            let from_eye_m = at_m - pose.position_m;
            let depth_m = from_eye_m.dot(pose.forward);
            let [width, height] = SIZE_PX.map(f64::from);
            let px = DVec2::new(from_eye_m.dot(pose.right), -from_eye_m.dot(pose.up)) * (view.focal_px() / depth_m)
                + DVec2::new(0.5 * width, 0.5 * height);
            // Away from the picture's border, where cells end.
            let is_inside = px.cmpge(DVec2::splat(6.0)).all() && px.x < width - 6.0 && px.y < height - 6.0;
            let seen = is_inside.then(|| places_m[px.y as usize * SIZE_PX[0] as usize + px.x as usize])??;
            // Points behind the ring are not visible.
            (seen.distance(at_m) < 40.0).then_some(px)
        };
        let expected = [crests_m(bend), crests_m(|away_m| -bend(away_m))];
        assert_eq!(expected.each_ref().map(Vec::len), [1, 2]);
        let truth =
            expected.map(|radii_m| radii_m.into_iter().flat_map(circle).filter_map(on_picture).collect::<Vec<_>>());
        for (name, truth, found) in [("ridges", &truth[0], &found[0]), ("valleys", &truth[1], &found[1])] {
            let (recall, precision) = (covered(truth, found), covered(found, truth));
            println!("{camera}, {name}: recall {:.1} %, precision {:.1} %", 100.0 * recall, 100.0 * precision);
            assert!(
                truth.len() > 500 && recall >= 0.95 && precision >= 0.95,
                "{name}: recall {recall}, precision {precision}, expected at least 0.95"
            );
        }
        // Planted errors: ridges in place of valleys, and a least turn that the land reaches nowhere.
        assert!(covered(&truth[0], &found[1]) < 0.2 && covered(&truth[1], &found[0]) < 0.2);
        assert!(edges(&style(|strokes| strokes.ridge_bend = 2.0)).0.iter().all(Vec::is_empty));
        // A width of 0 turns valleys off.
        assert!(edges(&style(|strokes| strokes.valley_width = 0.0)).0[1].is_empty());
    }
}
