// Draws the trees in view that are meshes: depth, surface id, normal and lightness. A tree is small beside the earth: it
// stands straight on its place of the flat map, and each of its corners is bent with it.
#import hachure::view::View
#import hachure::earth::bend
#import hachure::forest::Species
#import hachure::tree_form::{form_of, rounded}
#import hachure::trees::{TreeInstance, place_on_tree, normal_on_tree, is_shown, light_of, species_of}

struct TreeVertex {
    // Of a tree that is 1 tall; w: how far wind moves it.
    at: vec4<f32>,
    // w: lightness.
    normal: vec4<f32>,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> tree_instances: array<TreeInstance>;
@group(0) @binding(2) var<storage, read> tree_order: array<u32>;
@group(0) @binding(3) var<storage, read> tree_vertices: array<TreeVertex>;
@group(0) @binding(4) var<storage, read> tree_species: array<Species>;

struct Vertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) number: u32,
    @location(1) normal: vec4<f32>,
    // Of the tree that is 1 tall.
    @location(2) own: vec3<f32>,
}

struct Drawn {
    @location(0) id: u32,
    @location(1) normal: vec4<f32>,
    @location(2) form: vec4<f32>,
}

// What is nearer to the eye is not drawn, and from within nothing that is nearer than this.
const CLEAR_M: f32 = 5.0;
const WITHIN_M: f32 = 14.0;

@vertex
fn vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> Vertex {
    let number = tree_order[instance];
    let tree = tree_instances[number];
    let own = tree_vertices[index];
    let at_m = bend(tree.flat_m + place_on_tree(tree, own.at.xyz));
    let normal = vec4<f32>(normal_on_tree(tree, own.normal.xyz), own.normal.w * light_of(tree));
    return Vertex(view.clip_from_camera * vec4<f32>(at_m, 1.0), number, normal, own.at.xyz);
}

@fragment
fn fragment(in: Vertex, @builtin(front_facing) is_front: bool) -> Drawn {
    let tree = tree_instances[in.number];
    // An eye within a crown looks out of it.
    let along_m = view.near_m / in.clip.z;
    if !is_shown(tree, in.clip.xy) || along_m < CLEAR_M || (!is_front && along_m < WITHIN_M) {
        discard;
    }
    let normal = normalize(in.normal.xyz);
    let form = form_of(view, tree, tree_species[species_of(tree)].cylinder, in.own);
    return Drawn(tree.id, vec4<f32>(rounded(select(-normal, normal, is_front), form), in.normal.w), form);
}
