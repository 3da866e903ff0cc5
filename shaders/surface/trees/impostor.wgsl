// Draws the trees in view that are impostors: two triangles each, which face the eye and hold the tree's sphere.
//
// The ray of a pixel is followed, in the space of the tree and as far as it runs within the tree's upright cylinder,
// through the depths of the picture that was taken from nearest to the eye (src/forest/impostor.rs). Depths are told by a
// single surface, so what the ray passes behind by more than a step and THICKNESS is not hit. The step that hits is
// halved. A piece of canopy is drawn in the same way, from pictures of its own; since it is wide, and lies on land that is
// not as flat, it stands as if it were somewhat nearer to the eye.
#import hachure::view::View
#import hachure::earth::bend
#import hachure::forest::Species
#import hachure::tree_form::{form_of, rounded}
#import hachure::tree_pictures::{FRAMES, own_of, frame_near, direction_of, axes_of, cross_cylinder}
#import hachure::trees::{TreeInstance, place_on_tree, normal_on_tree, is_shown, species_of, light_of, CANOPY, TREE_LEVELS}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> tree_instances: array<TreeInstance>;
@group(0) @binding(2) var<storage, read> tree_order: array<u32>;
@group(0) @binding(3) var<storage, read> tree_species: array<Species>;
// The normal on the octahedral map, how far toward the eye, lightness; 0 is where nothing is seen.
@group(0) @binding(4) var tree_pictures: texture_2d<f32>;

struct Vertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) number: u32,
    // Of the tree that is 1 tall and wide.
    @location(1) @interpolate(flat) eye: vec3<f32>,
    @location(2) at: vec3<f32>,
    // The picture.
    @location(3) @interpolate(flat) frame: vec2<f32>,
}

struct Drawn {
    @location(0) id: u32,
    @location(1) normal: vec4<f32>,
    @location(2) form: vec4<f32>,
    @builtin(frag_depth) depth: f32,
}

const STEPS: u32 = 16u;
const CANOPY_STEPS: u32 = 8u;
const HALVINGS: u32 = 4u;
// By the sphere's radius.
const THICKNESS: f32 = 0.04;

// How much nearer a piece of canopy stands: by what it is wider than tall, and of its distance at most.
const NEARER: f32 = 0.5;
const NEARER_AT_MOST: f32 = 0.05;

// The sphere of a tree's pictures.
fn sphere_of(tree: TreeInstance) -> vec4<f32> {
    let species = tree_species[species_of(tree)];
    if (tree.bucket & 0xffffu) % TREE_LEVELS == CANOPY {
        return vec4<f32>(species.canopy_middle, species.canopy_radius);
    }
    return vec4<f32>(species.middle, species.radius);
}

fn from_octahedral(p: vec2<f32>) -> vec3<f32> {
    let z = 1.0 - abs(p.x) - abs(p.y);
    let fold = max(-z, 0.0);
    return normalize(vec3<f32>(p - select(-vec2<f32>(fold), vec2<f32>(fold), p >= vec2<f32>(0.0)), z));
}

@vertex
fn vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> Vertex {
    let number = tree_order[instance];
    let tree = tree_instances[number];
    let sphere = sphere_of(tree);
    let foot_m = bend(tree.flat_m);
    let eye = own_of(tree, view.eye_m - foot_m);
    let toward = normalize(eye - sphere.xyz);
    // A square that faces the eye and is as far away as the middle, wide enough for the sphere as the eye sees it.
    let far = max(length(eye - sphere.xyz), 1.01 * sphere.w);
    let wide = sphere.w * far * inverseSqrt(far * far - sphere.w * sphere.w);
    let right = normalize(select(vec3<f32>(-toward.y, toward.x, 0.0), vec3<f32>(1.0, 0.0, 0.0), length(toward.xy) < 1e-4));
    let up = cross(toward, right);
    let corner = vec2<f32>(select(-1.0, 1.0, index == 1u || index == 2u || index == 4u), select(-1.0, 1.0, index == 2u || index >= 4u));
    let own = sphere.xyz + wide * (corner.x * right + corner.y * up);
    let at_m = foot_m + place_on_tree(tree, own);
    return Vertex(view.clip_from_camera * vec4<f32>(at_m, 1.0), number, eye, own, frame_near(toward));
}

@fragment
fn fragment(in: Vertex) -> Drawn {
    let tree = tree_instances[in.number];
    let sphere = sphere_of(tree);
    let toward = direction_of(in.frame);
    let axes = axes_of(toward);
    // In the picture's space: right, up, toward the eye; the sphere's radius is 1.
    let origin = (in.eye - sphere.xyz) * axes / sphere.w;
    let ray = normalize((in.at - in.eye) * axes);
    let frame_px = f32(textureDimensions(tree_pictures).x) / FRAMES;
    let first = (in.frame + 0.5) * frame_px;
    let is_canopy = (tree.bucket & 0xffffu) % TREE_LEVELS == CANOPY;
    let steps = select(STEPS, CANOPY_STEPS, is_canopy);
    let species = tree_species[species_of(tree)];
    let cylinder = select(species.cylinder, species.canopy_cylinder, is_canopy);
    let within = cross_cylinder(cylinder, in.eye, normalize(in.at - in.eye));
    if within.y <= within.x || !is_shown(tree, in.clip.xy) {
        discard;
    }
    // Lengths of the ray count in the sphere's radius from here on.
    let span = within / sphere.w;
    let step = (span.y - span.x) / f32(steps);
    let thickness = THICKNESS + step * abs(ray.z);
    var before = span.x;
    var texel = vec4<f32>(0.0);
    var hit = 0.0;
    var is_hit = false;
    for (var i = 0u; i < steps; i++) {
        let along = span.x + step * f32(i + 1u);
        let p = origin + ray * along;
        let seen = look(first, frame_px, p.xy);
        let behind = seen.z - p.z;
        if seen.w > 0.0 && behind >= 0.0 && behind < thickness {
            is_hit = true;
            hit = along;
            texel = seen;
            break;
        }
        before = along;
    }
    if is_hit {
        for (var i = 0u; i < HALVINGS; i++) {
            let along = 0.5 * (before + hit);
            let p = origin + ray * along;
            let seen = look(first, frame_px, p.xy);
            let behind = seen.z - p.z;
            if seen.w > 0.0 && behind >= 0.0 && behind < thickness {
                hit = along;
                texel = seen;
            } else {
                before = along;
            }
        }
    }
    if !is_hit {
        discard;
    }
    let own = axes * (origin + ray * hit) * sphere.w + sphere.xyz;
    let clip = view.clip_from_camera * vec4<f32>(bend(tree.flat_m) + place_on_tree(tree, own), 1.0);
    let nearer_m = min(NEARER * max(tree.width_m - tree.height_m, 0.0), NEARER_AT_MOST * clip.w);
    let normal = normal_on_tree(tree, from_octahedral(texel.xy));
    let form = form_of(view, tree, cylinder, own);
    return Drawn(tree.id, vec4<f32>(rounded(normal, form), texel.w * light_of(tree)), form, clip.z / (clip.w - nearer_m));
}

// The texel of a picture at a place of its space.
fn look(middle_px: vec2<f32>, frame_px: f32, p: vec2<f32>) -> vec4<f32> {
    let half_px = 0.5 * frame_px;
    let within = clamp(vec2<f32>(p.x, -p.y) * half_px, vec2<f32>(-half_px), vec2<f32>(half_px - 0.01));
    return textureLoad(tree_pictures, vec2<i32>(floor(middle_px + within)), 0);
}
