// How far an update saw at each pixel and its neighbours. The next update asks it what nearer land hid (temporal.wgsl):
// a place is hidden only if what is seen all around it is nearer, for a contour lies where the surface ends.
@group(0) @binding(0) var depth: texture_depth_2d;
// Reversed, as the depth: near / distance; 0 is the sky.
@group(0) @binding(1) var farthest: texture_storage_2d<r32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = vec2<i32>(textureDimensions(depth));
    let pixel = vec2<i32>(id.xy);
    if any(pixel >= size) {
        return;
    }
    var least = 1.0;
    for (var i = 0; i < 9; i++) {
        let around = clamp(pixel + vec2<i32>(i % 3, i / 3) - 1, vec2<i32>(0), size - 1);
        least = min(least, textureLoad(depth, around, 0));
    }
    textureStore(farthest, pixel, vec4<f32>(least));
}
