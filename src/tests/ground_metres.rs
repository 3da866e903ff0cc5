//! A metre of the world is a metre on the ground: distances against Vincenty's geodesics in 16 reference systems.

use glam::DVec2;
use hachure::source::earth_projection::EarthProjection;
use hachure::source::georeference::{Crs, Georeference};
use hachure::source::{GeoKeys, WorldMapping};
use hachure::tiles::grid_projection::GridProjection;
use proj4rs::Proj;
use proj4rs::transform::transform;

const WGS84: [f64; 2] = [6_378_137.0, 298.257_223_563];
const GRS80: [f64; 2] = [6_378_137.0, 298.257_222_101];
const AIRY: [f64; 2] = [6_377_563.396, 299.324_964_6];
const CLARKE_IGN: [f64; 2] = [6_378_249.2, 293.466_021_293_626_5];
const BESSEL: [f64; 2] = [6_377_397.155, 299.152_812_8];

/// Samples along a side of the grids.
const SIDE: u32 = 101;

/// Returns the length of the geodesic between two places, given by longitude and latitude in radians (T. Vincenty,
/// "Direct and inverse solutions of geodesics on the ellipsoid with application of nested equations", Survey Review
/// 1975).
fn geodesic_m([axis_m, inverse_flattening]: [f64; 2], from: DVec2, to: DVec2) -> f64 {
    let f = 1.0 / inverse_flattening;
    let short_m = axis_m * (1.0 - f);
    let [u1, u2] = [from.y, to.y].map(|latitude| ((1.0 - f) * latitude.tan()).atan());
    let half = std::f64::consts::PI;
    let longitude = (to.x - from.x + half).rem_euclid(2.0 * half) - half;
    let mut lambda = longitude;
    for _ in 0..200 {
        let (sin_l, cos_l) = lambda.sin_cos();
        let sin_s = f64::hypot(u2.cos() * sin_l, u1.cos() * u2.sin() - u1.sin() * u2.cos() * cos_l);
        if sin_s == 0.0 {
            return 0.0;
        }
        let cos_s = u1.sin() * u2.sin() + u1.cos() * u2.cos() * cos_l;
        let sigma = sin_s.atan2(cos_s);
        let sin_a = u1.cos() * u2.cos() * sin_l / sin_s;
        let cos2_a = 1.0 - sin_a * sin_a;
        let cos_2m = if cos2_a == 0.0 { 0.0 } else { cos_s - 2.0 * u1.sin() * u2.sin() / cos2_a };
        let c = f / 16.0 * cos2_a * (4.0 + f * (4.0 - 3.0 * cos2_a));
        let sum = cos_2m + c * cos_s * (2.0 * cos_2m * cos_2m - 1.0);
        let next = longitude + (1.0 - c) * f * sin_a * (sigma + c * sin_s * sum);
        let is_done = (next - lambda).abs() < 1e-13;
        lambda = next;
        if is_done {
            let u = cos2_a * (axis_m * axis_m - short_m * short_m) / (short_m * short_m);
            let a = 1.0 + u / 16384.0 * (4096.0 + u * (-768.0 + u * (320.0 - 175.0 * u)));
            let b = u / 1024.0 * (256.0 + u * (-128.0 + u * (74.0 - 47.0 * u)));
            let inner = cos_s * (2.0 * cos_2m * cos_2m - 1.0)
                - b / 6.0 * cos_2m * (4.0 * sin_s * sin_s - 3.0) * (4.0 * cos_2m * cos_2m - 3.0);
            return short_m * a * (sigma - b * sin_s * (cos_2m + b / 4.0 * inner));
        }
    }
    panic!("{from} to {to}: no geodesic");
}

/// A reference system, its ellipsoid, and longitude and latitudes in degrees at which it is used.
struct System {
    epsg: u16,
    ellipsoid: [f64; 2],
    longitude: f64,
    latitudes: [f64; 5],
}

const fn system(epsg: u16, ellipsoid: [f64; 2], longitude: f64, latitudes: [f64; 5]) -> System {
    System { epsg, ellipsoid, longitude, latitudes }
}

