// What a place sees of the sun and of the sky, from the tiles that `surface/horizons` makes.
//
// Between texels, and between the tiles of two levels, horizons are interpolated and not shadows: the border of a
// shadow then lies between texels, and is as smooth as the horizon is. The level is that of the pixel's footprint: it
// is a function of place and distance alone, as the surface's is, so nothing pops.
#define_import_path hachure::seen
#import hachure::terrain::{terrain, tiles, place_on_level, as_far_as_there, grid_from_world, LevelPlace, TILE_SAMPLES}
#import hachure::earth::unbend

// Texels of a tile along a side, those outside of it at either end, and samples between texels.
const SEEN_SIDE: i32 = 130;
const SEEN_BORDER: i32 = 1;
const SEEN_SPACING: i32 = 2;
// Half of the sun's width, and what the horizon's own texels add, in radians.
const PENUMBRA_RAD: f32 = 0.008;

@group(0) @binding(15) var seen_tiles: texture_2d_array<u32>;
@group(0) @binding(16) var seen_sampler: sampler;

// The sine of the horizon toward the sun, and the visible sky, on a level or on the coarser one that stands in.
fn horizon_on(first: LevelPlace, g: vec2<f32>) -> vec2<f32> {
    var place = first;
    var slot = -1;
    loop {
        if place.tile >= 0 && tiles[place.tile].lit == 1u {
            slot = i32(tiles[place.tile].slot);
        }
        let is_found = slot >= 0 || place.level >= terrain.level_count - 1;
        if !is_found {
            place = place_on_level(place.level + 1, g);
        }
        continuing {
            break if is_found;
        }
    }
    let in_tile = vec2<f32>(place.cell & vec2<i32>(TILE_SAMPLES - 1)) + place.f;
    let u = max(in_tile / f32(SEEN_SPACING) + f32(SEEN_BORDER), vec2<f32>(0.0));
    let texel = min(vec2<i32>(u), vec2<i32>(SEEN_SIDE - 2));
    let f = u - vec2<f32>(texel);
    let layer = max(slot, 0);
    // The four texels around the corner that they share: south-west, south-east, north-east, north-west.
    let corner = vec2<f32>(texel + 1) / f32(SEEN_SIDE);
    let four = textureGather(0, seen_tiles, seen_sampler, corner, layer);
    let north = mix(unpack2x16unorm(four.w), unpack2x16unorm(four.z), f.x);
    let south = mix(unpack2x16unorm(four.x), unpack2x16unorm(four.y), f.x);
    let found = mix(north, south, f.y) * vec2<f32>(2.0, 1.0) - vec2<f32>(1.0, 0.0);
    // Before the first tile is made, everything is seen.
    return select(vec2<f32>(-1.0, 1.0), found, slot >= 0);
}

// The parts of the sun and of the sky that a place sees; camera-relative in the bent world.
fn seen_at(at_m: vec3<f32>, to_sun: vec3<f32>) -> vec2<f32> {
    let unbent = unbend(at_m);
    let g = grid_from_world(unbent.flat_m.xy).g;
    let pixel_m = length(at_m) / terrain.focal_px;
    let coarsest = terrain.level_count - 1;
    let wanted = clamp(log2(pixel_m / terrain.spacing_m), 0.0, f32(coarsest));
    let at = as_far_as_there(wanted, place_on_level(i32(wanted), g), g);
    // As `surface_near` does: most places need one level only.
    let blend = clamp((at.level - f32(at.place.level)) * 2.0 - 0.5, 0.0, 1.0);
    var place = at.place;
    if blend > 0.0 {
        place = place_on_level(min(place.level + 1, coarsest), g);
    }
    var coarse = vec2<f32>(0.0);
    var fine = vec2<f32>(0.0);
    var is_second = false;
    loop {
        fine = horizon_on(place, g);
        if !is_second {
            coarse = fine;
        }
        let is_done = is_second || blend == 0.0 || blend >= 1.0;
        place = at.place;
        is_second = true;
        continuing {
            break if is_done;
        }
    }
    let found = mix(fine, coarse, blend);
    let sun = dot(to_sun, unbent.up);
    return vec2<f32>(smoothstep(found.x - PENUMBRA_RAD, found.x + PENUMBRA_RAD, sun), found.y);
}
