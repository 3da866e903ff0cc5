//! Suggestive contours compared, pixel by pixel, with the zeros of the land's radial curvature: for closed forms, and
//! for real heights under a B-spline that is evaluated here.

use glam::{DVec2, DVec3};
use hachure::frame::Renderer;
use hachure::scene::view::{Pose, View};
use hachure::source::HeightGrid;
use hachure::style::Style;
use hachure::surface::edges::{EDGE_DRAW, EDGES, Edge, KIND_SUGGESTIVE};

use crate::tests::common::draw::{NOON, draw, places_m, still};
use crate::tests::common::{World, filled_grid, full, grid_of, real_data};
use crate::tests::curvature::{LANDS, RADIUS_M, bend, jet, style};
use crate::tests::helpers::stroke_lines::strokes_left;
use crate::tests::helpers::stroke_lines::{NEAR_PX, covered};

pub const SIZE_PX: [u32; 2] = [480, 320];
/// Approximate focal length, for the size of features in pixels.
const FOCAL_PX: f64 = 500.0;

/// The curvature along the direction to the eye, that direction, and the cosine between eye and normal.
struct Toward {
    curvature: f64,
    tangent: DVec3,
    facing: f64,
}

/// A function from a position on the map to height, slopes and second derivatives (xx, xy, yy).
type Bends<'a> = &'a dyn Fn(DVec2) -> (f64, DVec2, [f64; 3]);

fn toward(bends: Bends<'_>, map: DVec2, eye_m: DVec3) -> Toward {
    let jet = bends(map);
    let (height_m, slope, _) = jet;
    let normal = DVec3::new(-slope.x, -slope.y, 1.0).normalize();
    let to_eye = (eye_m - map.extend(height_m)).normalize();
    let facing = to_eye.dot(normal);
    let tangent = (to_eye - normal * facing).normalize();
    Toward { curvature: bend(&jet, tangent.truncate(), tangent.truncate()), tangent, facing }
}

/// Returns the points of the picture where the curvature toward the eye is zero and rises by at least `min_rise` over
/// a feature of `feature_m`. The cosine between land and eye is at most `largest_cosine`, and the foreshortened feature
/// has at least `min_px` pixels. `own` is the curvature of each pixel.
fn zeros(
    shape: &Shape<'_>,
    places_m: &[Option<DVec3>],
    own: &[Option<Toward>],
    eye_m: DVec3,
    min_rise: f64,
    largest_cosine: f64,
    min_px: f64,
) -> Vec<DVec2> {
    let &Shape { bends, feature_m, sign, .. } = shape;
    let [width, height] = SIZE_PX.map(|side| side as usize);
    let mut found = Vec::new();
    for pixel in 0..width * height {
        let [x, y] = [pixel % width, pixel / width];
        for (other, step, is_inside) in
            [(pixel + 1, DVec2::X, x + 1 < width), (pixel + width, DVec2::Y, y + 1 < height)]
        {
            if !is_inside {
                continue;
            }
            let (Some(a), Some(b)) = (&own[pixel], &own[other]) else { continue };
            if (a.curvature < 0.0) == (b.curvature < 0.0) {
                continue;
            }
            let (Some(place_a), Some(place_b)) = (places_m[pixel], places_m[other]) else { continue };
            // Pixels across a jump in depth are not neighbours on the land.
            if place_a.distance(place_b) > 0.05 * place_a.distance(eye_m) {
                continue;
            }
            let map = place_a.truncate();
            let step_m = 0.5 * feature_m * a.tangent.truncate();
            let [ahead, behind] = [step_m, -step_m].map(|step_m| toward(bends, map + step_m, eye_m).curvature);
            let rise = sign * (ahead - behind) / feature_m * feature_m * feature_m;
            let feature_px = FOCAL_PX * feature_m / place_a.distance(eye_m) * a.facing;
            if rise > min_rise && a.facing < largest_cosine && a.facing > 0.02 && feature_px >= min_px {
                let t = a.curvature / (a.curvature - b.curvature);
                found.push(DVec2::new(x as f64 + 0.5, y as f64 + 0.5) + t * step);
            }
        }
    }
    found
}

