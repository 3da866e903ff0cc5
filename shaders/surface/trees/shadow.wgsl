// The shadows of trees: which pixels are in the shadow of a tree.
//
// A tree's shadow is an upright cylinder extruded away from the sun. A box contains it, and its faces toward the eye
// are drawn where they are in front of the visible surface. Each pixel's point then tests, along its ray to the sun,
// whether the tree hides the sun: by the depths of the picture taken from nearest to the sun, where the ray meets them.
// So a shadow has the outline of its tree, falls on land, models and other trees alike, and needs no shadow map whose
// texels could be visible; its cost depends on the area that it covers on the picture.
//
// A tree does not shadow itself: its normals shade it. In wind (WIND) its shadow leans with it, by the straight part of
// the lean.
#import hachure::view::View
#import hachure::seen::place_seen
#import hachure::earth::bend
#import hachure::forest::{Forest, Species}
#ifdef WIND
#import hachure::wind::{Sway, lean_at}
#endif
#import hachure::tree_pictures::{FRAMES, own_of, back_of, frame_near, direction_of, axes_of, cross_cylinder}
#import hachure::trees::{TreeInstance, species_of, SHADOW_PX}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> tree_instances: array<TreeInstance>;
@group(0) @binding(2) var<storage, read> tree_order: array<u32>;
@group(0) @binding(3) var<storage, read> tree_species: array<Species>;
// See impostor.wgsl.
@group(0) @binding(4) var tree_pictures: texture_2d<f32>;
@group(0) @binding(5) var<uniform> forest: Forest;
@group(0) @binding(6) var surface_id: texture_2d<u32>;
@group(0) @binding(7) var distance_m: texture_2d<f32>;
#ifdef WIND
@group(0) @binding(8) var<storage, read> tree_sways: array<Sway>;
#endif

struct Vertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) number: u32,
}

// Corners of the box: three faces.
const CORNERS: u32 = 18u;
// Shadows of small trees fade in from SHADOW_PX to this multiple of it.
const COMES: f32 = 1.5;
// A shadow that is longer than its box fades out over this last part.
const FADES: f32 = 0.25;
// Depth by which the tree must be nearer to the sun than a point to hide it, in radii of its sphere.
const BIAS: f32 = 0.02;

struct Box {
    // Unit vectors: aside, across and toward the sun.
    axes: mat3x3<f32>,
    // Bounds along these axes, from the tree's foot.
    low_m: vec3<f32>,
    high_m: vec3<f32>,
}

// Returns the lean of the top, in metres to the east and to the north.
fn top_leans_m(tree: TreeInstance, number: u32) -> vec2<f32> {
#ifdef WIND
    return lean_at(tree_sways[number].now, tree.height_m);
#else
    return vec2<f32>(0.0);
#endif
}

fn box_of(tree: TreeInstance, leans_m: vec2<f32>) -> Box {
    let sun = forest.to_sun;
    let aside = normalize(select(vec3<f32>(-sun.y, sun.x, 0.0), vec3<f32>(1.0, 0.0, 0.0), length(sun.xy) < 1e-4));
    let across = cross(sun, aside);
    let cylinder = tree_species[species_of(tree)].cylinder;
    let radius_m = cylinder.x * tree.width_m;
    let top_m = cylinder.z * tree.height_m;
    let wide_m = radius_m * vec3<f32>(1.0, length(across.xy), length(sun.xy)) + length(leans_m);
    let low_m = min(vec3<f32>(0.0), top_m * vec3<f32>(0.0, across.z, sun.z)) - wide_m;
    let high_m = max(vec3<f32>(0.0), top_m * vec3<f32>(0.0, across.z, sun.z)) + wide_m;
    let reach_m = forest.shadow_reach * tree.height_m;
    return Box(mat3x3<f32>(aside, across, sun), vec3<f32>(low_m.xy, -reach_m), high_m);
}

