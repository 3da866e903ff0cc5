// Patches of 16 x 16 quads that morph (CDLOD: Strugar 2010), drawn from nothing but the index of the vertex.
//
// What we changed: the level of detail of a patch follows from its measured error, not from its distance, so patches
// of any levels may meet. Each patch has a continuous level, and each of its edges has the coarser of the two that
// meet there; a vertex that does not exist on the edge's level moves onto one that does. Positions are whole numbers
// of grid units until the last step, and both patches take that step with the same numbers: there is no crack.
#import hachure::view::View
#import hachure::terrain::{terrain, world_from_grid, level_at, vertex_height_m, is_void, UNITS_PER_SAMPLE}

@group(0) @binding(0) var<uniform> view: View;

struct Patch {
    @location(0) origin_units: vec2<i32>,
    // Log2 of the units between vertices, and the id that is written.
    @location(1) stride_log2_and_id: vec2<u32>,
    // Levels above the patch's own, at its first column, last column, first row, last row.
    @location(2) edge_levels: vec4<f32>,
    @location(3) inner_level: f32,
}

struct Vertex {
    @builtin(position) @invariant clip: vec4<f32>,
    @location(0) @interpolate(flat) id: u32,
    @location(1) g: vec2<f32>,
}

const QUADS: i32 = 16;

@vertex
fn vertex(@builtin(vertex_index) index: u32, patch_: Patch) -> Vertex {
    let ij = vec2<i32>(i32(index) % (QUADS + 1), i32(index) / (QUADS + 1));
    var level = patch_.inner_level;
    if ij.x == 0 { level = patch_.edge_levels.x; }
    if ij.x == QUADS { level = patch_.edge_levels.y; }
    if ij.y == 0 { level = patch_.edge_levels.z; }
    if ij.y == QUADS { level = patch_.edge_levels.w; }

    let whole = u32(level);
    let morph = level - f32(whole);
    let shift = vec2<u32>(whole);
    let on_level = ij >> shift;
    let from_units = grid_units(patch_, on_level << shift);
    let to_units = grid_units(patch_, (on_level & vec2<i32>(-2)) << shift);
    let a = vec2<f32>(from_units);
    let g = (a + (vec2<f32>(to_units) - a) * morph) / UNITS_PER_SAMPLE;

    let xy_m = world_from_grid(g);
    // The height is not known yet: the nearest that the terrain can be is, for both patches at an edge.
    let dz_m = max(max(terrain.min_z_m, -terrain.max_z_m), 0.0);
    let distance_m = sqrt(dot(xy_m, xy_m) + dz_m * dz_m);
    let z_m = vertex_height_m(g, level_at(g, distance_m));

    var out: Vertex;
    out.clip = view.clip_from_camera * vec4<f32>(xy_m, z_m, 1.0);
    out.id = patch_.stride_log2_and_id.y;
    out.g = g;
    return out;
}

fn grid_units(patch_: Patch, ij: vec2<i32>) -> vec2<i32> {
    let units = patch_.origin_units + (ij << vec2<u32>(patch_.stride_log2_and_id.x));
    return clamp(units, terrain.extent_units.xy, terrain.extent_units.zw);
}

@fragment
fn solid(in: Vertex) -> @location(0) u32 {
    return in.id;
}

// For patches with holes in their data.
@fragment
fn with_holes(in: Vertex) -> @location(0) u32 {
    let distance_m = view.near_m / in.clip.z;
    if is_void(in.g, i32(level_at(in.g, distance_m))) {
        discard;
    }
    return in.id;
}
