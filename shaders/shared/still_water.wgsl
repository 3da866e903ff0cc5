// Still water in elevation data: lakes and the sea are level there, and nothing else of their size is.
#define_import_path hachure::still_water
#import hachure::terrain::{terrain, levels, place_on_level, as_far_as_there, is_in_grid, LevelPlace}
#import hachure::surface::{heights, Surface, surface_near, surface_at, cell_at, Cell}

// Limits of still water: its slope, rise over run; differences between its heights, in metres; and differences between
// means of many of its heights, in metres.
const STEEPEST_WATER: f32 = 2e-4;
const LEVEL_WATER_M: f32 = 0.03;
const LEVEL_MEAN_M: f32 = 0.004;
// Distance at which the heights around a place are compared, in metres.
const WATER_M: f32 = 90.0;
// A lake contains a level square whose side is twice LAKE_M or, if that is less, twice LAKE_SAMPLES samples, and at
// least four samples. Terraces of land in whole metres are narrower where it slopes by more than 0.25 degrees.
const LAKE_M: f32 = 120.0;
const LAKE_SAMPLES: f32 = 8.0;
// Number of searches for such a square: around a place, around four points ARM_SAMPLES samples away diagonally, and on
// two coarser levels.
const LAKE_LOOKS: i32 = 7;
const ARM_SAMPLES: f32 = 2.5;
// A level square is part of a terrace if, on one of TERRACE_LOOKS coarser levels, the land around it is lower by less
// than the slope GENTLE (rise over run) in TERRACE_SAMPLES of sixteen samples, or lower or higher by less than it in
// LEVEL_SAMPLES.
const GENTLE: f32 = 0.01;
const TERRACE_SAMPLES: f32 = 2.0;
const LEVEL_SAMPLES: f32 = 6.0;
const TERRACE_LOOKS: i32 = 3;
// A square that is level on a level this much coarser is a lake, whatever is around.
const LARGE: i32 = 2;
// An end of a lake looks like a terrace too. The rest of the lake is searched this many samples away in eight
// directions, and at this many distances, each twice the one before.
const END_SAMPLES: f32 = 3.0;
const ENDS: i32 = 4;
// Level ground within this height of 0 is the sea, never a terrace.
const SEA_M: f32 = 0.5;
// A world with no greater range of heights is level land, and has no shore that would reveal a lake.
const LEVEL_WORLD_M: f32 = 0.5;
// Samples are read this far off the grid of samples and their midpoints, so that rounding never decides which is
// nearest.
const OFF_GRID: f32 = 0.13;
const NO_LAKE: f32 = 1e30;
const VOID: f32 = 2e30;

fn is_level(surface: Surface) -> bool {
    return length(surface.gradient) <= STEEPEST_WATER * terrain.spacing_m;
}

// Returns in how many of eight directions the land has the same height, WATER_M away.
fn level_around(g: vec2<f32>, height_m: f32) -> i32 {
    var level = 0;
    for (var i = 0; i < 8; i++) {
        let angle = f32(i) * 0.78539816;
        let there = g + WATER_M / terrain.spacing_m * vec2<f32>(cos(angle), sin(angle));
        let surface = surface_at(surface_near(there, as_far_as_there(0.0, place_on_level(0, there), there)));
        level += i32(abs(surface.height_m - height_m) < LEVEL_WATER_M);
    }
    return level;
}

// Heights above the sea of the sixteen samples around a place, in rows; VOID where there is no data.
struct Window {
    row_a: vec4<f32>,
    row_b: vec4<f32>,
    row_c: vec4<f32>,
    row_d: vec4<f32>,
    // Fractional position between the middle samples, and the level that the samples are of.
    f: vec2<f32>,
    level: i32,
}

// The lowest bit of a no-data sample is set.
fn known(height_m: f32) -> f32 {
    return select(height_m, VOID, (bitcast<u32>(height_m) & 1u) != 0u);
}

fn window_row(cell: Cell, row: i32) -> vec4<f32> {
    let first = cell.texel + vec2<i32>(-1, row);
    return vec4<f32>(
        known(textureLoad(heights, first, cell.slot, 0).r),
        known(textureLoad(heights, first + vec2<i32>(1, 0), cell.slot, 0).r),
        known(textureLoad(heights, first + vec2<i32>(2, 0), cell.slot, 0).r),
        known(textureLoad(heights, first + vec2<i32>(3, 0), cell.slot, 0).r));
}

