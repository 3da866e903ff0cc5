//! Trees stand where their points and the land say, each once, whoever looks.
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a test fails by panicking, into scratch folders")]

mod common;

use std::collections::BTreeMap;
use std::path::Path;

use bytemuck::Zeroable;
use common::World;
use common::draw::{NOON, draw, still};
use common::hill::Hill;
use glam::{DVec2, DVec3, IVec2};
use hachure::forest::cells::Cell;
use hachure::forest::points::Points;
use hachure::forest::{CELL_M, CELLS, TILE_M};
use hachure::frame::Frame;
use hachure::gpu::readback::read_buffer;
use hachure::scene::{Forest, Scene};
use hachure::style::Style;
use hachure::surface::trees::{DRAW, INSTANCES, TreeInstance};

const SIZE_PX: [u32; 2] = [128, 72];
/// Straight down, from where all of [`within`] is seen.
const ABOVE: &str = "0,0,1500,0,-90,60";

/// So tall that none is left out as too small.
const FOREST: Forest =
    Forest { seed: 7, trees_per_ha: 20.0, tree_line_m: 1e6, raggedness_m: 0.0, steepest_deg: 89.0, height_m: 600.0 };

fn within(at_m: DVec2) -> bool {
    at_m.abs().cmplt(DVec2::new(700.0, 400.0)).all()
}

/// Trees by their place in centimetres: where they stand in the world, how tall they are, and their id.
type Trees = BTreeMap<[i64; 2], (DVec3, f32, u32)>;

/// The trees of a camera.
fn seen(world: &mut World, forest: &Forest, camera: &str) -> Trees {
    world.surfaces.set_forest(Some(forest.clone()));
    let pose = world.pose(camera);
    let mut frame = Frame::new(&world.gpu).unwrap();
    let style = Style::load("plain").unwrap();
    // Tiles come with the first.
    for _ in 0..2 {
        draw(&world.gpu, &mut world.surfaces, &mut frame, &still(pose, SIZE_PX), &style, &NOON);
    }
    let count: Vec<u32> = read_buffer(&world.gpu, &frame.buffer(&DRAW).unwrap().raw, 4).unwrap();
    let mut trees = vec![TreeInstance::zeroed(); count[1] as usize];
    if !trees.is_empty() {
        trees = read_buffer(&world.gpu, &frame.buffer(&INSTANCES).unwrap().raw, trees.len()).unwrap();
    }
    let place = |tree: &TreeInstance| DVec3::from_array(tree.flat_m.map(f64::from)) + pose.position_m;
    let key = |at_m: DVec3| [at_m.x, at_m.y].map(|along_m| (100.0 * along_m).round() as i64);
    let all: Trees = trees.iter().map(|tree| (key(place(tree)), (place(tree), tree.height_m, tree.id))).collect();
    assert_eq!(all.len(), trees.len(), "each stands once");
    all
}

/// The points of a rank below that of a density, within [`within`].
fn points(trees_per_ha: f64) -> Vec<DVec2> {
    let Points { points, starts } = Points::new();
    let tiles = (-4..4).flat_map(|y| (-4..4).map(move |x| IVec2::new(x, y)));
    let cells = tiles.flat_map(|tile| (0..CELLS * CELLS).map(move |number| Cell { tile, number }));
    let of = |cell: Cell| {
        let own = &points[starts[cell.number as usize] as usize..starts[cell.number as usize + 1] as usize];
        let some = own.iter().filter(|point| point.rank < trees_per_ha / Forest::MOST_TREES_PER_HA);
        let corner_m = cell.corner_m();
        some.map(move |point| {
            let at_m = cell.tile.as_dvec2() * TILE_M + DVec2::from_array(point.at) * TILE_M;
            assert!((at_m - corner_m).cmpge(DVec2::ZERO).all() && (at_m - corner_m).cmplt(DVec2::splat(CELL_M)).all());
            at_m
        })
        .filter(|at_m| within(*at_m))
        .collect::<Vec<_>>()
    };
    cells.flat_map(of).collect()
}

