// Lines from tone: valleys of the tone image are dark lines, ridges are highlight lines, and steep steps are both.
//
// Lee, Markosian, Lee and Hughes 2007, "Line drawings via abstracted shading", sections 3.1 to 3.3.
// - Section 3.1: the tone around a place, at 3 x 3 samples that lie half a line width apart, is fitted by least squares with
//   f = a0 x^2 + 2 a1 x y + a2 y^2 + a3 x + a4 y + a5. The eigenvalues of (a0 a1; a1 a2) are the curvatures; the line lies
//   -(a3 a4).u / (2 lambda) away along u, the direction of the greater one, lambda.
// - Section 3.2: from a pixel the search goes by the part beta of that way, five times, and fits anew. It gives up where
//   the curvature falls below a threshold, or after half a line width in all. On the flank of a ridge the line comes nearer;
//   on a step it runs away, so beta of 0 keeps all tone edges, 1 keeps ridges and valleys alone, and between the two strong
//   edges stay.
// - Section 3.3: the opacity is a ramp of the curvature between two thresholds, times what is left at the distance to the
//   line, times counterchange: 1 - t for a dark line and t for a highlight line, where t is the tone.
//
// Readings and changes:
// - X of the fit is (-1, 0, 1) in both directions, so its pseudo-inverse is a few sums; curvatures are those of the tone per
//   square of half a line width. Thresholds mean the same for any width.
// - Samples lie between pixels, so they are bilinear.
// - The distance to the line is that from the pixel to where the first fit sees the line, or the last one, whichever is
//   less. On a flank the first fit is too far off by up to a half (a parabola knows no inflection), and what the search finds
//   on its way is right. On an edge the line runs away from the search, and only the first fit says where it is drawn.
// - Lines are anti-aliased: half of their ink lies at half their width, and they end within a pixel. `softness` fades them
//   from within as the paper does.
// - "The other curvature is sufficiently small" (section 3.1, and not in 3.2) is a choice, for it takes spots away and
//   opens crossings: see `roundest`.
// - A fit that reaches where no surface is near has its own tone there.
//
// SPECULAR: the specular channel has highlight lines, too.
#import hachure::view::View

