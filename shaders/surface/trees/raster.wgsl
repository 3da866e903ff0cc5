// Draws the trees in view that are meshes: depth, surface id, normal and lightness. A tree is small compared with the
// earth: it is upright at its position on the flat map, and each of its vertices is bent. In wind (WIND) vertices lean
// and flutter, and each pixel gets its displacement to the previous frame; normals do not change.
#import hachure::view::View
#import hachure::earth::bend
#import hachure::forest::Species
#import hachure::tree_form::{form_of, rounded}
#import hachure::trees::{TreeInstance, place_on_tree, normal_on_tree, is_shown, light_of, species_of, with_strokes, clear_m}
#ifdef WIND
#import hachure::wind::{Wind, Sway, moved_by_wind}
#endif

struct TreeVertex {
    // Position on a tree of height 1; w: how far wind moves it.
    at: vec4<f32>,
    // w: lightness.
    normal: vec4<f32>,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> tree_instances: array<TreeInstance>;
@group(0) @binding(2) var<storage, read> tree_order: array<u32>;
@group(0) @binding(3) var<storage, read> tree_vertices: array<TreeVertex>;
@group(0) @binding(4) var<storage, read> tree_species: array<Species>;
#ifdef WIND
@group(0) @binding(5) var<uniform> wind: Wind;
@group(0) @binding(6) var<storage, read> tree_sways: array<Sway>;
#endif
#ifdef LOCAL_COLOR
// Colour of each vertex: see hachure::local_color. The vertices of a triangle have the same colour.
@group(0) @binding(7) var<storage, read> tree_colors: array<u32>;
#endif

struct Vertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) number: u32,
    @location(1) normal: vec4<f32>,
    // Position on a tree of height 1.
    @location(2) own: vec3<f32>,
#ifdef WIND
    @location(3) step_m: vec3<f32>,
#endif
#ifdef LOCAL_COLOR
    @location(4) @interpolate(flat) color: u32,
#endif
}

struct Drawn {
    @location(0) id: u32,
    @location(1) normal: vec4<f32>,
    @location(2) form: vec4<f32>,
#ifdef WIND
    @location(3) step_m: vec4<f32>,
#endif
}

// Distance below which back faces are not drawn.
const WITHIN_M: f32 = 14.0;

@vertex
fn vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> Vertex {
    let number = tree_order[instance];
    let tree = tree_instances[number];
    let own = tree_vertices[index];
    let normal = vec4<f32>(normal_on_tree(tree, own.normal.xyz), own.normal.w * light_of(tree));
#ifdef WIND
    let from_foot_m = place_on_tree(tree, own.at.xyz);
    let moved = moved_by_wind(wind, view.focal_px, tree, tree_sways[number], own.at, from_foot_m);
    let at_m = bend(tree.flat_m + from_foot_m + moved[0]);
#else
    let at_m = bend(tree.flat_m + place_on_tree(tree, own.at.xyz));
#endif
    var out: Vertex;
    out.clip = view.clip_from_camera * vec4<f32>(at_m, 1.0);
    out.number = number;
    out.normal = normal;
    out.own = own.at.xyz;
#ifdef WIND
    out.step_m = moved[1] - moved[0];
#endif
#ifdef LOCAL_COLOR
    out.color = tree_colors[index];
#endif
    return out;
}

#ifdef LOCAL_COLOR
fn drawn(in: Vertex, is_front: bool) -> Drawn {
#else
@fragment
fn fragment(in: Vertex, @builtin(front_facing) is_front: bool) -> Drawn {
#endif
    let tree = tree_instances[in.number];
    // An eye within a crown looks out of it.
    let along_m = view.near_m / in.clip.z;
    if !is_shown(tree, in.clip.xy) || along_m < clear_m(tree, view.eye_m) || (!is_front && along_m < WITHIN_M) {
        discard;
    }
    let normal = normalize(in.normal.xyz);
    let form = form_of(view, tree, tree_species[species_of(tree)].cylinder, in.own);
    let seen = vec4<f32>(rounded(select(-normal, normal, is_front), form), with_strokes(in.normal.w, tree));
#ifdef WIND
    return Drawn(tree.id, seen, form, vec4<f32>(in.step_m, 0.0));
#else
    return Drawn(tree.id, seen, form);
#endif
}

#ifdef LOCAL_COLOR
// The same outputs, and the colour.
struct Colored {
    @location(0) id: u32,
    @location(1) normal: vec4<f32>,
    @location(2) form: vec4<f32>,
#ifdef WIND
    @location(3) step_m: vec4<f32>,
    @location(4) color: u32,
#else
    @location(3) color: u32,
#endif
}

@fragment
fn fragment(in: Vertex, @builtin(front_facing) is_front: bool) -> Colored {
    let all = drawn(in, is_front);
#ifdef WIND
    return Colored(all.id, all.normal, all.form, all.step_m, in.color);
#else
    return Colored(all.id, all.normal, all.form, in.color);
#endif
}
#endif
