//! Tests panoramas: the horizon is where the style places it, and the bent land remains the same land.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;

use common::draw::{NOON, draw, places_m, still};
use common::{World, grid_of};
use glam::{DVec2, DVec3};
use hachure::frame::Renderer;
use hachure::scene::view::Pose;
use hachure::style::{Panorama, Style};

const SIZE_PX: [u32; 2] = [160, 120];
/// A camera 10 km above level land that reaches 200 km far.
const CAMERA: &str = "0,0,10000,0,-15,60";

fn world() -> Option<World> {
    World::new(grid_of(1025, 1025, 400.0, |_, _| 0.0), 0.5)
}

/// Returns the point that each pixel shows, relative to the eye, in metres.
fn places(world: &mut World, pose: Pose, horizon_deg: f32) -> Vec<Option<DVec3>> {
    let style = Style { panorama: Panorama { horizon_deg }, ..Style::load("plain").unwrap() };
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    draw(&world.gpu, &mut world.surfaces, &mut renderer, &still(pose, SIZE_PX), &style, &NOON);
    places_m(&world.gpu, &renderer, pose.position_m).into_iter().map(|place| Some(place? - pose.position_m)).collect()
}

/// Returns how far below level the highest land in the middle column is, and the height of a pixel there, both in
/// degrees.
fn horizon_deg(pose: Pose, places: &[Option<DVec3>]) -> [f64; 2] {
    let view = still(pose, SIZE_PX);
    let [width, _] = SIZE_PX.map(|side| side as usize);
    let first = places.iter().skip(width / 2).step_by(width).position(Option::is_some).unwrap();
    let elevation_deg = |y: f64| {
        let ray = view.ray(DVec2::new((width / 2) as f64 + 0.5, y)).normalize();
        ray.z.asin().to_degrees()
    };
    // The border between the last pixel of sky and the first pixel of land.
    [-elevation_deg(first as f64), elevation_deg(first as f64) - elevation_deg(first as f64 + 1.0)]
}

#[test]
fn the_horizon_lies_where_it_is_asked_for() {
    let Some(mut world) = world() else { return };
    let pose = world.pose(CAMERA);
    for asked_deg in [8.0, 20.0, 30.0] {
        let places = places(&mut world, pose, asked_deg);
        let [found_deg, pixel_deg] = horizon_deg(pose, &places);
        println!("requested {asked_deg}°, measured {found_deg:.2}°, a pixel is {pixel_deg:.2}°");
        assert!((found_deg - f64::from(asked_deg)).abs() <= pixel_deg);
    }
    // Control: without bending, the land ends at its own horizon.
    let [flat_deg, pixel_deg] = horizon_deg(pose, &places(&mut world, pose, 0.0));
    assert!((flat_deg - 8.0).abs() > 5.0 * pixel_deg, "{flat_deg}");
}

#[test]
fn bent_land_is_the_same_land() {
    let Some(mut world) = world() else { return };
    let pose = world.pose(CAMERA);
    let places = places(&mut world, pose, 20.0);
    let bent = world.surfaces.terrain.earth_curvature(pose.position_m.z);
    let focal_px = still(pose, SIZE_PX).focal_px();
    // Computes the largest distance of points from level land, in pixels as seen from the eye.
    let off_px = |unbend: &dyn Fn(DVec3) -> DVec3| {
        let off_px = |place: &DVec3| (unbend(*place).z + pose.position_m.z).abs() / place.length() * focal_px;
        places.iter().flatten().map(off_px).fold(0.0, f64::max)
    };
    let worst_px = off_px(&|place| bent.unbend(place));
    println!("{worst_px:.3} px off level land at most");
    assert!(worst_px < 0.1);
    // Planted: points that are not bent back.
    assert!(off_px(&|place| place) > 5.0);
    // A map has no horizon, and the next picture is not bent.
    assert_eq!(Style::load("panorama").unwrap().for_map(1.0).unwrap().panorama.horizon_deg, 0.0);
    self::places(&mut world, pose, 0.0);
    assert_eq!(world.surfaces.terrain.earth_curvature(pose.position_m.z).inverse_radius, 0.0);
}
