//! Tests camera, camera path and scene file: what is written can be read back, and errors name their cause.

#![allow(clippy::unwrap_used, reason = "the helpers of tests may panic")]

use std::path::Path;

use glam::{DVec2, DVec3};
use hachure::scene::camera::{Camera, CameraError};
use hachure::scene::path::CameraPath;
use hachure::scene::{Scene, Wind, World};
use hachure::source::{Encoding, HeightUnit, OpenOptions, TileRows, VoidMode};
use proptest::prelude::*;

fn camera(text: &str) -> Camera {
    text.parse().unwrap()
}

fn path(text: &str) -> Result<CameraPath, String> {
    CameraPath::parse(Path::new("flight.csv"), text.as_bytes()).map_err(|error| error.to_string())
}

fn scene(text: &str) -> Result<Scene, String> {
    Scene::parse(Path::new("terrain/alps.toml"), text).map_err(|error| error.to_string())
}

#[test]
fn haze_thins_with_height() {
    let light = scene("[world]\nprocedural = { seed = 7 }\n[haze]\ndistance_m = 20000\n").unwrap().light([1e5, 1e5]);
    let distance_m = |height_m: f64| light.for_eye_above(height_m).haze_m;
    // The mean density along a ray that falls through all the air above, step by step.
    let marched = |height_m: f64| {
        let steps = 100_000;
        let air = (0..steps).map(|i| (-(f64::from(i) + 0.5) / f64::from(steps) * height_m / 8000.0).exp()).sum::<f64>();
        20_000.0 * f64::from(steps) / air
    };
    for height_m in [1.0, 100.0, 3000.0, 30_000.0, 1e6] {
        let is_so = |height_m: f64, wanted_m: f64| (distance_m(height_m) / wanted_m - 1.0).abs() < 1e-3;
        assert!(is_so(height_m, marched(height_m)), "{height_m} m: {}", distance_m(height_m));
        assert!(!is_so(height_m, marched(height_m + 100.0)) || height_m > 1e5);
    }
    assert!([-5000.0, 0.0].iter().all(|height_m| (distance_m(*height_m) - 20_000.0).abs() < 0.1));
}

#[test]
fn a_scene_says_how_its_heights_are_read() {
    let keys = "encoding = \"gsi\"\nheight_unit = \"us-ft\"\nheight_scale_m = 0.5\nheight_offset_m = -7\n\
                tile_rows = \"tms\"\nnodata = 5\nvoids = \"holes\"\n";
    let heights = scene(&format!("[world]\ndem = \"a.png\"\n{keys}")).unwrap().heights;
    let wanted = OpenOptions {
        encoding: Some(Encoding::Gsi),
        height_unit: Some(HeightUnit::UsFt),
        height_scale_m: Some(0.5),
        height_offset_m: Some(-7.0),
        tile_rows: Some(TileRows::Tms),
        no_data: Some(5.0),
        voids: VoidMode::Holes,
        ..OpenOptions::default()
    };
    assert_eq!(heights, wanted);
    for line in keys.lines().filter(|line| !line.starts_with("voids")) {
        let key = line.split(' ').next().unwrap();
        let error = scene(&format!("[world]\ncontinent = {{}}\n{line}\n")).unwrap_err();
        assert!(error.contains(&format!("world.{key}: it says how a dem is read")), "{error}");
    }
    for line in ["height_scale_m = 0", "height_offset_m = nan", "nodata = inf"] {
        let error = scene(&format!("[world]\ndem = \"a.png\"\n{line}\n")).unwrap_err();
        assert!(error.contains("it must be"), "{error}");
    }
}

#[test]
fn camera_axes_follow_the_compass() {
    let north = camera("0,0,0,0,0,60");
    assert!(north.forward().abs_diff_eq(DVec3::Y, 1e-12));
    assert!(north.right().abs_diff_eq(DVec3::X, 1e-12));
    assert!(north.up().abs_diff_eq(DVec3::Z, 1e-12));
    let east = camera("0,0,0,90,0,60");
    assert!(east.forward().abs_diff_eq(DVec3::X, 1e-12));
    assert!(east.right().abs_diff_eq(-DVec3::Y, 1e-12));
    let down = camera("0,0,0,0,-90,60");
    assert!(down.forward().abs_diff_eq(-DVec3::Z, 1e-12));
    assert!(down.up().abs_diff_eq(DVec3::Y, 1e-12));
}