/// Returns points along the edges of a kind, half a pixel apart.
pub fn drawn(world: &World, renderer: &Renderer, view: &View, pose: Pose, kind: u32) -> Vec<DVec2> {
    let count = strokes_left::<u32>(&world.gpu, renderer, &EDGE_DRAW, 1)[0] as usize / 2;
    let edges: Vec<Edge> = strokes_left(&world.gpu, renderer, &EDGES, count);
    let on_picture = |at_m: [f32; 3]| {
        let at_m = DVec3::from(at_m.map(f64::from));
        let depth_m = at_m.dot(pose.forward);
        let [width, height] = SIZE_PX.map(f64::from);
        DVec2::new(at_m.dot(pose.right), -at_m.dot(pose.up)) * (view.focal_px() / depth_m)
            + DVec2::new(0.5 * width, 0.5 * height)
    };
    let mut along = Vec::new();
    for edge in edges.iter().filter(|edge| edge.kind & 0xff == kind) {
        let (a, b) = (on_picture(edge.a_m), on_picture(edge.b_m));
        let steps = (2.0 * a.distance(b)).ceil().max(1.0) as usize;
        along.extend((0..=steps).map(|step| a.lerp(b, step as f64 / steps as f64)));
    }
    along
}

struct Found {
    recall: f64,
    precision: f64,
    zeros: usize,
    drawn: usize,
}

/// The limits are sharp in the pass, so zeros within this factor of a limit count neither as missed nor as wrong.
const MARGIN: f64 = 1.5;

/// The shape to compare with: the land's derivatives, with features of `feature_m`.
struct Shape<'a> {
    bends: Bends<'a>,
    feature_m: f64,
    /// Smaller features, in pixels, are not compared.
    min_px: f64,
    /// With -1, lines are expected where the curvature falls toward the eye (a planted error).
    sign: f64,
}

/// A picture of the land that was read back: the places of its pixels and the points of its contours.
struct Seen {
    eye_m: DVec3,
    /// The position of each pixel, where the land's derivatives are known.
    places_m: Vec<Option<DVec3>>,
    /// Points along the suggestive contours.
    drawn: Vec<DVec2>,
}

/// Draws a picture, whose frame ends with the lines in the fast tier.
fn look(world: &mut World, camera: &str, style: &Style, is_known: impl Fn(DVec2) -> bool) -> Seen {
    let pose = world.pose(camera);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    renderer.set_only_strokes(!full());
    let view = still(pose, SIZE_PX);
    draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, style, &NOON);
    let mut places_m = places_m(&world.gpu, &renderer, pose.position_m);
    places_m.iter_mut().for_each(|place| *place = place.filter(|place_m| is_known(place_m.truncate())));
    let mut drawn = drawn(world, &renderer, &view, pose, KIND_SUGGESTIVE);
    let is_seen = |px: &DVec2| {
        let inside = px.cmpge(DVec2::ZERO).all() && px.x < f64::from(SIZE_PX[0]) && px.y < f64::from(SIZE_PX[1]);
        inside && places_m[px.y as usize * SIZE_PX[0] as usize + px.x as usize].is_some()
    };
    drawn.retain(is_seen);
    Seen { eye_m: pose.position_m, places_m, drawn }
}

