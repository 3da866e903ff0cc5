// The triangle that covers a whole texture (src/gpu/full_screen.rs).
#define_import_path hachure::full_screen

// Returns the position of one of its three vertices.
fn full_screen_corner(index: u32) -> vec4<f32> {
    let corner = vec2<f32>(f32((index << 1u) & 2u), f32(index & 2u));
    return vec4<f32>(corner * 2.0 - 1.0, 0.0, 1.0);
}
