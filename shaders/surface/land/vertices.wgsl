// Computes the vertices of the patches, morphed (CDLOD: Strugar 2010): camera-relative positions, as drawn.
//
// Changes: a patch's level of detail follows from its measured error, not from its distance, so patches of any levels
// may meet. Each patch has a continuous level, and each of its edges has the coarser of the two levels that meet there;
// a vertex that does not exist on the edge's level moves onto one that does. Positions are integers in grid units until
// the last step, and both patches take that step with the same numbers, so there are no cracks.
//
// The vertices next to an edge morph onto it, and must arrive at the edge's own morphed vertices: only then do four
// siblings have the shape of their parent when they appear, even if the parent had a coarser neighbour.
//
// This is a separate pass because a software rasteriser shades vertices on one core, and because later passes need the
// triangles as drawn.
#import hachure::mesh::{Patch, QUADS, VERTICES}
#import hachure::terrain::{terrain, world_from_grid}
#import hachure::surface::vertex_height_m
#import hachure::earth::bend

@group(0) @binding(0) var<storage, read> patches: array<Patch>;
// VERTICES for each patch, row by row; relative to the camera, in metres.
@group(0) @binding(1) var<storage, read_write> positions: array<vec4<f32>>;

fn grid_units(quads: Patch, ij: vec2<i32>) -> vec2<i32> {
    let units = quads.origin_units + (ij << vec2<u32>(quads.stride_exponent));
    return clamp(units, terrain.extent_units.xy, terrain.extent_units.zw);
}

// Returns the level of a patch's edge, relative to the patch's own; 0 inside.
fn edge_level(quads: Patch, ij: vec2<i32>) -> f32 {
    var level = 0.0;
    if ij.x == 0 { level = quads.edge_levels.x; }
    if ij.x == QUADS { level = quads.edge_levels.y; }
    if ij.y == 0 { level = quads.edge_levels.z; }
    if ij.y == QUADS { level = quads.edge_levels.w; }
    return level;
}

// Returns the position of a vertex if only edges morph, in grid units.
fn on_edge_units(quads: Patch, ij: vec2<i32>) -> vec2<f32> {
    let level = edge_level(quads, ij);
    let whole = u32(level);
    let shift = vec2<u32>(whole);
    let on_level = ij >> shift;
    let a = vec2<f32>(grid_units(quads, on_level << shift));
    let b = vec2<f32>(grid_units(quads, (on_level & vec2<i32>(-2)) << shift));
    return a + (b - a) * (level - f32(whole));
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= VERTICES {
        return;
    }
    let quads = patches[id.y];
    let ij = vec2<i32>(i32(id.x) % (QUADS + 1), i32(id.x) / (QUADS + 1));
    let is_inside = all(ij > vec2<i32>(0)) && all(ij < vec2<i32>(QUADS));
    let level = select(0.0, quads.inner_level, is_inside);
    let whole = u32(level);
    let shift = vec2<u32>(whole);
    let on_level = ij >> shift;
    let a = on_edge_units(quads, on_level << shift);
    let b = on_edge_units(quads, (on_level & vec2<i32>(-2)) << shift);
    let g = (a + (b - a) * (level - f32(whole))) / terrain.units_per_sample;

    let xy_m = world_from_grid(g);
    // The height is not known yet. The nearest possible height serves instead, for both patches at an edge.
    let dz_m = max(max(terrain.min_z_m, -terrain.max_z_m), 0.0);
    let distance_m = sqrt(dot(xy_m, xy_m) + dz_m * dz_m);
    let at_m = bend(vec3<f32>(xy_m, vertex_height_m(g, distance_m)));
    positions[id.y * VERTICES + id.x] = vec4<f32>(at_m, 1.0);
}
