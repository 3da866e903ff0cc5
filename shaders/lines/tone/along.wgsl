// Lines from tone along themselves: crumbs go, and what stays is of an even ink.
//
// Lee et al. 2007, "Line drawings via abstracted shading", find lines pixel by pixel and say so: "rendered lines contain
// some pixel-level artifacts and may look a bit ratty" (section 1), and opacity may depend on other measures of confidence
// (section 3). This pass is no part of the paper. Its measure is length, as a draughtsman has it: from each pixel it walks
// both ways along the line, as the search saw its direction, until there is no ink or the line turns sharply. Short ends
// fade out, and ink is drawn toward its mean along the line, which leaves the profile across as it is (the idea of
// flow-based filters: Kang, Lee and Chui 2007).
//
// A single gap of a step is passed over. A line that runs off the picture, or behind nearer land of the same ink, goes on.
#import hachure::view::View

struct Along {
    // Shorter lines fade out.
    shortest_px: f32,
    step_px: f32,
    pad_a: f32,
    pad_b: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> along: Along;
// r, g: ink of dark lines and of highlight lines; b, a: the direction of the line.
@group(0) @binding(2) var tone_ink: texture_2d<f32>;
@group(0) @binding(3) var long_ink: texture_storage_2d<rgba16float, write>;

const STEPS: i32 = 8;
// Fainter is no ink, in parts of the pixel's own and at all.
const FAINT: f32 = 0.2;
const FAINTEST: f32 = 0.02;
// Cosine of the turn in a step at which a line is another one.
const TURN: f32 = 0.6;
// How much of its own ink a pixel gives for the mean.
const EVEN: f32 = 0.7;
// Where a line begins to fade, in parts of the shortest one.
const BEGIN: f32 = 0.4;

// How far the line goes on, and the sum and count of ink.
fn walk(pixel: vec2<i32>, way: vec2<f32>, is_highlight: bool, least: f32) -> vec3<f32> {
    var at_px = vec2<f32>(pixel) + 0.5;
    var on = way;
    var length_px = 0.0;
    var sum = 0.0;
    var count = 0.0;
    var is_gap = false;
    for (var i = 1; i <= STEPS; i++) {
        at_px += on * along.step_px;
        let next = vec2<i32>(floor(at_px));
        if any(next < vec2<i32>(0)) || any(next >= vec2<i32>(view.size_px)) {
            return vec3<f32>(f32(STEPS) * along.step_px, sum, count);
        }
        let seen = textureLoad(tone_ink, next, 0);
        let ink = select(seen.r, seen.g, is_highlight);
        let turned = select(-seen.ba, seen.ba, dot(seen.ba, on) >= 0.0);
        if ink < least || dot(turned, on) < TURN {
            if is_gap {
                break;
            }
            is_gap = true;
            continue;
        }
        is_gap = false;
        on = turned;
        length_px = f32(i) * along.step_px;
        sum += ink;
        count += 1.0;
    }
    return vec3<f32>(length_px, sum, count);
}

fn kept(pixel: vec2<i32>, way: vec2<f32>, is_highlight: bool, own: f32) -> f32 {
    if own <= 0.0 {
        return 0.0;
    }
    let least = max(FAINT * own, FAINTEST);
    let both = walk(pixel, way, is_highlight, least) + walk(pixel, -way, is_highlight, least);
    let mean = (own + both.y) / (1.0 + both.z);
    return mix(own, mean, EVEN) * smoothstep(BEGIN, 1.0, (both.x + 1.0) / along.shortest_px);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let own = textureLoad(tone_ink, pixel, 0);
    let ink = vec2<f32>(kept(pixel, own.ba, false, own.r), kept(pixel, own.ba, true, own.g));
    textureStore(long_ink, pixel, vec4<f32>(ink, own.ba));
}
