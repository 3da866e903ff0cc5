// Local Surface Approximation contours, base method (Zaidi et al., Eqs. 1 to 7).
//
// For each pair of opposite neighbours (q, its control c) of pixel p: a sphere through p and c, tangent to their
// normals, predicts q; the error is how far q is from that prediction.
//
// Readings and changes:
// - Eq. 6 as printed has q above and below the line. Its sense is: above, the checked pixel; below, the control.
// - The minimum over the arc of normals is 0 where the perpendicular lies inside the arc; the maximum likewise may lie
//   inside. Both are exact here.
// - epsilon is a length. `paper`: 1e-5 m. `footprint`: a part of the pixel's size in the world, so that a drawing does
//   not depend on the unit and the distance.
// - A pixel whose neighbourhood holds both sky and surface is a silhouette.
// - Nothing is thresholded here: that comes once, at the end (threshold.wgsl).
// - The error is kept for each of the four axes, since the line-density filter works along axes.
#import hachure::view::{View, distance_from_eye}

struct Lsa {
    // epsilon = paper_m + footprint * (pixel's size in the world).
    epsilon_paper_m: f32,
    epsilon_footprint: f32,
    // The ramp k of Eq. 6.
    plane_ramp: vec2<f32>,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> lsa: Lsa;
@group(0) @binding(2) var position: texture_2d<f32>;
@group(0) @binding(3) var normal: texture_2d<f32>;
// Errors of the axes (1,0), (0,1), (1,1), (1,-1); the greatest is E(p) of Eq. 1.
@group(0) @binding(4) var errors: texture_storage_2d<rgba16float, write>;

struct Sample {
    p: vec3<f32>,
    n: vec3<f32>,
}

// dot(N, d) for N along the arc from a to b: the least magnitude and the greatest.
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
        // Along the arc: at_a cos(t) + tangent sin(t). Its slope changes sign inside where the greatest lies inside.
        let tangent = dot(across, d) / sine;
        let slope_at_b = tangent * cosine - at_a * sine;
        if tangent * slope_at_b < 0.0 {
            most = length(vec2<f32>(at_a, tangent));
        }
    }
    return vec2<f32>(least, most);
}

// e(q, S(p, q)), Eq. 7, with the sphere from the control pixel c.
fn deviation(p: Sample, q: Sample, c: Sample, epsilon_m: f32) -> f32 {
    let to_c = c.p - p.p;
    let to_q = q.p - p.p;
    let turn_c = c.n - p.n;
    // Eq. 3: curvature, signed.
    let length_c = max(length(to_c), 1e-20);
    let curvature = sign(dot(turn_c, to_c)) * length(turn_c) / length_c;
    // Eq. 5.
    let curved = length(curvature * to_q - (q.n - p.n));
    // Eq. 6.
    let checked = arc_range(p.n, q.n, to_q).x;
    let control = arc_range(p.n, c.n, to_c).y;
    let ratio = checked / (control + epsilon_m);
    let plane = clamp((ratio - lsa.plane_ramp.x) / (lsa.plane_ramp.y - lsa.plane_ramp.x), 0.0, 1.0);
    // 4 is far above every threshold, and finite in 16 bits.
    return min(curved + plane, 4.0);
}

fn load(pixel: vec2<i32>) -> Sample {
    return Sample(textureLoad(position, pixel, 0).xyz, textureLoad(normal, pixel, 0).xyz);
}

fn is_sky(s: Sample) -> bool {
    return all(s.n == vec3<f32>(0.0));
}

fn axis_error(p: Sample, pixel: vec2<i32>, step: vec2<i32>, epsilon_m: f32) -> f32 {
    let forward = pixel + step;
    let back = pixel - step;
    let last = vec2<i32>(view.size_px) - 1;
    // Beyond the border there is nothing to compare.
    if any(min(forward, back) < vec2<i32>(0)) || any(max(forward, back) > last) {
        return 0.0;
    }
    let a = load(forward);
    let b = load(back);
    if is_sky(p) != is_sky(a) || is_sky(p) != is_sky(b) {
        return 1.0;
    }
    if is_sky(p) {
        return 0.0;
    }
    return max(deviation(p, a, b, epsilon_m), deviation(p, b, a, epsilon_m));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let p = load(pixel);
    let epsilon_m = lsa.epsilon_paper_m + lsa.epsilon_footprint * distance_from_eye(view, p.p) / view.focal_px;
    textureStore(errors, pixel, vec4<f32>(
        axis_error(p, pixel, vec2<i32>(1, 0), epsilon_m),
        axis_error(p, pixel, vec2<i32>(0, 1), epsilon_m),
        axis_error(p, pixel, vec2<i32>(1, 1), epsilon_m),
        axis_error(p, pixel, vec2<i32>(1, -1), epsilon_m),
    ));
}
