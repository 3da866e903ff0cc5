//! Tests areas of files that are filled: with a tint or with hatching, where they are and nowhere else.
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use glam::DVec2;

use crate::tests::common;

use super::features_on_land::{Files, SIZE_PX, coordinates, geojson, ink_of, put, put_on, style, world};
use common::draw::{NOON, draw, places_m, still};
use common::{World, grid_of};
use hachure::frame::Renderer;
use hachure::lines::draped::FEATURE_INK;
use hachure::scene::view::View;
use hachure::style::Style;

/// From above, and along and across hills.
const CAMERAS: [&str; 3] = ["0,0,6000,0,-90,45", "1500,-2500,+350,20,-15,60", "-2500,500,+500,90,-15,60"];

/// A pixel: its ink, and the place that it sees.
struct Pixel {
    ink: f64,
    at_m: Option<DVec2>,
    distance_m: f64,
}

fn pixels(world: &mut World, view: &View, style: &Style) -> Vec<Pixel> {
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    draw(&world.gpu, &mut world.surfaces, &mut renderer, view, style, &NOON);
    let places = places_m(&world.gpu, &renderer, view.pose.position_m);
    let inks = match renderer.target(&FEATURE_INK) {
        Some(target) => ink_of(&world.gpu, target),
        None => vec![0.0; places.len()],
    };
    let pixel = |(ink, place_m): (f64, Option<glam::DVec3>)| {
        let distance_m = place_m.map_or(0.0, |place_m| place_m.distance(view.pose.position_m));
        Pixel { ink, at_m: place_m.map(|place_m| place_m.truncate()), distance_m }
    };
    inks.into_iter().zip(places).map(pixel).collect()
}

/// Returns a ring of many corners around a place.
fn star(middle_m: DVec2, radius_m: f64) -> Vec<DVec2> {
    let corner = |i: i32| {
        let angle = f64::from(i) / 150.0 * std::f64::consts::TAU;
        middle_m + DVec2::from_angle(angle) * radius_m * (1.0 + 0.2 * (7.0 * angle).sin())
    };
    (0..=150).map(corner).collect()
}

