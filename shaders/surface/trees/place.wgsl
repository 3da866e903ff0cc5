// Places the trees of a block that an eye sees, and decides how each is drawn: one workgroup per block, whose threads
// take its points in turn.
//
// A tree exists if the density that the land determines at its point is above the point's rank (src/forest/mod.rs). Its
// foot is on the surface as drawn.
//
// Far away fewer trees are drawn, and each is wider, so that together they cover the land as all of them would: the
// stochastic simplification of Cook, Halstead, Planck and Ryu (2007, "Stochastic Simplification of Aggregate Detail"),
// whose order is here the rank of the points. A tree shrinks to nothing before it is removed, so none pops. Where it
// would be much wider than its natural shape, a piece of canopy that follows the slope replaces it. The representation
// of a tree changes with its height on the picture, for each tree at a size of its own; it dissolves from one to the
// next.
//
// Each tree has places of its own in the list of instances, whether it exists or not, so that the list does not depend on
// timing: blocks are sorted from near to far, and `list` makes lists of the instances that exist. A tree that is entirely
// behind the land and the models that this eye sees is in no list but that of its shadow.
#import hachure::dispatch::GROUPS_IN_ROW
#import hachure::view::{View, is_off_screen}
#import hachure::surface::{surface_near, surface_at, is_void}
#import hachure::terrain::{terrain, surface_level}
#import hachure::earth::bend
#import hachure::pcg::pcg
#import hachure::tree_ranks::{chosen_tile, rank_of}
#import hachure::forest::{Forest, Species, Site, random, stray, has_land, site_at, hollow_at, is_sea, is_still_water, density_of, suits, MAX_SPECIES, TreeRules}
#import hachure::surface_id::FIRST_TREE
#import hachure::trees::{TreeInstance, NEAR, MIDDLE, IMPOSTOR, CANOPY, TREE_LEVELS, SHADOW_PX, HAS_STROKES, INSTANCES_OF_TREE, NO_LIST, list_of, list_of_shadows, place_on_tree}
#import hachure::tree_depth::{NEARER, MAX_NEARER, TILE_PX}

// A block that may be in view. See src/forest/blocks.rs.
struct TreeBlock {
    // Corner of its tile, or of the first of them, in metres from the rig's origin.
    corner_m: vec2<f32>,
    tile: vec2<i32>,
    // First of its points, and their number.
    first: u32,
    count: u32,
    // Number of tiles, or of groups of tiles, along its side.
    tiles: u32,
    // How often four groups of tiles have merged into one that has a point.
    sparseness: u32,
    // The points that this workgroup takes, counted through all tiles: the first, and the end.
    begin: u32,
    end: u32,
    // First of their instances.
    first_instance: u32,
    padding: u32,
}

// The input of the pass, in one buffer: WebGPU guarantees eight storage buffers, and more than three uniforms are too
// many for a driver (docs/decisions/software-drivers.md).
struct Question {
    rules: TreeRules,
    blocks: array<TreeBlock>,
}

