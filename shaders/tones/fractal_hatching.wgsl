// Hatching by the fractal rule: approaching only ever adds marks, and never removes one (surface-stable fractal
// dithering: Johansen 2025, there for dots of a regular pattern).
//
// Along an axis of a chart, grid points for marks are the multiples of a length that is halved from level to level.
// Every second grid point of a level also belongs to the coarser one, so a mark belongs to the coarsest level that has
// it. Its *rank* is the density of marks from which on it exists: between half of its level's density and all of it, in
// an even order. Since marks have a constant width on the picture, a darkness corresponds to a density on the picture,
// which is a greater density on the ground when the eye is near: new marks come between the existing ones, and those
// stay.
//
// Dots are not at the multiples themselves. A cell between two multiples holds one dot, which stays when the cell is
// halved: it is in the half that the numbers of the surrounding cells choose (nested scrambling: Owen 1995). So a dot's
// position is fixed in the world and is in its cell at every level, and only nearby cells have to be searched.
//
// Dots of the kind `dots` (the variant `DOTS`) keep apart from each other, as described in dots.wgsl.
//
// Code for marks with ends is a variant (`ENDED`), because software drivers run both sides of a branch.
//
// Rows of marks are selected this way across, and the marks of a row along it, each axis with its own foreshortening.
// The offset of a row's marks is a digital net of the rows' numbers, so that neighbouring rows have different offsets.
// As long as neighbours do not touch, the inked part is exactly width times density. Once the gaps are filled in, all
// widths grow such that the inked part remains the requested darkness, up to black.
#import hachure::power::power
#import hachure::hatch::{HatchLayer, Footprint, change_along, divide, charts_at}
#import hachure::hatched_surface::{hatched_surface, view, hatch, axes, distance_m}
#ifdef DOTS
#import hachure::dots::{DotAxis, distance_px, dot_at, ink_of_dot}
#import hachure::hatch::{footprint, DOTS}
#import hachure::view::ray_of_pixel
#endif
#import hachure::seen::place_seen
#import hachure::cover::{Cover, united, texel_of, growth_of_share}

// Range over which a mark grows, relative: it is whole at a density this much above its rank, and begins as much below.
const GROWTH: f32 = 0.12;
// How much wider dots have to be to compensate for overlaps.
const LOST: f32 = 0.075;
// Levels below a row's own that affect its offset.
const FINER_BITS: i32 = 6;
const IDENTITY_BITS: u32 = 0xfffffu;

// The camera's position on an axis, in grid points of a level.
struct Cell {
    index: i32,
    rest: f32,
}

// Level by level for each axis.
@group(0) @binding(8) var<storage, read> cells: array<Cell>;
// See `texel_of`.
@group(0) @binding(9) var cover: texture_storage_2d<rgba16float, write>;

fn mixed_bits(value: u32) -> u32 {
    var v = value * 747796405u + 2891336453u;
    v = ((v >> ((v >> 28u) + 4u)) ^ v) * 277803737u;
    return (v >> 22u) ^ v;
}

// Returns mixed bits, each of which depends only on itself and the higher ones.
fn stirred(number: u32) -> u32 {
    let t = number ^ ((number >> 1u) & (number >> 4u)) ^ (number >> 5u) ^ ((number >> 2u) | (number >> 7u));
    return t ^ ((t >> 1u) & (t >> 3u)) ^ (t >> 2u);
}

// Returns which half of a cell keeps its mark, by the cell's number: the lowest bit is for the cell itself, the others
// are for the cells that contain it. In three of four cases it is not the half that the cell itself is in its parent: a
// mark is seldom near the end of its cell, where the next cell's mark might be.
fn kept_halves(cells: u32) -> u32 {
    return ~cells ^ (((cells >> 1u) ^ (cells >> 4u)) & ((cells >> 2u) ^ (cells >> 7u)));
}

// Returns the position of a cell's mark in it, 0 to 1: the halves that keep it, four times.
fn place_in_cell(index: i32) -> f32 {
    var halves = bitcast<u32>(index) << 4u;
    halves |= kept_halves(halves >> 1u) & 8u;
    halves |= kept_halves(halves >> 1u) & 4u;
    halves |= kept_halves(halves >> 1u) & 2u;
    halves |= kept_halves(halves >> 1u) & 1u;
    return (f32(halves & 15u) + 0.5) / 16.0;
}

