// Adds apparent ridges and valleys to the edge list: crests of view-dependent curvature (apparent.wgsl; Judd, Durand
// and Adelson 2007, "Apparent Ridges for Line Drawing").
//
// On such a line the curvature has a maximum along its own direction on the picture. Its derivative is taken from the
// neighbouring blocks; the paper takes it from the triangles around a vertex. A direction has no sense, so the
// directions at a cell's corners are flipped to agree with the first one. Apparent ridges slide toward contours as the
// eye moves, like the lines that a person sees; ridges (ridges.wgsl) are fixed to the surface.
//
// Curves are found by marching squares over the blocks of `lines/apparent` (cells.wgsl). A curve ends where the surface
// bends less than `least_bend` over a feature, where it bends about as much across, and where it is so foreshortened
// that its contour is drawn instead.
//
// Edges are in the order of cells (ordered.wgsl): `stage` 0 counts them, 1 writes them, 2 updates their number.
#import hachure::view::View
#import hachure::cells::{Corner, Curves, corner_at, curves_of, is_beside}
#import hachure::cell_edges::{Cell, put_curves}
#import hachure::edges::{KIND_RIDGE, KIND_VALLEY}
#import hachure::edge_list::has_told

struct ApparentRules {
    // Least change of the normal over a feature, in radians.
    least_bend: f32,
    // 1: ridges. -1: valleys.
    side: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> apparent_rules: ApparentRules;
@group(0) @binding(2) var position: texture_2d<f32>;
@group(0) @binding(3) var normal: texture_2d<f32>;
@group(0) @binding(4) var shape_normal: texture_2d<f32>;
@group(0) @binding(5) var shape_bend: texture_2d<f32>;
@group(0) @binding(6) var apparent: texture_2d<f32>;

// Cosine between normal and view direction below which the surface's contours are drawn instead.
const LEAST_FACING: f32 = 0.2;
// Largest curvature across a line, as a part of the curvature along it.
const MOST_ACROSS: f32 = 0.7;
// Smallest cosine between the directions at a cell's corners; with less agreement there is not a single line.
const ALIKE: f32 = 0.7;

// Returns the magnitude of the change of the normal. Where the surface becomes concave only its sign jumps; the
// magnitude is continuous.
fn turn_at(block: vec2<i32>) -> f32 {
    return abs(textureLoad(apparent, block, 0).x);
}

fn place_of(block: vec2<i32>) -> Corner {
    return corner_at(view, block, textureLoad(shape_normal, block, 0), 0.0, 0.0);
}

// Returns a block as a corner whose value is the derivative of the curvature along the block's direction, flipped to
// agree with `sense`.
fn crest_of(block: vec2<i32>, sense: vec2<f32>) -> Corner {
    let own = textureLoad(apparent, block, 0);
    let alike = dot(own.yz, sense);
    let along = select(-own.yz, own.yz, alike >= 0.0);
    var change = vec2<f32>(0.0);
    var is_whole = true;
    let middle = place_of(block);
    for (var i = 0; i < 4; i++) {
        let step = select(vec2<i32>(0, 1), vec2<i32>(1, 0), i < 2) * select(-1, 1, (i & 1) == 1);
        is_whole = is_whole && is_beside(view, middle, place_of(block + step));
        change += vec2<f32>(step) * turn_at(block + step);
    }
    let least = apparent_rules.least_bend;
    let bends = (apparent_rules.side * own.x * textureLoad(shape_bend, block, 0).w - least) / max(least, 0.01);
    let facing = dot(middle.normal, normalize(view.eye_m - middle.at_m));
    let room = min(bends, min(MOST_ACROSS - own.w, facing - LEAST_FACING));
    var corner = corner_at(view, block, textureLoad(shape_normal, block, 0), dot(change, along), room);
    corner.is_there = corner.is_there && is_whole && abs(alike) > ALIKE;
    return corner;
}

fn look(block: vec2<i32>) -> Curves {
    if any(block < vec2<i32>(1)) || any(block + 2 >= vec2<i32>(textureDimensions(shape_normal))) {
        return Curves();
    }
    let sense = textureLoad(apparent, block, 0).yz;
    let nw = crest_of(block, sense);
    let ne = crest_of(block + vec2<i32>(1, 0), sense);
    let se = crest_of(block + vec2<i32>(1, 1), sense);
    let sw = crest_of(block + vec2<i32>(0, 1), sense);
    // At a maximum the derivative falls.
    let slope = 0.5 * vec2<f32>(ne.value - nw.value + se.value - sw.value, sw.value - nw.value + se.value - ne.value);
    if dot(slope, sense) >= 0.0 {
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
    let kind = select(KIND_VALLEY, KIND_RIDGE, apparent_rules.side > 0.0);
    put_curves(view, position, normal, cell, look(cell.block), kind, 2u);
}
