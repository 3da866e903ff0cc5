// Rasterises depth of the patches, and their surface ids if they are wanted, from the positions that vertices.wgsl wrote.
#import hachure::view::View
#import hachure::mesh::{Patch, VERTICES}
#import hachure::terrain::grid_from_world
#import hachure::surface::is_void
#import hachure::earth::unbend

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> patches: array<Patch>;
@group(0) @binding(2) var<storage, read> positions: array<vec4<f32>>;

struct Vertex {
    @builtin(position) @invariant clip: vec4<f32>,
    @location(0) @interpolate(flat) id: u32,
    @location(1) at_m: vec3<f32>,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> Vertex {
    let at_m = positions[instance * VERTICES + index].xyz;
    // The highest bit is for meshes.
    let id = max(patches[instance].id & 0x7fffffffu, 1u);
    return Vertex(view.clip_from_camera * vec4<f32>(at_m, 1.0), id, at_m);
}

@fragment
fn solid(in: Vertex) -> @location(0) u32 {
    return in.id;
}

fn is_hole(in: Vertex) -> bool {
    let flat_m = unbend(in.at_m).flat_m;
    return is_void(grid_from_world(flat_m.xy).g, length(flat_m));
}

// For patches with holes in their data.
@fragment
fn with_holes(in: Vertex) -> @location(0) u32 {
    if is_hole(in) {
        discard;
    }
    return in.id;
}

// The same without ids. Patches without holes and ids have no fragment shader.
@fragment
fn only_holes(in: Vertex) {
    if is_hole(in) {
        discard;
    }
}
