// Exaggerated shading: relief is shaded at several scales at once (Rusinkiewicz, Burns and DeCarlo 2006, "Exaggerated
// Shading for Depicting Shape and Detail").
//
// At each scale the land's normal is compared with a light that grazes the next coarser form: the sun's direction minus
// its component along that form's normal. So ridges of every size have a light and a dark side, on slopes that face the
// sun too. The product is exaggerated and clamped, and scales are added with weights, the coarsest form in the
// unchanged light.
//
// Changes: forms are levels of the pyramid under a B-spline, at a number of pixels per sample (surface/form.wgsl), and
// scales double where the paper's grow by the square root of two. Surfaces other than land have no forms, and the
// unchanged light.
#import hachure::view::{View, from_eye}
#import hachure::seen::{place_seen, surface_seen}
#import hachure::terrain::grid_from_world
#import hachure::earth::{Unbent, unbend}
#import hachure::form::{level_seen, normal_of_level}
#import hachure::light::{Light, tone_of_lit}
#import hachure::surface_id::{has_trait, id_seen, ON_GRID}

struct ExaggerateRules {
    scales: u32,
    // Size of a sample of the finest form, in pixels.
    finest_px: f32,
    // Factor of the product before it is clamped.
    exaggeration: f32,
    // Weight of each coarser scale relative to the next finer one.
    coarser: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> light: Light;
@group(0) @binding(2) var<storage, read> exaggerate_rules: ExaggerateRules;
@group(0) @binding(3) var surface_id: texture_2d<u32>;
@group(0) @binding(4) var distance_m: texture_2d<f32>;
@group(0) @binding(5) var normal: texture_2d<u32>;
// rgb: white; a: the requested tone.
@group(0) @binding(6) var relief_light: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let at = place_seen(view, distance_m, pixel);
    if at.w <= 0.0 {
        textureStore(relief_light, pixel, vec4<f32>(1.0));
        return;
    }
    let own = surface_seen(normal, pixel);
    var lit = 0.5 + 0.5 * dot(own.xyz, light.to_sun);
    if has_trait(id_seen(surface_id, pixel), ON_GRID) {
        let flat_place = unbend(at.xyz);
        let point = grid_from_world(flat_place.flat_m.xy);
        let finest = level_seen(view, at.xyz, flat_place, point, exaggerate_rules.finest_px);
        var fine = own.xyz;
        var weight = 1.0;
        var sum = 0.0;
        var weights = 0.0;
        for (var i = 0u; i < exaggerate_rules.scales; i++) {
            let coarse = normal_of_level(flat_place, point, finest + f32(i));
            let along = light.to_sun - coarse * dot(coarse, light.to_sun);
            let grazing = along * inverseSqrt(max(dot(along, along), 1e-8));
            sum += weight * clamp(exaggerate_rules.exaggeration * dot(fine, grazing), -1.0, 1.0);
            weights += weight;
            weight *= exaggerate_rules.coarser;
            fine = coarse;
        }
        sum += weight * dot(fine, light.to_sun);
        lit = 0.5 + 0.5 * sum / (weights + weight);
    }
    textureStore(relief_light, pixel, vec4<f32>(vec3<f32>(1.0), tone_of_lit(light, own, lit)));
}
