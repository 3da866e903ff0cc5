//! Crowded lines and strokes are thinned out to the style's limit, without flickering more.
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use crate::tests::common;

use common::draw::{NOON, draw, still};
use common::{World, full, grid_of, rough_height_m};
use hachure::frame::{self, Renderer};
use hachure::gpu::readback::read;
use hachure::gpu::target::Target;
use hachure::lines::crowd::thin::UNCROWDED;
use hachure::lines::smooth::SMOOTHED;
use hachure::lines::stereo::agree::AGREED;
use hachure::lines::strokes::stroke::INK;
use hachure::picture::nearest::nearest_m;
use hachure::scene::stereo::{HYPERSTEREO, IPD_M, Pair};
use hachure::scene::view::{Pose, View};
use hachure::style::Style;

const SIZE_PX: [u32; 2] = [320, 192];
const CELL_PX: usize = 32;
/// A camera that sees mountain ranges one behind the other, to the horizon.
const RANGES: &str = "0,-22000,+1200,4,-7,50";

fn world() -> Option<World> {
    World::new(grid_of(1025, 1025, 60.0, rough_height_m), 0.0)
}

/// Reads a picture of one channel of 16 or 32 bits.
fn inks(world: &World, target: &Target) -> Vec<f64> {
    let bytes = read(&world.gpu, target, [0, 0], target.size_px()).unwrap();
    if target.texture.format() == wgpu::TextureFormat::R16Float {
        bytes.chunks_exact(2).map(|texel| half::f16::from_le_bytes([texel[0], texel[1]]).to_f64()).collect()
    } else {
        bytes.chunks_exact(4).map(|texel| f32::from_le_bytes(texel.try_into().unwrap()).into()).collect()
    }
}

/// Returns the mean ink of each cell.
fn cells(inks: &[f64]) -> Vec<f64> {
    let [width, height] = SIZE_PX.map(|side| side as usize);
    let mut means = Vec::new();
    for first_y in (0..height).step_by(CELL_PX) {
        for first_x in (0..width).step_by(CELL_PX) {
            let row = |y: usize| inks[y * width + first_x..][..CELL_PX].iter().sum::<f64>();
            means.push((first_y..first_y + CELL_PX).map(row).sum::<f64>() / (CELL_PX * CELL_PX) as f64);
        }
    }
    means
}

/// Loads a preset with `crowd` as the limit of its lines and strokes.
fn capped(name: &str, crowd: f32) -> Style {
    let mut style = Style::load(name).unwrap().without(&["water"]);
    style.lines_mut().into_iter().for_each(|lines| lines.crowd = crowd);
    // As many lines as presets merge leave too few for the planted error.
    style.strokes_mut().into_iter().for_each(|strokes| (strokes.crowd, strokes.merge_px) = (crowd, 1.5));
    style
}

/// Returns the limit of a style's strokes or lines; 1 is no limit.
fn cap_of(style: &Style) -> Option<f32> {
    let strokes = style.strokes().map(|strokes| strokes.crowd);
    strokes.or(style.lines().map(|lines| lines.crowd))
}

/// Returns the lines, or the strokes, of a view; `crowd` is the limit of both.
fn drawn(world: &mut World, renderer: &mut Renderer, name: &str, crowd: f32, ahead_m: f64) -> Vec<f64> {
    let style = capped(name, crowd);
    let mut pose = world.pose(RANGES);
    pose.position_m.y += ahead_m;
    draw(&world.gpu, &mut world.surfaces, renderer, &still(pose, SIZE_PX), &style, &NOON);
    let lines = if crowd < 1.0 { &UNCROWDED } else { &SMOOTHED };
    let target = renderer.target(if style.strokes().is_some() { &INK } else { lines }).unwrap().clone();
    inks(world, &target)
}

#[test]
fn no_cell_holds_more_ink_than_the_cap() {
    let Some(mut world) = world() else { return };
    let presets = [("lsa", 0.09), ("roystan", 0.09), ("strokes", 0.06)];
    for (name, cap) in presets.into_iter().filter(|(name, _)| full() || *name != "roystan") {
        let mut over = |crowd: f32| {
            let mut renderer = Renderer::new(&world.gpu).unwrap();
            let means = cells(&drawn(&mut world, &mut renderer, name, crowd, 0.0));
            let most = means.iter().copied().fold(0.0, f64::max);
            println!("{name} with {crowd}: most ink of a cell {most:.3}, mean {:.4}", means.iter().sum::<f64>() / 60.0);
            (means.iter().filter(|mean| **mean > 1.25 * f64::from(cap)).count(), means.iter().sum::<f64>())
        };
        let (capped, ink) = over(cap);
        assert_eq!(capped, 0, "{name}: cells with more ink than the limit allows");
        assert!(ink > 0.2, "{name}: hardly any lines are left");
        // Planted error: no limit.
        assert!(over(1.0).0 > 2, "{name} without a limit is not crowded");
    }
}

