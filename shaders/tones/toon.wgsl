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
#import hachure::tone_curve::{ToneCurve, ToneFit, fitted, foreground_part}
#endif

#ifdef EDITED
#import hachure::mass_grid::{MassCell, NO_LAND}
#import hachure::view::place_at

// Largest relative difference in distance between a pixel and a cell of the same face, and largest sine of the angle
// between the pixel's tangent plane and a cell of the same face that is farther away.
const ONE_FACE: f32 = 0.1;
const OFF_PLANE: f32 = 0.15;
#endif

#ifdef DRAPED_IMAGE
#import hachure::image_tone::with_image_hue
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
    // Number of cells of the masses, across and down.
    mass_cells: vec2<u32>,
    pad_c: vec2<f32>,
    // Linear colour of the ink that tints near land, and its strength, 0 to 1.
    foreground_ink: vec4<f32>,
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
#ifdef EDITED
@group(0) @binding(24) var<storage, read> mass_cells: array<MassCell>;
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

// Returns the fitted tone of light at a distance.
fn fitted_tone(lit: f32, away_m: f32) -> f32 {
#ifdef FITTED
    return fitted(tone_curve, tone_fit, lit, away_m);
#else
    return lit;
#endif
}

// Returns the tone of land at a pixel that sees `at`, changed as the masses around it on the same face of the land are, and
// within their tones. `normal` is that of the face.
fn within_masses(pixel: vec2<i32>, at: vec4<f32>, normal: vec3<f32>, tone: f32) -> f32 {
#ifdef EDITED
    let cells = vec2<i32>(toon.mass_cells);
    let cells_of_px = vec2<f32>(cells) / view.picture_px;
    let place = (vec2<f32>(pixel + view.origin_px) + 0.5) * cells_of_px - 0.5;
    let first = floor(place);
    // Cells that are about as far away are of the same face. Without one, those in the tangent plane are, as on level land
    // near the horizon.
    var is_same = array<bool, 4>();
    var is_level = array<bool, 4>();
    var any_same = false;
    var around_cells = array<MassCell, 4>();
    for (var i = 0; i < 4; i++) {
        let corner = vec2<i32>(i & 1, i >> 1u);
        let cell = clamp(vec2<i32>(first) + corner, vec2<i32>(0), cells - 1);
        let here = mass_cells[cell.y * cells.x + cell.x];
        let middle_px = (vec2<f32>(cell) + 0.5) / cells_of_px - vec2<f32>(view.origin_px);
        let away = place_at(view, middle_px, here.depth_m) - at.xyz;
        let is_land = here.tone != NO_LAND;
        around_cells[i] = here;
        is_same[i] = is_land && abs(here.depth_m - at.w) < ONE_FACE * at.w;
        is_level[i] = is_land && abs(dot(away, normal)) < OFF_PLANE * length(away);
        any_same = any_same || is_same[i];
    }
    // From the darkest tone to the lightest.
    var around = vec2<f32>(2.0, -1.0);
    // Tone and level of edited cells, which were lighter or darker than that.
    var lowered = vec2<f32>(2.0);
    var raised = vec2<f32>(-1.0);
    var change = 0.0;
    var weights = 1e-6;
    for (var i = 0; i < 4; i++) {
        let here = around_cells[i];
        if select(is_level[i], is_same[i], any_same) {
            let corner = vec2<f32>(vec2<i32>(i & 1, i >> 1u));
            let weight = mix(1.0 - (place - first), place - first, corner);
            around = vec2<f32>(min(around.x, here.tone), max(around.y, here.tone));
            lowered = select(lowered, vec2<f32>(here.tone, here.level), here.tone < min(here.before, lowered.x));
            raised = select(raised, vec2<f32>(here.tone, here.level), here.tone > max(here.before, raised.x));
            change += weight.x * weight.y * (here.tone - here.before);
            weights += weight.x * weight.y;
        }
    }
    // Where no cell is beyond the level, nothing between the cells is.
    around.y = select(around.y, min(around.y, lowered.x), around.y < lowered.y);
    around.x = select(around.x, max(around.x, raised.x), around.x >= raised.y);
    if around.x <= around.y {
        return clamp(tone + change / weights, around.x, around.y);
    }
#endif
    return tone;
}

// Returns the value of a tone, between the darkest and the lightest of the style.
fn value_of(tone: f32) -> f32 {
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
    var light_here = fitted_tone(lit, away_m);
    if n.w == 1.0 {
        light_here = within_masses(pixel, at, n.xyz, light_here);
    }
    let value = value_of(light_here);
    var marked = value;
#ifdef MARKED_TREES
    // Marks do not shade each leaf, and lines darken the crown in addition.
    let round = surface_seen(mark_surface, pixel);
    if round.w == FLAT {
        let at_marks = vec4<f32>(round.xyz, sqrt(n.w));
        marked = value_of(fitted_tone(light_tone(light, at_marks, surface.seen), away_m));
    }
#endif
    let asked = 1.0 - (1.0 - marked) * haze_clear(light, away_m) * half_of_focus(surface.clear);
    var color = ramp_color(value, attribute_at(at.xyz, n.xyz)) * mix(vec3<f32>(1.0), relief.rgb, toon.light_color);
#ifdef DRAPED_IMAGE
    color = with_image_hue(pixel, color);
#endif
#ifdef LOCAL_COLOR
    if has_trait(textureLoad(surface_id, pixel, 0).r, LOCALLY_COLORED) {
        let hue = hue_of(textureLoad(local_color, pixel, 0).r);
        color = mix(color, glaze(hue.rgb, luminance(color)), toon.local * hue.a);
    }
#endif
#ifdef FITTED
    // Transparent ink over the tones, as the graded blocks of colour prints (bokashi).
    color *= mix(vec3<f32>(1.0), toon.foreground_ink.rgb, toon.foreground_ink.a * foreground_part(tone_curve, away_m));
#endif
    textureStore(tone, pixel, vec4<f32>(mix(vec3<f32>(1.0), color, toon.wash), asked));
}
