// Local Surface Approximation contours (Zaidi et al., Eqs. 1 to 8).
//
// For each pair of opposite neighbours (q and its control c) of pixel p: a sphere through p and c that matches their
// normals predicts q, and the error is the distance of q from that prediction.
//
// ANTIALIASED: the same is done again with pixels twice as far (Eq. 8). A detail smaller than a pixel has an error only
// where a pixel hits it; where the surface around it continues, its error is halved.
// EIGHT: the errors of the eight directions are stored too, for a density filter that does not merge opposite ones.
//
// Interpretations and changes:
// - Eq. 6 as printed has q above and below the line. Its sense is: above, the checked pixel; below, the control.
// - The minimum over the arc of normals is 0 where the perpendicular is inside the arc; the maximum may be inside as
//   well. Both are exact here.
// - epsilon is a length. `paper`: 1e-5 m. `footprint`: a part of the pixel's size in the world, so that a drawing does
//   not depend on unit and distance.
// - A pixel whose neighbourhood contains both sky and surface is a silhouette.
// - Nothing is thresholded here: that is done once, at the end (threshold.wgsl).
// - The error is stored for each of the four axes, since the line-density filter works along axes.
// - Eq. 8 uses ramped errors. Its result is stored as the error that the ramp maps to it: so the ramp is still applied
//   once and last, the density filter means the same with and without Eq. 8, and Eq. 8 adds no lines.
// - Sky is an error of 1 in each of the terms of Eq. 8: a hole of one pixel in the land is halved, too.
#import hachure::view::{View, distance_from_eye}
#import hachure::seen::{normal_seen, place_seen}

