//! Trees are where their points and the land allow them, each exactly once, for every camera.
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a panic fails the test; files are temporary")]

use crate::tests::common;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use crate::tests::helpers::forest::{drawn_trees, of, points};
use common::hill::Hill;
use common::{World, grid_of};
use glam::{DVec2, DVec3};
use hachure::forest::cover::Cover;
use hachure::frame::Renderer;
use hachure::scene::forest::{Form, Species, TreeFile};
use hachure::scene::reach::Reach;
use hachure::scene::{CoverClass, CoverFiles, Forest, Scene};

const SIZE_PX: [u32; 2] = [128, 72];
/// A camera that looks straight down and sees all of [`within`].
const ABOVE: &str = "0,0,1500,0,-90,60";

/// Returns a forest of trees so tall that none is left out as too small.
fn tall(trees_per_ha: f64) -> Forest {
    of(Form::Conifer, trees_per_ha, 600.0)
}

fn within(at_m: DVec2) -> bool {
    at_m.abs().cmplt(DVec2::new(700.0, 400.0)).all()
}

/// Trees by their position in centimetres: position in the world, height in metres, and id.
type Trees = BTreeMap<[i64; 2], (DVec3, f32, u32)>;

/// Returns the trees that a camera sees. A tree that dissolves between two levels is drawn twice.
fn seen(world: &mut World, forest: &Forest, camera: &str) -> Trees {
    world.surfaces.set_forest(Some(forest.clone()));
    // At this detail no tree is left out.
    world.surfaces.set_tree_detail(4.0);
    let pose = world.pose(camera);
    let trees = drawn_trees(world, &mut Renderer::new(&world.gpu).unwrap(), pose, SIZE_PX);
    let key = |at_m: DVec3| [at_m.x, at_m.y].map(|along_m| (100.0 * along_m).round() as i64);
    let mut levels: BTreeMap<[i64; 2], Vec<u32>> = BTreeMap::new();
    trees.iter().for_each(|tree| levels.entry(key(tree.at_m)).or_default().push(tree.level));
    assert!(levels.values().all(|levels| levels.is_sorted_by(|a, b| a < b)), "a tree is drawn twice at one level");
    trees.iter().map(|tree| (key(tree.at_m), (tree.at_m, tree.instance.height_m, tree.instance.id))).collect()
}

/// Returns the points whose rank is below that of the density, inside [`within`].
fn places(trees_per_ha: f64) -> Vec<DVec2> {
    points(4, trees_per_ha).into_iter().map(|(at_m, _)| at_m.truncate()).filter(|at_m| within(*at_m)).collect()
}

/// Returns the density of a forest whose trees are only counted.
fn trees_per_ha() -> f64 {
    if common::full() { 20.0 } else { 5.0 }
}

/// Returns how many points have no tree within a centimetre, and how many trees have no point.
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
    for trees_per_ha in [50.0, 10.0].into_iter().skip(usize::from(!common::full())) {
        let all = seen(&mut world, &tall(trees_per_ha), ABOVE);
        let trees: Vec<DVec3> = all.values().map(|tree| tree.0).filter(|at_m| within(at_m.truncate())).collect();
        let places = places(trees_per_ha);
        println!("{trees_per_ha} per hectare: {} points, {} trees in all", places.len(), all.len());
        assert!(places.len() as f64 > 0.95 * trees_per_ha * 112.0);
        assert_eq!(unmatched(&places, &trees), [0, 0]);
        let off_m = trees.iter().map(|at_m| (at_m.z - hill.height_m(at_m.x, at_m.y)).abs()).fold(0.0, f64::max);
        println!("largest distance of a foot from the ground {off_m:.3} m");
        assert!(off_m < 0.3, "a tree is {off_m} m above or below the ground");
        // Planted errors: a missing tree, and one that is a metre away.
        assert_eq!(unmatched(&places, &trees[1..]), [1, 0]);
        let mut moved = trees.clone();
        moved[0].x += 1.0;
        assert_eq!(unmatched(&places, &moved), [1, 1]);
    }
}

