//! Two eyes draw one drawing: how well they agree, and that the result does not depend on which of them comes first.
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a panic fails the test; files are temporary")]

mod agreement;
mod exchange;
mod extremes;
mod near;

use glam::DVec3;
use hachure::frame::{self, Light, Renderer};
use hachure::gpu::Gpu;
use hachure::measure::report::Metrics;
use hachure::measure::stereo::StereoTotals;
use hachure::measure::temporal::{DrawnFrame, read_drawn};
use hachure::scene::stereo::Pair;
use hachure::scene::view::{Pose, Rig, View};
use hachure::style::{Lines, Stereo, Style};
use hachure::world::Surfaces;

const LIGHT: Light = Light { to_sun: DVec3::Z, haze_m: 30_000.0, haze_srgb: None, focus: None };

/// Returns a stereo pair for a camera at rest.
fn rig(pose: Pose, ipd_m: f64, size_px: [u32; 2]) -> Rig {
    Pair { ipd_m, convergence_m: None }.rig(&View::whole(pose, pose, size_px))
}

/// Draws the first frame of a style.
fn frame_of(gpu: &Gpu, surfaces: &mut Surfaces, style: &Style, rig: &Rig) -> Renderer {
    let mut renderer = Renderer::new(gpu).unwrap();
    let prepared = frame::prepare(gpu, surfaces, rig, style, &LIGHT);
    renderer.render_rig(gpu, surfaces, &prepared, rig, style, &LIGHT).unwrap();
    gpu.check().unwrap();
    renderer
}

/// Draws the first frame of a style and reads back all eyes.
fn draw(gpu: &Gpu, surfaces: &mut Surfaces, style: &Style, rig: &Rig) -> Vec<DrawnFrame> {
    let renderer = frame_of(gpu, surfaces, style, rig);
    (0..rig.eyes.len()).map(|eye| read_drawn(gpu, &renderer, rig, eye, style).unwrap()).collect()
}

fn agreement(eyes: &[DrawnFrame]) -> Metrics {
    let mut totals = StereoTotals::default();
    totals.add(&eyes[0], &eyes[1]).unwrap();
    totals.metrics().unwrap()
}

/// Loads a preset and changes its lines.
fn with_lines(name: &str, change: impl FnOnce(&mut Lines)) -> Style {
    let mut style = Style::load(name).unwrap();
    change(style.lines_mut().unwrap());
    style
}

/// Loads `ink` without agreement between the eyes.
fn ink_alone() -> Style {
    with_lines("lsa", |lines| lines.stereo = Stereo::Alone)
}
