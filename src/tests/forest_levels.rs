//! Trees keep their appearance and their number from mesh to impostor to canopy.
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a panic fails the test; files are temporary")]

use crate::tests::common;

use std::collections::{BTreeMap, BTreeSet};

use crate::tests::helpers::forest::{DrawnTree, drawn_trees, listed, of, points};
use common::World;
use common::draw::{NOON, draw, halves, still};
use common::{grid_of, quantile, random};
use glam::{DVec2, DVec3};
use hachure::frame::Renderer;
use hachure::gpu::readback::read;
use hachure::scene::forest::Form;
use hachure::scene::view::{Pose, View};
use hachure::style::Style;
use hachure::surface::trees::place::{FULL_PX, IMPOSTOR_PX};
use hachure::surface::trees::raster::TREE_NORMAL;
use hachure::surface::trees::{CANOPY, IMPOSTOR, MIDDLE, NEAR};
use hachure::surface::{SURFACE_ID, id};

const SIZE_PX: [u32; 2] = [160, 90];

fn plain() -> Option<World> {
    World::new(grid_of(321, 321, 20.0, |_, _| 0.0), 0.02)
}

fn key(at_m: DVec3) -> [i64; 2] {
    [at_m.x, at_m.y].map(|along_m| (2.0 * along_m).round() as i64)
}

/// Groups trees by their position in units of half a metre, which no two trees share here.
fn by_place(trees: &[DrawnTree]) -> BTreeMap<[i64; 2], Vec<DrawnTree>> {
    let mut places: BTreeMap<[i64; 2], Vec<DrawnTree>> = BTreeMap::new();
    trees.iter().for_each(|tree| places.entry(key(tree.at_m)).or_default().push(*tree));
    places
}

/// Returns whether the levels of a tree together cover the dither pattern exactly once, apart from a level that is
/// shrinking into a canopy.
fn is_whole(levels: &[DrawnTree]) -> bool {
    let mut alone: Vec<[f32; 2]> = levels.iter().filter(|tree| tree.level != CANOPY).map(|tree| tree.shown).collect();
    alone.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let is_chain = alone.windows(2).all(|pair| pair[0][1] == pair[1][0]);
    let is_full = alone.first().is_none_or(|first| first[0] == 0.0) && alone.last().is_none_or(|last| last[1] == 1.0);
    !levels.is_empty() && is_chain && is_full
}

