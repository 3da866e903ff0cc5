// The tone of the light at a pixel, before steps, fit and haze: from the light itself or from what emphasises relief, with
// the light of crests.
#define_import_path hachure::lit_tone
#import hachure::light::light_tone
#import hachure::lit_surface::{LitSurface, light}
#ifdef DRAPED_IMAGE
#import hachure::image_tone::image_light
#endif

// See tones/relief/radiance.wgsl; a single empty texel if relief is not emphasised.
@group(0) @binding(20) var relief_light: texture_2d<f32>;
// See tones/crests.wgsl; a single empty texel if crests are not lighter.
@group(0) @binding(21) var crest_light: texture_2d<f32>;

// Returns the tone of the light on `surface`, which `pixel` sees. `relief` and `crests` say which pictures exist.
fn lit_tone(surface: LitSurface, pixel: vec2<i32>, relief: bool, crests: bool) -> f32 {
    var lit = light_tone(light, surface.normal, surface.seen);
    if relief {
        lit = textureLoad(relief_light, pixel, 0).a;
    }
    if crests {
        lit = clamp(lit + textureLoad(crest_light, pixel, 0).r, 0.0, 1.0);
    }
#ifdef DRAPED_IMAGE
    lit *= image_light(pixel);
#endif
    return lit;
}