struct TreePoint {
    // Position in its tile, whose side is 1.
    at: vec2<f32>,
    number: u32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> forest: Forest;
@group(0) @binding(2) var<storage, read> tree_question: Question;
@group(0) @binding(4) var<storage, read> tree_points: array<TreePoint>;
@group(0) @binding(5) var<storage, read_write> tree_instances: array<TreeInstance>;
// For each instance the list in which it is drawn, and in the upper 16 bits the list of shadows; and the bits of its
// squared distance from the rig's origin.
@group(0) @binding(6) var<storage, read_write> tree_keys: array<vec2<u32>>;
// For each list, how many instances each block has in it.
@group(0) @binding(7) var<storage, read_write> tree_counts: array<u32>;
// The farthest depth in each tile of the picture.
@group(0) @binding(8) var tile_depth: texture_2d<f32>;
#ifdef COVER
// Density, class, height of the canopy: see src/forest/cover.rs. Rows from the south.
@group(0) @binding(25) var tree_cover: texture_2d<u32>;

// Returns the cover at a position; nothing grows outside of the rasters.
fn cover_at(xy_m: vec2<f32>) -> vec4<u32> {
    let at = vec2<i32>(floor((xy_m - tree_question.rules.cover_low_m) * tree_question.rules.cells_per_m));
    if any(at < vec2<i32>(0)) || any(at >= vec2<i32>(textureDimensions(tree_cover))) {
        return vec4<u32>(0u);
    }
    return textureLoad(tree_cover, at, 0);
}
#endif

const NOT_DRAWN: u32 = 0xffffffffu;
// At least as many as there are lists: three for each of eight species, and two.
const MAX_LISTS: u32 = 32u;
// A tree over more tiles than this is not tested.
const MAX_TILES: f32 = 256.0;

// Random variation of the height on the picture at which a tree changes its representation, relative, to either side.
const OWN_SIZE: f32 = 0.18;
// Range of that height over which the tree dissolves, relative.
const DISSOLVES: f32 = 0.16;
// Widening factors over which a canopy rises, and over which the tree shrinks.
const RISES: vec2<f32> = vec2<f32>(1.25, 1.85);
const SHRUNK: f32 = 2.1;
const SHRINKS: vec2<f32> = vec2<f32>(1.5, SHRUNK);
// Cosines between slope and sun at which trees are fully in the shade, and not at all; and their lightness in the
// shade.
const SHADE: vec2<f32> = vec2<f32>(0.0, 0.45);
const MIN_LIGHT: f32 = 0.6;
// Largest width of a crown, canopies included, in heights of the tree.
const WIDEST_CROWN: f32 = 0.75;
// Limits of the heights that a raster may give, relative to the mean height of the species.
const LOWEST: f32 = 0.3;
const TALLEST: f32 = 2.5;
// At flat angles trees hide each other, so fewer give the same coverage; this limits the effect.
const MIN_FORESHORTENING: f32 = 0.25;

var<workgroup> in_lists: array<atomic<u32>, 32>;

// Returns whether land and models hide a tree: at each pixel of a rectangle around it they are nearer than all of it.
fn is_hidden(tree: TreeInstance, level: u32) -> bool {
    let species = tree_question.rules.species[(tree.bucket & 0xffffu) / TREE_LEVELS];
    let is_canopy = level == CANOPY;
    let middle = select(species.middle, species.canopy_middle, is_canopy);
    let radius = select(species.radius, species.canopy_radius, is_canopy);
    let at_m = bend(tree.flat_m) + place_on_tree(tree, middle);
    let radius_m = radius * (max(tree.width_m, tree.height_m) + length(tree.slope) * tree.width_m) + forest.sways_m;
    let clip = view.clip_from_camera * vec4<f32>(at_m, 1.0);
    let near_m = clip.w - radius_m;
    let nearest_m = near_m - min(NEARER * max(tree.width_m - tree.height_m, 0.0), MAX_NEARER * near_m);
    if nearest_m <= view.near_m {
        return false;
    }
    let size_px = vec2<f32>(view.size_px);
    let at_px = (vec2<f32>(clip.x, -clip.y) / clip.w * 0.5 + 0.5) * size_px;
    // A sphere away from the axis is wider on the picture. The slope of a ray is less than twice that of its pixel.
    let off_axis = abs(vec2<f32>(clip.xy)) / clip.w * vec2<f32>(size_px) / view.focal_px;
    let reach_px = radius_m * view.focal_px / near_m * (1.0 + off_axis) + 1.0;
    let low = floor(clamp(at_px - reach_px, vec2<f32>(0.0), size_px - 1.0) / f32(TILE_PX));
    let high = floor(clamp(at_px + reach_px, vec2<f32>(0.0), size_px - 1.0) / f32(TILE_PX));
    let count = high - low + 1.0;
    if count.x * count.y > MAX_TILES {
        return false;
    }
    let depth = clip.z / nearest_m * (1.0 + 1e-5);
    for (var y = u32(low.y); y <= u32(high.y); y++) {
        for (var x = u32(low.x); x <= u32(high.x); x++) {
            if textureLoad(tile_depth, vec2<u32>(x, y), 0).r <= depth {
                return false;
            }
        }
    }
    return true;
}

// Adds an instance that is shown in a range of dither values, and returns its index; NOT_DRAWN for no range.
fn draw(tree: TreeInstance, level: u32, shown: vec2<f32>, number: u32) -> u32 {
    if shown.y <= shown.x {
        return NOT_DRAWN;
    }
    let species = (tree.bucket & 0xffffu) / TREE_LEVELS;
    var drawn = tree;
    drawn.bucket = (species * TREE_LEVELS + level) | (tree.bucket & 0xffff0000u);
    drawn.shown = pack2x16unorm(shown);
    tree_instances[number] = drawn;
    var list = NO_LIST;
    // A near tree may have strokes, which are tested one by one.
    if level == NEAR || !is_hidden(tree, level) {
        list = list_of(forest.species, species, level);
        atomicAdd(&in_lists[list], 1u);
    }
    tree_keys[number] = vec2<u32>(list | NO_LIST << 16u, bitcast<u32>(dot(tree.flat_m, tree.flat_m)));
    return number;
}

// Returns the share of a species at a site with a class of land cover, or without a class for 0.
fn share_of(site: Site, hollow: f32, number: u32, class_of_land: u32) -> f32 {
    var species = tree_question.rules.species[number];
#ifdef COVER
    if class_of_land > 0u {
        species.share = tree_question.rules.shares[(class_of_land - 1u) * MAX_SPECIES + number];
    }
#endif
    return suits(species, site, hollow);
}

// Returns the species of a tree.
fn species_at(site: Site, chance: f32, class_of_land: u32) -> u32 {
    var hollow = 0.0;
    if forest.asks_hollow != 0u {
        hollow = hollow_at(site);
    }
    var sum = 0.0;
    for (var i = 0u; i < forest.species; i++) {
        sum += share_of(site, hollow, i, class_of_land);
    }
    var rest = chance * sum;
    for (var i = 0u; i < forest.species; i++) {
        rest -= share_of(site, hollow, i, class_of_land);
        if rest < 0.0 {
            return i;
        }
    }
    return forest.species;
}

// Evaluates a point. Its instances have the places from `number` on.
fn examine(tile: vec2<i32>, corner_m: vec2<f32>, point: TreePoint, number: u32) {
    let rank = rank_of(tile, point.number, forest.points);
    // Most points are rejected here, where there are fewer trees than points.
    if rank >= forest.density {
        return;
    }
    let xy_m = corner_m + point.at * forest.tile_m;
    var said = vec4<u32>(255u, 0u, 0u, 255u);
#ifdef COVER
    said = cover_at(xy_m);
    if rank >= forest.density * f32(said.x) / 255.0 {
        return;
    }
#endif
    // Thinning at the distance, by a lower bound of the distance.
    let far_m = length(xy_m - view.eye_m.xy) / forest.full_m;
    if rank >= forest.density / max(far_m * far_m, 1.0) {
        return;
    }
    let site = site_at(xy_m);
    if !has_land(site.g) || is_sea(forest, site) {
        return;
    }
    let density = density_of(forest, site, stray(forest.seed, tile, point.at)) * f32(said.x) / 255.0;
    if rank >= density {
        return;
    }
    let toward_eye = view.eye_m - vec3<f32>(xy_m, site.height_m);
    let away_m = length(toward_eye);
    if away_m > forest.reach_m {
        return;
    }
    // Culling before more expensive steps, with the largest size that the tree could have here.
    let farther = max(away_m / forest.full_m, 1.0) / sqrt(MIN_FORESHORTENING);
    let tallest_m = forest.tallest_m;
    let about = vec3<f32>(xy_m, site.height_m + 0.5 * tallest_m);
    // A tree is in view if its shadow is.
    let shadow_m = select(0.0, forest.shadow_reach * tallest_m, tallest_m * view.focal_px > SHADOW_PX * away_m);
    let to_middle_m = -0.5 * shadow_m * forest.to_sun;
    let beyond_m = 0.5 * shadow_m + forest.sways_m;
    if is_off_screen(view, bend(about + to_middle_m), tallest_m * (1.0 + WIDEST_CROWN * farther) + beyond_m) {
        return;
    }
    if forest.level_is_water != 0u && is_still_water(site) {
        return;
    }
    let foreshortening = abs(dot(toward_eye, vec3<f32>(-site.slope, 1.0)))
        / max(away_m * sqrt(1.0 + dot(site.slope, site.slope)), 1e-3);
    let full_m = forest.full_m * sqrt(mix(MIN_FORESHORTENING, 1.0, foreshortening));
    let share = min(full_m * full_m / max(away_m * away_m, 1e-6), 1.0);
    // A tree shrinks before it is removed.
    let last = density * share;
    let size = clamp((last - rank) / max(0.4 * last * (1.0 - share), 1e-9), 0.0, 1.0);
    if rank >= last || is_void(site.g, away_m) {
        return;
    }
    let own = tile * i32(forest.points) + vec2<i32>(i32(point.number), 0);
    let chance = random(forest.seed, own, 2u);
    let more = random(forest.seed, own, 3u);
    let kind = species_at(site, more.x, said.y);
    if kind >= forest.species {
        return;
    }
    let species = tree_question.rules.species[kind];
    var height_m = species.height_m * mix(0.65, 1.35, chance.x);
    if said.z > 0u {
        height_m = clamp(0.25 * f32(said.z), LOWEST * species.height_m, TALLEST * species.height_m) * mix(0.85, 1.15, chance.x);
    }
    let foot_m = surface_at(surface_near(site.g, surface_level(site.g, away_m))).height_m;
    let flat_m = vec3<f32>(xy_m, foot_m);
    let wider = inverseSqrt(share);
    let crown_m = species.crown * height_m;
    let middle_m = flat_m + vec3<f32>(0.0, 0.0, 0.5 * height_m) + to_middle_m;
    if is_off_screen(view, bend(middle_m), 0.6 * height_m + 1.5 * crown_m * wider + beyond_m) {
        return;
    }
    let turn = chance.y * 6.2831853;
    // 29 bits: two trees in view seldom have the same.
    let id = FIRST_TREE | (pcg(bitcast<vec2<u32>>(own) ^ vec2<u32>(0u, forest.seed)).y >> 3u);
    // A slope that faces away from the sun is in the shade with everything on it.
    let up = normalize(vec3<f32>(-site.slope, 1.0));
    let light = mix(MIN_LIGHT, 1.0, smoothstep(SHADE.x, SHADE.y, dot(up, forest.to_sun)));
    let bucket = kind * TREE_LEVELS | u32(255.0 * light + 0.5) << 16u;
    let own_size = 1.0 + OWN_SIZE * (2.0 * more.y - 1.0);
    var next = number;
    let canopy = smoothstep(RISES.x * own_size, RISES.y * own_size, wider);
    if canopy > 0.0 {
        let scale = size * canopy;
        let width_m = crown_m * wider * sqrt(scale);
        let tree = TreeInstance(flat_m, 0.85 * height_m * scale, vec2<f32>(sin(turn), cos(turn)), width_m, id, site.slope,
            0u, bucket);
        next = select(number, number + 1u, draw(tree, CANOPY, vec2<f32>(0.0, 1.0), number) != NOT_DRAWN);
    }
    let alone = size * (1.0 - smoothstep(SHRINKS.x * own_size, SHRINKS.y * own_size, wider));
    if alone <= 0.0 {
        return;
    }
    let tall_m = height_m * alone;
    var tree = TreeInstance(flat_m, tall_m, vec2<f32>(sin(turn), cos(turn)), tall_m * min(wider, 1.3), id,
        vec2<f32>(0.0), 0u, bucket);
    // The representation depends on the tree's natural size, not on its shrunk size.
    let size_px = height_m * view.focal_px * own_size / max(away_m, 1e-3);
    let near = clamp((size_px / forest.middle_px - 1.0) / DISSOLVES + 0.5, 0.0, 1.0);
    let mesh = clamp((size_px / forest.impostor_px - 1.0) / DISSOLVES + 0.5, 0.0, 1.0);
    // A tree that is drawn mostly as its near mesh has strokes, if the style has any.
    tree.bucket |= select(0u, HAS_STROKES, near >= 0.5);
    // Of three ranges at most two are not empty.
    let of_near = draw(tree, NEAR, vec2<f32>(0.0, near), next);
    next += select(0u, 1u, of_near != NOT_DRAWN);
    let of_middle = draw(tree, MIDDLE, vec2<f32>(near, mesh), next);
    next += select(0u, 1u, of_middle != NOT_DRAWN);
    let of_impostor = draw(tree, IMPOSTOR, vec2<f32>(mesh, 1.0), min(next, number + INSTANCES_OF_TREE - 1u));
    // One shadow, whatever the tree is drawn as.
    let drawn = min(min(of_near, of_middle), of_impostor);
    if shadow_m > 0.0 && drawn != NOT_DRAWN {
        let list = list_of_shadows(forest.species, kind);
        tree_keys[drawn].x = (tree_keys[drawn].x & 0xffffu) | list << 16u;
        atomicAdd(&in_lists[list], 1u);
    }
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let number = group.x + group.y * GROUPS_IN_ROW;
    if number >= forest.blocks {
        return;
    }
    if thread < MAX_LISTS {
        atomicStore(&in_lists[thread], 0u);
    }
    workgroupBarrier();
    let block = tree_question.blocks[number];
    let i = block.begin + thread;
    if i < block.end {
        let first = block.first_instance + thread * INSTANCES_OF_TREE;
        for (var k = 0u; k < INSTANCES_OF_TREE; k++) {
            tree_keys[first + k] = vec2<u32>(NO_LIST | NO_LIST << 16u, 0u);
        }
        let which = i / block.count;
        let in_tiles = (block.tile >> vec2<u32>(block.sparseness)) + vec2<i32>(vec2<u32>(which % block.tiles, which / block.tiles));
        let tile = chosen_tile(in_tiles, block.sparseness);
        let corner_m = block.corner_m + vec2<f32>(tile - block.tile) * forest.tile_m;
        examine(tile, corner_m, tree_points[block.first + i % block.count], first);
    }
    workgroupBarrier();
    if thread < forest.species * 3u + 2u {
        tree_counts[thread * forest.blocks + number] = atomicLoad(&in_lists[thread]);
    }
}
