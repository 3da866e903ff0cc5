// Water as a cartographer draws it: a tint without tones, a line along the shore, and water lines or rules.
//
// Water lines run along the shore, each farther from the one before, and paler: as on the sheets of Dufour and Siegfried
// and on the copperplates of the USGS (Raisz 1938, "General Cartography", on water-lining). Their distances are counted
// in pixels of the place, so that they are the same wherever the camera is; seen along the water they come together, get
// thinner, and go before they would run into each other. Rules are level lines of the sheet.
#import hachure::view::{View, distance_from_eye}

struct WaterLook {
    // Linear.
    tint: vec3<f32>,
    shore_px: f32,
    line_px: f32,
    spacing_px: f32,
    // From a gap to the next, and from a line's ink to the next one's.
    growth: f32,
    paler: f32,
    lines: u32,
    // 1: rules in place of water lines.
    rules: u32,
    // How far the last line is from the shore.
    reach_px: f32,
    pad: f32,
}

// Lines that are nearer to each other on the picture are none; from the second distance on they are whole.
const TOO_NEAR_PX: f32 = 1.5;
const APART_PX: f32 = 3.0;
// What is left of rules far from the shore.
const OPEN: f32 = 0.5;

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> water_look: WaterLook;
@group(0) @binding(2) var position: texture_2d<f32>;
// See surface/water.wgsl.
@group(0) @binding(3) var water: texture_2d<f32>;
@group(0) @binding(4) var tone: texture_2d<f32>;
// As `tone`.
@group(0) @binding(5) var watered: texture_storage_2d<rgba16float, write>;
@group(0) @binding(6) var water_ink: texture_storage_2d<r32float, write>;

// The smaller change to the neighbours on both sides: borders of what hides are no shores.
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

// How much of a pixel a line covers whose middle is so far away.
fn line_ink(away_px: f32, width_px: f32) -> f32 {
    return min(width_px, 1.0) * clamp(0.5 * max(width_px, 1.0) + 0.5 - abs(away_px), 0.0, 1.0);
}

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
    let pixel_m = distance_from_eye(view, textureLoad(position, pixel, 0).xyz) / view.focal_px;
    // Pixels of the place for each of the picture: 1 seen from above, more along the water.
    let steep = length(vec2<f32>(change(pixel, vec2<i32>(1, 0), away_m), change(pixel, vec2<i32>(0, 1), away_m))) / pixel_m;
    let narrow = max(steep, 0.7);
    let away_px = away_m / pixel_m;
    let cover = clamp(0.5 + away_px / narrow, 0.0, 1.0);
    // Lines that are seen along the water are thinner.
    let thin = inverseSqrt(max(narrow, 1.0));
    var ink = line_ink(away_px / narrow, water_look.shore_px * thin);
    if water_look.rules == 1u {
        let row = (f32(pixel.y + view.origin_px.y) + 0.5) / water_look.spacing_px;
        let off_px = (fract(row) - 0.5) * water_look.spacing_px;
        let open = mix(1.0, OPEN, clamp(away_px / max(water_look.reach_px, 1.0), 0.0, 1.0));
        ink = max(ink, line_ink(off_px, water_look.line_px) * open * cover);
    } else {
        var middle_px = 0.0;
        var gap_px = water_look.spacing_px;
        var strength = 1.0;
        for (var i = 0u; i < water_look.lines; i++) {
            middle_px += gap_px;
            strength *= select(water_look.paler, 1.0, i == 0u);
            let apart = smoothstep(TOO_NEAR_PX, APART_PX, gap_px / narrow);
            ink = max(ink, line_ink((away_px - middle_px) / narrow, water_look.line_px * thin) * strength * apart);
            gap_px *= water_look.growth;
        }
    }
    textureStore(watered, pixel, mix(own, vec4<f32>(water_look.tint, 1.0), cover));
    textureStore(water_ink, pixel, vec4<f32>(ink));
}
