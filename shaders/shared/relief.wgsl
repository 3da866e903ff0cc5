// What the passes of relief know of each other: the gradient of depth, and how far it is blurred.
#define_import_path hachure::relief
#import hachure::view::View

struct ReliefRules {
    // Standard deviation of the blur, where nothing makes it coarser; how many times more there is far away, away from
    // the focus, and on level land.
    scale_px: f32,
    coarser_far: f32,
    coarser_aside: f32,
    coarser_level: f32,
    // Neighbours whose normals differ by more have a crease between them.
    crease_rad: f32,
    // What curvature is multiplied by, before its arctangent.
    alpha_px: f32,
    // How much of the foreshortening of what is seen along itself counts as curvature.
    foreshortening: f32,
    pad: f32,
}

// What a pixel sees, as the blur reads it.
struct DepthGradient {
    // Of the inverse depth across the picture, in 1/m: n_x / (n . p), n_y / (n . p). On a plane it is the same
    // everywhere.
    slope: vec2<f32>,
    // 0: a silhouette, a crease, or nothing at all. 1: all around is one surface.
    conductance: f32,
    // Standard deviation of the blur that is asked.
    sigma_px: f32,
}

// Steps of the scale that is kept with a gradient.
const SCALE_STEPS: f32 = 256.0;
// A place of another surface lies off the plane of a pixel by more than this, by its distance, and more where the plane is
// seen along itself.
const STEP: f32 = 0.01;

// Two numbers share a channel: a whole one, and a fraction below one half.
fn packed(gradient: DepthGradient, inverse_depth: f32) -> vec4<f32> {
    let scale = floor(gradient.sigma_px * SCALE_STEPS);
    return vec4<f32>(gradient.slope, inverse_depth, scale + 0.5 * gradient.conductance);
}

fn unpacked(texel: vec4<f32>) -> DepthGradient {
    let scale = floor(texel.w);
    return DepthGradient(texel.xy, 2.0 * (texel.w - scale), scale / SCALE_STEPS);
}

// 1 where what is `offset_px` away lies on the plane through a pixel, and 0 where another surface is.
fn on_plane(view: View, own: vec4<f32>, other: vec4<f32>, offset_px: vec2<f32>) -> f32 {
    let expected = own.z + dot(own.xy, offset_px) / view.focal_px;
    let miss = abs(other.z - expected) / max(own.z, 1e-30);
    // A surface that is seen along itself bends away at once.
    let steep = length(own.xy) / max(own.z * view.focal_px, 1e-30);
    let allowed = STEP + steep * max(abs(offset_px.x), abs(offset_px.y));
    return 1.0 - smoothstep(allowed, 3.0 * allowed, miss);
}

// The view-centred curvature at a pixel, times alpha: xx, xy, yy, positive where the surface bulges toward the eye (Vergne
// and others 2009, sections 4.2 and 4.4, step 7: a Sobel filter on the gradient, and flat where conductance is 0 about
// the pixel).
// `facing` is the cosine between normal and ray.
fn bend_at(view: View, rules: ReliefRules, depth_gradient: texture_2d<f32>, pixel: vec2<i32>, depth_m: f32, facing: f32) -> vec3<f32> {
    let own = unpacked(textureLoad(depth_gradient, pixel, 0));
    // A pixel beside a silhouette has a gradient that nothing around it has.
    var whole = own.conductance;
    var by_x = vec2<f32>(0.0);
    var by_y = vec2<f32>(0.0);
    for (var i = 0; i < 9; i++) {
        let way = vec2<i32>(i % 3, i / 3) - 1;
        let at = clamp(pixel + way, vec2<i32>(0), vec2<i32>(view.size_px) - 1);
        let beside = unpacked(textureLoad(depth_gradient, at, 0));
        whole = min(whole, beside.conductance);
        // Across a silhouette the surface is taken to go on as it is.
        let slope = mix(own.slope, beside.slope, beside.conductance);
        by_x += f32(way.x * (2 - abs(way.y))) / 8.0 * slope;
        by_y += f32(way.y * (2 - abs(way.x))) / 8.0 * slope;
    }
    // Inverse depth falls where depth rises.
    let bend = -depth_m * vec3<f32>(by_x.x, 0.5 * (by_x.y + by_y.x), by_y.y);
    let seen_along = pow(facing, 2.0 * (1.0 - rules.foreshortening));
    return rules.alpha_px * whole * seen_along * bend;
}
