//! Selects the trees that an eye sees, and how each is drawn. See `shaders/surface/trees/place.wgsl`.

use std::convert::Infallible;
use std::sync::Arc;

use glam::{DVec2, DVec3, UVec2};

use super::list::BlockPlaces;
use super::{DRAW_WORDS, DrawnTrees, list, list_of, lists, tile_depth as depths};
use crate::forest::blocks::{self, Block, Sight, Thinning};
use crate::forest::cover::Cover;
use crate::forest::points::Points;
use crate::forest::{LEVELS_OF_TILE, POINTS, TILE_M};
use crate::gpu::Gpu;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::BufferKind;
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;
use crate::gpu::scan;
use crate::gpu::target::{Group, Target, TextureName};
use crate::gpu::wgsl::shared::forest::{Forest as ForestUniform, MAX_SPECIES, Species as SpeciesRecord, TreeRules};
pub(crate) use crate::gpu::wgsl::shared::trees::TreeInstance;
use crate::gpu::wgsl::shared::trees::{CANOPY, IMPOSTOR, INSTANCES_OF_TREE, MIDDLE, NEAR, TREES_OF_GROUP};
pub(super) use crate::gpu::wgsl::surface::trees::place::TreePoint;
use crate::gpu::wgsl::surface::trees::place::{OWN_SIZE, SHRUNK, TreeBlock};
use crate::scene::forest::Species;
use crate::scene::view::View;
use crate::scene::{CoverFiles, Forest, Wind};
use crate::tiles::Terrain;
use crate::tiles::water_maps::NO_SEA_M;

/// The rasters of a forest.
const COVER: TextureName = TextureName {
    name: "tree cover",
    content: Group::Trees.shows("Rasters of the forest: share of the ground that trees cover"),
};

/// Largest number of trees that may be drawn for an eye, and so the capacity of each list. If there would be more,
/// thinning begins nearer to the eye.
pub(crate) const MAX_TREES: u32 = 1 << 17;
/// Places for their instances.
pub(crate) const MAX_INSTANCES: u32 = MAX_TREES * INSTANCES_OF_TREE;
/// Height on the picture below which fewer and wider trees are drawn, in pixels.
pub(crate) const FULL_PX: f64 = 22.0;
/// The largest distance at which forests are drawn, in metres.
pub(crate) const FARTHEST_M: f64 = 60_000.0;
/// Height on the picture below which a tree's mesh has few triangles, in pixels.
pub(crate) const MIDDLE_PX: f64 = 150.0;
/// Height on the picture below which a tree is drawn as an impostor, in pixels.
pub(crate) const IMPOSTOR_PX: f64 = 52.0;
/// Height of the tallest tree, as a multiple of its species' mean height.
pub(crate) const TALLEST: f64 = 1.35;
/// Height of the tallest tree, as the same multiple, where a raster gives the canopy height.
const TALLEST_OF_RASTER: f64 = 2.9;
/// Lower suns (by the sine of the elevation) throw no shadows. No shadow is longer than `LONGEST_SHADOW` tree heights.
const LOWEST_SUN: f64 = 0.02;
const LONGEST_SHADOW: f64 = 4.0;
/// Multiple of the distance up to which all trees are drawn, beyond which forest is drawn as canopy only.
const LAST_ALONE: f64 = (SHRUNK * (1.0 + OWN_SIZE)) as f64;
/// Number of shares: one for each land class and each species.
const SHARES: usize = CoverFiles::MAX_CLASSES * Forest::MAX_SPECIES;
/// Workgroups in a row of a dispatch.
const GROUPS_IN_ROW: u32 = crate::gpu::wgsl::shared::dispatch::GROUPS_IN_ROW;

/// For each list, the number of instances of each block.
const TREE_COUNTS: BufferKind = BufferKind::storage("tree counts");
/// [`TreeRules`], then [`TreeBlock`]s.
const TREE_QUESTION: BufferKind = BufferKind::storage("tree question");
/// Species records of a forest.
const TREE_SPECIES: BufferKind = BufferKind::storage("tree species");
const _: () = assert!(MAX_SPECIES as usize == Forest::MAX_SPECIES);