#[test]
fn camera_above_ground_is_set_on_it() {
    let above = camera(" 10, 20, +1.5, 0, 0, 50");
    assert!(above.height_above_ground);
    assert_eq!(above.to_string(), "10,20,+1.5,0,0,50");
    let resolved = above.on_ground(|x, y| x + y);
    assert_eq!(resolved.position_m.z, 31.5);
    assert!(!resolved.height_above_ground);
    assert_eq!(resolved.on_ground(|_, _| 1e9), resolved);
}

#[test]
fn camera_errors_name_the_field() {
    for (text, field) in [
        ("a,0,0,0,0,60", "x"),
        ("0,,0,0,0,60", "y"),
        ("0,0,++5,0,0,60", "z"),
        ("0,0,+,0,0,60", "z"),
        ("0,0,0,inf,0,60", "yaw"),
        ("0,0,0,0,91,60", "pitch"),
        ("0,0,0,0,0,0", "fov"),
        ("0,0,0,0,0,180", "fov"),
        ("0,0,0,0,0,NaN", "fov"),
        ("1e300,0,0,0,0,60", "x"),
    ] {
        match text.parse::<Camera>() {
            Err(CameraError::Field { field: named, .. }) => assert_eq!(named, field, "{text}"),
            other => panic!("{text}: {other:?}"),
        }
    }
    let error = "1,2,3".parse::<Camera>().unwrap_err().to_string();
    assert_eq!(error, "a camera is x,y,z,yaw,pitch,fov (6 numbers), but this has 3");
}

#[test]
fn path_yaw_takes_the_shorter_way() {
    let path = path("t,x,y,z,yaw,pitch,fov\n0,0,0,0,350,0,60\n1,0,0,0,10,0,60\n").unwrap();
    let middle = path.sample(0.5);
    assert!((middle.yaw_deg.rem_euclid(360.0)).min(360.0 - middle.yaw_deg.rem_euclid(360.0)) < 1e-9, "{middle}");
}

#[test]
fn path_counts_frames() {
    let moving = path("t,x,y,z,yaw,pitch,fov\n2,0,0,0,0,0,60\n2.1,1,0,0,0,0,60\n").unwrap();
    assert_eq!(moving.frames(30.0).len(), 4);
    assert!((moving.frames(30.0).last().unwrap().position_m.x - 1.0).abs() < 1e-9);
    let spread: Vec<f64> = moving.spread(3).map(|camera| camera.position_m.x).collect();
    assert!((spread[1] - 0.5).abs() < 1e-9 && spread[2] == 1.0);
    let still = path("t,x,y,z,yaw,pitch,fov\n0,1,2,+3,0,0,60\n").unwrap();
    assert_eq!((still.duration_s(), still.frame_count(60.0)), (0.0, 1));
    assert_eq!(still.sample(99.0), camera("1,2,+3,0,0,60"));
}

