// The tone image under a Gaussian as wide as lines are, along one axis; two such passes are the blur.
//
// Lee et al. 2007, "Line drawings via abstracted shading", section 3.2: "to reduce sampling artifacts, the preparation of
// the tone image includes a blurring step using a Gaussian kernel of size w". The width w decides which shapes are lines.
//
// Readings and changes:
// - "of size w" is a standard deviation of `blur` line widths, half of one unless a style says otherwise; what is farther
//   than 2.5 of them is left out.
// - Only surface counts, and what it is divided by is how much of the kernel is surface: light does not leak into the sky,
//   and widths do not shrink beside it. Where skylines are to be lines the sky is white instead, as the paper's background
//   is, and the edge of the land is a tone edge.
// - Each pixel's kernel has the width of its own lines. A pixel of the sky has the widest, so that the land reaches as far
//   into it as the fit of the search does.
// - Beyond the picture tones go on as they rise or fall within it: a mirror in a point. Else a slope of tone would have a
//   line along the border.
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
const REACH: f32 = 2.5;
const LEAST: f32 = 1e-3;

// The picture at a place that may lie beyond its border.
fn load(at: vec2<i32>, last: vec2<i32>) -> vec4<f32> {
    let border = clamp(at, vec2<i32>(0), last);
    let edge = textureLoad(tone_image, border, 0);
    if all(border == at) {
        return edge;
    }
    let beyond = 2.0 * edge - textureLoad(tone_image, clamp(2 * border - at, vec2<i32>(0), last), 0);
    return select(edge, beyond, beyond.a >= 0.0 && beyond.a <= 1.0);
}

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
    let falloff = -0.5 / (deviation_px * deviation_px);
    var sum = here;
    var weights = 1.0;
    for (var i = 1; i <= reach; i++) {
        let weight = exp(f32(i * i) * falloff);
        sum += weight * (load(pixel - i * blur.step, last) + load(pixel + i * blur.step, last));
        weights += 2.0 * weight;
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
