// The normal that light falls on: the land's own, or that of its form (surface/form.wgsl).
#define_import_path hachure::lit_normal
#import hachure::view::View
#import hachure::mark_normal::between_blocks

// Least weight of a block that sees another face of the land: its form still describes the pixel's face better than one
// sample of the land does.
const MIN_WEIGHT: f32 = 0.05;

// Returns the normal to light, and the lightness. `own` is the normal of a pixel that sees `at`, and the lightness of
// what is there; only land, whose lightness is 1, has a form. `detail` is the weight of the land's own normal, 0 to 1.
fn lit_normal(view: View, form_normal: texture_2d<f32>, pixel: vec2<i32>, at: vec4<f32>, own: vec4<f32>, detail: f32) -> vec4<f32> {
    if own.w != 1.0 || detail >= 1.0 {
        return own;
    }
    return vec4<f32>(normalize(mix(between_blocks(view, form_normal, pixel, at, own.xyz, MIN_WEIGHT), own.xyz, detail)), 1.0);
}
