// The distance of a place from the shore of still water, from the tiles that `surface/lakes` makes.
//
// A map holds the signed distance of each sample of its tile and of two around it, in samples of its level, in 8 bits,
// with more precision near the shore. Between samples it is a B-spline, so that shores are smooth where a sample is
// many pixels wide. The level is that of the pixel's footprint, and between levels distances are mixed: both are
// functions of position and distance alone, so nothing pops. A place too far from the shore for a level is left to the
// coarser one, whose distances reach twice as far.
#define_import_path hachure::water_maps
#import hachure::terrain::{terrain, tiles, place_on_level, between_corners, LevelPlace, TILE_SAMPLES, TILE_BORDER, NO_MAP}
#import hachure::surface::spline_weights

// Texels of a map across, each with four samples of a row, and rows. The last row is a flag: whether there is any
// water.
const MAP_WORDS: i32 = 65;
const MAP_ROWS: i32 = 261;
// Largest distance at which shores are found along each axis, in samples.
const SHORE_REACH: i32 = 31;
// Margin around a tile in which lakes are searched, in samples, and the resulting number of samples along a side.
const AROUND: i32 = 34;
const SIDE: i32 = 324;
// Distances that represent land, and water, farther from the shore, in samples; land is negative.
const FAR_LAND: f32 = -2.5;
const FAR_WATER: f32 = 32.0;
// Codes of land; the others are water's: their number, and the linear and quadratic coefficients of distance, so that
// steps are finer near the shore.
const LAND_CODES: f32 = 48.0;
const WATER_CODES: f32 = 207.0;
const NEAR_STEP: f32 = 8.6;
const FAR_STEP: f32 = 23.4;
// Parts of a map's reach: from the first on the coarser level gains weight, from the second on it alone counts.
const FAR_FROM: f32 = 0.55;
const FAR_TO: f32 = 0.8;
// Land within this distance of the shore still shows it, in samples; negative is land.
const SEEN_LAND: f32 = -2.2;

@group(0) @binding(17) var water_maps: texture_2d_array<u32>;

// Returns the code of a signed distance, 0 to 255.
fn code_of(distance: f32) -> f32 {
    let land = (distance / -FAR_LAND + 1.0) * LAND_CODES;
    let root = sqrt(NEAR_STEP * NEAR_STEP + 4.0 * FAR_STEP * max(distance, 0.0));
    let water = LAND_CODES + WATER_CODES * (root - NEAR_STEP) / (2.0 * FAR_STEP);
    return clamp(round(select(water, land, distance < 0.0)), 0.0, 255.0);
}

fn distances_of(codes: vec4<f32>) -> vec4<f32> {
    let off = codes * 255.0 - LAND_CODES;
    let water = max(off, vec4<f32>(0.0)) / WATER_CODES;
    return min(off, vec4<f32>(0.0)) * (-FAR_LAND / LAND_CODES) + water * (NEAR_STEP + FAR_STEP * water);
}

// Returns the codes of four samples of a row.
fn codes_in(slot: i32, first: i32, row: i32) -> u32 {
    let low = textureLoad(water_maps, vec2<i32>(first >> 2u, row), slot, 0).r;
    let high = textureLoad(water_maps, vec2<i32>((first >> 2u) + 1, row), slot, 0).r;
    let shift = u32(first & 3) * 8u;
    return select((low >> shift) | (high << ((32u - shift) & 31u)), low, shift == 0u);
}

// Returns the distance from the shore in a tile, in samples: negative on land.
fn shore_in(slot: i32, place: LevelPlace) -> f32 {
    if textureLoad(water_maps, vec2<i32>(0, MAP_ROWS - 1), slot, 0).r == 0u {
        return FAR_LAND;
    }
    let first = (place.cell & vec2<i32>(TILE_SAMPLES - 1)) + TILE_BORDER - 1;
    let middle = vec2<u32>(codes_in(slot, first.x, first.y + 1), codes_in(slot, first.x, first.y + 2));
    // All of it is land far from any shore.
    if all(middle == vec2<u32>(0u)) {
        return FAR_LAND;
    }
    let f = clamp(place.f, vec2<f32>(0.0), vec2<f32>(1.0));
    let along = spline_weights(f.x);
    let rows = vec4<f32>(
        dot(along, distances_of(unpack4x8unorm(codes_in(slot, first.x, first.y)))),
        dot(along, distances_of(unpack4x8unorm(middle.x))), dot(along, distances_of(unpack4x8unorm(middle.y))),
        dot(along, distances_of(unpack4x8unorm(codes_in(slot, first.x, first.y + 3)))));
    return dot(spline_weights(f.y), rows);
}

// Returns the distance to the shore in metres, at a place where a pixel is `pixel_m` wide: negative on land near the
// shore, 0 on land farther away, and `max_m` where the shore is out of every map's reach. `narrow` is the smallest
// extent of a sample, relative to the nominal sample size of its level.
fn shore_m(g: vec2<f32>, pixel_m: f32, narrow: f32, max_m: f32) -> f32 {
    let coarsest = terrain.level_count - 1;
    let wanted = clamp(log2(pixel_m / terrain.spacing_m), 0.0, f32(coarsest));
    let reach = min(f32(SHORE_REACH) * narrow, FAR_WATER);
    // Each level takes its part, as in `horizon_maps`.
    var level = min(i32(wanted + 0.25), coarsest);
    var found_m = 0.0;
    var sample_m = 0.0;
    var min_m = 0.0;
    var rest = 1.0;
    loop {
        let place = place_on_level(level, g);
        let record = max(place.tile, 0);
        let is_made = place.tile >= 0 && tiles[record].shoreless != NO_MAP;
        let is_last = level >= coarsest;
        let blocked = between_corners(unpack4x8unorm(tiles[record].shoreless), place);
        let above = clamp(max(wanted - f32(level), blocked) * 2.0 - 0.5, 0.0, 1.0);
        var away = FAR_LAND;
        if is_made {
            away = shore_in(i32(tiles[record].slot), place);
        }
        let size_m = terrain.spacing_m * exp2(f32(level));
        let far = smoothstep(FAR_FROM, FAR_TO, away / reach);
        var left = select(select(1.0, max(above, far), is_made), 0.0, is_last);
        // A coarser level finds the middle of a lake farther from the shore, if anything.
        min_m = max(min_m, min(away, FAR_FROM * reach) * size_m * rest * (1.0 - above) * far);
        let here_m = select(away * size_m, max(max_m, away * size_m), is_last && far == 1.0);
        found_m += here_m * rest * (1.0 - left);
        sample_m += size_m * rest * (1.0 - left);
        rest *= left;
        level += 1;
        continuing {
            break if rest == 0.0;
        }
    }
    let shore_m = min(select(found_m, max(found_m, min_m), min_m > 0.0), max_m);
    return select(select(shore_m, -1e-6, shore_m == 0.0), 0.0, found_m <= SEEN_LAND * sample_m && min_m == 0.0);
}
