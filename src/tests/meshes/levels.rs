//! Tests levels of detail of models: far models are drawn with fewer triangles without a visible difference, and models
//! out of view cost nothing.

use std::collections::HashMap;
use std::sync::Arc;

use glam::DVec3;
use hachure::frame::{DrawnMeshCounts, Renderer, prepare};
use hachure::gpu::readback::read;
use hachure::mesh::Mesh;
use hachure::mesh::levels::{Level, coarser};
use hachure::mesh::placed::{Placed, Room};
use hachure::mesh::simplify::simplify;
use hachure::scene::stereo::Pair;
use hachure::scene::view::{Pose, Rig};
use hachure::style::Style;
use hachure::surface::SURFACE_ID;
use hachure::surface::meshes::cull::seen;

use crate::tests::common::draw::{NOON, draw, still};
use crate::tests::common::{World, full, random, real_data};
use crate::tests::meshes::cull::{listed, town};
use crate::tests::meshes::shapes;

const SIZE_PX: [u32; 2] = [640, 360];
/// High above the land, which neither hides anything nor is hidden.
const CAMERA: &str = "100,200,3000,20,30,50";

/// A world and the renderer that draws it.
struct Bench {
    world: World,
    renderer: Renderer,
    style: Style,
}

impl Bench {
    fn new() -> Option<Self> {
        let (_, world) = shapes::hill()?;
        let renderer = Renderer::new(&world.gpu).unwrap();
        Some(Self { world, renderer, style: Style::load("plain").unwrap() })
    }

    /// Returns the triangle number of each pixel (`None` where it shows no model), and the counts of drawn instances
    /// and triangles.
    fn numbers(&mut self, placed: &Placed, pose: Pose) -> (Vec<Option<u32>>, DrawnMeshCounts) {
        let Self { world, renderer, style } = self;
        world.surfaces.set_meshes(placed.clone());
        let view = still(pose, SIZE_PX);
        draw(&world.gpu, &mut world.surfaces, renderer, &view, style, &NOON);
        let ids = read(&world.gpu, renderer.target(&SURFACE_ID).unwrap(), [0, 0], SIZE_PX).unwrap();
        let ids = ids.chunks_exact(4).map(|id| u32::from_le_bytes([id[0], id[1], id[2], id[3]]));
        let numbers = ids.map(|id| (id >> 30 == 2).then_some(id & 0x3fff_ffff)).collect();
        (numbers, renderer.drawn_meshes(&world.gpu).unwrap().unwrap())
    }
}

/// Returns rows of copies of a mesh, each at its own distance and scaled so that it is as many pixels wide as its row
/// prescribes.
fn crowd(mesh: &Arc<Mesh>, levels: Vec<Level>, pose: &Pose) -> Placed {
    let mut placed = Placed::default();
    placed.add_levels(mesh, levels).unwrap();
    let focal_px = still(*pose, SIZE_PX).focal_px();
    for i in 0..24_i64 {
        let (column, row) = (i % 6, i / 6);
        let across_px = [100.0, 55.0, 25.0, 9.0][row as usize];
        let away_m = 30.0 + 400.0 * random(i, 1);
        let place = |px: f64| px / focal_px * away_m;
        let (x_px, y_px) = (104.0 * (column as f64 - 2.5), 80.0 * (1.5 - row as f64));
        let middle_m = pose.position_m + pose.forward * away_m + pose.right * place(x_px) + pose.up * place(y_px);
        let scale = place(0.5 * across_px) / mesh.radius_m;
        let mut stance = shapes::stance(middle_m, 360.0 * random(i, 2), scale);
        stance.origin_m -= stance.world_from_mesh() * mesh.middle_m;
        placed.add(mesh, &stance).unwrap();
    }
    placed
}

/// Returns two ratios to the number of pixels on the outlines of the first picture: the number of pixels that are
/// covered in only one of the pictures, and the number of those that are farther than a pixel from its outlines.
fn moved(one: &[Option<u32>], other: &[Option<u32>]) -> [f64; 2] {
    let width = SIZE_PX[0] as usize;
    let around =
        |i: usize| [i - width - 1, i - width, i - width + 1, i - 1, i + 1, i + width - 1, i + width, i + width + 1];
    let is_outline = |i: usize| around(i).iter().any(|&j| one[i].is_some() != one[j].is_some());
    let inner = (width + 1..one.len() - width - 1).filter(|i| (1..width - 1).contains(&(i % width)));
    let (mut outline, mut differ, mut far) = (0, 0, 0);
    for i in inner {
        let is_on = is_outline(i);
        outline += usize::from(is_on && one[i].is_some());
        if one[i].is_some() != other[i].is_some() {
            differ += 1;
            far += usize::from(!is_on);
        }
    }
    [f64::from(differ) / outline as f64, far as f64 / outline as f64]
}

