// Suggestive contours become edges: where the surface would be a contour for an eye nearby (DeCarlo, Finkelstein,
// Rusinkiewicz, Santella 2003, "Suggestive Contours for Conveying Shape"; Pietrok 2021, section 4.1, draws their pixels).
//
// They are the zeros of the radial curvature at which it rises toward the eye. Their edges go into the list that
// contours are in, so strokes chain both, and a suggestive contour takes up a contour where that ends.
//
// Marching squares over the blocks of `lines/radial`: a cell has the places that four blocks stand for at its
// corners, which must be of one surface. A line enters and leaves where the radial curvature is zero on a side, and it
// ends in the cell where the rise falls below `least_rise`, where the surface faces the eye too much for a contour to be
// near, or where it turns away. Ends lie on the surface as it is seen there.
//
// Edges stand in the order of cells (ordered.wgsl): `stage` 0 counts them, 1 writes them, 2 says how many there are now.
#import hachure::view::{View, place_at, ray_at, place_of_pixel, distance_from_eye}
#import hachure::mark_normal::{BLOCK_PX, first_block, pixel_of_block}
#import hachure::edges::{Edge, KIND_SUGGESTIVE, MOST_EDGES}
#import hachure::ordered::{Order, all_marks, clear_marks, mark, marks_before}

