// Which trees of a cell an eye sees: a workgroup for each cell, and a point of it after the other for each thread.
//
// A tree exists if the density that the land asks for at its point is above the point's rank (src/forest/mod.rs). What
// the land says is asked of a level of about RULE_M, whatever is drawn there, so that no tree comes or goes with the
// level of detail; its foot stands on the surface that is drawn.
#import hachure::dispatch::GROUPS_IN_ROW
#import hachure::view::{View, distance_from_eye, is_beside}
#import hachure::terrain::{terrain, grid_from_world, place_on_level, as_far_as_there, surface_level}
#import hachure::surface::{surface_near, surface_at, is_void}
#import hachure::earth::{bend, camera_z_m}
#import hachure::pcg::pcg
#import hachure::surface_id::FIRST_TREE
#import hachure::trees::TreeInstance

struct Forest {
    seed: u32,
    cells: u32,
    // Trees that there is room for.
    capacity: u32,
    padding: u32,
    // Of the points: 1 is all of them.
    density: f32,
    // Metres above the sea, and by how much it strays.
    tree_line_m: f32,
    raggedness_m: f32,
    // Rise over run where the last tree stands.
    steepest: f32,
    // Of a tree in the mean.
    height_m: f32,
    // What is smaller is not drawn.
    smallest_px: f32,
    // So tall on the picture, all trees are drawn.
    full_px: f32,
    padding_b: f32,
}

// A cell that may be in view.
struct TreeCell {
    // Its corner, from the origin of the rig.
    corner_m: vec2<f32>,
    tile: vec2<i32>,
    // Which of its tile's, in rows.
    number: u32,
    // Its points.
    first: u32,
    count: u32,
    padding: u32,
}

struct TreePoint {
    // In its cell.
    at_m: vec2<f32>,
    rank: f32,
    padding: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> forest: Forest;
@group(0) @binding(2) var<storage, read> tree_cells: array<TreeCell>;
@group(0) @binding(3) var<storage, read> tree_points: array<TreePoint>;
@group(0) @binding(4) var<storage, read_write> tree_instances: array<TreeInstance>;
// Arguments of an indirect draw: vertices of a tree, trees, and the first of each.
@group(0) @binding(5) var<storage, read_write> tree_draw: array<atomic<u32>>;

const TREES: u32 = 1u;

// The land is asked at this scale.
const RULE_M: f32 = 30.0;
// Of the noise that the tree line strays by: four in a tile, so that it fits together.
const PATCH_M: f32 = 64.0;
const PATCHES: i32 = 4;
const CELLS: u32 = 8u;
const CELL_M: f32 = 32.0;

fn random(at: vec2<i32>, salt: u32) -> vec2<f32> {
    let mixed = pcg(bitcast<vec2<u32>>(at) ^ vec2<u32>(forest.seed * 0x9e3779b9u, salt));
    return vec2<f32>(mixed >> vec2<u32>(8u)) / 16777216.0;
}

// −1 to 1, smooth over PATCH_M, the same for both sides of a tile's border. `in_tile` counts in patches.
fn stray(tile: vec2<i32>, in_tile: vec2<f32>) -> f32 {
    let whole = floor(in_tile);
    let corner = tile * PATCHES + vec2<i32>(whole);
    let f = in_tile - whole;
    let t = f * f * (3.0 - 2.0 * f);
    let south = mix(random(corner, 1u).x, random(corner + vec2<i32>(1, 0), 1u).x, t.x);
    let north = mix(random(corner + vec2<i32>(0, 1), 1u).x, random(corner + vec2<i32>(1, 1), 1u).x, t.x);
    return 2.0 * mix(south, north, t.y) - 1.0;
}

@compute @workgroup_size(64)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let number = group.x + group.y * GROUPS_IN_ROW;
    if number >= forest.cells {
        return;
    }
    let cell = tree_cells[number];
    for (var i = thread; i < cell.count; i += 64u) {
        let point = tree_points[cell.first + i];
        // Most go here, where there are fewer trees than points.
        if point.rank >= forest.density {
            continue;
        }
        let xy_m = cell.corner_m + point.at_m;
        let at = grid_from_world(xy_m);
        let units = at.g * terrain.units_per_sample;
        if any(units < vec2<f32>(terrain.extent_units.xy)) || any(units > vec2<f32>(terrain.extent_units.zw)) {
            continue;
        }
        let rule_level = clamp(log2(RULE_M / terrain.spacing_m), 0.0, f32(terrain.level_count - 1));
        let land = surface_at(surface_near(at.g, as_far_as_there(rule_level, place_on_level(i32(rule_level), at.g), at.g)));
        let rise = length(vec2<f32>(dot(land.gradient, at.dg_dx), dot(land.gradient, at.dg_dy)));
        let in_tile = (point.at_m + CELL_M * vec2<f32>(vec2<u32>(cell.number % CELLS, cell.number / CELLS))) / PATCH_M;
        let line_m = forest.tree_line_m + forest.raggedness_m * stray(cell.tile, in_tile);
        let below_m = line_m - (land.height_m + camera_z_m());
        // It thins out toward the tree line and toward what is too steep.
        let density = forest.density * smoothstep(0.0, max(forest.raggedness_m, 1.0), below_m)
            * (1.0 - smoothstep(0.7 * forest.steepest, forest.steepest, rise));
        if point.rank >= density {
            continue;
        }
        let own = cell.tile * 4096 + vec2<i32>(i32(cell.first + i), 0);
        let chance = random(own, 2u);
        let height_m = forest.height_m * mix(0.65, 1.35, chance.x);
        let away_m = length(vec3<f32>(xy_m, land.height_m) - view.eye_m);
        // Far away fewer are drawn, as many to a part of the picture as where they are `full_px` tall: lines of all of them
        // would be black. Those of low rank stay, and lie evenly.
        let size_px = forest.height_m * view.focal_px / max(away_m, 1e-3);
        let share = min(size_px * size_px / (forest.full_px * forest.full_px), 1.0);
        let is_small = height_m * view.focal_px < forest.smallest_px * away_m;
        if is_small || point.rank >= density * share || is_void(at.g, away_m) {
            continue;
        }
        let foot_m = surface_at(surface_near(at.g, surface_level(at.g, away_m))).height_m;
        let flat_m = vec3<f32>(xy_m, foot_m);
        if is_beside(view, bend(flat_m + vec3<f32>(0.0, 0.0, 0.5 * height_m)), 0.6 * height_m) {
            continue;
        }
        let slot = atomicAdd(&tree_draw[TREES], 1u);
        if slot >= forest.capacity {
            atomicSub(&tree_draw[TREES], 1u);
            continue;
        }
        let turn = chance.y * 6.2831853;
        // 29 bits: two trees in view seldom have the same.
        let id = FIRST_TREE | (pcg(bitcast<vec2<u32>>(own) ^ vec2<u32>(0u, forest.seed)).y >> 3u);
        tree_instances[slot] = TreeInstance(flat_m, height_m, vec2<f32>(sin(turn), cos(turn)), id, 0u);
    }
}
