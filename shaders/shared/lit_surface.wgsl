// The surface at a pixel as lighting needs it: the normal that is lit, and which parts of the sun and of the sky are
// visible from there. All passes that light the visible surface use it, and have the bindings that it reads.
//
// With HORIZON_MAPS the land casts shadows, with TREE_SHADOWS trees do.
#define_import_path hachure::lit_surface
#import hachure::view::View
#import hachure::seen::surface_seen
#import hachure::focus::{Focus, in_focus}
#import hachure::light::Light
#import hachure::lit_normal::lit_normal
#ifdef HORIZON_MAPS
#import hachure::horizon_maps::visibility_at
#endif

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> light: Light;
@group(0) @binding(2) var<storage, read> focus: Focus;
@group(0) @binding(3) var distance_m: texture_2d<f32>;
@group(0) @binding(4) var normal: texture_2d<u32>;
// The normal of the land's form: see surface/form.wgsl. A single empty texel if the land itself is lit.
@group(0) @binding(5) var form_normal: texture_2d<f32>;
#ifdef TREE_SHADOWS
@group(0) @binding(6) var tree_shadow: texture_2d<f32>;
#endif

struct LitSurface {
    // The normal that is lit, and the lightness of the material.
    normal: vec4<f32>,
    // The visible parts of the sun and of the sky, 0 to 1.
    seen: vec2<f32>,
    // See `in_focus`.
    clear: f32,
}

// Returns the lit surface at a pixel that sees `at` (w: distance along the view axis).
fn lit_surface(pixel: vec2<i32>, at: vec4<f32>) -> LitSurface {
    let clear = in_focus(focus, view, at.xyz, vec2<f32>(pixel + view.origin_px) + 0.5);
    // Away from the focus there is less detail.
    let n = lit_normal(view, form_normal, pixel, at, surface_seen(normal, pixel), light.detail * clear);
#ifdef HORIZON_MAPS
    var seen = visibility_at(at.xyz, light.to_sun);
#else
    var seen = vec2<f32>(1.0);
#endif
#ifdef TREE_SHADOWS
    seen.x *= 1.0 - textureLoad(tree_shadow, pixel, 0).r;
#endif
    return LitSurface(n, seen, clear);
}
