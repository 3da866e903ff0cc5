// The colours of trees and models, and how they are mixed into a tone. Colours are linear.
//
// A painter uses a transparent pigment: little of it where the tone is light, so that paper shows through; much where
// it is dark, up to the pigment's full strength. Light that passes through an amount of pigment is the pigment's colour
// to that power (Beer and Lambert). The result is then scaled to the luminance of the tone, so that colours change no
// tone.
#define_import_path hachure::local_color
#import hachure::color::luminance

// Luminance at which a pigment has its full strength; darker tones get no more.
const BODY: f32 = 0.16;

// Unpacks a hue (see src/surface/local_color.rs): the colour at luminance 1, and whether there is one, 0 or 1.
fn hue_of(packed: u32) -> vec4<f32> {
    let stored = unpack4x8unorm(packed);
    let color = stored.rgb * stored.rgb;
    return vec4<f32>(color / max(luminance(color), 1e-3), stored.a);
}

// Returns a hue as a glaze of the given luminance.
fn glaze(hue: vec3<f32>, light: f32) -> vec3<f32> {
    let lit = clamp(light, 1e-4, 1.0);
    let pigment = pow(max(hue, vec3<f32>(1e-3)), vec3<f32>(min(log(lit) / log(BODY), 1.0)));
    let color = pigment * (lit / luminance(pigment));
    // A colour brighter than paper is mixed with white.
    let most = max(color.r, max(color.g, color.b));
    return select(color, mix(vec3<f32>(lit), color, (1.0 - lit) / max(most - lit, 1e-6)), most > 1.0);
}
