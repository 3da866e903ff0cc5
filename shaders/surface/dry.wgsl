// Replaces `surface/water` if no tile of the view has water: writes that no pixel is water.
@group(0) @binding(0) var water: texture_storage_2d<r32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    textureStore(water, vec2<i32>(id.xy), vec4<f32>(0.0));
}