/// Allowed ratio of changed pixels to pixels on an outline.
const MAX_MOVED: f64 = 0.1;
/// Allowed ratio of changed pixels that are farther than a pixel from an outline.
const MAX_FAR: f64 = 0.002;

#[test]
fn a_level_moves_no_outline_by_more_than_a_pixel() {
    let Some(mut bench) = Bench::new() else { return };
    let pose = bench.world.pose(CAMERA);
    let mut meshes = vec![("ball", shapes::mesh(shapes::sphere(4)))];
    if full() {
        meshes.push(("sheet", shapes::mesh(shapes::sheet())));
    }
    let names = [
        "obj/trees_quaternius/BirchTree_2.obj",
        // These are drawn in the long tier.
        "obj/permissive/suzanne.obj",
        "obj/permissive/teapot.obj",
        "obj/trees_quaternius/DeadTree_3.obj",
    ];
    for name in names.into_iter().take(if full() { 4 } else { 1 }) {
        let read =
            |path: std::path::PathBuf| hachure::mesh::obj::read_with(&path, &hachure::source::Silent, &mut |_| ());
        meshes.extend(real_data(name).map(|path| (name, read(path).unwrap())));
    }
    let mut fewest = usize::MAX;
    for (name, mesh) in meshes {
        let mesh = Arc::new(mesh);
        let levels = coarser(&mesh);
        let counts: Vec<usize> = levels.iter().map(|level| level.mesh.triangles.len()).collect();
        let errors: Vec<f64> = levels.iter().map(|level| level.error_m / mesh.radius_m).collect();
        fewest = fewest.min(counts.len());
        let (whole, all) = bench.numbers(&crowd(&mesh, Vec::new(), &pose), pose);
        let (drawn, fewer) = bench.numbers(&crowd(&mesh, levels.clone(), &pose), pose);
        let [differ, far] = moved(&whole, &drawn);
        println!(
            "{name}: {} of {} triangles ({counts:?}, {errors:.4?}); {differ:.3} of outlines differ, {far:.4} far",
            fewer.triangles, all.triangles
        );
        assert!(all.instances == 24 && fewer.instances == 24 && all.triangles == 24 * mesh.triangles.len() as u32);
        assert!(counts.is_empty() || fewer.triangles < all.triangles);
        assert!(differ <= MAX_MOVED && far <= MAX_FAR, "{name}: {differ} of the outline pixels differ, {far} are far");
        // Planted: a coarse level that claims to be exact.
        let liar = Level { mesh: simplify(&mesh, mesh.triangles.len() / 100), error_m: 0.0 };
        let [differ, far] = moved(&whole, &bench.numbers(&crowd(&mesh, vec![liar], &pose), pose).0);
        println!("    planted: {differ:.3}, {far:.4}");
        assert!(differ > MAX_MOVED || far > MAX_FAR, "{name}: a wrong level was not detected: {differ}, {far}");
    }
    assert!(fewest > 0);
}

/// Returns the number of the first triangle of each level of each instance.
fn firsts(placed: &Placed) -> Vec<Vec<u32>> {
    let mut next = 0;
    let mut first = |triangles: usize| {
        next += triangles as u32;
        next - triangles as u32
    };
    let of = |standing: &hachure::mesh::placed::Standing| {
        let whole = first(placed.meshes[standing.mesh].triangles.len());
        let levels = placed.coarser(standing.mesh).iter().map(|level| first(level.mesh.triangles.len()));
        [whole].into_iter().chain(levels).collect()
    };
    placed.standing.iter().map(of).collect()
}

#[test]
fn the_numbers_of_triangles_stay_whatever_else_is_in_view() {
    let Some(mut bench) = Bench::new() else { return };
    let placed = town();
    let firsts = firsts(&placed);
    let (mut pixels, mut levels) = (0, [0; 3]);
    // The triangle numbers of an instance at a level begin at the same number in every view.
    for camera in ["0,0,60,0,-10,60", "-3,8,61,4,-10,60", "-700,350,400,110,-35,40"] {
        let (numbers, _) = bench.numbers(&placed, bench.world.pose(camera));
        let list = listed(&bench.world.gpu, &bench.renderer, &placed);
        let ranges: Vec<(u32, usize, usize)> =
            list.iter().map(|seen| (firsts[seen.standing][seen.level], seen.standing, seen.level)).collect();
        let triangles = |standing: usize, level: usize| {
            let mesh = placed.standing[standing].mesh;
            let count = |level: usize| placed.coarser(mesh)[level].mesh.triangles.len();
            level.checked_sub(1).map_or_else(|| placed.meshes[mesh].triangles.len(), count) as u32
        };
        let is_of = |number: u32, moved: u32| {
            ranges.iter().find(|(first, standing, level)| {
                (first + moved..first + moved + triangles(*standing, *level)).contains(&number)
            })
        };
        for number in numbers.into_iter().flatten() {
            let found = is_of(number, 0);
            assert!(found.is_some(), "{camera}: triangle number {number} belongs to no instance in view");
            pixels += 1;
            levels[found.unwrap().2] += 1;
        }
        // Planted: numbers that count only the triangles in view.
        let mut next = 0;
        let counted = ranges.iter().map(|(_, standing, level)| {
            next += triangles(*standing, *level);
            next - triangles(*standing, *level)
        });
        assert!(counted.zip(&ranges).any(|(counted, range)| counted != range.0));
    }
    assert!(pixels > 5000 && levels.iter().all(|pixels| *pixels > 20), "{pixels} {levels:?}");
}