#[test]
fn trees_are_the_same_for_whoever_looks() {
    let Some(mut world) = World::new(Hill::square(321, 10.0).1, 0.02) else { return };
    let trees_per_ha = trees_per_ha();
    let forest = Forest { tree_line_m: 120.0, raggedness_m: 60.0, steepest_deg: 16.0, ..tall(trees_per_ha) };
    let [above, aside] = [ABOVE, "400,-1400,900,340,-35,70"].map(|camera| seen(&mut world, &forest, camera));
    let mut shared = 0;
    // Positions may be rounded to different centimetres, so trees are matched by id; few ids are shared by two trees.
    let by_id: BTreeMap<u32, (DVec3, f32)> =
        aside.values().map(|(at_m, height_m, id)| (*id, (*at_m, *height_m))).collect();
    for (at_m, height_m, id) in above.values() {
        let Some((other_m, other_height_m)) = by_id.get(id) else { continue };
        let is_same = at_m.truncate().distance(other_m.truncate()) < 0.01;
        shared += u32::from(is_same);
        // The foot of the tree is on the land as drawn, which depends on the camera.
        assert!(
            !is_same || (at_m.z - other_m.z).abs() < 0.3 && height_m == other_height_m,
            "{at_m} {other_m} {height_m} {other_height_m}"
        );
    }
    println!("{} from above, {} from the side, {shared} from both", above.len(), aside.len());
    assert!(f64::from(shared) > 25.0 * trees_per_ha);
    // Where both cameras see all of the land, they see the same trees.
    let near = |trees: &Trees| {
        let inner = |at_m: DVec3| at_m.truncate().distance(DVec2::new(0.0, -650.0)) < 250.0;
        let mut ids: Vec<u32> = trees.values().filter(|tree| inner(tree.0)).map(|tree| tree.2).collect();
        ids.sort_unstable();
        ids
    };
    assert!(near(&above).len() as f64 > 5.0 * trees_per_ha);
    let [near_above, near_aside] = [&above, &aside].map(near);
    let only = |a: &[u32], b: &[u32]| a.iter().filter(|id| !b.contains(id)).count();
    println!(
        "{} only from above, {} only from the side",
        only(&near_above, &near_aside),
        only(&near_aside, &near_above)
    );
    assert_eq!(near_above, near_aside);
    // Planted error: another seed.
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
    let everywhere = tall(trees_per_ha());
    let low = Forest { tree_line_m: 100.0, raggedness_m: 30.0, ..everywhere.clone() };
    let flat = Forest { steepest_deg: 10.0, ..everywhere.clone() };
    let [everywhere, low, flat] = [&everywhere, &low, &flat].map(|forest| seen(&mut world, forest, ABOVE));
    let count =
        |trees: &Trees, is_wrong: &dyn Fn(DVec3) -> bool| trees.values().filter(|tree| is_wrong(tree.0)).count();
    // The land is evaluated at the scale of 30 m, so the limits have a margin.
    let (too_high, too_steep) = (|at_m: DVec3| at_m.z > 131.0, |at_m: DVec3| slope_deg(at_m) > 10.5);
    println!("{} everywhere, {} below 100 m, {} on gentle land", everywhere.len(), low.len(), flat.len());
    assert_eq!([count(&low, &too_high), count(&flat, &too_steep)], [0, 0]);
    // Planted error: a forest without these rules.
    assert!(count(&everywhere, &too_high) > 50 && count(&everywhere, &too_steep) > 50);
    // Where no rule excludes them, all trees remain.
    let fine = |at_m: DVec3| at_m.z < 30.0;
    assert_eq!(count(&low, &fine), count(&everywhere, &fine));
    assert!(low.len() < everywhere.len() && flat.len() < everywhere.len());
}

