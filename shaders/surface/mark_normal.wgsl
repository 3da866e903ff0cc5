// The mark_normal of the land: the surface's normal at the scale of marks, at one pixel of sixteen.
//
// Marks follow the land, not its pebbles: direction and foreshortening of hatching come from the surface as a coarser
// level of the pyramid has it, some MARK_NORMAL_PX pixels to a sample. It is a function of place and distance alone, so
// it is smooth across tiles and levels of detail, and it stays where it is when the camera turns. A tree is
// flat to marks, and faces the eye.
#import hachure::view::{View, distance_from_eye}
#import hachure::terrain::{terrain, grid_from_world, place_on_level, as_far_as_there}
#import hachure::surface::{surface_near, surface_at}
#import hachure::earth::{unbend, bend_normal}
#import hachure::mark_normal::{BLOCK_PX, pixel_of_block, own_mark_normal}
#import hachure::surface_id::{kind_of, LAND}

// Size of a sample of the level that is asked, in pixels.
const MARK_NORMAL_PX: f32 = 12.0;

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var surface_id: texture_2d<u32>;
@group(0) @binding(2) var position: texture_2d<f32>;
@group(0) @binding(3) var normal: texture_2d<f32>;
// xyz: unit normal in the world; w: distance along the view axis. All 0 is the sky.
@group(0) @binding(4) var mark_normal: texture_storage_2d<rgba32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let block = vec2<i32>(id.xy);
    if any(id.xy >= textureDimensions(mark_normal)) {
        return;
    }
    let pixel = pixel_of_block(view, block);
    let at = textureLoad(position, pixel, 0);
    if at.w <= 0.0 {
        textureStore(mark_normal, block, vec4<f32>(0.0));
        return;
    }
    if kind_of(textureLoad(surface_id, pixel, 0).r) != LAND {
        textureStore(mark_normal, block, vec4<f32>(own_mark_normal(view, pixel, textureLoad(normal, pixel, 0)), at.w));
        return;
    }
    let flat_place = unbend(at.xyz);
    let point = grid_from_world(flat_place.flat_m.xy);
    let sample_m = MARK_NORMAL_PX * distance_from_eye(view, at.xyz) / view.focal_px;
    let wanted = clamp(log2(sample_m / terrain.spacing_m), 0.0, f32(terrain.level_count - 1));
    let level = as_far_as_there(wanted, place_on_level(i32(wanted), point.g), point.g);
    let gradient = surface_at(surface_near(point.g, level)).gradient;
    let by_world = vec2<f32>(dot(gradient, point.dg_dx), dot(gradient, point.dg_dy));
    let n = bend_normal(flat_place, by_world);
    textureStore(mark_normal, block, vec4<f32>(n, at.w));
}
