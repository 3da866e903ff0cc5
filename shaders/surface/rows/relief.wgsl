// Computes the relief of a block of rows: the heights of the land's form at the corners of its cells, and the steepness
// of the surroundings.
//
// The form is the level of the pyramid whose samples are twice as far apart as marks, under a B-spline
// (`form_of_level`), so rows follow nothing that is finer than a few marks. Heights are in the world, so that they are
// the same for every camera; outside of the grid they repeat those at its border. Holes of the data count as land here,
// with their filled heights: marks in them are not visible, and rows continue next to them. Steepness is the root mean
// square over 8 cells: along a ridge it is that of its sides.
#import hachure::terrain::{grid_from_world, world_from_grid, first_sample, last_sample}
#import hachure::form::{form_of_level}
#import hachure::rows::{RowBlock, NODES, SLOPE_CELLS, SLOPE_NODES, MARGIN_CELLS, RELIEF, grid_of, camera_height_m}

// Samples of the slope along a side of the square around a node.
const TAPS: i32 = 6;
// Levels by which the form is coarser than a block's cells.
const COARSER: f32 = 1.0;

@group(0) @binding(0) var<storage, read> jobs: array<RowBlock>;
@group(0) @binding(1) var<storage, read_write> relief: array<f32>;
@group(0) @binding(2) var<storage, read_write> counts: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let block = jobs[id.y];
    let number = i32(id.x);
    let first = i32(id.y) * RELIEF;
    if number == 0 {
        counts[block.slot] = 0u;
    }
    if number < NODES * NODES {
        let g = grid_of(block, vec2<f32>(vec2<i32>(number % NODES, number / NODES) - MARGIN_CELLS));
        let inside = clamp(g, first_sample(), last_sample());
        relief[first + number] = form_of_level(inside, block.level + COARSER).height_m + camera_height_m();
    }
    let node = number - NODES * NODES;
    if node < 0 || node >= SLOPE_NODES * SLOPE_NODES {
        return;
    }
    let middle = vec2<f32>((vec2<i32>(node % SLOPE_NODES, node / SLOPE_NODES) - 1) * SLOPE_CELLS);
    let point = grid_from_world(world_from_grid(grid_of(block, middle)));
    var sum = 0.0;
    for (var i = 0; i < TAPS * TAPS; i++) {
        let tap = (vec2<f32>(vec2<i32>(i % TAPS, i / TAPS)) + 0.5) / f32(TAPS) - 0.5;
        let g = clamp(grid_of(block, middle + tap * f32(2 * SLOPE_CELLS)), first_sample(), last_sample());
        let form = form_of_level(g, block.level + COARSER);
        let slope = vec2<f32>(dot(form.gradient, point.dg_dx), dot(form.gradient, point.dg_dy));
        sum += dot(slope, slope);
    }
    relief[first + number] = sum / f32(TAPS * TAPS);
}
