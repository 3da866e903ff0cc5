//! Trees sway as the wind's own function says, at every level, and the motion picture agrees.
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a panic fails the test; files are temporary")]

use crate::tests::common;

mod frames;

use std::collections::{BTreeMap, BTreeSet};

use crate::tests::helpers::forest::{DrawnTree, listed, of};
use common::draw::{draw, floats, halves, north_west, places};
use common::{World, full, grid_of, quantile};
use glam::{DVec2, DVec3};
use hachure::composite::PICTURE;
use hachure::frame::{Antialias, Renderer, SAMPLES_AT_REST};
use hachure::gpu::readback::read;
use hachure::scene::Wind;
use hachure::scene::forest::Form;
use hachure::scene::stereo::Pair;
use hachure::scene::view::{Clock, Part, Pose, Rig, View};
use hachure::style::Style;
use hachure::surface::motion::MOTION;
use hachure::surface::trees::place::IMPOSTOR_PX;
use hachure::surface::trees::{CANOPY, IMPOSTOR, MIDDLE, NEAR};
use hachure::surface::{SURFACE_ID, id};

const SIZE_PX: [u32; 2] = [320, 180];
const WIND: Wind = Wind { speed_m_s: 10.0, from_deg: 250.0 };
/// A camera among trees of all levels.
const CAMERA: &str = "-300,-900,25,15,-4,50";

/// Returns a plain with a forest.
fn wooded(form: Form, trees_per_ha: f64, wind: Option<Wind>) -> Option<World> {
    let mut world = World::new(grid_of(321, 321, 20.0, |_, _| 0.0), 0.02)?;
    world.surfaces.set_forest(Some(of(form, trees_per_ha, 20.0)));
    world.surfaces.set_wind(wind);
    Some(world)
}

/// The trees that a frame shows.
struct Shown {
    ids: Vec<u32>,
    position: Vec<[f32; 4]>,
    motion: Vec<[f32; 2]>,
    trees: Vec<DrawnTree>,
    view: View,
}

impl Shown {
    /// Returns the position of a pixel in the world.
    fn at_m(&self, pixel: usize) -> DVec3 {
        let [x, y, z, _] = self.position[pixel].map(f64::from);
        DVec3::new(x, y, z) + self.view.pose.position_m
    }

    fn by_id(&self) -> BTreeMap<u32, DrawnTree> {
        self.trees.iter().filter(|tree| tree.level != CANOPY).map(|tree| (tree.instance.id, *tree)).collect()
    }
}

