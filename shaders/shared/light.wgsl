// How light a place is: the tone that is asked for, before steps, marks and haze.
#define_import_path hachure::light

// As the shaders read it.
struct Light {
    to_sun: vec3<f32>,
    // How far light reaches around: 0 is Lambert's cosine, 1 half-Lambert, which keeps form in the shade.
    wrap: f32,
    // What is left without the sun.
    ambient: f32,
    // How much cast shadows take of the sun, and what hides the sky of the ambient light.
    shadow: f32,
    occlusion: f32,
    // How much of the darkness is the slope's own: 45 degrees are black (Lehmann 1799).
    slope: f32,
    // Above 1 more of the land is white.
    exposure: f32,
    // Exponent of the tone: above 1 is darker.
    contrast: f32,
    // Distance at which haze has taken 63 %, and what it leaves of a tone at last.
    haze_m: f32,
    faintest: f32,
    // How much of the land's own normals light falls on, beside the form's.
    detail: f32,
    // Rise over run up to which land is paper, and from which on it has all of its tone.
    level: f32,
    level_end: f32,
    padding: f32,
}

// 0 black to 1 white. `surface` is a normal, and the lightness of what is there: 1 is bare land. `seen` is which parts of
// the sun and of the sky the place sees.
fn light_tone(light: Light, surface: vec4<f32>, seen: vec2<f32>) -> f32 {
    let n = surface.xyz;
    let cosine = (dot(n, light.to_sun) + light.wrap) / (1.0 + light.wrap);
    let diffuse = pow(max(cosine, 0.0), 1.0 + light.wrap);
    let sun = diffuse * mix(1.0, seen.x, light.shadow);
    let sky = mix(1.0, seen.y, light.occlusion);
    return tone_of_lit(light, surface, sky * mix(sun, 1.0, light.ambient));
}

// The tone of a surface that is so light, by whatever light: with the darkness of its slope, exposure and contrast, and
// paper where land is level.
fn tone_of_lit(light: Light, surface: vec4<f32>, lit: f32) -> f32 {
    let n = surface.xyz;
    // The angle in parts of 45 degrees, within 0.2 degrees (atan by a parabola).
    let steep = length(n.xy) / max(n.z, 1e-3);
    let by_slope = 1.0 - clamp(steep * (1.0 + 0.3476 * (1.0 - steep)), 0.0, 1.0);
    // The sides of a tree or of a model are no slopes.
    let lightness = mix(lit, by_slope, select(0.0, light.slope, surface.w == 1.0));
    let tone = pow(surface.w * clamp(lightness * light.exposure, 0.0, 1.0), light.contrast);
    if surface.w != 1.0 || light.level_end <= 0.0 {
        return tone;
    }
    return mix(1.0, tone, smoothstep(light.level, light.level_end, steep));
}

// What haze leaves of contrast at a distance.
fn haze_clear(light: Light, distance_m: f32) -> f32 {
    let t = distance_m / light.haze_m;
    return mix(light.faintest, 1.0, exp(-t * t));
}
