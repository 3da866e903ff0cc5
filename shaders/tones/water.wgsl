// Water as a cartographer draws it: a tint without tones, a line along the shore, and water lines or ruled lines.
//
// Water lines run along the shore, each farther from the one before, and paler: as on the sheets of Dufour and
// Siegfried and on the copperplates of the USGS (Raisz 1938, "General Cartography", on water-lining). Their distances
// are in pixels at the place, so that they are independent of the camera; at flat angles they come together, get
// thinner, and vanish before they would merge. Ruled lines are horizontal on the sheet.
//
// With MIRROR still water takes the tone of its reflection, more at flatter angles. The ray that the water surface
// reflects is marched on the picture: its projection runs straight to its vanishing point, and its inverse depth is
// linear (McGuire and Mara 2014, "Efficient GPU Screen-Space Ray Tracing"). The surface that first hides the ray is the
// one that is reflected; if none does, the sky is. Engravers draw dark reflections in horizontal strokes that swell and
// break, and so does this pass.
#import hachure::view::{View, distance_from_eye, from_eye}
#import hachure::seen::place_seen
#import hachure::line_ink::line_ink
#ifdef MIRROR
#import hachure::earth::unbend
#import hachure::color::luminance
#import hachure::pcg::pcg
#endif

struct WaterLook {
    // Linear colour.
    tint: vec3<f32>,
    shore_px: f32,
    line_px: f32,
    spacing_px: f32,
    // Ratio between consecutive gaps, and between the ink of consecutive lines.
    growth: f32,
    paler: f32,
    lines: u32,
    // 1: ruled lines instead of water lines.
    rules: u32,
    // Distance of the last line from the shore, in pixels.
    reach_px: f32,
    // Weight of the reflection in the tone, 0 to 1.
    mirror: f32,
    // 1: the reflection is drawn in strokes; 0: in colour.
    strokes: u32,
    // Distance from the shore at which water has its deep colour, in pixels; 0: it has the tint alone.
    deep_px: f32,
    pad_a: u32,
    pad_b: u32,
    // Colours of the sky, linear.
    sky_horizon: vec3<f32>,
    pad_c: f32,
    sky_zenith: vec3<f32>,
    pad_d: f32,
    // Factor of the tint in deep water, linear.
    deep: vec3<f32>,
    pad_e: f32,
}

// Gap on the picture below which lines vanish; from the second distance on they are whole.
const TOO_NEAR_PX: f32 = 1.5;
const APART_PX: f32 = 3.0;
// How much larger both are where water is seen at a flat angle, and lines would jump from row to row.
const FLAT_APART: f32 = 1.4;
// Part of the ink of ruled lines that is left far from the shore.
const OPEN: f32 = 0.5;

// Sine of the angle to the water from which on all of its depth shows.
const STEEP: f32 = 0.4;

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> water_look: WaterLook;
@group(0) @binding(2) var distance_m: texture_2d<f32>;
// See surface/water.wgsl.
@group(0) @binding(3) var water: texture_2d<f32>;
@group(0) @binding(4) var tone: texture_2d<f32>;
// As `tone`.
@group(0) @binding(5) var watered: texture_storage_2d<rgba16float, write>;
@group(0) @binding(6) var water_ink: texture_storage_2d<r32float, write>;

// Returns the smaller change to the neighbours on both sides, because borders of occluding objects are not shores.
fn change(pixel: vec2<i32>, step: vec2<i32>, own: f32) -> f32 {
    let last = vec2<i32>(view.size_px) - 1;
    var least = 1e30;
    for (var side = -1; side <= 1; side += 2) {
        let next = pixel + side * step;
        let there = textureLoad(water, clamp(next, vec2<i32>(0), last), 0).r;
        if there != 0.0 && all(next >= vec2<i32>(0)) && all(next <= last) {
            least = min(least, abs(there - own));
        }
    }
    return select(least, 0.0, least == 1e30);
}

#ifdef MIRROR
// Length of the search for a reflection on the picture, its step, and bisections of the last step. Steps are short
// because the land below a crest hides a ray over few pixels.
const MIRROR_REACH_PX: f32 = 256.0;
const STEP_PX: f32 = 1.5;
const HALVINGS: i32 = 4;
// Slope toward the eye from which on a reflected ray has no vanishing point in front of the eye.
const STEEPEST: f32 = 0.03;
// Ratio of distances beyond which a surface is behind the water; nearer surfaces are not reflected there.
const BEFORE: f32 = 1.002;
// Radius in pixels over which tones are averaged.
const SOFT_PX: i32 = 2;
// Mean length after which a stroke breaks, and the largest sideways offset at which it takes its tone.
const BREAK_PX: f32 = 37.0;
const ASIDE_PX: f32 = 2.5;
// Darkness below which there are no strokes, and largest part of their spacing that strokes take.
const PALEST: f32 = 0.12;
const WIDEST: f32 = 0.7;

