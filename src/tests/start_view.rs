//! The camera that hachure chooses for a world without one, over lands whose summits are known.

use glam::{DVec2, DVec3};
use hachure::gpu::Gpu;
use hachure::scene::camera::Camera;
use hachure::scene::look::StandPoint;
use hachure::scene::view::View;
use hachure::tiles::terrain::TerrainOptions;
use hachure::world::OpenWorld;

use super::common::{full, gpu};

/// Samples along each side of the lands, and their distance in metres.
const SIDE: u32 = 401;
const SPACING_M: f64 = 30.0;
const ASPECT: f64 = 16.0 / 9.0;
/// Size of the picture whose rays are followed.
const SIZE_PX: [u32; 2] = [96, 54];

type Land = fn(f64, f64) -> f64;

/// The contents of a camera's view, measured by following the ray of each pixel over the land's own function.
#[derive(Debug)]
struct Shown {
    /// Part of the picture without land.
    empty: f64,
    /// Part of the picture in which a ray that points well below the horizon meets no land.
    hole: f64,
    /// Where the summit is in the picture, as parts of its width and height.
    summit: DVec2,
    is_summit_seen: bool,
    /// Part of the picture's height above the horizon.
    horizon: f64,
    /// Angle between the sun and the direction of view, in degrees.
    side_deg: f64,
    /// Part of the picture with land that rises by less than a fiftieth.
    level: f64,
}

/// A land with the place that the start view must show, by default the highest one.
struct Known {
    name: &'static str,
    land: Land,
    place_m: Option<DVec3>,
    /// Largest part of the picture that level land may fill.
    most_level: f64,
}

impl Known {
    const fn new(name: &'static str, land: Land) -> Self {
        Self { name, land, place_m: None, most_level: 1.0 }
    }
}

fn cone(x: f64, y: f64) -> f64 {
    200.0 + (1400.0 - 0.45 * (x - 2100.0).hypot(y + 1500.0)).max(0.02 * (x + y).sin())
}

fn ridge(x: f64, y: f64) -> f64 {
    let along = 0.8 * x + 0.6 * y;
    let across = 0.6 * x - 0.8 * y + 900.0;
    1500.0 - 0.4 * across.abs() - 0.05 * (along - 700.0).abs() + 60.0 * (along / 500.0).sin()
}

fn plateau(x: f64, y: f64) -> f64 {
    800.0 - (x + 1000.0).hypot(y - 800.0).clamp(1500.0, 2500.0) * 0.5
}

/// A mountain by the sea: beyond the shore the level is 0.
fn coast(x: f64, y: f64) -> f64 {
    (900.0 - 0.35 * (x + 2200.0).hypot(y)).max(0.0) + (-0.02 * (x - 1000.0)).max(0.0)
}

/// A hill in the south-west, and no-data elsewhere.
fn corner(x: f64, y: f64) -> f64 {
    if x > -1800.0 || y > -1500.0 {
        f64::NAN
    } else {
        300.0 + 400.0 * (-((x + 4200.0).hypot(y + 4000.0) / 700.0).powi(2)).exp()
    }
}

fn flat(_: f64, _: f64) -> f64 {
    120.0
}

fn gentle(x: f64, y: f64) -> f64 {
    50.0 + 12.0 * (x / 900.0).sin() * (y / 1100.0).cos() + 9.0 * (-((x - 800.0).hypot(y - 900.0) / 600.0).powi(2)).exp()
}

/// A mountain of 40 km on land of 12 km: what becomes of a DEM whose samples are taken to be too close.
fn tower(x: f64, y: f64) -> f64 {
    let (away, around) = ((x - 800.0).hypot(y + 1100.0), (y + 1100.0).atan2(x - 800.0));
    (40_000.0 - 14.0 * away + 0.5 * away * (9.0 * around).sin()).max(100.0)
}

/// A mountain whose summit a radar did not see, as on steep slopes: the hole reaches the edge of the data, and in it there
/// is a patch of a valley.
fn radar(x: f64, y: f64) -> f64 {
    let in_valley = (x + 500.0).hypot(y - 5100.0);
    if in_valley < 140.0 {
        return 900.0 - 0.5 * in_valley;
    }
    if x > -810.0 && x < -190.0 && y > 3900.0 {
        return f64::NAN;
    }
    let mountain = 2880.0 - 0.45 * (x + 420.0).hypot(y - 4200.0);
    let hill = 900.0 - 0.3 * (x - 3000.0).hypot(y + 2500.0);
    mountain.max(hill).max(300.0 + 20.0 * (x / 400.0).sin() * (y / 500.0).cos())
}

