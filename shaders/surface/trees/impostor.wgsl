// Draws the trees in view that are impostors: a polygon each, the hull of what its picture shows (src/forest/hull.rs).
//
// The polygon is in the plane of the nearest point of the picture, so no pixel of the tree is nearer to the eye than the
// polygon there: a GPU that knows this (`Draw::writes_farther`) tests the polygon's depth first, and does not run the
// shader where a nearer tree has been drawn. Trees are drawn from front to back (list.wgsl). The content of a pixel
// follows from the ray through its centre, and depends neither on the polygon nor on the order.
//
// The ray of a pixel is marched, in tree space and within the tree's upright cylinder, through the depths of the
// picture taken from nearest to the eye (src/forest/impostor.rs). The depths describe a single surface, so if the ray
// is behind it by more than a step and THICKNESS there is no hit. The step that hits is bisected. The picture is read
// at the level whose texels are as large as pixels, filtered between texels and between levels, and the tree is where
// at least half is covered: read from single texels, its outline would jump whenever it moves by a fraction of a pixel.
// A piece of canopy is drawn in the same way, from pictures of its own; since it is wide, and on land that is less
// flat, it is drawn somewhat nearer to the eye.
//
// In wind (WIND) a tree leans as its mesh does, so in the space where it is upright a ray is a curve. A shear by the
// lean of its top is removed from that space, which leaves rays straight; at each step the rest, at most a quarter of
// the lean of the top, displaces the position that is looked up.
#import hachure::view::{View, ray_at}
#import hachure::earth::bend
#import hachure::forest::Species
#import hachure::tree_form::{form_of, rounded}
#import hachure::tree_pictures::{FRAMES, own_of, back_of, frame_near, direction_of, axes_of, cross_cylinder}
#import hachure::tree_depth::{NEARER, MAX_NEARER}
#import hachure::trees::{TreeInstance, place_on_tree, normal_on_tree, is_shown, species_of, light_of, CANOPY, TREE_LEVELS}
#ifdef WIND
#import hachure::wind::{Sway, lean_at, lean_by_sway}
#endif

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> tree_instances: array<TreeInstance>;
@group(0) @binding(2) var<storage, read> tree_order: array<u32>;
@group(0) @binding(3) var<storage, read> tree_species: array<Species>;
// Octahedral normal, distance toward the eye, and lightness, which is negative where less than half is covered; 0 where
// there is nothing.
// Each species has a layer of these textures.
@group(0) @binding(4) var tree_pictures: texture_2d_array<f32>;
// Distance toward the eye times coverage, and coverage.
@group(0) @binding(6) var tree_outlines: texture_2d_array<f32>;
@group(0) @binding(7) var tree_outline_sampler: sampler;
#ifdef WIND
@group(0) @binding(5) var<storage, read> tree_sways: array<Sway>;
#endif
#ifdef LOCAL_COLOR
// Palette index of each texel of the pictures, and the palette of each species: see hachure::local_color.
@group(0) @binding(8) var tree_paints: texture_2d_array<u32>;
@group(0) @binding(9) var<storage, read> tree_palette: array<u32>;
#endif

// For each species and level of its pictures, the hull of each picture, row by row.
@group(0) @binding(24) var<storage, read> tree_hulls: array<TreeHull>;

// The hull of a picture, in radii of the tree's sphere: right and up from its centre.
struct TreeHull {
    // Outward unit normal of each side, counterclockwise, and how far in this direction the hull reaches.
    sides: array<vec4<f32>, 8>,
    // Depths of what it shows, toward the eye. If `near` is less than `far`, it shows nothing.
    near: f32,
    far: f32,
    padding: vec2<f32>,
}

struct Vertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) number: u32,
    // Eye position, in the space of a tree that is 1 tall and wide.
    @location(1) @interpolate(flat) eye: vec3<f32>,
    // The picture: column, row, mip level.
    @location(2) @interpolate(flat) frame: vec3<f32>,
    // Width of its sphere, in pixels; and the depths of what the picture shows: nearest, farthest.
    @location(3) @interpolate(flat) wide_px: vec3<f32>,
}

// Colours of a palette.
const PALETTE: u32 = 256u;
// Sides of a hull, which is drawn as a strip of triangles.
const SIDES: u32 = 8u;
// Margin around a hull for the rounding of vertices, in pixels.
const MARGIN_PX: f32 = 0.05;
// An eye nearer to a picture's plane than this (in radii), or farther from its direction (as a slope), gets a square
// that holds the whole sphere.
const LEAST_AWAY: f32 = 2.0;
const MAX_SLOPE: f32 = 0.7;
// Relative margin of a polygon's depth, for rounding; and for a piece of canopy, whose depth is not linear on the
// picture because it is drawn nearer.
const DEPTH_MARGIN: f32 = 1e-4;
const CANOPY_DEPTH_MARGIN: f32 = 5e-3;

