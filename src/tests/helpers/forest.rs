//! Forests for tests, and readback of the trees that a frame drew.

use bytemuck::Zeroable;
use glam::{DVec3, IVec2};
use hachure::forest::blocks::first_rank;
use hachure::forest::points::Points;
use hachure::forest::{POINTS, TILE_M};
use hachure::frame::Renderer;
use hachure::gpu::readback::read_buffer;
use hachure::scene::CoverFiles;
use hachure::scene::Forest;
use hachure::scene::forest::{Form, Species};
use hachure::scene::view::Pose;
use hachure::style::Style;
use hachure::surface::trees::place::{MAX_INSTANCES, MAX_TREES};
use hachure::surface::trees::{
    DRAW_WORDS, DRAWS, INSTANCES, KEYS, NO_LIST, ORDER, TREE_LEVELS, TreeInstance, list_of, lists,
};

use crate::tests::common::World;
use crate::tests::common::draw::{NOON, draw, still};

/// A tree in one of the lists that a frame draws.
#[derive(Clone, Copy, Debug)]
pub struct DrawnTree {
    pub at_m: DVec3,
    pub species: u32,
    pub level: u32,
    /// The interval of the dither pattern in which the tree is shown, from 0 to 1.
    pub shown: [f32; 2],
    pub instance: TreeInstance,
    /// Its place among the instances.
    pub number: u32,
    /// Whether land or models hide it, so that it is in no list.
    pub is_hidden: bool,
}

/// Returns a forest of trees of one form, everywhere.
pub fn of(form: Form, trees_per_ha: f64, height_m: f64) -> Forest {
    Forest {
        seed: 7,
        trees_per_ha,
        tree_line_m: 1e6,
        raggedness_m: 0.0,
        steepest_deg: 89.0,
        level_is_water: false,
        species: vec![Species::new(form, 1.0, height_m)],
        models: Vec::new(),
        cover: CoverFiles::default(),
    }
}

/// Returns the trees that a frame draws, list by list.
pub fn drawn_trees(world: &mut World, renderer: &mut Renderer, pose: Pose, size_px: [u32; 2]) -> Vec<DrawnTree> {
    let style = Style::load("plain").unwrap();
    draw(&world.gpu, &mut world.surfaces, renderer, &still(pose, size_px), &style, &NOON);
    listed(world, renderer, pose.position_m)
}

/// Reads the trees of the last frame of an eye, with those that the land hides.
pub fn listed(world: &World, renderer: &Renderer, origin_m: DVec3) -> Vec<DrawnTree> {
    let kind = |kind| renderer.buffer(kind).unwrap().raw.clone();
    let all = MAX_INSTANCES as usize;
    let keys: Vec<[u32; 2]> = read_buffer(&world.gpu, &kind(&KEYS), all).unwrap();
    // Behind the instances of this frame may be those of another one.
    let lists = order(world, renderer);
    let count = lists.iter().flatten().max().map_or(0, |last| *last as usize + 1);
    let mut instances = vec![TreeInstance::zeroed(); count];
    if count > 0 {
        instances.copy_from_slice(&read_buffer::<TreeInstance>(&world.gpu, &kind(&INSTANCES), count).unwrap());
    }
    let species = world.surfaces.forest().unwrap().species.len() as u32;
    let mut in_list = vec![false; count];
    for (list, numbers) in lists.iter().enumerate() {
        for number in numbers {
            let bucket = instances[*number as usize].bucket & 0xffff;
            assert_eq!(list_of(species, bucket / TREE_LEVELS, bucket % TREE_LEVELS), list as u32, "a wrong list");
            assert!(!std::mem::replace(&mut in_list[*number as usize], true), "an instance is listed twice");
        }
    }
    let trees = (0..count).filter(|number| keys[*number][1] != 0).map(|number| {
        let (instance, is_hidden) = (instances[number], keys[number][0] & 0xffff == NO_LIST);
        assert_eq!(is_hidden, !in_list[number], "the lists do not have all trees");
        let bucket = instance.bucket & 0xffff;
        DrawnTree {
            at_m: DVec3::from_array(instance.flat_m.map(f64::from)) + origin_m,
            species: bucket / TREE_LEVELS,
            level: bucket % TREE_LEVELS,
            shown: [instance.shown & 0xffff, instance.shown >> 16].map(|part| part as f32 / 65535.0),
            instance,
            number: number as u32,
            is_hidden,
        }
    });
    let mut trees: Vec<DrawnTree> = trees.collect();
    trees.sort_by_key(|tree| (tree.species, tree.level));
    trees
}

/// Reads the numbers of the instances in each list of the last frame in which trees are drawn.
pub fn order(world: &World, renderer: &Renderer) -> Vec<Vec<u32>> {
    let species = world.surfaces.forest().unwrap().species.len() as u32;
    let capacity = MAX_TREES as usize;
    let words: Vec<u32> =
        read_buffer(&world.gpu, &renderer.buffer(&DRAWS).unwrap().raw, (DRAW_WORDS * lists(species)) as usize).unwrap();
    let drawn = list_of(species, 0, hachure::surface::trees::CANOPY) as usize + 1;
    let order: Vec<u32> = read_buffer(&world.gpu, &renderer.buffer(&ORDER).unwrap().raw, drawn * capacity).unwrap();
    let of_list = |list: usize| order[list * capacity..][..words[list * DRAW_WORDS as usize + 1] as usize].to_vec();
    (0..drawn).map(of_list).collect()
}

/// Returns the positions and ranks of the trees at a density, on land that suits them everywhere, in tiles within
/// `reach` of the origin.
pub fn points(reach: i32, trees_per_ha: f64) -> Vec<(DVec3, f64)> {
    let all = Points::new();
    let density = trees_per_ha / Forest::MAX_TREES_PER_HA;
    let some: Vec<_> = all.points[..POINTS as usize].iter().filter(|point| point.rank() < density).copied().collect();
    let tiles = (-reach..reach).flat_map(|y| (-reach..reach).map(move |x| IVec2::new(x, y)));
    tiles
        .flat_map(|tile| {
            some.iter()
                .map(move |point| {
                    let at_m = (tile.as_dvec2() + glam::DVec2::from_array(point.at)) * TILE_M;
                    let rank = if point.number == 0 { first_rank(tile) } else { point.rank() };
                    (at_m.extend(0.0), rank)
                })
                .collect::<Vec<_>>()
        })
        .collect()
}
