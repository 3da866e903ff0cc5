// Computes distance and normal of the surface itself from the depth of the mesh.
//
// The mesh is within the level-of-detail error of the surface. The bicubic surface at the scale of the pixel's
// footprint, expanded to second order at the hit on the mesh, is intersected with the pixel's ray; the normal there is
// the analytic derivative. Position and normal then belong to one smooth surface, and LSA contours do not show the
// mesh. Near silhouettes, where the ray misses the smooth surface, the mesh's own position is used.
#import hachure::view::{View, place_of_pixel, ray_of_pixel}
#import hachure::seen::word_of_normal
#import hachure::terrain::{grid_from_world, surface_level}
#import hachure::surface::{surface_near, surface_at, Surface}
#import hachure::earth::{unbend, unbend_direction, bend_normal, Unbent}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var depth: texture_depth_2d;
@group(0) @binding(2) var distance_m: texture_storage_2d<r32float, write>;
#ifdef LIGHTNESS
// The scene has surfaces that are darker than land.
@group(0) @binding(3) var normal: texture_storage_2d<rg32uint, write>;
#else
@group(0) @binding(3) var normal: texture_storage_2d<r32uint, write>;
#endif

// Depth of the area that is never visible (hidden.wgsl), the nearest possible.
const HIDDEN: f32 = 1.0;

// Returns where the ray meets the surface, as a distance along the view axis from the hit on the mesh; 0 if it misses.
fn step_to_surface(above_m: f32, closing: f32, bend: f32) -> f32 {
    // above + closing t - bend t^2 / 2 = 0; the nearer root.
    let inside = closing * closing + 2.0 * bend * above_m;
    if inside < 0.0 || closing == 0.0 {
        return 0.0;
    }
    return -2.0 * above_m / (closing + sign(closing) * sqrt(inside));
}

// A point of the ray relative to the surface.
struct Cut {
    gradient: vec2<f32>,
    // Derivative of the gradient along the ray.
    bent: vec2<f32>,
    above_m: f32,
    // Distance to the surface along the view axis.
    step_m: f32,
}

fn cut(surface: Surface, z_m: f32, ray_z: f32, way: vec2<f32>) -> Cut {
    let bent = vec2<f32>(dot(surface.curvature.xy, way), dot(surface.curvature.yz, way));
    let above_m = z_m - surface.height_m;
    let step_m = step_to_surface(above_m, ray_z - dot(surface.gradient, way), dot(bent, way));
    return Cut(surface.gradient, bent, above_m, step_m);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let z = textureLoad(depth, pixel, 0);
    if z <= 0.0 || z >= HIDDEN {
        // Sky: the normal and the distance are 0.
        textureStore(distance_m, pixel, vec4<f32>(0.0));
        textureStore(normal, pixel, vec4<u32>(0u));
        return;
    }
    let ray = ray_of_pixel(view, pixel);
    let mesh_m = view.near_m / z;
    let pixel_m = mesh_m / view.focal_px;
    var along_m = mesh_m;
    var tried_m = mesh_m;
    var gradient = vec2<f32>(0.0);
    var dg_dx = vec2<f32>(0.0);
    var dg_dy = vec2<f32>(0.0);
    var above_m = 0.0;
    var tries = 0;
    // The first iteration is at the hit on the mesh. A step beyond the range of the expansion is tried at its end, and
    // continues from there if that is nearer. One loop, tested at its end: software drivers run both sides of a branch.
    loop {
        let at = unbend(place_of_pixel(view, pixel, tried_m));
        let step = unbend_direction(at, ray);
        let point = grid_from_world(at.flat_m.xy);
        let near = surface_near(point.g, surface_level(point.g, length(at.flat_m)));
        // The ray's direction over the grid; the map is straight enough over a few pixels.
        let way = point.dg_dx * step.x + point.dg_dy * step.y;
        let found = cut(surface_at(near), at.flat_m.z, step.z, way);
        var goes_on = false;
        if tries == 0 || abs(found.above_m) < abs(above_m) {
            along_m = tried_m;
            gradient = found.gradient;
            dg_dx = point.dg_dx;
            dg_dy = point.dg_dy;
            above_m = found.above_m;
            // Limits of the mesh's distance from the surface, and of the step that corrects it.
            if abs(above_m) < 4.0 * pixel_m && abs(found.step_m) < 32.0 * pixel_m {
                // Normals need more precision than positions: beyond a hundredth of a cell they would be off by a
                // thousandth.
                let short_m = 0.01 * exp2(floor(near.level)) / max(length(way), 1e-20);
                if abs(found.step_m) <= short_m {
                    along_m += found.step_m;
                    gradient += found.bent * found.step_m;
                } else {
                    tried_m = along_m + found.step_m;
                    tries += 1;
                    goes_on = tries < 3;
                }
            }
        }
        continuing {
            break if !goes_on;
        }
    }
    let by_world = vec2<f32>(dot(gradient, dg_dx), dot(gradient, dg_dy));
    let at_m = place_of_pixel(view, pixel, along_m);
    textureStore(distance_m, pixel, vec4<f32>(along_m, 0.0, 0.0, 0.0));
    textureStore(normal, pixel, vec4<u32>(word_of_normal(bend_normal(unbend(at_m), by_world)), 0u, 0u, 0u));
}
