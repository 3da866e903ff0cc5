// Blurs the tone image along one axis by a Gaussian of the lines' width; two such passes are the blur.
//
// Lee et al. 2007, "Line drawings via abstracted shading", section 3.2: "to reduce sampling artifacts, the preparation
// of the tone image includes a blurring step using a Gaussian kernel of size w". The width w decides which shapes are
// lines.
//
// Interpretations and changes:
// - "of size w" is a standard deviation of `blur` line widths, half of one unless a style says otherwise; the kernel is
//   cut off at 2.3 standard deviations.
// - Only surface counts, and the sum is divided by the part of the kernel that is surface: light does not leak into the
//   sky, and widths do not shrink near it. In styles that draw skylines the sky is white instead, like the paper's
//   background, and the edge of the land is a tone edge.
// - Each pixel's kernel has the width of its own lines. A pixel of the sky has the widest, so that the land extends
//   into the sky as far as the fit of the search does.
// - Near the border the kernel is as wide as there is room on both sides: a gradient of tone remains one, and makes no
//   line along the border.
// - Wide lines use a grid of cells of 2 x 2 pixels. A cell is the mean of its pixels, and the kernel is narrower
//   accordingly.
#import hachure::view::View
#import hachure::tone_grid::{grid_of}

struct Blur {
    // (1, 0) or (0, 1).
    step: vec2<i32>,
    // 1: the second pass, whose tones are normalised.
    is_last: u32,
    // 1: the sky is white. 0: it takes the tones next to it.
    is_sky_white: u32,
    // Standard deviation in line widths.
    deviation: f32,
    widest_px: f32,
    // Side of a cell of the grid.
    cell_px: i32,
    pad: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> blur: Blur;
// The output of lines/tone/tone_image.wgsl, or of the first pass.
@group(0) @binding(2) var tone_image: texture_2d<f32>;
// r: diffuse tone; g: specular; b: width of lines in pixels; a: part of the kernel that is surface. Before the last
// pass the first three are multiplied by a.
@group(0) @binding(3) var blurred: texture_storage_2d<rgba16float, write>;

// Extent of the kernel, in standard deviations.
const REACH: f32 = 2.3;
// If no more than this part of the kernel is surface, the surface is ignored.
const MIN_PART: f32 = 1e-3;
// Variance that cells of 2 x 2 pixels and interpolation between them already have, along one axis, in square pixels:
// 0.25 for a cell, and the rest makes curvatures those of pixels.
const OF_CELL: f32 = 0.6;
// Smallest variance of the kernel, in square pixels: with less, distant lines showed the stairs of cells.
const MIN_VARIANCE: f32 = 0.84;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let grid = grid_of(view, blur.cell_px);
    let cell = vec2<i32>(id.xy);
    if any(cell >= grid.size) {
        return;
    }
    let last = grid.size - 1;
    let here = textureLoad(tone_image, cell, 0);
    let width_px = select(blur.widest_px, here.b / here.a, here.a > MIN_PART);
    let asked_px = blur.deviation * width_px;
    let has_cells = blur.cell_px > 1;
    let left_px = sqrt(select(asked_px * asked_px, max(asked_px * asked_px - OF_CELL, MIN_VARIANCE), has_cells));
    let deviation = max(left_px / f32(blur.cell_px), 1e-3);
    let reach = i32(ceil(REACH * deviation));
    // exp(-i^2 / 2 deviation^2), computed from one to the next by a factor that falls by a factor.
    let falloff = -0.5 / (deviation * deviation);
    var weight = exp(falloff);
    var factor = weight * weight * weight;
    let less = weight * weight;
    var sum = here;
    var weights = 1.0;
    for (var i = 1; i <= reach; i++) {
        let before = cell - i * blur.step;
        let after = cell + i * blur.step;
        let counts = select(0.0, weight, all(before >= vec2<i32>(0)) && all(after <= last));
        sum += counts * (textureLoad(tone_image, before, 0) + textureLoad(tone_image, after, 0));
        weights += 2.0 * counts;
        weight *= factor;
        factor *= less;
    }
    var mean = sum / weights;
    if blur.is_last == 1u {
        let surface = mean.a;
        let whole = mean.rgb / max(surface, MIN_PART);
        mean = vec4<f32>(whole, surface);
        if blur.is_sky_white == 1u {
            mean.r = mix(1.0, whole.r, surface);
            mean.g = whole.g * surface;
        }
        if surface <= MIN_PART {
            mean.b = blur.widest_px;
        }
    }
    textureStore(blurred, cell, mean);
}
