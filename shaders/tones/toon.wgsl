// Toon tones: light in a few steps with soft borders, or smooth.
#import hachure::view::View
#import hachure::light::{Light, light_tone, haze_clear}

struct Toon {
    // 0: smooth.
    steps: f32,
    // Of the steps, and how soft their borders are (1: each rises all the way to the next).
    darkest: f32,
    lightest: f32,
    softness: f32,
    // How much of the tone is colour.
    wash: f32,
    pad_a: f32,
    pad_b: f32,
    pad_c: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> light: Light;
@group(0) @binding(2) var<uniform> toon: Toon;
@group(0) @binding(3) var position: texture_2d<f32>;
@group(0) @binding(4) var normal: texture_2d<f32>;
// rgb: colour before lines and haze; a: the tone asked for, haze included.
@group(0) @binding(5) var tone: texture_storage_2d<rgba16float, write>;

fn stepped(lit: f32) -> f32 {
    if toon.steps < 1.0 {
        return lit;
    }
    let scaled = lit * toon.steps;
    let step = floor(scaled);
    let soft = smoothstep(1.0 - toon.softness, 1.0, scaled - step);
    return clamp((step + soft) / (toon.steps - 1.0), 0.0, 1.0);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let at = textureLoad(position, pixel, 0);
    if at.w <= 0.0 {
        textureStore(tone, pixel, vec4<f32>(1.0));
        return;
    }
    let n = textureLoad(normal, pixel, 0).xyz;
    let value = mix(toon.darkest, toon.lightest, stepped(light_tone(light, n, vec2<f32>(1.0))));
    let asked = 1.0 - (1.0 - value) * haze_clear(light, length(at.xyz));
    textureStore(tone, pixel, vec4<f32>(vec3<f32>(mix(1.0, value, toon.wash)), asked));
}