struct Mirrored {
    color: vec3<f32>,
    // 0 white to 1 black.
    dark: f32,
}

// Returns the tone around a reflected position of the picture, without water and sky.
fn tone_about(px: vec2<f32>, sky: Mirrored) -> Mirrored {
    let middle = vec2<i32>(floor(px));
    let last = vec2<i32>(view.size_px) - 1;
    var sum = vec4<f32>(0.0);
    var count = 0.0;
    for (var i = 0; i < 9; i++) {
        let at = clamp(middle + SOFT_PX * (vec2<i32>(i % 3, i / 3) - 1), vec2<i32>(0), last);
        let is_land = textureLoad(distance_m, at, 0).r > 0.0 && textureLoad(water, at, 0).r <= 0.0;
        sum += select(vec4<f32>(0.0), textureLoad(tone, at, 0), is_land);
        count += f32(is_land);
    }
    let mean = sum / max(count, 1.0);
    return Mirrored(select(sky.color, mean.rgb, count > 0.0), select(sky.dark, 1.0 - mean.a, count > 0.0));
}

// Returns the reflection in water at a point shown by a pixel; `w` is its weight by the view angle.
fn mirrored(px: vec2<f32>, at_m: vec3<f32>, is_water: bool) -> vec4<f32> {
    let to_m = from_eye(view, at_m);
    let up = unbend(at_m).up;
    let reflected = to_m - 2.0 * dot(to_m, up) * up;
    let flat_seen = 1.0 - clamp(-dot(to_m, up) / length(to_m), 0.0, 1.0);
    let rise = clamp(2.0 * dot(reflected, up) / length(reflected), 0.0, 1.0);
    let sky_color = mix(water_look.sky_horizon, water_look.sky_zenith, rise);
    let sky = Mirrored(sky_color, 1.0 - luminance(sky_color));
    let depth_m = (view.clip_from_camera * vec4<f32>(at_m, 1.0)).w;
    let end = view.clip_from_camera * vec4<f32>(reflected, 0.0);
    let vanishes_px = (end.xy / end.w * vec2<f32>(0.5, -0.5) + 0.5) * vec2<f32>(view.size_px);
    let is_ahead = is_water && end.w > STEEPEST * length(to_m);
    let way = vanishes_px - px;
    let farthest = min(1.0, MIRROR_REACH_PX / max(length(way), 1.0));
    var before = 0.0;
    var found = -1.0;
    let count = max(i32(ceil(farthest * length(way) / STEP_PX)), 1);
    let steps = select(0, count, is_ahead);
    for (var i = 1; i <= steps; i++) {
        let part = farthest * f32(i) / f32(count);
        let at = vec2<i32>(floor(px + part * way));
        if any(at < vec2<i32>(0)) || any(at >= vec2<i32>(view.size_px)) {
            break;
        }
        let there_m = textureLoad(distance_m, at, 0).r;
        if there_m > BEFORE * depth_m && there_m * (1.0 - part) < depth_m {
            found = part;
            break;
        }
        before = part;
    }
    var seen = sky;
    if found >= 0.0 {
        for (var i = 0; i < HALVINGS; i++) {
            let middle = 0.5 * (before + found);
            let there_m = textureLoad(distance_m, vec2<i32>(floor(px + middle * way)), 0).r;
            let is_behind = there_m > BEFORE * depth_m && there_m * (1.0 - middle) < depth_m;
            found = select(found, middle, is_behind);
            before = select(middle, before, is_behind);
        }
        seen = tone_about(px + found * way, sky);
    }
    let amount = water_look.mirror * flat_seen * flat_seen;
    return vec4<f32>(select(seen.color, vec3<f32>(seen.dark), water_look.strokes == 1u), amount);
}