/// How many of the places have no tree within a centimetre, and how many trees have no place.
fn unmatched(places: &[DVec2], trees: &[DVec3]) -> [usize; 2] {
    let near = |a: DVec2, b: DVec2| a.distance(b) < 0.01;
    let lonely = places.iter().filter(|place| !trees.iter().any(|tree| near(**place, tree.truncate()))).count();
    let strange = trees.iter().filter(|tree| !places.iter().any(|place| near(*place, tree.truncate()))).count();
    [lonely, strange]
}

#[test]
fn every_point_has_its_tree_and_no_tree_is_elsewhere() {
    let (hill, grid) = Hill::square(321, 10.0);
    let Some(mut world) = World::new(grid, 0.02) else { return };
    for trees_per_ha in [50.0, 10.0] {
        let forest = Forest { trees_per_ha, ..FOREST };
        let all = seen(&mut world, &forest, ABOVE);
        let trees: Vec<DVec3> = all.values().map(|tree| tree.0).filter(|at_m| within(at_m.truncate())).collect();
        let places = points(trees_per_ha);
        println!("{trees_per_ha} for a hectare: {} points, {} trees in all", places.len(), all.len());
        assert!(places.len() as f64 > 0.95 * trees_per_ha * 112.0);
        assert_eq!(unmatched(&places, &trees), [0, 0]);
        let off_m = trees.iter().map(|at_m| (at_m.z - hill.height_m(at_m.x, at_m.y)).abs()).fold(0.0, f64::max);
        println!("their feet are at most {off_m:.3} m off the ground");
        assert!(off_m < 0.3, "{off_m}");
        // Planted: a tree too few, and one that is a metre away.
        assert_eq!(unmatched(&places, &trees[1..]), [1, 0]);
        let mut moved = trees.clone();
        moved[0].x += 1.0;
        assert_eq!(unmatched(&places, &moved), [1, 1]);
    }
}

#[test]
fn trees_are_the_same_for_whoever_looks() {
    let Some(mut world) = World::new(Hill::square(321, 10.0).1, 0.02) else { return };
    let forest = Forest { tree_line_m: 120.0, raggedness_m: 60.0, steepest_deg: 16.0, ..FOREST };
    let [above, aside] = [ABOVE, "400,-1400,900,340,-35,70"].map(|camera| seen(&mut world, &forest, camera));
    let mut shared = 0;
    // A place may be rounded to one centimetre or the next: by ids, of which few are those of two.
    let by_id: BTreeMap<u32, (DVec3, f32)> =
        aside.values().map(|(at_m, height_m, id)| (*id, (*at_m, *height_m))).collect();
    for (at_m, height_m, id) in above.values() {
        let Some((other_m, other_height_m)) = by_id.get(id) else { continue };
        let is_same = at_m.truncate().distance(other_m.truncate()) < 0.01;
        shared += usize::from(is_same);
        // Its foot stands on the land as it is drawn.
        assert!(!is_same || (at_m.z - other_m.z).abs() < 0.3 && height_m == other_height_m);
    }
    println!("{} from above, {} from aside, {shared} from both", above.len(), aside.len());
    assert!(shared > 500);
    // What both can see, both do.
    let near = |trees: &Trees| {
        let inner = |at_m: DVec3| at_m.truncate().distance(DVec2::new(0.0, -650.0)) < 250.0;
        let mut ids: Vec<u32> = trees.values().filter(|tree| inner(tree.0)).map(|tree| tree.2).collect();
        ids.sort_unstable();
        ids
    };
    assert!(near(&above).len() > 100);
    let [near_above, near_aside] = [&above, &aside].map(near);
    let only = |a: &[u32], b: &[u32]| a.iter().filter(|id| !b.contains(id)).count();
    println!("{} only from above, {} only from aside", only(&near_above, &near_aside), only(&near_aside, &near_above));
    assert_eq!(near_above, near_aside);
    // Planted: another seed is another forest.
    let other = seen(&mut world, &Forest { seed: 8, ..forest }, ABOVE);
    assert_ne!(other, above);
}

