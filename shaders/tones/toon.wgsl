// Toon tones: the light's diffuse term in a few steps with soft borders.
#import hachure::view::View

struct Toon {
    to_sun: vec3<f32>,
    steps: f32,
    // The darkest tone, and how soft the borders are (1: no steps at all).
    darkest: f32,
    softness: f32,
    lightest: f32,
    // How much of the tone is colour.
    wash: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> toon: Toon;
@group(0) @binding(2) var normal: texture_2d<f32>;
// rgb: colour before lines and haze; a: the tone asked for.
@group(0) @binding(3) var tone: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let n = textureLoad(normal, pixel, 0).xyz;
    var value = 1.0;
    if any(n != vec3<f32>(0.0)) {
        // Half-Lambert keeps form in the shade.
        let light = clamp(dot(n, toon.to_sun) * 0.5 + 0.5, 0.0, 1.0);
        let scaled = light * light * toon.steps;
        let step = floor(scaled);
        let soft = smoothstep(1.0 - toon.softness, 1.0, scaled - step);
        value = mix(toon.darkest, toon.lightest, clamp((step + soft) / (toon.steps - 1.0), 0.0, 1.0));
    }
    textureStore(tone, pixel, vec4<f32>(vec3<f32>(mix(1.0, value, toon.wash)), value));
}
