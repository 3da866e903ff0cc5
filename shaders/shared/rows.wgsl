// Rows of hachures: the blocks of land in which they are placed, and what is known of each.
//
// The land is cut into square blocks of a quadtree in grid coordinates. A block of level L has CELLS x CELLS cells, each
// 2^L samples of the finest level wide: a cell is the spacing of marks there, before the picture thins them. Places in a
// block are counted in cells from its corner; marks may begin in it and end beside it.
//
// Heights are counted in units of 1 / STEPS of a cell. Rows lie between heights that are multiples of 2^octave units, and
// a mark is seeded in the middle of its row, at an odd multiple of half of that. Each cell has the octave of its rows, or
// none (0).
#define_import_path hachure::rows
#import hachure::terrain::{terrain, GridPoint, world_from_grid, grid_from_world}

const CELLS: i32 = 64;
// Heights stand at the corners of cells, and of so many cells beside the block: nodes along a side.
const BESIDE: i32 = 17;
const NODES: i32 = 99;
// The slope that octaves follow stands at nodes that are so many cells apart, from one beside the block to the other.
const SLOPE_CELLS: i32 = 8;
const SLOPE_NODES: i32 = 11;
// Octaves stand for cells up to so many beside the block: cells along a side.
const MARGIN: i32 = 8;
const OCTAVES: i32 = 80;
// Words of a block's relief: heights, then slopes, then octaves.
const FIRST_OCTAVE: i32 = 9922;
const RELIEF: i32 = 16322;
const STEPS: f32 = 64.0;
// Of rows, by how steep the land is.
const LEAST_OCTAVE: i32 = 3;
const GREATEST_OCTAVE: i32 = 12;
// Candidates to a cell's width along the middle of a row; the picture chooses among them.
const DENSITY: u32 = 4u;
// Candidates of a block.
const MOST_CANDIDATES: u32 = 16384u;
// Samples of a mark: in the middle, and on each side of it.
const HALF: i32 = 8;
// Of these, the samples to the border of the row: those beyond are for marks that no row goes on from.
const CORE: i32 = 5;
const SAMPLES: i32 = 17;
// Words of a candidate: its index, the number of intervals in its piece, what is below, its height, and its samples.
const WORDS: u32 = 21u;
const CLOSED: u32 = 0x80000000u;
// Of an index: the same mark begins a piece of the next block, which draws it.
const ELSEWHERE: u32 = 0x80000000u;

// Of intervals: a mark that stands in no row. Its index is what it rises from sample to sample, and its height is one, in
// metres.
const ALONE: u32 = 0x40000000u;
// What is proposed for the picture, in words of four numbers. First the samples at which it begins and ends (the last times
// 32), a bit for each sample that is seen, its turn (the greatest comes first), and what is decided: UNDECIDED and so on.
// Then the samples: place in pixels, room beside it in pixels, distance along the view axis. A mark that stands in no row
// does not know its room: below 0 is how much of it is drawn.
const PROPOSAL: i32 = 18;
const UNDECIDED: f32 = 0.0;
const CHOSEN: f32 = 1.0;
const DRAWN: f32 = 2.0;
const DROPPED: f32 = 3.0;

struct RowRules {
    // Distance of marks on the picture.
    spacing_px: f32,
    // Length of a row where the land is as steep as it is around, in cells.
    row_cells: f32,
    // Tangent of the slope that is level.
    level: f32,
    // Darkest tone of marks.
    darkest: f32,
    // Part of a mark's length over which it thins out at an end.
    taper: f32,
    // Marks that this frame has room for.
    most_marks: u32,
    // Cells of level 0 on the picture at a distance of a metre: pixels.
    cell_px_m: f32,
    // Of blocks that there may be.
    least_level: f32,
    greatest_level: f32,
}

struct RowBlock {
    // Grid coordinate of its first corner.
    corner: vec2<f32>,
    // Samples of the finest level to a cell, and its log2.
    cell: f32,
    level: f32,
    // In the pool.
    slot: u32,
    // East and north of its middle, relative to the camera, and of a cell there along x and along y.
    middle_m: vec2<f32>,
    along_x: vec2<f32>,
    along_y: vec2<f32>,
}

fn cell_m(block: RowBlock) -> f32 {
    return block.cell * terrain.spacing_m;
}

fn grid_of(block: RowBlock, place: vec2<f32>) -> vec2<f32> {
    return block.corner + place * block.cell;
}

fn camera_height_m() -> f32 {
    return terrain.camera_z_coarse_m + terrain.camera_z_fine_m;
}

// Grid and world around a place: metres east and north of a cell along x and along y.
struct Frame {
    point: GridPoint,
    world_m: vec2<f32>,
    along_x: vec2<f32>,
    along_y: vec2<f32>,
}

fn frame_at(block: RowBlock, place: vec2<f32>) -> Frame {
    let world_m = world_from_grid(grid_of(block, place));
    let point = grid_from_world(world_m);
    let a = point.dg_dx;
    let b = point.dg_dy;
    let scale = block.cell / (a.x * b.y - b.x * a.y);
    return Frame(point, world_m, vec2<f32>(b.y, -a.y) * scale, vec2<f32>(-b.x, a.x) * scale);
}

fn world_way(frame: Frame, way: vec2<f32>) -> vec2<f32> {
    return frame.along_x * way.x + frame.along_y * way.y;
}

// Places of marks, in half words: a quarter of a block beside it at most.
fn pack_place(place: vec2<f32>) -> u32 {
    return pack2x16unorm(clamp((place + 16.0) / 96.0, vec2<f32>(0.0), vec2<f32>(1.0)));
}

fn unpack_place(word: u32) -> vec2<f32> {
    return unpack2x16unorm(word) * 96.0 - 16.0;
}
