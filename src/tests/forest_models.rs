//! Species that are models behave in forests like grown ones: near, at middle distance, as impostors, as canopy.
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a panic fails the test; files are temporary")]

use crate::tests::common;

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::tests::helpers::forest::{DrawnTree, listed, of};
use common::World;
use common::draw::{NOON, draw, halves, still};
use common::grid_of;
use hachure::forest::model::TreeModel;
use hachure::frame::Renderer;
use hachure::gpu::readback::read;
use hachure::mesh::obj;
use hachure::scene::forest::Form;
use hachure::style::Style;
use hachure::surface::trees::raster::TREE_NORMAL;
use hachure::surface::trees::{CANOPY, IMPOSTOR, MIDDLE, NEAR};
use hachure::surface::{SURFACE_ID, id};

const SIZE_PX: [u32; 2] = [320, 180];

/// Returns a box as a part of an OBJ file.
fn boxed(first: u32, [low, high]: [[f64; 3]; 2]) -> String {
    let at = |i: u32| (0..3).map(move |axis| if i >> axis & 1 == 0 { low[axis] } else { high[axis] });
    let vertices = (0..8).map(|i| format!("v {}\n", at(i).map(|v| v.to_string()).collect::<Vec<_>>().join(" ")));
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = faces.map(|face| format!("f {}\n", face.map(|corner| (first + corner).to_string()).join(" ")));
    vertices.collect::<String>() + &faces.concat()
}

/// Returns a hammer, unlike any tree: a thin trunk whose upper four tenths are a wide box.
fn hammer() -> Arc<TreeModel> {
    let trunk = boxed(1, [[-0.2, 0.0, -0.2], [0.2, 6.0, 0.2]]);
    let head = boxed(9, [[-3.0, 6.0, -3.0], [3.0, 10.0, 3.0]]);
    let mesh = obj::parse("hammer.obj".to_owned(), (trunk + &head).as_bytes()).unwrap();
    Arc::new(TreeModel::new(&mesh, false).unwrap())
}

fn plain(side: u32) -> Option<World> {
    World::new(grid_of(side, side, 20.0, |_, _| 0.0), 0.02)
}

struct Picture {
    /// The pixels of each tree, by id.
    pixels: BTreeMap<u32, Vec<[u32; 2]>>,
    ids: Vec<u32>,
    lightness: Vec<f64>,
    trees: Vec<DrawnTree>,
}

fn picture(world: &mut World, renderer: &mut Renderer, camera: &str, detail: f64) -> Picture {
    world.surfaces.set_tree_detail(detail);
    let (style, pose) = (Style::load("plain").unwrap(), world.pose(camera));
    draw(&world.gpu, &mut world.surfaces, renderer, &still(pose, SIZE_PX), &style, &NOON);
    let target = renderer.target(&SURFACE_ID).unwrap();
    let ids = read(&world.gpu, target, [0, 0], target.size_px()).unwrap();
    let ids: Vec<u32> = ids.chunks_exact(4).map(|id| u32::from_le_bytes([id[0], id[1], id[2], id[3]])).collect();
    let mut pixels: BTreeMap<u32, Vec<[u32; 2]>> = BTreeMap::new();
    for (i, id) in (0..).zip(&ids).filter(|(_, id)| **id >= id::FIRST_TREE) {
        pixels.entry(*id).or_default().push([i % SIZE_PX[0], i / SIZE_PX[0]]);
    }
    let normals = halves(&world.gpu, renderer.target(&TREE_NORMAL).unwrap());
    let lightness = normals.into_iter().map(|[_, _, _, lightness]| lightness).collect();
    Picture { pixels, ids, lightness, trees: listed(world, renderer, pose.position_m) }
}

impl Picture {
    /// Returns whether all of a tree is in the picture and it touches no other.
    fn is_clear(&self, own: u32) -> bool {
        self.pixels[&own].iter().all(|&[x, y]| {
            let inside = x > 0 && y > 0 && x + 1 < SIZE_PX[0] && y + 1 < SIZE_PX[1];
            let i = (y * SIZE_PX[0] + x) as usize;
            let free = |j: usize| self.ids[j] == own || self.ids[j] < id::FIRST_TREE;
            inside && [i - 1, i + 1, i - SIZE_PX[0] as usize, i + SIZE_PX[0] as usize].into_iter().all(free)
        })
    }

