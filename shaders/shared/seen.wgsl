// The two pictures of the visible surface, which most passes read: where the surface is, and its normal.
//
// `distance_m` holds the distance along the view axis, 0 in the sky. The surface is at that distance on the ray through
// the pixel's centre, so the position need not be stored: the passes that write distances compute it in the same way.
//
// `normal` holds an octahedral normal (Cigolle et al. 2014, "A Survey of Efficient Representations for Independent Unit
// Vectors") in 16 bits per coordinate, and in scenes with models or trees a second word with the lightness.
#define_import_path hachure::seen
#import hachure::view::{View, place_of_pixel}

// Half the range of a coordinate of an octahedral normal. Coordinates are 1 to 65535, so that no normal is 0, which is
// the sky, and both 0 and 1 are exact.
const NORMAL_SCALE: f32 = 32767.0;
const NORMAL_OFFSET: f32 = 32768.0;
// Stored for a lightness of 0: it is -0.0, because the word 0 stands for a lightness of 1.
const ZERO_LIGHTNESS: u32 = 0x80000000u;

// Returns the position that a pixel sees (xyz, in metres from the rig's origin), and its distance along the view axis
// (w). All 0 is the sky.
fn place_at_distance(view: View, pixel: vec2<i32>, along_m: f32) -> vec4<f32> {
    return select(vec4<f32>(0.0), vec4<f32>(place_of_pixel(view, pixel, along_m), along_m), along_m > 0.0);
}

// Reads the position that a pixel sees, as `place_at_distance`.
fn place_seen(view: View, distance_m: texture_2d<f32>, pixel: vec2<i32>) -> vec4<f32> {
    return place_at_distance(view, pixel, textureLoad(distance_m, pixel, 0).r);
}

// Returns the word of a unit normal. Its error is at most 7e-5 radians.
fn word_of_normal(n: vec3<f32>) -> u32 {
    let at = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    let folded = (1.0 - abs(at.yx)) * select(vec2<f32>(-1.0), vec2<f32>(1.0), at >= vec2<f32>(0.0));
    let place = clamp(select(at, folded, n.z < 0.0), vec2<f32>(-1.0), vec2<f32>(1.0));
    let whole = vec2<u32>(round(place * NORMAL_SCALE) + NORMAL_OFFSET);
    return whole.x | whole.y << 16u;
}

// Returns the unit normal of a word; 0 for the sky.
fn normal_of_word(word: u32) -> vec3<f32> {
    // In units of 1 / NORMAL_SCALE, which the length takes out. Signed integers convert faster on a CPU.
    let at = vec2<f32>(vec2<i32>(i32(word & 0xffffu), i32(word >> 16u)) - i32(NORMAL_OFFSET));
    let z = NORMAL_SCALE - abs(at.x) - abs(at.y);
    let below = max(-z, 0.0);
    let n = vec3<f32>(at - select(vec2<f32>(-below), vec2<f32>(below), at >= vec2<f32>(0.0)), z);
    return select(n * inverseSqrt(dot(n, n)), vec3<f32>(0.0), word == 0u);
}

// Reads the unit normal of the visible surface; 0 in the sky.
fn normal_seen(normal: texture_2d<u32>, pixel: vec2<i32>) -> vec3<f32> {
    return normal_of_word(textureLoad(normal, pixel, 0).r);
}

// Reads the unit normal of the visible surface, and its lightness, which is 1 on land; normal and lightness are 0 in
// the sky.
fn surface_seen(normal: texture_2d<u32>, pixel: vec2<i32>) -> vec4<f32> {
    let words = textureLoad(normal, pixel, 0);
    let lightness = select(bitcast<f32>(words.g), f32(words.r != 0u), words.g == 0u);
    return vec4<f32>(normal_of_word(words.r), lightness);
}

// Returns the two words of a unit normal and a lightness.
fn words_of_surface(surface: vec4<f32>) -> vec4<u32> {
    let lightness = bitcast<u32>(surface.w);
    return vec4<u32>(word_of_normal(surface.xyz), select(lightness, ZERO_LIGHTNESS, lightness == 0u), 0u, 0u);
}