#[test]
fn path_errors_name_file_line_and_cause() {
    let header = "t,x,y,z,yaw,pitch,fov\n";
    let row = "0,0,0,0,0,0,60\n";
    for (text, expected) in [
        ("t,x,y\n0,0,0\n".to_owned(), "flight.csv:1: the header is `t,x,y`"),
        (header.to_owned(), "flight.csv:2: a camera path needs at least one row"),
        (format!("{header}{row}{row}"), "flight.csv:3: t is 0 again"),
        (format!("{header}{row}1,0,0,0,0,0,60\n0.5,0,0,0,0,0,60\n"), "flight.csv:4: t is 0.5 after 1"),
        (format!("{header}{row}1,0,0\n"), "flight.csv:3: found 3 fields"),
        (format!("{header}{row}1,0,0,0,0,0,abc\n"), "flight.csv:3: the camera's fov is `abc`: not a number"),
        (format!("{header}{row}1,0,0,+5,0,0,60\n"), "flight.csv:3: z is above the ground"),
        (format!("{header}NaN,0,0,0,0,0,60\n"), "flight.csv:2: t is `NaN`"),
        ("t,x,y,z,yaw,pitch,fov,ease\n0,0,0,0,0,0,60\n".to_owned(), "flight.csv:2: found 7 fields; there must be 8"),
        (format!("{header}0,0,0,0,0,0,60,1\n"), "flight.csv:2: found 8 fields; there must be 7"),
        ("t,x,y,z,yaw,pitch,fov,ease\n0,0,0,0,0,0,60,1.5\n".to_owned(), "flight.csv:2: ease is `1.5`; it must be"),
        ("t,x,y,z,yaw,pitch,fov,ease\n0,0,0,0,0,0,60,NaN\n".to_owned(), "flight.csv:2: ease is `NaN`; it must be"),
    ] {
        let error = path(&text).unwrap_err();
        assert!(error.starts_with(expected), "{error}");
        assert!(!error.contains('\n'));
    }
    let error = CameraPath::read(Path::new("no/such.csv")).unwrap_err().to_string();
    assert!(error.contains("no/such.csv"), "{error}");
}

#[test]
fn path_of_both_kinds_stands_on_the_ground() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("p.csv");
    hachure::file::atomic::write(&file, b"t,x,y,z,yaw,pitch,fov\n0,0,0,+5,0,0,60\n1,0,0,200,0,0,60\n").unwrap();
    let path = CameraPath::read_on_ground(&file, |_, _| 100.0).unwrap();
    assert_eq!(path.sample(0.0).position_m.z, 105.0);
    assert_eq!(path.sample(1.0).position_m.z, 200.0);
}

#[test]
fn a_camera_slows_down_where_its_row_says() {
    let eased = |ease: [&str; 4]| {
        let rows: String =
            ease.iter().enumerate().map(|(t, ease)| format!("{t},{},{},9,0,0,60,{ease}\n", t * t, 5 * t)).collect();
        path(&format!("t,x,y,z,yaw,pitch,fov,ease\n{rows}")).unwrap()
    };
    let plain: String = (0..4).map(|t| format!("{t},{},{},9,0,0,60\n", t * t, 5 * t)).collect();
    let plain = path(&format!("t,x,y,z,yaw,pitch,fov\n{plain}")).unwrap();
    assert_eq!(eased(["", "0", " ", "0.0"]), plain, "no ease is the curve of files without the column");
    let speed = |path: &CameraPath, at_s: f64| {
        (path.sample(at_s + 1e-5).position_m - path.sample(at_s - 1e-5).position_m).length() / 2e-5
    };
    let rests = eased(["1", "0.5", "1", "0"]);
    for (at_s, part) in [(1.0, 0.5), (2.0, 0.0), (3.0 - 2e-5, 1.0)] {
        let (speed, before) = (speed(&rests, at_s), speed(&plain, at_s));
        assert!((speed - part * before).abs() < 2e-2, "{at_s} s: {speed} of {before}");
    }
    assert!(speed(&rests, 2e-5) < 1e-2, "it starts from rest");
    for row in 0..4 {
        assert_eq!(rests.sample(f64::from(row)).position_m, plain.sample(f64::from(row)).position_m);
        assert!(kink(|t| rests.sample(t).position_m, 2.0, 1e-5) < 1e-2);
    }
}

/// Returns how far the velocities from the left and from the right differ at a row.
fn kink(sample: impl Fn(f64) -> DVec3, at_s: f64, step_s: f64) -> f64 {
    let left = (sample(at_s) - sample(at_s - step_s)) / step_s;
    let right = (sample(at_s + step_s) - sample(at_s)) / step_s;
    left.distance(right)
}

