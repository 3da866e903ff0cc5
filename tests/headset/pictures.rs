//! Tests that each eye shows what the library draws for its pose, which is computed here from the runtime's numbers
//! alone.

use glam::{DMat3, DQuat, DVec3};
use hachure::frame::PICTURE;
use hachure::frame::{self, Renderer};
use hachure::scene::view::{Lens, Part, Pose, Rig, View};
use hachure::style::Style;
use hachure::world::OpenWorld;
use hachure::world::TerrainOptions;

use crate::Room;
use crate::common::draw::halves;
use crate::common::{all_lines, full};

const SIZES_PX: [[u32; 2]; 2] = [[96, 80], [80, 72]];
/// The same values as in `Room::fly`.
const YAW_DEG: f64 = 315.0;
const CAMERA_EAST_NORTH_M: [f64; 2] = [900.0, -900.0];
const CAMERA_ABOVE_GROUND_M: f64 = 20.0;
const EYES_ABOVE_FLOOR_M: f64 = 1.6;

/// Returns for each eye what the runtime dumped of the last frame: position, orientation and angles of the lens, and
/// the bytes of the image, whose size is in `images_px`.
fn last_frame(room: &Room, images_px: [[u32; 2]; 2]) -> [([f64; 11], Vec<u8>); 2] {
    let table = std::fs::read_to_string(room.path("dump/poses.csv")).unwrap();
    let rows: Vec<Vec<f64>> =
        table.lines().map(|line| line.split(',').map(|text| text.parse().unwrap()).collect()).collect();
    [0, 1].map(|eye| {
        let row = &rows[rows.len() - 2 + eye];
        assert_eq!(row[1], eye as f64);
        let [width, height] = images_px[eye];
        let name = format!("dump/{:05}-{eye}-{width}x{height}.raw", row[0]);
        (std::array::from_fn(|i| row[2 + i]), std::fs::read(room.path(&name)).unwrap())
    })
}

/// Returns the eyes in the axes of the OpenXR specification (y up, −z ahead), in a room whose floor is at `floor_m`.
fn rig(eyes: &[[f64; 11]; 2], sizes_px: [[u32; 2]; 2], floor_m: DVec3, scale: f64) -> Rig {
    let yaw = YAW_DEG.to_radians();
    let north = DMat3::from_cols(DVec3::X, DVec3::Z, -DVec3::Y);
    let world_from_room = DMat3::from_rotation_z(-yaw) * north;
    let views = [0, 1].map(|eye: usize| {
        let [x, y, z, qx, qy, qz, qw, left, right, up, down] = eyes[eye];
        let turn = world_from_room * DMat3::from_quat(DQuat::from_xyzw(qx, qy, qz, qw).normalize());
        let pose = Pose {
            position_m: floor_m + world_from_room * DVec3::new(x, y, z) * scale,
            forward: turn * -DVec3::Z,
            right: turn * DVec3::X,
            up: turn * DVec3::Y,
            fov_rad: up - down,
        };
        let lens = Some(Lens { left: -left.tan(), right: right.tan(), up: up.tan(), down: -down.tan() });
        let (jitter_px, picture_px, part) = (glam::DVec2::ZERO, sizes_px[eye], Part::whole(sizes_px[eye]));
        let still = View::of_part(pose, pose, picture_px, part);
        View { lens, previous_lens: lens, jitter_px, ..still }
    });
    let origin_m = 0.5 * (views[0].pose.position_m + views[1].pose.position_m);
    Rig { origin_m, eyes: views.to_vec() }
}

/// Returns the part of the pixels in which a channel differs by more than 2 of 255.
fn off(shown: &[u8], drawn: &[[f64; 4]]) -> f64 {
    let encoded = |linear: f64| {
        let linear = linear.clamp(0.0, 1.0);
        255.0 * if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
    };
    let wrong = shown
        .chunks_exact(4)
        .zip(drawn)
        .filter(|(shown, drawn)| (0..3).any(|i| (f64::from(shown[i]) - encoded(drawn[i])).abs() > 2.0));
    wrong.count() as f64 / drawn.len() as f64
}

