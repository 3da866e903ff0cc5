//! Trees keep their looks and their number as they go from mesh to impostor to canopy.
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a test fails by panicking, into scratch folders")]

mod common;

use std::collections::{BTreeMap, BTreeSet};

use common::World;
use common::draw::{NOON, draw, floats, halves, still};
use common::forest::{DrawnTree, drawn_trees, listed, of, points};
use common::{grid_of, quantile, random};
use glam::{DVec2, DVec3};
use hachure::frame::Frame;
use hachure::gpu::readback::read;
use hachure::scene::forest::Form;
use hachure::scene::view::Pose;
use hachure::style::Style;
use hachure::surface::trees::place::{FULL_PX, IMPOSTOR_PX};
use hachure::surface::trees::raster::TREE_NORMAL;
use hachure::surface::trees::{CANOPY, IMPOSTOR, MIDDLE, NEAR};
use hachure::surface::{SURFACE_ID, id};

const SIZE_PX: [u32; 2] = [160, 90];

/// A plain.
fn plain() -> Option<World> {
    World::new(grid_of(321, 321, 20.0, |_, _| 0.0), 0.02)
}

fn key(at_m: DVec3) -> [i64; 2] {
    [at_m.x, at_m.y].map(|along_m| (2.0 * along_m).round() as i64)
}

/// Trees by their places to half a metre, which no two share here.
fn by_place(trees: &[DrawnTree]) -> BTreeMap<[i64; 2], Vec<DrawnTree>> {
    let mut places: BTreeMap<[i64; 2], Vec<DrawnTree>> = BTreeMap::new();
    trees.iter().for_each(|tree| places.entry(key(tree.at_m)).or_default().push(*tree));
    places
}

/// Whether all of the dither pattern shows a tree that stands by itself, each value once, unless it is shrinking into a
/// canopy.
fn is_whole(levels: &[DrawnTree]) -> bool {
    let mut alone: Vec<[f32; 2]> = levels.iter().filter(|tree| tree.level != CANOPY).map(|tree| tree.shown).collect();
    alone.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let is_chain = alone.windows(2).all(|pair| pair[0][1] == pair[1][0]);
    let is_full = alone.first().is_none_or(|first| first[0] == 0.0) && alone.last().is_none_or(|last| last[1] == 1.0);
    !levels.is_empty() && is_chain && is_full
}

/// A flight from among the trees up and away: in each frame every tree that the placement's own list has is drawn, whole.
#[test]
fn no_tree_is_missing_in_any_frame_of_a_flight() {
    let Some(mut world) = plain() else { return };
    let forest = of(Form::Conifer, 40.0, 20.0);
    world.surfaces.set_forest(Some(forest.clone()));
    let all = points(14, forest.trees_per_ha);
    let density = forest.trees_per_ha / hachure::scene::Forest::MOST_TREES_PER_HA;
    let mut frame = Frame::new(&world.gpu).unwrap();
    let (mut seen, mut levels, mut lost) = (0, BTreeSet::new(), [0; 4]);
    for step in 0..24 {
        let t = f64::from(step) / 23.0;
        let height_m = 3.0 + 700.0 * t * t;
        let camera = format!("{},{},{height_m},{},{},70", -300.0 * t, -1200.0 * t, 20.0 * t, -4.0 - 20.0 * t);
        let pose = world.pose(&camera);
        let trees = drawn_trees(&mut world, &mut frame, pose, SIZE_PX);
        let drawn = by_place(&trees);
        let view = still(pose, SIZE_PX);
        let full_m = forest.height_m() * view.focal_px() / FULL_PX;
        let (mut missing, mut broken, mut expected) = (0, 0, 0);
        for (at_m, rank) in &all {
            let from_eye_m = *at_m - pose.position_m;
            let away_m = from_eye_m.length();
            // As the shader has it, of level land.
            let foreshortening = (from_eye_m.z / away_m).abs();
            let share = (full_m * (0.25 + 0.75 * foreshortening).sqrt() / away_m).powi(2).min(1.0);
            // In view with its middle, on land, and not by a hair.
            let is_listed = *rank < 0.995 * density * share
                && view.frustum().may_see_sphere(from_eye_m + DVec3::Z * 10.0, 0.0)
                && at_m.truncate().abs().max_element() < 3190.0;
            if is_listed {
                expected += 1;
                match drawn.get(&key(*at_m)) {
                    None => missing += 1,
                    Some(levels) => broken += usize::from(!is_whole(levels)),
                }
            }
        }
        assert!(missing == 0 && broken == 0, "frame {step}: {missing} missing, {broken} broken of {expected}");
        seen += expected;
        levels.extend(trees.iter().map(|tree| tree.level));
        // Planted: without one of the levels.
        for level in [NEAR, MIDDLE, IMPOSTOR, CANOPY] {
            let fewer: Vec<DrawnTree> = trees.iter().filter(|tree| tree.level != level).copied().collect();
            let fewer = by_place(&fewer);
            let is_lost = |at: &&[i64; 2]| fewer.get(*at).is_none_or(|levels| !is_whole(levels));
            lost[level as usize] += drawn.keys().filter(is_lost).count();
        }
    }
    assert!(lost.iter().all(|lost| *lost > 10), "trees are missing without a level: {lost:?}");
    println!("{seen} trees in 24 frames, none missing");
    assert!(seen > 20_000 && levels == BTreeSet::from([NEAR, MIDDLE, IMPOSTOR, CANOPY]), "{seen} {levels:?}");
}

