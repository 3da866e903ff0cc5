// Draws strokes as ink: a strip along the samples of each (Pietrok 2021, section 4.2.4; Northrup and Markosian 2000).
//
// There is one instance for each pair of consecutive samples, with two triangles each. Sides are mitred, at most to
// twice the width; ends are round. The strip is wider on each side for the border's coverage. Where strokes cross or a
// strip folds onto itself, the darker one stays (max blending), so nothing is inked twice.
//
// The texture's parameter in pixels runs along the stroke, and the distance from its centre line in pixels across it.
#import hachure::view::{View, place_at}
#import hachure::focus::{Focus, in_focus, focus_width}
#import hachure::stroke_style::Strokes
#import hachure::brush::{Brush, brush_uv, brush_ink}
#import hachure::stroke_samples::{LEAST_HALF_WIDTH_PX, Sample, SampleCounts, is_seam, FIRST, LAST, IS_CLOSED, RUNS_OFF}

// 0: strokes of this frame; 1: fading strokes.
@group(0) @binding(0) var<uniform> stage: u32;
@group(0) @binding(1) var<uniform> view: View;
@group(0) @binding(2) var<uniform> strokes: Strokes;
@group(0) @binding(3) var<storage, read> sample_counts: SampleCounts;
@group(0) @binding(4) var<storage, read> samples: array<Sample>;
// For a style with a stroke texture; only `textured` reads them. The tile holds pigment and threshold.
@group(0) @binding(5) var<uniform> brush: Brush;
@group(0) @binding(6) var brush_tile: texture_2d<f32>;
@group(0) @binding(7) var brush_sampler: sampler;
@group(0) @binding(8) var<storage, read> focus: Focus;

struct Vertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(linear) along_px: f32,
    @location(1) @interpolate(linear) across_px: f32,
    // Distances beyond the stroke's start and its end; negative on the stroke.
    @location(2) @interpolate(linear) beyond_px: vec2<f32>,
    @location(3) @interpolate(linear) half_width_px: f32,
    @location(4) @interpolate(linear) depth_m: f32,
    @location(5) @interpolate(linear) pressure: f32,
    @location(6) @interpolate(linear) shown_px: f32,
    @location(7) @interpolate(flat) id: u32,
}

const FRINGE_PX: f32 = 0.75;
// A stroke that continues off the sheet is extended past its last sample by OFF_PX. Between updates the view moves, and
// the extension grows with the distance to the border, times ASLANT because strokes meet the border obliquely, up to
// MAX_OFF_PX.
const OFF_PX: f32 = 4.0;
const ASLANT: f32 = 1.5;
const MAX_OFF_PX: f32 = 64.0;
// Number of segments that determine the direction of the extension.
const OFF_SEGMENTS: u32 = 4u;
// Length of a taper over which strokes turn pale.
const PALE_PX: f32 = 4.0;
// Largest coordinate at which anything is drawn; rounding fails beyond.
const FAR_OUT_PX: f32 = 32768.0;

fn direction(a: vec2<f32>, b: vec2<f32>) -> vec2<f32> {
    let d = b - a;
    let l = length(d);
    return select(vec2<f32>(0.0), d / l, l > 1e-4);
}

fn nothing() -> Vertex {
    return Vertex(vec4<f32>(2.0, 2.0, 0.0, 1.0), 0.0, 0.0, vec2<f32>(0.0), 0.0, 1.0, 0.0, 0.0, 0u);
}

fn is_out(own: Sample) -> bool {
    return own.depth_m < view.near_m || any(abs(own.px) > vec2<f32>(FAR_OUT_PX));
}

// Returns the length by which a stroke is extended off the sheet.
fn off_px(px: vec2<f32>) -> f32 {
    let from_border = min(px, vec2<f32>(view.size_px) - px);
    return OFF_PX + min(ASLANT * max(min(from_border.x, from_border.y), 0.0), MAX_OFF_PX);
}

// Returns the direction of a stroke at its last sample, or at its first one.
fn way_off(number: u32, ends: u32) -> vec2<f32> {
    var at = number;
    for (var i = 0u; i < OFF_SEGMENTS && (samples[at].flags & ends) == 0u; i++) {
        at = select(at - 1u, at + 1u, ends == LAST);
    }
    return direction(samples[at].px, samples[number].px);
}

