//! Apparent ridges and valleys compared with the view-dependent curvature of closed forms, computed per pixel in f64.

use glam::{DMat2, DVec2, DVec3};
use hachure::frame::Renderer;
use hachure::surface::edges::{KIND_RIDGE, KIND_VALLEY};

use crate::tests::common::draw::{NOON, draw, places_m, still};
use crate::tests::common::{World, full, grid_of};
use crate::tests::curvature::suggestive::{SIZE_PX, drawn};
use crate::tests::curvature::{bend, jet};
use crate::tests::helpers::stroke_lines::covered;

/// A function from a position on the map to a height, in metres.
type Height = fn(DVec2) -> f64;

const SPACING_M: f64 = 20.0;
/// The least turn of the normal over a feature, in radians.
const MIN_BEND: f64 = 0.008;
/// The limits of the pass.
const MIN_FACING: f64 = 0.2;
const MAX_ACROSS: f64 = 0.7;

/// Returns the height of dunes whose crests wander and differ in height.
fn dunes_m(at: DVec2) -> f64 {
    90.0 * (at.x / 310.0 + 0.8 * (at.y / 900.0).sin()).sin() + 50.0 * (at.y / 430.0 + 0.4 * (at.x / 700.0).cos()).cos()
}

/// Returns the height of a crater: a ring-shaped rim.
fn crater_m(at: DVec2) -> f64 {
    260.0 * (-((at.length() - 600.0) / 320.0).powi(2)).exp() + 0.05 * at.x
}

/// The largest turn of the normal per step in the picture, positive where the surface is convex; the direction of that
/// step in the world, perpendicular to the line of sight; the step on the map; the cosine between normal and eye; and
/// the ratio of the least to the largest turn.
struct Apparent {
    turn: f64,
    on_picture: DVec3,
    step: DVec2,
    facing: f64,
    across: f64,
}

/// Computes this curvature by Judd, Durand and Adelson 2007, section 3. With `foreshortens` false, steps are taken on
/// the surface instead of in the picture (a planted error).
fn apparent(height_m: Height, map: DVec2, eye_m: DVec3, foreshortens: bool) -> Apparent {
    let jet = jet(height_m, map);
    let normal = DVec3::new(-jet.1.x, -jet.1.y, 1.0).normalize();
    let to_eye = (eye_m - map.extend(jet.0)).normalize();
    let facing = to_eye.dot(normal);
    // An orthonormal frame of the surface, one of the picture, and the projection between them.
    let u = DVec3::new(1.0, 0.0, jet.1.x).normalize();
    let v = normal.cross(u);
    let right = to_eye.cross(DVec3::Z).normalize();
    let up = right.cross(to_eye);
    let projection = DMat2::from_cols(DVec2::new(u.dot(right), u.dot(up)), DVec2::new(v.dot(right), v.dot(up)));
    let back = if foreshortens { projection.inverse() } else { DMat2::IDENTITY };
    let of = |a: DVec3, b: DVec3| bend(&jet, a.truncate(), b.truncate());
    let shape = DMat2::from_cols(DVec2::new(of(u, u), of(u, v)), DVec2::new(of(v, u), of(v, v)));
    let operator = shape * back;
    let square = operator.transpose() * operator;
    let (mean, half, cross) =
        (0.5 * (square.x_axis.x + square.y_axis.y), 0.5 * (square.x_axis.x - square.y_axis.y), square.x_axis.y);
    let angle = 0.5 * cross.atan2(half);
    let along = DVec2::from_angle(angle);
    let [turn, least] = [half.hypot(cross), -half.hypot(cross)].map(|root| (mean + root).max(0.0).sqrt());
    let step = back * along;
    let in_world = u * step.x + v * step.y;
    let sign = if of(in_world, in_world) >= 0.0 { 1.0 } else { -1.0 };
    let on_picture = if foreshortens { right * along.x + up * along.y } else { in_world };
    Apparent { turn: sign * turn, on_picture, step: in_world.truncate(), facing, across: least / turn }
}

/// The limits of what is drawn: the normal turns by at least `min_bend` over a feature, the cosine to the eye is at
/// least `min_facing`, and the turn across is at most a fraction `max_across` of the largest one.
#[derive(Clone, Copy)]
struct Bounds {
    min_bend: f64,
    min_facing: f64,
    max_across: f64,
}

