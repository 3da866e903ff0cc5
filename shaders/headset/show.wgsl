// Copies an eye's picture to the headset's image, pixel by pixel, with a vignette while the view moves.
//
// The vignette leaves the picture unchanged within 22 degrees of the lens's axis, and at full strength makes it black
// beyond 37 degrees: motion in peripheral vision is what makes people sick.
#import hachure::full_screen::full_screen_corner

struct Show {
    // Upper left corner of the picture, in tangents from the lens's axis, x to the right and y down.
    corner_tangent: vec2<f32>,
    tangent_per_px: vec2<f32>,
    // Size of the picture, which may be a part of its texture.
    size_px: vec2<f32>,
    // 0: no vignette. 1: the border is black.
    vignette: f32,
    pad: f32,
}

const CLEAR_TANGENT: f32 = 0.4;
const BLACK_TANGENT: f32 = 0.75;

@group(0) @binding(0) var<uniform> show: Show;
@group(0) @binding(1) var picture: texture_2d<f32>;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return full_screen_corner(index);
}

@fragment
fn fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    // Beyond the picture its border goes on: the runtime may filter it.
    let last = vec2<i32>(show.size_px) - 1;
    let color = textureLoad(picture, clamp(vec2<i32>(at.xy), vec2<i32>(0), last), 0).rgb;
    let tangent = length(show.corner_tangent + at.xy * show.tangent_per_px);
    let dark = show.vignette * smoothstep(CLEAR_TANGENT, BLACK_TANGENT, tangent);
    return vec4<f32>(color * (1.0 - dark), 1.0);
}
