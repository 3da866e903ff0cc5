// Still water on the land, and how far its shore is.
//
// Whether a place is water is asked of samples (shared/still_water.wgsl). The shore lies where half of what is around a
// place is water, under a B-spline, so it has no stairs. Its distance is that of the nearest sample of land, which is
// found from coarse squares to fine ones: a square whose mean is the lake's height has no land in it (as distance fields
// are traced, Hart 1996, "Sphere tracing", and bounded by the nearest that is known). From there the shore is looked for
// along the way, and near it by its normal as well, until it is the nearest place of a smooth line. All of it is asked of
// the level that has a sample in about a pixel, so it is a function of place and distance alone.
#import hachure::view::{View, distance_from_eye}
#import hachure::terrain::{terrain, levels, grid_from_world, place_on_level, as_far_as_there}
#import hachure::earth::unbend
#import hachure::surface_id::{kind_of, LAND}
#import hachure::still_water::{Water, Window, window_at, sample_at, lake_near, wetness, is_wet, LEVEL_MEAN_M, NO_LAKE}

struct WaterRules {
    // What is no higher is the sea, in metres above it; very low where the scene has no sea.
    sea_m: f32,
    // Distances are found up to here.
    reach_px: f32,
    pad_a: f32,
    pad_b: f32,
}

// Squares have this many smaller ones along a side.
const PARTS: i32 = 4;
// The largest squares: so many levels coarser.
const COARSER: i32 = 4;
const MOST_RINGS: i32 = 8;
// Nearer than this, by samples, the shore's normal tells where its nearest place is.
const NEAR: f32 = 3.0;
const STEPS: i32 = 4;
// Farther away the shore is looked for so many samples to both sides as well: the mean has less of the samples' stairs.
const ASIDE: f32 = 2.0;

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> water_rules: WaterRules;
@group(0) @binding(2) var surface_id: texture_2d<u32>;
@group(0) @binding(3) var position: texture_2d<f32>;
// Metres to the shore on water, as far as is asked; on land beside it below 0; 0 elsewhere.
@group(0) @binding(4) var water: texture_storage_2d<r32float, write>;

// A place and what surrounds it.
struct Here {
    g: vec2<f32>,
    level: i32,
    water: Water,
    // Metres in samples of the finest level, and the other way round.
    metres: mat2x2<f32>,
    samples: mat2x2<f32>,
    // The size of a sample of the level.
    sample_m: f32,
}

fn metres_to(here: Here, g: vec2<f32>) -> f32 {
    return length(here.metres * (g - here.g));
}

// Whether there is no land in a square: `side` is its sides by g.
fn is_all_water(here: Here, g: vec2<f32>, side: vec2<f32>, level: i32) -> bool {
    let last = terrain.level_count - 1;
    let at = sample_at(min(level, last), g);
    if level <= last {
        // The sea's floor is not level.
        return abs(at - here.water.lake_m) < LEVEL_MEAN_M || (here.water.lake_m == NO_LAKE && at <= here.water.sea_m - 0.5);
    }
    // Nothing coarser is there: its corners are asked.
    var is_all = is_wet(here.water, at);
    for (var i = 0; i < 4 && is_all; i++) {
        let corner = g + side * (vec2<f32>(vec2<i32>(i & 1, i >> 1u)) - 0.5);
        is_all = is_wet(here.water, sample_at(last, corner));
    }
    return is_all;
}

// The cells of a ring around a square, one after the other.
fn cell_of_ring(ring: i32, number: i32) -> vec2<i32> {
    if ring == 0 {
        return vec2<i32>(0);
    }
    let side = number / (2 * ring);
    let along = number % (2 * ring) - ring;
    let at = vec2<i32>(select(along, -along, side >= 2), -ring);
    return select(vec2<i32>(at.x, select(at.y, -at.y, side == 2)), vec2<i32>(select(-at.y, at.y, side == 3), at.x), side == 1 || side == 3);
}