/// Inputs of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    pub eye: &'a View,
    /// The rig's origin in the world, to which positions are relative.
    pub origin_m: DVec3,
    /// The terrain, whose heights and slopes trees depend on.
    pub terrain: &'a Terrain,
    /// The forest's rules.
    pub forest: &'a Forest,
    /// Rasters of land classes and canopy heights.
    pub cover: Option<&'a Arc<Cover>>,
    /// Height of the sea, if there is one, in metres.
    pub sea_level_m: Option<f64>,
    /// The wind, if it blows.
    pub wind: Option<Wind>,
    /// Unit vector toward the sun, in world space.
    pub to_sun: DVec3,
    /// Whether the style has shadows: then trees out of view whose shadows fall into view are selected too.
    pub has_shadows: bool,
    /// Depth of land and models, behind which no tree is drawn.
    pub depth: &'a Target,
    /// [`depths::TILE_DEPTH`], which this writes and reads.
    pub tile_depth: &'a Target,
    /// Quality: the picture sizes at which trees change to a simpler level are divided by this; usually 1.
    pub detail: f64,
}

/// Uniforms and flags for the passes that draw trees.
#[derive(Clone, Debug)]
pub(crate) struct Placed {
    /// `Species` records of the forest.
    pub species: Resource,
    /// The `Forest` uniform of this eye.
    pub forest: Resource,
    /// Whether there may be trees in view that wind moves.
    pub may_sway: bool,
    /// Number of places for instances of trees.
    pub instances: u32,
}

/// Returns how far from its foot a tree's shadow is followed, away from the sun, as a multiple of the tree's height. On
/// level land a shadow ends at half of that, where there is room.
fn shadow_reach(to_sun: DVec3) -> f64 {
    if to_sun.z < LOWEST_SUN {
        return 0.0;
    }
    (2.0 * (1.0 - to_sun.z * to_sun.z) / to_sun.z + 0.5).min(LONGEST_SHADOW)
}