    /// Returns the width of a tree near its top, relative to the width halfway up.
    fn head(&self, own: u32) -> f64 {
        let pixels = &self.pixels[&own];
        let top = pixels.iter().map(|at| at[1]).min().unwrap();
        let foot = pixels.iter().map(|at| at[1]).max().unwrap();
        let width = |up: f64| {
            let row = foot - (f64::from(foot - top) * up).round() as u32;
            pixels.iter().filter(|at| at[1] == row).count() as f64
        };
        width(0.8) / width(0.5).max(1.0)
    }
}

#[test]
fn a_model_is_seen_at_all_distances() {
    // A few trees on a small plain, against the sky.
    let Some(mut world) = plain(21) else { return };
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    world.surfaces.set_forest(Some(of(Form::Model(0), 5.0, 20.0)));
    let heads = |world: &mut World, renderer: &mut Renderer, level: u32, detail: f64| {
        let mut heads = Vec::new();
        for step in 0..60 {
            let camera = format!("{},{},9,{},0,40", 37 * step % 290 - 145, 145 - 53 * step % 290, 40 * step);
            let seen = picture(world, renderer, &camera, detail);
            let whole = seen.trees.iter().filter(|tree| tree.level == level && tree.shown == [0.0, 1.0]);
            // Trees listed at several levels are shrinking into the canopy.
            let is_alone = |own: &u32| seen.trees.iter().filter(|tree| tree.instance.id == *own).count() == 1;
            let whole = whole.map(|tree| tree.instance.id).filter(is_alone);
            for own in whole.filter(|own| seen.pixels.contains_key(own)) {
                let rows = seen.pixels[&own].iter().map(|at| at[1]);
                if seen.is_clear(own) && rows.clone().max().unwrap() - rows.min().unwrap() > 25 {
                    heads.push(seen.head(own));
                }
            }
            if !common::full() && heads.len() >= 8 {
                break;
            }
        }
        heads
    };
    for (level, detail) in [(NEAR, 8.0), (MIDDLE, 1.6), (IMPOSTOR, 0.4)] {
        world.surfaces.set_tree_models(vec![hammer()]);
        let own = heads(&mut world, &mut renderer, level, detail);
        // Planted error: the model is missing and replaced by a broadleaf.
        world.surfaces.set_tree_models(Vec::new());
        let planted = heads(&mut world, &mut renderer, level, detail);
        let least = own.iter().copied().fold(f64::INFINITY, f64::min);
        let most = planted.iter().copied().fold(0.0, f64::max);
        println!(
            "level {level}: {} trees, heads at least {least:.1}; {} broadleaves, at most {most:.1}",
            own.len(),
            planted.len()
        );
        assert!(own.len() > 5 && planted.len() > 5 && least > 5.0 && most < 2.0);
    }

    // Seen from high above, a dense forest is canopies with the model's lightness.
    let Some(mut world) = plain(321) else { return };
    let mut renderer = Renderer::new(&world.gpu).unwrap();
    let mut lightness = |models: Vec<Arc<TreeModel>>| {
        world.surfaces.set_forest(Some(of(Form::Model(0), 400.0, 20.0)));
        world.surfaces.set_tree_models(models);
        let seen = picture(&mut world, &mut renderer, "0,-2800,500,0,-14,40", 1.0);
        let canopies: Vec<u32> =
            seen.trees.iter().filter(|tree| tree.level == CANOPY).map(|tree| tree.instance.id).collect();
        let is_canopy = |id: &u32| canopies.contains(id);
        let mut shown: Vec<f64> =
            seen.ids.iter().zip(&seen.lightness).filter(|(id, _)| is_canopy(id)).map(|(_, light)| *light).collect();
        println!("{} canopies in {} pixels", canopies.len(), shown.len());
        assert!(canopies.len() > 100 && shown.len() > 5000);
        common::quantile(&mut shown, 0.5)
    };
    let pale =
        TreeModel { canopy: hammer().canopy.iter().map(|corner| lighter(*corner)).collect(), ..(*hammer()).clone() };
    let (plain, pale, missing) = (lightness(vec![hammer()]), lightness(vec![Arc::new(pale)]), lightness(Vec::new()));
    println!("canopies: {plain:.3}, of a pale model {pale:.3}, of broadleaves {missing:.3}");
    assert!((pale / plain - 1.5).abs() < 0.1 && (missing / plain - 1.0).abs() < 0.1);
}

fn lighter(corner: hachure::forest::model::TreeCorner) -> hachure::forest::model::TreeCorner {
    hachure::forest::model::TreeCorner { lightness: 1.5 * corner.lightness, ..corner }
}