// Returns a number of 0 to 1 for a row of strokes and a position along it, which varies smoothly.
fn along_row(row: i32, along: f32) -> f32 {
    let cell = floor(along);
    let a = pcg(bitcast<vec2<u32>>(vec2<i32>(row, i32(cell)))).x;
    let b = pcg(bitcast<vec2<u32>>(vec2<i32>(row, i32(cell) + 1))).x;
    return mix(f32(a), f32(b), smoothstep(0.0, 1.0, along - cell)) / 4294967295.0;
}
#endif

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let own = textureLoad(tone, pixel, 0);
    let away_m = textureLoad(water, pixel, 0).r;
    if away_m == 0.0 {
        textureStore(watered, pixel, own);
        textureStore(water_ink, pixel, vec4<f32>(0.0));
        return;
    }
    let pixel_m = distance_from_eye(view, place_seen(view, distance_m, pixel).xyz) / view.focal_px;
    // Pixels at the place per pixel of the picture: 1 seen from above, more at flat angles.
    let steep = length(vec2<f32>(change(pixel, vec2<i32>(1, 0), away_m), change(pixel, vec2<i32>(0, 1), away_m))) / pixel_m;
    let narrow = max(steep, 0.7);
    let away_px = away_m / pixel_m;
    let cover = clamp(0.5 + away_px / narrow, 0.0, 1.0);
    // Lines at flat angles are thinner.
    let thin = inverseSqrt(max(narrow, 1.0));
    var ink = line_ink(away_px / narrow, water_look.shore_px * thin);
    if water_look.rules == 1u {
        let row = (f32(pixel.y + view.origin_px.y) + 0.5) / water_look.spacing_px;
        let off_px = (fract(row) - 0.5) * water_look.spacing_px;
        let open = mix(1.0, OPEN, clamp(away_px / max(water_look.reach_px, 1.0), 0.0, 1.0));
        ink = max(ink, line_ink(off_px, water_look.line_px) * open * cover);
    } else {
        let wider = mix(1.0, FLAT_APART, smoothstep(1.2, 2.0, narrow));
        var middle_px = 0.0;
        var gap_px = water_look.spacing_px;
        var strength = 1.0;
        for (var i = 0u; i < water_look.lines; i++) {
            middle_px += gap_px;
            strength *= select(water_look.paler, 1.0, i == 0u);
            let apart = smoothstep(TOO_NEAR_PX * wider, APART_PX * wider, gap_px / narrow);
            ink = max(ink, line_ink((away_px - middle_px) / narrow, water_look.line_px * thin) * strength * apart);
            gap_px *= water_look.growth;
        }
    }
    var tint = water_look.tint;
    if water_look.deep_px > 0.0 {
        // Water that is seen at a flat angle shows the sky rather than its depth.
        let to_m = from_eye(view, place_seen(view, distance_m, pixel).xyz);
        let level_sight = clamp(-to_m.z / length(to_m), 0.0, 1.0);
        let deep = smoothstep(0.0, water_look.deep_px, away_px) * smoothstep(0.0, STEEP, level_sight);
        tint *= mix(vec3<f32>(1.0), water_look.deep, deep);
    }
#ifdef MIRROR
    let gap_px = select(3.0, max(water_look.spacing_px, 2.0), water_look.strokes == 1u);
    let sheet = vec2<f32>(pixel + view.origin_px) + 0.5;
    let row = floor(sheet.y / gap_px);
    let wander = along_row(i32(row), sheet.x / BREAK_PX);
    // A whole stroke has the reflection of the middle of its row, offset a little to a side.
    let up_px = select(0.0, (row + 0.5) * gap_px - sheet.y, water_look.strokes == 1u);
    let seen_px = vec2<f32>(pixel) + 0.5 + vec2<f32>(2.0 * ASIDE_PX * (wander - 0.5), up_px);
    let seen = clamp(vec2<i32>(floor(seen_px)), vec2<i32>(0), vec2<i32>(view.size_px) - 1);
    let is_there = textureLoad(water, seen, 0).r > 0.0;
    let at = place_seen(view, distance_m, select(pixel, seen, is_there)).xyz;
    let mirror = mirrored(vec2<f32>(select(pixel, seen, is_there)) + 0.5, at, cover > 0.0);
    if water_look.strokes == 1u {
        let dark = clamp((mirror.x - PALEST) / (1.0 - PALEST), 0.0, 1.0) * mirror.w;
        // Strokes break where they are thin.
        let width_px = WIDEST * gap_px * dark * smoothstep(0.0, 0.25, dark + 0.3 * wander - 0.15);
        let off_px = sheet.y - (row + 0.5) * gap_px;
        ink = max(ink, line_ink(off_px, width_px) * cover);
    } else {
        tint = mix(tint, tint * mirror.rgb, mirror.w);
    }
#endif
    textureStore(watered, pixel, mix(own, vec4<f32>(tint, 1.0), cover));
    textureStore(water_ink, pixel, vec4<f32>(ink));
}