struct Drawn {
    @location(0) id: u32,
    @location(1) normal: vec4<f32>,
    @location(2) form: vec4<f32>,
#ifdef WIND
    @location(3) step_m: vec4<f32>,
#endif
#ifdef LOCAL_COLOR
#ifdef WIND
    @location(4) color: u32,
#else
    @location(3) color: u32,
#endif
#endif
    @builtin(frag_depth) depth: f32,
}

const STEPS: u32 = 16u;
const CANOPY_STEPS: u32 = 8u;
const HALVINGS: u32 = 4u;
// In radii of the sphere.
const THICKNESS: f32 = 0.04;
const NOWHERE: f32 = 1e6;
// Levels by which the picture is coarser than its texels at pixel size, for a tree whose sphere has the first size or
// less; it is not coarser from the second size on. The smaller a tree, the more its outline would jump.
const COARSER: f32 = 1.2;
const COARSER_PX: vec2<f32> = vec2<f32>(10.0, 44.0);
// Shortest step of a search.
const STEP_PX: f32 = 2.0;
const MIN_STEPS: u32 = 5u;

// Returns the sphere of a tree's pictures.
fn sphere_of(tree: TreeInstance) -> vec4<f32> {
    let species = tree_species[species_of(tree)];
    if (tree.bucket & 0xffffu) % TREE_LEVELS == CANOPY {
        return vec4<f32>(species.canopy_middle, species.canopy_radius);
    }
    return vec4<f32>(species.middle, species.radius);
}

#ifdef WIND
// The lean of a tree, in tree units.
struct Lean {
    // Lean of its top; the straight part of the lean is proportional to height.
    straight: vec2<f32>,
    // Direction of the remaining part; at a height it is multiplied by `curve`.
    curved: vec2<f32>,
    // Metres per square metre of height, to the east and to the north; and the tree's height.
    sway: vec2<f32>,
    height_m: f32,
    by_sway: f32,
}

fn lean_of(tree: TreeInstance, number: u32) -> Lean {
    let sway = tree_sways[number].now;
    let own = back_of(tree) * sway / tree.width_m;
    let by_sway = lean_by_sway(sway, tree.height_m);
    return Lean(own * by_sway, own, sway, tree.height_m, by_sway);
}

// Returns the part of the lean at a height that remains after the straight part is removed, as a factor.
fn curve(lean: Lean, own_z: f32) -> f32 {
    return lean_by_sway(lean.sway, own_z * lean.height_m) - own_z * lean.by_sway;
}

// Returns a bound of the remaining part.
fn max_curve(lean: Lean) -> f32 {
    return 0.25 * length(lean.straight);
}
#endif

fn from_octahedral(p: vec2<f32>) -> vec3<f32> {
    let z = 1.0 - abs(p.x) - abs(p.y);
    let fold = max(-z, 0.0);
    return normalize(vec3<f32>(p - select(-vec2<f32>(fold), vec2<f32>(fold), p >= vec2<f32>(0.0)), z));
}

fn is_canopy(tree: TreeInstance) -> bool {
    return (tree.bucket & 0xffffu) % TREE_LEVELS == CANOPY;
}

fn cylinder_of(tree: TreeInstance) -> vec4<f32> {
    let species = tree_species[species_of(tree)];
    return select(species.cylinder, species.canopy_cylinder, is_canopy(tree));
}

fn steps_of(tree: TreeInstance, wide_px: f32) -> u32 {
    return clamp(u32(wide_px / STEP_PX), MIN_STEPS, select(STEPS, CANOPY_STEPS, is_canopy(tree)));
}

fn nearer_m(tree: TreeInstance, along_m: f32) -> f32 {
    return min(NEARER * max(tree.width_m - tree.height_m, 0.0), MAX_NEARER * along_m);
}

// Returns a corner of a hull: where two sides meet. The sides are moved outward by `margin`, and as far as a segment with
// the centre 0 and the end `aside` reaches beyond them.
fn corner_of(hull: u32, number: u32, margin: f32, aside: vec2<f32>) -> vec2<f32> {
    let a = tree_hulls[hull].sides[number];
    let b = tree_hulls[hull].sides[(number + 1u) % SIDES];
    let reach = vec2<f32>(a.z, b.z) + margin + abs(vec2<f32>(dot(a.xy, aside), dot(b.xy, aside)));
    return vec2<f32>(reach.x * b.y - reach.y * a.y, reach.y * a.x - reach.x * b.x) / (a.x * b.y - a.y * b.x);
}

