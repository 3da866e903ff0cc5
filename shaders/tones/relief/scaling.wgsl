// Radiance scaling: light is scaled by curvature (Vergne, Pacanowski, Barla, Granier and Schlick 2010, "Radiance
// Scaling for Versatile Surface Enhancement", section 3). It uses one light, and so is cheaper than a warp of many.
//
// With d the light of a place and e = exp(-gamma kappa), d is multiplied by (alpha e + d (1 - alpha - alpha e)) /
// (alpha + d (e - alpha - alpha e)). Light above alpha becomes lighter where the surface bulges and darker in hollows,
// light below alpha the opposite, and kappa = 0 leaves it unchanged. Kappa is the mean curvature, here limited to -1 to
// 1 by an arctangent as in the warp.
#import hachure::view::from_eye
#import hachure::seen::place_seen
#import hachure::light::light_tone
#import hachure::lit_surface::{lit_surface, view, light, distance_m}
#import hachure::relief::{ReliefRules, bend_at}

struct ScalingRules {
    // Strength, gamma.
    strength: f32,
    // The tone that stays unchanged, alpha.
    invariant: f32,
}

@group(0) @binding(7) var<storage, read> scaling_rules: ScalingRules;
// rgb: white; a: the requested tone.
@group(0) @binding(9) var relief_light: texture_storage_2d<rgba16float, write>;
@group(0) @binding(20) var<storage, read> relief_rules: ReliefRules;
@group(0) @binding(21) var depth_gradient: texture_2d<f32>;

const PI: f32 = 3.1415927;

fn scaled(lit: f32, kappa: f32) -> f32 {
    let alpha = scaling_rules.invariant;
    let e = exp(-scaling_rules.strength * kappa);
    let factor = (alpha * e + lit * (1.0 - alpha - alpha * e)) / (alpha + lit * (e - alpha - alpha * e));
    return clamp(lit * factor, 0.0, 1.0);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let at = place_seen(view, distance_m, pixel);
    if at.w <= 0.0 {
        textureStore(relief_light, pixel, vec4<f32>(1.0));
        return;
    }
    let surface = lit_surface(pixel, at);
    let n = surface.normal;
    let facing = clamp(-dot(n.xyz, normalize(from_eye(view, at.xyz))), 0.0, 1.0);
    let bend = bend_at(view, relief_rules, depth_gradient, pixel, at.w, facing);
    let kappa = atan(0.5 * (bend.x + bend.z)) * 2.0 / PI;
    textureStore(relief_light, pixel, vec4<f32>(vec3<f32>(1.0), scaled(light_tone(light, n, surface.seen), kappa)));
}