/// Returns the upper left corner of an image of four bytes per pixel. Checks that its border goes on beyond it.
fn corner(bytes: &[u8], [width, height]: [u32; 2], [columns, rows]: [u32; 2]) -> Vec<u8> {
    let at = |column: u32, row: u32| (4 * (row * width + column)) as usize;
    for row in 0..height {
        for column in columns..width {
            let [here, border] = [at(column, row), at(columns - 1, row.min(rows - 1))];
            assert_eq!(bytes[here..here + 4], bytes[border..border + 4], "pixel {column}, {row}");
        }
    }
    (0..rows).flat_map(|row| bytes[at(0, row)..at(0, row) + 4 * columns as usize].iter().copied()).collect()
}

/// Flies with a script, a style and a number of frames, draws the last frame again with the library in `style`, and
/// compares the two. Returns the largest part of an eye's pixels that differ.
pub(crate) fn difference(
    room: &Room,
    script: &[(&str, &str)],
    (flown, frames): (&str, &str),
    style: &Style,
    scale: f64,
) -> f64 {
    difference_at(room, script, &["--frames", frames, "--style", flown], (style, 1.0, SIZES_PX), scale)
}

/// Compares as [`difference`] does, for a flight with `arguments`, whose pictures have `resolution` times the runtime's
/// size. They are the upper left parts of the images, and their borders go on beyond them.
fn difference_at(
    room: &Room,
    script: &[(&str, &str)],
    arguments: &[&str],
    (style, resolution, images_px): (&Style, f64, [[u32; 2]; 2]),
    scale: f64,
) -> f64 {
    let _ = std::fs::remove_dir_all(room.path("dump"));
    std::fs::create_dir(room.path("dump")).unwrap();
    let dump = room.path("dump");
    let sizes = images_px.map(|[width, height]| format!("{width}x{height}")).join(",");
    let script = [script, &[("DUMP", dump.to_str().unwrap()), ("SIZES", &sizes)]].concat();
    room.fly(&script, &[arguments, &["--antialias", "none"]].concat()).well(&arguments.join(" "));
    let sizes_px = images_px.map(|size_px| size_px.map(|side| (f64::from(side) * resolution).round() as u32));
    let mut shown = last_frame(room, images_px);
    for (eye, (_, bytes)) in shown.iter_mut().enumerate() {
        *bytes = corner(bytes, images_px[eye], sizes_px[eye]);
    }

    let gpu = crate::common::gpu().unwrap();
    let world = room.path("world.tif");
    let mut world = OpenWorld::open(&gpu, Some(world.to_str().unwrap()), TerrainOptions::default()).unwrap();
    let [east_m, north_m] = CAMERA_EAST_NORTH_M;
    let mut floor_m =
        DVec3::new(east_m, north_m, world.ground_m(east_m, north_m) + CAMERA_ABOVE_GROUND_M - EYES_ABOVE_FLOOR_M);
    let eyes = [shown[0].0, shown[1].0];
    if scale != 1.0 {
        // A giant's head is at the same position as the person's, and the ground is at table height.
        let head_m = rig(&eyes, sizes_px, floor_m, 1.0).origin_m;
        floor_m += head_m - rig(&eyes, sizes_px, floor_m, scale).origin_m;
        floor_m.z = world.ground_m(head_m.x, head_m.y) - 0.7 * scale;
    }
    let rig = rig(&eyes, sizes_px, floor_m, scale);
    let apart_m = rig.eyes[0].pose.position_m.distance(rig.eyes[1].pose.position_m);
    assert!((apart_m - 0.063 * scale).abs() < 1e-3 * scale, "{apart_m} m");
    let light = world.light();
    let mut renderer = Renderer::new(&gpu).unwrap();
    // Tiles and horizon maps are loaded synchronously; the second frame has all of them.
    for _ in 0..2 {
        let prepared = frame::prepare(&gpu, &mut world.surfaces, &rig, style, &light);
        renderer.render_rig(&gpu, &world.surfaces, &prepared, &rig, style, &light).unwrap();
    }
    gpu.check().unwrap();
    let drawn = [0, 1].map(|eye| halves(&gpu, renderer.eye_target(eye, &PICTURE).unwrap()));
    let most = [0, 1].map(|eye| off(&shown[eye].1, &drawn[eye])).into_iter().fold(0.0, f64::max);
    println!("{} at 1:{scale}: {most} of the pixels differ", style.name);
    // Planted: swapped eyes. Their sizes differ, so lenses and poses are swapped instead.
    let mut exchanged = rig.clone();
    exchanged.eyes.swap(0, 1);
    for (view, size_px) in exchanged.eyes.iter_mut().zip(sizes_px) {
        (view.picture_px, view.part) = (size_px, Part::whole(size_px));
    }
    let prepared = frame::prepare(&gpu, &mut world.surfaces, &exchanged, style, &light);
    renderer.render_rig(&gpu, &world.surfaces, &prepared, &exchanged, style, &light).unwrap();
    for (eye, (_, shown)) in shown.iter().enumerate() {
        let off = off(shown, &halves(&gpu, renderer.eye_target(eye, &PICTURE).unwrap()));
        assert!(off > 0.03, "{}: swapped eyes were not detected ({off})", style.name);
    }
    most
}