@vertex
fn vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) instance: u32) -> Vertex {
    let number = tree_order[instance];
    let tree = tree_instances[number];
    var sphere = sphere_of(tree);
    let foot_m = bend(tree.flat_m);
    var eye = own_of(tree, view.eye_m - foot_m);
    var curved = 0.0;
#ifdef WIND
    let lean = lean_of(tree, number);
    eye -= vec3<f32>(lean.straight * eye.z, 0.0);
    curved = max_curve(lean);
#endif
    let toward = normalize(eye - sphere.xyz);
    let frame = frame_near(toward);
    // The geometric mean of width and height, since a piece of canopy is wider than tall.
    let wide_m = 2.0 * (sphere.w + curved) * sqrt(tree.width_m * tree.height_m);
    let away_m = max(length(foot_m + place_on_tree(tree, sphere.xyz) - view.eye_m), view.near_m);
    let wide_px = wide_m * view.focal_px / away_m;
    let level = level_of(wide_px);
    let levels = textureNumLevels(tree_outlines);
    let hull = ((species_of(tree) * levels + u32(level)) * u32(FRAMES) + u32(frame.y)) * u32(FRAMES) + u32(frame.x);
    // From the strip to the polygon: 0, 1, 7, 2, 6, 3, 5, 4.
    let corner = select((index + 1u) / 2u, (SIDES - index / 2u) % SIDES, index % 2u == 0u);

    let near = tree_hulls[hull].near + curved / sphere.w;
    let far = tree_hulls[hull].far - curved / sphere.w;
    let axes = axes_of(direction_of(frame));
    let eye_on_picture = (eye - sphere.xyz) * axes / sphere.w;
    let away = eye_on_picture.z - near;
    let slope = eye_on_picture.xy / max(away, 1e-6);
    // A ray meets the picture's surface at most `deep` behind the plane of the polygon: that of the picture, and the
    // thickness with which it counts. A point at depth t behind the plane, seen from the eye, is at (p + slope t) f on
    // it, with f = 1 / (1 + t / away). The polygon is the hull of p for the middle of the values of f and t f, and has
    // half of their ranges as margins.
    let around = cylinder_of(tree);
    let level_ray = max(length(toward.xy) - 0.1, 0.05);
    let reach = 2.0 * (around.x + curved);
    let across = min(length(vec2<f32>(reach, around.z - around.y)), reach / level_ray) / sphere.w;
    let deep = near - far + THICKNESS + across / f32(steps_of(tree, wide_px));
    let f = 1.0 / (1.0 + deep / max(away, 1e-6));
    let margin_px = MARGIN_PX * away_m / (view.focal_px * sphere.w * min(tree.width_m, tree.height_m));
    let margin = 0.5 * (1.0 - f) + curved / sphere.w + margin_px;
    let aside = 0.5 * deep * f * slope;
    let is_square = away < LEAST_AWAY || length(slope) > MAX_SLOPE;
    var own = sphere.xyz;
    if is_square {
        // A square that faces the eye at the distance of the centre, wide enough for the sphere in perspective.
        let radius = sphere.w + curved;
        let far_away = max(length(eye - sphere.xyz), 1.01 * radius);
        let wide = radius * far_away * inverseSqrt(far_away * far_away - radius * radius);
        let right = normalize(select(vec3<f32>(-toward.y, toward.x, 0.0), vec3<f32>(1.0, 0.0, 0.0), length(toward.xy) < 1e-4));
        let up = cross(toward, right);
        let square = vec2<f32>(select(-1.0, 1.0, corner / 2u == 1u || corner / 2u == 2u), select(-1.0, 1.0, corner >= 4u));
        own += wide * (square.x * right + square.y * up);
    } else {
        let middle_f = 0.5 * (1.0 + f);
        let p = middle_f * corner_of(hull, corner, margin / middle_f, aside / middle_f) + aside;
        own += sphere.w * (axes * vec3<f32>(p, near));
    }
#ifdef WIND
    let at_m = foot_m + place_on_tree(tree, own + vec3<f32>(lean.straight * own.z, 0.0));
#else
    let at_m = foot_m + place_on_tree(tree, own);
#endif
    var clip = view.clip_from_camera * vec4<f32>(at_m, 1.0);
    let nearest_m = clip.w - nearer_m(tree, clip.w);
    let depth_margin = select(DEPTH_MARGIN, CANOPY_DEPTH_MARGIN, is_canopy(tree));
    clip.z = select(min(clip.z * clip.w / nearest_m * (1.0 + depth_margin), clip.w), clip.w, is_square || nearest_m <= 0.0);
    if tree_hulls[hull].near < tree_hulls[hull].far {
        clip = vec4<f32>(0.0);
    }
    let depths = vec2<f32>(near, far);
    return Vertex(clip, number, eye, vec3<f32>(frame, level), vec3<f32>(wide_px, depths));
}

