// Where each pixel's content was in the previous frame: exact for a world that stands still, sky included. Jitter is no
// motion.
#import hachure::view::{View, ray_of_pixel}

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
    // The sky is a direction: its last coordinate is 0, and the camera's step does not move it.
    let point = select(vec4<f32>(ray_of_pixel(view, pixel), 0.0), vec4<f32>(at.xyz, 1.0), at.w > 0.0);
    let clip = view.previous_clip_from_camera * point;
    // What was beside or behind the previous eye has no place in its picture: it comes from far outside.
    let ndc = clip.xy / max(clip.w, 1e-6 * length(clip.xyz));
    let before_px = vec2<f32>(ndc.x * 0.5 + 0.5, 0.5 - ndc.y * 0.5) * vec2<f32>(view.size_px);
    textureStore(motion, pixel, vec4<f32>(vec2<f32>(pixel) + 0.5 - view.jitter_px - before_px, 0.0, 0.0));
}
