// The light on a surface: the requested tone, before steps, marks and haze.
#define_import_path hachure::light
#import hachure::power::power

// The light of a frame, in the layout that shaders read.
struct Light {
    to_sun: vec3<f32>,
    // How far light reaches around a surface: 0 is Lambert's cosine; 1 is half-Lambert, which shows form in the shade.
    wrap: f32,
    // Light that is left without the sun, 0 to 1.
    ambient: f32,
    // Part of the sun that cast shadows take, and part of the ambient light that a hidden sky takes, 0 to 1.
    shadow: f32,
    occlusion: f32,
    // Part of the darkness that depends on slope alone, 0 to 1: 45 degrees are black (Lehmann 1799).
    slope: f32,
    // Factor of lightness; above 1 more of the land is white.
    exposure: f32,
    // Exponent of the tone; above 1 is darker.
    contrast: f32,
    // Distance at which haze has taken 63 % of the contrast, in metres, and the part that it leaves at infinity.
    haze_m: f32,
    faintest: f32,
    // Part of the land's own normals in the normals that are lit, 0 to 1; the form's normals are the rest.
    detail: f32,
    // Slope, rise over run, up to which land is bare paper, and from which on it has its full tone.
    level: f32,
    level_end: f32,
    padding: f32,
}

// Returns a tone, 0 black to 1 white. `surface` is a normal, and the lightness of the material: 1 is bare land. `seen`
// holds the visible parts of the sun and of the sky.
fn light_tone(light: Light, surface: vec4<f32>, seen: vec2<f32>) -> f32 {
    let n = surface.xyz;
    let cosine = (dot(n, light.to_sun) + light.wrap) / (1.0 + light.wrap);
    let diffuse = power(cosine, 1.0 + light.wrap);
    let sun = diffuse * mix(1.0, seen.x, light.shadow);
    let sky = mix(1.0, seen.y, light.occlusion);
    return tone_of_lit(light, surface, sky * mix(sun, 1.0, light.ambient));
}

// Returns the tone of a surface whose lighting is `lit`: applies the darkness of its slope, exposure and contrast, and
// leaves level land as paper.
fn tone_of_lit(light: Light, surface: vec4<f32>, lit: f32) -> f32 {
    let n = surface.xyz;
    // The slope angle in parts of 45 degrees, within 0.2 degrees (a parabola approximates atan).
    let steep = length(n.xy) / max(n.z, 1e-3);
    let by_slope = 1.0 - clamp(steep * (1.0 + 0.3476 * (1.0 - steep)), 0.0, 1.0);
    // The sides of a tree or of a model do not count as slopes.
    let lightness = mix(lit, by_slope, select(0.0, light.slope, surface.w == 1.0));
    let tone = power(surface.w * clamp(lightness * light.exposure, 0.0, 1.0), light.contrast);
    if surface.w != 1.0 || light.level_end <= 0.0 {
        return tone;
    }
    return mix(1.0, tone, smoothstep(light.level, light.level_end, steep));
}

// Returns the part of the contrast that haze leaves at a distance.
fn haze_clear(light: Light, distance_m: f32) -> f32 {
    let t = distance_m / light.haze_m;
    return mix(light.faintest, 1.0, exp(-t * t));
}