const SYSTEMS: [System; 16] = [
    system(3857, WGS84, 9.3, [-60.0, -33.0, 0.5, 46.6, 71.0]),
    system(3395, WGS84, -70.2, [-52.0, -33.0, 0.5, 46.6, 71.0]),
    system(32632, WGS84, 13.5, [5.0, 20.0, 46.6, 60.0, 72.0]),
    system(2056, BESSEL, 8.2, [45.9, 46.2, 46.6, 47.0, 47.6]),
    system(3413, WGS84, -76.0, [60.0, 66.0, 71.0, 78.0, 88.0]),
    system(3031, WGS84, 140.0, [-60.0, -66.0, -71.0, -78.0, -89.0]),
    system(3035, GRS80, 25.0, [36.0, 42.0, 50.0, 60.0, 69.0]),
    system(5070, GRS80, -120.5, [25.0, 32.0, 38.0, 44.0, 49.0]),
    system(2154, GRS80, 7.6, [42.0, 44.0, 46.5, 48.5, 51.0]),
    system(27700, AIRY, -5.5, [50.1, 52.0, 54.0, 56.5, 58.5]),
    system(6933, WGS84, 30.0, [-55.0, -30.0, 1.0, 45.0, 68.0]),
    system(3978, GRS80, -130.0, [42.0, 49.0, 55.0, 63.0, 77.0]),
    system(28992, BESSEL, 6.9, [50.8, 51.3, 52.0, 52.8, 53.4]),
    system(4326, WGS84, 100.0, [-60.0, -33.0, 0.5, 46.6, 71.0]),
    // Across the antimeridian, and from Paris.
    system(3857, WGS84, 180.0, [-60.0, -33.0, 0.5, 46.6, 71.0]),
    system(27572, CLARKE_IGN, 7.6, [42.0, 44.0, 46.5, 48.5, 51.0]),
];

impl System {
    /// Returns the projection between longitudes and latitudes in radians and the system, in the words of the
    /// catalogue, without a shift of datum.
    fn projections(&self) -> [Proj; 2] {
        let words = crs_definitions::from_code(self.epsg).unwrap().proj4;
        let kept = words
            .split_whitespace()
            .filter(|word| !["+towgs84", "+nadgrids", "+datum"].iter().any(|it| word.starts_with(it)));
        let is_sphere = self.epsg == 3857;
        let shape = match is_sphere {
            true => format!("+R={}", self.ellipsoid[0]),
            false => format!("+a={} +rf={}", self.ellipsoid[0], self.ellipsoid[1]),
        };
        let kept = kept.filter(|word| !["+ellps", "+a=", "+b="].iter().any(|it| word.starts_with(it)));
        let own = kept.collect::<Vec<_>>().join(" ") + " " + &shape;
        [format!("+proj=longlat {shape}"), own].map(|text| Proj::from_proj_string(&text).unwrap())
    }

    /// Returns the grid of samples `step_m` apart, on the ground, about a latitude.
    fn grid(&self, latitude: f64, step_m: f64) -> Georeference {
        let [degrees, own] = self.projections();
        let crs = |longitude: f64, latitude: f64| {
            let mut point = (longitude.to_radians(), latitude.to_radians(), 0.0);
            transform(&degrees, &own, &mut point).unwrap();
            if self.epsg == 4326 { DVec2::new(longitude, latitude) } else { DVec2::new(point.0, point.1) }
        };
        let (at, north) = (crs(self.longitude, latitude), crs(self.longitude, latitude + 1e-3));
        let step = step_m * at.distance(north) / 111.0;
        let half = 0.5 * f64::from(SIDE - 1) * step;
        let name = format!("EPSG:{}", self.epsg);
        let crs = match self.epsg {
            4326 => Crs::Geographic {
                radians_per_unit: 1f64.to_radians(),
                semi_major_axis_m: WGS84[0],
                inverse_flattening: WGS84[1],
                name,
            },
            _ => Crs::Projected { metres_per_unit: 1.0, name },
        };
        let crs_from_grid = [at.x - half, step, 0.0, at.y + half, 0.0, -step];
        Georeference { crs_from_grid, crs, geokeys: GeoKeys::default() }
    }

    /// Returns longitude and latitude in radians at a position of the grid.
    fn place_rad(&self, georeference: &Georeference, [column, row]: [f64; 2]) -> DVec2 {
        let [x0, a, b, y0, c, d] = georeference.crs_from_grid;
        let mut point = (x0 + a * column + b * row, y0 + c * column + d * row, 0.0);
        if self.epsg == 4326 {
            return DVec2::new(point.0.to_radians(), point.1.to_radians());
        }
        let [degrees, own] = self.projections();
        transform(&own, &degrees, &mut point).unwrap();
        DVec2::new(point.0, point.1)
    }
}