/// Tests a round lake in rolling land, and a meadow that is almost level.
#[test]
fn no_tree_stands_in_a_lake() {
    let shore_m = 260.0;
    let land_m = |x: f64, y: f64| {
        let beyond_m = x.hypot(y) - shore_m;
        if beyond_m < 0.0 { 40.0 } else { 40.0 + 0.04 * beyond_m + 2.0 * (0.01 * x).sin() * (0.02 * beyond_m).tanh() }
    };
    let Some(mut world) = World::new(grid_of(321, 321, 10.0, land_m), 0.02) else { return };
    // In the fast tier trees are so small in the picture that they are drawn as impostors.
    let all = of(Form::Conifer, 20.0, if common::full() { 600.0 } else { 250.0 });
    let wet = Forest { level_is_water: true, ..all.clone() };
    let [with_lake, everywhere] = [&wet, &all].map(|forest| seen(&mut world, forest, ABOVE));
    let inside =
        |trees: &Trees, radius_m: f64| trees.values().filter(|tree| tree.0.truncate().length() < radius_m).count();
    let ashore = |trees: &Trees| trees.values().filter(|tree| tree.0.truncate().length() > shore_m + 25.0).count();
    println!(
        "in the lake {} of {} trees, 20 m from the shore or more {}; ashore {} of {}",
        inside(&with_lake, shore_m),
        inside(&everywhere, shore_m),
        inside(&with_lake, shore_m - 20.0),
        ashore(&with_lake),
        ashore(&everywhere)
    );
    // The land is evaluated at the scale of 30 m, so a tree may be at the shore.
    assert_eq!(inside(&with_lake, shore_m - 20.0), 0);
    assert!(inside(&with_lake, shore_m) <= inside(&everywhere, shore_m) / 8);
    assert_eq!(ashore(&with_lake), ashore(&everywhere));
    // Planted error: a forest without this rule.
    assert!(inside(&everywhere, shore_m - 20.0) > 200);
    // Land that rises only slightly is not water.
    let Some(mut meadow) = World::new(grid_of(321, 321, 10.0, |x, y| 0.002 * x + 0.001 * y), 0.02) else { return };
    let [wet, all] = [&wet, &all].map(|forest| seen(&mut meadow, forest, ABOVE).len());
    assert_eq!(wet, all);
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
    let trees_per_ha = trees_per_ha();
    let trees = seen(&mut world, &tall(trees_per_ha), ABOVE);
    let inside = |at_m: DVec2| at_m.cmpgt(DVec2::new(-100.0, -90.0)).all() && at_m.cmplt(DVec2::new(90.0, 100.0)).all();
    let wrong = trees.values().filter(|tree| inside(tree.0.truncate())).count();
    let expected = places(trees_per_ha).into_iter().filter(|at_m| inside(*at_m)).count();
    println!("{wrong} trees in a hole that has {expected} points");
    assert!(wrong == 0 && expected as f64 > 2.5 * trees_per_ha);
}

