// Cut lines: the intersections of the land with families of parallel planes, as wide as the tone is dark.
//
// An engraver places parallel lines that follow the form, and lets them swell in the shade. Tanaka drew relief this way
// with contour lines (K. Tanaka, "The Relief Contour Method of Representing Topography on Maps", 1950); Dürer's
// followers did with planes that are upright or inclined. Each family of planes is a height above one of them, so a
// pixel knows its distance from the next line from this height and its gradient over the picture, as `height_lines`
// does. Lines match at the borders of parts and where land hides land, they are fixed to the land, and never fork.
//
// The addition here: the density of lines follows the picture. Planes are at distances that are powers of two; where
// the lines of one power are more than 1.3 spacings apart, lines between them grow, so gaps stay between 0.7 and 1.45
// spacings on even slopes. A line is a part of the gaps on its sides, so ink matches the requested tone, while lines
// grow as well. The density of lines follows a coarser form than the lines themselves: they do not end in each small
// fold.
#import hachure::view::View
#import hachure::seen::place_seen
#import hachure::terrain::{terrain, grid_from_world}
#import hachure::earth::{bend_normal, unbend}
#import hachure::form::{form_of_level, level_seen, steps_on_plane}
#import hachure::surface_id::{has_trait, id_seen, ON_GRID}
#import hachure::line_ink::line_ink

struct CutFamily {
    // Unit normal of the planes: east, north, up.
    normal: vec3<f32>,
    // Height of the rig's origin above a plane that all powers of two share.
    phase_m: f32,
    spacing_px: f32,
    // Sine of the angle between land and planes below which land has no lines.
    level: f32,
    darkness_from: f32,
}

struct CutRules {
    form_px: f32,
    darkest: f32,
    count: u32,
    families: array<CutFamily, 3>,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> rules: CutRules;
@group(0) @binding(2) var surface_id: texture_2d<u32>;
@group(0) @binding(3) var distance_m: texture_2d<f32>;
@group(0) @binding(4) var tone: texture_2d<f32>;
// Ink of each family in its own channel, 0 to 1.
@group(0) @binding(5) var ink: texture_storage_2d<rgba16float, write>;

// Levels by which the form that determines density is coarser.
const COARSER: f32 = 1.5;
// Gaps, in spacings, between which the line in the middle of a gap grows.
const CLOSED_GAP: f32 = 1.3;
const OPEN_GAP: f32 = 1.45;
// Largest ratio of a gap to the gap of the coarser form that counts for a line's width: it avoids blots on crests and
// saddles.
const WIDEST_GAP: f32 = 1.25;
// Part of the darkness beyond `darkness_from` that a crossing family takes.
const CROSSING: f32 = 0.6;

// Returns the gradient to the east and to the north of the height above planes, on a form with this slope.
fn slope_above(normal: vec3<f32>, slope: vec2<f32>) -> vec2<f32> {
    return normal.xy + normal.z * slope;
}

// Returns the ink of lines `interval_m` apart, shifted by a part of that, at a height that changes by `rise_m` per
// pixel.
fn lines(height_m: f32, interval_m: f32, shift: f32, rise_m: f32, width_px: f32) -> f32 {
    let turn = height_m / interval_m - shift;
    let away_px = abs(turn - round(turn)) * interval_m / rise_m;
    return line_ink(away_px, width_px);
}

// Returns the ink of a family at a height above its planes that changes by `rise_m` per pixel, and by `calm_m` on the
// coarser form.
fn family_ink(family: CutFamily, height_m: f32, rise_m: f32, calm_m: f32, dark: f32) -> f32 {
    let wanted = log2(family.spacing_px * max(calm_m, 1e-12));
    // Whole lines are one to two spacings apart.
    let power = ceil(wanted);
    let gap = exp2(power - wanted);
    let share = smoothstep(CLOSED_GAP, OPEN_GAP, gap);
    let interval_m = exp2(power);
    let gap_px = interval_m / max(rise_m, calm_m / WIDEST_GAP);
    let own = lines(height_m, interval_m, 0.0, rise_m, (1.0 - 0.5 * share) * gap_px * dark);
    let between = lines(height_m, interval_m, 0.5, rise_m, 0.5 * share * gap_px * dark);
    return max(own, between);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let at = place_seen(view, distance_m, pixel);
    let dark = clamp(1.0 - textureLoad(tone, pixel, 0).a, 0.0, rules.darkest);
    if at.w <= 0.0 || dark <= 0.0 || !has_trait(id_seen(surface_id, pixel), ON_GRID) {
        textureStore(ink, pixel, vec4<f32>(0.0, 0.0, 0.0, 1.0));
        return;
    }
    let flat_place = unbend(at.xyz);
    let point = grid_from_world(flat_place.flat_m.xy);
    let level = level_seen(view, at.xyz, flat_place, point, rules.form_px);
    let form = form_of_level(point.g, level);
    let calm = form_of_level(point.g, level + COARSER).gradient;
    let slope = vec2<f32>(dot(form.gradient, point.dg_dx), dot(form.gradient, point.dg_dy));
    let calm_slope = vec2<f32>(dot(calm, point.dg_dx), dot(calm, point.dg_dy));
    let steps = steps_on_plane(view, pixel, at.w, bend_normal(flat_place, slope));

    // The darkness left by crossing families, as light that passes through all of them.
    var light = 1.0 - dark;
    for (var i = 1u; i < rules.count; i++) {
        light /= 1.0 - CROSSING * max(dark - rules.families[i].darkness_from, 0.0);
    }
    var inks = vec3<f32>(0.0);
    for (var i = 0u; i < rules.count; i++) {
        let family = rules.families[i];
        let own_dark = select(CROSSING * max(dark - family.darkness_from, 0.0), clamp(1.0 - light, 0.0, 1.0), i == 0u);
        let height_m = dot(family.normal, vec3<f32>(flat_place.flat_m.xy, form.height_m)) + family.phase_m;
        let by_m = slope_above(family.normal, slope);
        let rise_m = max(length(vec2<f32>(dot(by_m, steps[0].xy), dot(by_m, steps[1].xy))), 1e-9);
        let calm_by_m = slope_above(family.normal, calm_slope);
        let calm_m = length(vec2<f32>(dot(calm_by_m, steps[0].xy), dot(calm_by_m, steps[1].xy)));
        let calm_sine = length(cross(family.normal, normalize(vec3<f32>(-calm_slope, 1.0))));
        let sine = min(length(cross(family.normal, normalize(vec3<f32>(-slope, 1.0)))), calm_sine);
        inks[i] = family_ink(family, height_m, rise_m, calm_m, own_dark * smoothstep(family.level, 2.0 * family.level, sine));
    }
    textureStore(ink, pixel, vec4<f32>(inks, 1.0));
}
