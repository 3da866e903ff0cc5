// Code that both kinds of hatching (tones/hatching.wgsl, tones/fractal_hatching.wgsl) share: how darkness is divided
// among layers, along which axes a layer's marks run at a place, and how these axes project on the picture.
//
// A *chart* is a pair of directions of the world: `across` the marks and `along` them. The coordinate along a direction
// is u = axis . place, in metres, so a chart is a solid texture (Benard et al. 2009): marks are defined in space and
// the surface cuts through them, without a parameterisation of the surface. Directions come from a fixed set of axes,
// 32 around the compass; where a layer follows the land, two neighbouring charts are blended.
#define_import_path hachure::hatch
#import hachure::view::View

// Level axes around the compass: north, then clockwise.
const AZIMUTHS: i32 = 32;
// First of the axes that fall at 45 degrees. No slope is perpendicular to both a level axis and its falling one.
const FIRST_FALLING: i32 = 32;
const HEIGHT_AXIS: i32 = 64;
// First of each layer's own two axes: across and along its fixed direction.
const FIRST_FIXED: i32 = 65;
// First of each layer's own along axis again, on which the coordinate changes slowly.
const FIRST_SLOW: i32 = 73;
const STEP_RAD: f32 = 0.19634954;
// Part of a step of azimuth in which two charts are blended.
const AZIMUTH_ZONE: f32 = 0.5;
const FIXED: u32 = 0u;
const SLOPE: u32 = 1u;
const CONTOUR: u32 = 2u;
const SIGHT: u32 = 3u;
const CURVATURE: u32 = 4u;
// Flags of a layer: its marks have no ends; and its marks darken by growing wider.
const ENDLESS: u32 = 1u;
const SWELLS: u32 = 2u;
// Flag: round dots that keep apart (dots.wgsl).
const DOTS: u32 = 4u;

struct HatchLayer {
    // FIXED, SLOPE, CONTOUR, SIGHT or CURVATURE.
    direction: u32,
    // Index of the layer's tonal art map.
    map: u32,
    // Size of marks relative to their recipe.
    size: f32,
    // Rotation from the direction of the land, clockwise, in steps of azimuth (STEP_RAD).
    turn: f32,
    // Horizontal unit vector: the fixed direction, which level land uses too.
    fixed_direction: vec2<f32>,
    // Length and width of a mark in pixels, for the fractal rule; a length of 0 is endless.
    marks_px: vec2<f32>,
    // Bits: ENDLESS, SWELLS, DOTS.
    flags: u32,
    // Part of the marks that is replaced by their mean, 0 to 1, for marks too small for pixels.
    grey: f32,
    pad_a: f32,
    pad_b: f32,
}

struct Hatch {
    layers: array<HatchLayer, 4>,
    // Optical density, -ln(1 - darkness), at which each layer begins, and the span from there to the next. Layers are
    // in the order in which they begin.
    begins: vec4<f32>,
    spans: vec4<f32>,
    // Steepness at which a layer fades in and out, as sines.
    comes_from: vec4<f32>,
    comes_full: vec4<f32>,
    goes_from: vec4<f32>,
    goes_full: vec4<f32>,
    count: u32,
    // Number of levels of the ladder, and the number of the first.
    level_count: i32,
    first_level: i32,
    // Smallest width of a mark's border, in thresholds: 0 is sharp, a pencil has some.
    softness: f32,
    // Side of the tile in texels: a power of two.
    side: u32,
    // One bit for each layer that is drawn: all layers, or the only one that was requested.
    drawn: u32,
    // Not 0: some layer follows the curvature.
    by_curvature: u32,
    // Part of the requested darkness that marks reproduce, 0 to 1.
    share: f32,
}

// Derivative of the surface point from pixel to pixel, right and down, in metres.
struct Footprint {
    dx: vec3<f32>,
    dy: vec3<f32>,
}

