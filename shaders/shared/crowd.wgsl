// How much ink lines leave about a place, by how much they matter: see src/lines/crowd/.
#define_import_path hachure::crowd
#import hachure::view::View

struct Crowd {
    // The part of the paper that lines may cover.
    most: f32,
    // Side of a cell in which ink is counted: a quarter of the window's.
    cell_px: u32,
    // Of the targets.
    cells: vec2<u32>,
    // From this eye to the other one of a pair; 0 is none.
    apart_m: f32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

// Ranks are counted in so many steps, the lowest first.
const BINS: u32 = 8u;
// What is kept of a cell: the ink of each step, then the width of its broadest stroke, in the same units.
const CELL_WORDS: u32 = 9u;
// Ink is counted in whole numbers, so that its sum is the same in whatever order: of a pixel that is all ink.
const UNITS: f32 = 64.0;
// Where both eyes of a pair see a place from directions that differ by less than this angle, the cap holds; where they
// differ by more than the second one, it does not. In radians, for small angles.
const APART_RAD: vec2<f32> = vec2<f32>(0.05, 0.1);
// Lines go as their rank falls below the bar by this, and are whole above it by as much.
const SOFT: f32 = 0.2;

// Cells are counted in the whole picture, so that parts of a large one agree.
fn first_cell(view: View, crowd: Crowd) -> vec2<i32> {
    return view.origin_px / i32(crowd.cell_px);
}

// The cell of a place on the targets, in the list of their cells.
fn cell_at(view: View, crowd: Crowd, px: vec2<f32>) -> vec2<i32> {
    let cell = vec2<i32>(floor((px + vec2<f32>(view.origin_px)) / f32(crowd.cell_px))) - first_cell(view, crowd);
    return clamp(cell, vec2<i32>(0), vec2<i32>(crowd.cells) - 1);
}

fn bin_of(rank: f32) -> u32 {
    return u32(clamp(rank * f32(BINS), 0.0, f32(BINS) - 1.0));
}

// How far the cap holds for lines at a distance along the view axis: 0 to 1, and 1 for the sky, whose distance is 0.
//
// Contours of near things lie elsewhere for each eye, among other lines: each eye would thin out others. The cap is for
// far ranges, which both eyes see alike; what is near is neither counted nor thinned out.
fn capped(crowd: Crowd, depth_m: f32) -> f32 {
    let apart_rad = select(0.0, crowd.apart_m / max(depth_m, 1e-6), depth_m > 0.0);
    return 1.0 - smoothstep(APART_RAD.x, APART_RAD.y, apart_rad);
}

// What the bar at a place leaves of a line of some rank: the bar itself, and what is left of lines above it.
fn left_of(bar: vec2<f32>, rank: f32) -> f32 {
    return bar.y * smoothstep(bar.x - SOFT, bar.x + SOFT, rank);
}

// The bar at a place on the targets of a view, between the middles of cells.
fn bar_at(view: View, crowd: Crowd, bars: texture_2d<f32>, px: vec2<f32>) -> vec2<f32> {
    let place = (px + vec2<f32>(view.origin_px)) / f32(crowd.cell_px) - 0.5;
    let whole = floor(place);
    let f = place - whole;
    let first = vec2<i32>(whole) - first_cell(view, crowd);
    var bar = vec2<f32>(0.0);
    for (var i = 0; i < 4; i++) {
        let offset = vec2<i32>(i & 1, i >> 1u);
        let weight = mix(1.0 - f, f, vec2<f32>(offset));
        let cell = clamp(first + offset, vec2<i32>(0), vec2<i32>(crowd.cells) - 1);
        bar += weight.x * weight.y * textureLoad(bars, cell, 0).xy;
    }
    return bar;
}
