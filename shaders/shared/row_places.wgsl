// Proposed marks on the picture, and a raster of which mark claims each cell, and with what priority.
//
// A cell of a raster holds the greatest word that was written to it: the priority of a mark that is drawn, which
// exceeds all others, or of one that is undecided. There are two of them: one has all claims, the other only marks that
// are drawn. A priority depends on the mark's position on the land, not on its number, so which mark claims a cell does
// not depend on timing. Walks across a mark, from cell to cell, find the distance to the next one.
#define_import_path hachure::row_places
#import hachure::view::View
#import hachure::rows::{RowRules, HALF, PROPOSAL}

// Cells of the raster per spacing, and the margin of the raster around the picture, in spacings.
const CELLS_PER_SPACING: f32 = 6.0;
const RASTER_MARGIN: f32 = 16.0;
// Bit of a word: the cell belongs to a mark that is drawn, whose priority follows.
const TAKEN: u32 = 0x80000000u;
// Step of a walk and of a line, in cells, small enough to skip no cell.
const WALK: f32 = 0.7;

// Rounds of the choice: after eight, nearly all proposals are decided.
const CHOICE_ROUNDS: u32 = 8u;

struct RowPlaces {
    // Size of the raster in cells.
    size: vec2<u32>,
    // Number of the round. Later rounds write greater words, so the raster need not be cleared.
    round: u32,
    stage: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> rules: RowRules;
@group(0) @binding(2) var<uniform> places: RowPlaces;
@group(0) @binding(3) var<storage, read_write> proposed: array<atomic<u32>, 4>;
@group(0) @binding(4) var<storage, read_write> proposals: array<vec4<f32>>;
// The raster that the pass reads.
@group(0) @binding(5) var<storage, read> near: array<u32>;

fn cell_px() -> f32 {
    return rules.spacing_px / CELLS_PER_SPACING;
}

// Returns the index of a cell; negative outside of the raster.
fn cell_at(px: vec2<f32>) -> i32 {
    let cell = vec2<i32>(floor((px + RASTER_MARGIN * rules.spacing_px) / cell_px()));
    let is_outside = any(cell < vec2<i32>(0)) || any(cell >= vec2<i32>(places.size));
    return select(cell.y * i32(places.size.x) + cell.x, -1, is_outside);
}

// Returns the word of a cell; everything outside of the raster is taken.
fn word_at(px: vec2<f32>) -> u32 {
    let cell = cell_at(px);
    if cell < 0 {
        return TAKEN;
    }
    return near[cell];
}

fn sample_of(number: u32, j: i32) -> vec4<f32> {
    return proposals[number * u32(PROPOSAL) + 1u + u32(j)];
}

// Returns the unit tangent of a mark between samples `begin` and `end`.
fn along_at(number: u32, j: i32, begin: i32, end: i32) -> vec2<f32> {
    let way = sample_of(number, min(j + 1, end)).xy - sample_of(number, max(j - 1, begin)).xy;
    return way / max(length(way), 1e-6);
}

fn across_at(number: u32, j: i32, begin: i32, end: i32) -> vec2<f32> {
    let along = along_at(number, j, begin, end);
    return vec2<f32>(-along.y, along.x);
}

fn is_seen(first: vec4<f32>, j: i32) -> bool {
    return ((u32(first.y) >> u32(j)) & 1u) == 1u;
}
