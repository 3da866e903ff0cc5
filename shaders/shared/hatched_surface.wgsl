// The surface at a pixel as both kinds of hatching need it: how dark its marks are, which normal and direction they
// follow, and how the surface is foreshortened. Both passes have the bindings that it is read from.
#define_import_path hachure::hatched_surface
#import hachure::view::{View, ray_of_pixel}
#import hachure::seen::surface_seen
#import hachure::mark_normal::{mark_normal_at, values_between_blocks}
#import hachure::hatch::{Hatch, Footprint, footprint}

// An axis of a chart.
struct Axis {
    direction: vec3<f32>,
    pad: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> hatch: Hatch;
@group(0) @binding(2) var<storage, read> axes: array<Axis>;
@group(0) @binding(3) var distance_m: texture_2d<f32>;
@group(0) @binding(4) var normal: texture_2d<u32>;
@group(0) @binding(5) var mark_normal: texture_2d<f32>;
@group(0) @binding(6) var tone: texture_2d<f32>;
// See surface/bend_axis.wgsl; a single empty texel if no layer needs it.
@group(0) @binding(7) var bend_axis: texture_2d<f32>;

struct HatchedSurface {
    // The darkness of the marks, 0 to 1.
    darkness: f32,
    // The pixel's own normal, and lightness or FLAT.
    own: vec4<f32>,
    // The normal that marks follow.
    normal: vec3<f32>,
    // The direction of greatest curvature, as in `bend_axis`; 0 if no layer needs it.
    line: vec2<f32>,
    // On the plane of `normal`.
    foot: Footprint,
}

// Returns the surface that marks follow at a pixel that sees `at` (w: distance along the view axis).
fn hatched_surface(pixel: vec2<i32>, at: vec4<f32>) -> HatchedSurface {
    let darkness = hatch.share * clamp(1.0 - textureLoad(tone, pixel, 0).a, 0.0, 1.0);
    let own = surface_seen(normal, pixel);
    let n = mark_normal_at(view, mark_normal, pixel, at, own);
    var line = vec2<f32>(0.0);
    if hatch.by_curvature != 0u {
        line = values_between_blocks(view, mark_normal, bend_axis, pixel, at).xy;
    }
    return HatchedSurface(darkness, own, n, line, footprint(view, ray_of_pixel(view, pixel), at.w, n));
}