/// Returns the points of the picture on crests of that curvature, in pixels; `side` −1 finds valleys.
fn crests(
    height_m: Height,
    places_m: &[Option<DVec3>],
    eye_m: DVec3,
    side: f64,
    bounds: Bounds,
    foreshortens: bool,
) -> Vec<DVec2> {
    let [width, height] = SIZE_PX.map(|side| side as usize);
    // The change of the curvature along its direction; its sign depends on the orientation of that direction.
    let look = |place_m: &DVec3| {
        let map = place_m.truncate();
        let own = apparent(height_m, map, eye_m, foreshortens);
        let step = own.step * 0.5;
        let [ahead, behind] = [step, -step].map(|step| apparent(height_m, map + step, eye_m, foreshortens).turn.abs());
        (own, ahead - behind)
    };
    let own: Vec<_> = places_m.iter().map(|place| place.as_ref().map(look)).collect();
    let mut found = Vec::new();
    for pixel in 0..width * height {
        let [x, y] = [pixel % width, pixel / width];
        for (other, step, is_inside) in
            [(pixel + 1, DVec2::X, x + 1 < width), (pixel + width, DVec2::Y, y + 1 < height)]
        {
            if !is_inside {
                continue;
            }
            let (Some((a, change_a)), Some((b, change_b))) = (&own[pixel], &own[other]) else { continue };
            let alike = a.on_picture.dot(b.on_picture);
            let change_b = change_b * alike.signum();
            if alike.abs() < 0.9 || (*change_a < 0.0) == (change_b < 0.0) {
                continue;
            }
            let (Some(place_a), Some(place_b)) = (places_m[pixel], places_m[other]) else { continue };
            if place_a.distance(place_b) > 0.05 * place_a.distance(eye_m) {
                continue;
            }
            // At a maximum the curvature falls along its direction.
            let falls = (change_b - change_a) * a.on_picture.dot(place_b - place_a) < 0.0;
            let is_asked = side * a.turn * SPACING_M >= bounds.min_bend
                && a.facing >= bounds.min_facing
                && a.across <= bounds.max_across;
            if falls && is_asked {
                let t = change_a / (change_a - change_b);
                found.push(DVec2::new(x as f64 + 0.5, y as f64 + 0.5) + t * step);
            }
        }
    }
    found
}

#[test]
fn apparent_ridges_are_crests_of_the_curvature_that_the_picture_shows() {
    for (name, height_m) in [("dunes", dunes_m as Height), ("crater", crater_m)] {
        let land = |x_m: f64, y_m: f64| height_m(DVec2::new(x_m, y_m));
        let Some(mut world) = World::new(grid_of(160, 160, SPACING_M, land), 0.2) else { return };
        let mut style = crate::tests::common::all_lines("strokes");
        style.set_water(None);
        let strokes = style.strokes_mut().unwrap();
        (strokes.ridge_px, strokes.ridge_bend, strokes.ridge_apparent) = (Some(1.0), MIN_BEND as f32, true);
        (strokes.ridge_width, strokes.valley_width) = (1.0, 1.0);
        // In the fast tier each land has one of the cameras.
        let cameras = ["0,-1500,900,0,-30,50", "-900,-1300,1300,35,-37,50"];
        for camera in cameras.into_iter().filter(|camera| full() || (*camera == cameras[0]) == (name == "dunes")) {
            let pose = world.pose(camera);
            let view = still(pose, SIZE_PX);
            let mut renderer = Renderer::new(&world.gpu).unwrap();
            draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, &style, &NOON);
            let found = [KIND_RIDGE, KIND_VALLEY].map(|kind| drawn(&world, &renderer, &view, pose, kind));
            let mut places_m = places_m(&world.gpu, &renderer, pose.position_m);
            let is_inside = |place_m: &DVec3| place_m.truncate().abs().max_element() < 70.0 * SPACING_M;
            places_m.iter_mut().for_each(|place| *place = place.filter(is_inside));
            let [width, height] = SIZE_PX;
            let is_known = |px: &DVec2| {
                let inside = px.cmpge(DVec2::splat(8.0)).all()
                    && px.x < f64::from(width) - 8.0
                    && px.y < f64::from(height) - 8.0;
                inside && places_m[px.y as usize * width as usize + px.x as usize].is_some()
            };
            // The limits are sharp in the pass, so points near a limit may be drawn or not.
            let bounds = |by: f64| Bounds {
                min_bend: MIN_BEND * by,
                min_facing: MIN_FACING * by,
                max_across: MAX_ACROSS / by.sqrt(),
            };
            let (sure, may_be) = (bounds(1.5), bounds(1.0 / 1.5));
            let at = |side: f64, bounds: Bounds, foreshortens: bool| -> Vec<DVec2> {
                let all = crests(height_m, &places_m, pose.position_m, side, bounds, foreshortens);
                all.into_iter().filter(is_known).collect()
            };
            for (side, kind, found) in [(1.0, "ridges", &found[0]), (-1.0, "valleys", &found[1])] {
                let found: Vec<DVec2> = found.iter().copied().filter(is_known).collect();
                let truth = at(side, sure, true);
                let (recall, precision) = (covered(&truth, &found), covered(&found, &at(side, may_be, true)));
                // Planted error: curvature measured on the surface.
                let planted = covered(&at(side, sure, false), &found);
                println!(
                    "{name}, {camera}, {kind}: {} points of truth, recall {:.1} %, precision {:.1} %; of crests on the \
                     surface {:.1} % are drawn",
                    truth.len(),
                    100.0 * recall,
                    100.0 * precision,
                    100.0 * planted
                );
                assert!(
                    truth.len() > 100 && recall >= 0.95 && precision >= 0.95,
                    "{name} {kind}: recall {recall}, precision {precision}, expected at least 0.95"
                );
                assert!(planted < 0.9, "{name} {kind}: crests on the surface pass as apparent ridges");
            }
            // Planted error: ridges in place of valleys.
            assert!(covered(&at(1.0, sure, true), &found[1]) < 0.3);
        }
    }
}
