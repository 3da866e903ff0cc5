//! The polynomial that approximates a projection, compared with the projection.
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use crate::tests::common;

use common::random;
use glam::{DVec2, Vec2};
use hachure::source::WorldMapping;
use hachure::source::georeference::{Crs, Georeference};
use hachure::tiles::grid_projection::{GridProjection, LocalProjection};

/// Returns a grid of `side_deg` × `side_deg` on WGS 84 whose centre is at `latitude_deg`.
fn geographic(side_deg: f64, latitude_deg: f64, samples: u32) -> (WorldMapping, GridProjection) {
    let step = side_deg / f64::from(samples - 1);
    let georeference = Georeference {
        crs_from_grid: [8.0, step, 0.0, latitude_deg + 0.5 * side_deg, 0.0, -step],
        crs: Crs::Geographic {
            radians_per_unit: std::f64::consts::PI / 180.0,
            semi_major_axis_m: 6_378_137.0,
            inverse_flattening: 298.257_223_563,
            name: "WGS 84".to_owned(),
        },
        geokeys: Default::default(),
    };
    let mapping = WorldMapping::new(&georeference, samples, samples).unwrap();
    let grid_projection = GridProjection::fit(&mapping, samples, samples);
    (mapping, grid_projection)
}

/// Side in degrees, latitude, samples per side, and tolerance in samples; the spacing is three arc seconds.
const GRIDS: [(f64, f64, u32, f64); 4] =
    [(1.0, 46.0, 1201, 1e-4), (1.0, 70.0, 1201, 1e-4), (5.0, 46.0, 6001, 1e-2), (5.0, 70.0, 6001, 1e-2)];

/// Returns points all over a grid, including its border.
fn places(samples: u32, count: i64) -> impl Iterator<Item = DVec2> {
    let last = f64::from(samples - 1);
    (0..count).map(move |i| {
        let inside = DVec2::new(random(i, 1), random(i, 2)) * last;
        match i % 8 {
            0 => DVec2::new(inside.x, 0.0),
            1 => DVec2::new(last, inside.y),
            _ => inside,
        }
    })
}

/// Returns the largest difference between polynomial and projection in samples: (forward, backward).
fn worst_samples(mapping: &WorldMapping, grid_projection: &GridProjection, samples: u32) -> (f64, f64) {
    places(samples, 4000).fold((0.0, 0.0), |(forward, backward): (f64, f64), grid| {
        let place_m = mapping.world_from_grid(grid.x, grid.y);
        let off_m = (grid_projection.world_from_grid(grid) - place_m).length();
        // Relative to the shorter side of a cell, so that the number is not too small.
        let beside_m = mapping.world_from_grid(grid.x + 1.0, grid.y) - place_m;
        let back = (grid_projection.grid_from_world(place_m) - grid).length();
        (forward.max(off_m / beside_m.length()), backward.max(back))
    })
}

#[test]
fn the_polynomial_follows_the_projection() {
    for (side_deg, latitude_deg, samples, allowed) in GRIDS {
        let (mapping, grid_projection) = geographic(side_deg, latitude_deg, samples);
        let (forward, backward) = worst_samples(&mapping, &grid_projection, samples);
        let said = grid_projection.worst_samples();
        println!(
            "{side_deg}° at {latitude_deg}° N: {forward:.2e} samples forward, {backward:.2e} back; its own estimate {said:.2e}"
        );
        assert!(
            forward <= allowed && backward <= allowed,
            "{side_deg}° at {latitude_deg}°: off by {forward:.2e} and {backward:.2e} samples, allowed {allowed:.0e}"
        );
        // The fit's own estimate is not lower than the measurement, apart from another unit of length.
        assert!(
            backward <= 1.5 * said && forward <= 4.0 * said.max(1e-9),
            "the fit claims {said:.2e} samples, measured {forward:.2e} forward and {backward:.2e} backward"
        );
        // Planted error: the fit of a grid one degree farther north.
        let (_, other) = geographic(side_deg, latitude_deg + 1.0, samples);
        let (forward, backward) = worst_samples(&mapping, &other, samples);
        assert!(forward > allowed && backward > allowed);
    }
}

/// Evaluates `world_from_grid` as the shader does, in f32.
fn world_f32(local: &LocalProjection, g: Vec2) -> Vec2 {
    evaluate(local, g * local.grid_unit, |term| Vec2::new(term[0], term[1]))
}

/// Evaluates `grid_from_world` as the shader does, in f32.
fn grid_f32(local: &LocalProjection, xy_m: Vec2) -> Vec2 {
    evaluate(local, (xy_m - Vec2::from(local.world_origin_m)) * local.world_unit, |term| Vec2::new(term[2], term[3]))
}

/// Evaluates Σ c_ij x^i y^j over i + j ≤ degree, with rows of rising powers of x.
fn evaluate(local: &LocalProjection, v: Vec2, coefficient: impl Fn(&[f32; 4]) -> Vec2) -> Vec2 {
    let degree = local.degree as usize;
    let mut rows = Vec::new();
    let mut terms = local.terms.iter();
    for row in 0..=degree {
        let row: Vec<_> = terms.by_ref().take(degree - row + 1).map(&coefficient).collect();
        rows.push(row.into_iter().rev().fold(Vec2::ZERO, |sum, c| sum * v.x + c));
    }
    rows.into_iter().rev().fold(Vec2::ZERO, |sum, row| sum * v.y + row)
}

