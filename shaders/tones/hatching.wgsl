// Hatching: marks that are fixed in the world and keep their size on the picture.
//
// A layer's marks are a tonal art map (Praun et al. 2001), stored as one tile of thresholds: a place takes ink where
// the darkness is above its threshold. The tile is mapped on a chart of the world (`hatch`), at the level of a ladder
// of scales at which one texel is about one pixel: a dynamic solid texture (Benard et al. 2009). Additions:
//
// - Scales are half octaves apart, and across and along the marks they are chosen separately, each by the gradient of
//   its coordinate on the picture. So marks keep spacing and length at grazing angles too.
// - Inks of two scales are not blended. Marks that darken by number overlap those of the other scale, and both share
//   the darkness as optical density: a scale with the weight w takes 1 - (1 - darkness)^w of it. So marks stay sharp,
//   and those of one scale become fewer while those of the other become more. Marks that swell would be thin twice; for
//   them the thresholds are mixed, and made uniform again by the exact distribution of the mixture.
// - Scales of one axis have different offsets on the other for each level, so that two never show the same marks:
//   shares of darkness assume independent marks.
// - With SWELLING there may be marks that swell; without it their code is omitted.
// - Phases come from the CPU in f64, one for each axis and scale.
#import hachure::seen::place_seen
#import hachure::hatch::{HatchLayer, Footprint, change_along, divide, charts_at, ENDLESS, SWELLS}
#import hachure::hatched_surface::{hatched_surface, view, hatch, axes, distance_m}
#import hachure::cover::{Cover, united, turned, texel_of, growth_of_share}

// Part of the interval between two scales in which both are drawn: across, and along.
const ACROSS_ZONE: f32 = 0.6;
const ALONG_ZONE: f32 = 0.5;
const HALF_OCTAVE: f32 = 0.70710678;
const GOLDEN: f32 = 0.38196601;
// Least border of a mark, in thresholds: four quantisation steps, without which a line that begins would be dotted.
const MIN_BORDER: f32 = 0.016;

// The camera's position on each axis, in texels of each level: level by level for each axis.
@group(0) @binding(8) var<storage, read> phases: array<f32>;
// Tile by tile, row by row, for each texel the four thresholds around it (this, along, across, both) and the gradient
// of thresholds there, for ink and for gaps: square roots in half bytes.
@group(0) @binding(9) var<storage, read> maps: array<vec2<u32>>;
// See `texel_of`.
@group(0) @binding(10) var cover: texture_storage_2d<rgba16float, write>;

// A threshold, and the width of a border of one pixel, in thresholds.
struct Threshold {
    value: f32,
    border: f32,
}

