// Computes the gradient of the picture's depth from normals (Vergne and others 2009, sections 4.2 and 4.4, steps 1 to
// 3).
//
// The paper uses the gradient of depth g = -(n_x, n_y) / n_z, and sets its conductance to 0 where a Sobel filter on
// depth finds a silhouette, or where the normals of neighbours differ by a crease.
//
// Changes:
// - In perspective the depth of a plane is not linear across the picture, but its inverse is. So this is the gradient
//   of inverse depth, n_xy / (n . p) with p the point relative to the eye: level ground has no curvature however it is
//   seen. From far above, as on a map, both are the same.
// - A Sobel filter on depth finds silhouettes everywhere on ground at a flat angle. Here a neighbour is on another
//   surface if it is off the plane of the pixel.
// - The extent of the blur (the importance function of section 4.3) grows with distance, away from the focus of the
//   picture and on level land, as the style requests.
#import hachure::view::{View, from_eye, distance_from_eye}
#import hachure::seen::{normal_seen, place_seen, surface_seen}
#import hachure::focus::{Focus, in_focus}
#import hachure::light::{Light, haze_clear}
#import hachure::lit_normal::lit_normal
#import hachure::relief::{ReliefRules, DepthGradient, packed, on_plane}
#import hachure::surface_id::{has_trait, id_seen, SMOOTH}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> light: Light;
@group(0) @binding(2) var<storage, read> relief_rules: ReliefRules;
@group(0) @binding(3) var<storage, read> focus: Focus;
@group(0) @binding(4) var surface_id: texture_2d<u32>;
@group(0) @binding(5) var distance_m: texture_2d<f32>;
@group(0) @binding(6) var normal: texture_2d<u32>;
@group(0) @binding(7) var form_normal: texture_2d<f32>;
// The same four values as `packed`; all 0 where there is no relief.
@group(0) @binding(8) var depth_gradient: texture_storage_2d<rgba32float, write>;

// Least cosine between normal and ray; at flatter angles the gradient grows no further.
const MIN_FACING: f32 = 0.04;
// Slope, rise over run, from which on land does not count as level.
const STEEP: f32 = 0.5;

fn seen(pixel: vec2<i32>) -> vec4<f32> {
    let at = place_seen(view, distance_m, pixel);
    let n = normal_seen(normal, pixel);
    let p = from_eye(view, at.xyz);
    let through = min(dot(n, p), -MIN_FACING * length(p));
    let across = vec2<f32>(dot(n, normalize(view.ray_dx)), dot(n, normalize(view.ray_dy)));
    return vec4<f32>(across / through, select(0.0, 1.0 / at.w, at.w > 0.0), 0.0);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let at = place_seen(view, distance_m, pixel);
    // Each leaf of a tree has its own normal.
    if at.w <= 0.0 || !has_trait(id_seen(surface_id, pixel), SMOOTH) {
        textureStore(depth_gradient, pixel, vec4<f32>(0.0));
        return;
    }
    let own = seen(pixel);
    let raw = surface_seen(normal, pixel);
    var conductance = 1.0;
    var min_cosine = 1.0;
    for (var i = 0; i < 4; i++) {
        let offset = select(vec2<i32>(0, i - 2), vec2<i32>(i - 1, 0), i % 2 == 0);
        let neighbour = pixel + offset;
        if any(neighbour < vec2<i32>(0)) || any(neighbour >= vec2<i32>(view.size_px)) {
            continue;
        }
        conductance = min(conductance, on_plane(view, own, seen(neighbour), vec2<f32>(offset)));
        min_cosine = min(min_cosine, dot(raw.xyz, normal_seen(normal, neighbour)));
    }
    let crease_rad = acos(clamp(min_cosine, -1.0, 1.0));
    conductance *= 1.0 - smoothstep(0.5 * relief_rules.crease_rad, relief_rules.crease_rad, crease_rad);

    let clear = in_focus(focus, view, at.xyz, vec2<f32>(pixel + view.origin_px) + 0.5);
    let n = lit_normal(view, form_normal, pixel, at, raw, light.detail * clear);
    let p = from_eye(view, at.xyz);
    let through = min(dot(n.xyz, p), -MIN_FACING * length(p));
    let slope = vec2<f32>(dot(n.xyz, normalize(view.ray_dx)), dot(n.xyz, normalize(view.ray_dy))) / through;
    let steep = length(raw.xy) / max(abs(raw.z), 1e-3);
    let coarser = relief_rules.coarser_far * (1.0 - haze_clear(light, distance_from_eye(view, at.xyz)))
        + relief_rules.coarser_aside * (1.0 - clear)
        + relief_rules.coarser_level * (1.0 - smoothstep(0.0, STEEP, steep));
    let sigma_px = relief_rules.scale_px * (1.0 + coarser);
    textureStore(depth_gradient, pixel, packed(DepthGradient(slope, conductance, sigma_px), own.z));
}
