// Computes the height of rows for each cell: a power of two.
//
// It follows from the steepness of the surrounding land, so that rows are about as long on gentle land as on steep
// land; and from whether a row of that height reaches the cell at all. A row's marks begin at its middle height. Where
// the slope line through a cell ends at a crest, at the bottom of a valley or on level land before it reaches that
// height, no mark arrives, and rows of half the height are tried. This is a function of position alone, so neighbouring
// blocks agree.
#import hachure::terrain::{terrain, is_in_grid}
#import hachure::rows::{RowRules, RowBlock, Frame, MARGIN, OCTAVES, FIRST_OCTAVE, RELIEF, STEPS, HALF, CORE}
#import hachure::rows::{MIN_OCTAVE, MAX_OCTAVE, cell_m, grid_of, frame_at}
#import hachure::row_form::{LONGEST, relief, row_form, steepness, horizontal_step}

// Number of octaves that are tried.
const TRIES: i32 = 2;
// Distance of a parallel flow line, in cells, and the smallest part of it to which the two may converge.
const ASIDE: f32 = 0.25;
const GATHERED: f32 = 0.4;

@group(0) @binding(0) var<uniform> rules: RowRules;
@group(0) @binding(1) var<storage, read> jobs: array<RowBlock>;

// Returns the octave whose rows have the desired length.
fn octave_by_slope(first: i32, cell: vec2<i32>) -> i32 {
    let slope = steepness(first, vec2<f32>(cell) + 0.5);
    let steps = STEPS * rules.row_cells * sqrt(max(slope, 1e-8));
    return clamp(i32(round(log2(steps))), MIN_OCTAVE, MAX_OCTAVE);
}

// Takes one step of the midpoint rule up or down the slope.
fn next_place(block: RowBlock, first: i32, frame: Frame, place: vec2<f32>, slope: vec2<f32>, rise_m: f32) -> vec2<f32> {
    let half = row_form(block, first, frame, place + 0.5 * horizontal_step(block, frame, slope, rise_m)).xy;
    return place + horizontal_step(block, frame, half, rise_m);
}

// Returns whether the slope line through a point continues for this rise, up or down, without converging with its
// neighbour: marks that come from the other end would be too far from each other here.
fn leads(block: RowBlock, first: i32, frame: Frame, begin: vec2<f32>, rise_m: f32, step_m: f32) -> bool {
    let count = i32(ceil(abs(rise_m) / step_m));
    let each_m = rise_m / f32(max(count, 1));
    var place = begin;
    var before = row_form(block, first, frame, place).xy;
    // The start of the neighbouring flow line, along the contour line.
    let up = horizontal_step(block, frame, before, length(before));
    var aside = begin + vec2<f32>(-up.y, up.x) * (ASIDE / max(length(up), 1e-12));
    for (var i = 0; i < count; i++) {
        let next = next_place(block, first, frame, place, before, each_m);
        aside = next_place(block, first, frame, aside, row_form(block, first, frame, aside).xy, each_m);
        let slope = row_form(block, first, frame, next).xy;
        if length(slope) < rules.level || distance(next, place) > LONGEST || dot(slope, before) <= 0.0 || distance(next, aside) < GATHERED * ASIDE {
            return false;
        }
        place = next;
        before = slope;
    }
    return true;
}

// Returns whether a mark of rows of this height reaches a point: from the middle of its own row or, if that row has
// none there, from beyond the border of the next.
fn is_covered(block: RowBlock, first: i32, frame: Frame, place: vec2<f32>, height_m: f32, row_m: f32) -> bool {
    let step_m = 0.5 * row_m / f32(CORE);
    let rise_m = (floor(height_m / row_m) + 0.5) * row_m - height_m;
    if leads(block, first, frame, place, rise_m, step_m) {
        return true;
    }
    let other_m = rise_m - sign(rise_m) * row_m;
    return abs(other_m) <= f32(HALF) * step_m && leads(block, first, frame, place, other_m, step_m);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let block = jobs[id.y];
    let number = i32(id.x);
    let first = i32(id.y) * RELIEF;
    if number >= OCTAVES * OCTAVES {
        return;
    }
    let cell = vec2<i32>(number % OCTAVES, number / OCTAVES) - MARGIN;
    let place = vec2<f32>(cell) + 0.5;
    var found = 0;
    if is_in_grid(grid_of(block, place)) {
        let frame = frame_at(block, place);
        let at = row_form(block, first, frame, place);
        let unit_m = cell_m(block) / STEPS;
        let wanted = octave_by_slope(first, cell);
        for (var octave = wanted; octave > max(wanted - TRIES, MIN_OCTAVE - 1) && found == 0; octave--) {
            if length(at.xy) > rules.level && is_covered(block, first, frame, place, at.z, unit_m * exp2(f32(octave))) {
                found = octave;
            }
        }
    }
    relief[first + FIRST_OCTAVE + number] = f32(found);
}
