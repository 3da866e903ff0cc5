// Round dots of one size that keep apart: marks of the kind `dots` under the fractal rule.
//
// Dots are at the grid points of both axes of a chart, each point displaced a little at random. The darkness determines
// the distance between dots on the picture, and each axis uses the level whose points are that far apart, or nearer by
// up to a half. Every second point of an axis belongs to the coarser level too and always has a dot; of the others as
// many have one as the density requires, in a random order. So a single set of dots serves all scales and tones.
// Several independent sets of different scales would overlap, because none would know its neighbours. Coming nearer or
// growing darker only adds dots.
//
// A dot is a disc on the picture around the projection of its centre.
#define_import_path hachure::dots
#import hachure::cover::Cover
#import hachure::hatch::{Footprint, change_along}

// Darkness up to which dots only come nearer to each other; beyond it they grow.
const DENSEST: f32 = 0.45;
// Range of a dot's order over which it grows from nothing to full size.
const COMES: f32 = 0.1;

// An axis at a position: the nearest grid point of its level.
struct DotAxis {
    index: i32,
    level: i32,
    // Offset of the position from that grid point, in grid points.
    rest: f32,
    // Distance between dots, in grid points: 1 to 2.
    apart: f32,
    // Change of the coordinate from pixel to pixel, right and down, in grid points.
    change: vec2<f32>,
}

// Returns the distance between dots on the picture that gives a darkness, in pixels.
fn distance_px(darkness: f32, width_px: f32) -> f32 {
    return width_px * sqrt(0.7853982 / clamp(darkness, 0.002, DENSEST));
}

fn stirred_bits(value: u32) -> u32 {
    var v = value * 747796405u + 2891336453u;
    v = ((v >> ((v >> 28u) + 4u)) ^ v) * 277803737u;
    return (v >> 22u) ^ v;
}

// Returns an identity of a grid point that is the same at every level that contains it: its odd index at its own level,
// and that level.
fn identity_of(index: i32, level: i32) -> u32 {
    let bits = bitcast<u32>(index);
    let coarser = select(countTrailingZeros(bits), 24u, (bits & 0xffffffu) == 0u);
    return ((bits >> coarser) & 0xffffffu) | (u32(level + i32(coarser)) << 24u);
}

// Shifts an axis for one row of dots, which is numbered by a grid point of the other axis. Each row has its own offset;
// without it dots would line up both ways.
fn of_row(u: DotAxis, row: u32) -> DotAxis {
    let part = stirred_bits(row) & 0x3fffu;
    let power = i32(row >> 24u) - u.level - 8;
    let whole = select(0, i32(part << u32(clamp(power, 0, 14))), power >= 0);
    let rest = u.rest + select(f32(part) * exp2(f32(power)), 0.0, power >= 0);
    let nearest = round(rest);
    return DotAxis(u.index + whole + i32(nearest), u.level, rest - nearest, u.apart, u.change);
}

// The dot of the grid point `step` from the nearest one.
struct Dot {
    // From the pixel to the dot's centre, in pixels.
    away_px: vec2<f32>,
    width_px: f32,
}

fn dot_at(all: DotAxis, v: DotAxis, step: vec2<i32>, darkness: f32, width_px: f32, seed: u32) -> Dot {
    let u = of_row(all, identity_of(v.index + step.y, v.level));
    let place = vec2<i32>(u.index, v.index) + step;
    let identity = stirred_bits(identity_of(place.x, u.level) ^ stirred_bits(identity_of(place.y, v.level) ^ seed));
    // Where it is dark there is no space for random displacement.
    let apart = distance_px(darkness, 1.0);
    let stray = min(0.4, 0.1 + 0.5 * (apart - 1.0) / apart);
    let strays = (vec2<f32>(vec2<u32>(identity & 0xfffu, (identity >> 12u) & 0xfffu)) / 2048.0 - 1.0) * stray;
    let away = vec2<f32>(step) - vec2<f32>(u.rest, v.rest) + strays * vec2<f32>(u.apart, v.apart);
    let det = u.change.x * v.change.y - u.change.y * v.change.x;
    let away_px = vec2<f32>(away.x * v.change.y - away.y * u.change.y, u.change.x * away.y - v.change.x * away.x)
        / select(det, 1e-12, abs(det) < 1e-12);
    // Part of such grid points that have a dot: less than 1 on an axis where the coarser level lacks the point.
    let parts = select(vec2<f32>(1.0), 2.0 / vec2<f32>(u.apart, v.apart) - 1.0, (place & vec2<i32>(1)) != vec2<i32>(0));
    let part = parts.x * parts.y;
    let order = f32(stirred_bits(identity) >> 8u) / 16777216.0;
    let grown = clamp((part * (1.0 + COMES) - order) / COMES, 0.0, 1.0);
    return Dot(away_px, width_px * sqrt(grown));
}

// Returns the ink of a dot in a pixel, 0 to 1. Dots do not grow to balance tones.
fn ink_of_dot(dot: Dot, darkness: f32) -> f32 {
    let wide_px = dot.width_px * sqrt(max(darkness, DENSEST) / DENSEST);
    return min(wide_px, 1.0) * clamp(0.5 * max(wide_px, 1.0) - length(dot.away_px) + 0.5, 0.0, 1.0);
}
