// Computes how much darker or lighter than requested marks must be around a cell, so that the mean of their ink is the
// tone: a step of Newton's method for the mean in a Gaussian window.
#import hachure::cover::{Balance, SIGMA_CELLS, REACH_CELLS}

// Smallest derivative of ink with respect to darkness that is assumed: with less, few marks end in the window.
const MIN_RISE: f32 = 0.4;
// Largest change of the darkness.
const MAX_STEP: f32 = 0.12;

@group(0) @binding(0) var<uniform> balance: Balance;
@group(0) @binding(1) var sums: texture_2d<f32>;
// Correction that is added to the darkness.
@group(0) @binding(2) var more: texture_storage_2d<r32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = vec2<i32>(balance.cells);
    let cell = vec2<i32>(id.xy);
    if any(cell >= size) {
        return;
    }
    var sum = vec3<f32>(0.0);
    for (var y = max(-REACH_CELLS, -cell.y); y <= min(REACH_CELLS, size.y - 1 - cell.y); y++) {
        for (var x = max(-REACH_CELLS, -cell.x); x <= min(REACH_CELLS, size.x - 1 - cell.x); x++) {
            let weight = exp(f32(x * x + y * y) * (-0.5 / (SIGMA_CELLS * SIGMA_CELLS)));
            sum += weight * textureLoad(sums, cell + vec2<i32>(x, y), 0).xyz;
        }
    }
    let step = sum.x / max(max(sum.y, MIN_RISE * sum.z), 1e-6);
    textureStore(more, cell, vec4<f32>(clamp(step, -MAX_STEP, MAX_STEP)));
}