@fragment
fn fragment(in: Vertex) -> Drawn {
    let tree = tree_instances[in.number];
    if !is_shown(tree, in.clip.xy) {
        discard;
    }
    let sphere = sphere_of(tree);
    let toward = direction_of(in.frame.xy);
    let axes = axes_of(toward);
    var own_ray = own_of(tree, ray_at(view, in.clip.xy));
#ifdef WIND
    let lean = lean_of(tree, in.number);
    own_ray -= vec3<f32>(lean.straight * own_ray.z, 0.0);
#endif
    own_ray = normalize(own_ray);
    // In the picture's space: right, up, toward the eye; the sphere's radius is 1.
    let origin = (in.eye - sphere.xyz) * axes / sphere.w;
    let ray = own_ray * axes;
    let frame_px = f32(textureDimensions(tree_pictures).x) / FRAMES;
    let steps = steps_of(tree, in.wide_px.x);
    let cylinder = cylinder_of(tree);
    var around = cylinder;
#ifdef WIND
    around.x += max_curve(lean);
    let aside = vec3<f32>(lean.curved, 0.0) * axes / sphere.w;
#endif
    let within = cross_cylinder(around, in.eye, own_ray);
    if within.y <= within.x {
        discard;
    }
    // From here on, lengths along the ray are in radii of the sphere.
    let span = within / sphere.w;
    let step = (span.y - span.x) / f32(steps);
    let thickness = THICKNESS + step * abs(ray.z);
    let picture = Picture(in.frame.xy * frame_px, frame_px, in.frame.z, i32(species_of(tree)));
    // Steps in front of the nearest point of the picture, or behind the farthest, do not hit.
    var first = 0u;
    var last = steps;
    if ray.z < -0.1 {
        let begins = ((in.wide_px.y - origin.z) / ray.z - span.x) / step;
        let ends = ((in.wide_px.z - thickness - origin.z) / ray.z - span.x) / step;
        first = u32(clamp(floor(begins) - 1.0, 0.0, f32(steps)));
        last = u32(clamp(ceil(ends) + 1.0, 0.0, f32(steps)));
    }
    var before = span.x + step * f32(first);
    var hit = 0.0;
    var is_hit = false;
    for (var i = first; i < last; i++) {
        let along = span.x + step * f32(i + 1u);
        var p = origin + ray * along;
#ifdef WIND
        p -= aside * curve(lean, in.eye.z + own_ray.z * along * sphere.w);
#endif
        let behind = look(picture, p.xy) - p.z;
        if behind >= 0.0 && behind < thickness {
            is_hit = true;
            hit = along;
            break;
        }
        before = along;
    }
    if is_hit {
        for (var i = 0u; i < HALVINGS; i++) {
            let along = 0.5 * (before + hit);
            var p = origin + ray * along;
#ifdef WIND
            p -= aside * curve(lean, in.eye.z + own_ray.z * along * sphere.w);
#endif
            let behind = look(picture, p.xy) - p.z;
            if behind >= 0.0 && behind < thickness {
                hit = along;
            } else {
                before = along;
            }
        }
    }
    if !is_hit {
        discard;
    }
    var on_picture = origin + ray * hit;
    var own = axes * on_picture * sphere.w + sphere.xyz;
#ifdef WIND
    on_picture -= aside * curve(lean, in.eye.z + own_ray.z * hit * sphere.w);
    own += vec3<f32>(lean.straight * own.z, 0.0);
#endif
    let clip = view.clip_from_camera * vec4<f32>(bend(tree.flat_m) + place_on_tree(tree, own), 1.0);
    let shown = look_closely(picture, on_picture.xy);
#ifdef LOCAL_COLOR
    let color = tree_palette[u32(picture.layer) * PALETTE + paint_at(picture, on_picture.xy)];
#endif
    let normal = normal_on_tree(tree, normalize(shown.xyz));
    let form = form_of(view, tree, cylinder, own);
    let seen = vec4<f32>(rounded(normal, form), shown.w * light_of(tree));
    let depth = clip.z / (clip.w - nearer_m(tree, clip.w));
#ifdef WIND
    let sway = tree_sways[in.number];
    let up_m = own.z * tree.height_m;
    let step_m = lean_at(sway.before, up_m) - lean_at(sway.now, up_m);
#ifdef LOCAL_COLOR
    return Drawn(tree.id, seen, form, vec4<f32>(step_m, 0.0, 0.0), color, depth);
#else
    return Drawn(tree.id, seen, form, vec4<f32>(step_m, 0.0, 0.0), depth);
#endif
#else
#ifdef LOCAL_COLOR
    return Drawn(tree.id, seen, form, color, depth);
#else
    return Drawn(tree.id, seen, form, depth);
#endif
#endif
}

