//! Every kind of ink from every extreme view, of land from 1 mm to 10 km between samples, and 10,000 km from the origin.

use glam::DVec3;
use hachure::frame::Light;
use hachure::scene::stereo::Pair;
use hachure::scene::view::Pose;
use hachure::style::{self, Style};

use super::checked::{Checked, SIZE_PX};
use super::lands::{Camera, EXTREME, Land, ORDINARY, SPACING_M};
use crate::tests::common::draw::{NOON, north_west, still};
use crate::tests::common::full;

/// A preset for each kind of ink: curvature, rows, cuts, water, relief, and lines from shading.
const KINDS: [&str; 6] = ["suggestive", "hachures", "engraving", "wash", "relief", "tone-lines"];

/// Returns the presets to draw.
pub(super) fn kinds() -> Vec<Style> {
    let is_wanted = |name: &&str| full() || KINDS.contains(name);
    style::names().into_iter().filter(is_wanted).map(|name| Style::load(name).unwrap()).collect()
}

/// Suns at the horizon, below it, and straight above and below.
pub(super) fn suns() -> [(&'static str, Light); 5] {
    let light = |x: f64, y: f64, z: f64| Light { to_sun: DVec3::new(x, y, z).normalize(), ..NOON };
    [
        ("the sun at the horizon", light(-0.8, 0.6, 0.0)),
        ("the sun below the horizon", light(-0.8, 0.6, -0.4)),
        ("the sun straight below", light(0.0, 0.0, -1.0)),
        ("the sun straight above", light(0.0, 0.0, 1.0)),
        ("the sun behind the horizon's edge", light(0.0, 1.0, -1e-9)),
    ]
}

/// Draws a style from all views, under all suns, and in pictures of few pixels. The fast tier draws every fourth of
/// these cases; which ones depends on the number of the style.
fn draw_all(checked: &mut Checked, poses: &[(&Camera, Pose)], land: &str, style: &Style, number: usize) {
    let [(_, ordinary), ..] = poses else { return };
    let of_view = |(camera, pose): &(&Camera, Pose)| (camera.name.to_owned(), *pose, SIZE_PX, north_west());
    let mut cases: Vec<_> = poses.iter().map(of_view).collect();
    let suns = suns().into_iter().take(if full() { 5 } else { 3 });
    cases.extend(suns.map(|(sun, light)| (sun.to_owned(), *ordinary, SIZE_PX, light)));
    let thin: &[[u32; 2]] = if full() { &[[1, 1], [2, 1], [1, 60], [300, 1]] } else { &[[1, 1]] };
    cases.extend(thin.iter().map(|size_px| (format!("{size_px:?} px"), *ordinary, *size_px, north_west())));
    let (first, step) = if full() { (0, 1) } else { (number % 4, 4) };
    for (name, pose, size_px, light) in cases.into_iter().skip(first).step_by(step) {
        checked.case(&format!("{}, {land}, {name}", style.name), pose, size_px, style, &light);
    }
}

fn poses(land: &Land) -> Vec<(&'static Camera, Pose)> {
    let most = if full() { EXTREME.len() } else { 7 };
    [&ORDINARY].into_iter().chain(&EXTREME[..most]).map(|camera| (camera, land.pose(camera))).collect()
}

#[test]
fn every_kind_of_ink_is_finite_from_every_view() {
    let spacings_m = if full() { &[SPACING_M, 0.001, 10_000.0, 0.03, 1.0, 500.0][..] } else { &[SPACING_M] };
    for spacing_m in spacings_m {
        let Some(land) = Land::of_spacing(*spacing_m) else { return };
        let (poses, name) = (poses(&land), land.name);
        let mut checked = Checked::new(land.world);
        for (number, mut style) in kinds().into_iter().enumerate() {
            // At their usual spacing, rows take as long as ten other kinds.
            if let Some(rows) = style.rows_mut().filter(|_| !full()) {
                rows.spacing_px *= 2.0;
            }
            draw_all(&mut checked, &poses, &name, &style, number);
        }
        checked.finish(&name);
    }
}

#[test]
fn every_kind_of_ink_is_finite_on_land_of_every_spacing() {
    for land in [Land::of_spacing(0.001), Land::of_spacing(10_000.0), Land::far()] {
        let Some(land) = land else { return };
        let cameras = if full() { &EXTREME[..] } else { &EXTREME[1..2] };
        let poses: Vec<_> = [&ORDINARY].into_iter().chain(cameras).map(|camera| (camera, land.pose(camera))).collect();
        let mut checked = Checked::new(land.world);
        for style in kinds() {
            for (camera, pose) in &poses {
                let name = format!("{}, {}, {}", style.name, land.name, camera.name);
                checked.case(&name, *pose, SIZE_PX, &style, &north_west());
                let ground = checked.ground();
                assert!(camera.name != ORDINARY.name || ground > 0.3, "{name}: {ground} of the picture is ground");
                if !full() {
                    continue;
                }
                let next = Pose { position_m: pose.position_m + pose.right * (0.3 * land.factor), ..*pose };
                checked.then(&name, [*pose, next], SIZE_PX, &style, &north_west());
            }
        }
        checked.finish(&land.name);
    }
}

#[test]
fn pairs_of_eyes_are_finite() {
    let Some(land) = Land::of_spacing(SPACING_M) else { return };
    let poses = poses(&land);
    let mut checked = Checked::new(land.world);
    let views = if full() { poses.len() } else { 1 };
    for style in kinds().into_iter().filter(|style| full() || style.name == "wash") {
        for (camera, pose) in poses.iter().take(views) {
            for ipd_m in [0.0, 0.065, 1e6].into_iter().skip(if full() { 0 } else { 2 }) {
                let rig = Pair { ipd_m, convergence_m: (ipd_m > 0.0).then_some(0.01) }.rig(&still(*pose, SIZE_PX));
                checked.renderer.forget();
                let (gpu, surfaces) = (&checked.world.gpu, &mut checked.world.surfaces);
                checked.renderer.render_eyes(gpu, surfaces, &rig, &style, &north_west()).unwrap();
                gpu.check().unwrap();
                checked.frames += 1;
                let found = checked.renderer.take_non_finite();
                checked.note(&format!("{}, eyes {ipd_m} m apart, {}", style.name, camera.name), &found);
            }
        }
    }
    checked.finish("pairs of eyes");
}
