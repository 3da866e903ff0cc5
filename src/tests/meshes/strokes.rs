//! Tests that strokes follow the visible contours of models, all of them and nothing else.
//!
//! The truth is exact: the contour of a ball is a circle, and the hill that hides parts of it is a formula.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use hachure::frame::Renderer;
use hachure::lines::strokes::COUNTS;
use hachure::lines::strokes::StrokeCounts;
use hachure::lines::strokes::points::POINTS;
use hachure::lines::strokes::points::Point;
use hachure::scene::view::View;
use hachure::style::Style;

use crate::tests::common::draw::{NOON, draw, still};
use crate::tests::common::hill::Hill;
use crate::tests::common::{World, all_lines, full};
use crate::tests::helpers::stroke_lines::{NEAR_PX, along_strokes, covered, missed, strokes_left};
use crate::tests::helpers::styles::of_outlines;
use crate::tests::meshes::shapes;

const SIZE_PX: [u32; 2] = [960, 540];
const HALF_M: DVec2 = DVec2::splat(1600.0);

fn strokes(world: &mut World, camera: &str) -> (View, Vec<Point>) {
    let mut style = of_outlines(all_lines("strokes"));
    style.strokes_mut().unwrap().borders = false;
    strokes_of(world, camera, &style, SIZE_PX)
}

fn strokes_of(world: &mut World, camera: &str, style: &Style, size_px: [u32; 2]) -> (View, Vec<Point>) {
    let view = still(world.pose(camera), size_px);
    let gpu = &world.gpu;
    let mut renderer = Renderer::new(gpu).unwrap();
    draw(gpu, &mut world.surfaces, &mut renderer, &view, style, &NOON);
    let counts: StrokeCounts = strokes_left(gpu, &renderer, &COUNTS, 1)[0];
    (view, strokes_left(gpu, &renderer, &POINTS, counts.points as usize))
}

fn is_inside(px: &DVec2) -> bool {
    px.cmpge(DVec2::ZERO).all() && px.x < f64::from(SIZE_PX[0]) && px.y < f64::from(SIZE_PX[1])
}

/// Returns points on the visible contour of a ball, at even angles, about five per pixel.
fn contour(hill: &Hill, view: &View, middle_m: DVec3, radius_m: f64) -> Vec<DVec2> {
    let eye_m = view.pose.position_m;
    let to_middle = middle_m - eye_m;
    let away_m = to_middle.length();
    let axis = to_middle / away_m;
    // The circle at which rays touch the ball.
    let sine = radius_m / away_m;
    let ring_m = eye_m + axis * (away_m * (1.0 - sine * sine));
    let ring_radius_m = radius_m * (1.0 - sine * sine).sqrt();
    let (right, up) = axis.any_orthonormal_pair();
    (0..20_000)
        .filter_map(|i| {
            let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / 20_000.0).sin_cos();
            let way = ring_m + (right * cos + up * sin) * ring_radius_m - eye_m;
            let hit = hill.hit(eye_m, way, HALF_M);
            view.place_px(way).filter(|px| is_inside(px) && hit.is_none_or(|hit| hit > 1.0))
        })
        .collect()
}

/// Cameras, and radii of a ball on the hill, a third of which is in the ground: seen from above, from the side, from
/// afar and from behind the hill.
const EYES: [(&str, f64); 4] = [
    ("-500,-900,+150,28,-22,50", 40.0),
    ("-330,-720,+4,0,3,40", 25.0),
    ("-1400,-1300,+500,42,-22,30", 60.0),
    ("250,-900,+30,320,4,45", 60.0),
];

fn ball(hill: &Hill, radius_m: f64) -> DVec3 {
    let (x_m, y_m) = (-300.0, -500.0);
    DVec3::new(x_m, y_m, hill.height_m(x_m, y_m) + 0.33 * radius_m)
}

