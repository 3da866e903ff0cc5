// Toon tones: light in a few steps with soft borders, or smooth, and their colours.
//
// Colours come from a two-dimensional table of the tone and of the place's height, slope or distance (X-toon: Barla,
// Thollot and Markosian 2006). Elevation tints are such a table.
#import hachure::view::distance_from_eye
#import hachure::seen::{place_seen, surface_seen}
#import hachure::earth::unbend
#import hachure::focus::half_of_focus
#import hachure::light::{light_tone, haze_clear}
#import hachure::lit_surface::{lit_surface, view, light, distance_m}
#import hachure::lit_tone::{lit_tone, relief_light}
#import hachure::mark_normal::FLAT
#ifdef FITTED
#import hachure::tone_curve::{ToneCurve, ToneFit, fitted}
#endif

#ifdef LOCAL_COLOR
#import hachure::color::luminance
#import hachure::local_color::{hue_of, glaze}
#import hachure::surface_id::{has_trait, LOCALLY_COLORED}
#endif

const HEIGHT: u32 = 0u;
const SLOPE: u32 = 1u;

struct Toon {
    // Number of steps; 0: smooth.
    steps: f32,
    // Tones of the darkest and the lightest step, and softness of the borders between steps (1: each rises all the way
    // to the next).
    darkest: f32,
    lightest: f32,
    softness: f32,
    // How strongly the tone is coloured, 0 to 1.
    wash: f32,
    // Row of the ramp: row_first + attribute * row_scale.
    row_first: f32,
    row_scale: f32,
    // HEIGHT, SLOPE, or any other value for the distance.
    by: u32,
    camera_z_m: f32,
    // Range of the land's heights.
    low_m: f32,
    high_m: f32,
    // Weight of the colours of trees and models, 0 to 1.
    local: f32,
    // 1: light comes from `relief_light`; and the weight of its colour, 0 to 1.
    relief: f32,
    light_color: f32,
    // 1: `crest_light` is added.
    crests: f32,
    pad_b: f32,
}

@group(0) @binding(7) var<uniform> toon: Toon;
// Linear colour, by tone from dark to light, and by the attribute.
@group(0) @binding(8) var ramp: texture_2d<f32>;
// rgb: colour before lines and haze; a: the requested tone, haze included.
@group(0) @binding(9) var tone: texture_storage_2d<rgba16float, write>;
#ifdef MARKED_TREES
@group(0) @binding(17) var mark_surface: texture_2d<u32>;
#endif
#ifdef FITTED
@group(0) @binding(22) var<storage, read> tone_curve: ToneCurve;
@group(0) @binding(23) var<storage, read> tone_fit: ToneFit;
#endif
#ifdef LOCAL_COLOR
@group(0) @binding(18) var surface_id: texture_2d<u32>;
@group(0) @binding(19) var local_color: texture_2d<u32>;
#endif

fn stepped(lit: f32) -> f32 {
    if toon.steps < 1.0 {
        return lit;
    }
    let scaled = lit * toon.steps;
    let step = floor(scaled);
    let soft = smoothstep(1.0 - toon.softness, 1.0, scaled - step);
    return clamp((step + soft) / (toon.steps - 1.0), 0.0, 1.0);
}

// Returns the value between the darkest and the lightest tone of the style.
fn value_of(lit: f32, away_m: f32) -> f32 {
#ifdef FITTED
    let tone = fitted(tone_curve, tone_fit, lit, away_m);
#else
    let tone = lit;
#endif
    return mix(toon.darkest, toon.lightest, stepped(tone));
}

fn attribute_at(at: vec3<f32>, n: vec3<f32>) -> f32 {
    if toon.by == HEIGHT {
        // The earth's surface curves away; heights above the sea are measured from it.
        return (unbend(at).flat_m.z + toon.camera_z_m - toon.low_m) / (toon.high_m - toon.low_m);
    }
    if toon.by == SLOPE {
        return degrees(acos(clamp(n.z, -1.0, 1.0)));
    }
    return distance_from_eye(view, at);
}

fn ramp_color(value: f32, kind: f32) -> vec3<f32> {
    let last = vec2<i32>(textureDimensions(ramp)) - 1;
    let place = vec2<f32>(value * f32(last.x), toon.row_first + kind * toon.row_scale);
    let p = clamp(place, vec2<f32>(0.0), vec2<f32>(last));
    let cell = vec2<i32>(p);
    let next = min(cell + 1, last);
    let f = p - vec2<f32>(cell);
    return mix(
        mix(textureLoad(ramp, cell, 0), textureLoad(ramp, vec2<i32>(next.x, cell.y), 0), f.x),
        mix(textureLoad(ramp, vec2<i32>(cell.x, next.y), 0), textureLoad(ramp, next, 0), f.x), f.y).rgb;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let at = place_seen(view, distance_m, pixel);
    if at.w <= 0.0 {
        textureStore(tone, pixel, vec4<f32>(1.0));
        return;
    }
    let surface = lit_surface(pixel, at);
    let n = surface.normal;
    let relief = textureLoad(relief_light, select(vec2<i32>(0), pixel, toon.relief > 0.0), 0);
    let lit = lit_tone(surface, pixel, toon.relief > 0.0, toon.crests > 0.0);
    let away_m = distance_from_eye(view, at.xyz);
    let value = value_of(lit, away_m);
    var marked = value;
#ifdef MARKED_TREES
    // Marks do not shade each leaf, and lines darken the crown in addition.
    let round = surface_seen(mark_surface, pixel);
    if round.w == FLAT {
        let at_marks = vec4<f32>(round.xyz, sqrt(n.w));
        marked = value_of(light_tone(light, at_marks, surface.seen), away_m);
    }
#endif
    let asked = 1.0 - (1.0 - marked) * haze_clear(light, away_m) * half_of_focus(surface.clear);
    var color = ramp_color(value, attribute_at(at.xyz, n.xyz)) * mix(vec3<f32>(1.0), relief.rgb, toon.light_color);
#ifdef LOCAL_COLOR
    if has_trait(textureLoad(surface_id, pixel, 0).r, LOCALLY_COLORED) {
        let hue = hue_of(textureLoad(local_color, pixel, 0).r);
        color = mix(color, glaze(hue.rgb, luminance(color)), toon.local * hue.a);
    }
#endif
    textureStore(tone, pixel, vec4<f32>(mix(vec3<f32>(1.0), color, toon.wash), asked));
}
