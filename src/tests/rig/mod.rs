//! Tests of frames with one eye and with two: passes hold no state of a frame, however the passes are submitted.
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a test may panic, and writes to scratch folders")]

mod background;
mod eyes;
mod lens;
mod live;
mod room;
mod steady;
mod switches;

use glam::DVec3;
use hachure::composite::PICTURE;
use hachure::frame::{self, Light, Renderer};
use hachure::gpu::readback::read;
use hachure::gpu::target::TargetKind;
use hachure::scene::view::{Pose, Rig, View};
use hachure::style::Style;
use hachure::surface::SURFACE_ID;
use hachure::surface::{DISTANCE, NORMAL};

use crate::tests::common::draw::halves;
use crate::tests::common::hill::Hill;
use crate::tests::common::{World, full, presets};

const SIZE_PX: [u32; 2] = [128, 72];
const START: &str = "900,-900,+20,315,3,60";

fn hill() -> Option<World> {
    World::new(Hill::square(321, 10.0).1, 1.0)
}

/// Returns a hill on its own device.
fn hill_apart() -> Option<World> {
    World::on_own_device(Hill::square(321, 10.0).1, 1.0)
}

/// Returns the presets that a test of all kinds of passes draws: in the fast tier one of each kind of lines, and one of
/// strokes and marks.
fn few_presets() -> Vec<&'static str> {
    if full() { presets() } else { vec!["lsa", "tone-lines", "crosshatch"] }
}

fn light() -> Light {
    Light { to_sun: DVec3::new(-0.5, 0.5, 0.4).normalize(), haze_m: 30_000.0, haze_srgb: None, focus: None }
}

fn view(previous: Pose, pose: Pose) -> View {
    View::whole(previous, pose, SIZE_PX)
}

/// Returns a pose to the right of another one.
fn shifted_right(pose: Pose, right_m: f64) -> Pose {
    Pose { position_m: pose.position_m + pose.right * right_m, ..pose }
}

/// Draws all eyes of a rig.
fn draw_rig(world: &mut World, renderer: &mut Renderer, style: &Style, rig: &Rig) {
    let light = light();
    renderer.set_wants_ids(true);
    let prepared = frame::prepare(&world.gpu, &mut world.surfaces, rig, style, &light);
    renderer.render_rig(&world.gpu, &world.surfaces, &prepared, rig, style, &light).unwrap();
    world.gpu.check().unwrap();
}

fn bytes(world: &World, renderer: &Renderer, eye: usize, kind: &TargetKind) -> Vec<u8> {
    read(&world.gpu, renderer.eye_target(eye, kind).unwrap(), [0, 0], SIZE_PX).unwrap()
}

/// Returns the bits of an eye's targets: the surface and the picture.
fn seen(world: &World, renderer: &Renderer, eye: usize) -> [Vec<u8>; 4] {
    [&DISTANCE, &NORMAL, &SURFACE_ID, &PICTURE].map(|kind| bytes(world, renderer, eye, kind))
}

/// Counts bytes that differ.
fn differing(a: &[Vec<u8>; 4], b: &[Vec<u8>; 4]) -> usize {
    a.iter().zip(b).flat_map(|(a, b)| a.iter().zip(b)).filter(|(a, b)| a != b).count()
}

/// Returns the brightness of the picture, from 0 to 1.
fn luma(world: &World, renderer: &Renderer) -> Vec<f32> {
    let luma = |[red, green, blue, _]: [f64; 4]| 0.2126 * red + 0.7152 * green + 0.0722 * blue;
    halves(&world.gpu, renderer.target(&PICTURE).unwrap()).into_iter().map(|texel| luma(texel) as f32).collect()
}

/// Returns the part of the pixels whose brightness differs by more than 0.1.
fn differs(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).filter(|(a, b)| (*a - *b).abs() > 0.1).count() as f64 / a.len() as f64
}