#[test]
fn no_tree_stands_where_the_land_is_against_it() {
    let (hill, grid) = Hill::square(321, 10.0);
    let Some(mut world) = World::new(grid, 0.02) else { return };
    let slope_deg = |at_m: DVec3| {
        let along = |dx: f64, dy: f64| {
            (hill.height_m(at_m.x + dx, at_m.y + dy) - hill.height_m(at_m.x - dx, at_m.y - dy)) / 2.0
        };
        along(1.0, 0.0).hypot(along(0.0, 1.0)).atan().to_degrees()
    };
    let low = Forest { tree_line_m: 100.0, raggedness_m: 30.0, ..FOREST };
    let flat = Forest { steepest_deg: 10.0, ..FOREST };
    let [everywhere, low, flat] = [&FOREST, &low, &flat].map(|forest| seen(&mut world, forest, ABOVE));
    let count =
        |trees: &Trees, is_wrong: &dyn Fn(DVec3) -> bool| trees.values().filter(|tree| is_wrong(tree.0)).count();
    // The land is asked at the scale of 30 m.
    let (too_high, too_steep) = (|at_m: DVec3| at_m.z > 131.0, |at_m: DVec3| slope_deg(at_m) > 10.5);
    println!("{} everywhere, {} below 100 m, {} on gentle land", everywhere.len(), low.len(), flat.len());
    assert_eq!([count(&low, &too_high), count(&flat, &too_steep)], [0, 0]);
    // Planted: without the rules there are some.
    assert!(count(&everywhere, &too_high) > 50 && count(&everywhere, &too_steep) > 50);
    // And where nothing is against them they are all there.
    let fine = |at_m: DVec3| at_m.z < 30.0;
    assert_eq!(count(&low, &fine), count(&everywhere, &fine));
    assert!(low.len() < everywhere.len() && flat.len() < everywhere.len());
}

#[test]
fn holes_have_no_trees() {
    let (_, mut grid) = Hill::square(321, 10.0);
    let width = grid.width as usize;
    for (number, height_m) in grid.heights_m.iter_mut().enumerate() {
        let (x, y) = (number % width, number / width);
        if (150..170).contains(&x) && (150..170).contains(&y) {
            *height_m = f32::NAN;
        }
    }
    let Some(mut world) = World::new(grid, 0.02) else { return };
    let trees = seen(&mut world, &FOREST, ABOVE);
    let inside = |at_m: DVec2| at_m.cmpgt(DVec2::new(-100.0, -90.0)).all() && at_m.cmplt(DVec2::new(90.0, 100.0)).all();
    let wrong = trees.values().filter(|tree| inside(tree.0.truncate())).count();
    let expected = points(FOREST.trees_per_ha).into_iter().filter(|at_m| inside(*at_m)).count();
    println!("{wrong} trees in a hole that has {expected} points");
    assert!(wrong == 0 && expected > 50);
}

#[test]
fn a_scene_says_where_trees_stand() {
    let parse = |forest: &str| {
        let text = format!("[world]\nprocedural = {{ seed = 1 }}\n{forest}");
        Scene::parse(Path::new("scene.toml"), &text).map_err(|error| error.to_string())
    };
    assert_eq!(parse("").unwrap().forest, None);
    let forest = parse("[forest]").unwrap().forest.unwrap();
    assert!(forest.seed == 1 && forest.trees_per_ha == 300.0 && forest.tree_line_m > 9000.0);
    let text = "[forest]\nseed = 3\ntrees_per_ha = 40.5\ntree_line_m = -20\nraggedness_m = 5\nsteepest_deg = 30\n\
                height_m = 9";
    let expected = Forest {
        seed: 3,
        trees_per_ha: 40.5,
        tree_line_m: -20.0,
        raggedness_m: 5.0,
        steepest_deg: 30.0,
        height_m: 9.0,
    };
    assert_eq!(parse(text).unwrap().forest, Some(expected));
    for (wrong, told) in [
        ("trees_per_ha = 626", "scene.toml:4:16: forest.trees_per_ha: it must lie within 0 to 625"),
        ("trees_per_ha = -1", "it must lie within 0 to 625"),
        ("height_m = 0", "forest.height_m: it must lie within 0.01 to 1000"),
        ("steepest_deg = nan", "forest.steepest_deg: it must lie within 1 to 89"),
        ("tree_line_m = inf", "forest.tree_line_m"),
        ("raggedness_m = -3", "forest.raggedness_m"),
        ("seed = -1", "seed"),
        ("species = \"oak\"", "species"),
    ] {
        let error = parse(&format!("[forest]\n{wrong}")).unwrap_err();
        assert!(error.starts_with("scene.toml:4:") && error.contains(told) && error.lines().count() == 1, "{error}");
    }
}
