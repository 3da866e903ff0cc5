//! Tests the detectors Sobel and Roystan, and the density filter with its ramp, against CPU twins.

use glam::DVec3;
use hachure::lines::detector::{self, ERRORS};
use hachure::lines::lsa::DIRECTIONS;
use hachure::lines::threshold::{self, LINE};
use hachure::style::{Detector, Lines, Style};
use hachure::surface::{DISTANCE, NORMAL, seen};

use crate::tests::line_pictures::{Bench, SIZE_PX, bits, chance, inside, off, places, view};

/// Returns positions, with the depth along the axis, and normals: a plain, a wall in front, a dip behind, noise, and
/// sky.
fn land() -> (Vec<[f32; 4]>, Vec<[f32; 4]>) {
    let view = view();
    places()
        .map(|(x, y)| {
            let ray = view.ray(glam::DVec2::new(x as f64 + 0.5, y as f64 + 0.5));
            if y < 6 && x > 20 {
                return ([0.0; 4], [0.0; 4]);
            }
            let far = 500.0 * (1.0 + 0.01 * x as f64) + 30.0 * (y as f64 * 0.3).sin();
            let depth_m = match (x, y) {
                (10..=24, 12..=30) => 60.0 + 0.2 * x as f64,
                (30..=50, 30..) => far * (1.0 + 0.06 * chance(x, y, 1)),
                _ => far,
            };
            let lean = if x > 35 { 0.9 * chance(x / 4, y / 4, 2) } else { 0.2 };
            let normal = DVec3::new(lean, -0.4, 1.0 - 0.6 * lean).normalize();
            let at = ray * depth_m;
            let [px, py, pz] = at.as_vec3().to_array();
            let [nx, ny, nz] = normal.as_vec3().to_array();
            // The normal that the picture can hold.
            ([px, py, pz, depth_m as f32], seen::surface_of(seen::words_of([nx, ny, nz, 1.0])))
        })
        .unzip()
}

fn errors_of(bench: &mut Bench, detector: Detector) -> Vec<f64> {
    let (positions, normals) = land();
    let distances_m: Vec<f32> = positions.iter().map(|at| at[3]).collect();
    let distance = bench.picture(&DISTANCE, SIZE_PX, &distances_m);
    let words: Vec<u32> = normals.iter().map(|normal| seen::words_of(*normal)[0]).collect();
    let normal = bench.picture(&NORMAL, SIZE_PX, &words);
    let errors = bench.out(&ERRORS);
    let lines = Lines { detector, ..Style::load("lsa").unwrap().lines().cloned().unwrap() };
    bench.run(|recorder| {
        let view = &recorder.uniform("view", &view().uniform(DVec3::ZERO));
        let (distance, normal, errors) = (&distance, &normal, &errors);
        let inputs = detector::Inputs { view, distance, normal, errors, directions: None };
        detector::run(recorder, &lines, &inputs);
    });
    let found = bench.halves(&errors);
    assert!(
        found.iter().all(|[a, b, c, d]| a == b && b == c && c == d),
        "the detector must write the same error for all axes"
    );
    found.into_iter().map(|[error, ..]| error).collect()
}

/// Returns Sobel's gradient of the depth, divided by the nearest depth around; `middle` is the weight of the middle.
fn sobel(positions: &[[f32; 4]], middle: f64) -> Vec<f64> {
    let depth_m = |x: i64, y: i64| {
        let depth_m = f64::from(positions[inside(x, y)][3]);
        if depth_m > 0.0 { depth_m } else { 1e7 }
    };
    let strength = |(x, y): (i64, i64)| {
        let side = |dx: i64, dy: i64, ax: i64, ay: i64| {
            depth_m(x + dx - ax, y + dy - ay) + middle * depth_m(x + dx, y + dy) + depth_m(x + dx + ax, y + dy + ay)
        };
        let (gx, gy) = (side(1, 0, 0, 1) - side(-1, 0, 0, 1), side(0, 1, 1, 0) - side(0, -1, 1, 0));
        let around = [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)].map(|(dx, dy)| depth_m(x + dx, y + dy));
        (gx.hypot(gy) / (8.0 * around.into_iter().fold(f64::MAX, f64::min))).min(4.0)
    };
    places().map(strength).collect()
}

#[test]
fn sobel_is_its_twin() {
    let Some(mut bench) = Bench::new() else { return };
    let found = errors_of(&mut bench, Detector::Sobel);
    let (positions, _) = land();
    // 16-bit floats have 11 significant bits.
    let most = 4.0 / 2048.0;
    assert_eq!(off(&found, &sobel(&positions, 2.0), most), 0);
    assert!(found.iter().filter(|error| **error > 0.1).count() > 100, "the picture must have edges");
    // Planted error: Prewitt's weights.
    assert!(off(&found, &sobel(&positions, 1.0), most) > 100);
}

