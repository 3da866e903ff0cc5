// Proposals of marks on the picture, and a raster that says who is where on it.
//
// A cell of the raster has the greatest word that was put there: the turn of a mark that is drawn, above all, or that of
// one that would be. A turn belongs to a mark's place on the land, as its number does not: which mark has a cell depends on
// no timing. Walks across a mark, from cell to cell, tell how near the next one is.
#define_import_path hachure::row_places
#import hachure::view::View
#import hachure::rows::{RowRules, HALF, PROPOSAL}

// Cells of the raster to a spacing, and spacings that it reaches beside the picture.
const CELLS_PER_SPACING: f32 = 6.0;
const RASTER_BESIDE: f32 = 16.0;
// Of a word: here is a mark that is drawn, whose turn follows.
const TAKEN: u32 = 0x80000000u;
// Steps of a walk and of a line, in cells: none is passed over.
const WALK: f32 = 0.7;

struct RowPlaces {
    // Of the raster.
    size: vec2<u32>,
    // A later round's words are greater, so none is wiped off.
    round: u32,
    stage: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> rules: RowRules;
@group(0) @binding(2) var<uniform> places: RowPlaces;
@group(0) @binding(3) var<storage, read_write> proposed: array<atomic<u32>, 4>;
@group(0) @binding(4) var<storage, read_write> proposals: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read_write> raster: array<atomic<u32>>;

fn cell_px() -> f32 {
    return rules.spacing_px / CELLS_PER_SPACING;
}

// The number of a cell; below 0 outside of the raster.
fn cell_at(px: vec2<f32>) -> i32 {
    let cell = vec2<i32>(floor((px + RASTER_BESIDE * rules.spacing_px) / cell_px()));
    let is_outside = any(cell < vec2<i32>(0)) || any(cell >= vec2<i32>(places.size));
    return select(cell.y * i32(places.size.x) + cell.x, -1, is_outside);
}

// What a place of the raster says; outside of it all is taken.
fn word_at(px: vec2<f32>) -> u32 {
    let cell = cell_at(px);
    if cell < 0 {
        return TAKEN;
    }
    return atomicLoad(&raster[cell]);
}

fn sample_of(number: u32, j: i32) -> vec4<f32> {
    return proposals[number * u32(PROPOSAL) + 1u + u32(j)];
}

// Of a mark that goes from sample to sample: unit, along it.
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
