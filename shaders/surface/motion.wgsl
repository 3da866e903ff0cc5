// Where each pixel's content was in the previous frame: exact for a world that stands still, sky included.
#import hachure::view::{View, motion_of, ray_of_pixel}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var position: texture_2d<f32>;
@group(0) @binding(2) var motion: texture_storage_2d<rg32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let at = textureLoad(position, pixel, 0);
    // The sky is a direction.
    let point = select(vec4<f32>(ray_of_pixel(view, pixel), 0.0), vec4<f32>(at.xyz, 1.0), at.w > 0.0);
    textureStore(motion, pixel, vec4<f32>(motion_of(view, pixel, point), 0.0, 0.0));
}
