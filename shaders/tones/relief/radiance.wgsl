// Light warping: the surroundings light each place, warped so that its form is visible (Vergne and others 2009, section
// 6).
//
// Lights surround the scene: the sun, and a number of parts of the sky, each with its mean radiance. Equation 2 of the
// paper is summed over them, with the inverse of the warp and its effect on solid angles (shared/light_warp.wgsl).
// Equation 3 multiplies by (lambda_u lambda_v)^gamma.
//
// Interpretations and changes:
// - Curvature is positive where the surface bulges toward the eye; there more of the surroundings is gathered.
// - The diffuse light of the parts of the sky is divided by that of a white sky, summed over the same parts. So a white
//   sky stays white whatever the warp does, and few lights leave no bands.
// - Light is clamped to the hemisphere around the normal after the inverse warp. The paper clamps it before as well;
//   with a white sky that would darken every curved surface.
// - The glossy part is the isotropic lobe of Ashikhmin and Shirley (2000, "An anisotropic Phong BRDF model").
// - The paper uses curvature along the line of sight; `foreshortening` reduces it on land at a flat angle, where each
//   sample of a DEM would look like a fold.
//
// Without WARPED, light is unchanged.
#import hachure::power::power
#import hachure::view::from_eye
#import hachure::seen::place_seen
#import hachure::light::tone_of_lit
#import hachure::lit_surface::{lit_surface, view, light, distance_m}
#import hachure::color::luminance
#import hachure::light_warp::{WarpedLight, inverse_warp_of, warp_light}
#ifdef WARPED
#import hachure::curvature::principal_of
#import hachure::relief::{ReliefRules, bend_at}
#endif

struct Surroundings {
    // Unit vectors in the world: right and down on the picture.
    right: vec3<f32>,
    // Exponent of (lambda_u lambda_v).
    gamma: f32,
    down: vec3<f32>,
    // Strength of glossy light, and its exponent.
    gloss: f32,
    // Unit vector toward the sun, in the axes of the picture.
    to_sun: vec3<f32>,
    shininess: f32,
    // Light of the sun on a surface that faces it, linear.
    sun: vec3<f32>,
    // Number of parts of the sky, all with the same solid angle.
    count: u32,
}

// A part of the sky around the scene.
struct SkyLight {
    // Unit vector in the axes of the picture: right, down, and toward the eye.
    direction: vec3<f32>,
    pad_a: f32,
    // Linear; scaled so that the whole sky gives level land a light of 1.
    radiance: vec3<f32>,
    pad_b: f32,
}

@group(0) @binding(7) var<storage, read> surroundings: Surroundings;
@group(0) @binding(8) var<storage, read> sky_lights: array<SkyLight>;
// rgb: the light's colour, of luminance 1; a: the requested tone.
@group(0) @binding(9) var relief_light: texture_storage_2d<rgba16float, write>;
#ifdef WARPED
@group(0) @binding(20) var<storage, read> relief_rules: ReliefRules;
@group(0) @binding(21) var depth_gradient: texture_2d<f32>;
#endif

const PI: f32 = 3.1415927;
// Reflectance of the glossy part at normal incidence.
const FACE_ON: f32 = 0.3;

// Returns the glossy light of a source, including its cosine.
fn glossy(n: vec3<f32>, to_light: vec3<f32>, to_eye: vec3<f32>) -> f32 {
    let cosine = max(dot(n, to_light), 0.0);
    let between = to_light + to_eye;
    let half_way = between * inverseSqrt(max(dot(between, between), 1e-12));
    let toward = max(dot(half_way, to_eye), 1e-3);
    let fresnel = FACE_ON + (1.0 - FACE_ON) * power(1.0 - toward, 5.0);
    let lobe = (surroundings.shininess + 1.0) / (8.0 * PI) * power(dot(n, half_way), surroundings.shininess);
    return cosine * lobe * fresnel / (toward * max(max(cosine, dot(n, to_eye)), 1e-3));
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
    let to_eye_world = -normalize(from_eye(view, at.xyz));
    let toward_eye = -cross(surroundings.right, surroundings.down);
    let seen_normal = vec3<f32>(dot(n.xyz, surroundings.right), dot(n.xyz, surroundings.down), dot(n.xyz, toward_eye));
    let to_eye = vec3<f32>(dot(to_eye_world, surroundings.right), dot(to_eye_world, surroundings.down), dot(to_eye_world, toward_eye));
    var contrast = 1.0;
#ifdef WARPED
    let facing = clamp(dot(n.xyz, to_eye_world), 0.0, 1.0);
    let bend = principal_of(bend_at(view, relief_rules, depth_gradient, pixel, at.w, facing));
    let warp = inverse_warp_of(bend.most, bend.least, bend.along);
    contrast = power(warp.area, -surroundings.gamma);
#endif
    var diffuse = vec3<f32>(0.0);
    var white = 0.0;
    var gloss = vec3<f32>(0.0);
    let solid_angle = 4.0 * PI / f32(max(surroundings.count, 1u));
    for (var i = 0u; i < surroundings.count; i++) {
        let sky = sky_lights[i];
#ifdef WARPED
        let warped = warp_light(warp, sky.direction);
        let direction = warped.direction;
        let growth = warped.growth;
#else
        let direction = sky.direction;
        let growth = 1.0;
#endif
        let cosine = max(dot(seen_normal, direction), 0.0) * growth;
        diffuse += sky.radiance * cosine;
        white += cosine;
        if surroundings.gloss > 0.0 {
            gloss += sky.radiance * (glossy(seen_normal, direction, to_eye) * growth * solid_angle);
        }
    }
#ifdef WARPED
    let sun = warp_light(warp, surroundings.to_sun);
#else
    let sun = WarpedLight(surroundings.to_sun, 1.0);
#endif
    let sun_cosine = max(dot(seen_normal, sun.direction), 0.0) * sun.growth;
    var sun_gloss = 0.0;
    if surroundings.gloss > 0.0 {
        sun_gloss = PI * glossy(seen_normal, sun.direction, to_eye) * sun.growth;
    }
    let sky_seen = mix(1.0, surface.seen.y, light.occlusion);
    let sun_seen = mix(1.0, surface.seen.x, light.shadow);
    let lit = contrast * (sky_seen * (diffuse / max(white, 1e-6) + surroundings.gloss * gloss)
        + sun_seen * surroundings.sun * (sun_cosine + surroundings.gloss * sun_gloss));
    let strength = luminance(lit);
    let tone = tone_of_lit(light, n, strength);
    textureStore(relief_light, pixel, vec4<f32>(lit / max(strength, 1e-4), tone));
}