/// The distances at which trees go over from a level to the next spread, and each takes its time.
#[test]
fn trees_change_their_level_one_by_one_and_slowly() {
    let Some(mut world) = plain() else { return };
    world.surfaces.set_forest(Some(of(Form::Conifer, 600.0, 20.0)));
    let mut frame = Frame::new(&world.gpu).unwrap();
    let pose = world.pose("0,0,30,0,-10,40");
    let trees = drawn_trees(&mut world, &mut frame, pose, [640, 360]);
    let places = by_place(&trees);
    for [finer, coarser] in [[NEAR, MIDDLE], [MIDDLE, IMPOSTOR], [IMPOSTOR, CANOPY]] {
        let is_between = |levels: &&Vec<DrawnTree>| {
            let has = |level: u32| levels.iter().any(|tree| tree.level == level);
            has(finer) && has(coarser)
        };
        // By what their own height does to it, which would spread them too.
        let mut sizes: Vec<f64> = places
            .values()
            .filter(is_between)
            .map(|levels| {
                let height_m = if coarser == CANOPY { 1.0 } else { f64::from(levels[0].instance.height_m) };
                levels[0].at_m.distance(pose.position_m) / height_m
            })
            .collect();
        let [low, middle, high] = [0.05, 0.5, 0.95].map(|part| quantile(&mut sizes, part));
        println!("{finer} to {coarser}: {} trees at {low:.2} to {high:.2} heights", sizes.len());
        assert!(sizes.len() > 10 && (high - low) / middle > 0.05);
    }
    // How many steps of a metre it takes one.
    let mut frames: BTreeMap<([i64; 2], u32), u32> = BTreeMap::new();
    for step in 0..60 {
        let pose = Pose { position_m: pose.position_m - DVec3::Y * f64::from(step), ..pose };
        let trees = drawn_trees(&mut world, &mut frame, pose, [640, 360]);
        for (at, levels) in by_place(&trees) {
            for pair in levels.windows(2) {
                *frames.entry((at, pair[0].level)).or_default() += 1;
            }
        }
    }
    for level in [MIDDLE, IMPOSTOR] {
        let mut counts: Vec<f64> =
            frames.iter().filter(|((_, from), _)| *from == level).map(|(_, count)| f64::from(*count)).collect();
        println!("from {level}: {} frames in the mean", quantile(&mut counts, 0.5));
        assert!(quantile(&mut counts, 0.5) >= 8.0);
    }
}

/// What a frame shows of trees: ids and normals.
fn pictured(world: &mut World, pose: Pose, detail: f64, size_px: [u32; 2]) -> (Vec<u32>, Vec<DVec3>, Vec<DrawnTree>) {
    world.surfaces.set_tree_detail(detail);
    let mut frame = Frame::new(&world.gpu).unwrap();
    let style = Style::load("plain").unwrap();
    for _ in 0..2 {
        draw(&world.gpu, &mut world.surfaces, &mut frame, &still(pose, size_px), &style, &NOON);
    }
    let target = frame.target(&SURFACE_ID).unwrap();
    let ids = read(&world.gpu, &target, [0, 0], target.size_px()).unwrap();
    let ids = ids.chunks_exact(4).map(|id| u32::from_le_bytes([id[0], id[1], id[2], id[3]])).collect();
    let normals = halves(&world.gpu, &frame.target(&TREE_NORMAL).unwrap());
    let normals = normals.into_iter().map(|[x, y, z, _]| DVec3::new(x, y, z)).collect();
    (ids, normals, listed(world, &frame, pose.position_m))
}

