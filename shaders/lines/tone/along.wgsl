// Lines from tone along themselves: crumbs go, and what stays is of an even ink.
//
// Lee et al. 2007, "Line drawings via abstracted shading", find lines pixel by pixel and say so: "rendered lines contain
// some pixel-level artifacts and may look a bit ratty" (section 1), and opacity may depend on other measures of confidence
// (section 3). This pass is no part of the paper. Its measure is length, as a draughtsman has it: from each pixel it walks
// both ways along the line, as the search saw its direction, until there is no ink or the line turns sharply. Short ends
// fade out, and ink is drawn toward its mean along the line, which leaves the profile across as it is (the idea of
// flow-based filters: Kang, Lee and Chui 2007).
//
// - Each step goes to the middle of the ink that it finds, so that all pixels across a line walk the same way and fade alike.
// - A gap makes what follows count less and does not end the line, and neither does a bend: all of it is smooth, so that
//   neighbours walk as far. A line that runs off the picture goes on.
#import hachure::view::View

struct Along {
    // Shorter lines fade out.
    shortest_px: f32,
    step_px: f32,
    steps: i32,
    pad: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> along: Along;
// r, g: ink of dark lines and of highlight lines; b, a: cosine and sine of twice the angle of the line.
@group(0) @binding(2) var tone_ink: texture_2d<f32>;
@group(0) @binding(3) var tone_sampler: sampler;
@group(0) @binding(4) var long_ink: texture_storage_2d<rgba16float, write>;

// Each way, at most; and how long one is at least.
const STEPS: i32 = 20;
const STEP_PX: f32 = 1.5;
// Fainter is no ink, in parts of the ink where the walk began and at all.
const FAINT: f32 = 0.2;
const FAINTEST: f32 = 0.01;
// Cosines of the turn in a step from which on a line is another one, and up to which it is the same.
const TURN: vec2<f32> = vec2<f32>(0.75, 0.93);
// What a gap of a step leaves of what follows, and what is so little that the walk ends.
const GAP: f32 = 0.45;
const LOST: f32 = 0.05;
// How much of its own ink a line gives for the mean.
const EVEN: f32 = 0.7;
// Where a line begins to fade, in parts of the shortest one.
const BEGIN: f32 = 0.3;

struct Place {
    px: vec2<f32>,
    ink: f32,
    // Unit; 0 where there is no line.
    way: vec2<f32>,
}

fn ink_at(px: vec2<f32>, is_highlight: bool) -> f32 {
    let texel = textureSampleLevel(tone_ink, tone_sampler, px / vec2<f32>(view.size_px), 0.0);
    return select(texel.r, texel.g, is_highlight);
}

// The middle of the line about a place, with its direction, which goes on as `on` does.
fn middle(px: vec2<f32>, on: vec2<f32>, is_highlight: bool) -> Place {
    let texel = textureSampleLevel(tone_ink, tone_sampler, px / vec2<f32>(view.size_px), 0.0);
    let here = select(texel.r, texel.g, is_highlight);
    let double = texel.ba * inverseSqrt(max(dot(texel.ba, texel.ba), 1e-12));
    let half_way = vec2<f32>(sqrt(max(0.5 + 0.5 * double.x, 0.0)), select(-1.0, 1.0, double.y >= 0.0) * sqrt(max(0.5 - 0.5 * double.x, 0.0)));
    let way = select(-half_way, half_way, dot(half_way, on) >= 0.0) * f32(dot(texel.ba, texel.ba) > 1e-6);
    let across = vec2<f32>(-way.y, way.x);
    let before = ink_at(px - across, is_highlight);
    let after = ink_at(px + across, is_highlight);
    let to_middle = (after - before) / max(before + here + after, 1e-6);
    return Place(px + to_middle * across, max(here, max(before, after)), way);
}

// How far the line goes on, and the sum and weight of ink.
fn walk(start: Place, on: vec2<f32>, is_highlight: bool) -> vec3<f32> {
    let least = max(FAINT * start.ink, FAINTEST);
    var at_px = start.px;
    var way = on;
    var walked = vec3<f32>(0.0);
    // What is left of the line's being the same one.
    var same = 1.0;
    for (var i = 1; i <= along.steps && same > LOST; i++) {
        at_px += way * along.step_px;
        if any(at_px < vec2<f32>(0.0)) || any(at_px >= vec2<f32>(view.size_px)) {
            walked.x += same * (along.shortest_px - f32(i - 1) * along.step_px);
            break;
        }
        let next = middle(at_px, way, is_highlight);
        let there = smoothstep(0.5 * least, 1.5 * least, next.ink) * smoothstep(TURN.x, TURN.y, dot(next.way, way));
        same *= mix(GAP, 1.0, there);
        at_px = mix(at_px, next.px, there);
        way = normalize(mix(way, next.way, there) + vec2<f32>(1e-9, 0.0));
        walked += same * there * vec3<f32>(along.step_px, next.ink, 1.0);
    }
    return walked;
}

// What is left of the ink of a pixel after a walk both ways.
fn kept(pixel: vec2<i32>, is_highlight: bool, own: f32) -> f32 {
    let start = middle(vec2<f32>(pixel) + 0.5, vec2<f32>(1.0, 0.0), is_highlight);
    // Where there is no ink, there is no walk.
    var both = vec3<f32>(0.0);
    for (var side = 0; side < 2 && own > FAINTEST; side++) {
        both += walk(start, select(start.way, -start.way, side == 1), is_highlight);
    }
    let mean = (start.ink + both.y) / (1.0 + both.z);
    let even = mix(1.0, mean / max(start.ink, 1e-4), EVEN);
    return saturate(own * even * smoothstep(BEGIN, 1.0, (both.x + 1.0) / along.shortest_px));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let own = textureLoad(tone_ink, pixel, 0);
    // A pixel of both has the direction of one.
    let is_highlight = own.g > own.r;
    let ink = kept(pixel, is_highlight, max(own.r, own.g));
    let other = min(own.r, own.g);
    textureStore(long_ink, pixel, vec4<f32>(select(vec2<f32>(ink, other), vec2<f32>(other, ink), is_highlight), own.ba));
}
