// Computes the factor by which marks must be wider so that their ink matches the requested ink: between rows, and on
// crests and in folds, land stays bare, and neighbouring marks compensate for that.
//
// For each square of the picture, the factor is the requested darkness around it divided by the ink that marks would
// have there.
#import hachure::view::View
#import hachure::rows::RowRules
#import hachure::row_ink::{INK_UNIT, square_px, squares_of}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> rules: RowRules;
@group(0) @binding(2) var<storage, read> inks: array<u32>;
@group(0) @binding(3) var<storage, read_write> gains: array<f32>;
@group(0) @binding(4) var distance_m: texture_2d<f32>;
@group(0) @binding(5) var tone: texture_2d<f32>;

// Distance between the pixels that are sampled.
const STRIDE: i32 = 2;
// Range of the factors that are returned.
const MIN_GAIN: f32 = 0.7;
const MAX_GAIN: f32 = 3.0;

// Returns the requested darkness in a square, summed over pixels.
fn asked_in(square: vec2<i32>) -> f32 {
    let low = square * square_px(rules);
    let to = min(low + square_px(rules), vec2<i32>(view.size_px));
    var sum = 0.0;
    for (var y = low.y; y < to.y; y += STRIDE) {
        for (var x = low.x; x < to.x; x += STRIDE) {
            let dark = clamp(1.0 - textureLoad(tone, vec2<i32>(x, y), 0).a, 0.0, rules.darkest);
            sum += select(0.0, dark, textureLoad(distance_m, vec2<i32>(x, y), 0).r > 0.0);
        }
    }
    return sum * f32(STRIDE * STRIDE);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let squares = squares_of(rules, view.size_px);
    let number = i32(id.x);
    if number >= squares.x * squares.y {
        return;
    }
    let own = vec2<i32>(number % squares.x, number / squares.x);
    var asked = 0.0;
    var drawn = 0.0;
    for (var i = 0; i < 9; i++) {
        let square = own + vec2<i32>(i % 3, i / 3) - 1;
        if all(square >= vec2<i32>(0)) && all(square < squares) {
            let weight = f32((2 - abs(i % 3 - 1)) * (2 - abs(i / 3 - 1)));
            asked += weight * asked_in(square);
            drawn += weight * f32(inks[square.y * squares.x + square.x]) / INK_UNIT;
        }
    }
    gains[number] = clamp(asked / max(drawn, 1.0), MIN_GAIN, MAX_GAIN);
}