@vertex
fn vertex(@builtin(vertex_index) corner: u32, @builtin(instance_index) instance: u32) -> Vertex {
    let number = instance + select(0u, sample_counts.fresh, stage == 1u);
    let begin = samples[number];
    if number + 1u >= sample_counts.samples || (begin.flags & LAST) != 0u {
        return nothing();
    }
    let end = samples[number + 1u];
    if is_out(begin) || is_out(end) || max(begin.shown_px, end.shown_px) <= -0.5 {
        return nothing();
    }
    // Corners 0 1 2, 2 1 3: even ones at this sample, odd ones at the next; the first two on the left.
    let slot = array<u32, 6>(0u, 1u, 2u, 2u, 1u, 3u)[corner];
    let is_next = (slot & 1u) == 1u;
    let side = select(1.0, -1.0, slot >= 2u);
    let i = number + u32(is_next);
    let at = samples[i];
    let is_first = (at.flags & FIRST) != 0u;
    let is_last = (at.flags & LAST) != 0u;
    let along = direction(begin.px, end.px);
    if all(along == vec2<f32>(0.0)) {
        return nothing();
    }
    let into = select(direction(samples[max(i, 1u) - 1u].px, at.px), vec2<f32>(0.0), is_first);
    let out = select(direction(at.px, samples[i + 1u].px), vec2<f32>(0.0), is_last);
    var tangent = into + out;
    let turn = length(tangent);
    tangent = select(along, tangent / turn, turn > 0.5);
    // Longer at a bend, so that both sides keep their width.
    let mitre = min(1.0 / max(dot(tangent, along), 0.25), 2.0);
    let reach = at.half_width_px + FRINGE_PX;
    var px = at.px + vec2<f32>(tangent.y, -tangent.x) * (side * reach * mitre);
    let sense = select(-1.0, 1.0, end.along_px >= begin.along_px);
    // Where strokes with different parameters meet, the earlier one's parameter continues.
    let length_px = distance(begin.px, end.px);
    let is_broken = is_seam(begin.along_px, end.along_px, length_px);
    var along_px = select(at.along_px, begin.along_px + sense * length_px, is_broken && is_next);
    // Extents for the round ends. Strokes that continue off the sheet have no round ends, and are extended out of view.
    let is_open = vec2<bool>((at.flags & IS_CLOSED) == 0u);
    let ends = vec2<bool>((begin.flags & FIRST) != 0u, (end.flags & LAST) != 0u) & is_open;
    let runs_off = ends & (vec2<u32>(begin.flags, end.flags) & vec2<u32>(RUNS_OFF)) != vec2<u32>(0u);
    let has_end = ends & !runs_off;
    let beyond_ends_px = reach + select(vec2<f32>(0.0), vec2<f32>(off_px(begin.px), off_px(end.px)), runs_off);
    let extents_px = select(vec2<f32>(0.0), beyond_ends_px, ends);
    let extent_px = select(extents_px.x, extents_px.y, is_next);
    var onward = along * select(-1.0, 1.0, is_next);
    if select(runs_off.x, runs_off.y, is_next) {
        onward = way_off(i, select(LAST, FIRST, is_next));
        px = at.px + vec2<f32>(onward.y, -onward.x) * (side * reach * select(-1.0, 1.0, is_next));
    }
    px += onward * extent_px;
    along_px += sense * select(-extent_px, extent_px, is_next);
    let own_px = select(-extent_px, length_px + extent_px, is_next);
    let beyond_px = select(vec2<f32>(-1.0), vec2<f32>(-own_px, own_px - length_px), has_end);
    let ndc = px / vec2<f32>(view.size_px) * vec2<f32>(2.0, -2.0) + vec2<f32>(-1.0, 1.0);
    return Vertex(
        vec4<f32>(ndc, 0.0, 1.0), along_px, sense * side * reach, beyond_px, at.half_width_px, at.depth_m, at.pressure, at.shown_px, number + 1u
    );
}

struct Fragment {
    @location(0) coverage: vec4<f32>,
    @location(1) id: u32,
}

// The brush at a point of a stroke.
struct Touched {
    half_width_px: f32,
    from_middle_px: f32,
    // Coverage of the pixel, 0 to 1.
    covered: f32,
    // Contrast left by haze and focus, 0 to 1.
    clear: f32,
}

fn touched(in: Vertex) -> Touched {
    let place_m = place_at(view, in.clip.xy, in.depth_m);
    let seen = in_focus(focus, view, place_m, in.clip.xy + vec2<f32>(view.origin_px));
    let half_width = max(focus_width(seen) * in.half_width_px * mix(0.35, 1.0, sqrt(clamp(in.pressure, 0.0, 1.0))), LEAST_HALF_WIDTH_PX);
    let beyond_px = max(max(in.beyond_px.x, in.beyond_px.y), 0.0);
    let distance_px = length(vec2<f32>(in.across_px, beyond_px));
    let covered = clamp(in.shown_px + 0.5, 0.0, 1.0) * clamp(half_width - distance_px + 0.5, 0.0, 1.0);
    let t = in.depth_m / strokes.haze_m;
    let clear = mix(strokes.faintest, 1.0, exp(-t * t)) * seen / focus_width(seen);
    return Touched(half_width, distance_px, covered, clear);
}

// Solid ink.
@fragment
fn fragment(in: Vertex) -> Fragment {
    let at = touched(in);
    // The end of a stroke is thin and pale.
    let opacity = clamp(in.pressure * max(strokes.taper_px, PALE_PX) / PALE_PX, 0.0, 1.0);
    let ink = opacity * at.covered * at.clear;
    if ink < 1.0 / 256.0 {
        discard;
    }
    return Fragment(vec4<f32>(ink), in.id);
}

// Returns the ink that the stroke texture takes, 0 to 1.
fn texture_ink(along_px: f32, across_px: f32, from_middle_px: f32, half_width_px: f32, pressure: f32) -> f32 {
    let texel = textureSample(brush_tile, brush_sampler, brush_uv(brush, along_px, across_px, half_width_px, 0u)).xy;
    return brush_ink(brush, texel, pressure, from_middle_px, half_width_px);
}

// Ink through the style's stroke texture. Haze takes a quarter of its effect from the pressure: distant strokes are
// lighter, and more broken.
@fragment
fn textured(in: Vertex) -> Fragment {
    let at = touched(in);
    let air = sqrt(sqrt(at.clear));
    // The round end is part of the stroke: the pressure reaches 0 where the round end does.
    let round_px = in.half_width_px;
    let pressure = air * (in.pressure * strokes.taper_px + round_px) / (strokes.taper_px + round_px);
    let taken = texture_ink(in.along_px, in.across_px, at.from_middle_px, at.half_width_px, pressure);
    let ink = at.covered * air * air * air * taken;
    // The stroke's id is written also where the texture takes no ink.
    if at.covered * at.clear < 1.0 / 256.0 {
        discard;
    }
    return Fragment(vec4<f32>(ink), in.id);
}
