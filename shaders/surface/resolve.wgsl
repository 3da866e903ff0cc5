// From the depth of the mesh to the position and normal of the surface itself.
//
// The mesh is within the level-of-detail error of the surface. The bicubic surface at the scale of the pixel's
// footprint, expanded to second order at the mesh's hit, is cut with the pixel's ray; there the normal is the
// analytic derivative. Position and normal then belong to one smooth surface, and LSA contours do not see the mesh.
// Near silhouettes, where the ray misses the smooth surface, the mesh's own position stays.
#import hachure::view::{View, ray_of_pixel}
#import hachure::terrain::{terrain, grid_from_world, level_at, surface_at}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var depth: texture_depth_2d;
@group(0) @binding(2) var position: texture_storage_2d<rgba32float, write>;
@group(0) @binding(3) var normal: texture_storage_2d<rgba32float, write>;

// Where the ray meets the surface, as a distance along the view axis from the mesh's hit; 0 where it does not.
fn step_to_surface(above_m: f32, closing: f32, bend: f32) -> f32 {
    // above + closing t - bend t^2 / 2 = 0, the root that is nearer.
    let inside = closing * closing + 2.0 * bend * above_m;
    if inside < 0.0 || closing == 0.0 {
        return 0.0;
    }
    return -2.0 * above_m / (closing + sign(closing) * sqrt(inside));
}

// The surface around a point of the ray, and the step along the ray that leads onto it.
struct Cut {
    gradient: vec2<f32>,
    // Change of the gradient with the way along the ray.
    bent: vec2<f32>,
    above_m: f32,
    step_m: f32,
    // The step leaves the place where the expansion holds. Normals need more care than positions: beyond a hundredth
    // of the distance between samples they would be off by more than a thousandth on rough land.
    is_long: bool,
}

fn cut(ray: vec3<f32>, along_m: f32) -> Cut {
    let at_m = ray * along_m;
    let point = grid_from_world(at_m.xy);
    let level = level_at(point.g, length(at_m));
    let surface = surface_at(point.g, level);
    // The ray's way over the grid.
    let way = point.dg_dx * ray.x + point.dg_dy * ray.y;
    let bent = vec2<f32>(dot(surface.curvature.xy, way), dot(surface.curvature.yz, way));
    let above_m = at_m.z - surface.height_m;
    let step_m = step_to_surface(above_m, ray.z - dot(surface.gradient, way), dot(bent, way));
    return Cut(surface.gradient, bent, above_m, step_m, abs(step_m) * length(way) > 0.01 * exp2(floor(level)));
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
    let mesh_m = view.near_m / z;
    let pixel_m = mesh_m / view.focal_px;
    var along_m = mesh_m;
    var found = cut(ray, along_m);
    var gradient = found.gradient;
    // What the mesh may be away from the surface, and how far the ray may go to make up for it.
    if abs(found.above_m) < 4.0 * pixel_m && abs(found.step_m) < 32.0 * pixel_m {
        // A step beyond the reach of the expansion is tried at its end, and goes on from there if that is nearer.
        for (var tries = 0; found.is_long && tries < 2; tries++) {
            let tried_m = along_m + found.step_m;
            let tried = cut(ray, tried_m);
            if abs(tried.above_m) >= abs(found.above_m) {
                break;
            }
            along_m = tried_m;
            found = tried;
        }
        gradient = found.gradient;
        if !found.is_long {
            along_m += found.step_m;
            gradient += found.bent * found.step_m;
        }
    }
    let point = grid_from_world(ray.xy * along_m);
    let by_world = vec2<f32>(dot(gradient, point.dg_dx), dot(gradient, point.dg_dy));
    textureStore(position, pixel, vec4<f32>(ray * along_m, along_m));
    textureStore(normal, pixel, vec4<f32>(normalize(vec3<f32>(-by_world, 1.0)), 1.0));
}
