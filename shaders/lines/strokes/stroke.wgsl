// Strokes as ink: a strip along the points of each chain (Loadholt 2021, section 4.2.4; Northrup and Markosian 2000).
//
// One instance for each pair of points that follow each other, two triangles each. Sides are mitred, at most to twice
// the width; ends are round and taper. The strip is half a pixel wider on each side for the border's coverage. Where
// strokes cross or a strip folds onto itself, the darker one stays (max blending), so nothing shows twice.
//
// Along the stroke runs its arc length in pixels, across it the distance from its middle in pixels.
#import hachure::view::View
#import hachure::strokes::Chain
#import hachure::stroke_edges::{Strokes, Point}
#import hachure::brush::{Brush, brush_uv, brush_ink}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> strokes: Strokes;
@group(0) @binding(2) var<storage, read> points: array<Point>;
// Arc length at each point since the first of all, in 1/16 px.
@group(0) @binding(3) var<storage, read> along_units: array<u32>;
@group(0) @binding(4) var<storage, read> chains: array<Chain>;
// Of a style with a stroke texture; only `textured` reads them. Pigment and threshold.
@group(0) @binding(5) var<uniform> brush: Brush;
@group(0) @binding(6) var brush_tile: texture_2d<f32>;
@group(0) @binding(7) var brush_sampler: sampler;

struct Vertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(linear) along_px: f32,
    @location(1) @interpolate(linear) across_px: f32,
    @location(2) @interpolate(flat) length_px: f32,
    @location(3) @interpolate(linear) half_width_px: f32,
    @location(4) @interpolate(linear) depth_m: f32,
    @location(5) @interpolate(flat) id: u32,
    @location(6) @interpolate(flat) key: u32,
}

const UNITS: f32 = 16.0;
const FRINGE_PX: f32 = 0.75;

fn direction(a: vec2<f32>, b: vec2<f32>) -> vec2<f32> {
    let d = b - a;
    let l = length(d);
    return select(vec2<f32>(0.0), d / l, l > 1e-4);
}

fn nothing() -> Vertex {
    return Vertex(vec4<f32>(2.0, 2.0, 0.0, 1.0), 0.0, 0.0, 0.0, 0.0, 1.0, 0u, 0u);
}

@vertex
fn vertex(@builtin(vertex_index) corner: u32, @builtin(instance_index) instance: u32) -> Vertex {
    let own = points[instance];
    let first = chains[own.chain].first + own.chain;
    let last = first + chains[own.chain].count;
    if instance >= last {
        return nothing();
    }
    let length_px = f32(along_units[last] - along_units[first]) / UNITS;
    if length_px < strokes.shortest_px {
        return nothing();
    }
    // Corners 0 1 2, 2 1 3: even ones at this point, odd ones at the next; the first two on the left.
    let slot = array<u32, 6>(0u, 1u, 2u, 2u, 1u, 3u)[corner];
    let is_next = (slot & 1u) == 1u;
    let side = select(1.0, -1.0, slot >= 2u);
    let i = instance + u32(is_next);
    let at = points[i];
    let before = points[max(i, first + 1u) - 1u].px;
    let after = points[min(i + 1u, last)].px;
    let along = direction(own.px, points[instance + 1u].px);
    if all(along == vec2<f32>(0.0)) {
        return nothing();
    }
    let into = direction(before, at.px);
    let out = direction(at.px, after);
    var tangent = into + out;
    let turn = length(tangent);
    tangent = select(along, tangent / turn, turn > 0.5);
    // Longer at a bend, so that both sides keep their width.
    let mitre = min(1.0 / max(dot(tangent, along), 0.25), 2.0);
    let nearness = clamp(strokes.haze_m / max(at.depth_m, 1.0) * 0.05, 0.3, 1.6);
    let half_width = strokes.half_width_px * mix(1.0, nearness, strokes.depth_width);
    let reach = half_width + FRINGE_PX;
    var px = at.px + vec2<f32>(tangent.y, -tangent.x) * (side * reach * mitre);
    var along_px = f32(along_units[i] - along_units[first]) / UNITS;
    // Room for the round ends.
    if i == first {
        px -= tangent * reach;
        along_px -= reach;
    }
    if i == last {
        px += tangent * reach;
        along_px += reach;
    }
    let ndc = px / vec2<f32>(view.size_px) * vec2<f32>(2.0, -2.0) + vec2<f32>(-1.0, 1.0);
    let clip = vec4<f32>(ndc, 0.0, 1.0);
    let key = chains[own.chain].key;
    return Vertex(clip, along_px, side * reach, length_px, half_width, at.depth_m, own.chain + 1u, key);
}

struct Fragment {
    @location(0) coverage: vec4<f32>,
    @location(1) id: u32,
}

// A place on a stroke.
struct Touched {
    // Below 0 in the round end.
    from_end_px: f32,
    taper_px: f32,
    half_width_px: f32,
    from_middle_px: f32,
    // Of the pixel.
    covered: f32,
    // What haze has left.
    clear: f32,
}

fn touched(in: Vertex) -> Touched {
    // A stroke that is shorter than its tapers tapers faster.
    let taper_px = min(strokes.taper_px, 0.5 * in.length_px) + 1e-3;
    let from_end_px = min(in.along_px, in.length_px - in.along_px);
    let pressure = clamp(from_end_px / taper_px, 0.0, 1.0);
    let half_width = max(in.half_width_px * mix(0.35, 1.0, sqrt(pressure)), 0.4);
    let beyond_px = max(-from_end_px, 0.0);
    let distance_px = length(vec2<f32>(in.across_px, beyond_px));
    let covered = clamp(half_width - distance_px + 0.5, 0.0, 1.0);
    let t = in.depth_m / strokes.haze_m;
    let clear = mix(strokes.faintest, 1.0, exp(-t * t));
    return Touched(from_end_px, taper_px, half_width, distance_px, covered, clear);
}

// Solid ink.
@fragment
fn fragment(in: Vertex) -> Fragment {
    let at = touched(in);
    let ink = at.covered * at.clear;
    if ink < 1.0 / 256.0 {
        discard;
    }
    return Fragment(vec4<f32>(ink), in.id);
}

// What the stroke texture takes of it, 0 to 1.
fn texture_ink(along_px: f32, across_px: f32, from_middle_px: f32, half_width_px: f32, pressure: f32, key: u32) -> f32 {
    let texel = textureSample(brush_tile, brush_sampler, brush_uv(brush, along_px, across_px, half_width_px, key)).xy;
    return brush_ink(brush, texel, pressure, from_middle_px, half_width_px);
}

// Ink through the style's stroke texture. Haze takes a quarter of its part from the hand's pressure: far strokes are
// lighter, and more broken.
@fragment
fn textured(in: Vertex) -> Fragment {
    let at = touched(in);
    let air = sqrt(sqrt(at.clear));
    // The round end is a part of the stroke: pressure is gone where it ends.
    let round_px = in.half_width_px;
    let pressure = air * clamp((at.from_end_px + round_px) / (at.taper_px + round_px), 0.0, 1.0);
    let taken = texture_ink(in.along_px, in.across_px, at.from_middle_px, at.half_width_px, pressure, in.key);
    let ink = at.covered * air * air * air * taken;
    if ink < 1.0 / 256.0 {
        discard;
    }
    return Fragment(vec4<f32>(ink), in.id);
}