/// Returns whether a place is in a ring, and its distance from it.
fn in_ring(ring: &[DVec2], at_m: DVec2) -> (bool, f64) {
    let (mut is_inside, mut nearest_m) = (false, f64::INFINITY);
    for pair in ring.windows(2) {
        let [a, b] = [pair[0] - at_m, pair[1] - at_m];
        if (a.y <= 0.0) != (b.y <= 0.0) && a.x + (b.x - a.x) * a.y / (a.y - b.y) > 0.0 {
            is_inside = !is_inside;
        }
        let along = b - a;
        let part = (-a.dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
        nearest_m = nearest_m.min((a + along * part).length());
    }
    (is_inside, nearest_m)
}

/// Returns the parts of the pixels away from borders, and of those at borders, whose ink is not that of the rings: full
/// inside and none outside; and the number of both kinds.
fn wrong(pixels: &[Pixel], rings: &[Vec<DVec2>], view: &View, full_ink: f64) -> ([f64; 2], [usize; 2]) {
    let (mut wrong, mut count) = ([0_usize; 2], [0_usize; 2]);
    for pixel in pixels {
        let Some(at_m) = pixel.at_m else {
            assert_eq!(pixel.ink, 0.0, "the sky has ink");
            continue;
        };
        let of_rings = rings.iter().map(|ring| in_ring(ring, at_m));
        let (is_inside, nearest_m) =
            of_rings.fold((false, f64::INFINITY), |all, one| (all.0 != one.0, all.1.min(one.1)));
        let pixel_m = pixel.distance_m / view.focal_px();
        // On a slope that the eye grazes, a pixel is long.
        let is_border = nearest_m < 6.0 * pixel_m;
        let kind = usize::from(is_border);
        count[kind] += 1;
        let expected = if is_inside { full_ink } else { 0.0 };
        let is_wrong = match is_border {
            true => nearest_m > 0.75 * pixel_m && (pixel.ink - expected).abs() > 0.6 * full_ink,
            false => (pixel.ink - expected).abs() > 1e-3,
        };
        wrong[kind] += usize::from(is_wrong);
    }
    ([0, 1].map(|kind| wrong[kind] as f64 / count[kind].max(1) as f64), count)
}

#[test]
fn areas_are_filled_where_they_are() {
    let Some(mut world) = world() else { return };
    let files = Files::new();
    let [outer, hole] = [2300.0, 900.0].map(|radius_m| star(DVec2::new(200.0, -100.0), radius_m));
    // The hole has the direction of the outer ring, as some programs write it.
    let rings = format!("[{},{}]", coordinates(&outer), coordinates(&hole));
    let path = files.write("park.geojson", &geojson(&[("", "Polygon", rings)]));
    put(&mut world, &[&path]);
    let style = style("line_px = 0\nfill = 0.5");
    for camera in CAMERAS {
        let view = still(world.pose(camera), SIZE_PX);
        let pixels = pixels(&mut world, &view, &style);
        let rings = [outer.clone(), hole.clone()];
        let (parts, count) = wrong(&pixels, &rings, &view, 0.5);
        println!("{camera}: of {count:?} pixels away from borders and at them, {parts:.4?} are wrong");
        assert!(count[0] > 10_000 && count[1] > 500, "{count:?}");
        assert!(parts[0] < 5e-4 && parts[1] < 0.02, "{parts:?}");
        // Borders are smooth.
        let between = pixels.iter().filter(|pixel| pixel.ink > 0.05 && pixel.ink < 0.45).count();
        assert!(between > 200, "{between}");
        // Planted: the hole is filled; the area is two pixels away from where it should be.
        assert!(wrong(&pixels, &rings[..1], &view, 0.5).0[0] > 0.01);
        let shift_m = 2.0 * pixels[pixels.len() / 2 + 160].distance_m / view.focal_px();
        let shifted = rings.map(|ring| ring.iter().map(|at| *at + shift_m).collect());
        assert!(wrong(&pixels, &shifted, &view, 0.5).0[1] > 0.05);
    }
}

#[test]
fn layers_fill_the_areas_that_they_name() {
    let Some(mut world) = world() else { return };
    let files = Files::new();
    let square = |x_m: f64, half_m: f64| {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]];
        format!("[{}]", coordinates(&corners.map(|at| DVec2::new(x_m, 0.0) + half_m * DVec2::from_array(at))))
    };
    let areas = [
        ("\"kind\":\"park\"", "Polygon", square(-1500.0, 500.0)),
        ("\"kind\":\"lake\"", "Polygon", square(1500.0, 500.0)),
        // The land is inside of this one, far from its outline.
        ("\"kind\":\"country\"", "Polygon", square(0.0, 50_000.0)),
    ];
    let path = files.write("areas.geojson", &geojson(&areas));
    put(&mut world, &[&path]);
    let view = still(world.pose("0,0,9000,0,-90,50"), SIZE_PX);
    // The inks in the park, in the lake, and elsewhere.
    let inks = |world: &mut World, layer: &str| {
        let pixels = pixels(world, &view, &style(&format!("line_px = 0\n{layer}")));
        [DVec2::new(-1500.0, 0.0), DVec2::new(1500.0, 0.0), DVec2::new(0.0, 2500.0)].map(|place_m| {
            let near = |pixel: &&Pixel| pixel.at_m.is_some_and(|at_m| at_m.distance(place_m) < 200.0);
            let inks: Vec<f64> = pixels.iter().filter(near).map(|pixel| pixel.ink).collect();
            assert!(inks.len() > 10, "{}", inks.len());
            (inks.iter().sum::<f64>() / inks.len() as f64 * 100.0).round() / 100.0
        })
    };
    for (layer, expected) in [
        ("", [0.2; 3]),
        ("fill = 0.75", [0.75; 3]),
        ("fill = 0", [0.0; 3]),
        ("of = \"lines\"", [0.0; 3]),
        ("of = \"areas\"", [0.2; 3]),
        ("when = \"kind == 'park'\"", [0.2, 0.0, 0.0]),
        ("when = \"kind in ('park', 'lake')\"", [0.2, 0.2, 0.0]),
        ("when = \"kind == 'country'\"", [0.2; 3]),
        ("file = \"others\"", [0.0; 3]),
    ] {
        assert_eq!(inks(&mut world, layer), expected, "{layer}");
    }
}