// The request to an axis: the grid points of its level, and which of them have marks of which width.
struct Asked {
    level: i32,
    place_m: f32,
    place_px: f32,
    // Density; marks of a lower rank exist.
    density: f32,
    width_px: f32,
}

// Returns the request for marks of width `width_px` at darkness d of this axis alone. Loose marks are anywhere in their
// cells and overlap; for them a d above 1 requests wider ones.
fn asked(axis: i32, foot: Footprint, width_px: f32, d: f32, is_loose: bool) -> Asked {
    let per_px = max(length(change_along(axes[axis].direction, foot)), 1e-9);
    // At d = 1 there is one mark per width; the level has up to twice as many grid points.
    let wanted = log2(width_px * per_px) - f32(hatch.first_level);
    let level = clamp(floor(wanted), 0.0, f32(hatch.level_count - 1));
    let place_m = exp2(level + f32(hatch.first_level));
    let place_px = place_m / per_px;
    let density = min(d, 1.0) * place_px / width_px;
    // With marks at more than every second grid point, gaps are two grid points wide or filled, and filled ones
    // overlap. The bare part of the paper is 1 - d, all in the gaps.
    let unfilled = 2.0 * (1.0 - density);
    let even_px = 2.0 * place_px * (1.0 - (1.0 - d) / max(unfilled, 1e-4));
    let wide_px = select(select(width_px, even_px, density > 0.5), min(width_px * d * d, 2.0 * place_px), is_loose);
    return Asked(i32(level), place_m, place_px, density, max(wide_px, width_px));
}

// A mark of an axis: its identity, its own level relative to the current one, and its current width.
struct Mark {
    identity: u32,
    // Its position in an even order of its level, as a part of 2^32.
    order: u32,
    coarser: i32,
    width_px: f32,
}

// Returns the mark of a grid point of a level. `kept` has a bit for each coarser level: 0 where it is that level's mark
// too.
fn mark_at(index: i32, kept: u32, row: Asked, seed: u32) -> Mark {
    let bits = bitcast<u32>(index);
    let coarser = min(i32(select(countTrailingZeros(kept), 31u, kept == 0u)), hatch.level_count - 1 - row.level);
    let number = (bits >> u32(coarser)) & IDENTITY_BITS;
    let own_level = u32(row.level + coarser);
    let identity = mixed_bits(number ^ (own_level << 20u) ^ seed);
    // Neighbours of one level come in an even order: multiples of the golden ratio. The number is odd.
    let order = (number >> 1u) * 2654435769u + mixed_bits(own_level ^ seed);
    let rank = exp2(-f32(coarser)) * (0.5 + 0.5 * f32(order >> 8u) / 16777216.0);
    let grown = clamp((row.density / rank - 1.0) / (2.0 * GROWTH) + 0.5, 0.0, 1.0);
    // A mark that grows in a gap narrower than a mark fills just the gap.
    let gap_px = clamp(exp2(f32(coarser) + 1.0) * row.place_px - row.width_px, 0.0, row.width_px);
    let whole_px = mix(gap_px, row.width_px, smoothstep(0.9, 1.0, grown));
    return Mark(identity, order, coarser, whole_px * grown);
}

// Returns unclamped ink at a distance from the centre line of a mark.
fn profile(away_px: f32, width_px: f32) -> f32 {
    return min(width_px, 1.0) * (0.5 * max(width_px, 1.0) - abs(away_px) + 0.5);
}

