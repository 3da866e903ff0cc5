// Horizon maps: the sky and the sun as seen from each place, one tile of texels for each tile of heights.
//
// Horizon mapping (Max 1988): each texel stores the elevation of the horizon toward the sun and not whether it is in
// shadow, so the sun may rise and set over the same tiles, and borders of shadows may be as soft as the sun is wide.
// The visible sky is the mean over eight azimuths of 1 - sin(horizon), the sky-view factor (Zaksek et al. 2011), which
// is horizon-based ambient occlusion (Bavoil and Sainz 2008) of a height field.
//
// The addition here: steps double with the level of the pyramid. At level L, whose samples are s apart, the horizon is
// sampled at n s, (n + 1) s, ... (2 n - 1) s, and then the next level takes over at n times twice s. So a step is as
// long as the samples that it reads, which are already averaged, and a horizon at 50 km takes some 70 steps. The
// sequence of distances is the same for all tiles: a tile of a finer level has more steps nearby, and no others. The
// horizons of two levels of detail, and of two neighbouring tiles, are therefore those of one function of position.
#import hachure::terrain::{terrain, levels, tiles, place_on_level, world_from_grid, grid_from_world, LevelPlace}
#import hachure::terrain::{TILE_SAMPLES, TILE_BORDER, NO_SLOT, is_in_grid}
#import hachure::surface::{heights, camera_relative_m}
#import hachure::map_job::MapJob
#import hachure::horizon_maps::{MAP_BORDER, MAP_SPACING, MAP_SIDE}

// Steps per octave of distance: toward the sun, and for the sky.
const SUN_STEPS: i32 = 8;
const SKY_STEPS: i32 = 2;
const SKY_AZIMUTHS: i32 = 8;
// Possible rise of the horizon, as a tangent, at which the march for the sky stops.
const SKY_GAIN: f32 = 0.02;
const FARTHEST_M: f32 = 2e5;
// Workgroups of 8 x 8 texels along a side of a tile.
const GROUPS: u32 = 17u;

struct Horizons {
    // Unit vector, east and north.
    to_sun: vec2<f32>,
    pad_a: f32,
    pad_b: f32,
}

@group(0) @binding(0) var<uniform> horizons: Horizons;
@group(0) @binding(1) var<storage, read> jobs: array<MapJob>;
// In 16 bits each: the sine of the horizon's elevation toward the sun, -1 to 1, and the visible part of the sky.
@group(0) @binding(2) var horizon_maps: texture_storage_2d_array<r32uint, write>;

// Returns a bilinear height: neighbouring texels read the same samples, and averages of coarse levels need no better
// filter.
fn height_m(wanted: i32, g: vec2<f32>) -> f32 {
    var level = wanted;
    var place: LevelPlace;
    var slot = NO_SLOT;
    // Where a tile is missing a coarser one replaces it. The loop is tested at its end: most run it once.
    loop {
        place = place_on_level(level, g);
        slot = select(NO_SLOT, tiles[max(place.tile, 0)].slot, place.tile >= 0);
        level += 1;
        continuing {
            break if slot != NO_SLOT || level >= terrain.level_count;
        }
    }
    let texel = (place.cell & vec2<i32>(TILE_SAMPLES - 1)) + TILE_BORDER;
    let layer = select(i32(slot), 0, slot == NO_SLOT);
    let nw = textureLoad(heights, texel, layer, 0).r;
    let ne = textureLoad(heights, texel + vec2<i32>(1, 0), layer, 0).r - nw;
    let sw = textureLoad(heights, texel + vec2<i32>(0, 1), layer, 0).r - nw;
    let se = textureLoad(heights, texel + vec2<i32>(1, 1), layer, 0).r - nw;
    return camera_relative_m(nw) + mix(ne * place.f.x, mix(sw, se, place.f.x), place.f.y);
}

// A point from which horizons are computed.
struct Eye {
    g: vec2<f32>,
    z_m: f32,
    level: i32,
}

