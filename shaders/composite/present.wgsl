// The picture onto the window, scaled to it.
#import hachure::color::srgb_from_linear

struct Present {
    // 1: the window's format does not encode to sRGB by itself.
    encode: u32,
    pad: u32,
    window_px: vec2<f32>,
}

@group(0) @binding(0) var<uniform> present: Present;
@group(0) @binding(1) var picture: texture_2d<f32>;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    let corner = vec2<f32>(f32((index << 1u) & 2u), f32(index & 2u));
    return vec4<f32>(corner * 2.0 - 1.0, 0.0, 1.0);
}

@fragment
fn fragment(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let size = vec2<f32>(textureDimensions(picture));
    let p = at.xy / present.window_px * size - 0.5;
    let whole = floor(p);
    let f = p - whole;
    let last = vec2<i32>(size) - 1;
    let i = vec2<i32>(whole);
    let color = mix(
        mix(load(i, last), load(i + vec2<i32>(1, 0), last), f.x),
        mix(load(i + vec2<i32>(0, 1), last), load(i + vec2<i32>(1, 1), last), f.x),
        f.y);
    return vec4<f32>(select(color, srgb_from_linear(color), present.encode != 0u), 1.0);
}

fn load(pixel: vec2<i32>, last: vec2<i32>) -> vec3<f32> {
    return textureLoad(picture, clamp(pixel, vec2<i32>(0), last), 0).rgb;
}
