// The normal that light falls on: the land's own, or that of its form (surface/form.wgsl).
#define_import_path hachure::lit_normal
#import hachure::view::View
#import hachure::mark_normal::between_blocks

// A block of the form that sees another face still knows more of it than a sample of the land.
const BESIDE: f32 = 0.05;

// `own` is the normal of a pixel that sees `at`, and the lightness of what is there: other things than land have no form.
// `detail` is how much of the land's own slopes is left.
fn lit_normal(view: View, form_normal: texture_2d<f32>, pixel: vec2<i32>, at: vec4<f32>, own: vec4<f32>, detail: f32) -> vec4<f32> {
    if own.w != 1.0 || detail >= 1.0 {
        return own;
    }
    return vec4<f32>(normalize(mix(between_blocks(view, form_normal, pixel, at, own.xyz, BESIDE), own.xyz, detail)), 1.0);
}