// Returns the threshold of a map's tile at a position in texels, where a pixel is `texels` wide; inverted in dark
// tones.
fn tile_threshold(map: u32, place: vec2<f32>, texels: f32, is_dark: bool) -> Threshold {
    let whole = floor(place);
    let f = place - whole;
    let cell = vec2<u32>(vec2<i32>(whole)) & vec2<u32>(hatch.side - 1u);
    let quads = maps[(map * hatch.side + cell.y) * hatch.side + cell.x];
    let weights = vec4<f32>((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y);
    let roots = unpack4x8unorm((quads.y >> select(0u, 4u, is_dark)) & 0x0f0f0f0fu) * 17.0;
    let value = dot(unpack4x8unorm(quads.x), weights);
    return Threshold(select(value, 1.0 - value, is_dark), dot(roots * roots, weights) * texels);
}

#ifdef SWELLING
// Mixes two thresholds by weight w into one that is uniform again: through the distribution function of (1 - w) A + w B
// for independent uniform A and B.
fn mixed(first: Threshold, second: Threshold, w: f32) -> Threshold {
    let x = mix(first.value, second.value, w);
    let b = min(w, 1.0 - w);
    let a = 1.0 - b;
    let near = min(x, 1.0 - x);
    let corner = max(a * b, 1e-6);
    let inner = near >= b;
    let below = select(0.5 * near * near / corner, (near - 0.5 * b) / a, inner);
    let rise = select(near / corner, 1.0 / a, inner);
    return Threshold(select(below, 1.0 - below, x > 0.5), mix(first.border, second.border, w) * rise);
}
#endif

// Returns the ink where `darkness` meets a threshold. `growth` is the derivative of this darkness with respect to the
// requested one.
fn cover_at(found: Threshold, darkness: f32, growth: f32, layer: HatchLayer) -> Cover {
    let border = max(max(found.border, hatch.softness), MIN_BORDER);
    // No ink on white paper, and no gap in black.
    let edge = 0.5 * border * (max(1.0 - darkness / 0.03, 0.0) - max(1.0 - (1.0 - darkness) / 0.03, 0.0));
    let reach = (darkness - edge - found.value) / border + 0.5;
    let ink = mix(clamp(reach, 0.0, 1.0), darkness, layer.grey);
    return Cover(ink, select(reach, ink, layer.grey > 0.0), growth * mix(1.0 / border, 1.0, layer.grey));
}

// A coordinate at a place: its change per pixel in metres, the finer level of the ladder with its texels per metre, the
// weight of the coarser level, and the coordinate itself.
struct Scale {
    change_m: f32,
    texels_per_m: f32,
    coarser: f32,
    // The finer level, and its index in `phases`.
    level: i32,
    phase: i32,
    place_m: f32,
}

fn scale_of(axis: i32, at: vec3<f32>, foot: Footprint, size: f32, zone: f32) -> Scale {
    let direction = axes[axis].direction;
    let d = change_along(direction, foot);
    let step = log2(max(dot(d, d) * size * size, 1e-24)) - f32(hatch.first_level);
    let bounded = clamp(step, 0.0, f32(hatch.level_count) - 1.001);
    let whole = floor(bounded);
    return Scale(sqrt(dot(d, d)), exp2(-0.5 * (whole + f32(hatch.first_level))), clamp((bounded - whole - 0.5) / zone + 0.5, 0.0, 1.0),
        i32(whole), axis * hatch.level_count + i32(whole), dot(direction, at));
}

// Returns the ink of a layer.
fn layer_cover(index: i32, asked: f32, growth: f32, at: vec3<f32>, n: vec3<f32>, line: vec2<f32>, foot: Footprint) -> Cover {
    let layer = hatch.layers[index];
    let charts = charts_at(layer, index, n, at, line);
    let side = f32(hatch.side);
    let offset = f32(index) * GOLDEN * side;
    let is_dark = asked > 0.5;
    let darkness = min(asked, 1.0 - asked);
    let density = log2(max(1.0 - darkness, 1e-5));
    let is_endless = (layer.flags & ENDLESS) != 0u;
#ifdef SWELLING
    let swells = (layer.flags & SWELLS) != 0u;
#endif
    // Two charts, each with the finer and the coarser scale of its two coordinates; combinations without weight are
    // skipped. Loops are tested at their end: software drivers run both sides of a branch.
    var cover = Cover(0.0, -1e3, 0.0);
    var k = select(0, 1, charts.second >= 1.0);
    let last = select(0, 1, charts.second > 0.0);
    loop {
        // Not by index, which is slow on software drivers.
        let along = select(charts.along.x, charts.along.y, k == 1);
        let u = scale_of(select(charts.across.x, charts.across.y, k == 1), at, foot, layer.size, ACROSS_ZONE);
        var v = scale_of(along, at, foot, layer.size, ALONG_ZONE);
        if is_endless {
            // A line without ends has no length to preserve, so it uses the scale across.
            v.phase = v.phase + u.level - v.level;
            v.texels_per_m = u.texels_per_m;
            v.coarser = 0.0;
        }
        let chart_weight = select(1.0 - charts.second, charts.second, k == 1);
        let chart_density = density * chart_weight;
        let chart_growth = growth * chart_weight / (1.0 - darkness);
        // Rows have a different offset for each axis along them, as for each level.
        let row_offset = fract(f32(along) * GOLDEN) * side;
        let first_u = select(0, 1, u.coarser >= 1.0);
        let last_u = select(0, 1, u.coarser > 0.0);
        let last_v = select(0, 1, v.coarser > 0.0);
        var i = first_u;
        var j = select(0, 1, v.coarser >= 1.0);
#ifdef SWELLING
        var row_weight = 0.0;
        var all_weight = 0.0;
        var row: Threshold;
        var all: Threshold;
#endif
        loop {
            let scale_u = select(u.texels_per_m, u.texels_per_m * HALF_OCTAVE, i == 1);
            let own_v = select(j, i, is_endless);
            let scale_v = select(v.texels_per_m, v.texels_per_m * HALF_OCTAVE, own_v == 1);
            let elsewhere = fract(vec2<f32>(f32(u.level + i), select(f32(v.level + j), 0.0, is_endless)) * GOLDEN) * side;
            let place = vec2<f32>(phases[v.phase + own_v] + v.place_m * scale_v, phases[u.phase + i] + u.place_m * scale_u);
            let one = tile_threshold(layer.map, place + elsewhere + vec2<f32>(offset, offset + select(row_offset, 0.0, is_endless)), u.change_m * scale_u, is_dark);
            let weight = select(1.0 - u.coarser, u.coarser, i == 1) * select(1.0 - v.coarser, v.coarser, j == 1);
            let own = 1.0 - exp2(chart_density * weight);
            let added = united(cover, cover_at(one, own, chart_growth * weight * (1.0 - own), layer));
#ifdef SWELLING
            // The first one is mixed with nothing.
            row = mixed(one, row, row_weight);
            row_weight = 1.0 - u.coarser;
            if !swells {
                cover = added;
            }
#else
            cover = added;
#endif
            i += 1;
            if i > last_u {
#ifdef SWELLING
                all = mixed(row, all, all_weight);
                all_weight = 1.0 - v.coarser;
                row_weight = 0.0;
#endif
                i = first_u;
                j += 1;
            }
            continuing {
                break if j > last_v;
            }
        }
#ifdef SWELLING
        if swells {
            let own = 1.0 - exp2(chart_density);
            cover = united(cover, cover_at(all, own, chart_growth * (1.0 - own), layer));
        }
#endif
        k += 1;
        continuing {
            break if k > last;
        }
    }
    let gaps = turned(cover);
    return Cover(select(cover.ink, gaps.ink, is_dark), select(cover.reach, gaps.reach, is_dark), cover.rise);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let at = place_seen(view, distance_m, pixel);
    if at.w <= 0.0 {
        textureStore(cover, pixel, vec4<f32>(0.0));
        return;
    }
    let surface = hatched_surface(pixel, at);
    var shares = divide(hatch, surface.darkness, length(surface.normal.xy));
    var all = Cover(0.0, -1e3, 0.0);
    for (var i = 0u; i < hatch.count; i++) {
        if shares.x > 0.0 && ((hatch.drawn >> i) & 1u) != 0u {
            let growth = growth_of_share(shares.x, surface.darkness);
            all = united(all, layer_cover(i32(i), shares.x, growth, at.xyz, surface.normal, surface.line, surface.foot));
        }
        shares = shares.yzwx;
    }
    textureStore(cover, pixel, texel_of(all, surface.darkness));
}