#[test]
fn the_visible_contour_of_a_ball_is_drawn_and_nothing_else() {
    let Some((hill, mut world)) = shapes::hill() else { return };
    let mesh = Arc::new(shapes::mesh(shapes::sphere(5)));
    let mut all = Vec::new();
    // The fast tier has the eye behind the hill.
    for (camera, radius_m) in EYES.into_iter().skip(if full() { 0 } else { 3 }) {
        let middle_m = ball(&hill, radius_m);
        world.surfaces.set_meshes(Default::default());
        let land = along_strokes(&strokes(&mut world, camera).1, SIZE_PX);
        shapes::place(&mut world, &mesh, &shapes::stance(middle_m, 0.0, radius_m));
        let (view, points) = strokes(&mut world, camera);
        let truth = contour(&hill, &view, middle_m, radius_m);
        let drawn = along_strokes(&points, SIZE_PX);
        // Strokes of the land itself do not count.
        let own = missed(&drawn, &land, NEAR_PX);
        let (recall, precision) = (covered(&truth, &drawn), covered(&own, &truth));
        println!(
            "{camera}: recall {recall:.4}, precision {precision:.4}, {} places, {} of strokes",
            truth.len(),
            own.len()
        );
        assert!(truth.len() > 2000 && own.len() > 500);
        all.push((recall, precision));
        // Planted: strokes moved by 5 px, and only half of the strokes.
        let astray: Vec<DVec2> = own.iter().map(|px| *px + DVec2::new(0.0, 5.0)).collect();
        assert!(covered(&truth, &astray) < 0.9 && covered(&astray, &truth) < 0.9);
        assert!(covered(&truth, &own[..own.len() / 2]) < 0.9);
        // Planted: the contour of a slightly larger ball.
        let larger = contour(&hill, &view, middle_m, 1.05 * radius_m);
        assert!(covered(&larger, &drawn) < 0.98);
    }
    assert!(all.iter().all(|(recall, precision)| *recall >= 0.98 && *precision >= 0.98), "{all:?}");
}

#[test]
fn a_crease_in_a_corner_is_drawn_where_a_style_wants_it() {
    let Some((_, mut world)) = shapes::hill() else { return };
    // Two walls of 20 m that meet in a corner, high above the land, seen obliquely from inside.
    let text = "v -20 -20 0\nv 0 0 0\nv 20 -20 0\nv -20 -20 20\nv 0 0 20\nv 20 -20 20\nf 1 2 5 4\nf 2 3 6 5\n";
    let mesh = Arc::new(hachure::mesh::obj::parse("corner.obj".to_owned(), text.as_bytes()).unwrap());
    let pose = world.pose("0,0,3000,20,40,40");
    let foot_m = pose.position_m + pose.forward * 80.0;
    shapes::place(&mut world, &mesh, &shapes::stance(foot_m, 30.0, 1.0));
    let size_px = if full() { SIZE_PX } else { SIZE_PX.map(|side| side / 2) };
    let crease = |world: &mut World, crease_deg: Option<f32>| {
        let mut style = of_outlines(all_lines("strokes"));
        style.strokes_mut().unwrap().crease_deg = crease_deg;
        let (view, points) = strokes_of(world, "0,0,3000,20,40,40", &style, size_px);
        let ends = [0.0, 20.0].map(|z| view.place_px(foot_m + DVec3::Z * z - pose.position_m).unwrap());
        let truth: Vec<DVec2> = (0..=400).map(|i| ends[0].lerp(ends[1], f64::from(i) / 400.0)).collect();
        covered(&truth, &along_strokes(&points, size_px))
    };
    let drawn = crease(&mut world, Some(60.0));
    println!("{drawn:.3} of the crease");
    assert!(drawn >= 0.98, "{drawn}");
    // Planted: a style that draws only sharper creases, and one that draws none.
    assert!(crease(&mut world, Some(100.0)) < 0.2 && crease(&mut world, None) < 0.2);
}
