// What both ways of hatching share: how darkness is divided among layers, along which axes a layer's marks lie at a
// place, and how these axes run on the picture.
//
// A *chart* is a pair of directions of the world: `across` the marks and `along` them. A coordinate along a direction
// is u = axis . place, in metres, so a chart is a solid texture (Benard et al. 2009): marks live in space and the
// surface cuts them out, without a parameterisation of the surface. Directions come from a fixed set of axes, 32 around
// the compass; where a layer follows the land, two neighbouring charts hand over to each other.
#define_import_path hachure::hatch
#import hachure::view::View

// Around the compass: north, then clockwise.
const AZIMUTHS: i32 = 32;
// After the level axes come those that fall at 45 degrees: no slope stands square to all of (level, falling).
const FIRST_FALLING: i32 = 32;
const HEIGHT_AXIS: i32 = 64;
// Then each layer's own two: across and along its fixed direction.
const FIRST_FIXED: i32 = 65;
// And each layer's own along direction again, on which one moves slowly.
const FIRST_SLOW: i32 = 73;
const STEP_RAD: f32 = 0.19634954;
// The part of a step of azimuth in which two charts share a place.
const AZIMUTH_ZONE: f32 = 0.5;
const FIXED: u32 = 0u;
const SLOPE: u32 = 1u;
const CONTOUR: u32 = 2u;
const SIGHT: u32 = 3u;
const CURVATURE: u32 = 4u;
// Of a layer: marks that have no ends, and such that darken by growing wider.
const ENDLESS: u32 = 1u;
const SWELLS: u32 = 2u;
// Round dots that know of each other.
const DOTS: u32 = 4u;

struct HatchLayer {
    // FIXED, SLOPE, CONTOUR, SIGHT or CURVATURE.
    direction: u32,
    // Which map.
    map: u32,
    // Marks are this much larger than their recipe has them.
    size: f32,
    // Added to the direction of the land, in steps of azimuth.
    turn: f32,
    // Unit, level: the fixed direction, and what level land falls back to.
    fixed_direction: vec2<f32>,
    // Length and width of a mark in pixels, for the fractal rule; a length of 0 is endless.
    marks_px: vec2<f32>,
    // ENDLESS, SWELLS, DOTS.
    flags: u32,
    // How much of the marks is only their mean: such as are too small for pixels.
    grey: f32,
    pad_a: f32,
    pad_b: f32,
}

struct Hatch {
    layers: array<HatchLayer, 4>,
    // Of each layer, in the order in which they begin. Optical density, -ln(1 - darkness), at which it does, and from
    // there to the next.
    begins: vec4<f32>,
    spans: vec4<f32>,
    // Steepness at which a layer comes and goes, as sines.
    comes_from: vec4<f32>,
    comes_full: vec4<f32>,
    goes_from: vec4<f32>,
    goes_full: vec4<f32>,
    count: u32,
    // Levels of the ladder and the first one's number.
    level_count: i32,
    first_level: i32,
    // Width of the border of a mark in thresholds, at least: 0 is sharp, a pencil has some.
    softness: f32,
    // Side of the tile in texels: a power of two.
    side: u32,
    // A bit for each layer that is drawn: all, or one whose marks are asked for alone.
    drawn: u32,
    // Not 0: some layer follows the curvature.
    by_curvature: u32,
    pad_c: u32,
}

// How a place moves over the surface from pixel to pixel.
struct Footprint {
    dx: vec3<f32>,
    dy: vec3<f32>,
}

// Of a plane with normal n through the place that a ray sees at `along_m`.
fn footprint(view: View, ray: vec3<f32>, along_m: f32, n: vec3<f32>) -> Footprint {
    let closing = dot(n, ray);
    // Beyond 89 degrees marks are allowed to shrink.
    let safe = select(1.0, -1.0, closing < 0.0) * max(abs(closing), 0.02 * length(ray));
    let dx = view.ray_dx - ray * (dot(n, view.ray_dx) / safe);
    let dy = view.ray_dy - ray * (dot(n, view.ray_dy) / safe);
    return Footprint(dx * along_m, dy * along_m);
}

// How a coordinate changes from pixel to pixel, in metres.
fn change_along(axis: vec3<f32>, foot: Footprint) -> vec2<f32> {
    return vec2<f32>(dot(axis, foot.dx), dot(axis, foot.dy));
}

// Optical densities add up where independent marks lie on each other: -ln(1 - coverage). A layer takes part from the
// darkness on at which it begins, in equal shares with the others that have begun, as far as it likes the slope. The
// first does what nobody likes. Returns each layer's darkness. Written out: software drivers index vectors slowly.
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

// Two charts and how much of the second.
struct Charts {
    across: vec2<i32>,
    along: vec2<i32>,
    second: f32,
}

fn azimuth_axis(first: i32, step: i32) -> i32 {
    return first + (step & (AZIMUTHS - 1));
}

// How much of its fixed direction a layer has where no direction bends more than others.
const UNDECIDED: f32 = 0.03;

// The charts along the greatest bend (surface/bend_axis.wgsl), as a line on the map. A line has no sense, so half of the
// compass is enough, and the charts of both ends are one. Level axes count along it: they run along lines of any slope.
fn charts_of_line(layer: HatchLayer, n: vec3<f32>, bend_axis: vec2<f32>) -> Charts {
    let fixed = layer.fixed_direction;
    let doubled = bend_axis + UNDECIDED * vec2<f32>(fixed.x * fixed.x - fixed.y * fixed.y, 2.0 * fixed.x * fixed.y);
    let angle = 0.5 * atan2(doubled.y, doubled.x);
    var ahead = vec2<f32>(cos(angle), sin(angle));
    if layer.turn != 0.0 {
        // On the surface, clockwise from above.
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

// The charts of a layer at a place with mark normal n, seen along a ray. `bend_axis` is for layers by curvature alone.
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
        // On a wall that stands square to an axis, height takes its place.
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
    // Along the contours as they are; turned ones are like those down the slope, a quarter further.
    if layer.direction == CONTOUR && layer.turn == 0.0 {
        let level = 1.0 - smoothstep(0.045, 0.06, steep);
        if (layer.flags & ENDLESS) != 0u {
            // What runs along a line without ends is its wobble: one axis for all, or lines would break where it
            // changes. It has the scale of what runs across, and height rises slowly.
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
    // Level land has no slope: there the fixed direction wins, without a border.
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
