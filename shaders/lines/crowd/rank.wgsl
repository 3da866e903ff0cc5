// The rank of a line at each pixel: 0 is a short fragment on a face, 1 a long skyline. The ink of each rank is counted
// in the cell of the pixel.
//
// Half of the rank is the relative step in distance across the line, from the nearest surface around to the farthest;
// the sky is farthest. The other half is how far the line continues: its mean ink along a straight path of a quarter of
// the window to either side, in the best of eight directions, minus the mean across. A short fragment has little ink
// along its path, and grey noise as much across as along.
//
// The second half of the word is how far the cap holds for the line: that of the nearest surface around, whose contour
// it is.
#import hachure::view::View
#import hachure::crowd::{Crowd, capped, first_cell, bin_of, CELL_WORDS, UNITS}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> crowd: Crowd;
@group(0) @binding(2) var distance_m: texture_2d<f32>;
@group(0) @binding(3) var line: texture_2d<f32>;
// Rank, and how far the cap holds, in 16 bits each.
@group(0) @binding(4) var rank: texture_storage_2d<r32uint, write>;
// CELL_WORDS for each cell, which begin at 0. Lines of pixels are narrow, so their width is not stored.
@group(0) @binding(5) var<storage, read_write> counts: array<atomic<u32>>;

const DIRECTIONS: i32 = 8;
// Samples to either side.
const TAPS: i32 = 6;
const AROUND_PX: i32 = 2;
// Relative step in distance that counts half.
const STEP: f32 = 0.05;
const PI: f32 = 3.1415927;

fn inside(pixel: vec2<i32>) -> vec2<i32> {
    return clamp(pixel, vec2<i32>(0), vec2<i32>(view.size_px) - 1);
}

// Returns 1 / distance of the farthest and of the nearest surface around; 0 is the sky. Where there is no ink, loops end
// early, since a software driver runs both sides of a branch.
fn nearness_at(pixel: vec2<i32>, has_ink: bool) -> vec2<f32> {
    var nearness = vec2<f32>(1e30, 0.0);
    let last = select(-AROUND_PX, AROUND_PX, has_ink);
    for (var y = -AROUND_PX; y <= last; y++) {
        for (var x = -AROUND_PX; x <= AROUND_PX; x++) {
            let depth_m = textureLoad(distance_m, inside(pixel + vec2<i32>(x, y)), 0).r;
            let near = select(0.0, 1.0 / max(depth_m, 1e-6), depth_m > 0.0);
            nearness = vec2<f32>(min(nearness.x, near), max(nearness.y, near));
        }
    }
    return nearness;
}

fn step_of(nearness: vec2<f32>) -> f32 {
    let step = 1.0 - nearness.x / max(nearness.y, 1e-30);
    return step / (step + STEP);
}

fn length_at(pixel: vec2<i32>, has_ink: bool) -> f32 {
    let apart_px = f32(crowd.cell_px) / f32(TAPS);
    var means: array<f32, DIRECTIONS>;
    let taps = select(1, TAPS, has_ink);
    for (var tap = 1; tap <= taps; tap++) {
        for (var i = 0; i < DIRECTIONS; i++) {
            let angle = PI * f32(i) / f32(DIRECTIONS);
            let way = apart_px * vec2<f32>(cos(angle), sin(angle));
            let off = vec2<i32>(round(way * f32(tap)));
            means[i] += textureLoad(line, inside(pixel + off), 0).r + textureLoad(line, inside(pixel - off), 0).r;
        }
    }
    var best = 0.0;
    for (var i = 0; i < DIRECTIONS; i++) {
        best = max(best, means[i] - means[(i + DIRECTIONS / 2) % DIRECTIONS]);
    }
    return best / f32(2 * TAPS);
}

// Adds the ink of a pixel to its cell. A part of a large picture may begin before the first cell.
fn count(pixel: vec2<i32>, own_rank: f32, ink: f32) {
    let place = vec2<f32>(pixel + view.origin_px) + 0.5;
    let cell = vec2<i32>(floor(place / f32(crowd.cell_px))) - first_cell(view, crowd);
    if all(cell >= vec2<i32>(0)) && all(cell < vec2<i32>(crowd.cells)) {
        let first = (u32(cell.y) * crowd.cells.x + u32(cell.x)) * CELL_WORDS;
        atomicAdd(&counts[first + bin_of(own_rank)], u32(round(ink * UNITS)));
    }
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let ink = textureLoad(line, pixel, 0).r;
    var value = vec2<f32>(0.0);
    if ink > 0.0 {
        let nearness = nearness_at(pixel, ink > 0.0);
        let nearest_m = select(0.0, 1.0 / nearness.y, nearness.y > 0.0);
        value = vec2<f32>(0.5 * (step_of(nearness) + length_at(pixel, ink > 0.0)), capped(crowd, nearest_m));
        count(pixel, value.x, ink * value.y);
    }
    textureStore(rank, pixel, vec4<u32>(pack2x16unorm(value), 0u, 0u, 0u));
}
