//! `render --aov-names standard`: channels of an EXR under the names that compositors use, on a slope of known shape.

#![allow(clippy::unwrap_used, reason = "a panic fails the test, in helpers too")]

#[path = "../src/tests/common/program.rs"]
mod program;

use std::path::Path;

use exr::prelude::{FlatSamples, MetaData, ReadChannels, ReadLayers};

/// Slope of the land: the rise in metres per metre to the east and to the north.
const RISE: [f64; 2] = [0.2, 0.1];
const SIDE: usize = 96;
const SPACING_M: f64 = 30.0;
const MIDDLE_M: f64 = 900.0;
const SIZE: [usize; 2] = [96, 54];
const RENDER: &str = "slope.asc --size 96x54 --camera=50,-700,1150,10,-14,50 --aov depth,position,normal,surface";

/// Creates a folder with a DEM of a plane. The origin of the world is its centre.
fn place() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let middle = 0.5 * (SIDE as f64 - 1.0);
    let mut text = format!("ncols {SIDE}\nnrows {SIDE}\nxllcorner 0\nyllcorner 0\ncellsize {SPACING_M}\n");
    for row in 0..SIDE {
        let height_m = |column: usize| {
            let [east_m, north_m] = [column as f64 - middle, middle - row as f64].map(|at| at * SPACING_M);
            MIDDLE_M + RISE[0] * east_m + RISE[1] * north_m
        };
        let heights: Vec<String> = (0..SIDE).map(|column| format!("{:.3}", height_m(column))).collect();
        text += &(heights.join(" ") + "\n");
    }
    hachure::file::atomic::write(&folder.path().join("slope.asc"), text.as_bytes()).unwrap();
    folder
}

/// Reads the float channels of an EXR by name, with the crate `exr` alone.
fn floats(path: &Path) -> impl Fn(&str) -> Vec<f32> + use<> {
    let image = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels();
    let image = image.first_valid_layer().all_attributes().from_file(path).unwrap();
    let list = image.layer_data.channel_data.list;
    move |name| {
        let channel = list.iter().find(|channel| channel.name.to_string() == name).expect(name);
        match &channel.sample_data {
            FlatSamples::F32(values) => values.clone(),
            _ => panic!("{name} is not a float channel"),
        }
    }
}

fn names(path: &Path) -> Vec<String> {
    let found = MetaData::read_from_file(path, false).unwrap();
    found.headers[0].channels.list.iter().map(|channel| channel.name.to_string()).collect()
}

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|value| value.to_bits()).collect()
}

#[test]
fn standard_names_have_the_values_of_the_others() {
    let folder = place();
    program::draw(folder.path(), &format!("{RENDER} -o own.exr"));
    program::draw(folder.path(), &format!("{RENDER} --aov-names standard -o standard.exr"));
    let path = folder.path().join("standard.exr");
    let expected = ["A", "B", "G", "N.X", "N.Y", "N.Z", "P.X", "P.Y", "P.Z", "R", "Z", "surface.id"];
    assert_eq!(names(&path), expected);
    let (own, standard) = (floats(&folder.path().join("own.exr")), floats(&path));
    for (own_name, name) in
        [("R", "R"), ("depth.V", "Z"), ("normal.X", "N.X"), ("normal.Y", "N.Y"), ("normal.Z", "N.Z")]
    {
        assert_eq!(bits(&own(own_name)), bits(&standard(name)), "{name}");
    }
    assert_ne!(bits(&own("normal.X")), bits(&standard("N.Y")), "planted error, axes exchanged");
    // Channels `position` are relative to the camera, channels P to the world's origin.
    let depth = standard("Z");
    let seen: Vec<usize> = (0..depth.len()).filter(|i| depth[*i].is_finite()).collect();
    assert!(
        seen.len() > depth.len() / 2 && seen.len() < depth.len(),
        "the picture must have land and sky; pixels of land: {}",
        seen.len()
    );
    for (axis, camera_m) in [("X", 50.0), ("Y", -700.0), ("Z", 1150.0)] {
        let (from_camera, place) = (own(&format!("position.{axis}")), standard(&format!("P.{axis}")));
        assert!(
            seen.iter().all(|i| (place[*i] - from_camera[*i] - camera_m).abs() < 1e-3),
            "P.{axis} differs from position plus camera"
        );
        assert!((0..depth.len()).all(|i| depth[i].is_finite() || place[i] == 0.0), "P.{axis} must be 0 in the sky");
    }
}