/// Selects the trees of a forest that an eye sees.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>, trees: &DrawnTrees) -> Placed {
    let &Inputs {
        view,
        eye,
        origin_m,
        terrain,
        forest,
        cover,
        sea_level_m,
        wind,
        to_sun,
        has_shadows,
        depth,
        tile_depth,
        detail,
    } = inputs;
    let shared = &trees.shared;
    let (height_m, focal_px) = (forest.height_m(), eye.focal_px());
    // A raster may give trees more than their species' mean height.
    let tallest_m = height_m * if forest.cover.canopy_height.is_some() { TALLEST_OF_RASTER } else { TALLEST };
    let density = forest.trees_per_ha / Forest::MAX_TREES_PER_HA;
    let shadow_reach = if has_shadows { shadow_reach(to_sun) } else { 0.0 };
    let sways_m = wind.map_or(0.0, |wind| wind.reach_m(tallest_m));
    let mut sight = Sight {
        eye_m: eye.pose.position_m,
        frustum: &eye.frustum(),
        reach_m: FARTHEST_M,
        land_m: terrain.corners_m(),
        range_m: terrain.range_m().map(f64::from),
        tallest_m,
        shadow_m: -shadow_reach * tallest_m * to_sun,
        sways_m,
        thinning: Thinning { density, full_m: height_m * focal_px * detail / FULL_PX },
    };
    let blocks = blocks::fitted(&mut sight, &shared.points, u64::from(MAX_TREES));
    // Beyond this distance there is only canopy, which does not sway.
    let sways_within_m = LAST_ALONE * sight.thinning.full_m;
    let may_sway = wind.is_some() && blocks.iter().any(|block| sight.sees_within(*block, sways_within_m));
    let packed = groups_of(&sight, &blocks, &shared.points, origin_m, lists(trees.species()));
    let instances = packed.last().map_or(0, |last| last.first_instance + (last.end - last.begin) * INSTANCES_OF_TREE);
    recorder.reset(&trees.draws, &empty_draws(trees));
    let count = packed.len() as u32;
    let uniform = ForestUniform {
        seed: forest.seed,
        blocks: count,
        capacity: MAX_TREES,
        species: forest.species.len() as u32,
        density: density as f32,
        tree_line_m: forest.tree_line_m as f32,
        raggedness_m: forest.raggedness_m as f32,
        steepest: forest.steepest_deg.to_radians().tan() as f32,
        full_m: sight.thinning.full_m as f32,
        reach_m: sight.reach_m as f32,
        middle_px: (MIDDLE_PX / detail) as f32,
        impostor_px: (IMPOSTOR_PX / detail) as f32,
        tile_m: TILE_M as f32,
        points: POINTS as f32,
        asks_hollow: forest.species.iter().any(|species| species.by_hollow != 0.0).into(),
        tallest_m: tallest_m as f32,
        sways_m: sways_m as f32,
        to_sun: to_sun.as_vec3().to_array(),
        shadow_reach: shadow_reach as f32,
        level_is_water: forest.level_is_water.into(),
        sea_m: sea_level_m.map_or(NO_SEA_M, |level_m| level_m as f32),
        ..ForestUniform::default()
    };
    let records = species_records(forest, trees);
    let species = recorder.upload(&TREE_SPECIES, &records).binding();
    let placed = Placed { species, forest: recorder.uniform("forest", &uniform), may_sway, instances };
    if packed.is_empty() && !recorder.prewarms() {
        return placed;
    }
    let [cover_low_m, cells_per_m] = grid_of(cover, origin_m);
    let rules = TreeRules { cover_low_m, cells_per_m, species: records, shares: shares(forest) };
    let question = [bytemuck::bytes_of(&rules), bytemuck::cast_slice(&packed)].concat();
    let counts = recorder.buffer(&TREE_COUNTS, 4 * (u64::from(count * lists(trees.species())) + 1));
    depths::run(recorder, view, depth, tile_depth);
    let mut resources: Vec<Named> = vec![
        ("view", view.clone()),
        ("tile_depth", tile_depth.into()),
        ("forest", placed.forest.clone()),
        ("tree_question", recorder.upload(&TREE_QUESTION, &question).binding()),
        ("tree_points", shared.point_buffer.binding()),
        ("tree_instances", trees.instances.binding()),
        ("tree_keys", trees.keys.binding()),
        ("tree_counts", counts.binding()),
    ];
    resources.extend(terrain.resources());
    let definitions: &[&str] = if cover.is_some() { &["COVER"] } else { &[] };
    if let Some(cover) = cover {
        resources.push(cover_texture(recorder, cover));
    }
    let rows = count.div_ceil(GROUPS_IN_ROW).max(1);
    recorder.groups(Compute { name: "surface/trees/place", definitions }, [count.min(GROUPS_IN_ROW), rows], &resources);
    let places: Vec<BlockPlaces> = packed
        .iter()
        .map(|block| BlockPlaces { first_instance: block.first_instance, count: block.end - block.begin })
        .collect();
    list::run(recorder, trees, &counts, &places);
    placed
}

/// Returns the blocks of a view for the shader, from near to far, each cut into parts with as many points as a workgroup
/// has threads.
fn groups_of(sight: &Sight<'_>, blocks: &[Block], points: &Points, origin_m: DVec3, lists: u32) -> Vec<TreeBlock> {
    // Both eyes of a rig have the same order, which is that of the rig's origin.
    let away_m2 = |block: &Block| {
        let middle_m = block.corner_m() + 0.5 * block.side_m() - origin_m.truncate();
        middle_m.length_squared().to_bits()
    };
    let mut sorted: Vec<(u64, &Block)> = blocks.iter().map(|block| (away_m2(block), block)).collect();
    sorted.sort_by_key(|(away_m2, block)| (*away_m2, block.level, block.tile.to_array(), block.number));
    let mut packed: Vec<TreeBlock> = Vec::with_capacity(blocks.len());
    let mut first_instance = 0;
    for (_, block) in sorted {
        let level = block.level.min(LEVELS_OF_TILE - 1) as usize;
        let corner_m = block.tile.as_dvec2() * TILE_M - origin_m.truncate();
        let (count, tiles) = (sight.listed(*block, points) as u32, block.tiles());
        let all = count * tiles * tiles;
        for begin in (0..all).step_by(TREES_OF_GROUP as usize) {
            let end = (begin + TREES_OF_GROUP).min(all);
            packed.push(TreeBlock {
                corner_m: corner_m.as_vec2().to_array(),
                tile: block.tile.to_array(),
                first: points.starts[level][block.number as usize],
                count,
                tiles,
                sparseness: block.sparseness(),
                begin,
                end,
                first_instance,
                padding: 0,
            });
            first_instance += (end - begin) * INSTANCES_OF_TREE;
        }
    }
    // A view has a few thousand blocks. If it had more than can be summed up, the farthest would be left out.
    packed.truncate((scan::MAX_VALUES / lists) as usize);
    packed
}