fn window_at(place: LevelPlace, g: vec2<f32>) -> Window {
    let cell = cell_at(place, g);
    return Window(window_row(cell, -1), window_row(cell, 0), window_row(cell, 1), window_row(cell, 2), cell.f, cell.level);
}

// Returns the window on a level that may be coarser than the pyramid: its samples then are means over points of the
// coarsest level.
fn wide_window(level: i32, g: vec2<f32>) -> Window {
    let last = terrain.level_count - 1;
    if level <= last {
        return window_at(place_on_level(level, g), g);
    }
    let info = levels[last];
    let size = f32(1 << u32(level - last));
    let c = (g * info.scale + info.fraction + vec2<f32>(info.cell) + 0.5) / size - 0.5;
    let f = fract(c);
    var rows = array<vec4<f32>, 4>();
    for (var i = 0; i < 16; i++) {
        let middle = vec2<f32>(vec2<i32>(i % 4, i / 4) - 1) - f;
        var sum = 0.0;
        for (var k = 0; k < 4; k++) {
            let aside = vec2<f32>(vec2<i32>(k % 2, k / 2)) * 0.5 - 0.25;
            sum += sample_at(last, g + (middle + aside) * size / info.scale);
        }
        rows[i / 4][i % 4] = min(0.25 * sum, VOID);
    }
    return Window(rows[0], rows[1], rows[2], rows[3], f, level);
}

// Returns level coordinates per grid coordinate.
fn wide_scale(level: i32) -> vec2<f32> {
    let last = min(level, terrain.level_count - 1);
    return levels[last].scale / f32(1 << u32(level - last));
}

// Returns the height of the sample that is nearest to a position.
fn sample_at(level: i32, g: vec2<f32>) -> f32 {
    let cell = cell_at(place_on_level(level, g), g);
    return known(textureLoad(heights, cell.texel + vec2<i32>(cell.f + 0.5), cell.slot, 0).r);
}

// Returns the heights of the three squares between two rows, NO_LAKE for those that are not level.
fn squares(a: vec4<f32>, b: vec4<f32>) -> vec3<f32> {
    let low = min(min(a.xyz, a.yzw), min(b.xyz, b.yzw));
    let high = max(max(a.xyz, a.yzw), max(b.xyz, b.yzw));
    return select(vec3<f32>(NO_LAKE), low, (high - low < vec3<f32>(LEVEL_MEAN_M)) & (high < vec3<f32>(NO_LAKE)));
}

fn all_at(window: Window, height_m: f32, within_m: f32) -> bool {
    let away = max(max(abs(window.row_a - height_m), abs(window.row_b - height_m)),
        max(abs(window.row_c - height_m), abs(window.row_d - height_m)));
    return all(away < vec4<f32>(within_m));
}

fn has_height(window: Window, height_m: f32) -> bool {
    let away = min(min(abs(window.row_a - height_m), abs(window.row_b - height_m)),
        min(abs(window.row_c - height_m), abs(window.row_d - height_m)));
    return any(away < vec4<f32>(LEVEL_WATER_M));
}

// Returns the finest level on which a level square of 2 × 2 samples is a lake.
fn lake_level() -> i32 {
    let samples = min(LAKE_M / terrain.spacing_m, LAKE_SAMPLES);
    return max(i32(round(log2(max(samples, 2.0)))), 1);
}

// A level square near a place: its height, or NO_LAKE, and its centre in the grid.
struct Square {
    height_m: f32,
    centre: vec2<f32>,
}

// Returns the first level square of the nine around a place on a level: the middle one, then the four that share its
// sides, then the corners.
fn level_square(g: vec2<f32>, level: i32) -> Square {
    let window = wide_window(level, g);
    let north = squares(window.row_a, window.row_b);
    let middle = squares(window.row_b, window.row_c);
    let south = squares(window.row_c, window.row_d);
    var found = middle.y;
    var offset = vec2<f32>(0.0);
    for (var i = 0; i < 8 && found == NO_LAKE; i++) {
        let next = array<vec2<i32>, 8>(vec2<i32>(0, -1), vec2<i32>(-1, 0), vec2<i32>(1, 0), vec2<i32>(0, 1),
            vec2<i32>(-1, -1), vec2<i32>(1, -1), vec2<i32>(-1, 1), vec2<i32>(1, 1))[i];
        let row = select(select(south, middle, next.y == 0), north, next.y < 0);
        found = select(select(row.z, row.y, next.x == 0), row.x, next.x < 0);
        offset = vec2<f32>(next);
    }
    let centre = g + (offset + 0.5 - window.f + OFF_GRID) / wide_scale(window.level);
    // Beyond the border all heights repeat those at the border.
    let half = 0.75 / wide_scale(window.level);
    if !is_in_grid(centre - half) || !is_in_grid(centre + half) {
        found = NO_LAKE;
    }
    if found != NO_LAKE && window.level > 0 {
        let under = wide_window(window.level - 1, centre);
        found = select(NO_LAKE, found, all_at(under, found, LEVEL_MEAN_M));
    }
    return Square(found, centre);
}