/// Compares drawn contours with the zeros; `eye_off_m` moves the eye for which the zeros are computed (a planted
/// error).
fn compare(seen: &Seen, style: &Style, shape: &Shape<'_>, eye_off_m: DVec3) -> Found {
    let Seen { places_m, drawn, .. } = seen;
    let strokes = style.strokes().unwrap();
    let (rise, facing) = (f64::from(strokes.suggestive_rise), f64::from(strokes.suggestive_deg).to_radians().cos());
    let eye_m = seen.eye_m + eye_off_m;
    let own_of = |place_m: DVec3| toward(shape.bends, place_m.truncate(), eye_m);
    let own: Vec<Option<Toward>> = places_m.iter().map(|place| place.map(own_of)).collect();
    let sure = zeros(shape, places_m, &own, eye_m, rise * MARGIN, facing - 0.03, shape.min_px);
    let all = zeros(shape, places_m, &own, eye_m, rise / MARGIN, facing + 0.03, 0.0);
    Found { recall: covered(&sure, drawn), precision: covered(drawn, &all), zeros: sure.len(), drawn: drawn.len() }
}

#[test]
fn they_lie_where_the_radial_curvature_of_closed_forms_is_zero() {
    let spacing_m = 0.1 * RADIUS_M;
    let mut total = 0;
    // The saddles have few zeros or none.
    for land in LANDS.into_iter().filter(|land| full() || !land.name.contains("saddle")) {
        let samples = (8.0 * RADIUS_M / spacing_m) as u32 + 1;
        let height_m = |x_m: f64, y_m: f64| (land.height_m)(DVec2::new(x_m, y_m));
        let Some(mut world) = World::new(grid_of(samples, samples, spacing_m, height_m), 0.2) else { return };
        let mut style = style(1.0);
        let strokes = style.strokes_mut().unwrap();
        // Samples are close together here, so a feature rises little.
        (strokes.suggestive_rise, strokes.suggestive_deg) = (4e-4, 5.0);
        let bends = |map: DVec2| jet(land.height_m, map);
        let is_inside = |map: DVec2| map.abs().max_element() < 4.0 * RADIUS_M - 4.0 * spacing_m;
        let is_known = |map: DVec2| is_inside(map) && (land.principal)(map).is_some();
        let shape = Shape { bends: &bends, feature_m: spacing_m, min_px: 0.0, sign: 1.0 };
        for camera in ["150,-1500,500,3,-12,50", "-600,-1000,800,30,-25,55"] {
            let seen = look(&mut world, camera, &style, is_known);
            let Found { recall, precision, zeros, drawn } = compare(&seen, &style, &shape, DVec3::ZERO);
            total += zeros;
            println!(
                "{}, {camera}: {zeros} pixels of zeros, recall {:.1} %; {drawn} points drawn, precision {:.1} %",
                land.name,
                100.0 * recall,
                100.0 * precision
            );
            if land.name == "cylinder" {
                assert!(drawn == 0, "a cylinder is convex everywhere, and has {drawn} points of suggestive contours");
                continue;
            }
            assert!(
                recall >= 0.95 && precision >= 0.95,
                "{}: recall {recall}, precision {precision}, expected at least 0.95",
                land.name
            );
            // Planted error: the lines of an eye elsewhere.
            let planted = compare(&seen, &style, &shape, DVec3::new(400.0, 0.0, 200.0));
            assert!(zeros < 50 || planted.recall < 0.5 && planted.precision < 0.5, "{}", land.name);
        }
    }
    assert!(total > 400);
}