// The sample of land that is nearest, by g, and its distance; `reach_m` if there is none within.
fn nearest_land(here: Here, reach_m: f32) -> vec3<f32> {
    let top = here.level + COARSER;
    let is_there = top < terrain.level_count;
    let info = levels[min(top, terrain.level_count - 1)];
    let side = select(f32(1 << u32(COARSER)) / levels[here.level].scale, 1.0 / info.scale, is_there);
    let c = here.g * info.scale + info.fraction;
    let middle = select(here.g, here.g + (round(c) - c) * side, is_there);
    let side_m = vec2<f32>(length(here.metres[0]) * side.x, length(here.metres[1]) * side.y);
    let half_m = 0.5 * max(length(here.metres * side), length(here.metres * vec2<f32>(side.x, -side.y)));
    let parts = f32(PARTS);
    var nearest = vec3<f32>(here.g, reach_m);
    for (var ring = 0; ring <= MOST_RINGS && f32(ring - 1) * min(side_m.x, side_m.y) < nearest.z; ring++) {
        for (var i = 0; i < max(8 * ring, 1); i++) {
            let g = middle + vec2<f32>(cell_of_ring(ring, i)) * side;
            if metres_to(here, g) - half_m > nearest.z || is_all_water(here, g, side, top) {
                continue;
            }
            for (var j = 0; j < PARTS * PARTS; j++) {
                let finer = g + side * ((vec2<f32>(vec2<i32>(j % PARTS, j / PARTS)) + 0.5) / parts - 0.5);
                if metres_to(here, finer) - half_m / parts > nearest.z || is_all_water(here, finer, side / parts, here.level + 2) {
                    continue;
                }
                for (var k = 0; k < PARTS * PARTS; k++) {
                    let one = finer + side / parts * ((vec2<f32>(vec2<i32>(k % PARTS, k / PARTS)) + 0.5) / parts - 0.5);
                    let away_m = metres_to(here, one);
                    if away_m < nearest.z && !is_wet(here.water, sample_at(here.level, one)) {
                        nearest = vec3<f32>(one, away_m);
                    }
                }
            }
        }
    }
    return nearest;
}

// How much is water around a place `at_m` from here, and the gradient of that by metres.
fn wetness_at(here: Here, at_m: vec2<f32>) -> vec3<f32> {
    let g = here.g + here.samples * at_m;
    let found = wetness(here.water, window_at(place_on_level(here.level, g), g));
    return vec3<f32>(found.x, found.yz * here.samples);
}

// The shore from a place on, along a direction.
fn along_m(here: Here, first_m: vec2<f32>, toward: vec2<f32>, steps: i32) -> vec2<f32> {
    var at_m = first_m;
    for (var step = 0; step < steps; step++) {
        let found = wetness_at(here, at_m);
        let falls = max(dot(-found.yz, toward), 0.0);
        let by_m = (found.x - 0.5) / max(falls, 0.3 / here.sample_m);
        at_m += toward * clamp(by_m, -here.sample_m, here.sample_m);
    }
    return at_m;
}

// The distance of the shore by the nearest sample of land, `land_m` from here.
fn shore_m(here: Here, land_m: vec2<f32>) -> f32 {
    var toward = normalize(land_m);
    let first_m = land_m - 0.5 * here.sample_m * toward;
    if length(land_m) > NEAR * here.sample_m {
        let middle_m = length(along_m(here, first_m, toward, STEPS - 1));
        var sum = vec2<f32>(middle_m, 1.0);
        for (var side = -1; side <= 1; side += 2) {
            let aside = f32(side) * ASIDE * here.sample_m * vec2<f32>(-toward.y, toward.x);
            let beside_m = dot(along_m(here, toward * middle_m + aside, toward, STEPS - 2), toward);
            // A shore that turns away is another matter.
            sum += vec2<f32>(beside_m, 1.0) * (1.0 - smoothstep(0.5, 1.0, abs(beside_m - middle_m) / here.sample_m));
        }
        return sum.x / sum.y;
    }
    var at_m = first_m;
    for (var step = 0; step < STEPS; step++) {
        let slope = wetness_at(here, at_m).yz;
        if length(slope) > 0.1 / here.sample_m && dot(-slope, toward) > 0.2 * length(slope) {
            toward = -normalize(slope);
        }
        at_m = along_m(here, at_m, toward, 1);
        if step < STEPS - 1 {
            at_m = toward * dot(at_m, toward);
        }
    }
    return length(at_m);
}

