// The parts of the sun and of the sky that are visible from a point, read from the tiles that `surface/land/horizons`
// computes.
//
// Horizons, not shadows, are interpolated between texels and between the tiles of two levels, so that the border of a
// shadow is independent of texels and as smooth as the horizon. The level is that of the pixel's footprint: a function
// of position and distance alone, like the surface's level, so nothing pops.
#define_import_path hachure::horizon_maps
#import hachure::terrain::{terrain, tiles, place_on_level, between_corners, grid_from_world, LevelPlace, TILE_SAMPLES, NO_MAP}
#import hachure::earth::unbend

// Texels of a tile along a side, border texels at either end, and samples between texels.
const MAP_SIDE: i32 = 130;
const MAP_BORDER: i32 = 1;
const MAP_SPACING: i32 = 2;
// Half of the sun's angular width, plus the resolution of the horizon's texels, in radians.
const PENUMBRA_RAD: f32 = 0.008;

@group(0) @binding(15) var horizon_maps: texture_2d_array<u32>;
@group(0) @binding(16) var horizon_sampler: sampler;

// Returns the sine of the horizon toward the sun, and the visible part of the sky, at a position of a tile.
fn horizon_in(slot: u32, place: LevelPlace) -> vec2<f32> {
    let in_tile = vec2<f32>(place.cell & vec2<i32>(TILE_SAMPLES - 1)) + place.f;
    let u = max(in_tile / f32(MAP_SPACING) + f32(MAP_BORDER), vec2<f32>(0.0));
    let texel = min(vec2<i32>(u), vec2<i32>(MAP_SIDE - 2));
    let f = u - vec2<f32>(texel);
    // The four texels around the corner that they share: south-west, south-east, north-east, north-west.
    let corner = vec2<f32>(texel + 1) / f32(MAP_SIDE);
    let four = textureGather(0, horizon_maps, horizon_sampler, corner, slot);
    let north = mix(unpack2x16unorm(four.w), unpack2x16unorm(four.z), f.x);
    let south = mix(unpack2x16unorm(four.x), unpack2x16unorm(four.y), f.x);
    return mix(north, south, f.y) * vec2<f32>(2.0, 1.0) - vec2<f32>(1.0, 0.0);
}

// Returns the visible parts of the sun and of the sky, 0 to 1, at a camera-relative point of the bent world.
fn visibility_at(at_m: vec3<f32>, to_sun: vec3<f32>) -> vec2<f32> {
    let unbent = unbend(at_m);
    let g = grid_from_world(unbent.flat_m.xy).g;
    let pixel_m = length(at_m) / terrain.focal_px;
    let coarsest = terrain.level_count - 1;
    let wanted = clamp(log2(pixel_m / terrain.spacing_m), 0.0, f32(coarsest));
    // Each level takes its part, as in `surface_near`, and leaves the rest to the next coarser one; a level whose map
    // is missing or not ready leaves all. There is one loop, tested at its end: most places need one level, few need
    // more than two.
    var level = min(i32(wanted + 0.25), coarsest);
    var found = vec2<f32>(0.0);
    var rest = 1.0;
    loop {
        let place = place_on_level(level, g);
        let record = max(place.tile, 0);
        let is_lit = place.tile >= 0 && tiles[record].unlit != NO_MAP;
        let is_last = level >= coarsest;
        let unlit = between_corners(unpack4x8unorm(tiles[record].unlit), place);
        let above = max(wanted - f32(level), unlit) * 2.0 - 0.5;
        let left = select(select(1.0, clamp(above, 0.0, 1.0), is_lit), 0.0, is_last);
        // Before the first tile is made, everything is visible.
        let here = select(vec2<f32>(-1.0, 1.0), horizon_in(tiles[record].slot, place), is_lit);
        found += here * (rest * (1.0 - left));
        rest *= left;
        level += 1;
        continuing {
            break if rest == 0.0;
        }
    }
    let sun = dot(to_sun, unbent.up);
    return vec2<f32>(smoothstep(found.x - PENUMBRA_RAD, found.x + PENUMBRA_RAD, sun), found.y);
}
