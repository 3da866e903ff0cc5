// Traces the marks of candidates: from its seed each runs up and down the slope to the heights at which its row ends.
//
// Samples are at even heights, so samples of neighbouring marks with the same number are side by side, and their
// distance is the local gap. Between samples a mark follows the gradient of the land's form by two steps of the
// midpoint rule, by height; a step of Newton's method then corrects the height. A mark ends early where the form is
// level, where rows have another height, and where there is no land.
//
// Some marks are shifted up by one sample: if all ends were at one height, a white line would run along them, and rows
// would look like steps. The paper-folding sequence by the mark's index decides which marks are shifted: however many
// marks the picture thins out, at most three neighbours are alike.
//
// Beyond the border of its row a mark continues where no mark of the next row would arrive: where the land stops
// rising, or falling, before the middle of that row. So crests and valleys between rows are not bare. A mark outside of
// any row runs as far up and down as one of a row does on land of the surrounding steepness.
#import hachure::rows::{RowRules, RowBlock, MARGIN, OCTAVES, FIRST_OCTAVE, RELIEF, STEPS, MOST_CANDIDATES, WORDS, ELSEWHERE, ALONE, HALF, CORE}
#import hachure::rows::{cell_m, frame_at, pack_place}
#import hachure::row_form::{LONGEST, relief, row_form, steepness, way_of}

@group(0) @binding(0) var<uniform> rules: RowRules;
@group(0) @binding(1) var<storage, read> jobs: array<RowBlock>;
@group(0) @binding(3) var<storage, read> counts: array<u32>;
@group(0) @binding(4) var<storage, read_write> candidates: array<u32>;

fn octave_at(first: i32, place: vec2<f32>) -> i32 {
    let cell = vec2<i32>(floor(place)) + MARGIN;
    if any(cell < vec2<i32>(0)) || any(cell >= vec2<i32>(OCTAVES)) {
        return 0;
    }
    return i32(relief[first + FIRST_OCTAVE + cell.y * OCTAVES + cell.x]);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let block = jobs[id.y];
    if id.x >= min(counts[block.slot], MOST_CANDIDATES) {
        return;
    }
    let at = (block.slot * MOST_CANDIDATES + id.x) * WORDS;
    let first = i32(id.y) * RELIEF;
    let seed = vec2<f32>(bitcast<f32>(candidates[at + 4u]), bitcast<f32>(candidates[at + 5u]));
    let frame = frame_at(block, seed);
    let is_alone = candidates[at + 1u] == ALONE;
    let height = bitcast<i32>(candidates[at + 3u]);
    let unit_m = cell_m(block) / STEPS;
    var middle_m = f32(height) * unit_m;
    // The lowest set bit is half of the row's height.
    let half_row = height & -height;
    let octave = i32(firstTrailingBit(u32(half_row))) + 1;
    var step_m = f32(half_row) * unit_m / f32(CORE);
    if is_alone {
        middle_m = row_form(block, first, frame, seed).z;
        step_m = 0.5 * rules.row_cells * cell_m(block) * sqrt(max(steepness(first, seed), 1e-8)) / f32(CORE);
        candidates[at] = bitcast<u32>(step_m);
        candidates[at + 3u] = bitcast<u32>(middle_m);
    }
    var reach = vec2<u32>(0u);
    // Number of samples by which the mark is shifted up.
    let index = max(candidates[at] & ~ELSEWHERE, 1u);
    let twos = firstTrailingBit(index);
    let stagger = i32((index >> (twos + 1u)) ^ twos) & 1;
    candidates[at + 4u + u32(HALF)] = pack_place(seed);
    for (var side = 0; side < 2; side++) {
        let sign = select(-1.0, 1.0, side == 1);
        var place = seed;
        var slope = row_form(block, first, frame, place).xy;
        // A seed on land below the threshold of slope gets no mark.
        var goes = length(slope) > rules.level;
        for (var i = 1; i <= select(2 * CORE, CORE, is_alone) && goes; i++) {
            var next = place;
            for (var part = 0; part < 2; part++) {
                let half = next + 0.25 * way_of(block, frame, slope, sign * step_m);
                let there = row_form(block, first, frame, half).xy;
                next += 0.5 * way_of(block, frame, there, sign * step_m);
                slope = there;
            }
            let end = row_form(block, first, frame, next);
            let wanted_m = middle_m + sign * step_m * f32(i);
            next += way_of(block, frame, end.xy, wanted_m - end.z);
            slope = row_form(block, first, frame, next).xy;
            let gone = distance(next, place);
            goes = length(slope) > rules.level && gone < LONGEST
                && (is_alone || octave_at(first, next) == octave || (octave_at(first, next) < octave && octave_at(first, place) == octave)) && dot(slope, end.xy) > 0.0;
            if goes {
                place = next;
                reach[side] = u32(i);
            }
            if i <= HALF {
                candidates[at + u32(4 + HALF + select(-i, i, side == 1))] = pack_place(place);
            }
        }
        for (var i = i32(reach[side]) + 1; i <= HALF; i++) {
            candidates[at + u32(4 + HALF + select(-i, i, side == 1))] = pack_place(place);
        }
        // Either the next row takes over from here, or the rest is too far for this one.
        reach[side] = u32(select(min(i32(reach[side]), HALF), CORE + select(select(-stagger, stagger, side == 1), 0, is_alone), goes));
    }
    candidates[at + 2u] = reach.x | (reach.y << 8u);
}