// Returns the footprint on a plane with normal n, through the point at `along_m` on a ray.
fn footprint(view: View, ray: vec3<f32>, along_m: f32, n: vec3<f32>) -> Footprint {
    let closing = dot(n, ray);
    // Beyond 89 degrees marks may shrink.
    let safe = select(1.0, -1.0, closing < 0.0) * max(abs(closing), 0.02 * length(ray));
    let dx = view.ray_dx - ray * (dot(n, view.ray_dx) / safe);
    let dy = view.ray_dy - ray * (dot(n, view.ray_dy) / safe);
    return Footprint(dx * along_m, dy * along_m);
}

// Returns the change of a coordinate from pixel to pixel, right and down, in metres.
fn change_along(axis: vec3<f32>, foot: Footprint) -> vec2<f32> {
    return vec2<f32>(dot(axis, foot.dx), dot(axis, foot.dy));
}

// Divides a darkness among the layers; returns each layer's darkness. Where independent marks overlap, optical
// densities -ln(1 - coverage) add up. A layer takes part from the darkness at which it begins, in equal shares with the
// others that have begun, weighted by its range of steepness. The first layer takes the darkness that no other layer
// may take. The loop is unrolled because software drivers index vectors slowly.
fn divide(hatch: Hatch, darkness: f32, steepness: f32) -> vec4<f32> {
    let whole = -log(max(1.0 - darkness, 1e-4));
    let liking = smoothstep(hatch.comes_from, hatch.comes_full, vec4<f32>(steepness))
        * (1.0 - smoothstep(hatch.goes_from, hatch.goes_full, vec4<f32>(steepness)));
    let span = clamp(vec4<f32>(whole) - hatch.begins, vec4<f32>(0.0), hatch.spans);
    let two = vec4<f32>(liking.xy, 0.0, 0.0);
    let three = vec4<f32>(liking.xyz, 0.0);
    let nobody = vec4<f32>(1.0, 0.0, 0.0, 0.0);
    var densities = nobody * span.x;
    densities += select(nobody, two / max(two.x + two.y, 1e-6), two.x + two.y > 1e-3) * span.y;
    let sum = three.x + three.y + three.z;
    densities += select(nobody, three / max(sum, 1e-6), sum > 1e-3) * span.z;
    densities += select(nobody, liking / max(sum + liking.w, 1e-6), sum + liking.w > 1e-3) * span.w;
    return 1.0 - exp(-densities);
}

// Two charts, and the weight of the second, 0 to 1.
struct Charts {
    across: vec2<i32>,
    along: vec2<i32>,
    second: f32,
}

fn azimuth_axis(first: i32, step: i32) -> i32 {
    return first + (step & (AZIMUTHS - 1));
}

// Weight of the fixed direction where no direction bends more than others.
const UNDECIDED: f32 = 0.03;

// Returns the charts along the direction of greatest curvature (surface/bend_axis.wgsl), as a line on the map. A line
// has no sense, so half of the compass is enough, and the charts at both ends are the same. Level axes serve as
// `along`: they suit lines of any slope.
fn charts_of_line(layer: HatchLayer, n: vec3<f32>, bend_axis: vec2<f32>) -> Charts {
    let fixed = layer.fixed_direction;
    let doubled = bend_axis + UNDECIDED * vec2<f32>(fixed.x * fixed.x - fixed.y * fixed.y, 2.0 * fixed.x * fixed.y);
    let angle = 0.5 * atan2(doubled.y, doubled.x);
    var ahead = vec2<f32>(cos(angle), sin(angle));
    if layer.turn != 0.0 {
        // The turn is on the surface, clockwise from above.
        let along = normalize(vec3<f32>(ahead, -dot(n.xy, ahead) / max(n.z, 0.05)));
        let turn = layer.turn * STEP_RAD;
        ahead = (cos(turn) * along - sin(turn) * cross(n, along)).xy;
    }
    let half = AZIMUTHS / 2;
    let step = atan2(ahead.x, ahead.y) / STEP_RAD + f32(AZIMUTHS);
    let whole = floor(step);
    let a = i32(whole) & (half - 1);
    let b = (i32(whole) + 1) & (half - 1);
    return Charts(vec2<i32>(a + 8, b + 8), vec2<i32>(a, b), clamp((step - whole - 0.5) / AZIMUTH_ZONE + 0.5, 0.0, 1.0));
}

