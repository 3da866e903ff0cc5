// Rasterises depth and surface id of the meshes in view, from the positions that vertices.wgsl wrote, over the depth of
// the land. Both sides of a triangle are drawn: an open surface is visible from behind too.
#import hachure::view::View
#import hachure::meshes::{mesh_instances, mesh_triangles, mesh_places, instance_of, BY_TRIANGLE}
#import hachure::surface_id::FIRST_MESH

@group(0) @binding(0) var<uniform> view: View;

struct Vertex {
    @builtin(position) @invariant clip: vec4<f32>,
    @location(0) @interpolate(flat) id: u32,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Vertex {
    let standing = mesh_instances[instance_of(index / 3u, BY_TRIANGLE)];
    let number = index / 3u - standing.triangles_before;
    let triangle = mesh_triangles[standing.first_triangle + number];
    let corners = vec3<u32>(triangle.corner_a, triangle.corner_b, triangle.corner_c);
    let at_m = mesh_places[standing.first_place + corners[index % 3u]].xyz;
    return Vertex(view.clip_from_camera * vec4<f32>(at_m, 1.0), FIRST_MESH | (standing.first_number + number));
}

@fragment
fn fragment(in: Vertex) -> @location(0) u32 {
    return in.id;
}
