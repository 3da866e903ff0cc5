// Colour conversions, and the noise of the paper. Colours are linear.
#define_import_path hachure::color

#import hachure::pcg::pcg

fn luminance(color: vec3<f32>) -> f32 {
    return dot(color, vec3<f32>(0.2126, 0.7152, 0.0722));
}

fn srgb_from_linear(color: vec3<f32>) -> vec3<f32> {
    let c = clamp(color, vec3<f32>(0.0), vec3<f32>(1.0));
    return select(1.055 * pow(c, vec3<f32>(1.0 / 2.4)) - 0.055, c * 12.92, c <= vec3<f32>(0.0031308));
}

// Inverts `srgb_from_linear` for colours within 0 to 1.
fn linear_from_srgb(color: vec3<f32>) -> vec3<f32> {
    return select(pow((color + 0.055) / 1.055, vec3<f32>(2.4)), color / 12.92, color <= vec3<f32>(0.04045));
}

fn hash(cell: vec2<i32>) -> f32 {
    return f32(pcg(vec2<u32>(cell)).x >> 8u) / 16777216.0;
}

// Returns value noise in [0, 1], continuous in its first derivative.
fn noise(p: vec2<f32>) -> f32 {
    let whole = floor(p);
    let cell = vec2<i32>(whole);
    let f = p - whole;
    let s = f * f * (3.0 - 2.0 * f);
    return mix(
        mix(hash(cell), hash(cell + vec2<i32>(1, 0)), s.x),
        mix(hash(cell + vec2<i32>(0, 1)), hash(cell + vec2<i32>(1, 1)), s.x),
        s.y);
}