/// Returns 1 for an edge and 0 for none, or NaN where rounding decides. `steepest` is k where the surface is seen
/// edge-on.
fn roystan(positions: &[[f32; 4]], normals: &[[f32; 4]], steepest: f64) -> Vec<f64> {
    let nearness = |x: i64, y: i64| {
        let depth_m = f64::from(positions[inside(x, y)][3]);
        if depth_m > 0.0 { 1.0 / depth_m } else { 0.0 }
    };
    let normal = |x: i64, y: i64| {
        let [x, y, z, _] = normals[inside(x, y)];
        DVec3::new(x.into(), y.into(), z.into())
    };
    let view = view();
    let edge = |(x, y): (i64, i64)| {
        let across =
            (nearness(x + 1, y + 1) - nearness(x - 1, y - 1)).hypot(nearness(x - 1, y + 1) - nearness(x + 1, y - 1));
        let ray = view.ray(glam::DVec2::new(x as f64 + 0.5, y as f64 + 0.5)).normalize();
        let turned = ((1.0 + normal(x, y).dot(ray) - 0.5) / 0.5).clamp(0.0, 1.0);
        let k = 1.0 + (steepest - 1.0) * turned;
        let depth = 100.0 * across / (1.5 * nearness(x, y).max(nearness(x - 1, y - 1)) * k).max(1e-30);
        let [n1, n2] = [((1, 1), (-1, -1)), ((-1, 1), (1, -1))]
            .map(|((ax, ay), (bx, by))| (normal(x + ax, y + ay) - normal(x + bx, y + by)).length() * 0.5);
        let bent = n1.hypot(n2) / 0.4;
        if [depth, bent].into_iter().any(|share| (share - 1.0).abs() < 1e-4) {
            return f64::NAN;
        }
        f64::from(u8::from(depth > 1.0 || bent > 1.0))
    };
    places().map(edge).collect()
}

#[test]
fn roystans_outline_is_its_twin() {
    let Some(mut bench) = Bench::new() else { return };
    let found = errors_of(&mut bench, Detector::Roystan);
    let (positions, normals) = land();
    let differing = |steepest: f64| {
        let expected = roystan(&positions, &normals, steepest);
        let unsure = expected.iter().filter(|edge| edge.is_nan()).count();
        assert!(unsure < 20, "{unsure} pixels are undecided");
        found.iter().zip(&expected).filter(|(found, expected)| (**found - **expected).abs() > 0.5).count()
    };
    assert_eq!(differing(8.0), 0);
    let edges = found.iter().filter(|edge| **edge > 0.5).count();
    assert!((100..found.len() - 100).contains(&edges), "{edges} edges");
    // Planted error: a threshold that does not grow as the surface turns away.
    assert!(differing(1.0) > 20);
}

/// Returns the ramp of the filtered error: the smallest error in a line of `2 * radius + 1` pixels, times `density`, is
/// subtracted.
fn thresholded(errors: &[[f64; 4]], lines: &Lines, radius: i64) -> Vec<f64> {
    let load = |x: i64, y: i64| errors[inside(x, y)].map(|error| error.clamp(0.0, 1.0));
    let most = |errors: [f64; 4]| errors.into_iter().fold(f64::MIN, f64::max);
    let [low, high] = lines.ramp.map(f64::from);
    let value = |(x, y): (i64, i64)| {
        let here = load(x, y);
        let mut error = most(here);
        if lines.density > 0.0 && error > low {
            let mut least = here;
            for i in -radius..=radius {
                let along = [load(x + i, y), load(x, y + i), load(x + i, y + i), load(x + i, y - i)];
                least = std::array::from_fn(|axis| least[axis].min(along[axis][axis]));
            }
            if lines.detector != Detector::Lsa {
                least = [least.into_iter().fold(f64::MAX, f64::min); 4];
            }
            error = most(std::array::from_fn(|axis| here[axis] - f64::from(lines.density) * least[axis]));
        }
        ((error - low) / (high - low)).clamp(0.0, 1.0)
    };
    places().map(value).collect()
}

