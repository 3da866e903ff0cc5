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
use hachure::surface::trees::{DRAW_WORDS, DRAWS, INSTANCES, ORDER, TREE_LEVELS, TREE_LISTS, TreeInstance};

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

/// Reads the trees of the last frame of an eye.
pub fn listed(world: &World, renderer: &Renderer, origin_m: DVec3) -> Vec<DrawnTree> {
    let species = world.surfaces.forest().unwrap().species.len() as u32;
    let buckets = species * TREE_LEVELS;
    let lists = species * TREE_LISTS;
    let words: Vec<u32> =
        read_buffer(&world.gpu, &renderer.buffer(&DRAWS).unwrap().raw, (DRAW_WORDS * (lists + 1)) as usize).unwrap();
    let count = words[(lists * DRAW_WORDS) as usize] as usize;
    let capacity = hachure::surface::trees::place::MAX_TREES as usize;
    assert!(count <= capacity, "{count} trees, more than the capacity of {capacity}");
    if count == 0 {
        return Vec::new();
    }
    let mut instances = vec![TreeInstance::zeroed(); count];
    instances.copy_from_slice(
        &read_buffer::<TreeInstance>(&world.gpu, &renderer.buffer(&INSTANCES).unwrap().raw, count).unwrap(),
    );
    let order: Vec<u32> =
        read_buffer(&world.gpu, &renderer.buffer(&ORDER).unwrap().raw, buckets as usize * capacity).unwrap();
    let of_bucket = |bucket: u32| {
        let first = bucket as usize * capacity;
        let own = &order[first..first + words[(bucket * DRAW_WORDS + 1) as usize] as usize];
        own.iter().map(move |number| (bucket, *number)).collect::<Vec<_>>()
    };
    let trees = (0..buckets).flat_map(of_bucket).map(|(bucket, number)| {
        let instance = instances[number as usize];
        assert_eq!(instance.bucket & 0xffff, bucket, "a tree is in a list of another species or level");
        DrawnTree {
            at_m: DVec3::from_array(instance.flat_m.map(f64::from)) + origin_m,
            species: bucket / TREE_LEVELS,
            level: bucket % TREE_LEVELS,
            shown: [instance.shown & 0xffff, instance.shown >> 16].map(|part| part as f32 / 65535.0),
            instance,
        }
    });
    let trees: Vec<DrawnTree> = trees.collect();
    assert_eq!(trees.len(), count, "the lists do not have all trees");
    trees
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
