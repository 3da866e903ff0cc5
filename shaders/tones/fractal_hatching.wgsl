// Hatching by the zoom rule: coming nearer only ever adds marks, and never removes one (surface-stable fractal
// dithering: Johansen 2025, there for dots of a regular pattern).
//
// Along an axis of a chart, places for marks are the multiples of a length that is halved from level to level: every
// second place of a level is a place of the coarser one already, so a mark belongs to the coarsest level that has it.
// Its *rank* is the density of marks from which on it is there: between half of its level's and all of it, in an even
// order. Since a mark's width is one on the picture, a darkness asks for a density on the picture, and nearness makes
// that a larger one on the ground: marks come between those that are there, and those stay.
//
// Rows of marks are chosen so across, and the marks of a row along it, each axis at its own foreshortening. As long as
// neighbours do not touch, the inked part is width times density, exactly. When the gaps are filled in, the width of
// all grows such that the inked part remains the darkness that was asked for, up to black.
#import hachure::view::{View, ray_of_pixel}
#import hachure::form::form_at
#import hachure::hatch::{Hatch, HatchLayer, Footprint, footprint, change_along, divide, charts_at}
#import hachure::cover::{Cover, united, texel_of, growth_of_share}

const AZIMUTH_ZONE: f32 = 0.5;
// How gradually a mark comes: it is whole at a density this much above its rank, and begins as much below.
const GROWTH: f32 = 0.12;
const IDENTITY_BITS: u32 = 0xfffffu;

struct Axis {
    direction: vec3<f32>,
    pad: f32,
}

