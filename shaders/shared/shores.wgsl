// Data of a tile's samples while its water map is made, 32 bits each.
#define_import_path hachure::shores
#import hachure::terrain::{terrain, levels, grid_from_world, world_from_grid, TILE_SAMPLES}
#import hachure::map_job::MapJob
#import hachure::water_maps::{AROUND, SIDE}

// Tiles that are made at once, and offsets in the list of what was found: whether each tile has water, then the number
// of blocks that may have a lake, the number of tiles with water, their numbers, and the number of tiles being made.
const SQUARES: u32 = 4u;
const WET_TILES: u32 = 5u;
const FIRST_WET: u32 = 6u;
const JOBS: u32 = 10u;
const FOUND: u32 = 11u;
// Blocks of 2 × 2 samples along a side of a tile and its surroundings.
const BLOCKS: i32 = 162;
// An entry in the list of blocks that may have a lake: the block's number in the lower bits, the tile's above.
const JOB_SHIFT: u32 = 16u;

const IS_SHORE: u32 = 1u;
const IS_WATER: u32 = 2u;
// Steps per sample in which the offset of a shore is stored, and the largest offset in samples.
const OFFSET_STEPS: f32 = 42.0;
const FARTHEST_OFFSET: f32 = 3.0;
// Row of the nearest shore sample in a column, relative to the sample's own, plus ROW_ZERO; 0 is none.
const ROW_SHIFT: u32 = 26u;
const ROW_ZERO: i32 = 32;

// A piece of shore near a sample: its offset from there in samples, and its unit normal in the world, toward water.
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

// Returns the steps along x and along y in the world at a sample, relative to the nominal sample size of the level.
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