/// A ridge with ribs next to a plain.
fn scarp(x: f64, y: f64) -> f64 {
    let away = (y + 3000.0 + 0.05 * x).abs();
    let rib = 70.0 * (x / 160.0).sin() * (away / 900.0).min(1.0) * (1.0 - away / 1300.0).max(0.0);
    410.0 + (460.0 - 0.36 * away + rib - 0.012 * (x + 2400.0).abs()).max(0.002 * (x + y))
}

fn open(gpu: &Gpu, land: Land) -> OpenWorld {
    let half_m = 0.5 * SPACING_M * f64::from(SIDE - 1);
    let places = (0..SIDE).flat_map(|row| (0..SIDE).map(move |column| (column, row)));
    let at_m = |index: u32| SPACING_M * f64::from(index) - half_m;
    let heights_m = places.map(|(column, row)| land(at_m(column), -at_m(row)) as f32).collect();
    OpenWorld::from_heights(gpu, heights_m, [SIDE; 2], SPACING_M, TerrainOptions::default()).unwrap()
}

/// Returns the highest place of a land.
fn summit_of(land: Land) -> DVec3 {
    let half = 0.5 * SPACING_M * f64::from(SIDE - 1);
    let steps = || (0..SIDE).map(|i| SPACING_M * f64::from(i) - half);
    let places = steps().flat_map(|y| steps().map(move |x| DVec3::new(x, y, land(x, y))));
    places.filter(|at| !at.z.is_nan()).max_by(|a, b| a.z.total_cmp(&b.z)).unwrap()
}

/// Returns the distance along a ray at which it meets the land, in metres.
fn met_m(land: Land, from_m: DVec3, way: DVec3) -> Option<f64> {
    let half = 0.5 * SPACING_M * f64::from(SIDE - 1);
    let mut away_m = 0.0;
    while away_m < 300_000.0 {
        let at = from_m + way * away_m;
        if at.x.abs() <= half && at.y.abs() <= half && at.z <= land(at.x, at.y) {
            return Some(away_m);
        }
        away_m += 10.0 + 0.002 * away_m;
    }
    None
}

fn shown(world: &OpenWorld, land: Land, camera: &Camera, summit_m: DVec3) -> Shown {
    let pose = world.pose(camera);
    let view = View::whole(pose, pose, SIZE_PX);
    let size = DVec2::new(f64::from(SIZE_PX[0]), f64::from(SIZE_PX[1]));
    let (mut empty, mut hole, mut level) = (0.0, 0.0, 0.0);
    for (x, y) in (0..SIZE_PX[1]).flat_map(|y| (0..SIZE_PX[0]).map(move |x| (x, y))) {
        let way = view.ray(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)).normalize();
        match met_m(land, pose.position_m, way) {
            Some(away_m) => {
                let at = pose.position_m + away_m * way;
                let rise_m = DVec2::new(
                    land(at.x + 15.0, at.y) - land(at.x - 15.0, at.y),
                    land(at.x, at.y + 15.0) - land(at.x, at.y - 15.0),
                );
                level += if rise_m.length() < 0.02 * 30.0 { 1.0 } else { 0.0 };
            }
            None => {
                empty += 1.0;
                hole += if way.z < (-8.0_f64).to_radians().sin() { 1.0 } else { 0.0 };
            }
        }
    }
    let pixels = size.x * size.y;
    let to_summit = summit_m - pose.position_m;
    let met = met_m(land, pose.position_m, (to_summit + DVec3::Z * 5.0).normalize());
    let horizon = view.place_px(DVec3::new(pose.forward.x, pose.forward.y, 0.0)).map_or(0.0, |at| at.y / size.y);
    let side_deg = ((world.scene.sun.azimuth_deg - camera.yaw_deg + 180.0).rem_euclid(360.0) - 180.0).abs();
    Shown {
        empty: empty / pixels,
        hole: hole / pixels,
        summit: view.place_px(to_summit).map_or(DVec2::NAN, |at| at / size),
        is_summit_seen: met.is_none_or(|away_m| away_m > to_summit.length() - 150.0),
        horizon,
        side_deg,
        level: level / pixels,
    }
}

/// Returns what is wrong with a view that level land may fill to a part.
fn faults(shown: &Shown, most_level: f64) -> Vec<&'static str> {
    let middle = |part: f64| (0.25..=0.75).contains(&part);
    let checks = [
        (middle(shown.summit.x) && middle(shown.summit.y), "the summit is not in the middle half"),
        (shown.is_summit_seen, "the summit is hidden"),
        (shown.empty <= 0.4, "more than 40 % of sky"),
        (shown.hole <= 0.015, "a view onto no-data"),
        (shown.horizon < 0.5, "the horizon is not above the middle"),
        ((45.0..=115.0).contains(&shown.side_deg), "no light from the side"),
        (shown.level <= most_level, "an empty foreground"),
    ];
    checks.into_iter().filter(|(is_right, _)| !is_right).map(|(_, fault)| fault).collect()
}