#[test]
fn what_is_drawn_follows_what_is_in_view() {
    let Some(mut bench) = Bench::new() else { return };
    let placed = town();
    let pose = bench.world.pose("0,0,60,0,-10,60");
    let (_, counts) = bench.numbers(&placed, pose);
    let curvature = bench.world.surfaces.terrain.earth_curvature(pose.position_m.z);
    let wanted = seen(&placed, &still(pose, SIZE_PX), &curvature);
    let whole: usize = placed.standing.iter().map(|standing| placed.mesh(standing).triangles.len()).sum();
    println!("{counts:?} of {} with {whole} triangles", placed.standing.len());
    assert!(wanted.len().abs_diff(counts.instances as usize) <= 2 && counts.instances > 50 && counts.left_out == 0);
    assert!((counts.triangles as usize) < whole / 20 && counts.triangles > 1000);
    let up = Pose { forward: DVec3::Z, up: -pose.forward, ..pose };
    let away = Pose { position_m: DVec3::new(0.0, 0.0, 5000.0), ..up };
    assert_eq!(bench.numbers(&placed, away).1, DrawnMeshCounts { instances: 0, triangles: 0, left_out: 0 });
    // With less room, levels get coarser. With still less, the last instances are left out, and the others do not move.
    let ball = Arc::new(shapes::mesh(shapes::sphere(3)));
    let pose = bench.world.pose(CAMERA);
    let mut placed = crowd(&ball, coarser(&ball), &pose);
    let (all, counts) = bench.numbers(&placed, pose);
    // With a little less room than wanted, all instances are drawn with fewer triangles.
    placed.limit_room(Room { vertices: u64::from(counts.triangles) / 4, triangles: 1500 });
    let (coarse, fewer) = bench.numbers(&placed, pose);
    println!("{counts:?}, {fewer:?}");
    assert!(fewer.left_out == 0 && fewer.triangles * 2 < counts.triangles + 2 * 24 && coarse != all);
    let coarsest = placed.coarser(0).last().unwrap().mesh.vertices_m.len() as u64;
    placed.limit_room(Room { vertices: 10 * coarsest + 5, triangles: 1500 });
    let (some, less) = bench.numbers(&placed, pose);
    placed.limit_room(Room { vertices: 24 * coarsest, triangles: 1500 });
    let (all, least) = bench.numbers(&placed, pose);
    println!("{least:?}, {less:?}");
    assert!(least.left_out == 0 && less.instances == 10 && less.left_out == 14);
    let last = some.iter().flatten().max().unwrap();
    let is_same = |(all, some): (&Option<u32>, &Option<u32>)| all == some || all.is_some_and(|number| number > *last);
    let others = all.iter().zip(&some).filter(|pair| pair.0 != pair.1).count();
    assert!(all.iter().zip(&some).all(is_same) && others > 300, "{others}");
    // The same holds in a style with strokes, in which there is no room for some edges.
    let strokes = Style::load("strokes").unwrap();
    bench.style = strokes;
    let (again, stroked) = bench.numbers(&placed, pose);
    assert!(again == all && stroked == least);
}

