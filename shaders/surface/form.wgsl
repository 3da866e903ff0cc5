// The form of the land: the normal that is lit, at one pixel of sixteen.
//
// A cartographer lights the land's form and not each of its samples (Imhof 1965, "Kartographische Geländedarstellung",
// on generalisation in shaded relief): a few large masses of shade, whose borders are as calm as the picture is coarse.
// The form is the level of the pyramid that has `form_px` pixels per sample, under a B-spline, which smooths the
// samples and does not pass through them. It is a function of position and distance alone, like the mark normals. Near
// the eye, where the finest samples are larger than that, the form is the land itself.
//
// A ridge that runs along the light has the same tone on both sides. There the light turns, always to the same side, by
// up to `turn_rad`, as cartographers and Brassel (1974, "A Model for Automatic Hill-Shading") turn it. Instead of the
// light the normal is rotated, in the opposite direction around the plumb line: so slopes, and the light on other
// things, stay as they are.
#import hachure::view::View
#import hachure::seen::place_seen
#import hachure::terrain::{terrain, grid_from_world}
#import hachure::earth::unbend
#import hachure::form::{form_of_level, form_seen, MAX_BEYOND}
#import hachure::mark_normal::{block_count, pixel_of_block}
#import hachure::surface_id::{has_trait, id_seen, ON_GRID}

struct FormRules {
    // Horizontal unit vector toward the sun.
    to_sun: vec2<f32>,
    // Size of a sample of the requested level, in pixels.
    form_px: f32,
    turn_rad: f32,
}

// Levels by which the form that defines ridges is coarser; and the squared change of slope over a sample at which the
// light turns by half of the maximum.
const RIDGE_LEVELS: f32 = 2.0;
const RIDGE: f32 = 0.01;

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> form_rules: FormRules;
@group(0) @binding(2) var surface_id: texture_2d<u32>;
@group(0) @binding(3) var distance_m: texture_2d<f32>;
// xyz: unit normal in the world; w: distance along the view axis. All 0 where there is no land.
@group(0) @binding(4) var form_normal: texture_storage_2d<rgba32float, write>;

// Returns how far the light turns, as a part of the maximum. `bends` are second derivatives by x, y of the world: xx,
// xy, yy, over a sample of the form.
fn turned(bends: vec3<f32>) -> f32 {
    // Directions are represented by twice their angle, so that both ends of a ridge are the same. The greatest bend is
    // along `most`; along a ridge, where the land bends down on the whole, the least bend is across it.
    let most = vec2<f32>(bends.x - bends.z, 2.0 * bends.y);
    let sum = bends.x + bends.z;
    let along = -most * sign(sum);
    let sun = vec2<f32>(form_rules.to_sun.x * form_rules.to_sun.x - form_rules.to_sun.y * form_rules.to_sun.y,
        2.0 * form_rules.to_sun.x * form_rules.to_sun.y);
    let strength = min(dot(most, most), sum * sum);
    let aligned = max(dot(along, sun) * inverseSqrt(max(dot(along, along), 1e-20)), 0.0);
    return aligned * aligned * strength / (strength + RIDGE);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let block = vec2<i32>(id.xy);
    if any(id.xy >= block_count(view)) {
        return;
    }
    let pixel = pixel_of_block(view, block);
    let at = place_seen(view, distance_m, pixel);
    if at.w <= 0.0 || !has_trait(id_seen(surface_id, pixel), ON_GRID) {
        textureStore(form_normal, block, vec4<f32>(0.0));
        return;
    }
    let flat_place = unbend(at.xyz);
    let point = grid_from_world(flat_place.flat_m.xy);
    let form = form_seen(view, at.xyz, flat_place, point, form_rules.form_px);
    var n = form.normal;
    if form_rules.turn_rad != 0.0 {
        // Ridges of the coarser form determine the turn.
        let level = form.level + RIDGE_LEVELS;
        let ridge = form_of_level(point.g, level);
        let xx = vec3<f32>(point.dg_dx.x * point.dg_dx.x, 2.0 * point.dg_dx.x * point.dg_dx.y, point.dg_dx.y * point.dg_dx.y);
        let yy = vec3<f32>(point.dg_dy.x * point.dg_dy.x, 2.0 * point.dg_dy.x * point.dg_dy.y, point.dg_dy.y * point.dg_dy.y);
        let xy = vec3<f32>(point.dg_dx.x * point.dg_dy.x, point.dg_dx.x * point.dg_dy.y + point.dg_dx.y * point.dg_dy.x,
            point.dg_dx.y * point.dg_dy.y);
        let bends = vec3<f32>(dot(ridge.curvature, xx), dot(ridge.curvature, xy), dot(ridge.curvature, yy));
        let turn = -form_rules.turn_rad * turned(bends * terrain.spacing_m * exp2(clamp(level, 0.0, f32(terrain.level_count - 1) + MAX_BEYOND)));
        n = vec3<f32>(cos(turn) * n.x - sin(turn) * n.y, sin(turn) * n.x + cos(turn) * n.y, n.z);
    }
    textureStore(form_normal, block, vec4<f32>(n, at.w));
}
