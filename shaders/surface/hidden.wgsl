// Fills the area that is never visible with the nearest depth and no surface. See src/surface/hidden.rs.

// In normalised device coordinates.
@group(0) @binding(0) var<storage, read> corners: array<vec2<f32>>;

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    // Depth is reversed: 1 is at the near plane.
    return vec4<f32>(corners[index], 1.0, 1.0);
}

@fragment
fn fragment() -> @location(0) u32 {
    return 0u;
}