struct Lsa {
    // epsilon = epsilon_paper_m + epsilon_footprint * (pixel's size in the world).
    epsilon_paper_m: f32,
    epsilon_footprint: f32,
    // The ramp k of Eq. 6.
    plane_ramp: vec2<f32>,
    // From eta_min to eta_max, for Eq. 8.
    ramp: vec2<f32>,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> lsa: Lsa;
@group(0) @binding(2) var distance_m: texture_2d<f32>;
@group(0) @binding(3) var normal: texture_2d<u32>;
// Errors of the axes (1,0), (0,1), (1,1), (1,-1); the greatest is E(p) of Eq. 1.
@group(0) @binding(4) var errors: texture_storage_2d<rgba16float, write>;
#ifdef EIGHT
// Errors of the eight directions, two per word: along each axis, and against it.
@group(0) @binding(5) var directions: texture_storage_2d<rgba32uint, write>;
#endif

struct Sample {
    p: vec3<f32>,
    n: vec3<f32>,
}

// Returns the least and the greatest magnitude of dot(N, d) for N along the arc from a to b.
fn arc_range(a: vec3<f32>, b: vec3<f32>, d: vec3<f32>) -> vec2<f32> {
    let at_a = dot(a, d);
    let at_b = dot(b, d);
    let cosine = dot(a, b);
    let across = b - cosine * a;
    let sine = length(across);
    var least = min(abs(at_a), abs(at_b));
    var most = max(abs(at_a), abs(at_b));
    if at_a * at_b < 0.0 {
        least = 0.0;
    }
    if sine > 1e-7 {
        // Along the arc: at_a cos(t) + tangent sin(t). Its slope changes sign inside where the maximum is inside.
        let tangent = dot(across, d) / sine;
        let slope_at_b = tangent * cosine - at_a * sine;
        if tangent * slope_at_b < 0.0 {
            most = length(vec2<f32>(at_a, tangent));
        }
    }
    return vec2<f32>(least, most);
}

// S(p, c): the surface around p as predicted by the control pixel c.
struct Fit {
    // Signed, Eq. 3.
    curvature: f32,
    // The denominator of Eq. 6.
    control_m: f32,
    // True if one of the samples is sky and the other is not: no curve can be fitted.
    is_torn: bool,
}

fn fit(p: Sample, c: Sample, epsilon_m: f32) -> Fit {
    let to_c = c.p - p.p;
    let turn = c.n - p.n;
    let length_c = max(length(to_c), 1e-20);
    let curvature = sign(dot(turn, to_c)) * length(turn) / length_c;
    return Fit(curvature, arc_range(p.n, c.n, to_c).y + epsilon_m, is_sky(p) != is_sky(c));
}

// Returns e(q, S), Eq. 7.
fn deviation(p: Sample, q: Sample, surface: Fit) -> f32 {
    if surface.is_torn || is_sky(p) != is_sky(q) {
        return 1.0;
    }
    if is_sky(p) {
        return 0.0;
    }
    let to_q = q.p - p.p;
    // Eq. 5.
    let curved = length(surface.curvature * to_q - (q.n - p.n));
    // Eq. 6.
    let ratio = arc_range(p.n, q.n, to_q).x / surface.control_m;
    let plane = clamp((ratio - lsa.plane_ramp.x) / (lsa.plane_ramp.y - lsa.plane_ramp.x), 0.0, 1.0);
    // 4 is far above every threshold, and finite in 16 bits.
    return min(curved + plane, 4.0);
}

fn load(pixel: vec2<i32>) -> Sample {
    return Sample(place_seen(view, distance_m, pixel).xyz, normal_seen(normal, pixel));
}

fn is_sky(s: Sample) -> bool {
    return all(s.n == vec3<f32>(0.0));
}

fn is_inside(a: vec2<i32>, b: vec2<i32>) -> bool {
    return all(min(a, b) >= vec2<i32>(0)) && all(max(a, b) < vec2<i32>(view.size_px));
}

fn ramped(error: f32) -> f32 {
    return clamp((error - lsa.ramp.x) / (lsa.ramp.y - lsa.ramp.x), 0.0, 1.0);
}

// Eq. 8. `a` is the error of the far pixel by the near one's surface, `b` of the near pixel by the far one's, `c` with
// both near.
fn antialiased(a: f32, b: f32, c: f32) -> f32 {
    let far = min(ramped(a), ramped(b));
    let near = ramped(c);
    return select(c, mix(lsa.ramp.x, lsa.ramp.y, 0.5 * (far + near)), far < near);
}

// Returns the errors of the two pixels one step along an axis, and one step against it.
fn axis_errors(p: Sample, pixel: vec2<i32>, step: vec2<i32>, epsilon_m: f32) -> vec2<f32> {
    // Beyond the border there is nothing to compare with.
    if !is_inside(pixel + step, pixel - step) {
        return vec2<f32>(0.0);
    }
    let a = load(pixel + step);
    let b = load(pixel - step);
    if is_sky(p) && is_sky(a) && is_sky(b) {
        return vec2<f32>(0.0);
    }
    let by_a = fit(p, a, epsilon_m);
    let by_b = fit(p, b, epsilon_m);
    let near = vec2<f32>(deviation(p, a, by_b), deviation(p, b, by_a));
#ifdef ANTIALIASED
    if !is_inside(pixel + 2 * step, pixel - 2 * step) {
        return near;
    }
    let far_a = load(pixel + 2 * step);
    let far_b = load(pixel - 2 * step);
    return vec2<f32>(
        antialiased(deviation(p, far_a, by_b), deviation(p, a, fit(p, far_b, epsilon_m)), near.x),
        antialiased(deviation(p, far_b, by_a), deviation(p, b, fit(p, far_a, epsilon_m)), near.y),
    );
#else
    return near;
#endif
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let p = load(pixel);
    let epsilon_m = lsa.epsilon_paper_m + lsa.epsilon_footprint * distance_from_eye(view, p.p) / view.focal_px;
    let x = axis_errors(p, pixel, vec2<i32>(1, 0), epsilon_m);
    let y = axis_errors(p, pixel, vec2<i32>(0, 1), epsilon_m);
    let down = axis_errors(p, pixel, vec2<i32>(1, 1), epsilon_m);
    let up = axis_errors(p, pixel, vec2<i32>(1, -1), epsilon_m);
    // e_max: opposite directions share the greater error.
    let most = vec4<f32>(max(x.x, x.y), max(y.x, y.y), max(down.x, down.y), max(up.x, up.y));
    textureStore(errors, pixel, most);
#ifdef EIGHT
    let words = vec4<u32>(pack2x16unorm(x), pack2x16unorm(y), pack2x16unorm(down), pack2x16unorm(up));
    textureStore(directions, pixel, words);
#endif
}
