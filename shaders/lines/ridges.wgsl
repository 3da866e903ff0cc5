// Adds ridges and valleys to the edge list: crests of curvature.
//
// On a ridge the surface is convex, and its largest principal curvature has a maximum along its own principal
// direction: the derivative of the curvature along that direction passes through zero from positive to negative. A
// valley is a ridge of the surface seen from below. A principal direction is an axis, which may point either way, so
// the directions at a cell's corners are flipped to agree with the first corner's, which fixes the sign of the
// derivative.
//
// Without APPARENT, the curvature is that of the surface (Ohtake, Belyaev, Seidel 2004, "Ridge-Valley Lines on Meshes
// via Implicit Surface Fitting"), and its derivative comes from `surface/curvature`.
//
// With APPARENT, it is the view-dependent curvature of apparent.wgsl (Judd, Durand and Adelson 2007, "Apparent Ridges
// for Line Drawing"), and its derivative is taken from the neighbouring blocks; the paper takes it from the triangles
// around a vertex. Apparent ridges slide toward contours as the eye moves, like the lines that a person sees; the
// others are fixed to the surface.
//
// Curves are found by marching squares over the blocks of `surface/curvature` (cells.wgsl). A curve ends where the
// surface bends less than `min_bend` over a feature, where it bends about as much in the other principal direction (a
// dome has no ridge), and where the surface is so foreshortened that its contour is drawn instead, which shows the same
// shape.
//
// Edges are written in the order of cells, in two stages (edge_list.wgsl).
#import hachure::mark_normal::block_count
#import hachure::view::View
#import hachure::cells::{Corner, Curves, corner_at, curves_of}
#import hachure::cell_edges::{Cell, put_curves}
#import hachure::edges::{KIND_RIDGE, KIND_VALLEY}
#ifdef APPARENT
#import hachure::cells::on_one_surface
#else
#import hachure::curvature::{frame_of, form3, principal_of}
#endif

