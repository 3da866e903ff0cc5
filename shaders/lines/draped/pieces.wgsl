// Drapes lines and points of features on the land that is drawn, and cuts them into pieces that are short on the picture.
//
// There is one thread for each segment of a line, and one for each point. Most blocks of points have one segment, so a
// workgroup for each block would leave 63 of 64 threads idle. A segment is straight on the map. Its part in view is divided evenly, by the size of a pixel at the place that is nearest to the eye, and every
// division point gets the height of the surface that the resolve pass computes there (docs/decisions/one-surface.md).
#import hachure::view::View
#import hachure::earth::bend
#import hachure::terrain::{terrain, grid_from_world, surface_level, is_in_grid}
#import hachure::surface::{surface_near, surface_at}
#import hachure::draped::{DrapedPiece, DrapedRules, DOT}

struct DrapedBlock {
    // East and north of its origin, in metres from the rig's origin.
    origin_m: vec2<f32>,
    // Its first point, and their number.
    first: u32,
    count: u32,
}

struct DrapedPoint {
    // East and north of the block's origin, in metres.
    at_m: vec2<f32>,
    // Length of the line up to here, in metres.
    along_m: f32,
    // 1 for a point that is drawn as a dot.
    is_dot: u32,
}

// Length of a piece on the picture, and the largest number of pieces of a segment.
const PIECE_PX: f32 = 2.5;
const MOST_PIECES: f32 = 512.0;
// A segment is cut off this far outside of the picture, as a fraction of its half size.
const BEYOND: f32 = 0.05;

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> rules: DrapedRules;
@group(0) @binding(2) var<storage, read> blocks: array<DrapedBlock>;
@group(0) @binding(3) var<storage, read> points: array<DrapedPoint>;
@group(0) @binding(4) var<storage, read_write> pieces: array<DrapedPiece>;
@group(0) @binding(5) var<storage, read_write> drawn: array<atomic<u32>, 4>;
// For each thread a block, from bit SEGMENT_BITS on, and a segment of it.
@group(0) @binding(6) var<storage, read> segments: array<u32>;

const SEGMENT_BITS: u32 = 6u;

// Returns the height of the surface at a place, relative to the rig's origin. `about_m` is a height near it.
fn height_m(xy_m: vec2<f32>, about_m: f32) -> f32 {
    let g = grid_from_world(xy_m).g;
    return surface_at(surface_near(g, surface_level(g, length(vec3<f32>(xy_m, about_m))))).height_m;
}

// Projects a place with its height: position on the targets, and distance along the view axis. The distance is 0 if the
// place is behind the eye or outside of the land.
fn projected(xy_m: vec2<f32>, height_m: f32) -> vec3<f32> {
    let clip = view.clip_from_camera * vec4<f32>(bend(vec3<f32>(xy_m, height_m)), 1.0);
    let px = (clip.xy / max(clip.w, 1e-6) * vec2<f32>(0.5, -0.5) + 0.5) * vec2<f32>(view.size_px);
    let is_there = clip.w > view.near_m && is_in_grid(grid_from_world(xy_m).g);
    return vec3<f32>(px, select(0.0, clip.w, is_there));
}

// Returns the part of a segment that may be in view, as fractions of it; the second is not larger than the first if
// nothing is. Whatever the heights of the land are, they are within its range.
fn part_in_view(a_m: vec2<f32>, b_m: vec2<f32>) -> vec2<f32> {
    let fall_m = 0.5 * terrain.inverse_radius * max(dot(a_m, a_m), dot(b_m, b_m));
    let range_m = vec2<f32>(terrain.min_z_m - fall_m, terrain.max_z_m);
    let m = transpose(view.clip_from_camera);
    var part = vec2<f32>(0.0, 1.0);
    for (var side = 0u; side < 5u; side++) {
        var plane = m[3];
        if side < 4u {
            plane = m[3] * (1.0 + BEYOND) + m[side / 2u] * select(-1.0, 1.0, side % 2u == 0u);
        }
        let high = max(plane.z * range_m.x, plane.z * range_m.y) + plane.w;
        let at_a = dot(plane.xy, a_m) + high;
        let at_b = dot(plane.xy, b_m) + high;
        let crossing = at_a / (at_a - at_b);
        if at_a < 0.0 && at_b < 0.0 {
            part = vec2<f32>(1.0, 0.0);
        } else if at_a < 0.0 {
            part.x = max(part.x, crossing);
        } else if at_b < 0.0 {
            part.y = min(part.y, crossing);
        }
    }
    return part;
}

fn place_dot(at_m: vec2<f32>) {
    let about_m = height_m(at_m, 0.0);
    let at = projected(at_m, height_m(at_m, about_m));
    if at.z > 0.0 {
        let place = atomicAdd(&drawn[1], 1u);
        if place < rules.capacity {
            pieces[place] = DrapedPiece(vec4<f32>(at, DOT), vec4<f32>(at, DOT));
        } else {
            atomicSub(&drawn[1], 1u);
        }
    }
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= rules.segments {
        return;
    }
    let block = blocks[segments[id.x] >> SEGMENT_BITS];
    let index = segments[id.x] & ((1u << SEGMENT_BITS) - 1u);
    if index + 1u >= block.count {
        return;
    }
    let a = points[block.first + index];
    let b = points[block.first + index + 1u];
    let a_m = block.origin_m + a.at_m;
    let b_m = block.origin_m + b.at_m;
    let part = part_in_view(a_m, b_m);
    if part.x > part.y {
        return;
    }
    if a.is_dot == 1u {
        if index == 0u {
            place_dot(a_m);
        }
        return;
    }
    let along_m = b_m - a_m;
    // Where the part in view is nearest to the eye.
    let nearest = clamp(dot(view.eye_m.xy - a_m, along_m) / max(dot(along_m, along_m), 1e-12), part.x, part.y);
    let near_m = a_m + along_m * nearest;
    var about_m = height_m(near_m, 0.0);
    about_m = height_m(near_m, about_m);
    let away_m = length(vec3<f32>(near_m, about_m) - view.eye_m);
    let length_px = length(along_m) * (part.y - part.x) * view.focal_px / max(away_m, view.near_m);
    let count = u32(clamp(ceil(length_px / PIECE_PX), 1.0, MOST_PIECES));
    let first = atomicAdd(&drawn[1], count);
    // Pieces without room are not drawn; the count is that of those with room again when all threads have ended.
    let room = min(count, rules.capacity - min(first, rules.capacity));
    if room < count {
        atomicSub(&drawn[1], count - room);
    }
    var before = vec4<f32>(0.0);
    for (var i = 0u; i <= count; i++) {
        let t = mix(part.x, part.y, f32(i) / f32(count));
        let at_m = a_m + along_m * t;
        about_m = height_m(at_m, about_m);
        let at = vec4<f32>(projected(at_m, about_m), mix(a.along_m, b.along_m, t));
        if i > 0u && i <= room {
            pieces[first + i - 1u] = DrapedPiece(before, at);
        }
        before = at;
    }
}