/// Compares as [`difference`] does; the pictures must be the same.
fn compare(room: &Room, script: &[(&str, &str)], style: &str, scale: f64) {
    let off = difference(room, script, (style, "14"), &Style::load(style).unwrap(), scale);
    assert!(off < 0.01, "{style}: {off} of the pixels differ");
}

#[test]
fn each_eye_is_shown_what_the_library_draws() {
    let Some(room) = Room::with_hill() else { return };
    for style in ["lsa", "plain"].into_iter().take(if full() { 2 } else { 1 }) {
        compare(&room, &[], style, 1.0);
    }
}

/// A lower resolution is a part of the runtime's image, and the same drawing.
#[test]
fn a_level_of_quality_is_what_the_library_draws_at_its_resolution() {
    let Some(room) = Room::with_hill() else { return };
    let front = room.path("front-lsa.toml");
    let text = "style = \"lsa\"\nadapter = \"any\"\nsize = [96, 80]\ncost = \"GPU ms\"\n\n[[points]]\n\
                levels = [\"draft\"]\ncost = 1.0\ncost_ratio = 0.5\n\n[points.set]\nscale = \"0.5\"\n\n[points.errors]\ntone_error_percent = 1.0\n";
    std::fs::write(&front, text).unwrap();
    let style = Style::load("lsa").unwrap().scaled(0.5);
    // With a budget that nothing holds, pictures are a part of textures of the runtime's size. They are so large that the
    // processor is not the limit, because then the governor would not act.
    let large_px = SIZES_PX.map(|size_px| size_px.map(|side| 4 * side));
    for (quality, images_px) in [(["--quality", "draft"], SIZES_PX), (["--budget", "0.02"], large_px)] {
        let frames = if full() { "40" } else { "16" };
        let common = ["--frames", frames, "--style", "lsa", "--front", front.to_str().unwrap()];
        let off = difference_at(&room, &[], &[&common[..], &quality].concat(), (&style, 0.5, images_px), 1.0);
        assert!(off < 0.01, "{quality:?}: {off} of the pixels differ");
    }
}

#[test]
fn a_giants_eyes_stand_far_apart() {
    let Some(room) = Room::with_hill() else { return };
    let script = [("MOTION", "none"), ("PUSHES", "3-5:/user/hand/right/input/a/click")];
    compare(&room, &script, "lsa", 1000.0);
}