struct SuggestiveRules {
    least_rise: f32,
    // A cosine: what faces the eye more has none.
    most_facing: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> suggestive_rules: SuggestiveRules;
@group(0) @binding(2) var position: texture_2d<f32>;
@group(0) @binding(3) var normal: texture_2d<f32>;
@group(0) @binding(4) var shape_normal: texture_2d<f32>;
@group(0) @binding(5) var radial: texture_2d<f32>;
@group(0) @binding(7) var<storage, read_write> edges: array<Edge>;
@group(0) @binding(8) var<storage, read_write> edge_draw: array<u32>;
@group(0) @binding(9) var<storage, read_write> order: Order;

// Corners are of one surface if each lies so near the plane of the next one, in widths of a cell on the ground.
const ON_PLANE: f32 = 1.5;

// A corner of a cell.
struct Corner {
    px: vec2<f32>,
    at_m: vec3<f32>,
    normal: vec3<f32>,
    // Radial curvature, in turns over a pixel.
    bend: f32,
    // Where it is above 0, all that is asked holds.
    room: f32,
    is_there: bool,
}

fn corner_of(block: vec2<i32>) -> Corner {
    let own = textureLoad(radial, block, 0);
    let pixel = pixel_of_block(view, block);
    let rise = (own.y - suggestive_rules.least_rise) / max(suggestive_rules.least_rise, 0.01);
    let room = min(rise, min(suggestive_rules.most_facing - own.z, own.z));
    return Corner(vec2<f32>(pixel) + 0.5, place_of_pixel(view, pixel, own.w), textureLoad(shape_normal, block, 0).xyz,
        own.x, room, own.w > 0.0);
}

fn is_beside(a: Corner, b: Corner) -> bool {
    let away_m = b.at_m - a.at_m;
    let allowed_m = ON_PLANE * f32(BLOCK_PX) * distance_from_eye(view, a.at_m) / view.focal_px;
    return a.is_there && b.is_there && abs(dot(a.normal, away_m)) < allowed_m && abs(dot(b.normal, away_m)) < allowed_m;
}

// Where a line crosses a side of a cell.
struct Crossing {
    px: vec2<f32>,
    room: f32,
    is_there: bool,
}

fn crossing_of(a: Corner, b: Corner) -> Crossing {
    let is_there = (a.bend < 0.0) != (b.bend < 0.0);
    let t = select(0.5, a.bend / (a.bend - b.bend), is_there);
    return Crossing(mix(a.px, b.px, t), mix(a.room, b.room, t), is_there);
}

// The place on the surface that is seen at a place of the picture: on the plane of the pixel there.
fn on_surface(px: vec2<f32>) -> vec3<f32> {
    let pixel = clamp(vec2<i32>(floor(px)), vec2<i32>(0), vec2<i32>(view.size_px) - 1);
    let at = textureLoad(position, pixel, 0);
    let n = textureLoad(normal, pixel, 0).xyz;
    let ray = ray_at(view, px);
    let facing = dot(n, ray);
    let depth_m = dot(n, at.xyz - view.eye_m) / select(facing, -1e-6, abs(facing) < 1e-6);
    // A plane that is seen edge-on leads anywhere.
    return place_at(view, px, clamp(depth_m, 0.98 * at.w, 1.02 * at.w));
}

// The lines of a cell: at most two.
var<private> found: array<vec4<f32>, 2>;
var<private> found_count: u32;

fn add(start: Crossing, end: Crossing) {
    if max(start.room, end.room) <= 0.0 {
        return;
    }
    let t = start.room / (start.room - end.room);
    let between = mix(start.px, end.px, clamp(t, 0.0, 1.0));
    let a = select(between, start.px, start.room > 0.0);
    let b = select(between, end.px, end.room > 0.0);
    if any(a != b) {
        found[found_count] = vec4<f32>(a, b);
        found_count += 1u;
    }
}

fn look(block: vec2<i32>) {
    found_count = 0u;
    if any(block + 1 >= vec2<i32>(textureDimensions(shape_normal))) {
        return;
    }
    let nw = corner_of(block);
    let ne = corner_of(block + vec2<i32>(1, 0));
    let se = corner_of(block + vec2<i32>(1, 1));
    let sw = corner_of(block + vec2<i32>(0, 1));
    if !(is_beside(nw, ne) && is_beside(ne, se) && is_beside(se, sw) && is_beside(sw, nw)) {
        return;
    }
    var sides = array<Crossing, 4>(crossing_of(nw, ne), crossing_of(ne, se), crossing_of(se, sw), crossing_of(sw, nw));
    // At a saddle lines part the middle from the corners that are not like it.
    let middle = nw.bend + ne.bend + se.bend + sw.bend;
    if sides[0].is_there && sides[1].is_there && sides[2].is_there && sides[3].is_there {
        if (middle < 0.0) == (nw.bend < 0.0) {
            add(sides[0], sides[1]);
            add(sides[2], sides[3]);
        } else {
            add(sides[3], sides[0]);
            add(sides[1], sides[2]);
        }
        return;
    }
    var first = -1;
    for (var i = 0; i < 4; i++) {
        if sides[i].is_there {
            if first >= 0 {
                add(sides[first], sides[i]);
                return;
            }
            first = i;
        }
    }
}

fn key_of(block: vec2<i32>) -> u32 {
    let own = vec2<u32>(block + first_block(view));
    return own.x * 0x9e3779b1u ^ own.y * 0x85ebca6bu;
}

@compute @workgroup_size(8, 8)
fn main(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    if order.stage == 2u {
        if thread == 0u {
            edge_draw[0] += 2u * order.starts[order.groups];
        }
        return;
    }
    clear_marks(thread);
    workgroupBarrier();
    look(vec2<i32>(id.xy));
    for (var i = 0u; i < found_count; i++) {
        mark(2u * thread + i);
    }
    workgroupBarrier();
    let own_group = group.x + group.y * groups.x;
    if order.stage == 0u {
        if thread == 0u {
            order.starts[own_group] = all_marks();
        }
        return;
    }
    var index = edge_draw[0] / 2u + order.starts[own_group] + marks_before(2u * thread);
    for (var i = 0u; i < found_count && index < MOST_EDGES; i++) {
        edges[index] = Edge(on_surface(found[i].xy), key_of(vec2<i32>(id.xy)) + i, on_surface(found[i].zw), KIND_SUGGESTIVE);
        index += 1u;
    }
}