/// Returns height, slopes and second derivatives of a uniform cubic B-spline over the samples of a grid.
fn spline(grid: &HeightGrid, spacing_m: f64, map: DVec2) -> (f64, DVec2, [f64; 3]) {
    let half = DVec2::new(f64::from(grid.width - 1), f64::from(grid.height - 1)) * 0.5;
    let g = DVec2::new(map.x, -map.y) / spacing_m + half;
    let cell = g.floor();
    let f = g - cell;
    let weights = |f: f64| {
        let e = 1.0 - f;
        [
            [
                e.powi(3) / 6.0,
                (3.0 * f.powi(3) - 6.0 * f * f + 4.0) / 6.0,
                (3.0 * e.powi(3) - 6.0 * e * e + 4.0) / 6.0,
                f.powi(3) / 6.0,
            ],
            [-0.5 * e * e, 1.5 * f * f - 2.0 * f, -1.5 * e * e + 2.0 * e, 0.5 * f * f],
            [e, 3.0 * f - 2.0, 3.0 * e - 2.0, f],
        ]
    };
    let (x, y) = (weights(f.x), weights(f.y));
    let sum = |of_x: usize, of_y: usize| {
        let at =
            |cell: f64, offset: usize, most: u32| (cell + offset as f64 - 1.0).clamp(0.0, f64::from(most - 1)) as usize;
        let height_m = |row: usize, column: usize| {
            let index = at(cell.y, row, grid.height) * grid.width as usize + at(cell.x, column, grid.width);
            f64::from(grid.heights_m[index])
        };
        let of_row = |row: usize| x[of_x].iter().enumerate().map(|(i, weight)| weight * height_m(row, i)).sum::<f64>();
        y[of_y].iter().enumerate().map(|(row, weight)| weight * of_row(row)).sum::<f64>()
    };
    let by = 1.0 / spacing_m;
    // Rows run south.
    let slope = DVec2::new(sum(1, 0), -sum(0, 1)) * by;
    (sum(0, 0), slope, [sum(2, 0) * by * by, -sum(1, 1) * by * by, sum(0, 2) * by * by])
}

#[test]
fn they_lie_where_that_of_real_land_is_zero() {
    let views = [
        ("dem/geotiff/mt_rainier_90m.tif", "-8000,-12000,+900,30,-25,50"),
        ("dem/geotiff/mt_everest_90m.tif", "4000,-9000,+900,-15,-25,45"),
        ("dem/geotiff/N46E008_alps.tif", "0,0,+900,40,-25,50"),
    ];
    for (file, camera) in views.into_iter().take(if full() { 3 } else { 1 }) {
        let Some(path) = real_data(file) else { return };
        let real = filled_grid(&path);
        // The same heights on a flat map, where derivatives are known.
        let spacing_m = 90.0;
        let middle = [real.width / 2, real.height / 2];
        let [width, height] = [real.width, real.height].map(|side| side.min(600));
        let first = [middle[0] - width / 2, middle[1] - height / 2];
        let mut grid = grid_of(width, height, spacing_m, |_, _| 0.0);
        for row in 0..height {
            for column in 0..width {
                let from = (first[1] + row) as usize * real.width as usize + (first[0] + column) as usize;
                grid.heights_m[(row * width + column) as usize] = real.heights_m[from];
            }
        }
        let copy = grid.clone();
        let Some(mut world) = World::new(grid, 0.5) else { return };
        let style = style(1.0);
        let bends = |map: DVec2| spline(&copy, spacing_m, map);
        let shape = Shape { bends: &bends, feature_m: spacing_m, min_px: 10.0, sign: 1.0 };
        let seen = look(&mut world, camera, &style, |_| true);
        let Found { recall, precision, zeros, drawn } = compare(&seen, &style, &shape, DVec3::ZERO);
        println!(
            "{file}: {zeros} pixels of zeros, recall {:.1} % within {NEAR_PX} px; {drawn} points drawn, precision {:.1} %",
            100.0 * recall,
            100.0 * precision
        );
        let planted = compare(&seen, &style, &Shape { sign: -1.0, ..shape }, DVec3::ZERO);
        println!(
            "  planted error, zeros where the curvature falls: recall {:.1} %, precision {:.1} %",
            100.0 * planted.recall,
            100.0 * planted.precision
        );
        assert!(
            zeros > 400 && recall >= 0.95 && precision >= 0.95,
            "{file}: recall {recall}, precision {precision}, expected at least 0.95"
        );
        assert!(planted.recall < 0.5 && planted.precision < 0.5, "{file}: zeros where the curvature falls pass");
    }
}
