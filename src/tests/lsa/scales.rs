//! Measures how many lines remain in pictures of fewer pixels, which a window draws at a smaller scale.
//!
//! The truth is where depth jumps in a picture with four times as many pixels on each side, so contours are known to a
//! quarter of a pixel. *Recall* is the share of contours with a line within 2 px in the drawn picture; *precision* is
//! the share of its line pixels with a jump, however small, within 2 px.

use glam::DVec2;
use hachure::frame::Renderer;
use hachure::gpu::readback::read_as;
use hachure::scene::view::{Pose, View};
use hachure::source::{Silent, procedural};
use hachure::style::Style;

use crate::tests::common::draw::{NOON, draw, places};
use crate::tests::common::shot::ink;
use crate::tests::common::{World, full};
use crate::tests::helpers::styles::of_outlines;

const SIZE_PX: [u32; 2] = [480, 270];
const SCALES: [f64; 4] = [1.0, 0.75, 0.5, 0.25];
/// Pixels of the truth per pixel of the whole picture, on each side.
const FINER: u32 = 4;
const REACH_PX: f64 = 2.0;
/// Least jump that a person would draw, as in `common::silhouette`: as a part of the distance, in pixels, and relative
/// to the change of depth per pixel of the surface behind.
const JUMP_PART: f64 = 0.02;
const JUMP_PX: f64 = 8.0;
const JUMP_FLOW: f64 = 4.0;
/// Least jump of any kind.
const MIN_JUMP_PART: f64 = 0.002;
const MIN_JUMP_FLOW: f64 = 1.5;

/// Points on contours and on jumps of any kind, as parts of the picture's sides.
#[derive(Default)]
struct Truth {
    contours: Vec<DVec2>,
    jumps: Vec<DVec2>,
}

/// Finds contours and jumps in the depths of a picture, row by row.
fn truth(view: &View, depths_m: &[f64]) -> Truth {
    let [width, height] = view.part.size_px.map(|side| side as usize);
    let mut truth = Truth::default();
    let px_m = f64::from(FINER) / view.focal_px();
    for pixel in 0..width * height {
        let (x, y) = (pixel % width, pixel / width);
        for (other, middle, inside) in
            [(pixel + 1, [1.0, 0.5], x + 1 < width), (pixel + width, [0.5, 1.0], y + 1 < height)]
        {
            if !inside {
                continue;
            }
            let [a_m, b_m] = [pixel, other].map(|pixel| depths_m[pixel]);
            let (near_m, far_m) = (a_m.min(b_m), a_m.max(b_m));
            if near_m.is_infinite() {
                continue;
            }
            let (nearer, behind) = if a_m <= b_m { (pixel, other) } else { (other, pixel) };
            let beyond_m = (2 * behind).checked_sub(nearer).and_then(|beyond| depths_m.get(beyond));
            let flow_m = beyond_m.map_or(0.0, |beyond_m| (beyond_m - far_m).abs());
            let flow_m = if flow_m.is_finite() { flow_m } else { 0.0 };
            let jump_m = far_m - near_m;
            let place = DVec2::new((x as f64 + middle[0]) / width as f64, (y as f64 + middle[1]) / height as f64);
            if jump_m > (MIN_JUMP_PART * near_m).max(MIN_JUMP_FLOW * flow_m) {
                truth.jumps.push(place);
            }
            if jump_m > (JUMP_PART.max(JUMP_PX * px_m) * near_m).max(JUMP_FLOW * flow_m) {
                truth.contours.push(place);
            }
        }
    }
    truth
}

/// Returns whether any pixel of `is` is within [`REACH_PX`] of a point of a picture.
fn is_near(is: &[bool], size_px: [u32; 2], at_px: DVec2) -> bool {
    let reach = REACH_PX.ceil() as i64 + 1;
    let middle = at_px.floor().as_i64vec2();
    (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| [middle.x + x, middle.y + y])).any(|[x, y]| {
        let inside = (0..i64::from(size_px[0])).contains(&x) && (0..i64::from(size_px[1])).contains(&y);
        let apart_px = DVec2::new(x as f64 + 0.5, y as f64 + 0.5).distance(at_px);
        inside && apart_px <= REACH_PX && is[(y * i64::from(size_px[0]) + x) as usize]
    })
}

