// Removes the land from the distances that hatching reads, in a style whose land has rows of hachures: only models and
// trees are hatched.
#import hachure::view::View
#import hachure::surface_id::{has_trait, ON_GRID}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var surface_id: texture_2d<u32>;
@group(0) @binding(2) var distance_m: texture_2d<f32>;
// 0 where land is visible, as for the sky.
@group(0) @binding(3) var distance_off_land_m: texture_storage_2d<r32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let is_land = has_trait(textureLoad(surface_id, pixel, 0).r, ON_GRID);
    textureStore(distance_off_land_m, pixel, select(textureLoad(distance_m, pixel, 0), vec4<f32>(0.0), is_land));
}