// A picture at the level whose texels have about the size of pixels.
struct Picture {
    // Its corner, and its side, in texels of the finest level.
    corner_px: vec2<f32>,
    side_px: f32,
    level: f32,
    layer: i32,
}

// Returns the level at which pictures of a tree are read.
fn level_of(wide_px: f32) -> f32 {
    let side_px = f32(textureDimensions(tree_outlines).x) / FRAMES;
    let last = f32(textureNumLevels(tree_outlines) - 1u);
    let coarser = COARSER * (1.0 - smoothstep(COARSER_PX.x, COARSER_PX.y, wide_px));
    return clamp(round(log2(side_px / wide_px) + coarser), 0.0, last);
}

// Returns how far toward the eye a picture's surface is at a position in its space; -NOWHERE if there is none.
fn look(picture: Picture, p: vec2<f32>) -> f32 {
    if any(abs(p) >= vec2<f32>(1.0)) {
        return -NOWHERE;
    }
    // Clamped to its outermost texels: beyond them is another picture.
    let most = 1.0 - exp2(picture.level) / picture.side_px;
    let within = clamp(vec2<f32>(p.x, -p.y), vec2<f32>(-most), vec2<f32>(most)) * 0.5 + 0.5;
    let uv = (picture.corner_px + within * picture.side_px) / vec2<f32>(textureDimensions(tree_outlines));
    let outline = textureSampleLevel(tree_outlines, tree_outline_sampler, uv, picture.layer, picture.level).xy;
    return select(-NOWHERE, outline.x / max(outline.y, 1e-3), outline.y >= 0.5);
}

#ifdef LOCAL_COLOR
// Returns the palette index at a position.
fn paint_at(picture: Picture, p: vec2<f32>) -> u32 {
    let level = u32(picture.level);
    let scale = 1.0 / f32(1u << level);
    let side_px = picture.side_px * scale;
    let at = clamp((vec2<f32>(p.x, -p.y) * 0.5 + 0.5) * side_px, vec2<f32>(0.0), vec2<f32>(side_px - 0.01));
    return textureLoad(tree_paints, vec2<i32>(floor(picture.corner_px * scale + 0.5) + floor(at)), picture.layer, level).r;
}
#endif

// Returns normal (not normalised) and lightness at a position, from the four texels around.
fn look_closely(picture: Picture, p: vec2<f32>) -> vec4<f32> {
    let level = u32(picture.level);
    let side_px = picture.side_px / f32(1u << level);
    let corner_px = picture.corner_px / f32(1u << level);
    let at = clamp((vec2<f32>(p.x, -p.y) * 0.5 + 0.5) * side_px - 0.5, vec2<f32>(0.0), vec2<f32>(side_px - 1.001));
    let f = fract(at);
    var sum = vec4<f32>(0.0);
    var weights = 0.0;
    for (var i = 0; i < 4; i++) {
        let texel_step = vec2<i32>(i & 1, i >> 1u);
        let texel = textureLoad(tree_pictures, vec2<i32>(floor(corner_px + 0.5) + floor(at)) + texel_step, picture.layer, level);
        let near = select(1.0 - f, f, texel_step == vec2<i32>(1));
        // Texels with little coverage have little weight.
        let covered = select(select(0.1, 1.0, texel.w > 0.0), 0.0, texel.w == 0.0);
        let weight = covered * (near.x * near.y + 1e-3);
        sum += weight * vec4<f32>(from_octahedral(texel.xy), abs(texel.w));
        weights += weight;
    }
    if weights == 0.0 {
        return vec4<f32>(0.0, 0.0, 1.0, 0.6);
    }
    return vec4<f32>(sum.xyz + vec3<f32>(0.0, 0.0, 1e-6), sum.w / weights);
}