/// Returns a georeference with the keys that its Well-Known Text gives.
fn read_again(picture: &Georeference) -> Georeference {
    let geokeys = hachure::source::wkt::keys(&picture.wkt().unwrap()).unwrap();
    match picture.epsg() {
        Some(_) => picture.clone(),
        None => Georeference { geokeys, ..picture.clone() },
    }
}

/// Returns world distance over ground distance between pairs of positions of a grid, over two samples each.
fn ratios(system: &System, georeference: &Georeference, mapping: &WorldMapping, centres: &[[f64; 2]]) -> Vec<f64> {
    let ways = [[1.0, 0.0], [0.0, 1.0], [0.7, 0.7], [-0.7, 0.7]];
    let pairs = centres.iter().flat_map(|[x, y]| ways.map(|[dx, dy]| [[x - dx, y - dy], [x + dx, y + dy]]));
    pairs
        .map(|[from, to]| {
            let world_m = mapping.world_from_grid(from[0], from[1]).distance(mapping.world_from_grid(to[0], to[1]));
            let places = [from, to].map(|at| system.place_rad(georeference, at));
            world_m / geodesic_m(system.ellipsoid, places[0], places[1])
        })
        .collect()
}

fn departure(ratios: &[f64]) -> f64 {
    ratios.iter().map(|ratio| (ratio - 1.0).abs()).fold(0.0, f64::max)
}

#[test]
fn world_metres_are_ground_metres_within_the_stated_bound() {
    let middle = 0.5 * f64::from(SIDE - 1);
    let last = f64::from(SIDE - 1);
    let edges =
        [[1.0, 1.0], [last - 1.0, 1.0], [1.0, last - 1.0], [last - 1.0, last - 1.0], [middle, 1.0], [1.0, middle]];
    let (mut worst_centre, mut worst_edge, mut planted): (f64, f64, f64) = (0.0, 0.0, 0.0);
    for system in &SYSTEMS {
        for latitude in system.latitudes {
            // A valley, and a country.
            for step_m in [30.0, 3000.0] {
                let georeference = system.grid(latitude, step_m);
                let mapping = WorldMapping::new(&georeference, SIDE, SIDE).unwrap();
                let scale = *mapping.ground_scale().unwrap();
                let name = format!("EPSG:{} at {latitude}°, {step_m} m", system.epsg);
                let centre = departure(&ratios(system, &georeference, &mapping, &[[middle, middle]]));
                let edge = departure(&ratios(system, &georeference, &mapping, &edges));
                // Steps of 6 km are no longer points.
                let slack = if step_m > 100.0 { 1e-4 } else { 1e-6 };
                assert!(centre < 0.003 + slack, "{name}: {centre} at the centre");
                assert!(edge <= scale.world.departure() + slack, "{name}: {edge}, stated {}", scale.world.departure());
                (worst_centre, worst_edge) = (worst_centre.max(centre), worst_edge.max(edge));
                if let Some(file) = scale.file {
                    planted = planted.max((file.centre - 1.0).abs());
                    assert!(file.min <= file.centre && file.centre <= file.max, "{name}");
                }
                let fitted = GridProjection::fit(&mapping, SIDE, SIDE);
                assert!(fitted.worst_samples() < 0.01, "{name}: the GPU is {} samples off", fitted.worst_samples());
            }
        }
    }
    println!("largest departure: {worst_centre:.6} at centres, {worst_edge:.6} at edges");
    assert!(planted > 2.0, "planted: without ground metres the error at a centre would be {planted}");
}

#[test]
fn a_stated_bound_is_reached() {
    // Where the scale varies most, the bound is not much larger than the measured error.
    for (system, latitude) in [(&SYSTEMS[0], 71.0), (&SYSTEMS[4], 60.0), (&SYSTEMS[13], 0.5)] {
        let georeference = system.grid(latitude, 30_000.0);
        let mapping = WorldMapping::new(&georeference, SIDE, SIDE).unwrap();
        let stated = mapping.ground_scale().unwrap().world.departure();
        let last = f64::from(SIDE - 1);
        let all: Vec<[f64; 2]> = (1..SIDE - 1)
            .step_by(7)
            .flat_map(|i| {
                [[f64::from(i), 1.0], [f64::from(i), last - 1.0], [1.0, f64::from(i)], [last - 1.0, f64::from(i)]]
            })
            .collect();
        let found = departure(&ratios(system, &georeference, &mapping, &all));
        assert!(found > 0.8 * stated && found < 1.05 * stated, "EPSG:{}: found {found}, stated {stated}", system.epsg);
    }
}