/// Flies from among the trees up and away: in each frame every tree that the CPU expects is drawn, completely.
#[test]
fn no_tree_is_missing_in_any_frame_of_a_flight() {
    let Some(mut world) = plain() else { return };
    let forest = of(Form::Conifer, 300.0, 20.0);
    world.surfaces.set_forest(Some(forest.clone()));
    let all = points(14, forest.trees_per_ha);
    let density = forest.trees_per_ha / hachure::scene::Forest::MAX_TREES_PER_HA;
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let (mut seen, mut levels, mut lost) = (0, BTreeSet::new(), [0; 4]);
    for step in 0..16 {
        let t = f64::from(step) / 15.0;
        let height_m = 3.0 + 700.0 * t * t;
        let camera = format!("{},{},{height_m},{},{},70", -300.0 * t, -1200.0 * t, 20.0 * t, -4.0 - 20.0 * t);
        let pose = world.pose(&camera);
        let trees = drawn_trees(&mut world, &mut renderer, pose, SIZE_PX);
        let drawn = by_place(&trees);
        let view = still(pose, SIZE_PX);
        let full_m = forest.height_m() * view.focal_px() / FULL_PX;
        let (mut missing, mut broken, mut expected) = (0, 0, 0);
        for (at_m, rank) in &all {
            let from_eye_m = *at_m - pose.position_m;
            let away_m = from_eye_m.length();
            // The shader's formula, for level land.
            let foreshortening = (from_eye_m.z / away_m).abs();
            let share = (full_m * (0.25 + 0.75 * foreshortening).sqrt() / away_m).powi(2).min(1.0);
            // The centre of the tree is in view, it is on land, and its rank is not at the limit.
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
        // Planted error: one of the levels is missing.
        for level in [NEAR, MIDDLE, IMPOSTOR, CANOPY] {
            let fewer: Vec<DrawnTree> = trees.iter().filter(|tree| tree.level != level).copied().collect();
            let fewer = by_place(&fewer);
            let is_lost = |at: &&[i64; 2]| fewer.get(*at).is_none_or(|levels| !is_whole(levels));
            lost[level as usize] += drawn.keys().filter(is_lost).count();
        }
    }
    assert!(
        lost.iter().all(|lost| *lost > 0),
        "trees lost without each of the levels, expected some for each: {lost:?}"
    );
    println!("{seen} trees in 16 frames, none missing");
    assert!(seen > 3_000 && levels == BTreeSet::from([NEAR, MIDDLE, IMPOSTOR, CANOPY]), "{seen} {levels:?}");
}

/// The distances at which trees change from one level to the next are spread out, and each change takes several frames.
#[test]
fn trees_change_their_level_one_by_one_and_slowly() {
    let Some(mut world) = plain() else { return };
    world.surfaces.set_forest(Some(of(Form::Conifer, 240.0, 20.0)));
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let pose = world.pose("0,0,30,0,-10,40");
    let near_and_wide = ["0,0,30,0,-5,9.3", "0,0,30,0,-5,43"].map(|camera| world.pose(camera));
    let trees = drawn_trees(&mut world, &mut renderer, pose, [400, 225]);
    let places = by_place(&trees);
    for [finer, coarser] in [[NEAR, MIDDLE], [MIDDLE, IMPOSTOR], [IMPOSTOR, CANOPY]] {
        let is_between = |levels: &&Vec<DrawnTree>| {
            let has = |level: u32| levels.iter().any(|tree| tree.level == level);
            has(finer) && has(coarser)
        };
        // Distances are relative to the tree's height, which would spread them too.
        let mut sizes: Vec<f64> = places
            .values()
            .filter(is_between)
            .map(|levels| {
                let height_m = if coarser == CANOPY { 1.0 } else { f64::from(levels[0].instance.height_m) };
                levels[0].at_m.distance(pose.position_m) / height_m
            })
            .collect();
        let [low, middle, high] = [0.05, 0.5, 0.95].map(|part| quantile(&mut sizes, part));
        println!("{finer} to {coarser}: {} trees at distances of {low:.2} to {high:.2} heights", sizes.len());
        assert!(sizes.len() > 10 && (high - low) / middle > 0.05);
    }
    // The number of metres, in steps of one or several, that the change of one tree takes. In a narrower picture of the
    // same height, trees change at the same distances.
    let (size_px, step_m) = if common::full() { ([400, 225], 1_u8) } else { ([160, 225], 4) };
    let mut changing = |pose: Pose, end_m: u8| {
        let mut metres: BTreeMap<([i64; 2], u32), u8> = BTreeMap::new();
        for along_m in (0..end_m).step_by(step_m.into()) {
            let pose = Pose { position_m: pose.position_m - DVec3::Y * f64::from(along_m), ..pose };
            let trees = drawn_trees(&mut world, &mut renderer, pose, size_px);
            for (at, levels) in by_place(&trees) {
                for pair in levels.windows(2) {
                    *metres.entry((at, pair[0].level)).or_default() += step_m;
                }
            }
        }
        metres
    };
    let dissolving = |metres: &BTreeMap<([i64; 2], u32), u8>, level: u32| {
        let mut all: Vec<f64> =
            metres.iter().filter(|((_, of), _)| *of == level).map(|(_, metres)| f64::from(*metres)).collect();
        println!("from {level}: median {} m, of {} trees", quantile(&mut all, 0.5), all.len());
        assert!(all.len() > 10);
        quantile(&mut all, 0.5)
    };
    let metres = changing(pose, 20);
    for level in [MIDDLE, IMPOSTOR] {
        assert!(dissolving(&metres, level) >= 8.0);
    }
    // The nearest level is tested in a picture with as many pixels per radian as one of 1080 rows, because the level
    // above it changes too soon.
    let [near, wide] = near_and_wide;
    assert!((still(near, size_px).focal_px() / still(wide, [1920, 1080]).focal_px() - 1.0).abs() < 0.05);
    assert!(dissolving(&changing(near, 24), NEAR) >= 8.0);
}

/// Returns the trees that a frame shows: ids, normals, and the list.
fn pictured(
    world: &mut World,
    renderer: &mut Renderer,
    pose: Pose,
    detail: f64,
    size_px: [u32; 2],
    jitter_px: DVec2,
) -> (Vec<u32>, Vec<DVec3>, Vec<DrawnTree>) {
    world.surfaces.set_tree_detail(detail);
    let style = Style::load("plain").unwrap();
    let view = View { jitter_px, ..still(pose, size_px) };
    draw(&world.gpu, &mut world.surfaces, renderer, &view, &style, &NOON);
    let target = renderer.target(&SURFACE_ID).unwrap();
    let ids = read(&world.gpu, target, [0, 0], target.size_px()).unwrap();
    let ids = ids.chunks_exact(4).map(|id| u32::from_le_bytes([id[0], id[1], id[2], id[3]])).collect();
    let normals = halves(&world.gpu, renderer.target(&TREE_NORMAL).unwrap());
    let normals = normals.into_iter().map(|[x, y, z, _]| DVec3::new(x, y, z)).collect();
    (ids, normals, listed(world, renderer, pose.position_m))
}

/// How well two pictures of a tree agree.
struct Agreement {
    /// Intersection over union of its pixels.
    overlap: f64,
    /// The angle between the mean normals.
    of_means_deg: f64,
    /// The mean angle over the pixels in which both show the tree.
    of_pixels_deg: f64,
}

/// Compares two pictures of a tree; normals of the second are turned about the vertical.
fn agreement(id: u32, a: (&[u32], &[DVec3]), b: (&[u32], &[DVec3]), turn_rad: f64) -> Agreement {
    let (mut both, mut any, mut sum_deg) = (0_u32, 0_u32, 0.0);
    let turned = |n: DVec3| DVec2::from_angle(turn_rad).rotate(n.truncate()).extend(n.z);
    let mut means = [DVec3::ZERO; 2];
    for i in 0..a.0.len() {
        let [in_a, in_b] = [a.0[i] == id, b.0[i] == id];
        any += u32::from(in_a || in_b);
        means[0] += if in_a { a.1[i] } else { DVec3::ZERO };
        means[1] += if in_b { turned(b.1[i]) } else { DVec3::ZERO };
        if in_a && in_b {
            both += 1;
            sum_deg += a.1[i].angle_between(turned(b.1[i])).to_degrees();
        }
    }
    Agreement {
        overlap: f64::from(both) / f64::from(any.max(1)),
        of_means_deg: means[0].angle_between(means[1]).to_degrees(),
        of_pixels_deg: sum_deg / f64::from(both.max(1)),
    }
}

/// Returns the fraction of a tree's pixels in both pictures that have a pixel of the tree in the other one, at their
/// place or next to it, with the second picture shifted by `aside_px`. For a branch one pixel wide, a shift of half a
/// pixel halves the intersection over union without a visible difference; this measure does not react to it.
fn within_a_pixel(id: u32, a: &[u32], b: &[u32], size_px: [u32; 2], aside_px: i64) -> f64 {
    let [width, height] = size_px.map(i64::from);
    let is_in = |ids: &[u32], x: i64, y: i64| {
        (0..width).contains(&x) && (0..height).contains(&y) && ids[(y * width + x) as usize] == id
    };
    let (mut held, mut all) = (0_u32, 0_u32);
    for (from, to, aside_px) in [(a, b, -aside_px), (b, a, aside_px)] {
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).filter(|(x, y)| is_in(from, *x, *y)) {
            all += 1;
            let mut around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (x + aside_px + dx, y + dy)));
            held += u32::from(around.any(|(x, y)| is_in(to, x, y)));
        }
    }
    f64::from(held) / f64::from(all.max(1))
}

