// The tone image under a Gaussian as wide as lines are, along one axis; two such passes are the blur.
//
// Lee et al. 2007, "Line drawings via abstracted shading", section 3.2: "to reduce sampling artifacts, the preparation of
// the tone image includes a blurring step using a Gaussian kernel of size w". The width w decides which shapes are lines.
//
// Readings and changes:
// - "of size w" is a standard deviation of `blur` line widths, half of one unless a style says otherwise; what is farther
//   than 2.3 of them is left out.
// - Only surface counts, and what it is divided by is how much of the kernel is surface: light does not leak into the sky,
//   and widths do not shrink beside it. Where skylines are to be lines the sky is white instead, as the paper's background
//   is, and the edge of the land is a tone edge.
// - Each pixel's kernel has the width of its own lines. A pixel of the sky has the widest, so that the land reaches as far
//   into it as the fit of the search does.
// - Beside the border the kernel is as wide as there is room on both sides: a slope of tone stays one, and has no line along
//   the border.
#import hachure::view::View

struct Blur {
    // (1, 0) or (0, 1).
    step: vec2<i32>,
    // 1: the second pass, whose tones are whole.
    is_last: u32,
    // 1: the sky is white. Else it has the tones beside it.
    is_sky_white: u32,
    // Standard deviation in line widths.
    deviation: f32,
    widest_px: f32,
    pad_a: f32,
    pad_b: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> blur: Blur;
// As lines/tone/tone_image.wgsl writes it, or the first pass.
@group(0) @binding(2) var tone_image: texture_2d<f32>;
// r: diffuse tone; g: specular; b: width of lines in pixels; a: which part of the kernel is surface. Before the last pass
// the first three are multiplied by that.
@group(0) @binding(3) var blurred: texture_storage_2d<rgba16float, write>;

// Standard deviations that count.
const REACH: f32 = 2.3;
const LEAST: f32 = 1e-3;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let last = vec2<i32>(view.size_px) - 1;
    let here = textureLoad(tone_image, pixel, 0);
    let width_px = select(blur.widest_px, here.b / here.a, here.a > LEAST);
    let deviation_px = max(blur.deviation * width_px, 1e-3);
    let reach = i32(ceil(REACH * deviation_px));
    // exp(-i^2 / 2 deviation^2), from one to the next by a factor that falls by a factor.
    let falloff = -0.5 / (deviation_px * deviation_px);
    var weight = exp(falloff);
    var factor = weight * weight * weight;
    let less = weight * weight;
    var sum = here;
    var weights = 1.0;
    for (var i = 1; i <= reach; i++) {
        let before = pixel - i * blur.step;
        let after = pixel + i * blur.step;
        let counts = select(0.0, weight, all(before >= vec2<i32>(0)) && all(after <= last));
        sum += counts * (textureLoad(tone_image, before, 0) + textureLoad(tone_image, after, 0));
        weights += 2.0 * counts;
        weight *= factor;
        factor *= less;
    }
    var mean = sum / weights;
    if blur.is_last == 1u {
        let surface = mean.a;
        let whole = mean.rgb / max(surface, LEAST);
        mean = vec4<f32>(whole, surface);
        if blur.is_sky_white == 1u {
            mean.r = mix(1.0, whole.r, surface);
            mean.g = whole.g * surface;
        }
        if surface <= LEAST {
            mean.b = blur.widest_px;
        }
    }
    textureStore(blurred, pixel, mean);
}
