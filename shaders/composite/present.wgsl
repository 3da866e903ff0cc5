// Draws the picture into the window, scaled to it; or two eyes' pictures, side by side or mixed.
#import hachure::color::srgb_from_linear
#import hachure::full_screen::full_screen_corner

struct Present {
    // 1: the window's format does not encode to sRGB, so the shader does.
    encode: u32,
    // For two eyes. 1: side by side, the left eye on the left; 0: mixed.
    side_by_side: u32,
    window_px: vec2<f32>,
    // Rows that give red, green and blue from the left eye's linear colour, and from the right eye's.
    left_mix: array<vec4<f32>, 3>,
    right_mix: array<vec4<f32>, 3>,
    // Sizes of the pictures, which may be parts of their textures.
    picture_px: vec2<u32>,
    right_px: vec2<u32>,
    // For two styles: where the right one begins, as a part of the window's width.
    divider: f32,
}

@group(0) @binding(0) var<uniform> present: Present;
@group(0) @binding(1) var picture: texture_2d<f32>;
// The right eye's picture, or that of the right style; `fragment` does not read it.
@group(0) @binding(2) var right_picture: texture_2d<f32>;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return full_screen_corner(index);
}

@fragment
fn fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    return encoded(scaled(picture, present.picture_px, at.xy / present.window_px));
}

@fragment
fn pair(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let place = at.xy / present.window_px;
    if present.side_by_side == 1u {
        let half = vec2<f32>(fract(2.0 * place.x), place.y);
        return encoded(select(scaled(picture, present.picture_px, half), scaled(right_picture, present.right_px, half), place.x >= 0.5));
    }
    let left = scaled(picture, present.picture_px, place);
    let right = scaled(right_picture, present.right_px, place);
    var color: vec3<f32>;
    for (var i = 0; i < 3; i++) {
        color[i] = dot(present.left_mix[i].xyz, left) + dot(present.right_mix[i].xyz, right);
    }
    return encoded(clamp(color, vec3<f32>(0.0), vec3<f32>(1.0)));
}

@fragment
fn divided(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let place = at.xy / present.window_px;
    if place.x < present.divider {
        return encoded(scaled(picture, present.picture_px, place));
    }
    return encoded(scaled(right_picture, present.right_px, place));
}

fn encoded(color: vec3<f32>) -> vec4<f32> {
    return vec4<f32>(select(color, srgb_from_linear(color), present.encode != 0u), 1.0);
}

// Samples a picture bilinearly at a position from 0 to 1.
fn scaled(of_eye: texture_2d<f32>, size_px: vec2<u32>, place: vec2<f32>) -> vec3<f32> {
    let size = vec2<f32>(size_px);
    let p = place * size - 0.5;
    let whole = floor(p);
    let f = p - whole;
    let last = vec2<i32>(size) - 1;
    let i = vec2<i32>(whole);
    return mix(
        mix(load(of_eye, i, last), load(of_eye, i + vec2<i32>(1, 0), last), f.x),
        mix(load(of_eye, i + vec2<i32>(0, 1), last), load(of_eye, i + vec2<i32>(1, 1), last), f.x),
        f.y);
}

fn load(of_eye: texture_2d<f32>, pixel: vec2<i32>, last: vec2<i32>) -> vec3<f32> {
    return textureLoad(of_eye, clamp(pixel, vec2<i32>(0), last), 0).rgb;
}