/// Returns four largest errors: of positions from the slope in metres; of normals; of positions, projected with the
/// file's matrix, from their pixels; of depths from the distance along the view axis in metres.
fn farthest_off(path: &Path, [x, y, z]: [&[f32]; 3], [nx, ny, nz]: [&[f32]; 3], depth: &[f32]) -> [f64; 4] {
    let header = MetaData::read_from_file(path, false).unwrap().headers.remove(0);
    let (camera, ndc) = (header.own_attributes.world_to_camera, header.own_attributes.world_to_normalized_device);
    let (camera, ndc) = (camera.unwrap(), ndc.unwrap());
    let length = (RISE[0] * RISE[0] + RISE[1] * RISE[1] + 1.0).sqrt();
    let mut off = [0.0_f64; 4];
    for i in (0..depth.len()).filter(|i| depth[*i].is_finite()) {
        let at = [x[i], y[i], z[i]].map(f64::from);
        // Cells at the border of the heights have one neighbour less, and another slope.
        let inner_m = (0.5 * SIDE as f64 - 3.0) * SPACING_M;
        if at[0].abs().max(at[1].abs()) > inner_m {
            continue;
        }
        // Multiplies a row vector by a matrix that is stored row by row.
        let times = |matrix: [f32; 16]| -> [f64; 4] {
            let row = [at[0], at[1], at[2], 1.0];
            std::array::from_fn(|to| (0..4).map(|k| row[k] * f64::from(matrix[4 * k + to])).sum())
        };
        let (seen, ndc) = (times(camera), times(ndc));
        let px = [0.5 * (1.0 + ndc[0] / ndc[3]) * SIZE[0] as f64, 0.5 * (1.0 - ndc[1] / ndc[3]) * SIZE[1] as f64];
        let pixel = [i % SIZE[0], i / SIZE[0]].map(|at| at as f64 + 0.5);
        let normal = [nx[i], ny[i], nz[i]].map(f64::from);
        let of_pixel = [
            (MIDDLE_M + RISE[0] * at[0] + RISE[1] * at[1] - at[2]).abs(),
            (normal[0] + RISE[0] / length)
                .abs()
                .max((normal[1] + RISE[1] / length).abs())
                .max((normal[2] - 1.0 / length).abs()),
            (px[0] - pixel[0]).hypot(px[1] - pixel[1]),
            (seen[2] + f64::from(depth[i])).abs(),
        ];
        off = std::array::from_fn(|k| off[k].max(of_pixel[k]));
    }
    off
}

