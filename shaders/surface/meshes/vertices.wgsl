// Computes the vertices of the meshes in view, as drawn: relative to the rig's origin, on the bent earth.
//
// This is a separate pass because the rasteriser, the normals and the edges need bit-identical positions, and because
// software rasterisers shade vertices on one core. The matrices are computed in f64 and are relative to the camera;
// each vertex is bent by itself, like the land around it.
#import hachure::dispatch::thread_number
#import hachure::meshes::{mesh_instances, instance_of, BY_VERTEX}
#import hachure::earth::bend

@group(0) @binding(0) var<storage, read> mesh_vertices: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> mesh_positions: array<vec4<f32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let number = thread_number(id);
    let at = instance_of(number, BY_VERTEX);
    let standing = mesh_instances[at];
    let own = number - standing.first_place;
    if own >= standing.vertices {
        return;
    }
    let place = vec4<f32>(mesh_vertices[standing.first_vertex + own].xyz, 1.0);
    let flat_m = vec3<f32>(dot(standing.east, place), dot(standing.north, place), dot(standing.up, place));
    mesh_positions[standing.first_place + own] = vec4<f32>(bend(flat_m), 1.0);
}