#[test]
fn kink_finds_a_planted_corner() {
    // A polyline passes through its rows but is not C1, which the measure must detect.
    let corner = |t: f64| DVec3::new(t, (t - 1.0).abs(), 0.0);
    assert!(kink(corner, 1.0, 1e-4) > 1.0);
}

proptest! {
    #[test]
    fn camera_round_trips(
        x in -1e8..1e8, y in -1e8..1e8, z in -1e4..1e4, above: bool,
        yaw in -720.0..720.0, pitch in -90.0..90.0, fov in 0.1..170.0,
    ) {
        let camera = Camera {
            position_m: DVec3::new(x, y, z), height_above_ground: above,
            yaw_deg: yaw, pitch_deg: pitch, fov_deg: fov,
        };
        prop_assert_eq!(camera.to_string().parse::<Camera>().unwrap(), camera);
        let (forward, right, up) = (camera.forward(), camera.right(), camera.up());
        for (a, b, expected) in [(forward, forward, 1.0), (right, right, 1.0), (up, up, 1.0), (forward, right, 0.0),
            (forward, up, 0.0), (right, up, 0.0)] {
            prop_assert!((a.dot(b) - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn camera_parser_never_panics(text in "[-+0-9.,einfNa ]{0,40}") {
        let _ = text.parse::<Camera>();
    }

    #[test]
    fn path_passes_through_its_rows_and_is_smooth(
        rows in prop::collection::vec(
            (0.1..5.0f64, -100.0..100.0f64, -100.0..100.0f64, 0.0..360.0f64, -60.0..60.0f64, 20.0..90.0f64), 1..8)
    ) {
        let mut text = String::from("t,x,y,z,yaw,pitch,fov\n");
        let mut time_s = 0.0;
        let mut given = Vec::new();
        for &(step_s, x, y, yaw, pitch, fov) in &rows {
            time_s += step_s;
            text += &format!("{time_s},{x},{y},{},{yaw},{pitch},{fov}\n", x + y);
            given.push((time_s, x, y, yaw, fov));
        }
        let path = path(&text).unwrap();
        for &(time_s, x, y, yaw, fov) in &given {
            let camera = path.sample(time_s);
            prop_assert!((camera.position_m - DVec3::new(x, y, x + y)).length() < 1e-9);
            prop_assert!(((camera.yaw_deg - yaw + 180.0).rem_euclid(360.0) - 180.0).abs() < 1e-9);
            prop_assert!((camera.fov_deg - fov).abs() < 1e-9);
        }
        for row in given.iter().take(given.len() - 1).skip(1) {
            // For a smooth path the difference is the curvature times the step, so it falls with the step; at a corner
            // it stays.
            let angles = |t: f64| { let c = path.sample(t); DVec3::new(c.yaw_deg, c.pitch_deg, 0.0) };
            for coarse_and_fine in [
                [1e-3, 1e-5].map(|step_s| kink(|t| path.sample(t).position_m, row.0, step_s)),
                [1e-3, 1e-5].map(|step_s| kink(angles, row.0, step_s)),
            ] {
                prop_assert!(coarse_and_fine[1] < 0.05 * coarse_and_fine[0] + 1e-3, "{coarse_and_fine:?}");
            }
        }
        for camera in path.frames(7.0) {
            prop_assert!(camera.position_m.is_finite() && camera.yaw_deg.is_finite());
            prop_assert!(camera.to_string().parse::<Camera>().is_ok(), "{camera}");
        }
    }
}

#[test]
fn scene_file_is_read() {
    let scene = scene(
        r##"
        vertical_exaggeration = 1.5
        [world]
        dem = "alps.tif"
        [sun]
        azimuth_deg = 135
        [haze]
        distance_m = 9000.0
        color = "#ff8000"
        [camera]
        start = "0,-10,+20,0,-5,50"
        "##,
    )
    .unwrap();
    assert_eq!(scene.world, World::File("terrain/alps.tif".into()));
    assert_eq!((scene.sun.azimuth_deg, scene.sun.elevation_deg), (135.0, 40.0));
    assert_eq!(scene.haze.distance_over_m([1.0, 1.0]), 9000.0);
    assert_eq!(scene.haze.color_srgb, Some([1.0, 128.0 / 255.0, 0.0]));
    assert_eq!(scene.start, Some(camera("0,-10,+20,0,-5,50")));
    assert_eq!(scene.vertical_exaggeration, 1.5);
    assert_eq!(scene.wind, None);
}

#[test]
fn wind_is_read() {
    let wind = |table: &str| scene(&format!("world.procedural.seed = 1\n{table}")).unwrap().wind;
    assert_eq!(wind("wind = { speed_m_s = 4, from_deg = 240 }"), Some(Wind { speed_m_s: 4.0, from_deg: 240.0 }));
    assert_eq!(wind("wind = {}"), Some(Wind { speed_m_s: 5.0, from_deg: 270.0 }));
    // Wind from the west blows to the east.
    assert!(wind("wind = {}").unwrap().toward().distance(DVec2::X) < 1e-12);
    assert_eq!(wind("wind = { speed_m_s = 0 }"), None);
    assert_eq!(wind(""), None);
}

#[test]
fn scene_file_defaults_and_worlds() {
    let least = scene("world.procedural.seed = 1").unwrap();
    assert_eq!(Scene { file: None, ..least }, Scene::default());
    assert_eq!(scene("[world]\ndem = \"/a/b.tif\"").unwrap().world, World::File("/a/b.tif".into()));
    assert_eq!(scene("[world]\ndem = \"s3://a/b.tif\"").unwrap().world, World::Url("s3://a/b.tif".into()));
    assert_eq!(Scene::default().haze.distance_over_m([3000.0, 4000.0]), 2250.0);
    assert!(Scene::default().sun.direction().z > 0.0);
}

#[test]
fn scene_errors_name_file_key_and_cause() {
    let world = "[world]\nprocedural = { seed = 1 }\n";
    for (text, expected) in [
        (String::new(), "terrain/alps.toml:1:1: the key \"world\" is missing"),
        ("[world]\n".to_owned(), "terrain/alps.toml:1:1: world: it needs dem"),
        ("[world]\ndem = \"a\"\nprocedural = { seed = 1 }\n".to_owned(), "terrain/alps.toml:1:1: world: it has both"),
        (
            format!("{world}[sun]\nazimut_deg = 5\n"),
            "terrain/alps.toml:4:1: unknown key \"sun.azimut_deg\"; did you mean \"azimuth_deg\"?",
        ),
        (
            format!("{world}[sun]\nazimuth_deg = \"x\"\n"),
            "terrain/alps.toml:4:15: sun.azimuth_deg must be a number, but \"x\" is text",
        ),
        (
            format!("{world}[sun]\nelevation_deg = nan\n"),
            "terrain/alps.toml:4:17: sun.elevation_deg: it must be between",
        ),
        (
            format!("{world}[wind]\nspeed_m_s = 61\n"),
            "terrain/alps.toml:4:13: wind.speed_m_s: it must be between 0 and 60",
        ),
        (format!("{world}[wind]\nfrom_deg = nan\n"), "terrain/alps.toml:4:12: wind.from_deg: it must be between"),
        (format!("{world}[haze]\ndistance_m = 0.0\n"), "terrain/alps.toml:4:14: haze.distance_m: it must be"),
        (format!("{world}[haze]\ncolor = \"#+1234f\"\n"), "terrain/alps.toml:4:9: haze.color: it must be written"),
        (format!("{world}[camera]\nstart = \"1,2\"\n"), "terrain/alps.toml:4:9: camera.start: a camera is"),
        (format!("vertical_exaggeration = 0.0\n{world}"), "terrain/alps.toml:1:25: vertical_exaggeration: it must"),
        (format!("{world}[sun\n"), "terrain/alps.toml:3:5: unclosed table"),
    ] {
        let error = scene(&text).unwrap_err();
        assert!(error.starts_with(expected), "{error}");
        assert!(!error.contains('\n'), "{error}");
    }
}