#[test]
fn the_start_view_frames_the_summit() {
    let Some(gpu) = gpu() else { return };
    let lands = [
        Known::new("cone", cone),
        Known::new("ridge", ridge),
        Known { place_m: Some(DVec3::new(-1000.0, 800.0, 50.0)), ..Known::new("plateau", plateau) },
        Known::new("coast", coast),
        Known { most_level: 0.2, ..Known::new("corner", corner) },
        Known::new("gentle", gentle),
        Known { place_m: Some(DVec3::new(0.0, 0.0, 120.0)), ..Known::new("flat", flat) },
        Known::new("tower", tower),
        Known::new("radar", radar),
        Known { most_level: 0.2, ..Known::new("scarp", scarp) },
    ];
    let mut wrong = Vec::new();
    // In the fast tier a corner with a hill, and a land with holes.
    let is_wanted = |known: &Known| full() || ["corner", "radar"].contains(&known.name);
    for Known { name, land, place_m, most_level } in lands.into_iter().filter(is_wanted) {
        let world = open(&gpu, land);
        let camera = world.start_camera(ASPECT);
        let summit_m = place_m.unwrap_or_else(|| summit_of(land));
        let shown = shown(&world, land, &camera, summit_m);
        println!("{name}: {camera}: {shown:?}");
        let found = faults(&shown, most_level);
        if !found.is_empty() {
            wrong.push(format!("{name}: {camera}: {found:?}"));
        }
        if full() || name == "radar" {
            assert_eq!(camera, world.start_camera(ASPECT), "{name}: the same world has the same view");
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn faults_of_views_are_found() {
    let Some(gpu) = gpu() else { return };
    let world = open(&gpu, cone);
    let good: Camera = "4105,-1321,2811,265,-41.3,45".parse().unwrap();
    let summit_m = summit_of(cone);
    assert_eq!(faults(&shown(&world, cone, &good, summit_m), 0.3), [""; 0]);
    let fault = |change: &dyn Fn(&mut Camera), expected: &str| {
        let mut camera = good;
        change(&mut camera);
        let found = faults(&shown(&world, cone, &camera, summit_m), 0.3);
        assert!(found.contains(&expected), "{camera}: {found:?}");
    };
    fault(&|camera| camera.yaw_deg += 35.0, "the summit is not in the middle half");
    fault(&|camera| camera.pitch_deg = 20.0, "more than 40 % of sky");
    fault(&|camera| camera.pitch_deg = 20.0, "the horizon is not above the middle");
    fault(&|camera| camera.yaw_deg = world.scene.sun.azimuth_deg, "no light from the side");
    fault(&|camera| camera.position_m = DVec3::new(2100.0, -7000.0, 2500.0), "a view onto no-data");
    fault(&|camera| camera.position_m.z = 150.0, "the summit is hidden");
    let beside: Camera = "5800,4500,900,215,-10,45".parse().unwrap();
    fault(&|camera| *camera = beside, "an empty foreground");
    // The view of the whole extent from the south that was chosen before has the summit off centre.
    let from_south = Camera { position_m: DVec3::new(0.0, -5040.0, 1810.0), yaw_deg: 0.0, pitch_deg: -9.0, ..good };
    assert!(!faults(&shown(&world, cone, &from_south, summit_m), 1.0).is_empty());
}

#[test]
fn a_place_is_looked_at_from_where_one_says() {
    let Some(gpu) = gpu() else { return };
    let mut world = open(&gpu, cone);
    let place_m = DVec2::new(-2000.0, 1000.0);
    let at_m = place_m.extend(cone(place_m.x, place_m.y));
    let from = StandPoint { azimuth_deg: 200.0, distance_m: 1800.0 };
    for from in [None, Some(from)] {
        let camera = world.camera_looking_at(place_m, from, ASPECT).unwrap().unwrap();
        let shown = shown(&world, cone, &camera, at_m);
        assert!((shown.summit - 0.5).abs().max_element() < 0.25 && shown.is_summit_seen, "{camera}: {shown:?}");
        if let Some(from) = from {
            let away = camera.position_m.truncate() - place_m;
            let azimuth_deg = away.x.atan2(away.y).to_degrees().rem_euclid(360.0);
            assert!((away.length() - from.distance_m).abs() < 2.0, "{camera}");
            assert!((azimuth_deg - from.azimuth_deg).abs() < 0.2, "{camera}");
        }
    }
    assert_eq!(world.camera_looking_at(DVec2::splat(9000.0), None, ASPECT).unwrap(), None, "no land there");
    // A scene's own start is kept.
    let own: Camera = "1,2,+3,4,-5,60".parse().unwrap();
    world.scene.start = Some(own);
    assert_eq!(world.start_camera(ASPECT), own);
}
