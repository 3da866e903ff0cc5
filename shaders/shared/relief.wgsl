// Data that the passes of light warping share: the gradient of inverse depth, and the scale at which it is blurred.
#define_import_path hachure::relief
#import hachure::power::power
#import hachure::view::View

struct ReliefRules {
    // Standard deviation of the blur, in pixels, and the factors by which it grows far away, away from the focus, and
    // on level land.
    scale_px: f32,
    coarser_far: f32,
    coarser_aside: f32,
    coarser_level: f32,
    // Angle between the normals of neighbours above which there is a crease between them.
    crease_rad: f32,
    // Factor of curvature before its arctangent, in pixels.
    alpha_px: f32,
    // Part of the foreshortening at flat angles that counts as curvature, 0 to 1.
    foreshortening: f32,
    pad: f32,
}

// The depth gradient at a pixel, as the blur reads it.
struct DepthGradient {
    // Gradient of the inverse depth across the picture, in 1/m: n_x / (n . p), n_y / (n . p). It is constant on a
    // plane.
    slope: vec2<f32>,
    // 0 at a silhouette, at a crease and in the sky; 1 where the surface is continuous all around.
    conductance: f32,
    // Requested standard deviation of the blur, in pixels.
    sigma_px: f32,
}

// Steps per pixel in which the scale is stored with a gradient.
const SCALE_STEPS: f32 = 256.0;
// Relative distance from a pixel's plane beyond which a point is of another surface; more is allowed at flat angles.
const STEP: f32 = 0.01;

// Two numbers share the last channel: the scale as an integer, and the conductance as a fraction below one half.
fn packed(gradient: DepthGradient, inverse_depth: f32) -> vec4<f32> {
    let scale = floor(gradient.sigma_px * SCALE_STEPS);
    return vec4<f32>(gradient.slope, inverse_depth, scale + 0.5 * gradient.conductance);
}

fn unpacked(texel: vec4<f32>) -> DepthGradient {
    let scale = floor(texel.w);
    return DepthGradient(texel.xy, 2.0 * (texel.w - scale), scale / SCALE_STEPS);
}

// Returns 1 where the point at `offset_px` is on the plane through the pixel, and 0 where another surface is.
fn on_plane(view: View, own: vec4<f32>, other: vec4<f32>, offset_px: vec2<f32>) -> f32 {
    let expected = own.z + dot(own.xy, offset_px) / view.focal_px;
    let miss = abs(other.z - expected) / max(own.z, 1e-30);
    // A surface at a flat angle curves away quickly.
    let steep = length(own.xy) / max(own.z * view.focal_px, 1e-30);
    let allowed = STEP + steep * max(abs(offset_px.x), abs(offset_px.y));
    return 1.0 - smoothstep(allowed, 3.0 * allowed, miss);
}

// Returns the view-centred curvature at a pixel, times alpha: xx, xy, yy, positive where the surface bulges toward the
// eye (Vergne and others 2009, sections 4.2 and 4.4, step 7: a Sobel filter on the gradient, and flat where conductance
// is 0 around the pixel). `facing` is the cosine between normal and ray.
fn bend_at(view: View, rules: ReliefRules, depth_gradient: texture_2d<f32>, pixel: vec2<i32>, depth_m: f32, facing: f32) -> vec3<f32> {
    let own = unpacked(textureLoad(depth_gradient, pixel, 0));
    // The gradient of a pixel next to a silhouette matches none around it.
    var whole = own.conductance;
    var by_x = vec2<f32>(0.0);
    var by_y = vec2<f32>(0.0);
    for (var i = 0; i < 9; i++) {
        let way = vec2<i32>(i % 3, i / 3) - 1;
        let at = clamp(pixel + way, vec2<i32>(0), vec2<i32>(view.size_px) - 1);
        let neighbour = unpacked(textureLoad(depth_gradient, at, 0));
        whole = min(whole, neighbour.conductance);
        // Across a silhouette the surface is assumed to continue unchanged.
        let slope = mix(own.slope, neighbour.slope, neighbour.conductance);
        by_x += f32(way.x * (2 - abs(way.y))) / 8.0 * slope;
        by_y += f32(way.y * (2 - abs(way.x))) / 8.0 * slope;
    }
    // Inverse depth falls where depth rises.
    let bend = -depth_m * vec3<f32>(by_x.x, 0.5 * (by_x.y + by_y.x), by_y.y);
    let seen_along = power(facing, 2.0 * (1.0 - rules.foreshortening));
    return rules.alpha_px * whole * seen_along * bend;
}
