// The density control of lines: ink is counted in cells of the picture, separately for each step of rank, and lines
// below a cell's bar are left out. See src/lines/crowd/.
#define_import_path hachure::crowd
#import hachure::view::View

struct Crowd {
    // Largest part of the paper that lines may cover, 0 to 1.
    most: f32,
    // Side of a cell in which ink is counted, in pixels: a quarter of the window of the sum.
    cell_px: u32,
    // Number of cells across and down the target.
    cells: vec2<u32>,
    // Distance to the other eye of a stereo pair, in metres; 0 if there is none.
    apart_m: f32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

// Number of steps of rank in which ink is counted, the lowest first.
const BINS: u32 = 8u;
// Words stored per cell: the ink of each step, then the width of the broadest stroke in the same units.
const CELL_WORDS: u32 = 9u;
// Units of ink in a fully inked pixel. Ink is counted in integers, so that its sum does not depend on the order.
const UNITS: f32 = 64.0;
// The cap holds fully where the two eyes of a stereo pair see a place from directions that differ by less than the
// first angle, and not at all beyond the second. In radians, for small angles.
const APART_RAD: vec2<f32> = vec2<f32>(0.05, 0.1);
// Lines are gone where their rank is this far below the bar, and whole where it is this far above.
const SOFT: f32 = 0.2;

// Returns the first cell of the target. Cells are counted in the whole picture, so that parts of a large one agree.
fn first_cell(view: View, crowd: Crowd) -> vec2<i32> {
    return view.origin_px / i32(crowd.cell_px);
}

// Returns the cell of a position on the target, counted from the target's first cell.
fn cell_at(view: View, crowd: Crowd, px: vec2<f32>) -> vec2<i32> {
    let cell = vec2<i32>(floor((px + vec2<f32>(view.origin_px)) / f32(crowd.cell_px))) - first_cell(view, crowd);
    return clamp(cell, vec2<i32>(0), vec2<i32>(crowd.cells) - 1);
}

// Returns the step of rank in which a rank is counted.
fn bin_of(rank: f32) -> u32 {
    return u32(clamp(rank * f32(BINS), 0.0, f32(BINS) - 1.0));
}

// Returns how far the cap holds for lines at a distance along the view axis: 0 to 1, and 1 for the sky, whose distance
// is 0.
//
// Contours of near objects are at different positions for each eye, among different lines, so each eye would thin out
// different ones. The cap is for far ranges, which both eyes see alike; near lines are neither counted nor thinned out.
fn capped(crowd: Crowd, depth_m: f32) -> f32 {
    let apart_rad = select(0.0, crowd.apart_m / max(depth_m, 1e-6), depth_m > 0.0);
    return 1.0 - smoothstep(APART_RAD.x, APART_RAD.y, apart_rad);
}

// Returns the fraction of a line's ink that remains. `bar` holds the rank of the bar, and the fraction that remains of
// lines above it.
fn remaining_part(bar: vec2<f32>, rank: f32) -> f32 {
    return bar.y * smoothstep(bar.x - SOFT, bar.x + SOFT, rank);
}

// Returns the bar at a position on the target, interpolated between the centres of cells.
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
