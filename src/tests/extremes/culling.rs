//! Blocks of rows that are culled change no picture, also in a turn, and few are left where land is wide.

use std::sync::Arc;
use std::time::Instant;

use glam::{DQuat, DVec3};
use hachure::frame::Renderer;
use hachure::gpu::readback::read;
use hachure::gpu::recorder::Submits;
use hachure::scene::stereo::Pair;
use hachure::scene::view::{Pose, Rig};
use hachure::style::Style;
use hachure::surface::rows::reach::Culling;
use hachure::surface::rows::ribbons::ROW_INK;
use hachure::tiles::Terrain;
use hachure::tiles::terrain::{Loading, TerrainOptions};

use super::lands::{EXTREME, Land, ORDINARY, SPACING_M};
use crate::tests::common::draw::{draw, north_west, still};
use crate::tests::common::{World, full, grid_of};

const SIZE_PX: [u32; 2] = [240, 180];

/// Spacing of marks so close that a small picture needs as many blocks as usual marks on a large one, in pixels.
const CLOSE_PX: f32 = 2.0;

fn style(spacing_px: f32) -> Style {
    let mut style = Style::load("hachures").unwrap();
    style.rows_mut().unwrap().spacing_px = spacing_px;
    style
}

fn renderer(world: &World, culling: Culling) -> Renderer {
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    renderer.set_row_culling(culling);
    renderer
}

/// Draws the eyes of a rig, and returns the ink of the rows of the last one.
fn row_ink(world: &mut World, renderer: &mut Renderer, rig: &Rig, style: &Style) -> Vec<u8> {
    renderer.forget();
    renderer.render_eyes(&world.gpu, &mut world.surfaces, rig, style, &north_west()).unwrap();
    world.gpu.wait();
    world.gpu.check().unwrap();
    let target = renderer.eye_target(rig.eyes.len() - 1, &ROW_INK).unwrap();
    read(&world.gpu, target, [0, 0], target.size_px()).unwrap()
}

fn mono(pose: Pose) -> Rig {
    Rig::mono(still(pose, SIZE_PX))
}

/// Returns the number of pixels with different ink.
fn differing(a: &[u8], b: &[u8]) -> usize {
    assert_eq!(a.len(), b.len());
    a.chunks_exact(2).zip(b.chunks_exact(2)).filter(|(a, b)| a != b).count()
}

/// Returns how many pixels of views differ from those without culling, with culling and with the planted error. One
/// renderer draws all, so that it builds each block once.
fn changed(world: &mut World, rigs: &[(String, Rig)], spacing_px: f32) -> [usize; 2] {
    let style = style(spacing_px);
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let (mut changed, mut inked, mut pixels) = ([0, 0], 0, 0);
    for (name, rig) in rigs {
        let drawings = [Culling::Nothing, Culling::ByReach, Culling::WithoutReach].map(|culling| {
            renderer.set_row_culling(culling);
            (row_ink(world, &mut renderer, rig, &style), renderer.row_blocks())
        });
        let [(reference, all), (ink, kept), (planted, without)] = drawings;
        let differ = [differing(&reference, &ink), differing(&reference, &planted)];
        println!("{name}: {kept} of {all} blocks, {without} without reach; {differ:?} pixels differ");
        changed = [changed[0] + differ[0], changed[1] + differ[1]];
        inked += reference.chunks_exact(2).filter(|ink| **ink != [0, 0]).count();
        pixels += reference.len() / 2;
    }
    // 4000 of 240 × 180.
    assert!(54 * inked > 5 * pixels, "{inked} of {pixels} pixels have ink");
    changed
}

#[test]
fn culling_changes_no_picture() {
    let Some(mut land) = Land::of_spacing(SPACING_M) else { return };
    let cameras = [&ORDINARY, &EXTREME[1], &EXTREME[2], &EXTREME[6]];
    let mut rigs: Vec<_> =
        cameras.into_iter().map(|camera| (camera.name.to_owned(), mono(land.pose(camera)))).collect();
    let ordinary = land.pose(&ORDINARY);
    // The pair's eyes are a thirtieth of the nearest land apart.
    rigs.push(("a pair".to_owned(), Pair { ipd_m: 10.0, convergence_m: None }.rig(&still(ordinary, SIZE_PX))));
    rigs.push(("a turned head".to_owned(), mono(rolled(ordinary, 0.5))));
    assert_eq!(changed(&mut land.world, &rigs, CLOSE_PX)[0], 0);
}

/// Draws maps of low hills. A border between blocks is just outside of their western edge, so marks of blocks that are
/// out of view run into the picture.
#[test]
fn marks_that_begin_out_of_view_are_drawn() {
    let low_m = |x_m: f64, y_m: f64| 60.0 * ((x_m / 900.0).sin() + (y_m / 700.0 + x_m / 2100.0).cos());
    let Some(mut world) = World::new(grid_of(513, 513, 60.0, low_m), 1.0) else { return };
    let map =
        |step: u32| (format!("step {step}"), mono(world.pose(&format!("{},0,11000,0,-90,45", 6070 + 100 * step))));
    let maps: Vec<_> = (0..8).filter(|step| full() || [3, 4].contains(step)).map(map).collect();
    let [differ, missing] = changed(&mut world, &maps, 4.0);
    assert_eq!(differ, 0);
    // Planted: blocks are culled although their marks reach into the picture.
    assert!(missing > 20, "{missing}");
}

