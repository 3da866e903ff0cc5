// What a tile's samples know of shores while its water map is made: 32 bits each.
#define_import_path hachure::shores
#import hachure::terrain::{terrain, levels, grid_from_world, world_from_grid, TILE_SAMPLES}
#import hachure::map_job::MapJob
#import hachure::water_maps::{AROUND, SIDE}

// Tiles that are made at once. What was found of them: whether there is water in each, how many squares of samples may
// have a lake, how many tiles have water, which, and how many are made.
const SQUARES: u32 = 4u;
const WET_TILES: u32 = 5u;
const FIRST_WET: u32 = 6u;
const JOBS: u32 = 10u;
const FOUND: u32 = 11u;
// Squares of four samples along a side of a tile and what is around it.
const BLOCKS: i32 = 162;
// A square in the list of those that may have a lake: its number, and above that the tile's.
const JOB_SHIFT: u32 = 16u;

const IS_SHORE: u32 = 1u;
const IS_WATER: u32 = 2u;
// Steps of a sample, and the farthest that a shore is from its sample.
const OFFSET_STEPS: f32 = 42.0;
const FARTHEST_OFFSET: f32 = 3.0;
// Where the sample of a shore that is nearest in a column is: so many rows farther, plus this; 0 is nowhere.
const ROW_SHIFT: u32 = 26u;
const ROW_ZERO: i32 = 32;

// A piece of shore near a sample: its place from there in samples, and its normal toward water, of length 1 in the world.
struct Shore {
    offset: vec2<f32>,
    normal: vec2<f32>,
}

fn packed_shore(shore: Shore) -> u32 {
    let steps = vec2<u32>(clamp(round(shore.offset * OFFSET_STEPS) + 128.0, vec2<f32>(0.0), vec2<f32>(255.0)));
    let turn = u32(round(atan2(shore.normal.y, shore.normal.x) / radians(360.0) * 256.0 + 256.0)) & 255u;
    return IS_SHORE | (steps.x << 2u) | (steps.y << 10u) | (turn << 18u);
}

fn unpacked_shore(word: u32) -> Shore {
    let steps = vec2<f32>(vec2<u32>(word >> 2u, word >> 10u) & vec2<u32>(255u));
    let angle = f32((word >> 18u) & 255u) * (radians(360.0) / 256.0);
    return Shore((steps - 128.0) / OFFSET_STEPS, vec2<f32>(cos(angle), sin(angle)));
}

// What a step along x, and one along y, is in the world at a sample, by the size of samples of the level.
fn extents(job: MapJob, place: vec2<i32>) -> mat2x2<f32> {
    let info = levels[job.level];
    let sample = clamp(job.tile * TILE_SAMPLES - AROUND + place, vec2<i32>(0), info.size - 1);
    let g = (vec2<f32>(sample - info.cell) - info.fraction) / info.scale;
    let point = grid_from_world(world_from_grid(g));
    let determinant = point.dg_dx.x * point.dg_dy.y - point.dg_dx.y * point.dg_dy.x;
    let metres = mat2x2<f32>(point.dg_dy.y, -point.dg_dx.y, -point.dg_dy.x, point.dg_dx.x) * (1.0 / determinant);
    let size_m = terrain.spacing_m * exp2(f32(job.level));
    return mat2x2<f32>(metres[0] / (info.scale.x * size_m), metres[1] / (info.scale.y * size_m));
}