fn centre(pixel: usize) -> DVec2 {
    let width = SIZE_PX[0] as usize;
    DVec2::new((pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5)
}

/// Draws a view; in the long tier twice, where the first frame loads the tiles.
fn shown(world: &mut World, renderer: &mut Renderer, view: View) -> Shown {
    let style = Style::load("plain").unwrap();
    renderer.set_wants_motion(true);
    for _ in 0..if full() { 2 } else { 1 } {
        draw(&world.gpu, &mut world.surfaces, renderer, &view, &style, &north_west());
    }
    let target = |kind| renderer.target(kind).unwrap();
    let ids = read(&world.gpu, target(&SURFACE_ID), [0, 0], target(&SURFACE_ID).size_px()).unwrap();
    Shown {
        ids: ids.chunks_exact(4).map(|id| u32::from_le_bytes([id[0], id[1], id[2], id[3]])).collect(),
        position: places(&world.gpu, renderer, 0),
        motion: floats::<2>(&world.gpu, target(&MOTION)),
        trees: listed(world, renderer, view.pose.position_m),
        view,
    }
}

#[test]
fn without_wind_the_clock_is_nothing() {
    let Some(mut world) = wooded(Form::Birch, 200.0, None) else { return };
    let pose = world.pose(CAMERA);
    let style = Style::load("lsa").unwrap();
    let size_px = if full() { SIZE_PX } else { [96, 54] };
    let mut picture = |wind: Option<Wind>, now_s: f64| {
        world.surfaces.set_wind(wind);
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let view = View::whole(pose, pose, size_px).at(Clock::still(now_s));
        for _ in 0..2 {
            draw(&world.gpu, &mut world.surfaces, &mut renderer, &view, &style, &north_west());
        }
        assert_eq!(renderer.may_sway(), wind.is_some_and(|wind| wind.speed_m_s > 0.0));
        halves(&world.gpu, renderer.target(&PICTURE).unwrap())
    };
    let calm = picture(None, 0.0);
    assert!(picture(None, 1234.5) == calm, "without wind the picture depends on the time");
    assert!(picture(Some(Wind { speed_m_s: 0.0, ..WIND }), 1234.5) == calm, "a wind of 0 m/s changes the picture");
    let windy = picture(Some(WIND), 1234.5);
    assert!(picture(Some(WIND), 1234.5) == windy, "two pictures of the same time differ");
    // Planted errors: wind, and a time one second later.
    assert!(windy != calm && picture(Some(WIND), 1235.5) != windy);
}

/// Compares the motion of each pixel of a tree with what the wind does to that tree in f64; returns the differences by
/// level, in pixels, less what leaves may flutter.
fn off_px(shown: &Shown, wind: Wind, clock: Clock) -> [Vec<f64>; 4] {
    let trees = shown.by_id();
    let mut off: [Vec<f64>; 4] = Default::default();
    for pixel in 0..shown.ids.len() {
        let Some(tree) = trees.get(&shown.ids[pixel]) else { continue };
        let at_m = shown.at_m(pixel);
        let (foot_m, up_m) = (tree.at_m.truncate(), at_m.z - tree.at_m.z);
        let lean = |time_s: f64| wind.lean_m(foot_m, up_m, time_s);
        let was_m = at_m + (lean(clock.before_s) - lean(clock.now_s)).extend(0.0);
        let before = View::whole(shown.view.previous, shown.view.previous, SIZE_PX);
        let Some(was_px) = before.place_px(was_m - before.pose.position_m) else { continue };
        let [x, y] = shown.motion[pixel].map(f64::from);
        let px_per_m = shown.view.focal_px() / tree.at_m.distance(shown.view.pose.position_m);
        // The leaves of meshes flutter by 4 cm, at most 1.7 times per second; small trees do not flutter.
        let flutters = tree.level != IMPOSTOR && f64::from(tree.instance.height_m) * px_per_m > 1.4 * IMPOSTOR_PX;
        let swing = (std::f64::consts::TAU * 1.7 * (clock.now_s - clock.before_s)).min(2.0);
        let flutter_px = if flutters { 0.04 * 2.0_f64.sqrt() * swing * px_per_m } else { 0.0 };
        let off_px = (centre(pixel) - DVec2::new(x, y)).distance(was_px);
        off[tree.level as usize].push((off_px - flutter_px).max(0.0));
    }
    off
}

#[test]
fn motion_is_what_wind_does_to_each_tree() {
    let Some(mut world) = wooded(Form::Conifer, 200.0, Some(WIND)) else { return };
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let pose = world.pose(CAMERA);
    let previous = Pose { position_m: pose.position_m - DVec3::new(0.3, 1.0, 0.1), ..pose };
    // The time between frames of a film, and a long one.
    for (step_s, least) in [(0.04, 0.01), (1.0, 0.25)] {
        let clock = Clock { now_s: 3000.0, before_s: 3000.0 - step_s };
        let shown = shown(&mut world, &mut renderer, View::whole(previous, pose, SIZE_PX).at(clock));
        let off = off_px(&shown, WIND, clock);
        // Planted error: trees that do not move.
        let still = off_px(&shown, WIND, Clock::still(3000.0));
        for level in [NEAR, MIDDLE, IMPOSTOR] {
            let pixels = off[level as usize].len();
            let [off, still] = [&off, &still].map(|off| quantile(&mut off[level as usize].clone(), 0.95));
            println!(
                "{step_s} s, level {level}: error {off:.4} px on {pixels} pixels, without the tree's own motion {still:.4}"
            );
            assert!(
                pixels > 100 && off < 0.01 && still > least,
                "level {level}: error of motion {off} px, without the tree's own motion {still} px"
            );
        }
    }
}

/// Considers the pixels of crowns that were in the previous frame and not hidden there; returns the fraction whose
/// motion leads to the same tree, and their number.
fn same_tree(now: &Shown, before: &Shown, motion: impl Fn(usize) -> DVec2) -> (f64, usize) {
    let (mut same, mut all) = (0, 0);
    let trees = now.by_id();
    for pixel in 0..now.ids.len() {
        let Some(tree) = trees.get(&now.ids[pixel]).filter(|tree| before.by_id_has(tree.instance.id)) else { continue };
        if now.at_m(pixel).z - tree.at_m.z < 0.6 * f64::from(tree.instance.height_m) {
            continue;
        }
        let was = centre(pixel) - motion(pixel);
        let [x, y] = [was.x.floor(), was.y.floor()].map(|along| along as i64);
        if x < 0 || y < 0 || x >= i64::from(SIZE_PX[0]) || y >= i64::from(SIZE_PX[1]) {
            continue;
        }
        let there = (y * i64::from(SIZE_PX[0]) + x) as usize;
        let [was_m, is_m] = [before.position[there][3], now.position[pixel][3]];
        if was_m > 0.0 && was_m < 0.9 * is_m {
            continue;
        }
        all += 1;
        same += usize::from(before.ids[there] == now.ids[pixel]);
    }
    (f64::from(u32::try_from(same).unwrap()) / f64::from(u32::try_from(all).unwrap()), all)
}

impl Shown {
    fn by_id_has(&self, id: u32) -> bool {
        self.trees.iter().any(|tree| tree.instance.id == id)
    }
}

#[test]
fn motion_leads_to_the_same_tree_in_the_frame_before() {
    // Trees apart from each other, so that a pixel does not show the tree behind.
    let wind = Wind { speed_m_s: 18.0, ..WIND };
    let Some(mut world) = wooded(Form::Broadleaf, 40.0, Some(wind)) else { return };
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let pose = world.pose("-300,-900,12,340,2,50");
    let previous = Pose { position_m: pose.position_m - DVec3::new(0.2, 0.5, 0.0), ..pose };
    let clock = Clock { now_s: 71.0, before_s: 69.0 };
    let before = shown(&mut world, &mut renderer, View::whole(previous, previous, SIZE_PX).at(Clock::still(69.0)));
    let now = shown(&mut world, &mut renderer, View::whole(previous, pose, SIZE_PX).at(clock));
    let (right, all) = same_tree(&now, &before, |pixel| {
        let [x, y] = now.motion[pixel].map(f64::from);
        DVec2::new(x, y)
    });
    // Planted errors: motion of the eye alone, and no motion.
    let eyes = |pixel: usize| {
        let before = View::whole(previous, previous, SIZE_PX);
        let was = before.place_px(now.at_m(pixel) - previous.position_m);
        was.map_or(DVec2::ZERO, |was| centre(pixel) - was)
    };
    let (of_eye, _) = same_tree(&now, &before, eyes);
    let (none, _) = same_tree(&now, &before, |_| DVec2::ZERO);
    println!("{all} pixels: same tree {right:.4}, with the eye's motion alone {of_eye:.4}, without motion {none:.4}");
    assert!(all > 3000 && right > 0.96);
    assert!(1.0 - of_eye > 2.0 * (1.0 - right) && 1.0 - none > 2.0 * (1.0 - right));
}

/// Returns the trees that touch neither another one nor the picture's border.
fn that_stand_clear(shown: &Shown) -> BTreeSet<u32> {
    let [width, height] = SIZE_PX.map(|side| side as usize);
    let is_tree = |id: u32| id >= id::FIRST_TREE;
    let mut clear: BTreeSet<u32> = shown.ids.iter().copied().filter(|id| is_tree(*id)).collect();
    for (pixel, own) in shown.ids.iter().enumerate().filter(|(_, id)| is_tree(**id)) {
        let (x, y) = (pixel % width, pixel / width);
        let is_inside = x > 0 && y > 0 && x + 1 < width && y + 1 < height;
        let touches = |other: usize| is_tree(shown.ids[other]) && shown.ids[other] != *own;
        if !is_inside || [pixel - 1, pixel + 1, pixel - width, pixel + width].into_iter().any(touches) {
            clear.remove(own);
        }
    }
    clear
}

/// Returns the mean column of each tree's pixels within a range of its height.
fn columns(shown: &Shown, band: [f64; 2]) -> BTreeMap<u32, f64> {
    let trees = shown.by_id();
    let mut sums: BTreeMap<u32, (f64, f64)> = BTreeMap::new();
    for (pixel, id) in shown.ids.iter().enumerate() {
        let Some(tree) = trees.get(id) else { continue };
        let up = (shown.at_m(pixel).z - tree.at_m.z) / f64::from(tree.instance.height_m);
        if (band[0]..band[1]).contains(&up) {
            let sum = sums.entry(*id).or_default();
            *sum = (sum.0 + centre(pixel).x, sum.1 + 1.0);
        }
    }
    sums.into_iter().filter(|(_, (_, count))| *count >= 4.0).map(|(id, (sum, count))| (id, sum / count)).collect()
}

#[test]
fn tops_lean_as_far_as_the_wind_says() {
    let Some(mut world) = wooded(Form::Conifer, 20.0, Some(WIND)) else { return };
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    // The camera looks across the wind.
    let pose = world.pose("-300,-900,10,340,3,40");
    let view = View::whole(pose, pose, SIZE_PX).at(Clock::still(500.0));
    let windy = shown(&mut world, &mut renderer, view);
    world.surfaces.set_wind(None);
    let calm = shown(&mut world, &mut renderer, view);
    // The top fifth leans as much as the trunk does at about nine tenths of the height.
    let (leant, upright) = (columns(&windy, [0.8, 1.0]), columns(&calm, [0.8, 1.0]));
    let mut off = Vec::new();
    let mut leans_m = Vec::new();
    for (id, tree) in windy.by_id() {
        let (Some(leant), Some(upright)) = (leant.get(&id), upright.get(&id)) else { continue };
        let up_m = 0.88 * f64::from(tree.instance.height_m);
        let lean_m = WIND.lean_m(tree.at_m.truncate(), up_m, 500.0);
        let away_m = (tree.at_m - pose.position_m).dot(pose.forward);
        let expected_px = lean_m.dot(pose.right.truncate()) * view.focal_px() / away_m;
        if (5.0..100.0).contains(&away_m) && expected_px.abs() > 1.0 {
            off.push((leant - upright) / expected_px);
            leans_m.push(lean_m.length());
        }
    }
    let [low, middle, high] = [0.1, 0.5, 0.9].map(|part| quantile(&mut off.clone(), part));
    println!(
        "{} trees lean by a median of {:.2} m; in the picture by {low:.2}, {middle:.2}, {high:.2} of that (10th, 50th, 90th percentile)",
        off.len(),
        quantile(&mut leans_m, 0.5)
    );
    // Planted error, by the bound: half of the lean, or twice.
    assert!(off.len() >= 5 && (0.8..1.2).contains(&middle));
}

#[test]
fn a_mesh_and_its_impostor_lean_alike() {
    let all = [(Form::Broadleaf, 10.0), (Form::Conifer, 25.0)];
    for (form, speed_m_s) in all.into_iter().take(if full() { 2 } else { 1 }) {
        let wind = Wind { speed_m_s, ..WIND };
        let Some(mut world) = wooded(form, 12.0, Some(wind)) else { return };
        let mut renderer = Renderer::new(&world.gpu).unwrap();
        let bands = [[0.1, 0.4], [0.4, 0.7], [0.7, 1.0]];
        let (mut all, mut all_planted): ([Vec<f64>; 3], [Vec<f64>; 3]) = Default::default();
        for number in 0..14 {
            // The camera looks across the wind, in both directions.
            let (x_m, yaw_deg) = (120 * number - 900, 320 + 5 * (number / 2) + 180 * (number % 2));
            let pose = world.pose(&format!("{x_m},-900,55,{yaw_deg},-35,40"));
            let mut of = |detail: f64, wind: Option<Wind>, now_s: f64| {
                world.surfaces.set_wind(wind);
                world.surfaces.set_tree_detail(detail);
                shown(&mut world, &mut renderer, View::whole(pose, pose, SIZE_PX).at(Clock::still(now_s)))
            };
            // First all trees are meshes, then the small ones are impostors.
            let meshes = of(4.0, Some(wind), 77.0);
            let impostors = of(0.7, Some(wind), 77.0);
            let (calm_meshes, calm_impostors) = (of(4.0, None, 0.0), of(0.7, None, 0.0));
            let pictures = [&meshes, &impostors, &calm_meshes, &calm_impostors];
            let clear = pictures.map(that_stand_clear);
            let is_impostor = |id: u32| {
                let own: Vec<_> = impostors.trees.iter().filter(|tree| tree.instance.id == id).collect();
                own.len() == 1 && own[0].level == IMPOSTOR && clear.iter().all(|clear| clear.contains(&id))
            };
            let apart = |b: &Shown, band: [f64; 2]| {
                let all = [&meshes, b, &calm_meshes, &calm_impostors];
                let [a, b, calm_a, calm_b] = all.map(|shown| columns(shown, band));
                // How much farther the mesh has moved with the wind from its calm position than the impostor.
                let with_wind = wind.toward().dot(pose.right.truncate()).signum();
                let of_tree = |(id, at): (&u32, &f64)| {
                    let lean_a = at - calm_a.get(id)?;
                    Some((lean_a - (b.get(id)? - calm_b.get(id)?)) * with_wind).filter(|_| is_impostor(*id))
                };
                a.iter().filter_map(of_tree).collect::<Vec<f64>>()
            };
            for (number, band) in bands.into_iter().enumerate() {
                all[number].extend(apart(&impostors, band));
                // Planted error: upright impostors.
                all_planted[number].extend(apart(&calm_impostors, band));
            }
        }
        // A single tree may show another side of its impostor than in the calm, but the mean over all trees is not
        // shifted.
        for (band, (off, planted)) in bands.into_iter().zip(all.into_iter().zip(all_planted)) {
            let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len() as f64;
            let most = quantile(&mut off.iter().map(|off| off.abs()).collect::<Vec<_>>(), 0.9);
            let (count, off, planted) = (off.len(), mean(&off), mean(&planted));
            println!(
                "{form:?} at {speed_m_s} m/s, {band:?}: {count} trees, mean difference {off:.3} px, one in ten by more \
                 than {most:.3}; upright impostors {planted:.3}"
            );
            assert!(count >= 15 && off.abs() < 0.1 && most < 1.0);
            assert!(band[0] < 0.5 || planted > 0.2 && planted > 4.0 * off.abs());
        }
    }
}
