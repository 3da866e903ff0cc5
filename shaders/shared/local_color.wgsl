// The colours that trees and models have of their own, and how a tone takes them. Colours are linear.
//
// A painter lays a transparent pigment: where the tone is light, little of it, and paper shows through; where it is dark,
// much, up to the pigment's own strength. Light that goes through so much pigment is the pigment's colour to that power
// (Beer and Lambert). Then it is made as light as the tone, so that colours change no tone.
#define_import_path hachure::local_color
#import hachure::color::luminance

// The luminance at which a pigment has all of its strength; what is darker has no more.
const BODY: f32 = 0.16;

// From src/surface/local_color.rs: the colour that has the luminance 1; and whether there is one, 0 or 1.
fn hue_of(packed: u32) -> vec4<f32> {
    let stored = unpack4x8unorm(packed);
    let color = stored.rgb * stored.rgb;
    return vec4<f32>(color / max(luminance(color), 1e-3), stored.a);
}

// A hue as a glaze that has this luminance.
fn glaze(hue: vec3<f32>, light: f32) -> vec3<f32> {
    let lit = clamp(light, 1e-4, 1.0);
    let pigment = pow(max(hue, vec3<f32>(1e-3)), vec3<f32>(min(log(lit) / log(BODY), 1.0)));
    let color = pigment * (lit / luminance(pigment));
    // What would be brighter than paper gives way to white.
    let most = max(color.r, max(color.g, color.b));
    return select(color, mix(vec3<f32>(lit), color, (1.0 - lit) / max(most - lit, 1e-6)), most > 1.0);
}