#[test]
fn both_eyes_draw_the_same_levels() {
    let Some(mut bench) = Bench::new() else { return };
    let pose = bench.world.pose(CAMERA);
    let sheet = Arc::new(shapes::mesh(shapes::sheet()));
    // Sheets side by side and of all sizes, so that some are near a change of level.
    let mut placed = Placed::default();
    placed.add_levels(&sheet, coarser(&sheet)).unwrap();
    let focal_px = still(pose, SIZE_PX).focal_px();
    for i in 0..60_i64 {
        let away_m = 30.0 + 100.0 * random(i, 1);
        let place = |px: f64| px / focal_px * away_m;
        let (x_px, y_px) = (60.0 * ((i % 10) as f64 - 4.5), 56.0 * ((i / 10) as f64 - 2.5));
        let middle_m = pose.position_m + pose.forward * away_m + pose.right * place(x_px) + pose.up * place(y_px);
        let scale = place(3.0 + 25.0 * random(i, 2)) / sheet.radius_m;
        placed.add(&sheet, &shapes::stance(middle_m, 360.0 * random(i, 3), scale)).unwrap();
    }
    let firsts = firsts(&placed);
    bench.world.surfaces.set_meshes(placed);
    let mut levels_of = |rig: &Rig| -> Vec<HashMap<usize, usize>> {
        let Bench { world, renderer, style } = &mut bench;
        let prepared = prepare(&world.gpu, &mut world.surfaces, rig, style, &NOON);
        renderer.render_rig(&world.gpu, &world.surfaces, &prepared, rig, style, &NOON).unwrap();
        let of = |eye: usize| {
            let ids = read(&world.gpu, renderer.eye_target(eye, &SURFACE_ID).unwrap(), [0, 0], SIZE_PX).unwrap();
            let ids = ids.chunks_exact(4).map(|id| u32::from_le_bytes([id[0], id[1], id[2], id[3]]));
            let level_of = |number: u32| {
                let standing = firsts.partition_point(|levels| levels[0] <= number) - 1;
                (standing, firsts[standing].partition_point(|first| *first <= number) - 1)
            };
            ids.filter(|id| id >> 30 == 2).map(|id| level_of(id & 0x3fff_ffff)).collect()
        };
        (0..rig.eyes.len()).map(of).collect()
    };
    let differ = |one: &HashMap<usize, usize>, other: &HashMap<usize, usize>| {
        one.iter().filter(|(standing, level)| other.get(standing).is_some_and(|seen| seen != *level)).count()
    };
    let pair = Pair { ipd_m: 4.0, ..Pair::default() }.rig(&still(pose, SIZE_PX));
    let eyes = levels_of(&pair);
    let both = eyes[0].keys().filter(|standing| eyes[1].contains_key(standing)).count();
    let kinds: Vec<usize> = (0..3).map(|level| eyes[0].values().filter(|seen| **seen == level).count()).collect();
    println!("{both} in both eyes, {kinds:?} of each level");
    assert!(both > 30 && kinds.iter().all(|count| *count > 3) && differ(&eyes[0], &eyes[1]) == 0);
    // Planted: two eyes that choose their levels independently.
    let nearer = Pose { position_m: pose.position_m + 4.0 * pose.forward, ..pose };
    let alone = [pose, nearer].map(|pose| levels_of(&Rig::mono(still(pose, SIZE_PX))).remove(0));
    assert!(differ(&alone[0], &alone[1]) > 0);
}

/// Measures frame times of one ball on a hill, of a thousand, and of a thousand without levels. The three take turns.
#[test]
#[ignore = "a measurement"]
fn what_a_thousand_cost() {
    let Some((hill, mut world)) = shapes::hill() else { return };
    let ball = Arc::new(shapes::mesh(shapes::sphere(4)));
    let town = |count: i64, levels: Vec<Level>| {
        let mut placed = Placed::default();
        placed.add_levels(&ball, levels).unwrap();
        for i in 0..count {
            let (x_m, y_m) = (1200.0 * random(i, 7) - 600.0, 1400.0 * random(i, 8) - 500.0);
            let at_m = DVec3::new(x_m, y_m, hill.height_m(x_m, y_m) + 3.0);
            placed.add(&ball, &shapes::stance(at_m, 0.0, 5.0)).unwrap();
        }
        Arc::new(placed)
    };
    let towns = [town(1, coarser(&ball)), town(1000, coarser(&ball)), town(1000, Vec::new())];
    let pose = world.pose("0,-700,+40,0,-4,60");
    for name in ["lsa", "pen"] {
        let style = Style::load(name).unwrap();
        let mut frames = [(); 3].map(|()| Renderer::new(&world.gpu).unwrap());
        let mut times_ms = [(); 3].map(|()| Vec::new());
        for turn in 0..12 {
            for (town, (renderer, times_ms)) in towns.iter().zip(frames.iter_mut().zip(&mut times_ms)) {
                world.surfaces.set_meshes((**town).clone());
                // The GPU buffers are rebuilt for each of them, so the first frame is not timed.
                for is_timed in [false, true] {
                    let start = std::time::Instant::now();
                    draw(&world.gpu, &mut world.surfaces, renderer, &still(pose, SIZE_PX), &style, &NOON);
                    if is_timed && turn > 1 {
                        times_ms.push(start.elapsed().as_secs_f64() * 1e3);
                    }
                }
            }
        }
        let medians = times_ms.each_mut().map(|times_ms| crate::tests::common::quantile(times_ms, 0.5));
        let drawn = frames.each_ref().map(|renderer| renderer.drawn_meshes(&world.gpu).unwrap().unwrap());
        println!("{name}: {medians:.1?} ms, ratio {:.2} and {:.2}", medians[1] / medians[0], medians[2] / medians[0]);
        println!("    {drawn:?}");
    }
}