#[test]
fn true_north_is_where_the_meridian_goes() {
    for system in &SYSTEMS {
        for latitude in system.latitudes {
            let georeference = system.grid(latitude, 30.0);
            let mapping = WorldMapping::new(&georeference, SIDE, SIDE).unwrap();
            let middle = f64::from(SIDE / 2);
            // The bearing of the grid's own north, from two places one row apart.
            let [south, north] = [middle + 0.5, middle - 0.5].map(|row| system.place_rad(&georeference, [middle, row]));
            let parallel = south.y.cos().midpoint(north.y.cos());
            let grid_north = ((north.x - south.x) * parallel).atan2(north.y - south.y);
            let found = mapping.true_north_rad(DVec2::ZERO).unwrap();
            assert!(
                (found + grid_north).abs() < 2e-4 + 5e-3 * grid_north.abs(),
                "EPSG:{} at {latitude}°: {found}, the grid is at {grid_north}",
                system.epsg
            );
        }
    }
    // The case from the Canadian Arctic: 30.9° clockwise from the top of the sheet.
    let grid = Georeference {
        crs_from_grid: [-1_200_000.0, 40.0, 0.0, -2_000_000.0, 0.0, -40.0],
        crs: Crs::Projected { metres_per_unit: 1.0, name: "EPSG:3413".into() },
        geokeys: GeoKeys::default(),
    };
    let mapping = WorldMapping::new(&grid, 61, 51).unwrap();
    let north_deg = mapping.true_north_rad(DVec2::ZERO).unwrap().to_degrees();
    assert!((north_deg - 30.9).abs() < 0.05, "{north_deg}");
}

#[test]
fn a_grid_that_is_ground_metres_stays_as_it_is() {
    let utm = SYSTEMS[2].grid(46.6, 30.0);
    let mapping = WorldMapping::new(&utm, SIDE, SIDE).unwrap();
    let corner = mapping.world_from_grid(0.0, 0.0);
    let [x0, step, ..] = utm.crs_from_grid;
    assert_eq!(corner, DVec2::new(-50.0 * step, 50.0 * step), "{x0}");
    assert!(mapping.describe().starts_with("EPSG:32632, origin at"), "{}", mapping.describe());
    let local = Georeference { crs: Crs::Local, ..utm };
    let mapping = WorldMapping::new(&local, SIDE, SIDE).unwrap();
    assert!(mapping.ground_scale().is_none() && mapping.true_north_rad(DVec2::ZERO).is_none());
}

#[test]
fn a_picture_has_the_reference_system_of_its_pixels() {
    // Rotated, wide in the file's own plane, and geographic; the last number is the largest error in metres.
    let wide = SYSTEMS[5].grid(-88.0, 60_000.0);
    let worlds = [SYSTEMS[0].grid(71.0, 300.0), SYSTEMS[4].grid(66.0, 300.0), wide, SYSTEMS[13].grid(46.6, 300.0)];
    for world in worlds {
        let mapping = WorldMapping::new(&world, SIDE, SIDE).unwrap();
        let (first_m, pixel_m) = (DVec2::new(-3000.0, 4000.0), 50.0);
        let picture = mapping.picture_georeference(&world, first_m, pixel_m);
        // Another program reads the sidecar text of the picture.
        let keys = read_again(&picture);
        let projection = EarthProjection::of(&keys).unwrap();
        for [column, row] in [[0.0, 0.0], [120.0, 0.0], [0.0, 160.0], [120.0, 160.0]] {
            let [x0, a, b, y0, c, d] = picture.crs_from_grid;
            let crs = DVec2::new(x0 + a * column + b * row, y0 + c * column + d * row);
            let found = projection.longitude_latitude_rad(crs);
            let world_m = first_m + pixel_m * DVec2::new(column, -row);
            let expected = mapping.longitude_latitude_rad(world_m).unwrap();
            let error_m = 6.4e6 * (found - expected).length();
            assert!(error_m < 0.01, "{}: {error_m} m", mapping.describe());
            // Planted: the axes exchanged.
            let turned = projection.longitude_latitude_rad(DVec2::new(x0 + a * row + b * column, crs.y));
            assert!(column == row || 6.4e6 * (turned - expected).length() > 10.0);
        }
    }
}
