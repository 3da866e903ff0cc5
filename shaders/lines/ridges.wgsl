// Adds ridges and valleys to the edge list: crests of curvature (Ohtake, Belyaev, Seidel 2004, "Ridge-Valley Lines on
// Meshes via Implicit Surface Fitting").
//
// On a ridge the largest curvature has a maximum along its own direction, and is convex; a valley is a ridge of the
// surface seen from below. So the derivative of the curvature along that direction is zero, and falling. A direction
// has no sense, so the directions at a cell's corners are flipped to agree with the first one, and the derivative takes
// its sign from them.
//
// Curves are found by marching squares over the blocks of `surface/curvature` (cells.wgsl). A curve ends where the
// surface bends less than `least_bend` over a feature, where it bends about as much across (a dome has no ridge), and
// where it is so foreshortened that a contour is near, which shows the same shape.
//
// Edges are in the order of cells (ordered.wgsl): `stage` 0 counts them, 1 writes them, 2 updates their number.
#import hachure::view::View
#import hachure::cells::{Corner, Curves, corner_at, curves_of}
#import hachure::cell_edges::{Cell, put_curves}
#import hachure::curvature::{frame_of, form3, principal_of}
#import hachure::edges::{KIND_RIDGE, KIND_VALLEY}
#import hachure::edge_list::has_told

struct RidgeRules {
    // Least change of the normal over a feature, in radians.
    least_bend: f32,
    // 1: ridges. -1: valleys.
    side: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> ridge_rules: RidgeRules;
@group(0) @binding(2) var position: texture_2d<f32>;
@group(0) @binding(3) var normal: texture_2d<f32>;
@group(0) @binding(4) var shape_normal: texture_2d<f32>;
@group(0) @binding(5) var shape_bend: texture_2d<f32>;
@group(0) @binding(6) var shape_change: texture_2d<f32>;

// Largest curvature across a ridge, as a part of the curvature along its direction.
const MOST_ACROSS: f32 = 0.7;
// Cosine between normal and view direction below which the surface's contours are drawn instead.
const LEAST_FACING: f32 = 0.2;

// A corner of a cell, whose value has the sign of an arbitrary sense of its direction, and that direction in the world.
struct Crest {
    corner: Corner,
    along: vec3<f32>,
}

fn crest_of(block: vec2<i32>) -> Crest {
    let seen = textureLoad(shape_normal, block, 0);
    let shape = textureLoad(shape_bend, block, 0);
    let bend = ridge_rules.side * shape.xyz;
    let found = principal_of(bend);
    let frame = frame_of(seen.xyz);
    let change = ridge_rules.side * form3(textureLoad(shape_change, block, 0), found.along, found.along, found.along);
    let facing = dot(seen.xyz, normalize(view.eye_m - corner_at(view, block, seen, 0.0, 0.0).at_m));
    let least = ridge_rules.least_bend;
    let room = min(min((found.most * shape.w - least) / max(least, 0.01), (MOST_ACROSS * found.most - abs(found.least)) * shape.w / max(least, 0.01)),
        facing - LEAST_FACING);
    return Crest(corner_at(view, block, seen, change, room), frame * found.along);
}

// Smallest cosine between the directions at a cell's corners. With less agreement the surface bends alike in all
// directions, and there is no ridge.
const ALIKE: f32 = 0.7;

// Returns the corner with its direction flipped to agree with another one.
fn agreeing(own: Crest, along: vec3<f32>) -> Corner {
    var corner = own.corner;
    let alike = dot(own.along, along);
    corner.value = select(-corner.value, corner.value, alike >= 0.0);
    corner.is_there = corner.is_there && abs(alike) > ALIKE;
    return corner;
}

fn look(block: vec2<i32>) -> Curves {
    if any(block + 1 >= vec2<i32>(textureDimensions(shape_normal))) {
        return Curves();
    }
    let first = crest_of(block);
    let nw = first.corner;
    let ne = agreeing(crest_of(block + vec2<i32>(1, 0)), first.along);
    let se = agreeing(crest_of(block + vec2<i32>(1, 1)), first.along);
    let sw = agreeing(crest_of(block + vec2<i32>(0, 1)), first.along);
    // On a ridge the derivative falls along its direction on the picture.
    let slope = 0.5 * vec2<f32>(ne.value - nw.value + se.value - sw.value, sw.value - nw.value + se.value - ne.value);
    let start = view.clip_from_camera * vec4<f32>(nw.at_m, 1.0);
    let on = view.clip_from_camera * vec4<f32>(first.along, 0.0);
    let way = (on.xy * start.w - start.xy * on.w) * vec2<f32>(1.0, -1.0) * vec2<f32>(view.size_px);
    if dot(slope, way) >= 0.0 {
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
    if has_told(thread) {
        return;
    }
    let cell = Cell(vec2<i32>(id.xy), thread, group.x + group.y * groups.x);
    let kind = select(KIND_VALLEY, KIND_RIDGE, ridge_rules.side > 0.0);
    put_curves(view, position, normal, cell, look(cell.block), kind, 2u);
}