struct RidgeRules {
    // Least change of the normal over a feature, in radians.
    min_bend: f32,
    // 1: ridges. -1: valleys, as ridges of the inverted surface.
    orientation: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> ridge_rules: RidgeRules;
@group(0) @binding(2) var distance_m: texture_2d<f32>;
@group(0) @binding(3) var normal: texture_2d<u32>;
@group(0) @binding(4) var shape_normal: texture_2d<f32>;
@group(0) @binding(5) var shape_bend: texture_2d<f32>;
#ifdef APPARENT
@group(0) @binding(6) var apparent: texture_2d<f32>;
#else
@group(0) @binding(6) var shape_change: texture_2d<f32>;
#endif

// Largest ratio of the curvature in the other principal direction to that across the ridge.
const MAX_ACROSS: f32 = 0.7;
// Cosine between normal and view direction below which the surface's contours are drawn instead.
const MIN_FACING: f32 = 0.2;
// Smallest cosine between the directions at a cell's corners. If they agree less, the surface bends about equally in
// all directions, or several lines meet in the cell.
const ALIKE: f32 = 0.7;

// A corner of a cell. Its value is the derivative of the curvature along `along`; if `along` is flipped, the value
// changes its sign.
struct Crest {
    corner: Corner,
    // Unit vector: in the world, or with APPARENT in xy on the picture.
    along: vec3<f32>,
}

// Returns the cosine between the normal and the direction to the eye.
fn facing_of(corner: Corner) -> f32 {
    return dot(corner.normal, normalize(view.eye_m - corner.at_m));
}

#ifdef APPARENT
// Returns a block's corner without value and room (see cells.wgsl).
fn plain_corner(block: vec2<i32>) -> Corner {
    return corner_at(view, block, textureLoad(shape_normal, block, 0), 0.0, 0.0);
}

// Returns the magnitude of the view-dependent curvature: it is continuous, while the sign jumps where the surface
// becomes concave.
fn magnitude_at(block: vec2<i32>) -> f32 {
    return abs(textureLoad(apparent, block, 0).x);
}

// Returns the crest at a block, with the derivative of the magnitude by central differences.
fn crest_of(block: vec2<i32>) -> Crest {
    let own = textureLoad(apparent, block, 0);
    var change = vec2<f32>(0.0);
    var is_whole = true;
    let middle = plain_corner(block);
    for (var i = 0; i < 4; i++) {
        let step = select(vec2<i32>(0, 1), vec2<i32>(1, 0), i < 2) * select(-1, 1, (i & 1) == 1);
        is_whole = is_whole && on_one_surface(view, middle, plain_corner(block + step));
        change += vec2<f32>(step) * magnitude_at(block + step);
    }
    let least = ridge_rules.min_bend;
    // The w of `shape_bend` is the feature size.
    let bends = (ridge_rules.orientation * own.x * textureLoad(shape_bend, block, 0).w - least) / max(least, 0.01);
    var corner = middle;
    corner.value = dot(change, own.yz);
    corner.room = min(bends, min(MAX_ACROSS - own.w, facing_of(middle) - MIN_FACING));
    corner.is_there = corner.is_there && is_whole;
    return Crest(corner, vec3<f32>(own.yz, 0.0));
}

// Returns the direction of a crest on the picture.
fn on_picture(crest: Crest) -> vec2<f32> {
    return crest.along.xy;
}
#else
// Returns the crest at a block, with the derivative from `shape_change`.
fn crest_of(block: vec2<i32>) -> Crest {
    let seen = textureLoad(shape_normal, block, 0);
    let shape = textureLoad(shape_bend, block, 0);
    let bend = ridge_rules.orientation * shape.xyz;
    let found = principal_of(bend);
    let frame = frame_of(seen.xyz);
    let third = textureLoad(shape_change, block, 0);
    let change = ridge_rules.orientation * form3(third, found.along, found.along, found.along);
    let least = ridge_rules.min_bend;
    var corner = corner_at(view, block, seen, change, 0.0);
    // Near the land's border (surface/curvature.wgsl).
    corner.is_there = corner.is_there && any(third != vec4<f32>(0.0));
    corner.room = min(min((found.most * shape.w - least) / max(least, 0.01), (MAX_ACROSS * found.most - abs(found.least)) * shape.w / max(least, 0.01)),
        facing_of(corner) - MIN_FACING);
    return Crest(corner, frame * found.along);
}

// Returns the direction of a crest on the picture, of any length.
fn on_picture(crest: Crest) -> vec2<f32> {
    let start = view.clip_from_camera * vec4<f32>(crest.corner.at_m, 1.0);
    let on = view.clip_from_camera * vec4<f32>(crest.along, 0.0);
    return (on.xy * start.w - start.xy * on.w) * vec2<f32>(1.0, -1.0) * vec2<f32>(view.size_px);
}
#endif

// Returns the corner with its direction flipped to agree with another one.
fn agreeing(own: Crest, along: vec3<f32>) -> Corner {
    var corner = own.corner;
    let alike = dot(own.along, along);
    corner.value = select(-corner.value, corner.value, alike >= 0.0);
    corner.is_there = corner.is_there && abs(alike) > ALIKE;
    return corner;
}

// Returns the ridges or valleys in the cell whose first corner is a block.
fn curves_in_cell(block: vec2<i32>) -> Curves {
#ifdef APPARENT
    // A crest depends on the blocks around it.
    let reach = 1;
#else
    let reach = 0;
#endif
    if any(block < vec2<i32>(reach)) || any(block + 1 + reach >= vec2<i32>(block_count(view))) {
        return Curves();
    }
    let first = crest_of(block);
    let nw = agreeing(first, first.along);
    let ne = agreeing(crest_of(block + vec2<i32>(1, 0)), first.along);
    let se = agreeing(crest_of(block + vec2<i32>(1, 1)), first.along);
    let sw = agreeing(crest_of(block + vec2<i32>(0, 1)), first.along);
    // On a ridge the derivative decreases along the ridge's direction on the picture.
    let slope = 0.5 * vec2<f32>(ne.value - nw.value + se.value - sw.value, sw.value - nw.value + se.value - ne.value);
    if dot(slope, on_picture(first)) >= 0.0 {
        return Curves();
    }
    return curves_of(view, nw, ne, se, sw);
}

@compute @workgroup_size(8, 8)
fn main(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let cell = Cell(vec2<i32>(id.xy), thread, group.x + group.y * groups.x, groups.x * groups.y);
    let kind = select(KIND_VALLEY, KIND_RIDGE, ridge_rules.orientation > 0.0);
    put_curves(view, distance_m, normal, cell, curves_in_cell(cell.block), kind, 2u);
}
