// Draws the trees in view: depth, surface id and normal. A tree is small beside the earth: it stands straight on its
// place of the flat map, and each of its corners is bent with it.
#import hachure::view::View
#import hachure::earth::bend
#import hachure::trees::TreeInstance

struct TreeVertex {
    // Of a tree that is 1 tall.
    at: vec4<f32>,
    normal: vec4<f32>,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> tree_instances: array<TreeInstance>;
@group(0) @binding(2) var<storage, read> tree_vertices: array<TreeVertex>;

struct Vertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) id: u32,
    @location(1) normal: vec3<f32>,
}

struct Drawn {
    @location(0) id: u32,
    @location(1) normal: vec4<f32>,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) number: u32) -> Vertex {
    let tree = tree_instances[number];
    let own = tree_vertices[index];
    let turn = mat2x2<f32>(vec2<f32>(tree.turn.y, tree.turn.x), vec2<f32>(-tree.turn.x, tree.turn.y));
    let at_m = tree.flat_m + tree.height_m * vec3<f32>(turn * own.at.xy, own.at.z);
    return Vertex(
        view.clip_from_camera * vec4<f32>(bend(at_m), 1.0), tree.id, vec3<f32>(turn * own.normal.xy, own.normal.z));
}

@fragment
fn fragment(in: Vertex, @builtin(front_facing) is_front: bool) -> Drawn {
    let normal = normalize(in.normal);
    return Drawn(in.id, vec4<f32>(select(-normal, normal, is_front), 1.0));
}