/// Tests rasters: a class of land cover has its own density and species, and a canopy raster gives heights.
#[test]
fn rasters_say_what_grows() {
    let Some(mut world) = World::new(Hill::square(321, 10.0).1, 0.02) else { return };
    let mut forest = tall(20.0);
    forest.species.push(Species::new(Form::Snag, 1.0, 600.0));
    let class = |class, shares: [f64; 2]| CoverClass { class, density: 1.0, shares: shares.to_vec() };
    forest.cover.classes = vec![class(41, [0.0, 1.0]), class(42, [1.0, 0.0])];
    // Columns from the west: no forest, the first class at half density, the second class with a canopy of 64 m.
    let texel = |column: u32| [[0, 1, 0, 255], [128, 1, 0, 255], [255, 2, 255, 255]][column as usize];
    let texels: Vec<[u8; 4]> = (0..6).map(|cell| texel(cell % 3)).collect();
    let cover = Cover { low_m: [-600.0, -400.0], high_m: [600.0, 400.0], size: [3, 2], texels };
    forest.cover.canopy_height = Some(Path::new("canopy.tif").to_owned());
    world.surfaces.set_forest_cover(Some(Arc::new(cover)));
    let forest_of = |world: &mut World, size_px: [u32; 2]| {
        world.surfaces.set_forest(Some(forest.clone()));
        world.surfaces.set_tree_detail(4.0);
        let pose = world.pose(ABOVE);
        drawn_trees(world, &mut Renderer::new(&world.gpu).unwrap(), pose, size_px)
    };
    let trees = forest_of(&mut world, SIZE_PX);
    let places = places(20.0);
    let expected = |low_m: f64, density: f64| {
        let is_within = |at_m: &&DVec2| (low_m..low_m + 400.0).contains(&at_m.x) && at_m.y.abs() < 400.0;
        density * places.iter().filter(is_within).count() as f64
    };
    let within = |low_m: f64| trees.iter().filter(move |tree| (low_m..low_m + 400.0).contains(&tree.at_m.x));
    assert!(trees.iter().all(|tree| tree.at_m.x > -200.0 && tree.at_m.x < 600.0 && tree.at_m.y.abs() < 400.0));
    for (low_m, density, species) in [(-200.0, 128.0 / 255.0, 1), (200.0, 1.0, 0)] {
        let (count, expected) = (within(low_m).count() as f64, expected(low_m, density));
        println!("from {low_m} m on {count} trees of {expected:.0}");
        // A tree that dissolves between two levels is drawn twice.
        assert!(within(low_m).all(|tree| tree.species == species) && (count / expected - 1.1).abs() < 0.12);
    }
    // The raster's 255 quarters of a metre, but at least 0.3 of the species' height.
    assert!(within(200.0).all(|tree| (150.0..=210.0).contains(&tree.instance.height_m)));
    assert!(within(-200.0).any(|tree| tree.instance.height_m > 300.0));
    // Planted error: without the cover, trees of both species are everywhere.
    world.surfaces.set_forest_cover(None);
    let everywhere = forest_of(&mut world, if common::full() { SIZE_PX } else { [64, 36] });
    assert!(everywhere.iter().any(|tree| tree.at_m.x < -200.0) && everywhere.len() > 2 * trees.len());
}

#[test]
fn a_scene_says_where_trees_stand() {
    let parse = |forest: &str| {
        let text = format!("[world]\nprocedural = {{ seed = 1 }}\n{forest}");
        Scene::parse(Path::new("scene.toml"), &text).map_err(|error| error.to_string())
    };
    assert_eq!(parse("").unwrap().forest, None);
    let forest = parse("[forest]").unwrap().forest.unwrap();
    assert!(forest.level_is_water && forest.seed == 1 && forest.trees_per_ha == 300.0 && forest.tree_line_m > 9000.0);
    let forms: Vec<Form> = forest.species.iter().map(|species| species.form).collect();
    assert_eq!(forms, [Form::Conifer, Form::Broadleaf, Form::Birch, Form::Snag]);
    let text = "[forest]\nseed = 3\ntrees_per_ha = 40.5\ntree_line_m = -20\nraggedness_m = 5\nsteepest_deg = 30\n\
                level_ground = \"land\"\nheight_m = 9\n[[forest.species]]\nform = \"birch\"\n[[forest.species]]\nform = \"snag\"\n\
                share = 0.5\nheight_m = 7\nlow_m = 100\nhigh_m = 900\naspect_deg = 200\nby_hollow = -0.5";
    let snag = Species {
        heights_m: [100.0, 900.0],
        aspect_deg: 200.0,
        by_aspect: 1.0,
        by_hollow: -0.5,
        ..Species::new(Form::Snag, 0.5, 7.0)
    };
    let expected = Forest {
        seed: 3,
        trees_per_ha: 40.5,
        tree_line_m: -20.0,
        raggedness_m: 5.0,
        steepest_deg: 30.0,
        level_is_water: false,
        species: vec![Species::new(Form::Birch, 1.0, 9.0), snag],
        models: Vec::new(),
        cover: CoverFiles::default(),
    };
    assert_eq!(parse(text).unwrap().forest, Some(expected));
    let many = "[[forest.species]]\nform = \"birch\"\n".repeat(9);
    assert!(parse(&many).unwrap_err().contains("forest.species: at most 8 are allowed"));
    for (wrong, cause) in [
        ("form = \"oak\"", "oak"),
        ("form = \"birch\"\nshare = -1", "scene.toml:5:9: forest.species.share: it must be between 0 and 1000000"),
        ("form = \"birch\"\nlow_m = 3\nhigh_m = 2", "forest.species.low_m: it is greater than high_m"),
        ("form = \"birch\"\nby_aspect = 2", "forest.species.by_aspect: it must be between 0 and 1"),
        ("share = 1", "scene.toml:3:1: forest.species: it needs form = \"conifer\" or file = \"tree.obj\""),
        ("form = \"birch\"\nfile = \"a.obj\"", "scene.toml:5:8: forest.species.file: it cannot be combined with form"),
        (
            "form = \"birch\"\nup = \"z\"",
            "scene.toml:5:6: forest.species.up: it is only used with file, which is missing",
        ),
        ("file = \"\"", "scene.toml:4:8: forest.species.file: it is empty"),
        ("file = \"https://x/a.obj\"", "scene.toml:4:8: forest.species.file: it must be a local file"),
        ("file = \"a.obj\"\nup = \"x\"", "scene.toml:5:6: "),
        ("file = 3", "scene.toml:4:8: "),
    ] {
        let error = parse(&format!("[[forest.species]]\n{wrong}")).unwrap_err();
        assert!(error.contains(cause) && error.lines().count() == 1, "{error}");
    }
    for (wrong, cause) in [
        ("trees_per_ha = 626", "scene.toml:4:16: forest.trees_per_ha: it must be between 0 and 625"),
        ("trees_per_ha = -1", "it must be between 0 and 625"),
        ("height_m = 0", "forest.height_m: it must be between 0.01 and 1000"),
        ("steepest_deg = nan", "forest.steepest_deg: it must be between 1 and 89"),
        ("tree_line_m = inf", "forest.tree_line_m"),
        ("raggedness_m = -3", "forest.raggedness_m"),
        ("seed = -1", "seed"),
        ("species = \"oak\"", "species"),
    ] {
        let error = parse(&format!("[forest]\n{wrong}")).unwrap_err();
        assert!(error.starts_with("scene.toml:4:") && error.contains(cause) && error.lines().count() == 1, "{error}");
    }
}