@vertex
fn vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> Vertex {
    let number = tree_order[instance];
    let tree = tree_instances[number];
    let foot_m = bend(tree.flat_m);
    let box = box_of(tree, top_leans_m(tree, number));
    let middle_m = 0.5 * (box.low_m + box.high_m);
    let half_m = 0.5 * (box.high_m - box.low_m);
    let eye_m = (view.eye_m - foot_m) * box.axes - middle_m;
    let is_outside = abs(eye_m) > half_m + 2.0 * view.near_m;
    let face = index / 6u;
    let corner = index % 6u;
    let uv = vec2<f32>(select(-1.0, 1.0, corner == 1u || corner == 2u || corner == 4u), select(-1.0, 1.0, corner == 2u || corner >= 4u));
    // For an eye within the box it covers the whole picture; faces that look away from the eye are not drawn.
    if !any(is_outside) {
        return Vertex(select(vec4<f32>(0.0), vec4<f32>(uv, 1.0, 1.0), face == 0u), number);
    }
    if !is_outside[face] {
        return Vertex(vec4<f32>(0.0), number);
    }
    var at = vec3<f32>(0.0);
    at[face] = sign(eye_m[face]);
    at[(face + 1u) % 3u] = uv.x;
    at[(face + 2u) % 3u] = uv.y;
    let at_m = foot_m + box.axes * (middle_m + at * half_m);
    return Vertex(view.clip_from_camera * vec4<f32>(at_m, 1.0), number);
}

// Returns the part of four texels around a position in the picture's space that is nearer to the sun than a depth.
fn hidden(frame: vec2<f32>, p: vec2<f32>, depth: f32) -> f32 {
    let frame_px = f32(textureDimensions(tree_pictures).x) / FRAMES;
    let at = (vec2<f32>(p.x, -p.y) * 0.5 + 0.5) * frame_px - 0.5;
    if any(at < vec2<f32>(0.0)) || any(at > vec2<f32>(frame_px - 1.001)) {
        return 0.0;
    }
    let whole = floor(at);
    let first = vec2<i32>(frame * frame_px + whole);
    var by_corner: vec4<f32>;
    for (var i = 0; i < 4; i++) {
        let texel = textureLoad(tree_pictures, first + vec2<i32>(i & 1, i >> 1u), 0);
        by_corner[i] = f32(texel.w > 0.0 && texel.z > depth + BIAS);
    }
    let f = at - whole;
    return mix(mix(by_corner.x, by_corner.y, f.x), mix(by_corner.z, by_corner.w, f.x), f.y);
}

@fragment
fn fragment(in: Vertex) -> @location(0) vec4<f32> {
    let pixel = vec2<i32>(in.clip.xy);
    let at = place_seen(view, distance_m, pixel);
    let tree = tree_instances[in.number];
    let foot_m = bend(tree.flat_m);
    let from_foot_m = at.xyz - foot_m;
    let leans_m = top_leans_m(tree, in.number);
    let box = box_of(tree, leans_m);
    let along = from_foot_m * box.axes;
    if at.w <= 0.0 || any(along < box.low_m) || any(along > box.high_m) || textureLoad(surface_id, pixel, 0).r == tree.id {
        discard;
    }
    let species = tree_species[species_of(tree)];
    // The space where the tree is upright.
    let leans = vec3<f32>(back_of(tree) * leans_m / tree.width_m, 0.0);
    let leaning = own_of(tree, from_foot_m);
    let to_leaning_sun = own_of(tree, forest.to_sun);
    let own = leaning - leans * leaning.z;
    let to_sun = to_leaning_sun - leans * to_leaning_sun.z;
    let within = cross_cylinder(species.cylinder, own, to_sun);
    if within.y <= within.x {
        discard;
    }
    let frame = frame_near(normalize(to_sun));
    let axes = axes_of(direction_of(frame));
    let origin = (own - species.middle) * axes / species.radius;
    let ray = to_sun * axes / species.radius;
    let per_depth = ray.xy / max(ray.z, 1e-6);
    // The depth of the picture where the ray crosses the plane through the sphere's centre.
    let frame_px = f32(textureDimensions(tree_pictures).x) / FRAMES;
    let crossing = origin.xy - per_depth * origin.z;
    let guess = clamp((vec2<f32>(crossing.x, -crossing.y) * 0.5 + 0.5) * frame_px, vec2<f32>(0.0), vec2<f32>(frame_px - 1.0));
    let depth = textureLoad(tree_pictures, vec2<i32>(frame * frame_px + guess), 0).z;
    let shade = hidden(frame, crossing + per_depth * depth, origin.z);
    let size_px = tree.height_m * view.focal_px / max(length(view.eye_m - foot_m), 1e-3);
    let comes = smoothstep(SHADOW_PX, COMES * SHADOW_PX, size_px);
    let fades = smoothstep(0.0, FADES, 1.0 - along.z / box.low_m.z);
    return vec4<f32>(shade * comes * fades, 0.0, 0.0, 1.0);
}