/// The rasters of a forest on the GPU.
struct CoverTexture {
    cover: Arc<Cover>,
    view: wgpu::TextureView,
}

/// Returns the binding of the rasters.
fn cover_texture(recorder: &mut Recorder<'_>, cover: &Arc<Cover>) -> Named {
    let made = recorder.cached(
        |known: &CoverTexture| Arc::ptr_eq(&known.cover, cover),
        |gpu| Ok::<_, Infallible>(CoverTexture { cover: Arc::clone(cover), view: cover_view(gpu, cover) }),
    );
    let Ok(texture) = made;
    ("tree_cover", Resource::Texture(COVER, texture.view.clone()))
}

/// Returns the south-western corner of the rasters, relative to the rig's origin, and their cells per metre.
fn grid_of(cover: Option<&Arc<Cover>>, origin_m: DVec3) -> [[f32; 2]; 2] {
    let Some(cover) = cover else { return [[0.0; 2]; 2] };
    let [low_m, high_m] = [cover.low_m, cover.high_m].map(DVec2::from_array);
    let cells_per_m = UVec2::from_array(cover.size).as_dvec2() / (high_m - low_m);
    [low_m - origin_m.truncate(), cells_per_m].map(|pair| pair.as_vec2().to_array())
}

fn cover_view(gpu: &Gpu, cover: &Cover) -> wgpu::TextureView {
    gpu.count_object();
    let size = wgpu::Extent3d { width: cover.size[0], height: cover.size[1], depth_or_array_layers: 1 };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("tree cover"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Uint,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * size.width), rows_per_image: None };
    gpu.queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(&cover.texels), layout, size);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// Returns the arguments of draws without instances.
fn empty_draws(trees: &DrawnTrees) -> Vec<u32> {
    let all = trees.species();
    let mut words = vec![0; (lists(all) * DRAW_WORDS) as usize];
    let mut set = |list: u32, vertices: u32| words[(list * DRAW_WORDS) as usize] = vertices;
    for (species, model) in (0..all).zip(&trees.shared.species) {
        set(list_of(all, species, NEAR), model.near.index_count);
        set(list_of(all, species, MIDDLE), model.middle.index_count);
        set(trees.list_of_shadows(species), super::shadow::CORNERS);
    }
    for level in [IMPOSTOR, CANOPY] {
        set(list_of(all, 0, level), super::impostor::SIDES);
    }
    words
}

/// Returns the shares of the species in each land class.
fn shares(forest: &Forest) -> [f32; SHARES] {
    let mut shares = [0.0; SHARES];
    for (own, class) in shares.chunks_exact_mut(Forest::MAX_SPECIES).zip(&forest.cover.classes) {
        own.iter_mut().zip(&class.shares).for_each(|(own, share)| *own = *share as f32);
    }
    shares
}

/// Returns the records of the species.
fn species_records(forest: &Forest, trees: &DrawnTrees) -> [SpeciesRecord; Forest::MAX_SPECIES] {
    let mut records = [SpeciesRecord::default(); Forest::MAX_SPECIES];
    for ((record, species), model) in records.iter_mut().zip(&forest.species).zip(&trees.shared.species) {
        let Species { share, height_m, heights_m: [low_m, high_m], aspect_deg, by_aspect, by_hollow, .. } = species;
        let (east, north) = aspect_deg.to_radians().sin_cos();
        *record = SpeciesRecord {
            share: *share as f32,
            height_m: *height_m as f32,
            low_m: *low_m as f32,
            high_m: *high_m as f32,
            aspect: (DVec2::new(east, north) * *by_aspect).as_vec2().to_array(),
            by_hollow: *by_hollow as f32,
            crown: model.crown,
            middle: model.alone.middle,
            radius: model.alone.radius,
            canopy_middle: model.canopy.middle,
            canopy_radius: model.canopy.radius,
            cylinder: model.alone.cylinder,
            canopy_cylinder: model.canopy.cylinder,
        };
    }
    records
}