/// How much an impostor looks like its mesh.
struct Likeness {
    impostor: Agreement,
    /// With the impostor turned by 10°.
    turned_deg: f64,
    /// The result of [`within_a_pixel`], and the same with the impostor shifted by four pixels.
    near: f64,
    aside: f64,
    /// The overlap of the mesh with itself half a pixel to the right and down: an impostor must be better.
    shifted: f64,
}

/// Returns whether a tree touches neither another one nor the picture's border.
fn stands_clear(own: u32, ids: &[u32], size_px: [u32; 2]) -> bool {
    let [width, height] = size_px.map(|side| side as usize);
    (0..ids.len()).filter(|i| ids[*i] == own).all(|i| {
        let (x, y) = (i % width, i / width);
        x > 0
            && y > 0
            && x + 1 < width
            && y + 1 < height
            && [i - 1, i + 1, i - width, i + width].iter().all(|j| ids[*j] == own || ids[*j] < id::FIRST_TREE)
    })
}

/// Compares each form from many sides, at the size at which it changes to its impostor.
#[test]
fn impostors_look_like_their_meshes() {
    const PICTURE_PX: [u32; 2] = [320, 180];
    const VIEWS: usize = 25;
    // Trees of this size are within a hundred metres.
    let Some(mut world) = World::new(grid_of(65, 65, 20.0, |_, _| 0.0), 0.02) else { return };
    let height_m = 20.0;
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    // The branches of a dead tree are one pixel wide, so even its mesh agrees as little with itself shifted by half a
    // pixel.
    let forms =
        [(Form::Conifer, 0.92, 7.0), (Form::Broadleaf, 0.96, 7.0), (Form::Birch, 0.92, 7.0), (Form::Snag, 0.68, 10.0)];
    for (form, least, max_deg) in forms {
        world.surfaces.set_forest(Some(of(form, 12.0, height_m)));
        let mut all: Vec<Likeness> = Vec::new();
        for i in 0..60 {
            if all.len() >= VIEWS {
                break;
            }
            let yaw_deg = 360.0 * random(i, 1);
            let pitch_deg = -5.0 - 70.0 * random(i, 2);
            // At the centre of the picture trees change to impostors.
            let away_m = height_m * still(world.pose("0,0,1,0,0,40"), PICTURE_PX).focal_px() / IMPOSTOR_PX;
            let up_m = away_m * -pitch_deg.to_radians().sin();
            let camera = format!("{},{},{up_m},{yaw_deg},{pitch_deg},40", 200.0 * random(i, 3), 200.0 * random(i, 4));
            let pose = world.pose(&camera);
            let mut seen =
                |detail: f64, jitter_px| pictured(&mut world, &mut renderer, pose, detail, PICTURE_PX, jitter_px);
            let (shifted_ids, shifted_normals, _) = seen(4.0, DVec2::splat(0.5));
            let (mesh_ids, mesh_normals, _) = seen(4.0, DVec2::ZERO);
            let (ids, normals, trees) = seen(0.8, DVec2::ZERO);
            for tree in trees.iter().filter(|tree| tree.level == IMPOSTOR && tree.shown == [0.0, 1.0]) {
                let own = tree.instance.id;
                let size_px = f64::from(tree.instance.height_m) * still(pose, PICTURE_PX).focal_px()
                    / tree.at_m.distance(pose.position_m);
                let is_clear = [&ids, &mesh_ids].iter().all(|ids| stands_clear(own, ids, PICTURE_PX));
                if !is_clear || !(0.75..1.4).contains(&(size_px / IMPOSTOR_PX)) {
                    continue;
                }
                let mesh = (&mesh_ids[..], &mesh_normals[..]);
                if !ids.contains(&own) {
                    continue;
                }
                all.push(Likeness {
                    impostor: agreement(own, mesh, (&ids, &normals), 0.0),
                    turned_deg: agreement(own, mesh, (&ids, &normals), 10.0_f64.to_radians()).of_means_deg,
                    near: within_a_pixel(own, &mesh_ids, &ids, PICTURE_PX, 0),
                    aside: within_a_pixel(own, &mesh_ids, &ids, PICTURE_PX, 4),
                    shifted: agreement(own, mesh, (&shifted_ids, &shifted_normals), 0.0).overlap,
                });
            }
        }
        let mean = |of: &dyn Fn(&Likeness) -> f64| all.iter().map(of).sum::<f64>() / all.len() as f64;
        let overlap = mean(&|each| each.impostor.overlap);
        let of_means_deg = mean(&|each| each.impostor.of_means_deg);
        let turned_deg = mean(&|each| each.turned_deg);
        let [near, aside, shifted] = [mean(&|each| each.near), mean(&|each| each.aside), mean(&|each| each.shifted)];
        let mut overlaps: Vec<f64> = all.iter().map(|each| each.impostor.overlap).collect();
        println!(
            "{form:?}, {} views: overlap {overlap:.3}, 5th percentile {:.3}, mesh shifted by half a pixel {:.3}; \
             within a pixel {near:.3}, shifted by four pixels {aside:.3}; mean normals {of_means_deg:.1}° apart, turned by 10° \
             {turned_deg:.1}°; normals of pixels {:.1}° apart",
            all.len(),
            quantile(&mut overlaps, 0.05),
            shifted,
            mean(&|each| each.impostor.of_pixels_deg),
        );
        assert!(all.len() >= VIEWS && overlap > least && of_means_deg < max_deg && near > 0.93);
        assert!(overlap > shifted);
        // Planted errors: an impostor that is turned, and one that is shifted.
        assert!(turned_deg > of_means_deg + 1.0 && aside < near - 0.03);
    }
}