// Where the camera is on an axis, in places of a level.
struct Cell {
    index: i32,
    rest: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> hatch: Hatch;
@group(0) @binding(2) var<storage, read> axes: array<Axis>;
// Level by level for each axis.
@group(0) @binding(3) var<storage, read> cells: array<Cell>;
@group(0) @binding(4) var position: texture_2d<f32>;
@group(0) @binding(5) var normal: texture_2d<f32>;
@group(0) @binding(6) var form: texture_2d<f32>;
@group(0) @binding(7) var tone: texture_2d<f32>;
// See `texel_of`.
@group(0) @binding(8) var cover: texture_storage_2d<rgba16float, write>;

fn mixed_bits(value: u32) -> u32 {
    var v = value * 747796405u + 2891336453u;
    v = ((v >> ((v >> 28u) + 4u)) ^ v) * 277803737u;
    return (v >> 22u) ^ v;
}

// What is asked of an axis: the places of its level, and which of them have marks of which width.
struct Asked {
    level: i32,
    place_m: f32,
    place_px: f32,
    // Ranks below this are there.
    density: f32,
    width_px: f32,
}

// Marks of width `width_px` on darkness d of this axis alone.
fn asked(axis: i32, foot: Footprint, width_px: f32, d: f32) -> Asked {
    let per_px = max(length(change_along(axes[axis].direction, foot)), 1e-9);
    // At d = 1 there is a mark for each width; the level has up to twice as many places.
    let wanted = log2(width_px * per_px) - f32(hatch.first_level);
    let level = clamp(floor(wanted), 0.0, f32(hatch.level_count - 1));
    let place_m = exp2(level + f32(hatch.first_level));
    let place_px = place_m / per_px;
    let density = d * place_px / width_px;
    // More than every second place: gaps are two places wide or filled, and what is filled overlaps. The rest of the
    // paper is the part 1 - d, all in the gaps.
    let unfilled = 2.0 * (1.0 - density);
    let wide_px = 2.0 * place_px * (1.0 - (1.0 - d) / max(unfilled, 1e-4));
    let drawn_px = select(width_px, max(wide_px, width_px), density > 0.5);
    return Asked(i32(level), place_m, place_px, density, drawn_px);
}

// A mark of an axis: who it is, its own level counted from the one that is looked at, and how much of it is there.
struct Mark {
    identity: u32,
    // Its place in an even order of its level, as a part of 2^32.
    order: u32,
    coarser: i32,
    width_px: f32,
}

fn mark_at(index: i32, row: Asked, seed: u32) -> Mark {
    let bits = bitcast<u32>(index);
    let coarser = min(i32(select(countTrailingZeros(bits), 31u, bits == 0u)), hatch.level_count - 1 - row.level);
    let number = (bits >> u32(coarser)) & IDENTITY_BITS;
    let own_level = u32(row.level + coarser);
    let identity = mixed_bits(number ^ (own_level << 20u) ^ seed);
    // Neighbours of one level come in an even order: multiples of the golden ratio. The number is odd.
    let order = (number >> 1u) * 2654435769u + mixed_bits(own_level ^ seed);
    let rank = exp2(-f32(coarser)) * (0.5 + 0.5 * f32(order >> 8u) / 16777216.0);
    let grown = clamp((row.density / rank - 1.0) / (2.0 * GROWTH) + 0.5, 0.0, 1.0);
    // What grows in a gap that is narrower than a mark fills just that.
    let gap_px = clamp(exp2(f32(coarser) + 1.0) * row.place_px - row.width_px, 0.0, row.width_px);
    let whole_px = mix(gap_px, row.width_px, smoothstep(0.9, 1.0, grown));
    return Mark(identity, order, coarser, whole_px * grown);
}

// Ink without bounds at a place `away_px` from the middle of a mark.
fn profile(away_px: f32, width_px: f32) -> f32 {
    return min(width_px, 1.0) * (0.5 * max(width_px, 1.0) - abs(away_px) + 0.5);
}

fn chart_cover(layer: HatchLayer, seed: u32, across: i32, along: i32, darkness: f32, at: vec3<f32>, foot: Footprint) -> Cover {
    let size_px = layer.marks_px * layer.size;
    let is_endless = layer.marks_px.x <= 0.0;
    // Both axes make the darkness together: the longer the marks, the more of it is done by rows.
    let by_rows = select(min(size_px.x / (size_px.x + size_px.y), 0.75), 1.0, is_endless);
    let row = asked(across, foot, size_px.y, pow(darkness, by_rows));
    let dash = asked(along, foot, max(size_px.x, 1.0), pow(darkness, 1.0 - by_rows));
    let base_u = cells[across * hatch.level_count + row.level];
    let base_v = cells[along * hatch.level_count + dash.level];
    let u = base_u.rest + dot(axes[across].direction, at) / row.place_m;
    let v = base_v.rest + dot(axes[along].direction, at) / dash.place_m;
    let nearest_u = round(u);
    // Round ends take ink; in the darks ends are square.
    let roundness = clamp((0.6 - darkness) * 4.0, 0.0, 1.0);
    var ink = 0.0;
    var reach = -1.0;
    var reaching_px = 0.0;
    for (var i = -1; i <= 1; i++) {
        let row_mark = mark_at(base_u.index + i32(nearest_u) + i, row, seed);
        let away_px = (u - nearest_u - f32(i)) * row.place_px;
        let width_px = row_mark.width_px;
        var drawn = profile(away_px, width_px);
        var best = drawn;
        if !is_endless && drawn > -0.5 {
            // Each row's marks begin somewhere else: by a part, in 256ths, of what a place of the row's own level is.
            let part = (row_mark.order * 5u) >> 24u;
            let power = row_mark.coarser + row.level - dash.level + i32(round(log2(size_px.x / size_px.y))) - 8;
            let shift = select(f32(part) * exp2(f32(power)), 0.0, power >= 0);
            let whole_shift = select(0, i32(part << u32(clamp(power, 0, 31))), power >= 0);
            let place = v + shift;
            let nearest_v = round(place);
            let first_v = base_v.index + whole_shift + i32(nearest_v);
            let end_px = roundness * 0.5 * width_px * (1.0 - sqrt(max(1.0 - 4.0 * away_px * away_px / max(width_px * width_px, 1e-6), 0.0)));
            let longer_px = roundness * 0.215 * width_px - 2.0 * end_px;
            var on_row = 0.0;
            best = -1.0;
            for (var j = -1; j <= 1; j++) {
                let mark = mark_at(first_v + j, dash, row_mark.identity);
                let along_px = (place - nearest_v - f32(j)) * dash.place_px;
                let one = profile(along_px, max(mark.width_px + select(0.0, longer_px, mark.width_px > 0.0), 0.0));
                on_row = min(on_row + clamp(one, 0.0, 1.0), 1.0);
                best = max(best, select(-1.0, one, mark.width_px > 0.05));
            }
            best = min(drawn, best);
            drawn = clamp(drawn, 0.0, 1.0) * on_row;
        }
        // A mark that has not come is not there to grow.
        if width_px > 0.05 && best > reach {
            reach = best;
            reaching_px = min(width_px, 1.0);
        }
        // Two marks that a pixel sees lie beside each other.
        ink = min(ink + clamp(drawn, 0.0, 1.0), 1.0);
    }
    // Both borders of a mark move: width / darkness is the distance of marks, or nearly so where they have ends.
    return Cover(ink, reach, 0.5 * reaching_px * size_px.y / max(darkness, 0.05));
}

fn layer_cover(index: i32, darkness: f32, at: vec3<f32>, n: vec3<f32>, foot: Footprint) -> Cover {
    let layer = hatch.layers[index];
    let charts = charts_at(layer, index, n, at, AZIMUTH_ZONE);
    var cover = Cover(0.0, -1e3, 0.0);
    let is_endless = layer.marks_px.x <= 0.0;
    var k = i32(charts.second >= 1.0);
    let last = i32(charts.second > 0.0);
    loop {
        // Two charts share the density, so that their marks together make the darkness.
        let share = select(1.0 - charts.second, charts.second, k == 1);
        let own = 1.0 - pow(1.0 - darkness, share);
        cover = united(cover, chart_cover(layer, u32(index * 7919) + select(u32(charts.along[k] * 131), 0u, is_endless), charts.across[k], charts.along[k], own, at, foot));
        k += 1;
        continuing {
            break if k > last;
        }
    }
    return cover;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let at = textureLoad(position, pixel, 0);
    if at.w <= 0.0 {
        textureStore(cover, pixel, vec4<f32>(0.0));
        return;
    }
    let darkness = clamp(1.0 - textureLoad(tone, pixel, 0).a, 0.0, 1.0);
    let n = form_at(view, form, pixel, at, textureLoad(normal, pixel, 0).xyz);
    let foot = footprint(view, ray_of_pixel(view, pixel), at.w, n);
    let shares = divide(hatch, darkness, length(n.xy));
    var all = Cover(0.0, -1e3, 0.0);
    for (var i = 0u; i < hatch.count; i++) {
        if shares[i] > 0.0 {
            let one = layer_cover(i32(i), min(shares[i], 0.9999), at.xyz, n, foot);
            all = united(all, Cover(one.ink, one.reach, one.rise * growth_of_share(shares[i], darkness)));
        }
    }
    textureStore(cover, pixel, texel_of(all, darkness));
}