#[test]
fn the_border_is_dark_on_the_way() {
    let Some(room) = Room::with_hill() else { return };
    let dump = room.path("dump");
    // Returns the red of the upper left corner and of the middle, for each eye.
    let seen = |script: &[(&str, &str)]| {
        let _ = std::fs::remove_dir_all(&dump);
        std::fs::create_dir(&dump).unwrap();
        let script = [script, &[("DUMP", dump.to_str().unwrap()), ("SIZES", "96x80,80x72")]].concat();
        room.fly(&script, &["--frames", "60", "--style", "plain"]).well("flying");
        let shown = last_frame(&room, SIZES_PX);
        [0, 1].map(|eye| {
            let [width, height] = SIZES_PX[eye].map(|side| side as usize);
            [0, 4 * (width * (height / 2) + width / 2)].map(|at| shown[eye].1[at])
        })
    };
    let rest = seen(&[]);
    let flying = seen(&[("PUSHES", "5-999:/user/hand/left/input/thumbstick:0:1")]);
    for (rest, flying) in rest.iter().zip(flying) {
        assert!(rest.iter().all(|red| *red > 60), "at rest the picture must be bright: {rest:?}");
        assert!(
            flying[0] < 48 && flying[1] > 60,
            "in flight the border must be dark and the middle bright: {flying:?}"
        );
    }
}

#[test]
fn what_nobody_sees_is_not_drawn() {
    let Some(room) = Room::with_hill() else { return };
    let dump = room.path("dump");
    let shown = |style: &str, mask: &[(&str, &str)]| {
        let _ = std::fs::remove_dir_all(&dump);
        std::fs::create_dir(&dump).unwrap();
        let script = [mask, &[("DUMP", dump.to_str().unwrap()), ("SIZES", "96x80,80x72"), ("MOTION", "none")]].concat();
        room.fly(&script, &["--frames", "14", "--style", style, "--antialias", "none"]).well(style);
        last_frame(&room, SIZES_PX).map(|(_, bytes)| bytes)
    };
    // A cap counts lines in windows, some of which extend into hidden parts.
    let mut ink = all_lines("lsa");
    // Level land would be white, like parts that are not drawn.
    ink.light.level_deg = 0.0;
    let ink_file = room.path("lsa.toml");
    std::fs::write(&ink_file, ink.text()).unwrap();
    let cases = if full() { 2 } else { 1 };
    for style in [ink_file.to_str().unwrap(), "plain"].into_iter().take(cases) {
        let whole = shown(style, &[]);
        // The runtime's hidden corners are a quarter of each side; after frame 5 they are two fifths.
        for (mask, part) in [("5", 0.4), ("corners", 0.25)].into_iter().take(cases) {
            let masked = shown(style, &[("MASK", mask)]);
            for eye in [0, 1] {
                let [width, height] = SIZES_PX[eye].map(|side| side as usize);
                // 0 in the corner, 1 at the edge of the hidden part.
                let depth = |pixel: usize| {
                    let along = |at: usize, side: usize| (at.min(side - 1 - at) as f64 + 0.5) / (part * side as f64);
                    along(pixel % width, width) + along(pixel / width, height)
                };
                let differs = |pixel: usize| whole[eye][4 * pixel..][..3] != masked[eye][4 * pixel..][..3];
                let all = 0..width * height;
                let seen = all.clone().filter(|pixel| depth(*pixel) >= 1.0 && differs(*pixel)).count();
                // Only hidden pixels of land count, because the upper corners are sky in any case.
                let below = width * height / 2;
                let hidden: Vec<_> = all.filter(|pixel| *pixel > below && depth(*pixel) < 0.5).collect();
                let undrawn = hidden.iter().filter(|pixel| differs(**pixel)).count();
                println!(
                    "{style}, {mask}, eye {eye}: {seen} seen pixels differ, {undrawn} of {} hidden ones",
                    hidden.len()
                );
                assert_eq!(seen, 0, "{style}, {mask}, eye {eye}");
                assert!(undrawn * 10 > hidden.len() * 9, "{style}, {mask}, eye {eye}: {undrawn} of {}", hidden.len());
            }
        }
    }
}
