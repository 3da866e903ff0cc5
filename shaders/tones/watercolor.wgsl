// Watercolour: washes stray from their outlines, darken at their edges, and settle in the paper.
//
// After Bousseau and others 2006: pigment density d changes a colour C to C - (C - C²)(d - 1), and d depends on wet
// edges, granulation and flow. Edges are found by the difference to the surroundings. The paper warps texture
// coordinates; here the positions at which the wash is sampled are warped, by noise that is fixed in the world, so
// washes keep their shape while the camera moves. Granulation is a property of the paper and is fixed to the sheet.
#import hachure::view::{View, distance_from_eye}
#import hachure::seen::place_seen
#import hachure::color::{luminance, noise}
#import hachure::wobble::{Anchor, wobble}

struct Watercolor {
    edge: f32,
    edge_px: f32,
    granulation: f32,
    flow: f32,
    warp_px: f32,
    pad_a: f32,
    pad_b: f32,
    pad_c: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> watercolor: Watercolor;
@group(0) @binding(2) var<uniform> anchor: Anchor;
@group(0) @binding(3) var distance_m: texture_2d<f32>;
@group(0) @binding(4) var tone: texture_2d<f32>;
// As `tone`.
@group(0) @binding(5) var washed: texture_storage_2d<rgba16float, write>;

// Returns the wash at a position of the picture, interpolated between pixels and clamped to the border. Where there is
// no land it returns `own`: paint ends at bare paper, and does not run into it.
fn wash_at(px: vec2<f32>, own: vec4<f32>) -> vec4<f32> {
    let last = vec2<i32>(view.size_px) - 1;
    if textureLoad(distance_m, clamp(vec2<i32>(round(px)), vec2<i32>(0), last), 0).r <= 0.0 {
        return own;
    }
    let whole = floor(px);
    let f = px - whole;
    let i = vec2<i32>(whole);
    let a = clamp(i, vec2<i32>(0), last);
    let b = clamp(i + 1, vec2<i32>(0), last);
    return mix(
        mix(textureLoad(tone, a, 0), textureLoad(tone, vec2<i32>(b.x, a.y), 0), f.x),
        mix(textureLoad(tone, vec2<i32>(a.x, b.y), 0), textureLoad(tone, b, 0), f.x), f.y);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let at = place_seen(view, distance_m, pixel);
    let own = textureLoad(tone, pixel, 0);
    if at.w <= 0.0 {
        textureStore(washed, pixel, own);
        return;
    }
    // Noise of some 24 pixels for two directions, and noise of a hundred pixels for the flow.
    let pixel_m = distance_from_eye(view, at.xyz) / view.focal_px;
    // The second is the same noise in a world rotated around its diagonal.
    let turned = Anchor(anchor.blocks.yzx, 0u, anchor.rest_m.yzx, 0u);
    let stray = vec2<f32>(wobble(anchor, at.xyz, pixel_m), wobble(turned, at.yzx, pixel_m));
    let slow = wobble(anchor, at.xyz, 4.0 * pixel_m);
    let px = vec2<f32>(pixel) + watercolor.warp_px * stray;
    let here = wash_at(px, own);
    // The surroundings, at two radii alternately: a wash ends where its surroundings are lighter.
    var around = 0.0;
    for (var i = 0; i < 8; i++) {
        let angle = f32(i) * 0.785398;
        let reach = watercolor.edge_px * select(1.0, 0.5, (i & 1) == 1);
        around += luminance(wash_at(px + reach * vec2<f32>(cos(angle), sin(angle)), here).rgb);
    }
    let ends = clamp((around / 8.0 - luminance(here.rgb)) * 6.0, 0.0, 1.0);
    let sheet = vec2<f32>(pixel + view.origin_px);
    let valley = noise(sheet * 0.43) * 0.6 + noise(sheet * 0.91 + 17.0) * 0.4 - 0.5;
    let density = 1.0 + watercolor.edge * ends + watercolor.granulation * valley + watercolor.flow * 0.6 * (slow + 0.35 * stray.x);
    let color = here.rgb - (here.rgb - here.rgb * here.rgb) * (density - 1.0);
    textureStore(washed, pixel, vec4<f32>(clamp(color, vec3<f32>(0.0), vec3<f32>(1.0)), own.a));
}