/// Returns the largest error of the expansion at points around a camera, relative to their horizontal distance from the
/// camera (at least `min_m`): (forward, backward).
fn relative(
    mapping: &WorldMapping,
    grid_projection: &GridProjection,
    samples: u32,
    camera_m: DVec2,
    min_m: f64,
) -> (f64, f64) {
    let anchor = grid_projection.anchor(camera_m);
    let local = grid_projection.around(anchor, camera_m);
    let last = f64::from(samples - 1);
    let mut worst = (0.0_f64, 0.0_f64);
    for i in 0..4000 {
        // The distance varies from a hundredth of a sample to the whole grid.
        let reach = last * 10_f64.powf(-5.0 * random(i, 3));
        let angle = std::f64::consts::TAU * random(i, 4);
        let grid = (anchor + reach * DVec2::from_angle(angle)).clamp(DVec2::ZERO, DVec2::splat(last));
        // The GPU has differences in f32.
        let g = (grid - anchor).as_vec2();
        let grid = anchor + g.as_dvec2();
        let way_m = mapping.world_from_grid(grid.x, grid.y) - camera_m;
        let distance_m = way_m.length().max(min_m);
        let forward_m = (world_f32(&local, g).as_dvec2() - way_m).length();
        let back_m = (grid_f32(&local, way_m.as_vec2()) - g).as_dvec2().length() * grid_projection.spacing_m();
        worst = (worst.0.max(forward_m / distance_m), worst.1.max(back_m / distance_m));
    }
    worst
}

#[test]
fn the_expansion_keeps_its_digits_near_the_camera() {
    for (side_deg, latitude_deg, samples, allowed) in GRIDS {
        let (mapping, grid_projection) = geographic(side_deg, latitude_deg, samples);
        let half_m = mapping.world_from_grid(f64::from(samples - 1), f64::from(samples - 1) * 0.5).x;
        let cameras = [
            ("middle", DVec2::new(0.3, -0.2)),
            ("off middle", DVec2::new(0.61 * half_m, -0.43 * half_m)),
            ("near a corner", DVec2::new(-0.93 * half_m, 0.93 * half_m)),
            ("outside", DVec2::new(-3.0 * half_m, 0.4 * half_m)),
            ("far outside", DVec2::new(40.0 * half_m, 25.0 * half_m)),
        ];
        for (name, camera_m) in cameras {
            // The fit's own error is a length, taken relative to the distance of a sample.
            let (forward, backward) =
                relative(&mapping, &grid_projection, samples, camera_m, grid_projection.spacing_m());
            println!(
                "{side_deg}° at {latitude_deg}° N, camera {name}: {forward:.2e} forward, {backward:.2e} back, relative to the distance"
            );
            // For comparison: a pixel of a 20° field of view over 2160 rows is 1.6e-4.
            let most = 4e-6 + 2.0 * allowed.min(grid_projection.worst_samples());
            assert!(
                forward <= most && backward <= most,
                "{name}: errors {forward:.2e} and {backward:.2e}, allowed {most:.1e}"
            );
        }
        // Planted error: an expansion for a camera ten metres away.
        let camera_m = DVec2::new(0.3, -0.2);
        let anchor = grid_projection.anchor(camera_m);
        let local = grid_projection.around(anchor, camera_m + 10.0);
        let off = (world_f32(&local, Vec2::ZERO).as_dvec2() - (mapping.world_from_grid(anchor.x, anchor.y) - camera_m))
            .length();
        assert!(off / grid_projection.spacing_m() > 0.1, "an expansion for another camera is off by only {off} m");
    }
}

/// Tests that bounding boxes take account of curved parallels: that of a wide, low rectangle is larger than that of its
/// corners.
#[test]
fn boxes_hold_all_of_a_wide_strip() {
    let (width, height) = (2401, 301);
    let step = 8.0 / 2400.0;
    let georeference = Georeference {
        crs_from_grid: [8.0, step, 0.0, 50.5, 0.0, -step],
        crs: Crs::Geographic {
            radians_per_unit: std::f64::consts::PI / 180.0,
            semi_major_axis_m: 6_378_137.0,
            inverse_flattening: 298.257_223_563,
            name: "WGS 84".to_owned(),
        },
        geokeys: Default::default(),
    };
    let mapping = WorldMapping::new(&georeference, width, height).unwrap();
    let grid_projection = GridProjection::fit(&mapping, width, height);
    let mut outside_corners = 0;
    for level in 0..5 {
        let side = DVec2::new(f64::from(width - 1), f64::from(height - 1)) / f64::from(1 << level);
        for tile in 0..1 << level {
            let first = DVec2::new(f64::from(tile) * side.x, 0.0);
            let (low_m, high_m) = grid_projection.bounds(first, first + side);
            let corners = [first, first + side, first + DVec2::new(side.x, 0.0), first + DVec2::new(0.0, side.y)];
            let corners_m = corners.map(|corner| mapping.world_from_grid(corner.x, corner.y));
            let lowest_m = corners_m.into_iter().reduce(DVec2::min).unwrap();
            let highest_m = corners_m.into_iter().reduce(DVec2::max).unwrap();
            for i in 0..2000 {
                let grid = first + side * DVec2::new(random(i, 3), random(i, 4));
                let place_m = mapping.world_from_grid(grid.x, grid.y);
                assert!(
                    place_m.cmpge(low_m).all() && place_m.cmple(high_m).all(),
                    "level {level}, tile {tile}: {place_m} is outside the box"
                );
                outside_corners += u32::from(place_m.cmplt(lowest_m).any() || place_m.cmpgt(highest_m).any());
            }
        }
    }
    // Planted error: boxes of the corners alone.
    assert!(outside_corners > 30, "only {outside_corners} points are outside the corners' boxes");
}
