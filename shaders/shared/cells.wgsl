// Zero curves of a value on the visible surface, by marching squares over blocks of pixels.
//
// A cell has four neighbouring blocks as its corners, which must see the same surface. A curve enters and leaves the
// cell where the value is zero on a side. It ends inside the cell where `room` falls to zero; `room` is positive where
// all conditions on the curve hold.
#define_import_path hachure::cells
#import hachure::view::{View, place_at, ray_at, place_of_pixel, distance_from_eye}
#import hachure::seen::{normal_seen, place_seen}
#import hachure::mark_normal::{BLOCK_PX, first_block, pixel_of_block}

// Two corners are on one surface if each is this near the other's tangent plane, in widths of a cell on the ground.
const ON_PLANE: f32 = 1.5;

// A corner of a cell: the pixel that represents a block. The argument `seen` of `corner_at` is the block's normal, and
// the distance along the view axis in metres.
struct Corner {
    px: vec2<f32>,
    at_m: vec3<f32>,
    normal: vec3<f32>,
    // The value whose zero curves are traced.
    value: f32,
    // Positive where a curve may be drawn.
    room: f32,
    // False for the sky.
    is_there: bool,
}

fn corner_at(view: View, block: vec2<i32>, seen: vec4<f32>, value: f32, room: f32) -> Corner {
    let pixel = pixel_of_block(view, block);
    return Corner(vec2<f32>(pixel) + 0.5, place_of_pixel(view, pixel, seen.w), seen.xyz, value, room, seen.w > 0.0);
}

// Returns whether two corners are on one surface.
fn on_one_surface(view: View, a: Corner, b: Corner) -> bool {
    let away_m = b.at_m - a.at_m;
    let allowed_m = ON_PLANE * f32(BLOCK_PX) * distance_from_eye(view, a.at_m) / view.focal_px;
    return a.is_there && b.is_there && abs(dot(a.normal, away_m)) < allowed_m && abs(dot(b.normal, away_m)) < allowed_m;
}

// A point on a side of a cell where the value is zero, if there is one (`is_there`).
struct Crossing {
    px: vec2<f32>,
    room: f32,
    is_there: bool,
}

fn crossing_of(a: Corner, b: Corner) -> Crossing {
    let is_there = (a.value < 0.0) != (b.value < 0.0);
    let t = select(0.5, a.value / (a.value - b.value), is_there);
    return Crossing(mix(a.px, b.px, t), mix(a.room, b.room, t), is_there);
}

// The curves of a cell, at most two: start and end, in pixels of the target.
struct Curves {
    lines: array<vec4<f32>, 2>,
    count: u32,
}

fn add_curve(curves: ptr<function, Curves>, start: Crossing, end: Crossing) {
    if max(start.room, end.room) <= 0.0 {
        return;
    }
    let t = start.room / (start.room - end.room);
    let between = mix(start.px, end.px, clamp(t, 0.0, 1.0));
    let a = select(between, start.px, start.room > 0.0);
    let b = select(between, end.px, end.room > 0.0);
    if any(a != b) {
        (*curves).lines[(*curves).count] = vec4<f32>(a, b);
        (*curves).count += 1u;
    }
}

// Returns the curves of a cell whose corners are given clockwise from the north-west.
fn curves_of(view: View, nw: Corner, ne: Corner, se: Corner, sw: Corner) -> Curves {
    var curves: Curves;
    if !(on_one_surface(view, nw, ne) && on_one_surface(view, ne, se) && on_one_surface(view, se, sw) && on_one_surface(view, sw, nw)) {
        return curves;
    }
    var sides = array<Crossing, 4>(crossing_of(nw, ne), crossing_of(ne, se), crossing_of(se, sw), crossing_of(sw, nw));
    // At a saddle the curves separate the middle from the two corners whose sign differs from the middle's.
    if sides[0].is_there && sides[1].is_there && sides[2].is_there && sides[3].is_there {
        let middle = nw.value + ne.value + se.value + sw.value;
        if (middle < 0.0) == (nw.value < 0.0) {
            add_curve(&curves, sides[0], sides[1]);
            add_curve(&curves, sides[2], sides[3]);
        } else {
            add_curve(&curves, sides[3], sides[0]);
            add_curve(&curves, sides[1], sides[2]);
        }
        return curves;
    }
    var first = -1;
    for (var i = 0; i < 4; i++) {
        if sides[i].is_there {
            if first >= 0 {
                add_curve(&curves, sides[first], sides[i]);
                return curves;
            }
            first = i;
        }
    }
    return curves;
}

// Returns the point of the visible surface at a position on the picture: where its ray meets the tangent plane of the
// pixel there.
fn on_surface(view: View, distance_m: texture_2d<f32>, normal: texture_2d<u32>, px: vec2<f32>) -> vec3<f32> {
    let pixel = clamp(vec2<i32>(floor(px)), vec2<i32>(0), vec2<i32>(view.size_px) - 1);
    let at = place_seen(view, distance_m, pixel);
    let n = normal_seen(normal, pixel);
    let ray = ray_at(view, px);
    let facing = dot(n, ray);
    let depth_m = dot(n, at.xyz - view.eye_m) / select(facing, -1e-6, abs(facing) < 1e-6);
    // A plane seen edge-on would put the point anywhere, so the depth is clamped.
    return place_at(view, px, clamp(depth_m, 0.98 * at.w, 1.02 * at.w));
}

// Returns a key for a cell that is the same in every part of a large picture.
fn key_of_cell(view: View, block: vec2<i32>) -> u32 {
    let own = vec2<u32>(block + first_block(view));
    return own.x * 0x9e3779b1u ^ own.y * 0x85ebca6bu;
}
