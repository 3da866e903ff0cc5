// Makes crests lighter and hollows darker, by the curvature of the land: shading by curvature in addition to shading by
// the sun (Kennelly 2008, "Terrain maps displaying hill-shading with curvature"). It shows forms that run along the
// light, and those in the shade.
//
// The light that is added depends on the mean of the principal curvatures over a sample of the form, which is how far
// the normal turns there; a sharp ridge gains little more than a blunt one. Land that a style leaves white for its
// slope gains nothing.
#import hachure::view::View
#import hachure::seen::place_seen
#import hachure::light::Light
#import hachure::mark_normal::values_between_blocks

struct CrestRules {
    // Largest gain of crests, and loss of hollows.
    most: f32,
}

// Turn of the normal over a sample, in radians, at which half of that is gained.
const HALF_AT: f32 = 0.15;

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> light: Light;
@group(0) @binding(2) var<uniform> crest_rules: CrestRules;
@group(0) @binding(3) var distance_m: texture_2d<f32>;
@group(0) @binding(4) var shape_normal: texture_2d<f32>;
@group(0) @binding(5) var shape_bend: texture_2d<f32>;
// Light to add, -1 to 1.
@group(0) @binding(6) var crest_light: texture_storage_2d<r32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let at = place_seen(view, distance_m, pixel);
    if at.w <= 0.0 {
        textureStore(crest_light, pixel, vec4<f32>(0.0));
        return;
    }
    // Curvature times the size of a sample, each of which is interpolated.
    let bend = values_between_blocks(view, shape_normal, shape_bend, pixel, at);
    let turn = 0.5 * (bend.x + bend.z) * bend.w;
    var gain = crest_rules.most * turn / (HALF_AT + abs(turn));
    if light.level_end > 0.0 {
        let n = values_between_blocks(view, shape_normal, shape_normal, pixel, at).xyz;
        gain *= smoothstep(light.level, light.level_end, length(n.xy) / max(n.z, 1e-3));
    }
    textureStore(crest_light, pixel, vec4<f32>(gain));
}