// Returns whether a level square is a terrace and not a lake: around it the land continues downward as gently as
// terraces do, or most of it is hardly higher. Land around a lake is higher, except at a dam, which is steep, and an
// outlet, which is narrow.
fn is_terrace(square: Square, level: i32) -> bool {
    if abs(square.height_m) <= SEA_M {
        return false;
    }
    var is_lower = false;
    for (var look = 1; look <= TERRACE_LOOKS && !is_lower; look++) {
        let window = wide_window(level + look, square.centre);
        let max_m = GENTLE * terrain.spacing_m * exp2(f32(level + look));
        let gentle = gently(window.row_a, square.height_m, max_m) + gently(window.row_b, square.height_m, max_m)
            + gently(window.row_c, square.height_m, max_m) + gently(window.row_d, square.height_m, max_m);
        is_lower = gentle.x >= TERRACE_SAMPLES || gentle.x + gentle.y >= LEVEL_SAMPLES;
    }
    return is_lower;
}

// Returns how many samples of a row are lower, and how many higher, but by no more than `max_m`.
fn gently(row: vec4<f32>, height_m: f32, max_m: f32) -> vec2<f32> {
    let by_m = height_m - row;
    let gentle = (abs(by_m) > vec4<f32>(LEVEL_WATER_M)) & (abs(by_m) < vec4<f32>(max_m));
    let none = vec4<f32>(0.0);
    let one = vec4<f32>(1.0);
    return vec2<f32>(dot(select(none, one, gentle & (by_m > none)), one), dot(select(none, one, gentle & (by_m < none)), one));
}

// Returns the height of the lake at a place or within a few samples of it, if `own` has that height; else NO_LAKE.
//
// A sample of a coarse level is the mean of those below it. Land around a lake is higher than the lake, so a mean
// equals the lake's height only where all of it is lake: four such means that are equal, with the sixteen below them,
// are a square of water. Most terraces are narrower, and means of slopes are not equal; a terrace that is as wide
// continues downward.
fn lake_near(g: vec2<f32>, own: Window) -> f32 {
    if terrain.max_z_m - terrain.min_z_m < LEVEL_WORLD_M {
        return NO_LAKE;
    }
    let first = max(lake_level(), own.level);
    var square = Square(NO_LAKE, g);
    var at = first;
    // Squares around the place come first, then those farther away on the same level, for the arms of a lake, then
    // larger ones.
    for (var look = 0; look < LAKE_LOOKS && square.height_m == NO_LAKE; look++) {
        at = first + max(look - 4, 0);
        let aside = vec2<f32>(f32((look & 1) * 2 - 1), f32((look & 2) - 1)) * select(0.0, ARM_SAMPLES, look > 0 && look < 5);
        square = level_square(g + aside / wide_scale(at), at);
        // The lake must be visible at the place itself, not only next to it.
        if !has_height(own, square.height_m) {
            square.height_m = NO_LAKE;
        }
    }
    if square.height_m == NO_LAKE || !is_terrace(square, at) {
        return square.height_m;
    }
    // The square may be the shallow end of a lake: then a nearby square at the same height is not a terrace.
    var goes_on = abs(level_square(square.centre, first + LARGE).height_m - square.height_m) < LEVEL_WATER_M;
    for (var i = 0; i < 8 * ENDS && !goes_on; i++) {
        let angle = f32(i) * 0.78539816;
        let away = END_SAMPLES * exp2(f32(i / 8)) * vec2<f32>(cos(angle), sin(angle));
        let other = level_square(square.centre + away / wide_scale(first), first);
        if abs(other.height_m - square.height_m) < LEVEL_WATER_M {
            goes_on = !is_terrace(other, first);
        }
    }
    return select(NO_LAKE, square.height_m, goes_on);
}
