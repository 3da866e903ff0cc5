//! Both eyes see the same trees, and so do all samples of one picture.
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a panic fails the test; files are temporary")]

use crate::tests::common;

use crate::tests::helpers::forest::of;
use common::draw::{draw, floats, halves, north_west, places, still};
use common::hill::Hill;
use common::{World, full};
use glam::DVec3;
use hachure::composite::PICTURE;
use hachure::frame::{Antialias, Renderer, prepare};
use hachure::gpu::readback::read;
use hachure::lines::stereo::agree::AGREED;
use hachure::scene::forest::{Form, Species};
use hachure::scene::stereo::Pair;
use hachure::scene::view::{Rig, View};
use hachure::style::Style;
use hachure::surface::{SURFACE_ID, id};

const SIZE_PX: [u32; 2] = [320, 180];
const CAMERA: &str = "-300,-900,+40,15,-4,50";

fn wooded() -> Option<World> {
    let mut world = World::new(Hill::square(321, 10.0).1, 1.0)?;
    let mut forest = of(Form::Conifer, 150.0, 18.0);
    forest.species = Species::mixed(18.0);
    world.surfaces.set_forest(Some(forest));
    Some(world)
}

fn draw_rig(world: &mut World, renderer: &mut Renderer, rig: &Rig, style: &Style) {
    let prepared = prepare(&world.gpu, &mut world.surfaces, rig, style, &north_west());
    renderer.render_rig(&world.gpu, &world.surfaces, &prepared, rig, style, &north_west()).unwrap();
    world.gpu.check().unwrap();
}

#[test]
fn both_eyes_see_the_same_trees_and_draw_the_same_of_them() {
    let Some(mut world) = wooded() else { return };
    let view = still(world.pose(CAMERA), SIZE_PX);
    let rig = Pair { ipd_m: 0.5, convergence_m: None }.rig(&view);
    let style = Style::load("lsa").unwrap();
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    draw_rig(&mut world, &mut renderer, &rig, &style);
    let seen = |eye: usize| {
        let target = |kind| renderer.eye_target(eye, kind).unwrap();
        let ids = read(&world.gpu, target(&SURFACE_ID), [0, 0], SIZE_PX).unwrap();
        let ids: Vec<u32> = ids.chunks_exact(4).map(|id| u32::from_le_bytes([id[0], id[1], id[2], id[3]])).collect();
        let positions = places(&world.gpu, &renderer, eye);
        let lines: Vec<f32> = floats::<1>(&world.gpu, target(&AGREED)).into_iter().map(|[line]| line).collect();
        (ids, positions, lines)
    };
    let [(left_ids, positions, left_lines), (right_ids, right_positions, right_lines)] = [seen(0), seen(1)];
    let right = &rig.eyes[1];
    let (mut both, mut same) = (0, 0);
    for (i, at) in positions.iter().enumerate() {
        if left_ids[i] < id::FIRST_TREE {
            continue;
        }
        let at_m = DVec3::new(at[0].into(), at[1].into(), at[2].into()) + rig.origin_m;
        let Some(px) = right.place_px(at_m - right.pose.position_m) else { continue };
        let [x, y] = [px.x.floor(), px.y.floor()].map(|along| along as i64);
        if x < 1 || y < 1 || x + 1 >= i64::from(SIZE_PX[0]) || y + 1 >= i64::from(SIZE_PX[1]) {
            continue;
        }
        let j = (y * i64::from(SIZE_PX[0]) + x) as usize;
        // The comparison skips pixels that are hidden from the other eye.
        let away = |at: &[f32; 4]| f64::from(at[3]);
        if (away(&right_positions[j]) - away(at)).abs() > 0.02 * away(at) {
            continue;
        }
        both += 1;
        // At the border of a tree a pixel may show the neighbouring tree.
        let around = [j - 1, j, j + 1, j - SIZE_PX[0] as usize, j + SIZE_PX[0] as usize];
        same += usize::from(around.iter().any(|j| right_ids[*j] == left_ids[i]));
    }
    let of_ink = |lines: &[f32]| lines.iter().sum::<f32>() / lines.len() as f32;
    let (left_ink, right_ink) = (of_ink(&left_lines), of_ink(&right_lines));
    println!("{same} of {both} pixels show the same tree; ink {left_ink:.4} and {right_ink:.4}");
    assert!(both > 5000 && same as f64 > 0.99 * both as f64);
    assert!((left_ink / right_ink - 1.0).abs() < 0.05 && left_ink > 0.02);
    // Planted error: pixels shifted to other trees.
    let shifted = (0..left_ids.len() - 30).filter(|i| left_ids[*i] >= id::FIRST_TREE);
    let (all, wrong) =
        shifted.fold((0, 0), |(all, wrong), i| (all + 1, wrong + i32::from(left_ids[i] != left_ids[i + 30])));
    assert!(f64::from(wrong) > 0.5 * f64::from(all));
}

/// Tests that two eyes at one position draw what one eye draws, in several kinds of style.
#[test]
fn a_pair_without_distance_is_one_eye() {
    let Some(mut world) = wooded() else { return };
    let view = still(world.pose(CAMERA), if full() { SIZE_PX } else { [96, 54] });
    for name in ["lsa", "wash", "crosshatch"] {
        let style = Style::load(name).unwrap();
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        draw_rig(&mut world, &mut renderer, &Rig::mono(view), &style);
        let alone = halves(&world.gpu, renderer.eye_target(0, &PICTURE).unwrap());
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let rig = Pair { ipd_m: 0.0, convergence_m: None }.rig(&view);
        draw_rig(&mut world, &mut renderer, &rig, &style);
        for eye in 0..2 {
            let picture = halves(&world.gpu, renderer.eye_target(eye, &PICTURE).unwrap());
            assert!(picture == alone, "{name}: eye {eye} differs from the single eye");
        }
        // Planted error: eyes with a distance between them.
        let rig = Pair { ipd_m: 2.0, convergence_m: None }.rig(&view);
        draw_rig(&mut world, &mut renderer, &rig, &style);
        assert!(
            halves(&world.gpu, renderer.eye_target(1, &PICTURE).unwrap()) != alone,
            "{name}: eyes 2 m apart draw the same picture"
        );
    }
}

/// At rest, temporal anti-aliasing smooths the edges of a forest, and the picture comes to rest.
#[test]
fn a_forest_at_rest_becomes_still() {
    let Some(mut world) = wooded() else { return };
    let style = Style::load("lsa").unwrap();
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    renderer.set_antialias(Antialias::Temporal);
    let pose = world.pose(CAMERA);
    // In the fast tier a strip of the picture.
    let size_px = if full() { SIZE_PX } else { [64, SIZE_PX[1]] };
    let mut pictures = Vec::new();
    for number in 0..40 {
        let view = View::whole(pose, pose, size_px);
        draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, &style, &north_west());
        if [0, 1, 38, 39].contains(&number) {
            pictures.push(halves(&world.gpu, renderer.target(&PICTURE).unwrap()));
        }
    }
    let change = |a: &[[f64; 4]], b: &[[f64; 4]]| {
        a.iter().zip(b).map(|(a, b)| (a[1] - b[1]).abs()).sum::<f64>() / a.len() as f64
    };
    let [first, last] = [change(&pictures[0], &pictures[1]), change(&pictures[2], &pictures[3])];
    println!("change from the first frame to the second {first:.5}, between the last two {last:.6}");
    // Planted error: the first two frames, which are not averaged yet.
    assert!(last < 2e-3 && first > 5.0 * last);
}
