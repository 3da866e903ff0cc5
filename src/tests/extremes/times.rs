//! No extreme case takes much longer than its ordinary twin.

use std::time::Instant;

use glam::DVec2;
use hachure::frame::{Light, Renderer};
use hachure::scene::view::Pose;
use hachure::style::Style;

use super::checked::SIZE_PX;
use super::lands::{EXTREME, Land, ORDINARY, SPACING_M};
use super::views::{kinds, suns};
use crate::tests::common::draw::{draw, north_west, still};
use crate::tests::common::{World, full};

/// Largest time of a case, as a multiple of that of its ordinary twin.
const LONGEST: f64 = 4.0;

/// Returns the shortest time of a frame of a view at rest, in milliseconds, until the GPU has finished it.
fn least_ms(world: &mut World, renderer: &mut Renderer, pose: Pose, style: &Style, light: &Light) -> f64 {
    let frame_ms = |renderer: &mut Renderer, world: &mut World| {
        renderer.forget();
        let begun = Instant::now();
        draw(&world.gpu, &mut world.surfaces, renderer, &still(pose, SIZE_PX), style, light);
        begun.elapsed().as_secs_f64() * 1000.0
    };
    // The first frame compiles, loads tiles, and makes maps.
    frame_ms(renderer, world);
    (0..3).map(|_| frame_ms(renderer, world)).fold(f64::MAX, f64::min)
}

#[test]
fn no_extreme_view_takes_long() {
    let Some(ordinary) = Land::of_spacing(SPACING_M) else { return };
    let lands = [Some(ordinary), Land::of_spacing(0.001), Land::of_spacing(10_000.0), Land::far()];
    let mut ratios: Vec<(f64, String)> = Vec::new();
    let mut twins_ms = Vec::new();
    for land in lands {
        let Some(mut land) = land else { return };
        let poses: Vec<_> = [&ORDINARY].into_iter().chain(&EXTREME).map(|camera| (camera, land.pose(camera))).collect();
        for (number, style) in kinds().iter().enumerate() {
            let mut renderer = Renderer::new(&land.world.gpu).unwrap();
            let is_ordinary = land.factor == 1.0 && land.middle_m == DVec2::ZERO;
            let most = if full() || is_ordinary { poses.len() } else { 4 };
            for (camera, pose) in &poses[..most] {
                let ms = least_ms(&mut land.world, &mut renderer, *pose, style, &north_west());
                if twins_ms.len() == number {
                    twins_ms.push(ms);
                }
                ratios.push((
                    ms / twins_ms[number],
                    format!("{}, {}, {}: {ms:.1} ms", style.name, land.name, camera.name),
                ));
            }
            for (sun, light) in suns().into_iter().filter(|_| full() || is_ordinary) {
                let ms = least_ms(&mut land.world, &mut renderer, poses[0].1, style, &light);
                ratios.push((ms / twins_ms[number], format!("{}, {}, {sun}: {ms:.1} ms", style.name, land.name)));
            }
        }
    }
    ratios.sort_by(|a, b| b.0.total_cmp(&a.0));
    println!("{} cases; the longest:", ratios.len());
    ratios.iter().take(12).for_each(|(ratio, name)| println!("  {ratio:.2} times its twin: {name}"));
    let long: Vec<_> = ratios.iter().filter(|(ratio, _)| *ratio > LONGEST).collect();
    assert!(long.is_empty(), "too long: {long:#?}");
}