// A sample that has some land is none of water, so the shore lies farther than between samples on coarse levels: by half a
// sample, from corner to corner where it lies across. (Grids whose size is odd have samples that reach a little farther.)
fn farther_m(here: Here, toward: vec2<f32>) -> f32 {
    let corner = (abs(toward.x) + abs(toward.y)) / max(length(toward), 1e-12);
    return select(0.5 * corner * here.sample_m, 0.0, here.level == 0);
}

fn reaches(window: Window, sea_m: f32) -> bool {
    let low = min(min(window.row_a, window.row_b), min(window.row_c, window.row_d));
    return any(low <= vec4<f32>(sea_m));
}

// Whether samples beside each other are level, or the sea's.
fn any_level(window: Window, sea_m: f32) -> bool {
    let down = min(min(abs(window.row_a - window.row_b), abs(window.row_b - window.row_c)), abs(window.row_c - window.row_d));
    let across = min(min(abs(window.row_a.xyz - window.row_a.yzw), abs(window.row_b.xyz - window.row_b.yzw)),
        min(abs(window.row_c.xyz - window.row_c.yzw), abs(window.row_d.xyz - window.row_d.yzw)));
    return any(down < vec4<f32>(LEVEL_MEAN_M)) || any(across < vec3<f32>(LEVEL_MEAN_M)) || reaches(window, sea_m);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let at = textureLoad(position, pixel, 0);
    if at.w <= 0.0 || kind_of(textureLoad(surface_id, pixel, 0).r) != LAND {
        textureStore(water, pixel, vec4<f32>(0.0));
        return;
    }
    let point = grid_from_world(unbend(at.xyz).flat_m.xy);
    let pixel_m = distance_from_eye(view, at.xyz) / view.focal_px;
    let wanted = clamp(log2(pixel_m / terrain.spacing_m), 0.0, f32(terrain.level_count - 1));
    let place = as_far_as_there(wanted, place_on_level(i32(wanted), point.g), point.g).place;
    let window = window_at(place, point.g);
    if !any_level(window, water_rules.sea_m) {
        textureStore(water, pixel, vec4<f32>(0.0));
        return;
    }
    let here_water = Water(lake_near(point.g, window), water_rules.sea_m);
    let found = wetness(here_water, window);
    // Holes of the data are no water by themselves.
    if found.x <= 0.0 || (here_water.lake_m == NO_LAKE && !reaches(window, water_rules.sea_m)) {
        textureStore(water, pixel, vec4<f32>(0.0));
        return;
    }
    let determinant = point.dg_dx.x * point.dg_dy.y - point.dg_dx.y * point.dg_dy.x;
    let metres = mat2x2<f32>(point.dg_dy.y, -point.dg_dx.y, -point.dg_dy.x, point.dg_dx.x) * (1.0 / determinant);
    let sample_m = terrain.spacing_m * exp2(f32(place.level));
    let here = Here(point.g, place.level, here_water, metres, mat2x2<f32>(point.dg_dx, point.dg_dy), sample_m);
    let reach_m = water_rules.reach_px * pixel_m;
    var distance_m: f32;
    if found.x < 0.5 {
        let steep = length(found.yz * here.samples);
        distance_m = max((found.x - 0.5) / max(steep, 0.05 / sample_m), -2.0 * sample_m) + farther_m(here, found.yz);
    } else {
        let land = nearest_land(here, reach_m + sample_m);
        let way = land.xy - here.g;
        distance_m = reach_m;
        if land.z < reach_m + sample_m {
            distance_m = min(shore_m(here, here.metres * way) + farther_m(here, way), reach_m);
        }
    }
    textureStore(water, pixel, vec4<f32>(select(distance_m, -1e-6, distance_m == 0.0)));
}
