// Rows of hachures: the blocks of land in which they are placed, and the data of each block.
//
// The land is cut into square blocks of a quadtree in grid coordinates. A block of level L has CELLS x CELLS cells,
// each 2^L samples of the finest level wide: a cell is the spacing of marks there, before the picture thins them.
// Positions in a block are in cells from its corner; marks begin in the block and may end outside of it.
//
// Heights are in units of 1 / STEPS of a cell. Rows are between heights that are multiples of 2^octave units, and a
// mark is seeded in the middle of its row, at an odd multiple of half of that. Each cell has the octave of its rows, or
// 0 for none.
#define_import_path hachure::rows
#import hachure::terrain::{terrain, GridPoint, world_from_grid, grid_from_world}

const CELLS: i32 = 64;
// Cells around the block that have heights too, and nodes (corners of cells) along a side.
const MARGIN_CELLS: i32 = 17;
const NODES: i32 = 99;
// Distance between the nodes of the slope that octaves follow, in cells, and the number of them along a side, with one
// outside of the block at either end.
const SLOPE_CELLS: i32 = 8;
const SLOPE_NODES: i32 = 11;
// Cells around the block that have octaves too, and cells with octaves along a side.
const MARGIN: i32 = 8;
const OCTAVES: i32 = 80;
// Offsets in a block's relief, in words: heights come first, then slopes, then octaves; and its size.
const FIRST_OCTAVE: i32 = 9922;
const RELIEF: i32 = 16322;
const STEPS: f32 = 64.0;
// Range of the octaves of rows; the steepness of the land determines the octave.
const MIN_OCTAVE: i32 = 3;
const MAX_OCTAVE: i32 = 12;
// Candidates per width of a cell along the middle of a row; the picture chooses among them.
const DENSITY: u32 = 4u;
// Largest number of candidates of a block.
const MAX_CANDIDATES: u32 = 16384u;
// Samples of a mark on each side of the middle one.
const HALF: i32 = 8;
// Distance beyond the border of the picture at which the middle of a mark may be for the mark to be proposed, in cells
// and, in addition, in pixels: the longest possible row, and the marks that are next to it.
const REACH_CELLS: f32 = 24.0;
const REACH_PX: f32 = 16.0;
// Samples from the middle to the border of the row; those beyond serve marks that no other row continues.
const CORE: i32 = 5;
const SAMPLES: i32 = 17;
// Words of a candidate: its index in its piece of a row's middle line; the number of intervals between the candidates
// of that piece; the number of samples below its seed, plus 256 times the number above it; the seed's height; and its
// samples (sample_word), in whose place the seed is stored as two floats until `trace` writes them.
const INDEX: u32 = 0u;
const INTERVALS: u32 = 1u;
const REACH: u32 = 2u;
const HEIGHT: u32 = 3u;
const SEED: u32 = 4u;
const WORDS: u32 = 21u;
// Bit of the number of intervals: the piece is a closed line.
const CLOSED: u32 = 0x80000000u;
// Bit of an index: the same mark begins a piece of the next block, which draws it.
const ELSEWHERE: u32 = 0x80000000u;

// The number of intervals of a mark outside of any row. After `trace` its index holds its rise from sample to sample,
// and its height is in metres.
const ALONE: u32 = 0x40000000u;
// Size of a proposal, in vectors of four. The first vector holds the samples at which the mark begins and ends (the end
// times 32), a bit for each visible sample, its priority (the greatest comes first), and its state: UNDECIDED to
// DROPPED. The others are samples: position in pixels, free room on either side in pixels, and distance along the view
// axis. A mark outside of any row has no known room: there a negative number is the part of it that is drawn.
const PROPOSAL: i32 = 18;
const UNDECIDED: f32 = 0.0;
const CHOSEN: f32 = 1.0;
const DRAWN: f32 = 2.0;
const DROPPED: f32 = 3.0;

struct RowRules {
    // Distance between marks on the picture, in pixels.
    spacing_px: f32,
    // Length of a row where the land is as steep as its surroundings, in cells.
    row_cells: f32,
    // Tangent of the slope below which land counts as level.
    level: f32,
    // Number of samples between the ends of neighbouring marks of a row, 0 to 4.
    stagger: f32,
    // Darkest tone of marks.
    darkest: f32,
    // Part of a mark's length over which it tapers at an end.
    taper: f32,
    // Capacity for marks in this frame.
    max_marks: u32,
    // Size of a cell of level 0 on the picture at a distance of one metre, in pixels.
    cell_px_m: f32,
    // Range of the levels of blocks.
    min_level: f32,
    greatest_level: f32,
}

struct RowBlock {
    // Grid coordinates of its first corner.
    corner: vec2<f32>,
    // Samples of the finest level per cell, and the log2 of that.
    cell: f32,
    level: f32,
    // Index in the pool.
    slot: u32,
    // East and north of its centre, relative to the camera, and the sides of a cell there along x and along y, all in
    // metres.
    middle_m: vec2<f32>,
    along_x: vec2<f32>,
    along_y: vec2<f32>,
}

// Returns the side of a cell in metres.
fn cell_m(block: RowBlock) -> f32 {
    return block.cell * terrain.spacing_m;
}

// Converts a position in a block to grid coordinates.
fn grid_of(block: RowBlock, place: vec2<f32>) -> vec2<f32> {
    return block.corner + place * block.cell;
}

fn camera_height_m() -> f32 {
    return terrain.camera_z_coarse_m + terrain.camera_z_fine_m;
}

// The transform between grid and world around a position: sides of a cell along x and along y, in metres east and
// north.
struct Frame {
    point: GridPoint,
    world_m: vec2<f32>,
    along_x: vec2<f32>,
    along_y: vec2<f32>,
}

// Returns the transform around a position in a block.
fn frame_at(block: RowBlock, place: vec2<f32>) -> Frame {
    let world_m = world_from_grid(grid_of(block, place));
    let point = grid_from_world(world_m);
    let a = point.dg_dx;
    let b = point.dg_dy;
    let scale = block.cell / (a.x * b.y - b.x * a.y);
    return Frame(point, world_m, vec2<f32>(b.y, -a.y) * scale, vec2<f32>(-b.x, a.x) * scale);
}

// Converts an offset in cells to an offset in the world, in metres east and north.
fn world_offset(frame: Frame, cells: vec2<f32>) -> vec2<f32> {
    return frame.along_x * cells.x + frame.along_y * cells.y;
}

// Returns the word that holds the sample `i` of the candidate whose words begin at `at`; sample 0 is the seed.
fn sample_word(at: u32, i: i32) -> u32 {
    return at + SEED + u32(HALF + i);
}

// Positions of marks are packed in 16 bits each, up to a quarter of a block outside of the block.
fn pack_place(place: vec2<f32>) -> u32 {
    return pack2x16unorm(clamp((place + 16.0) / 96.0, vec2<f32>(0.0), vec2<f32>(1.0)));
}

fn unpack_place(word: u32) -> vec2<f32> {
    return unpack2x16unorm(word) * 96.0 - 16.0;
}
