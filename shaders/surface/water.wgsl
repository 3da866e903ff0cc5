// Computes the distance to the shore of still water, on the visible land, from the maps of its tiles.
#import hachure::view::{View, distance_from_eye, from_eye}
#import hachure::seen::place_seen
#import hachure::terrain::{terrain, grid_from_world}
#import hachure::earth::unbend
#import hachure::surface_id::{has_trait, id_seen, ON_GRID}
#import hachure::water_maps::shore_m

struct WaterRules {
    // Largest distance that is found, in pixels.
    reach_px: f32,
    pad_a: f32,
    pad_b: f32,
    pad_c: f32,
}

// Sine of the angle to the water below which shores are smoothed more, in inverse proportion to it, and up to a factor.
const FLAT: f32 = 0.3;
const LONGEST: f32 = 8.0;

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> water_rules: WaterRules;
@group(0) @binding(2) var surface_id: texture_2d<u32>;
@group(0) @binding(3) var distance_m: texture_2d<f32>;
// Metres to the shore on water, up to `reach_px`; negative on land near the shore; 0 elsewhere.
@group(0) @binding(4) var water: texture_storage_2d<r32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let at = place_seen(view, distance_m, pixel);
    if at.w <= 0.0 || !has_trait(id_seen(surface_id, pixel), ON_GRID) {
        textureStore(water, pixel, vec4<f32>(0.0));
        return;
    }
    let place = unbend(at.xyz);
    let away_m = distance_from_eye(view, at.xyz);
    let pixel_m = away_m / view.focal_px;
    // At flat angles a pixel is long, and a shore that is as fine as the pixel is wide would break into beads.
    let level_sight = abs(dot(from_eye(view, at.xyz), place.up)) / away_m;
    let long = clamp(FLAT / max(level_sight, 1e-4), 1.0, LONGEST);
    let point = grid_from_world(place.flat_m.xy);
    // The distance between columns of samples, and between rows, is the inverse of the gradient of the grid coordinate.
    let narrow = 1.0 / max(length(vec2<f32>(point.dg_dx.x, point.dg_dy.x)), length(vec2<f32>(point.dg_dx.y, point.dg_dy.y)));
    let found_m = shore_m(point.g, pixel_m * long, narrow / terrain.spacing_m, water_rules.reach_px * pixel_m);
    textureStore(water, pixel, vec4<f32>(found_m));
}
