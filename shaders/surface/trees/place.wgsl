// Which trees of a block an eye sees, and how each is drawn: a workgroup for each block, and a point of it after the
// other for each thread.
//
// A tree exists if the density that the land asks for at its point is above the point's rank (src/forest/mod.rs). Its
// foot stands on the surface that is drawn.
//
// Far away fewer trees are drawn, and each is wider, so that together they cover the land as all of them would: the
// stochastic simplification of Cook, Halstead, Planck and Ryu (2007, "Stochastic Simplification of Aggregate Detail"),
// whose order is here the rank of the points. Before a tree goes it shrinks to nothing, so none vanishes. When it is
// much wider than it is by nature, a piece of canopy rises in its place, which lies on the slope. What a tree is drawn
// as changes with its height on the picture, for each tree at a size of its own; from one to the next it dissolves.
#import hachure::dispatch::GROUPS_IN_ROW
#import hachure::view::{View, is_beside}
#import hachure::surface::{surface_near, surface_at, is_void}
#import hachure::terrain::{terrain, surface_level}
#import hachure::earth::bend
#import hachure::pcg::pcg
#import hachure::tree_ranks::{chosen_tile, rank_of}
#import hachure::forest::{Forest, Species, Site, random, stray, has_land, site_at, hollow_at, is_still_water, density_of, suits, MOST_SPECIES, TreeRules}
#import hachure::surface_id::FIRST_TREE
#import hachure::trees::{TreeInstance, NEAR, MIDDLE, IMPOSTOR, CANOPY, TREE_LEVELS, DRAW_WORDS, SHADOW_PX, HAS_STROKES}

// A block that may be in view. See src/forest/blocks.rs.
struct TreeBlock {
    // The corner of its tile, or of the first of them, from the origin of the rig.
    corner_m: vec2<f32>,
    tile: vec2<i32>,
    // Its points.
    first: u32,
    count: u32,
    // Along its side.
    tiles: u32,
    // How often four groups of tiles have become one that has a point.
    sparseness: u32,
}

// In one buffer: WebGPU promises eight, and more than three uniforms are too many for a driver
// (docs/decisions/software-drivers.md).
struct Question {
    rules: TreeRules,
    blocks: array<TreeBlock>,
}