struct Search {
    // Curvatures from which lines begin, and at which they are full; for highlight lines, too.
    dark_ramp: vec2<f32>,
    highlight_ramp: vec2<f32>,
    beta: f32,
    // Part of half a line's width over which its ink fades.
    softness: f32,
    counterchange: f32,
    // The lesser curvature may be this part of the greater one; 1 and more is no bound.
    roundest: f32,
    // 1: they are drawn.
    has_dark: u32,
    has_highlights: u32,
    // 1: a style without a sky that is white.
    is_sky_toneless: u32,
    pad: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> search: Search;
// For its last channel: 1 is surface.
@group(0) @binding(2) var tone_image: texture_2d<f32>;
// r: diffuse tone; g: specular; b: width of lines in pixels; a: which part of what is around is surface.
@group(0) @binding(3) var blurred: texture_2d<f32>;
@group(0) @binding(4) var tone_sampler: sampler;
// r: ink of dark lines; g: ink of highlight lines; b, a: cosine and sine of twice the angle of the line, so that both ways
// along it are one and a mean of neighbours has a meaning.
@group(0) @binding(5) var tone_ink: texture_storage_2d<rgba16float, write>;

const STEPS: i32 = 5;
// Surface that is less of what is around has no tone to speak of.
const LEAST_SURFACE: f32 = 0.01;

struct Fit {
    // The greater curvature, its direction, and the slope along it.
    curvature: f32,
    other: f32,
    across: vec2<f32>,
    slope: f32,
}

fn tone_at(place_px: vec2<f32>, channel: u32, own: f32) -> f32 {
    let texel = textureSampleLevel(blurred, tone_sampler, place_px / vec2<f32>(view.size_px), 0.0);
    let is_there = search.is_sky_toneless == 0u || texel.a > LEAST_SURFACE;
    return select(own, select(texel.r, texel.g, channel == 1u), is_there);
}

// The fit around a place, in units of the samples' spacing. Beside the border it is that of the nearest place whose samples
// lie in the picture: its slope goes on to the place as its curvature says.
fn fit(asked_px: vec2<f32>, spacing_px: f32, channel: u32, own: f32) -> Fit {
    let size_px = vec2<f32>(view.size_px);
    let first_px = min(vec2<f32>(spacing_px + 0.5), 0.5 * size_px);
    let place_px = clamp(asked_px, first_px, size_px - first_px);
    let beyond = (asked_px - place_px) / spacing_px;
    let x = vec2<f32>(spacing_px, 0.0);
    let y = vec2<f32>(0.0, spacing_px);
    // Columns from left to right.
    let left = vec3<f32>(tone_at(place_px - x - y, channel, own), tone_at(place_px - x, channel, own), tone_at(place_px - x + y, channel, own));
    let middle = vec3<f32>(tone_at(place_px - y, channel, own), tone_at(place_px, channel, own), tone_at(place_px + y, channel, own));
    let right = vec3<f32>(tone_at(place_px + x - y, channel, own), tone_at(place_px + x, channel, own), tone_at(place_px + x + y, channel, own));
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
    // Of (a0 a1; a1 a2) - curvature the longer of two rows says the direction; where both are 0 any does.
    let one = vec2<f32>(curvature - a2, a1);
    let two = vec2<f32>(a1, curvature - a0);
    let longer = select(two, one, dot(one, one) >= dot(two, two));
    let squared = dot(longer, longer);
    let across = select(vec2<f32>(1.0, 0.0), longer * inverseSqrt(max(squared, 1e-30)), squared > 1e-20);
    return Fit(curvature, mean - side * radius, across, dot(gradient, across) + 2.0 * curvature * dot(beyond, across));
}

struct Line {
    // Of a dark line, and of a highlight line.
    ink: vec2<f32>,
    // Cosine and sine of twice its angle.
    direction: vec2<f32>,
}

// The line at a pixel, by one channel. There is one fit in one loop, and the loop ends when no pixel of a group goes on:
// drivers that run both sides of a branch have little to do where there are no lines.
fn line_of(place_px: vec2<f32>, width_px: f32, channel: u32, tone: f32) -> Line {
    let spacing_px = 0.5 * width_px;
    var at_px = place_px;
    var travelled_px = 0.0;
    var first_px = 0.0;
    var is_dark = false;
    var is_line = true;
    var ramp = vec2<f32>(0.0);
    var seen = Fit(0.0, 0.0, vec2<f32>(1.0, 0.0), 0.0);
    for (var i = 0; i <= STEPS && is_line; i++) {
        seen = fit(at_px, spacing_px, channel, tone);
        let way_px = -spacing_px * seen.slope / (2.0 * select(seen.curvature, 1e-12, abs(seen.curvature) < 1e-12));
        if i == 0 {
            is_dark = seen.curvature > 0.0;
            ramp = max(select(search.highlight_ramp, search.dark_ramp, is_dark), vec2<f32>(1e-4, 2e-4));
            first_px = abs(way_px);
            is_line = select(search.has_highlights, search.has_dark, is_dark) == 1u && !(is_dark && channel == 1u);
        }
        is_line = is_line && select(-1.0, 1.0, is_dark) * seen.curvature >= ramp.x;
        if i < STEPS {
            at_px += search.beta * way_px * seen.across;
            travelled_px += search.beta * abs(way_px);
            is_line = is_line && travelled_px <= 0.5 * width_px;
        }
    }
    let by_curvature = saturate((abs(seen.curvature) - ramp.x) / max(ramp.y - ramp.x, 1e-6));
    let rest_px = -spacing_px * seen.slope / (2.0 * select(seen.curvature, 1e-12, abs(seen.curvature) < 1e-12));
    let away_px = min(first_px, length(at_px + rest_px * seen.across - place_px));
    let covered = saturate(0.5 * width_px - away_px + 0.5);
    let faded = 1.0 - search.softness * smoothstep(1.0 - search.softness, 1.0, 2.0 * away_px / width_px);
    let round = smoothstep(0.5 * search.roundest, search.roundest, seen.other / select(seen.curvature, 1.0, seen.curvature == 0.0));
    let is_long = select(1.0 - round, 1.0, search.roundest >= 1.0);
    let against = mix(1.0, select(tone, 1.0 - tone, is_dark), search.counterchange);
    let ink = select(0.0, saturate(by_curvature * covered * faded * is_long * saturate(against)), is_line);
    let u = seen.across;
    let direction = select(vec2<f32>(0.0), vec2<f32>(u.y * u.y - u.x * u.x, -2.0 * u.x * u.y), ink > 0.0);
    return Line(select(vec2<f32>(0.0, ink), vec2<f32>(ink, 0.0), is_dark), direction);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    if textureLoad(tone_image, pixel, 0).a <= 0.0 {
        textureStore(tone_ink, pixel, vec4<f32>(0.0));
        return;
    }
    let own = textureLoad(blurred, pixel, 0);
    let place_px = vec2<f32>(pixel) + 0.5;
    var line = line_of(place_px, own.b, 0u, own.r);
#ifdef SPECULAR
    // Highlights stand out from what is around them, whatever its diffuse tone.
    let highlight = line_of(place_px, own.b, 1u, own.g);
    if highlight.ink.y > line.ink.y {
        line = Line(vec2<f32>(line.ink.x, highlight.ink.y), highlight.direction);
    }
#endif
    textureStore(tone_ink, pixel, vec4<f32>(line.ink, line.direction));
}
