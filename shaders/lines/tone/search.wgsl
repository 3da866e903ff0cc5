// Finds lines from shading: valleys of the tone image are dark lines, ridges are highlight lines, and steep steps are
// both.
//
// Lee, Markosian, Lee and Hughes 2007, "Line drawings via abstracted shading", sections 3.1 to 3.3.
// - Section 3.1: the tone around a point, at 3 x 3 samples that are half a line width apart, is fitted by least squares
//   with f = a0 x^2 + 2 a1 x y + a2 y^2 + a3 x + a4 y + a5. The eigenvalues of (a0 a1; a1 a2) are the curvatures; the
//   line is at the distance -(a3 a4).u / (2 lambda) along u, the direction of the greater one, lambda.
// - Section 3.2: from a pixel the search moves by the part beta of that distance, five times, and fits again. It gives
//   up where the curvature falls below a threshold, or after half a line width in all. On the flank of a ridge the line
//   comes nearer; on a step it recedes. So beta = 0 keeps all tone edges, 1 keeps only ridges and valleys, and values
//   in between also keep strong edges.
// - Section 3.3: the opacity is a ramp of the curvature between two thresholds, times a falloff with the distance to
//   the line, times counterchange: 1 - t for a dark line and t for a highlight line, where t is the tone.
//
// Interpretations and changes:
// - X of the fit is (-1, 0, 1) in both directions, so its pseudo-inverse is a few sums. Curvatures are those of the
//   tone per square of half a line width, so thresholds mean the same for any width.
// - Samples are between pixels, so they are bilinear.
// - The distance to the line is that from the pixel to the line of the first fit, or of the last one, whichever is
//   less. On a flank the first fit is off by up to a half (a parabola has no inflection), and the search finds the
//   right position. On an edge the line recedes from the search, and only the first fit gives the position at which it
//   is drawn.
// - "The other curvature is sufficiently small" (section 3.1, and not in 3.2) is optional, because it removes spots and
//   opens crossings: see `roundest`.
// - Samples of a fit without surface nearby take the tone of the fit's own cell.
// - The search runs per cell of a grid; cells are 2 x 2 pixels where lines are wide. It does not produce ink but lines,
//   with position and strength. `ink` draws them in the pixels.
//
// SPECULAR: the specular channel has highlight lines, too.
#import hachure::view::View
#import hachure::tone_grid::{Grid, Line, grid_of, left_of, texel_of_line}