/// Tests that a frame lists and draws what is visible, not what exists: the same view of worlds with a thousand to a
/// hundred million trees.
#[test]
fn a_frame_costs_what_is_seen() {
    let mut drawn: Vec<usize> = Vec::new();
    for trees in [1e3_f64, 1e8, 1e4, 1e5, 1e6, 1e7].into_iter().take(if common::full() { 6 } else { 2 }) {
        let side_m = (trees / 300.0).sqrt() * 100.0;
        let Some(mut world) = World::new(grid_of(65, 65, side_m / 64.0, |_, _| 0.0), 1.0) else { return };
        world.surfaces.set_forest(Some(of(Form::Conifer, 300.0, 20.0)));
        let pose = world.pose("0,0,100,0,-90,40");
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        drawn.push(drawn_trees(&mut world, &mut renderer, pose, SIZE_PX).len());
        let begun = std::time::Instant::now();
        drawn_trees(&mut world, &mut renderer, pose, SIZE_PX);
        println!(
            "{trees:.0e} trees in {side_m:.0} m: {} drawn, {:.0} ms",
            drawn[drawn.len() - 1],
            begun.elapsed().as_secs_f64() * 1000.0
        );
    }
    assert!(
        drawn[0] > 200 && drawn.iter().all(|count| *count == drawn[0]),
        "the number of drawn trees depends on the world: {drawn:?}"
    );
    // Planted error: a view of more trees.
    let Some(mut world) = World::new(grid_of(65, 65, 20.0, |_, _| 0.0), 1.0) else { return };
    world.surfaces.set_forest(Some(of(Form::Conifer, 300.0, 20.0)));
    let pose = world.pose("0,0,150,0,-90,40");
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    assert!(drawn_trees(&mut world, &mut renderer, pose, SIZE_PX).len() > drawn[0]);
}
