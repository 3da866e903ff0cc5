// The mark normal of the land: its normal at the scale of hatching marks, at one pixel of sixteen.
//
// Marks follow the land's form, not its pebbles: direction and foreshortening of hatching come from the level of the
// pyramid that has `form_px` pixels per sample, under a B-spline (shared/form.wgsl). On gentle land small forms hardly
// define which way is down, so marks follow a form up to CALM_LEVELS levels coarser there, and stay in rows. The mark
// normal is a function of position and distance alone, so it is smooth across tiles and levels of detail, and does not
// change when the camera turns. Marks treat a tree as flat and facing the eye.
#import hachure::view::View
#import hachure::seen::{place_seen, surface_seen}
#import hachure::terrain::grid_from_world
#import hachure::earth::unbend
#import hachure::form::{form_seen, normal_of_level}
#import hachure::mark_normal::{BLOCK_PX, block_count, pixel_of_block, own_mark_normal}
#import hachure::surface_id::{has_trait, id_seen, ON_GRID}

struct MarkRules {
    // Size of a sample of the requested level, in pixels.
    form_px: f32,
    // Slope, rise over run, below which land uses a coarser form.
    calm: f32,
}

const CALM_LEVELS: f32 = 2.0;

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> mark_rules: MarkRules;
@group(0) @binding(2) var surface_id: texture_2d<u32>;
@group(0) @binding(3) var distance_m: texture_2d<f32>;
@group(0) @binding(4) var normal: texture_2d<u32>;
// xyz: unit normal in the world; w: distance along the view axis. All 0 is the sky.
@group(0) @binding(5) var mark_normal: texture_storage_2d<rgba32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let block = vec2<i32>(id.xy);
    if any(id.xy >= block_count(view)) {
        return;
    }
    let pixel = pixel_of_block(view, block);
    let at = place_seen(view, distance_m, pixel);
    if at.w <= 0.0 {
        textureStore(mark_normal, block, vec4<f32>(0.0));
        return;
    }
    if !has_trait(id_seen(surface_id, pixel), ON_GRID) {
        textureStore(mark_normal, block, vec4<f32>(own_mark_normal(view, pixel, surface_seen(normal, pixel)), at.w));
        return;
    }
    let flat_place = unbend(at.xyz);
    let point = grid_from_world(flat_place.flat_m.xy);
    let form = form_seen(view, at.xyz, flat_place, point, mark_rules.form_px);
    var n = form.normal;
    let steep = length(n.xy) / max(n.z, 1e-3);
    if steep < mark_rules.calm {
        let coarser = min(log2(mark_rules.calm / max(steep, 1e-3)), CALM_LEVELS);
        n = normal_of_level(flat_place, point, form.level + coarser);
    }
    textureStore(mark_normal, block, vec4<f32>(n, at.w));
}