#[test]
fn hatching_has_its_ink_and_direction_at_all_distances() {
    let Some(mut world) = World::new(grid_of(161, 161, 50.0, |_, _| 500.0), 0.2) else { return };
    let files = Files::new();
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]];
    let square = format!("[{}]", coordinates(&corners.map(|at| 3900.0 * DVec2::from_array(at))));
    let path = files.write("area.geojson", &geojson(&[("", "Polygon", square)]));
    put_on(&mut world, &[&path], 161, 50.0);
    for height_m in [900.0, 1100.0, 1500.0, 1900.0, 2600.0, 4100.0] {
        let view = still(world.pose(&format!("0,0,{height_m},0,-90,45")), SIZE_PX);
        for (fill, hatch_px) in [(0.15, 7.0), (0.5, 7.0), (0.8, 5.0), (0.25, 16.0)] {
            let layer = format!("line_px = 0\nfill = {fill}\nhatch_px = {hatch_px}\nhatch_deg = 0");
            let pixels = pixels(&mut world, &view, &style(&layer));
            let mean = pixels.iter().map(|pixel| pixel.ink).sum::<f64>() / pixels.len() as f64;
            // Lines run to the north: along a column ink stays, and along a row it changes.
            let difference = |step: usize| {
                let pairs = pixels.iter().zip(&pixels[step..]).map(|(a, b)| (a.ink - b.ink).abs());
                pairs.sum::<f64>() / pixels.len() as f64
            };
            let [across, along] = [difference(2), difference(SIZE_PX[0] as usize * 2)];
            println!(
                "from {height_m} m, {fill} at {hatch_px} px: {mean:.3} of the area is inked; {across:.3} and {along:.3}"
            );
            assert!((mean - fill).abs() < 0.03, "{mean}");
            assert!(along < 0.02 && across > 0.1, "{across} {along}");
            // Other directions are clockwise from north: to the north-east, and to the east.
            let turned = |azimuth_deg: u32, [x, y]: [i32; 2]| {
                let layer = layer.replace("hatch_deg = 0", &format!("hatch_deg = {azimuth_deg}"));
                let pixels = self::pixels(&mut world, &view, &style(&layer));
                let step = (y * SIZE_PX[0] as i32 + x).unsigned_abs() as usize;
                let pairs = pixels.iter().zip(&pixels[step..]).map(|(a, b)| (a.ink - b.ink).abs());
                pairs.sum::<f64>() / pixels.len() as f64
            };
            let mut turned = turned;
            if height_m == 1500.0 {
                assert!(turned(45, [2, -2]) < 0.03 && turned(45, [2, 2]) > 0.1 && turned(90, [2, 0]) < 0.02, "{layer}");
            }
            // Lines are about as far apart as asked.
            let row = &pixels[120 * 320..121 * 320];
            let begins =
                row.windows(2).filter(|pair| pair[0].ink < 0.3 * fill.max(0.5) && pair[1].ink >= 0.3 * fill.max(0.5));
            let apart_px = 320.0 / begins.count().max(1) as f64;
            assert!(apart_px > 0.45 * hatch_px && apart_px < 1.6 * hatch_px || fill > 0.7, "{apart_px}");
        }
    }
}

/// Areas of the size of the earth end near the land before their positions are converted to its projection, which puts
/// places on the other side of the earth anywhere.
#[test]
fn areas_as_large_as_the_earth_are_filled() {
    let Some(mut world) = world() else { return };
    let files = Files::new();
    let view = still(world.pose("0,0,9000,0,-90,50"), SIZE_PX);
    let mean = |pixels: &[Pixel]| {
        let land: Vec<f64> = pixels.iter().filter(|pixel| pixel.at_m.is_some()).map(|pixel| pixel.ink).collect();
        land.iter().sum::<f64>() / land.len() as f64
    };
    // The land is at 9 degrees east and 47 degrees north, and longitudes may have any turn.
    for (west, south, east, north, expected) in [
        (-180.0, -80.0, 180.0, 85.0, 0.5),
        (-180.0, -90.0, 180.0, 90.0, 0.5),
        (0.0, 0.0, 360.0, 85.0, 0.5),
        (300.0, 0.0, 400.0, 85.0, 0.5),
        (-170.0, -80.0, 8.0, 85.0, 0.0),
        (10.0, -80.0, 190.0, 85.0, 0.0),
        (-180.0, -80.0, 180.0, 46.0, 0.0),
    ] {
        let ring = [[west, south], [east, south], [east, north], [west, north], [west, south]];
        let text = format!("{{\"type\":\"Polygon\",\"coordinates\":[{ring:?}]}}");
        let path = files.write("large.geojson", &text);
        put(&mut world, &[&path]);
        let found = mean(&pixels(&mut world, &view, &style("line_px = 0\nfill = 0.5")));
        assert!((found - expected).abs() < 1e-3, "{west} to {east}, {south} to {north}: {found}");
    }
}