#[test]
fn places_and_normals_are_those_of_the_slope() {
    let folder = place();
    program::draw(folder.path(), &format!("{RENDER} --aov-names standard -o a.exr"));
    let path = folder.path().join("a.exr");
    let of = floats(&path);
    let [x, y, z, nx, ny, nz, depth] = ["P.X", "P.Y", "P.Z", "N.X", "N.Y", "N.Z", "Z"].map(of);
    let off = farthest_off(&path, [&x, &y, &z], [&nx, &ny, &nz], &depth);
    println!(
        "errors of positions {:.4} m, of normals {:.5}, of projections {:.4} px, of depths {:.4} m",
        off[0], off[1], off[2], off[3]
    );
    let holds = |off: [f64; 4]| off[0] < 0.05 && off[1] < 0.002 && off[2] < 0.02 && off[3] < 0.02;
    assert!(holds(off), "errors of positions, normals, projections, depths: {off:?}");
    // Planted errors: positions relative to the camera, exchanged axes, and distances to the eye in place of depths.
    let from_camera: Vec<f32> = z.iter().map(|z| z - 1150.0).collect();
    assert!(!holds(farthest_off(&path, [&x, &y, &from_camera], [&nx, &ny, &nz], &depth)));
    assert!(!holds(farthest_off(&path, [&x, &z, &y], [&nx, &ny, &nz], &depth)));
    assert!(!holds(farthest_off(&path, [&x, &y, &z], [&ny, &nx, &nz], &depth)));
    let eye_m = [50.0, -700.0, 1150.0];
    let distance = |i: usize| (x[i] - eye_m[0]).hypot(y[i] - eye_m[1]).hypot(z[i] - eye_m[2]);
    let to_eye: Vec<f32> =
        (0..depth.len()).map(|i| if depth[i].is_finite() { distance(i) } else { f32::INFINITY }).collect();
    assert!(!holds(farthest_off(&path, [&x, &y, &z], [&nx, &ny, &nz], &to_eye)));
}

#[test]
fn an_exr_has_its_camera() {
    let folder = place();
    program::draw(folder.path(), "slope.asc --size 128x72 --camera=10,-1600,1700,30,-20,50 --dpi 200 -o a.exr");
    let found = MetaData::read_from_file(folder.path().join("a.exr"), false).unwrap();
    let own = &found.headers[0].own_attributes;
    assert_eq!(own.horizontal_density, Some(200.0));
    // Multiplies a row vector by a matrix in row-major order.
    let times = |point: [f64; 3], matrix: [f32; 16]| -> [f64; 4] {
        let row = [point[0], point[1], point[2], 1.0];
        std::array::from_fn(|i| (0..4).map(|k| row[k] * f64::from(matrix[4 * k + i])).sum())
    };
    let (camera, ndc) = (own.world_to_camera.unwrap(), own.world_to_normalized_device.unwrap());
    let (yaw, pitch) = (30f64.to_radians(), (-20f64).to_radians());
    let ahead = [yaw.sin() * pitch.cos(), yaw.cos() * pitch.cos(), pitch.sin()];
    let right = [yaw.cos(), -yaw.sin(), 0.0];
    let eye = [10.0, -1600.0, 1700.0];
    let at = |ahead_m: f64, right_m: f64| std::array::from_fn(|i| eye[i] + ahead_m * ahead[i] + right_m * right[i]);
    let near = |a: [f64; 4], b: [f64; 4]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.01);
    assert!(near(times(at(500.0, 20.0), camera), [20.0, 0.0, -500.0, 1.0]), "{:?}", times(at(500.0, 20.0), camera));
    assert!(!near(times(at(500.0, 20.0), camera), [-20.0, 0.0, -500.0, 1.0]));
    // A point at the right edge of the picture.
    let side_m = 500.0 * 25f64.to_radians().tan() * 128.0 / 72.0;
    let [x, y, z, w] = times(at(500.0, side_m), ndc);
    assert!(near([x / w, y / w, z / w, w], [1.0, 0.0, 0.0, 500.0]), "{:?}", [x, y, z, w]);
    assert!(near(times(eye, camera), [0.0, 0.0, 0.0, 1.0]));
}

#[test]
fn names_without_channels_are_reported() {
    let folder = place();
    for (arguments, words) in [
        ("slope.asc -o a.exr --aov-names standard", "--aov-names: requires --aov"),
        ("slope.asc -o a.exr --aov depth --aov-names nuke", "it must be hachure or standard"),
    ] {
        let output = program::run(folder.path(), arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success() && said.contains(words) && said.trim_end().lines().count() == 1, "{said}");
        assert!(!folder.path().join("a.exr").exists());
    }
}