/// How two pictures of a tree agree: intersection over union of its pixels, and the mean angle of normals where both
/// show it, in degrees.
fn agreement(id: u32, a: (&[u32], &[DVec3]), b: (&[u32], &[DVec3]), turn_rad: f64) -> (f64, f64, usize) {
    let (mut both, mut any, mut sum_deg) = (0, 0, 0.0);
    for i in 0..a.0.len() {
        let [in_a, in_b] = [a.0[i] == id, b.0[i] == id];
        any += usize::from(in_a || in_b);
        if in_a && in_b {
            both += 1;
            let turned = DVec2::from_angle(turn_rad).rotate(b.1[i].truncate()).extend(b.1[i].z);
            sum_deg += a.1[i].angle_between(turned).to_degrees();
        }
    }
    (both as f64 / any.max(1) as f64, sum_deg / both.max(1) as f64, any)
}

/// Each form from a hundred sides, as large as where it goes over to its impostor.
#[test]
fn impostors_look_like_their_meshes() {
    const PICTURE_PX: [u32; 2] = [320, 180];
    let Some(mut world) = plain() else { return };
    let height_m = 20.0;
    for (form, [least, most_deg]) in [
        (Form::Conifer, [0.8, 30.0]),
        (Form::Broadleaf, [0.85, 30.0]),
        (Form::Birch, [0.75, 30.0]),
        (Form::Snag, [0.3, 40.0]),
    ] {
        world.surfaces.set_forest(Some(of(form, 4.0, height_m)));
        let (mut overlaps, mut angles_deg, mut planted) = (Vec::new(), Vec::new(), Vec::new());
        for i in 0..24 {
            if overlaps.len() >= 100 {
                break;
            }
            let yaw_deg = 360.0 * random(i, 1);
            let pitch_deg = -5.0 - 70.0 * random(i, 2);
            // The picture's middle is where trees go over.
            let away_m = height_m * still(world.pose("0,0,1,0,0,40"), PICTURE_PX).focal_px() / IMPOSTOR_PX;
            let up_m = away_m * -pitch_deg.to_radians().sin();
            let camera = format!("{},{},{up_m},{yaw_deg},{pitch_deg},40", 900.0 * random(i, 3), 900.0 * random(i, 4));
            let pose = world.pose(&camera);
            let (mesh_ids, mesh_normals, _) = pictured(&mut world, pose, 4.0, PICTURE_PX);
            let (ids, normals, trees) = pictured(&mut world, pose, 0.8, PICTURE_PX);
            for tree in trees.iter().filter(|tree| tree.level == IMPOSTOR && tree.shown == [0.0, 1.0]) {
                let own = tree.instance.id;
                let is_at_border = (0..ids.len()).any(|i| {
                    let (x, y) = (i as u32 % PICTURE_PX[0], i as u32 / PICTURE_PX[0]);
                    let on_border = x == 0 || y == 0 || x + 1 == PICTURE_PX[0] || y + 1 == PICTURE_PX[1];
                    on_border && (ids[i] == own || mesh_ids[i] == own)
                });
                let mesh = (&mesh_ids[..], &mesh_normals[..]);
                let (overlap, angle_deg, pixels) = agreement(own, mesh, (&ids, &normals), 0.0);
                if is_at_border || pixels < 60 {
                    continue;
                }
                if std::env::var_os("SHOW").is_some() {
                    let to = tree.at_m - pose.position_m;
                    println!(
                        "  {form:?} {overlap:.2} {angle_deg:.0}° {pixels} px, from {:.0}° above, {:.0} m",
                        (-to.z / to.length()).asin().to_degrees(),
                        to.length()
                    );
                }
                overlaps.push(overlap);
                angles_deg.push(angle_deg);
                planted.push(agreement(own, mesh, (&ids, &normals), 25.0_f64.to_radians()).1);
            }
        }
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        println!(
            "{form:?}, {} views: overlap {:.3}, at least {:.3}; normals {:.1}°, turned by 25° {:.1}°",
            overlaps.len(),
            mean(&overlaps),
            quantile(&mut overlaps, 0.05),
            mean(&angles_deg),
            mean(&planted)
        );
        assert!(overlaps.len() >= 40, "{}", overlaps.len());
        assert!(mean(&overlaps) > least && mean(&angles_deg) < most_deg);
        // Planted: an impostor that is turned.
        assert!(mean(&planted) > mean(&angles_deg) + 3.0);
    }
    let _ = id::FIRST_TREE;
    let _ = floats::<1>;
}