/// Returns the lines, or the strokes, that each of two eyes draws.
fn drawn_by_both(world: &mut World, pose: Pose, style: &Style, ipd_m: f64) -> [Vec<f64>; 2] {
    let rig = Pair { ipd_m, convergence_m: None }.rig(&View::whole(pose, pose, SIZE_PX));
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let prepared = frame::prepare(&world.gpu, &mut world.surfaces, &rig, style, &NOON);
    renderer.render_rig(&world.gpu, &world.surfaces, &prepared, &rig, style, &NOON).unwrap();
    world.gpu.check().unwrap();
    let kind = if style.strokes().is_some() { &INK } else { &AGREED };
    [0, 1].map(|eye| inks(world, &renderer.eye_target(eye, kind).unwrap().clone()))
}

#[test]
fn every_preset_with_lines_has_a_cap() {
    let lacks = |style: &Style| cap_of(style).is_some_and(|cap| cap >= 1.0);
    for name in common::presets() {
        assert!(!lacks(&Style::load(name).unwrap()), "{name} has no limit on crowded lines");
    }
    // Planted error: presets without a limit.
    assert!(lacks(&common::all_lines("lsa")) && lacks(&common::all_lines("wash")));
}

#[test]
fn no_cell_of_either_eye_holds_more_ink_than_the_cap() {
    let Some(mut world) = world() else { return };
    let pose = world.pose(RANGES);
    let presets = [("lsa", 0.09), ("strokes", 0.06), ("wash", 0.05)];
    for (name, cap) in presets.into_iter().filter(|(name, _)| full() || *name != "strokes") {
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let nearest = nearest_m(&world.gpu, &mut renderer, &mut world.surfaces, pose, &capped(name, 1.0)).unwrap();
        // The fast tier leaves out eyes as far apart as those of a person, which see nearly the same picture.
        let apart_m = [IPD_M, nearest.unwrap() * HYPERSTEREO];
        for ipd_m in apart_m.into_iter().skip(usize::from(!full())) {
            let mut over = |crowd: f32| {
                drawn_by_both(&mut world, pose, &capped(name, crowd), ipd_m).map(|inks| {
                    let means = cells(&inks);
                    let most = means.iter().copied().fold(0.0, f64::max);
                    let all: f64 = means.iter().sum();
                    println!("{name} with {crowd}, {ipd_m:.2} m: most ink of a cell {most:.3}, mean {:.4}", all / 60.0);
                    (means.iter().filter(|mean| **mean > 1.25 * f64::from(cap)).count(), all)
                })
            };
            for (capped, ink) in over(cap) {
                assert_eq!(capped, 0, "{name}, eyes {ipd_m:.2} m apart: cells with more ink than the limit allows");
                assert!(ink > 0.2, "{name}: hardly any lines are left");
            }
            // Planted error: no limit.
            assert!(over(1.0).iter().all(|(capped, _)| *capped > 1), "{name} without a limit is not crowded");
        }
    }
}

#[test]
fn thinned_lines_flicker_no_more_than_all_of_them() {
    let Some(mut world) = world() else { return };
    let mut flicker = |crowds: [f32; 2]| {
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let frames: Vec<Vec<f64>> = (0..8_u8)
            .map(|i| drawn(&mut world, &mut renderer, "lsa", crowds[usize::from(i % 2)], 1.5 * f64::from(i)))
            .collect();
        let ink: f64 = frames.iter().flatten().sum();
        let change = |pair: &[Vec<f64>]| pair[0].iter().zip(&pair[1]).map(|(a, b)| (a - b).abs()).sum::<f64>();
        let changed = frames.windows(2).map(change).sum::<f64>();
        [changed, changed / ink]
    };
    let [all, thinned, unsteady] = [[1.0; 2], [0.09; 2], [0.09, 0.06]].map(&mut flicker);
    println!(
        "ink that changes, absolute and as a fraction of all: all lines {all:.4?}, thinned {thinned:.4?}, unsteady {unsteady:.4?}"
    );
    // Half as much ink flickers. The fraction of the remaining ink is a little larger than without a limit, because
    // what appears and disappears are the soft ends of lines.
    assert!(thinned[0] <= 0.5 * all[0] && thinned[1] <= 1.4 * all[1], "thinned {thinned:?}, all lines {all:?}");
    // Planted error: a limit that changes from frame to frame.
    assert!(unsteady[0] > 0.5 * all[0] || unsteady[1] > 1.4 * all[1], "unsteady {unsteady:?}, all lines {all:?}");
}