fn chart_cover(layer: HatchLayer, seed: u32, across: i32, along: i32, darkness: f32, at: vec3<f32>, foot: Footprint) -> Cover {
    let size_px = layer.marks_px * layer.size;
    let is_endless = layer.marks_px.x <= 0.0;
    let is_dot = !is_endless && size_px.x <= size_px.y;
    // Both axes together make the darkness: the longer the marks, the more of it is due to rows. Rows of dots touch and
    // have few dots each, or they would be visible as rows; and where it is dark, dots overlap.
    let by_rows = select(select(min(size_px.x / (size_px.x + size_px.y), 0.75), 0.25 * (1.0 - darkness), is_dot), 1.0, is_endless);
    let lost = select(1.0, 1.0 + LOST * darkness * inverseSqrt(1.0 - darkness), is_dot);
    let row = asked(across, foot, size_px.y, lost * power(darkness, by_rows), is_dot);
    let base_u = cells[across * hatch.level_count + row.level];
    let u = base_u.rest + dot(axes[across].direction, at) / row.place_m;
    let nearest_u = round(u);
#ifdef ENDED
    let dash = asked(along, foot, max(size_px.x, 1.0), lost * power(darkness, 1.0 - by_rows), is_dot);
    let base_v = cells[along * hatch.level_count + dash.level];
    let v = base_v.rest + dot(axes[along].direction, at) / dash.place_m;
    // Round ends reduce ink; in dark tones ends are square.
    let roundness = clamp((0.6 - darkness) * 4.0, 0.0, 1.0);
    // A row's number is in units of a quarter of its marks' length.
    let row_power = row.level - dash.level + i32(round(log2(max(size_px.x, 1e-3) / size_px.y))) + 2 - FINER_BITS;
#endif
    var ink = 0.0;
    var reach = -1.0;
    var reaching_px = 0.0;
    for (var i = -1; i <= 1; i++) {
        let row_index = base_u.index + i32(nearest_u) + i;
        let row_mark = mark_at(row_index, bitcast<u32>(row_index), row, seed);
        let away_px = (u - nearest_u - f32(i)) * row.place_px;
        let width_px = row_mark.width_px;
        var drawn = profile(away_px, width_px);
        var best = drawn;
#ifdef ENDED
        if !is_endless && drawn > -0.5 {
            // Each row's marks have a different offset: its number, times x^-2 + x^-6 + ... as polynomials over bits.
            let number = (bitcast<u32>(row_index) >> u32(row_mark.coarser)) << u32(FINER_BITS);
            let mixed = number ^ stirred(number >> 1u);
            let part = (mixed ^ (mixed >> 2u) ^ (mixed >> 6u)) & 0x3fffu;
            let power = row_mark.coarser + row_power;
            let shift = select(f32(part) * exp2(f32(power)), 0.0, power >= 0);
            let whole_shift = select(0, i32(part << u32(clamp(power, 0, 31))), power >= 0);
            let place = v + shift;
            let cell_v = select(round(place), floor(place), is_dot);
            let first_v = base_v.index + whole_shift + i32(cell_v);
            let end_px = roundness * 0.5 * width_px * (1.0 - sqrt(max(1.0 - 4.0 * away_px * away_px / max(width_px * width_px, 1e-6), 0.0)));
            let longer_px = roundness * 0.215 * width_px - 2.0 * end_px;
            var on_row = 0.0;
            best = -1.0;
            for (var j = -1; j <= 1; j++) {
                let bits = bitcast<u32>(first_v + j);
                let mark = mark_at(first_v + j, bits ^ select(0u, kept_halves(bits >> 1u), is_dot), dash, row_mark.identity);
                let along_px = (place - cell_v - f32(j) - select(0.0, place_in_cell(first_v + j), is_dot)) * dash.place_px;
                let one = profile(along_px, max(mark.width_px + select(0.0, longer_px, mark.width_px > 0.0), 0.0));
                on_row = min(on_row + clamp(one, 0.0, 1.0), 1.0);
                best = max(best, select(-1.0, one, mark.width_px > 0.05));
            }
            best = min(drawn, best);
            drawn = clamp(drawn, 0.0, 1.0) * on_row;
        }
#endif
        // A mark that does not exist yet cannot grow to balance the tone.
        if width_px > 0.05 && best > reach {
            reach = best;
            reaching_px = min(width_px, 1.0);
        }
        // Two marks in one pixel are next to each other.
        ink = min(ink + clamp(drawn, 0.0, 1.0), 1.0);
    }
    // Both borders of a mark move: width / darkness is the distance between marks, or nearly so if they have ends.
    return Cover(ink, reach, 0.5 * reaching_px * size_px.y / max(darkness, 0.05));
}

