// Finds the shore near each sample: where half of the surroundings are water, under a wide B-spline, so that it has no
// stairs. Newton's method starts from each sample that has land and water around it.
#import hachure::surface::{spline_weights, spline_slopes}
#import hachure::map_job::MapJob
#import hachure::water_maps::SIDE
#import hachure::shores::{Shore, packed_shore, extents, IS_SHORE, IS_WATER, FARTHEST_OFFSET, FIRST_WET}
#import hachure::lake_blocks::GIVEN_WATER
#import hachure::still_water::{LEVEL_WATER_M, NO_LAKE, VOID}

// Workgroups of 8 x 8 samples along a side.
const GROUPS: u32 = 41u;
const STEPS: i32 = 3;
// A sample with less water than DRY or more than WET around it has no shore.
const DRY: f32 = 0.04;
const WET: f32 = 0.96;
// Tolerance for the wetness of 0.5 at a shore.
const OFF: f32 = 0.06;

@group(0) @binding(0) var<storage, read> jobs: array<MapJob>;
@group(0) @binding(1) var<storage, read> classes: array<f32>;
@group(0) @binding(2) var<storage, read> found: array<u32>;
@group(0) @binding(3) var<storage, read_write> shores: array<u32>;

fn class_at(first: i32, place: vec2<i32>) -> f32 {
    let inside = clamp(place, vec2<i32>(0), vec2<i32>(SIDE - 1));
    return classes[first + inside.y * SIDE + inside.x];
}

// Returns 1 for water of the lake, 0 for land and for other lakes. Holes of the data have no shore.
fn wet(first: i32, place: vec2<i32>, lake: f32) -> f32 {
    let other = class_at(first, place);
    let is_one = other == GIVEN_WATER || lake == GIVEN_WATER && other < NO_LAKE;
    return select(0.0, 1.0, abs(other - lake) < LEVEL_WATER_M || other == VOID || is_one);
}

// Weights of six samples along an axis at a position between the middle two: those of a B-spline over means of three,
// which remove islands of a sample or two; or their derivatives.
struct Taps {
    first: vec3<f32>,
    last: vec3<f32>,
}

fn over_means(four: vec4<f32>) -> Taps {
    return Taps(0.25 * vec3<f32>(four.x, 2.0 * four.x + four.y, four.x + 2.0 * four.y + four.z),
        0.25 * vec3<f32>(four.y + 2.0 * four.z + four.w, four.z + 2.0 * four.w, four.w));
}

fn sum_of(taps: Taps, low: vec3<f32>, high: vec3<f32>) -> f32 {
    return dot(taps.first, low) + dot(taps.last, high);
}

// Returns the part of the surroundings that is water, and its gradient in samples.
fn wetness(first: i32, at: vec2<f32>, lake: f32) -> vec3<f32> {
    let cell = vec2<i32>(floor(at));
    let f = at - floor(at);
    let along = over_means(spline_weights(f.x));
    let slope = over_means(spline_slopes(f.x));
    var rows = array<vec2<f32>, 6>();
    for (var i = 0; i < 6; i++) {
        let left = cell + vec2<i32>(-2, i - 2);
        let low = vec3<f32>(wet(first, left, lake), wet(first, left + vec2<i32>(1, 0), lake), wet(first, left + vec2<i32>(2, 0), lake));
        let high = vec3<f32>(wet(first, left + vec2<i32>(3, 0), lake), wet(first, left + vec2<i32>(4, 0), lake),
            wet(first, left + vec2<i32>(5, 0), lake));
        rows[i] = vec2<f32>(sum_of(along, low, high), sum_of(slope, low, high));
    }
    let down = over_means(spline_weights(f.y));
    let steep = over_means(spline_slopes(f.y));
    let low = vec3<f32>(rows[0].x, rows[1].x, rows[2].x);
    let high = vec3<f32>(rows[3].x, rows[4].x, rows[5].x);
    let low_slopes = vec3<f32>(rows[0].y, rows[1].y, rows[2].y);
    let high_slopes = vec3<f32>(rows[3].y, rows[4].y, rows[5].y);
    return vec3<f32>(sum_of(down, low, high), sum_of(down, low_slopes, high_slopes), sum_of(steep, low, high));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(workgroup_id) group: vec3<u32>) {
    let turn = group.y / GROUPS;
    let number = found[FIRST_WET + turn];
    let place = vec2<i32>(vec2<u32>(id.x, id.y - turn * GROUPS * 8u));
    if any(place >= vec2<i32>(SIDE)) {
        return;
    }
    let first = i32(number) * SIDE * SIDE;
    // The lake at this sample or at one of its neighbours.
    var lake = class_at(first, place);
    var is_same = true;
    for (var i = 0; i < 9; i++) {
        let other = class_at(first, place + vec2<i32>(i % 3, i / 3) - 1);
        is_same = is_same && other == class_at(first, place);
        lake = select(lake, other, lake >= NO_LAKE && other < NO_LAKE);
    }
    let at = first + place.y * SIDE + place.x;
    if is_same || lake >= NO_LAKE {
        shores[at] = select(0u, IS_WATER, lake < NO_LAKE);
        return;
    }
    let own = wetness(first, vec2<f32>(place), lake);
    let side = select(0u, IS_WATER, own.x >= 0.5);
    if own.x < DRY || own.x > WET {
        shores[at] = side;
        return;
    }
    let job = jobs[number];
    let world = extents(job, place);
    let determinant = world[0].x * world[1].y - world[0].y * world[1].x;
    let grid = mat2x2<f32>(world[1].y, -world[0].y, -world[1].x, world[0].x) * (1.0 / determinant);
    var offset = vec2<f32>(0.0);
    var around = own;
    for (var step = 0; step < STEPS; step++) {
        let slope = around.yz * grid;
        let by = grid * slope * ((0.5 - around.x) / max(dot(slope, slope), 0.01));
        offset += by * min(1.0, 1.0 / max(length(by), 1e-6));
        around = wetness(first, vec2<f32>(place) + offset, lake);
    }
    let slope = around.yz * grid;
    if abs(around.x - 0.5) > OFF || length(slope) < 0.05 {
        shores[at] = side;
        return;
    }
    let normal = normalize(slope);
    // A coarse sample with some land does not count as water where heights define water. So on coarse levels the true
    // shore is farther out than halfway between samples: by half a sample, measured from corner to corner where it runs
    // diagonally.
    if job.level > 0 && lake != GIVEN_WATER {
        offset -= grid * normal * (0.5 * (abs(normal.x) + abs(normal.y)));
    }
    shores[at] = side | select(0u, packed_shore(Shore(offset, normal)), all(abs(offset) < vec2<f32>(FARTHEST_OFFSET)));
}