// Returns the charts of a layer at a place with mark normal n, seen along a ray. `bend_axis` is used only by layers
// that follow the curvature.
fn charts_at(layer: HatchLayer, index: i32, n: vec3<f32>, ray: vec3<f32>, bend_axis: vec2<f32>) -> Charts {
    if layer.direction == CURVATURE {
        return charts_of_line(layer, n, bend_axis);
    }
    let own_across = FIRST_FIXED + 2 * index;
    let own_along = own_across + 1;
    let fixed_across = vec3<f32>(layer.fixed_direction.y, -layer.fixed_direction.x, 0.0);
    let facing_across = abs(dot(n, fixed_across));
    let facing_along = abs(dot(n.xy, layer.fixed_direction));
    if layer.direction == FIXED {
        // On a wall perpendicular to an axis, the height axis replaces it.
        let no_across = smoothstep(0.95, 0.985, facing_across);
        let no_along = smoothstep(0.75, 0.85, facing_along);
        if no_across > 0.0 {
            return Charts(vec2<i32>(own_across, HEIGHT_AXIS), vec2<i32>(own_along), no_across);
        }
        if (layer.flags & ENDLESS) != 0u {
            return Charts(vec2<i32>(own_across), vec2<i32>(own_along), 0.0);
        }
        return Charts(vec2<i32>(own_across), vec2<i32>(own_along, HEIGHT_AXIS), no_along);
    }
    let steep = length(n.xy);
    // Layers along the contours, without a turn. Turned ones are treated like those down the slope, a quarter turn
    // further.
    if layer.direction == CONTOUR && layer.turn == 0.0 {
        let level = 1.0 - smoothstep(0.045, 0.06, steep);
        if (layer.flags & ENDLESS) != 0u {
            // Along a line without ends only its wobble varies, so one axis serves all: lines would break where the
            // axis changes. The axis has the scale of the `across` axis, and height changes slowly.
            return Charts(vec2<i32>(HEIGHT_AXIS, own_across), vec2<i32>(FIRST_SLOW + index, own_along), level);
        }
        let step = atan2(n.x, n.y) / STEP_RAD + 8.0;
        let whole = floor(step);
        let second = clamp((step - whole - 0.5) / AZIMUTH_ZONE + 0.5, 0.0, 1.0);
        let here = azimuth_axis(0, i32(whole) + i32(second > 0.5));
        if level > 0.0 {
            return Charts(vec2<i32>(HEIGHT_AXIS, own_across), vec2<i32>(here, own_along), level);
        }
        return Charts(vec2<i32>(HEIGHT_AXIS),
            vec2<i32>(azimuth_axis(0, i32(whole)), azimuth_axis(0, i32(whole) + 1)), second);
    }
    // Level land has no slope: there the fixed direction takes over gradually.
    let is_contour = layer.direction == CONTOUR;
    let level_ahead = select(layer.fixed_direction, -fixed_across.xy, is_contour);
    var ahead = n.xy + level_ahead * (0.03 * max(1.0 - steep * 8.0, 0.0));
    if layer.direction == SIGHT {
        // Straight down, as on a map, nothing is seen at a flat angle.
        if length(ray.xy) < 0.03 * abs(ray.z) {
            return Charts(vec2<i32>(own_across), vec2<i32>(own_along), 0.0);
        }
        ahead = -ray.xy;
    }
    let step = atan2(ahead.x, ahead.y) / STEP_RAD + layer.turn + select(0.0, 8.0, is_contour) + f32(AZIMUTHS);
    let whole = floor(step);
    let second = clamp((step - whole - 0.5) / AZIMUTH_ZONE + 0.5, 0.0, 1.0);
    let a = i32(whole);
    return Charts(
        vec2<i32>(azimuth_axis(0, a + 8), azimuth_axis(0, a + 9)),
        vec2<i32>(azimuth_axis(FIRST_FALLING, a), azimuth_axis(FIRST_FALLING, a + 1)), second);
}