#[test]
fn the_density_filter_is_its_twin() {
    let Some(mut bench) = Bench::new() else { return };
    // Lines on noise, and an area where every pixel is an edge.
    let errors: Vec<[half::f16; 4]> = places()
        .map(|(x, y)| {
            let ground = |axis: i64| 0.3 * chance(x, y, 10 + axis);
            let line = if x % 13 == 5 || (x + y) % 17 == 3 { 0.9 } else { 0.0 };
            let crowd = if x > 40 && y > 25 { 0.7 + 0.3 * chance(x, y, 20) } else { 0.0 };
            std::array::from_fn(|axis| half::f16::from_f64(f64::max(ground(axis as i64) + line, crowd)))
        })
        .collect();
    let picture = bench.picture(&ERRORS, SIZE_PX, &bits(&errors));
    let exact: Vec<[f64; 4]> = errors.iter().map(|errors| errors.map(half::f16::to_f64)).collect();
    for detector in [Detector::Lsa, Detector::Sobel] {
        for density in [0.0, 1.0, 2.0] {
            let lines =
                Lines { detector, density, ramp: [0.1, 0.6], ..Style::load("lsa").unwrap().lines().cloned().unwrap() };
            let line = bench.out(&LINE);
            bench.run(|recorder| {
                let view = &recorder.uniform("view", &view().uniform(DVec3::ZERO));
                let inputs = threshold::Inputs { view, errors: &picture, directions: None, line: &line };
                threshold::run(recorder, &lines, &inputs);
            });
            let found = bench.floats(&line);
            assert_eq!(off(&found, &thresholded(&exact, &lines, 2), 1e-4), 0, "{detector:?}, density {density}");
            // Planted errors: a line of three pixels, and one of seven.
            for radius in [1, 3] {
                let differing = off(&found, &thresholded(&exact, &lines, radius), 1e-4);
                assert!(
                    density == 0.0 || differing > 50,
                    "{detector:?}, density {density}, radius {radius}: {differing}"
                );
            }
        }
    }
}

/// Like [`thresholded`], for eight directions: two for each axis.
fn thresholded_eight(errors: &[[f64; 8]], lines: &Lines) -> Vec<f64> {
    let load = |x: i64, y: i64| errors[inside(x, y)].map(|error| error.clamp(0.0, 1.0));
    let [low, high] = lines.ramp.map(f64::from);
    let value = |(x, y): (i64, i64)| {
        let here = load(x, y);
        let mut least = here;
        for i in -2..=2 {
            let along = [load(x + i, y), load(x, y + i), load(x + i, y + i), load(x + i, y - i)];
            least = std::array::from_fn(|direction| least[direction].min(along[direction / 2][direction]));
        }
        let left = (0..8).map(|direction| here[direction] - f64::from(lines.density) * least[direction]);
        ((left.fold(f64::MIN, f64::max) - low) / (high - low)).clamp(0.0, 1.0)
    };
    places().map(value).collect()
}

#[test]
fn the_density_filter_of_eight_directions_is_its_twin() {
    let Some(mut bench) = Bench::new() else { return };
    let errors: Vec<[half::f16; 8]> = places()
        .map(|(x, y)| {
            let line = if x % 13 == 5 || (x + y) % 17 == 3 { 0.8 } else { 0.0 };
            let crowd = if x > 40 && y > 25 { 0.9 * chance(x, y, 20) } else { 0.0 };
            std::array::from_fn(|i| {
                // One side of an axis has errors where the other has none.
                let ground = 0.4 * chance(x, y, 10 + i as i64);
                half::f16::from_f64(f64::max(ground, if i % 2 == 0 { line } else { crowd }))
            })
        })
        .collect();
    let exact: Vec<[f64; 8]> = errors.iter().map(|errors| errors.map(half::f16::to_f64)).collect();
    let merged: Vec<[half::f16; 4]> =
        errors.iter().map(|errors| std::array::from_fn(|axis| errors[2 * axis].max(errors[2 * axis + 1]))).collect();
    let words: Vec<[u32; 4]> = errors
        .iter()
        .map(|errors| {
            let bits = errors.map(|error| (error.to_f64().clamp(0.0, 1.0) * 65_535.0).round() as u32);
            std::array::from_fn(|axis| bits[2 * axis] | bits[2 * axis + 1] << 16)
        })
        .collect();
    let picture = bench.picture(&ERRORS, SIZE_PX, &bits(&merged));
    let directions = bench.picture(&DIRECTIONS, SIZE_PX, &words);
    let lines = Lines { density: 2.0, ramp: [0.0, 0.6], ..Style::load("lsa").unwrap().lines().cloned().unwrap() };
    let line = bench.out(&LINE);
    bench.run(|recorder| {
        let view = &recorder.uniform("view", &view().uniform(DVec3::ZERO));
        let inputs = threshold::Inputs { view, errors: &picture, directions: Some(&directions), line: &line };
        threshold::run(recorder, &lines, &inputs);
    });
    let found = bench.floats(&line);
    assert_eq!(off(&found, &thresholded_eight(&exact, &lines), 1e-4), 0);
    // Planted error: opposite directions share the larger error.
    let halved: Vec<[f64; 4]> = merged.iter().map(|errors| errors.map(half::f16::to_f64)).collect();
    assert!(off(&found, &thresholded(&halved, &lines, 2), 1e-4) > 50);
}