/// Returns recall and precision of the lines of a picture.
fn quality(line: &[f64], size_px: [u32; 2], truth: &Truth) -> [f64; 2] {
    let scale = DVec2::new(size_px[0].into(), size_px[1].into());
    let is_line: Vec<bool> = line.iter().map(|line| *line > 0.5).collect();
    let drawn = truth.contours.iter().filter(|place| is_near(&is_line, size_px, **place * scale)).count();
    let mut is_jump = vec![false; line.len()];
    for place in &truth.jumps {
        let [x, y] = (*place * scale).floor().to_array().map(|at| at as usize);
        is_jump[y.min(size_px[1] as usize - 1) * size_px[0] as usize + x.min(size_px[0] as usize - 1)] = true;
    }
    let lines: Vec<usize> = (0..line.len()).filter(|pixel| is_line[*pixel]).collect();
    let width = size_px[0] as usize;
    let centre = |pixel: &usize| DVec2::new((pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5);
    let right = lines.iter().filter(|pixel| is_near(&is_jump, size_px, centre(pixel))).count();
    [drawn as f64 / truth.contours.len().max(1) as f64, right as f64 / lines.len().max(1) as f64]
}

/// Returns the distance along the view axis in each pixel, in metres, without drawing anything but the surface.
fn depths_m(world: &mut World, renderer: &mut Renderer, view: &View) -> Vec<f64> {
    draw(&world.gpu, &mut world.surfaces, renderer, view, &Style::load("plain").unwrap(), &NOON);
    let positions = places(&world.gpu, renderer, 0);
    positions.into_iter().map(|[.., depth_m]| if depth_m > 0.0 { depth_m.into() } else { f64::INFINITY }).collect()
}

/// Draws a picture and returns its lines.
fn lines(world: &mut World, renderer: &mut Renderer, pose: Pose, size_px: [u32; 2], style: &Style) -> Vec<f64> {
    draw(&world.gpu, &mut world.surfaces, renderer, &View::whole(pose, pose, size_px), style, &NOON);
    let line = renderer.line_target(0, style).unwrap();
    let texels: Vec<f32> = read_as(&world.gpu, line, [0, 0], size_px).unwrap();
    texels.into_iter().map(f64::from).collect()
}

/// Returns the detectors as the paper compares them, its full method first: the others thin out crowded lines at half
/// strength.
/// None has a cap of crowded lines, which would remove what detectors find.
fn detectors() -> Vec<(&'static str, Style)> {
    let of = |mut style: Style, is_full: bool| {
        let lines = style.lines_mut().unwrap();
        (lines.geometric_antialias, lines.halved, lines.density) = (is_full, !is_full, if is_full { 2.0 } else { 1.0 });
        lines.crowd = 1.0;
        style
    };
    let preset = |name| Style::load(name).unwrap();
    let full_method = ("full", of(of_outlines(ink("footprint")), true));
    // The others are only compared with it, so the fast tier does without them.
    let others = || {
        [
            ("base", of(ink("footprint"), false)),
            ("Sobel", of(preset("sobel"), false)),
            ("Roystan", of(preset("roystan"), false)),
        ]
    };
    [full_method].into_iter().chain(full().then(others).into_iter().flatten()).collect()
}

fn table(name: &str, world: Option<World>, views: &[&str]) {
    let Some(mut world) = world else { return };
    let mut drawn = Renderer::new(&world.gpu).unwrap();
    let detectors = detectors();
    // The fast tier draws the whole and half scales.
    let every = if full() { 1 } else { 2 };
    let mut sums = vec![[[0.0; 2]; SCALES.len()]; detectors.len()];
    for view in views {
        let pose = world.pose(view);
        let fine = View::whole(pose, pose, SIZE_PX.map(|side| FINER * side));
        let truth = truth(&fine, &depths_m(&mut world, &mut drawn, &fine));
        assert!(truth.contours.len() > 1000, "{name}, {view}: {} contours are too few", truth.contours.len());
        for ((detector, style), sums) in detectors.iter().zip(&mut sums) {
            for (scale, sum) in SCALES.iter().zip(sums).step_by(every) {
                let size_px = SIZE_PX.map(|side| (f64::from(side) * scale).round() as u32);
                let line = lines(&mut world, &mut drawn, pose, size_px, style);
                let found = quality(&line, size_px, &truth);
                *sum = std::array::from_fn(|i| sum[i] + found[i] / views.len() as f64);
                // Planted: lines moved 6 px to the right, and no lines.
                let mut moved = line.clone();
                moved.rotate_right(6);
                let planted = quality(&moved, size_px, &truth);
                assert!(
                    planted[0] < found[0] && planted[1] < found[1],
                    "{name}, {view}, {detector}, {scale}: moved lines were not detected: {planted:?}, unmoved {found:?}"
                );
                assert!(quality(&vec![0.0; line.len()], size_px, &truth)[0] == 0.0);
            }
        }
    }
    println!("{name}: recall and precision at the scales {SCALES:?}, or at every second of them");
    for ((detector, _), sums) in detectors.iter().zip(&sums) {
        let cell = |[recall, precision]: &[f64; 2]| format!("{:.1} {:.1}", 100.0 * recall, 100.0 * precision);
        let cells: Vec<String> = sums.iter().step_by(every).map(cell).collect();
        println!("  {detector:8} {}", cells.join(" | "));
    }
    let [whole, half] = [0, 2].map(|scale| sums[0][scale][0]);
    assert!(half >= 0.9 * whole, "{name}: recall of the full method falls from {whole} to {half} at half scale");
}

#[test]
fn lines_are_left_in_pictures_of_fewer_pixels() {
    let views = ["-300,-2500,+350,20,-6,60", "900,-900,+60,315,0,60"];
    let count = if full() { 2 } else { 1 };
    table("mountains", World::new(procedural::generate_sized(1, 512, 24.0, &Silent), 1.0), &views[..count]);
    if !full() {
        return;
    }
    let views = ["-8000,-12000,+1500,30,-12,50", "3000,2000,+200,160,-5,60"];
    table("Rainier", World::filled("dem/geotiff/mt_rainier_90m.tif", 1.0), &views);
}
