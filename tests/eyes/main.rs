//! Two eyes draw one drawing: how well they agree, and what must not depend on which of them comes first.
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a test fails by panicking, into scratch folders")]

#[path = "../common/mod.rs"]
mod common;

mod agreement;

use glam::DVec3;
use hachure::frame::{self, Frame, Light};
use hachure::gpu::Gpu;
use hachure::measure::report::Metrics;
use hachure::measure::stereo::StereoTotals;
use hachure::measure::temporal::{DrawnFrame, read_drawn};
use hachure::scene::stereo::Pair;
use hachure::scene::view::{Pose, Rig, View};
use hachure::style::Style;
use hachure::world::Surfaces;

const SIZE_PX: [u32; 2] = [640, 360];

fn light() -> Light {
    Light { to_sun: DVec3::new(-0.5, 0.5, 0.4).normalize(), haze_m: 30_000.0, haze_srgb: None }
}

/// Two eyes at a camera that rests.
fn rig(pose: Pose, ipd_m: f64) -> Rig {
    Pair { ipd_m, convergence_m: None }.rig(&View::whole(pose, pose, SIZE_PX))
}

/// What both eyes draw of a style's first frame.
fn draw(gpu: &Gpu, surfaces: &mut Surfaces, style: &Style, rig: &Rig) -> Vec<DrawnFrame> {
    let mut frame = Frame::new(gpu).unwrap();
    let prepared = frame::prepare(gpu, surfaces, rig, style, &light());
    frame.render_rig(gpu, surfaces, &prepared, rig, style, &light()).unwrap();
    gpu.check().unwrap();
    (0..rig.eyes.len()).map(|eye| read_drawn(gpu, &frame, rig, eye, style).unwrap()).collect()
}

fn agreement(eyes: &[DrawnFrame]) -> Metrics {
    let mut totals = StereoTotals::default();
    totals.add(&eyes[0], &eyes[1]).unwrap();
    totals.metrics().unwrap()
}