#[test]
fn a_species_may_be_a_model() {
    let species = [
        "file = \"a.obj\"",
        "form = \"snag\"",
        "file = \"b/c.obj\"\nup = \"z\"\nheight_m = 9",
        "file = \"a.obj\"\nup = \"y\"",
    ];
    let text: String = species.map(|keys| format!("[[forest.species]]\n{keys}\n")).concat();
    let parse = |text: &str| {
        Scene::parse(Path::new("land/s.toml"), &format!("[world]\nprocedural = {{ seed = 1 }}\n{text}")).unwrap()
    };
    let scene = parse(&text);
    let forest = scene.forest.clone().unwrap();
    let forms: Vec<Form> = forest.species.iter().map(|species| species.form).collect();
    // Each file is listed once.
    assert_eq!(forms, [Form::Model(0), Form::Snag, Form::Model(1), Form::Model(0)]);
    let model = |file: &str, z_up| TreeFile { file: file.into(), z_up };
    assert_eq!(forest.models, [model("land/a.obj", false), model("land/b/c.obj", true)]);
    assert!(forest.species[2].height_m == 9.0 && forest.species[0].height_m == 18.0);
    // Planted error: another up axis is another model.
    assert_ne!(parse(&text.replace("\"y\"", "\"z\"")).forest.unwrap().species[3].form, Form::Model(0));
    let check =
        |scene: &Scene, reach| scene.check_reach(Path::new("land/s.toml"), reach).map_err(|error| error.to_string());
    assert_eq!(check(&scene, Reach::SceneFolder), Ok(()));
    let far = parse(&text.replace("a.obj", "../a.obj"));
    let error = check(&far, Reach::SceneFolder).unwrap_err();
    assert!(error.contains("forest.species.file: ") && error.contains("--trust-scene"), "{error}");
    assert_eq!(check(&far, Reach::Anywhere), Ok(()));
}