/// Returns a pose rotated around its axis.
fn rolled(pose: Pose, angle_rad: f64) -> Pose {
    let roll = DQuat::from_axis_angle(pose.forward, angle_rad);
    Pose { right: roll * pose.right, up: roll * pose.up, ..pose }
}

/// Returns a pose rotated to the right, around the vertical.
fn turned(pose: Pose, angle_rad: f64) -> Pose {
    let turn = DQuat::from_axis_angle(DVec3::Z, -angle_rad);
    Pose { forward: turn * pose.forward, right: turn * pose.right, up: turn * pose.up, ..pose }
}

#[test]
fn culling_changes_nothing_in_a_turn() {
    let Some(mut land) = Land::of_spacing(SPACING_M) else { return };
    let pose = land.pose(&ORDINARY);
    // Slow at first, then faster than blocks follow one another.
    let (angles_deg, size_px): (&[f64], _) =
        if full() { (&[0.0, 0.3, 2.0, 7.0, 20.0], SIZE_PX) } else { (&[0.0, 2.0, 20.0], SIZE_PX.map(|side| side / 2)) };
    let view = |deg: &f64| (format!("{deg} degrees"), Rig::mono(still(turned(pose, deg.to_radians()), size_px)));
    let turn: Vec<_> = angles_deg.iter().map(view).collect();
    assert_eq!(changed(&mut land.world, &turn, CLOSE_PX)[0], 0);
}

/// Returns the number of frames of a window's turn over land whose tiles are loaded, in which blocks are late.
fn late_frames(step_deg: f64, culling: Culling) -> Option<usize> {
    let mut land = Land::of_spacing(SPACING_M)?;
    let style = style(CLOSE_PX);
    let options = TerrainOptions { loading: Loading::Stream, ..TerrainOptions::default() };
    let store = Arc::clone(land.world.surfaces.terrain.store());
    land.world.surfaces = Terrain::new(&land.world.gpu, store, options).unwrap().into();
    let mut renderer = renderer(&land.world, culling);
    let pose = land.pose(&ORDINARY);
    let World { gpu, surfaces, .. } = &mut land.world;
    let mut frame = |pose: Pose| {
        let prepared = draw(gpu, surfaces, &mut renderer, &still(pose, SIZE_PX), &style, &north_west());
        (prepared.tiles.late || prepared.tiles.loaded > 0, renderer.has_late_rows())
    };
    // All tiles around the camera, and then the blocks of the first view.
    let mut at_rest = |pose: Pose| (0..400).any(|_| frame(pose) == (false, false));
    for step in 0..6 {
        assert!(at_rest(turned(pose, f64::from(step))), "the view never comes to rest");
    }
    assert!(at_rest(pose));
    let count = (90.0 / step_deg) as usize;
    Some((1..=count).filter(|step| frame(turned(pose, (*step as f64 * step_deg).to_radians())).1).count())
}

/// Run with `cargo test --release --lib tests::extremes::culling -- --ignored --nocapture`.
#[test]
#[ignore = "a measurement that takes minutes"]
fn what_culling_saves() {
    let style = Style::load("hachures").unwrap();
    let size_px = [320, 240];
    let least_ms = |world: &mut World, renderer: &mut Renderer, pose: Pose| {
        let begun = Instant::now();
        draw(&world.gpu, &mut world.surfaces, renderer, &still(pose, size_px), &style, &north_west());
        begun.elapsed().as_secs_f64() * 1000.0
    };
    for land in [Land::of_spacing(SPACING_M), Land::of_spacing(10_000.0), Land::far(), Land::of_spacing(0.001)] {
        let Some(mut land) = land else { return };
        for camera in [&ORDINARY].into_iter().chain(&EXTREME[..3]) {
            let pose = land.pose(camera);
            let mut both = [Culling::Nothing, Culling::ByReach].map(|culling| renderer(&land.world, culling));
            let mut times_ms = [f64::MAX; 2];
            for round in 0..4 {
                for (renderer, time_ms) in both.iter_mut().zip(&mut times_ms) {
                    let ms = least_ms(&mut land.world, renderer, pose);
                    *time_ms = if round > 0 { time_ms.min(ms) } else { *time_ms };
                }
            }
            let [before, after] = [0, 1].map(|i| both[i].row_blocks());
            let [before_ms, after_ms] = times_ms;
            println!(
                "{}, {}: {before} blocks, {before_ms:.1} ms; culled {after}, {after_ms:.1} ms",
                land.name, camera.name
            );
            let passes = both.each_mut().map(|renderer| {
                renderer.set_submits(Submits::Timed);
                least_ms(&mut land.world, renderer, pose);
                let mut times = renderer.take_times().unwrap_or_default();
                times.sort_by(|a, b| b.gpu_ms.total_cmp(&a.gpu_ms));
                times
                    .iter()
                    .take(5)
                    .map(|pass| format!("{} {:.1}", pass.name, pass.gpu_ms))
                    .collect::<Vec<_>>()
                    .join(", ")
            });
            println!("    {}\n    {}", passes[0], passes[1]);
        }
    }
}

/// In a window, culling does not delay blocks that come into view.
/// Run as [`what_culling_saves`].
#[test]
#[ignore = "a measurement that takes minutes"]
fn blocks_are_no_later_in_a_turn() {
    for step_deg in [2.0, 6.0] {
        let [Some(before), Some(after)] =
            [Culling::Nothing, Culling::ByReach].map(|culling| late_frames(step_deg, culling))
        else {
            return;
        };
        println!("{step_deg} degrees each frame: blocks are late in {before} frames, {after} with culling");
        assert!(after <= before, "{step_deg} degrees");
    }
}