#ifdef DOTS
fn dot_axis(axis: i32, at: vec3<f32>, foot: Footprint, own: Footprint, apart_px: f32) -> DotAxis {
    let direction = axes[axis].direction;
    let apart_m = apart_px * max(length(change_along(direction, foot)), 1e-9);
    let level = clamp(floor(log2(apart_m) - f32(hatch.first_level)), 0.0, f32(hatch.level_count - 1));
    let place_m = exp2(level + f32(hatch.first_level));
    let base = cells[axis * hatch.level_count + i32(level)];
    let u = base.rest + dot(direction, at) / place_m;
    let nearest = round(u);
    return DotAxis(base.index + i32(nearest), i32(level), u - nearest, clamp(apart_m / place_m, 1.0, 2.0),
        change_along(direction, own) / place_m);
}

// Dots of the kind `dots`. The chart's scale is that of the form, and dots are round on the land itself. A dot belongs
// to the chart with the greater weight at the dot's centre: no two charts show dots at one place.
fn dots_cover(index: i32, darkness: f32, at: vec3<f32>, n: vec3<f32>, line: vec2<f32>, foot: Footprint, own: Footprint) -> Cover {
    let layer = hatch.layers[index];
    let charts = charts_at(layer, index, n, at, line);
    let width_px = layer.marks_px.y * layer.size;
    let apart_px = distance_px(darkness, width_px);
    var ink = 0.0;
    var k = i32(charts.second >= 0.6);
    let last = i32(charts.second > 0.4);
    loop {
        let u = dot_axis(charts.along[k], at, foot, own, apart_px);
        let v = dot_axis(charts.across[k], at, foot, own, apart_px);
        for (var i = 0; i < 9; i++) {
            let one = dot_at(u, v, vec2<i32>(i % 3 - 1, i / 3 - 1), darkness, width_px, u32(index * 7919 + charts.along[k] * 131));
            var drawn = ink_of_dot(one, darkness);
            if drawn > 0.0 && last != i32(charts.second >= 0.6) {
                let there = charts_at(layer, index, n, at + own.dx * one.away_px.x + own.dy * one.away_px.y, line);
                drawn = select(0.0, drawn, (there.second >= 0.5) == (k == 1));
            }
            ink = max(ink, drawn);
        }
        k += 1;
        continuing {
            break if k > last;
        }
    }
    return Cover(ink, ink, 0.0);
}
#endif

fn layer_cover(index: i32, darkness: f32, at: vec3<f32>, n: vec3<f32>, line: vec2<f32>, foot: Footprint, own: Footprint) -> Cover {
    let layer = hatch.layers[index];
#ifdef DOTS
    if (layer.flags & DOTS) != 0u {
        return dots_cover(index, darkness, at, n, line, foot, own);
    }
#endif
    let charts = charts_at(layer, index, n, at, line);
    var cover = Cover(0.0, -1e3, 0.0);
    let is_endless = layer.marks_px.x <= 0.0;
    var k = i32(charts.second >= 1.0);
    let last = i32(charts.second > 0.0);
    loop {
        // Two charts share the density, so that their marks together make the darkness.
        let share = select(1.0 - charts.second, charts.second, k == 1);
        let asked_here = 1.0 - power(1.0 - darkness, share);
        cover = united(cover, chart_cover(layer, u32(index * 7919) + select(u32(charts.along[k] * 131), 0u, is_endless), charts.across[k], charts.along[k], asked_here, at, foot));
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
    let at = place_seen(view, distance_m, pixel);
    if at.w <= 0.0 {
        textureStore(cover, pixel, vec4<f32>(0.0));
        return;
    }
    let surface = hatched_surface(pixel, at);
    let n = surface.normal;
#ifdef DOTS
    // Marks treat trees as flat.
    let own = footprint(view, ray_of_pixel(view, pixel), at.w, select(n, surface.own.xyz, surface.own.w == 1.0));
#else
    let own = surface.foot;
#endif
    let shares = divide(hatch, surface.darkness, length(n.xy));
    var all = Cover(0.0, -1e3, 0.0);
    for (var i = 0u; i < hatch.count; i++) {
        if shares[i] > 0.0 && ((hatch.drawn >> i) & 1u) != 0u {
            let one = layer_cover(i32(i), min(shares[i], 0.9999), at.xyz, n, surface.line, surface.foot, own);
            all = united(all, Cover(one.ink, one.reach, one.rise * growth_of_share(shares[i], surface.darkness)));
        }
    }
    textureStore(cover, pixel, texel_of(all, surface.darkness));
}
