// Computes the marks of a frame: the drawn parts of chosen proposals, and their widths.
//
// A mark's width is the requested darkness (by Lehmann's law it follows from the slope; here from the style's tone),
// times the mark's room, times the factor that compensates for bare land around it.
#import hachure::view::View
#import hachure::rows::{RowRules, HALF, PROPOSAL, SAMPLES, DRAWN}
#import hachure::row_ink::{SLENDER, square_px, squares_of}

// Largest width of a mark, in widths of its room.
const WIDEST: f32 = 0.9;
// Limit of the compensation for bare land, as darkness: marks of light tones are not made wider than this part of their
// room, because they would touch.
const LEAN: f32 = 0.7;

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> rules: RowRules;
@group(0) @binding(2) var<storage, read> proposed: array<u32, 4>;
@group(0) @binding(3) var<storage, read> proposals: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> gains: array<f32>;
// Draw arguments: vertices, instances, the first of each.
@group(0) @binding(5) var<storage, read_write> drawn: array<atomic<u32>, 4>;
// SAMPLES for each mark: position in pixels, half the width, distance along the view axis.
@group(0) @binding(6) var<storage, read_write> marks: array<vec4<f32>>;
@group(0) @binding(7) var tone: texture_2d<f32>;

// Returns the factor interpolated between the centres of squares.
fn gain_at(px: vec2<f32>) -> f32 {
    let squares = squares_of(rules, view.size_px);
    let place = clamp(px / f32(square_px(rules)) - 0.5, vec2<f32>(0.0), vec2<f32>(squares) - 1.001);
    let a = vec2<i32>(max(place, vec2<f32>(0.0)));
    let b = min(a + 1, squares - 1);
    let f = place - vec2<f32>(a);
    return mix(
        mix(gains[a.y * squares.x + a.x], gains[a.y * squares.x + b.x], f.x),
        mix(gains[b.y * squares.x + a.x], gains[b.y * squares.x + b.x], f.x), f.y);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let number = id.x;
    if number >= min(proposed[0], rules.max_marks) {
        return;
    }
    let at = number * u32(PROPOSAL);
    let first = proposals[at];
    if first.w != DRAWN {
        return;
    }
    let begin = i32(first.x) % 32;
    let end = i32(first.x) / 32;
    var lengths: array<f32, 17>;
    var widths: array<f32, 17>;
    var length_px = 0.0;
    var widest_px = 0.0;
    var dark = -1.0;
    for (var j = begin; j <= end; j++) {
        let own = proposals[at + 1u + u32(j)];
        let pixel = clamp(vec2<i32>(floor(own.xy)), vec2<i32>(0), vec2<i32>(view.size_px) - 1);
        // A sample that is hidden keeps the darkness before it, because the surface in front has another tone.
        if ((u32(first.y) >> u32(j)) & 1u) == 1u || dark < 0.0 {
            dark = clamp(1.0 - textureLoad(tone, pixel, 0).a, 0.0, rules.darkest);
        }
        let wider = min(dark * gain_at(own.xy), max(dark, LEAN));
        widths[j] = min(wider / (1.0 - 0.667 * rules.taper), WIDEST) * own.z;
        if j > begin {
            length_px += distance(own.xy, proposals[at + u32(j)].xy);
        }
        lengths[j] = length_px;
        widest_px = max(widest_px, widths[j]);
    }
    let gain = min(1.0, length_px / (SLENDER * max(widest_px, 1e-6)));
    if gain * widest_px < 0.02 {
        return;
    }
    let place = atomicAdd(&drawn[1], 1u);
    let taper_px = max(rules.taper * length_px, 1e-3);
    for (var j = 0; j < SAMPLES; j++) {
        let k = clamp(j, begin, end);
        let own = proposals[at + 1u + u32(k)];
        let from_end = min(lengths[k], length_px - lengths[k]);
        let thin = sqrt(clamp(from_end / taper_px, 0.0, 1.0));
        marks[place * u32(SAMPLES) + u32(j)] = vec4<f32>(own.xy, 0.5 * gain * thin * widths[k], own.w);
    }
}
