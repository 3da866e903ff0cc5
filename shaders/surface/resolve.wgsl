// From the depth of the mesh to the position and normal of the surface itself.
//
// The mesh is within the level-of-detail error of the surface. Two Newton steps along the pixel's ray take its depth
// to the bicubic surface at the scale of the pixel's footprint, where the normal is the analytic derivative: position
// and normal then belong to one smooth surface, and LSA contours do not see the mesh. Near silhouettes, where the ray
// grazes or misses the smooth surface, the mesh's own position stays.
#import hachure::view::{View, ray_of_pixel}
#import hachure::terrain::{terrain, grid_from_world, level_at, surface_at, GridPoint}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var depth: texture_depth_2d;
@group(0) @binding(2) var position: texture_storage_2d<rgba32float, write>;
@group(0) @binding(3) var normal: texture_storage_2d<rgba32float, write>;

struct Hit {
    // Height above the surface, and its change with distance along the view axis.
    above_m: f32,
    above_per_m: f32,
    gradient: vec2<f32>,
}

fn measure(at_m: vec3<f32>, ray: vec3<f32>) -> Hit {
    let point = grid_from_world(at_m.xy);
    let surface = surface_at(point.g, level_at(point.g, length(at_m)));
    let gradient = vec2<f32>(dot(surface.yz, point.dg_dx), dot(surface.yz, point.dg_dy));
    return Hit(at_m.z - surface.x, ray.z - dot(gradient, ray.xy), gradient);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let z = textureLoad(depth, pixel, 0);
    if z <= 0.0 {
        // Sky: no normal, and a position without a length.
        textureStore(position, pixel, vec4<f32>(0.0));
        textureStore(normal, pixel, vec4<f32>(0.0));
        return;
    }
    let ray = ray_of_pixel(view, pixel);
    let steepness = 0.02 * length(ray);
    let mesh_m = view.near_m / z;
    var along_m = mesh_m;
    var hit = measure(ray * along_m, ray);
    let pixel_m = along_m * length(ray) / view.focal_px;
    // The mesh is this near to the surface; a longer way leads to another slope.
    let reach_m = 4.0 * pixel_m;
    if abs(hit.above_per_m) > steepness && abs(hit.above_m) < reach_m {
        let step_m = -hit.above_m / hit.above_per_m;
        let there = measure(ray * (along_m + step_m), ray);
        // A step that does not come nearer has left the slope.
        if abs(there.above_m) <= abs(hit.above_m) && along_m + step_m > 0.0 {
            along_m += step_m;
            hit = there;
            if abs(hit.above_per_m) > steepness {
                along_m -= hit.above_m / hit.above_per_m;
            }
        }
    }
    textureStore(position, pixel, vec4<f32>(ray * along_m, along_m));
    textureStore(normal, pixel, vec4<f32>(normalize(vec3<f32>(-hit.gradient, 1.0)), 1.0));
}