struct TreePoint {
    // In its tile, whose side is 1.
    at: vec2<f32>,
    number: u32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> forest: Forest;
@group(0) @binding(2) var<storage, read> tree_question: Question;
@group(0) @binding(4) var<storage, read> tree_points: array<TreePoint>;
@group(0) @binding(5) var<storage, read_write> tree_instances: array<TreeInstance>;
// For each species and level the numbers of its instances, then for each species those that throw shadows:
// `forest.capacity` each.
@group(0) @binding(6) var<storage, read_write> tree_order: array<u32>;
// For each of these lists the arguments of its draw: vertices of a tree, trees, and the first of each. Then how many
// instances there are.
@group(0) @binding(7) var<storage, read_write> tree_draws: array<atomic<u32>>;
#ifdef COVER
// Density, class, height of the canopy: see src/forest/cover.rs. Rows from the south.
@group(0) @binding(25) var tree_cover: texture_2d<u32>;

// What rasters say of a place; nothing grows outside of them.
fn cover_at(xy_m: vec2<f32>) -> vec4<u32> {
    let at = vec2<i32>(floor((xy_m - tree_question.rules.cover_low_m) * tree_question.rules.cells_per_m));
    if any(at < vec2<i32>(0)) || any(at >= vec2<i32>(textureDimensions(tree_cover))) {
        return vec4<u32>(0u);
    }
    return textureLoad(tree_cover, at, 0);
}
#endif

const TREES: u32 = 1u;
// Of a species: those of its levels, and after those of all species one of its shadows.
const LISTS: u32 = TREE_LEVELS + 1u;
const NOT_DRAWN: u32 = 0xffffffffu;

// The height on the picture at which a tree goes over strays by this for each tree, to either side.
const OWN_SIZE: f32 = 0.18;
// Over this part of the height it dissolves.
const DISSOLVES: f32 = 0.16;
// As a canopy rises a tree shrinks, by how much wider than by nature it is.
const RISES: vec2<f32> = vec2<f32>(1.25, 1.85);
const SHRUNK: f32 = 2.1;
const SHRINKS: vec2<f32> = vec2<f32>(1.5, SHRUNK);
// Cosines between slope and sun where trees are in the shade, and where they are not; and how light they are in it.
const SHADE: vec2<f32> = vec2<f32>(0.0, 0.45);
const LEAST_LIGHT: f32 = 0.6;
// By the height of a tree: no crown is wider, canopies included.
const WIDEST_CROWN: f32 = 0.75;
// Where a raster says how tall trees are: between these, by the mean height of the species.
const LOWEST: f32 = 0.3;
const TALLEST: f32 = 2.5;
// Seen along the land trees hide each other, and fewer show as much.
const LEAST_FORESHORTENING: f32 = 0.25;

// The number of its instance.
fn draw(tree: TreeInstance, level: u32, shown: vec2<f32>) -> u32 {
    if shown.y <= shown.x {
        return NOT_DRAWN;
    }
    let number = atomicAdd(&tree_draws[forest.species * LISTS * DRAW_WORDS], 1u);
    // The CPU sees to it that there is room; a tree that has none is counted all the same.
    if number >= forest.capacity {
        return NOT_DRAWN;
    }
    let bucket = (tree.bucket & 0xffffu) + level;
    list(number, bucket);
    var drawn = tree;
    drawn.bucket = bucket | (tree.bucket & 0xffff0000u);
    drawn.shown = pack2x16unorm(shown);
    tree_instances[number] = drawn;
    return number;
}

fn list(number: u32, which: u32) {
    let slot = atomicAdd(&tree_draws[which * DRAW_WORDS + TREES], 1u);
    tree_order[which * forest.capacity + slot] = number;
}

// How much of a species there is at a site, of a class of land: 0 is none.
fn share_of(site: Site, hollow: f32, number: u32, class_of_land: u32) -> f32 {
    var species = tree_question.rules.species[number];
#ifdef COVER
    if class_of_land > 0u {
        species.share = tree_question.rules.shares[(class_of_land - 1u) * MOST_SPECIES + number];
    }
#endif
    return suits(species, site, hollow);
}

// Of which species a tree is.
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

fn ask(tile: vec2<i32>, corner_m: vec2<f32>, point: TreePoint) {
    let rank = rank_of(tile, point.number, forest.points);
    // Most go here, where there are fewer trees than points.
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
    // Nor those that are too many at the distance: it is this at least.
    let far_m = length(xy_m - view.eye_m.xy) / forest.full_m;
    if rank >= forest.density / max(far_m * far_m, 1.0) {
        return;
    }
    let site = site_at(xy_m);
    if !has_land(site.g) {
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
    // Before anything that costs more: the widest that it could be here.
    let farther = max(away_m / forest.full_m, 1.0) / sqrt(LEAST_FORESHORTENING);
    let tallest_m = forest.tallest_m;
    let about = vec3<f32>(xy_m, site.height_m + 0.5 * tallest_m);
    // What throws its shadow into the picture is in view with it.
    let shadow_m = select(0.0, forest.shadow_reach * tallest_m, tallest_m * view.focal_px > SHADOW_PX * away_m);
    let to_middle_m = -0.5 * shadow_m * forest.to_sun;
    let beyond_m = 0.5 * shadow_m + forest.sways_m;
    if is_beside(view, bend(about + to_middle_m), tallest_m * (1.0 + WIDEST_CROWN * farther) + beyond_m) {
        return;
    }
    if forest.level_is_water != 0u && is_still_water(site) {
        return;
    }
    let foreshortening = abs(dot(toward_eye, vec3<f32>(-site.slope, 1.0)))
        / max(away_m * sqrt(1.0 + dot(site.slope, site.slope)), 1e-3);
    let full_m = forest.full_m * sqrt(mix(LEAST_FORESHORTENING, 1.0, foreshortening));
    let share = min(full_m * full_m / max(away_m * away_m, 1e-6), 1.0);
    // Before it goes it shrinks.
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
    if is_beside(view, bend(middle_m), 0.6 * height_m + 1.5 * crown_m * wider + beyond_m) {
        return;
    }
    let turn = chance.y * 6.2831853;
    // 29 bits: two trees in view seldom have the same.
    let id = FIRST_TREE | (pcg(bitcast<vec2<u32>>(own) ^ vec2<u32>(0u, forest.seed)).y >> 3u);
    // A slope that looks away from the sun is in the shade with all that stands on it.
    let up = normalize(vec3<f32>(-site.slope, 1.0));
    let light = mix(LEAST_LIGHT, 1.0, smoothstep(SHADE.x, SHADE.y, dot(up, forest.to_sun)));
    let bucket = kind * TREE_LEVELS | u32(255.0 * light + 0.5) << 16u;
    let own_size = 1.0 + OWN_SIZE * (2.0 * more.y - 1.0);
    let canopy = smoothstep(RISES.x * own_size, RISES.y * own_size, wider);
    if canopy > 0.0 {
        let scale = size * canopy;
        let width_m = crown_m * wider * sqrt(scale);
        let tree = TreeInstance(flat_m, 0.85 * height_m * scale, vec2<f32>(sin(turn), cos(turn)), width_m, id, site.slope,
            0u, bucket);
        _ = draw(tree, CANOPY, vec2<f32>(0.0, 1.0));
    }
    let alone = size * (1.0 - smoothstep(SHRINKS.x * own_size, SHRINKS.y * own_size, wider));
    if alone <= 0.0 {
        return;
    }
    let tall_m = height_m * alone;
    var tree = TreeInstance(flat_m, tall_m, vec2<f32>(sin(turn), cos(turn)), tall_m * min(wider, 1.3), id,
        vec2<f32>(0.0), 0u, bucket);
    // What it is drawn as goes by its size, not by what is left of it.
    let size_px = height_m * view.focal_px * own_size / max(away_m, 1e-3);
    let near = clamp((size_px / forest.middle_px - 1.0) / DISSOLVES + 0.5, 0.0, 1.0);
    let mesh = clamp((size_px / forest.impostor_px - 1.0) / DISSOLVES + 0.5, 0.0, 1.0);
    // Where most of it is the near mesh it has strokes, if there are any.
    tree.bucket |= select(0u, HAS_STROKES, near >= 0.5);
    let of_near = draw(tree, NEAR, vec2<f32>(0.0, near));
    let of_middle = draw(tree, MIDDLE, vec2<f32>(near, mesh));
    let of_impostor = draw(tree, IMPOSTOR, vec2<f32>(mesh, 1.0));
    // One shadow, whatever the tree is drawn as.
    let drawn = min(min(of_near, of_middle), of_impostor);
    if shadow_m > 0.0 && drawn != NOT_DRAWN {
        list(drawn, forest.species * TREE_LEVELS + kind);
    }
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let number = group.x + group.y * GROUPS_IN_ROW;
    if number >= forest.blocks {
        return;
    }
    let block = tree_question.blocks[number];
    let count = block.count * block.tiles * block.tiles;
    for (var i = thread; i < count; i += 64u) {
        let which = i / block.count;
        let group = (block.tile >> vec2<u32>(block.sparseness)) + vec2<i32>(vec2<u32>(which % block.tiles, which / block.tiles));
        let tile = chosen_tile(group, block.sparseness);
        let corner_m = block.corner_m + vec2<f32>(tile - block.tile) * forest.tile_m;
        ask(tile, corner_m, tree_points[block.first + i % block.count]);
    }
}