// Returns the tangent of the horizon's elevation, at least `least`. `way` is grid coordinates per metre; over the
// length of a sample at that distance the map is straight.
fn horizon(eye: Eye, way: vec2<f32>, steps: i32, least: f32, gain: f32) -> f32 {
    let coarsest = terrain.level_count - 1;
    let room_m = terrain.max_z_m - eye.z_m;
    var tangent = least;
    var level = eye.level;
    var size_m = terrain.spacing_m * exp2(f32(level));
    var i = 1;
    loop {
        let d_m = size_m * f32(i);
        let g = eye.g + way * d_m;
        // Drop of the earth's surface below the horizontal, divided by the distance.
        let drop = 0.5 * d_m * terrain.earth_inverse_radius;
        // Beyond the land's border there is nothing.
        let is_land = is_in_grid(g);
        let rise = (height_m(min(level, coarsest), g) - eye.z_m) / d_m - drop;
        tangent = select(tangent, max(tangent, rise), is_land);
        let is_last = !is_land || d_m > FARTHEST_M || room_m / d_m - drop <= tangent + gain;
        i += 1;
        if i == 2 * steps {
            i = steps;
            level += 1;
            size_m *= 2.0;
        }
        continuing {
            break if is_last;
        }
    }
    return tangent;
}

fn sine(tangent: f32) -> f32 {
    return tangent * inverseSqrt(1.0 + tangent * tangent);
}

// The sky is computed from every second texel along each side, and interpolated between these nodes: it is a mean over
// all azimuths, smoother than the horizon toward the sun, which makes borders of shadows. A workgroup shares its nodes.
const NODE_SPACING: i32 = 2;
const NODES_PER_SIDE: i32 = 5;
const NODES: i32 = 25;
const MARCHES: i32 = 200;
const INVOCATIONS: i32 = 64;

// The sine of the horizon from each node of the workgroup in each azimuth, and the hidden part of the sky at each node.
var<workgroup> sky_horizons: array<f32, MARCHES>;
var<workgroup> hidden: array<f32, NODES>;

// A texel of the map, and the derivatives of grid coordinates there.
struct Post {
    eye: Eye,
    dg_dx: vec2<f32>,
    dg_dy: vec2<f32>,
}

fn post(job: MapJob, texel: vec2<i32>) -> Post {
    let info = levels[job.level];
    let sample = clamp(job.tile * TILE_SAMPLES + (texel - MAP_BORDER) * MAP_SPACING, vec2<i32>(0), info.size - 1);
    let g = (vec2<f32>(sample - info.cell) - info.fraction) / info.scale;
    let point = grid_from_world(world_from_grid(g));
    return Post(Eye(g, height_m(job.level, g), job.level), point.dg_dx, point.dg_dy);
}

fn march_for_sky(job: MapJob, first_texel: vec2<i32>, i: i32) {
    let node = vec2<i32>(i % NODES_PER_SIDE, i / NODES_PER_SIDE % NODES_PER_SIDE);
    let azimuth = (f32(i / NODES) + 0.5) * radians(360.0) / f32(SKY_AZIMUTHS);
    let at = post(job, first_texel + NODE_SPACING * node);
    let way = at.dg_dx * sin(azimuth) + at.dg_dy * cos(azimuth);
    sky_horizons[i] = sine(horizon(at.eye, way, SKY_STEPS, 0.0, SKY_GAIN));
}

@compute @workgroup_size(8, 8)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) index: u32,
) {
    let job = jobs[group.y / GROUPS];
    let first_texel = 8 * vec2<i32>(vec2<u32>(group.x, group.y % GROUPS));
    for (var i = i32(index); i < MARCHES; i += INVOCATIONS) {
        march_for_sky(job, first_texel, i);
    }
    workgroupBarrier();
    let own = i32(index);
    if own < NODES {
        var sum = 0.0;
        for (var azimuth = 0; azimuth < SKY_AZIMUTHS; azimuth++) {
            sum += sky_horizons[azimuth * NODES + own];
        }
        hidden[own] = sum / f32(SKY_AZIMUTHS);
    }
    workgroupBarrier();

    let in_group = vec2<i32>(local.xy);
    let texel = first_texel + in_group;
    if any(texel >= vec2<i32>(MAP_SIDE)) {
        return;
    }
    let at = post(job, texel);
    let way = at.dg_dx * horizons.to_sun.x + at.dg_dy * horizons.to_sun.y;
    let toward_sun = sine(horizon(at.eye, way, SUN_STEPS, -1.0, 0.0));
    let nw = in_group.y / NODE_SPACING * NODES_PER_SIDE + in_group.x / NODE_SPACING;
    let f = vec2<f32>(in_group % NODE_SPACING) / f32(NODE_SPACING);
    let north = mix(hidden[nw], hidden[nw + 1], f.x);
    let south = mix(hidden[nw + NODES_PER_SIDE], hidden[nw + NODES_PER_SIDE + 1], f.x);
    let seen = vec2<f32>(0.5 + 0.5 * toward_sun, 1.0 - mix(north, south, f.y));
    textureStore(horizon_maps, texel, job.slot, vec4<u32>(pack2x16unorm(seen), 0u, 0u, 0u));
}