struct Search {
    // Curvatures at which dark lines begin and at which they are full; the same for highlight lines.
    dark_ramp: vec2<f32>,
    highlight_ramp: vec2<f32>,
    beta: f32,
    counterchange: f32,
    // Largest ratio of the lesser curvature to the greater one; 1 and more sets no bound.
    roundest: f32,
    // 1: dark lines, and highlight lines, are drawn.
    has_dark: u32,
    has_highlights: u32,
    // 1: the sky has no tone, unlike a white sky.
    is_sky_toneless: u32,
    // Side of a cell of the grid, in pixels.
    cell_px: i32,
    pad: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> search: Search;
// r: diffuse tone; g: specular; b: width of lines in pixels; a: part of the surroundings that is surface.
@group(0) @binding(2) var blurred: texture_2d<f32>;
@group(0) @binding(3) var tone_sampler: sampler;
// In the encoding of `line_of_texel`.
@group(0) @binding(4) var tone_lines: texture_storage_2d<rgba16float, write>;

const STEPS: i32 = 5;
// Part of the surroundings that must be surface for a tone to be valid.
const MIN_SURFACE: f32 = 0.01;
// Largest distance of a line that is stored, in cells.
const FARTHEST: f32 = 64.0;
// Curvatures relative to the threshold of lines. Cells down to the first are searched too, since the border of a line
// is between them and their neighbours; curvatures are clamped to the second.
const MIN_SEARCHED: f32 = 0.2;
const MAX_CURVATURE: f32 = 1000.0;

struct Fit {
    // Greater curvature; lesser curvature; direction of the greater one; gradient along it.
    curvature: f32,
    other: f32,
    across: vec2<f32>,
    slope: f32,
}

// `size` is that of the grid. The texture may be larger, so that the sampler does not clamp.
fn tone_at(size: vec2<f32>, place: vec2<f32>, channel: u32, own: f32) -> f32 {
    let inside = clamp(place, vec2<f32>(0.5), size - 0.5);
    let texel = textureSampleLevel(blurred, tone_sampler, inside / vec2<f32>(textureDimensions(blurred)), 0.0);
    let is_there = search.is_sky_toneless == 0u || texel.a > MIN_SURFACE;
    return select(own, select(texel.r, texel.g, channel == 1u), is_there);
}

// Fits the tone around a point, in units of the samples' spacing. Near the border the fit is that of the nearest point
// whose samples are in the picture, and its gradient is extrapolated to the point by its curvature.
fn fit(grid: Grid, asked: vec2<f32>, spacing: f32, channel: u32, own: f32) -> Fit {
    let size = vec2<f32>(grid.size);
    let first = min(vec2<f32>(spacing + 0.5), 0.5 * size);
    let place = clamp(asked, first, size - first);
    let beyond = (asked - place) / spacing;
    let x = vec2<f32>(spacing, 0.0);
    let y = vec2<f32>(0.0, spacing);
    // Columns from left to right.
    let left = vec3<f32>(tone_at(size, place - x - y, channel, own), tone_at(size, place - x, channel, own), tone_at(size, place - x + y, channel, own));
    let middle = vec3<f32>(tone_at(size, place - y, channel, own), tone_at(size, place, channel, own), tone_at(size, place + y, channel, own));
    let right = vec3<f32>(tone_at(size, place + x - y, channel, own), tone_at(size, place + x, channel, own), tone_at(size, place + x + y, channel, own));
    let all_three = vec3<f32>(1.0);
    let down = vec3<f32>(-1.0, 0.0, 1.0);
    let bent = vec3<f32>(1.0, -2.0, 1.0);
    let a0 = dot(left - 2.0 * middle + right, all_three) / 6.0;
    let a1 = dot(right - left, down) / 8.0;
    let a2 = dot(left + middle + right, bent) / 6.0;
    let gradient = vec2<f32>(dot(right - left, all_three), dot(left + middle + right, down)) / 6.0;
    let mean = 0.5 * (a0 + a2);
    let difference = 0.5 * (a0 - a2);
    let radius = length(vec2<f32>(difference, a1));
    let side = select(-1.0, 1.0, mean >= 0.0);
    let curvature = mean + side * radius;
    // The longer of the two rows of (a0 a1; a1 a2) - curvature gives the direction; where both are 0 any direction will
    // do.
    let one = vec2<f32>(curvature - a2, a1);
    let two = vec2<f32>(a1, curvature - a0);
    let longer = select(two, one, dot(one, one) >= dot(two, two));
    let squared = dot(longer, longer);
    let across = select(vec2<f32>(1.0, 0.0), longer * inverseSqrt(max(squared, 1e-30)), squared > 1e-20);
    return Fit(curvature, mean - side * radius, across, dot(gradient, across) + 2.0 * curvature * dot(beyond, across));
}

// Returns the line that a cell detects in one channel. There is one fit in one loop, which ends when no cell of a
// workgroup continues: drivers that execute both sides of a branch have little to do where there are no lines. Lengths
// are in cells.
fn line_of(grid: Grid, place: vec2<f32>, width: f32, channel: u32, tone: f32) -> Line {
    let spacing = 0.5 * width;
    var at = place;
    var travelled = 0.0;
    var first = vec2<f32>(0.0);
    var is_dark = false;
    var is_line = true;
    var is_wanted = true;
    var ramp = vec2<f32>(0.0);
    var curvature = 0.0;
    var seen = Fit(0.0, 0.0, vec2<f32>(1.0, 0.0), 0.0);
    for (var i = 0; i <= STEPS && is_line; i++) {
        seen = fit(grid, at, spacing, channel, tone);
        let way = -spacing * seen.slope / (2.0 * select(seen.curvature, 1e-12, abs(seen.curvature) < 1e-12));
        if i == 0 {
            is_dark = seen.curvature > 0.0;
            ramp = max(select(search.highlight_ramp, search.dark_ramp, is_dark), vec2<f32>(1e-4, 2e-4));
            first = way * seen.across;
            is_wanted = select(search.has_highlights, search.has_dark, is_dark) == 1u && !(is_dark && channel == 1u);
            is_line = is_wanted;
            curvature = clamp(seen.curvature / ramp.x, -MAX_CURVATURE, MAX_CURVATURE);
        }
        let least = select(1.0, MIN_SEARCHED, i == 0) * ramp.x;
        is_line = is_line && select(-1.0, 1.0, is_dark) * seen.curvature >= least;
        if i < STEPS {
            at += search.beta * way * seen.across;
            travelled += search.beta * abs(way);
            is_line = is_line && travelled <= 0.5 * width;
        }
    }
    let by_curvature = saturate((abs(seen.curvature) - ramp.x) / max(ramp.y - ramp.x, 1e-6));
    let rest = -spacing * seen.slope / (2.0 * select(seen.curvature, 1e-12, abs(seen.curvature) < 1e-12));
    let last = at + rest * seen.across - place;
    let round = smoothstep(0.5 * search.roundest, search.roundest, seen.other / select(seen.curvature, 1.0, seen.curvature == 0.0));
    let is_long = select(1.0 - round, 1.0, search.roundest >= 1.0);
    let against = mix(1.0, select(tone, 1.0 - tone, is_dark), search.counterchange);
    let opacity = select(0.0, saturate(by_curvature * is_long * saturate(against)), is_line);
    let to_line = select(last, first, dot(first, first) < dot(last, last));
    // The direction is stored pointing right, as `way_of_number` reads it.
    let left = select(-seen.across, seen.across, seen.across.y >= 0.0);
    let side = select(-1.0, 1.0, dot(to_line, left) >= 0.0);
    let offset_px = side * min(length(to_line), FARTHEST) * f32(grid.side_px);
    // Where a search began well and gave up, the border is halfway to the neighbouring cells.
    let shown_curvature = select(curvature, 0.0, is_wanted && !is_line && abs(curvature) >= MIN_SEARCHED);
    return Line(shown_curvature, opacity, offset_px, vec2<f32>(left.y, -left.x));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let grid = grid_of(view, search.cell_px);
    let cell = vec2<i32>(id.xy);
    if any(cell >= grid.size) {
        return;
    }
    let own = textureLoad(blurred, cell, 0);
    if own.a <= 0.0 {
        textureStore(tone_lines, cell, vec4<f32>(0.0));
        return;
    }
    let place = vec2<f32>(cell) + 0.5;
    let width = own.b / f32(grid.side_px);
    var line = line_of(grid, place, width, 0u, own.r);
#ifdef SPECULAR
    // Highlights stand out from their surroundings, whatever their diffuse tone; of two lines the stronger one is
    // stored.
    let highlight = line_of(grid, place, width, 1u, own.g);
    if highlight.opacity > line.opacity {
        line = highlight;
    }
#endif
    textureStore(tone_lines, cell, texel_of_line(line));
}
