// The form of the land that rows of hachures follow: heights at the corners of a block's cells, interpolated by cubic
// convolution (Keys 1981), which passes through these heights and has no kinks.
#define_import_path hachure::row_form
#import hachure::rows::{RowBlock, Frame, MARGIN_CELLS, NODES, SLOPE_CELLS, SLOPE_NODES}

// Largest step along the slope, in cells.
const LONGEST: f32 = 2.0;

@group(0) @binding(2) var<storage, read_write> relief: array<f32>;

// Weights of four heights for the interpolated height at the fraction t between the middle two.
fn weights(t: f32) -> vec4<f32> {
    return 0.5 * vec4<f32>(t * (t * (2.0 - t) - 1.0), t * t * (3.0 * t - 5.0) + 2.0, t * (t * (4.0 - 3.0 * t) + 1.0), t * t * (t - 1.0));
}

// Weights of four heights for the derivative at the fraction t between the middle two.
fn slopes(t: f32) -> vec4<f32> {
    return 0.5 * vec4<f32>(t * (4.0 - 3.0 * t) - 1.0, t * (9.0 * t - 10.0), t * (8.0 - 9.0 * t) + 1.0, t * (3.0 * t - 2.0));
}

// Returns the slope to the east and to the north, and the height in the world, at a position in a block whose relief
// begins at `first`.
fn row_form(block: RowBlock, first: i32, frame: Frame, place: vec2<f32>) -> vec3<f32> {
    let at = clamp(place + f32(MARGIN_CELLS), vec2<f32>(1.0), vec2<f32>(f32(NODES) - 2.001));
    let node = vec2<i32>(floor(at));
    let f = at - vec2<f32>(node);
    let across = weights(f.x);
    let rise = slopes(f.x);
    let along = weights(f.y);
    let climb = slopes(f.y);
    var height_m = 0.0;
    var gradient = vec2<f32>(0.0);
    for (var row = 0; row < 4; row++) {
        let i = first + (node.y + row - 1) * NODES + node.x - 1;
        let heights = vec4<f32>(relief[i], relief[i + 1], relief[i + 2], relief[i + 3]);
        let here = dot(heights, across);
        height_m += along[row] * here;
        gradient += vec2<f32>(along[row] * dot(heights, rise), climb[row] * here);
    }
    gradient /= block.cell;
    return vec3<f32>(dot(gradient, frame.point.dg_dx), dot(gradient, frame.point.dg_dy), height_m);
}

// Returns the horizontal step along the slope over which the land rises by `rise_m`, in cells.
fn horizontal_step(block: RowBlock, frame: Frame, slope: vec2<f32>, rise_m: f32) -> vec2<f32> {
    let by_m = slope * (rise_m / max(dot(slope, slope), 1e-12));
    return (frame.point.dg_dx * by_m.x + frame.point.dg_dy * by_m.y) / block.cell;
}

// Returns the mean square of the slope around a position.
fn steepness(first: i32, at: vec2<f32>) -> f32 {
    let place = at / f32(SLOPE_CELLS) + 1.0;
    let node = clamp(vec2<i32>(floor(place)), vec2<i32>(0), vec2<i32>(SLOPE_NODES - 2));
    let f = place - vec2<f32>(node);
    let i = first + NODES * NODES + node.y * SLOPE_NODES + node.x;
    return mix(mix(relief[i], relief[i + 1], f.x), mix(relief[i + SLOPE_NODES], relief[i + SLOPE_NODES + 1], f.x), f.y);
}
