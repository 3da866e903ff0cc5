// Traces the marks of candidates: each mark runs from its seed up and down the slope to the heights at which its row
// ends.
//
// Samples are evenly spaced in height, so samples of neighbouring marks with the same number are side by side, and
// their distance is the local gap. Between samples a mark follows the gradient of the land's form by two steps of the
// midpoint rule, by height; a step of Newton's method then corrects the height. A mark ends early where the form is
// level, where rows have another octave (see rows.wgsl), and where there is no land.
//
// Some marks are shifted up by one sample: if all ends were at one height, a white line would run along them, and rows
// would look like steps. The alternating paper-folding sequence, by the mark's index, decides which marks are shifted:
// however many marks the picture thins out, at most three neighbours are alike.
//
// Beyond the border of its row a mark continues where the next row has none: where the land stops rising, or falling,
// before the middle of that row. So crests and valleys between rows are not bare. A mark outside of any row runs as far
// up and down as one of a row does on land of the surrounding steepness.
#import hachure::rows::{RowRules, RowBlock, MARGIN, OCTAVES, FIRST_OCTAVE, RELIEF, STEPS, MAX_CANDIDATES, INDEX, INTERVALS, REACH, HEIGHT, SEED, WORDS, ELSEWHERE, ALONE, HALF, CORE}
#import hachure::rows::{cell_m, frame_at, pack_place, sample_word}
#import hachure::row_form::{LONGEST, relief, row_form, steepness, horizontal_step}

@group(0) @binding(0) var<uniform> rules: RowRules;
@group(0) @binding(1) var<storage, read> jobs: array<RowBlock>;
// Binding 2, `relief`, is in row_form.wgsl.
@group(0) @binding(3) var<storage, read> counts: array<u32>;
@group(0) @binding(4) var<storage, read_write> candidates: array<u32>;

// Returns the octave of the rows at a position in a block whose relief begins at `first`; 0 without rows.
fn octave_at(first: i32, place: vec2<f32>) -> i32 {
    let cell = vec2<i32>(floor(place)) + MARGIN;
    if any(cell < vec2<i32>(0)) || any(cell >= vec2<i32>(OCTAVES)) {
        return 0;
    }
    return i32(relief[first + FIRST_OCTAVE + cell.y * OCTAVES + cell.x]);
}

// Returns whether a mark may run from one position to the next: within land of its row's octave, or by one step out of
// it, onto land of lower octaves.
fn stays_in_row(first: i32, place: vec2<f32>, next: vec2<f32>, octave: i32) -> bool {
    let octave_next = octave_at(first, next);
    return octave_next == octave || (octave_next < octave && octave_at(first, place) == octave);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let block = jobs[id.y];
    if id.x >= min(counts[block.slot], MAX_CANDIDATES) {
        return;
    }
    let at = (block.slot * MAX_CANDIDATES + id.x) * WORDS;
    let first = i32(id.y) * RELIEF;
    let seed = vec2<f32>(bitcast<f32>(candidates[at + SEED]), bitcast<f32>(candidates[at + SEED + 1u]));
    let frame = frame_at(block, seed);
    let is_alone = candidates[at + INTERVALS] == ALONE;
    let index = max(candidates[at + INDEX] & ~ELSEWHERE, 1u);
    let height = bitcast<i32>(candidates[at + HEIGHT]);
    let unit_m = cell_m(block) / STEPS;
    var middle_m = f32(height) * unit_m;
    // The seed is at an odd multiple of half of the row's height, so the lowest set bit is that half.
    let half_row = height & -height;
    let octave = i32(firstTrailingBit(u32(half_row))) + 1;
    var step_m = f32(half_row) * unit_m / f32(CORE);
    if is_alone {
        middle_m = row_form(block, first, frame, seed).z;
        step_m = 0.5 * rules.row_cells * cell_m(block) * sqrt(max(steepness(first, seed), 1e-8)) / f32(CORE);
        candidates[at + INDEX] = bitcast<u32>(step_m);
        candidates[at + HEIGHT] = bitcast<u32>(middle_m);
    }
    // Number of samples below and above the seed.
    var reach = vec2<u32>(0u);
    // Number of samples by which the mark is shifted up or down, so that the ends of the marks of a row are not in line:
    // by the paper-folding sequence, inverted where the number of factors of two is odd.
    let twos = firstTrailingBit(index);
    let offset = i32(rules.stagger);
    let up = (offset + 1) / 2;
    let stagger = select(up - offset, up, (((index >> (twos + 1u)) ^ twos) & 1u) == 1u);
    candidates[sample_word(at, 0)] = pack_place(seed);
    for (var side = 0; side < 2; side++) {
        // Down the slope, then up.
        let sign = select(-1, 1, side == 1);
        var place = seed;
        var slope = row_form(block, first, frame, place).xy;
        // A seed on land below the threshold of slope gets no mark.
        var continues = length(slope) > rules.level;
        // The middle of the next row is 2 CORE samples away.
        for (var i = 1; i <= select(2 * CORE, CORE, is_alone) && continues; i++) {
            let rise_m = f32(sign) * step_m;
            var next = place;
            for (var substep = 0; substep < 2; substep++) {
                let midpoint = next + 0.25 * horizontal_step(block, frame, slope, rise_m);
                slope = row_form(block, first, frame, midpoint).xy;
                next += 0.5 * horizontal_step(block, frame, slope, rise_m);
            }
            let predicted = row_form(block, first, frame, next);
            let wanted_m = middle_m + rise_m * f32(i);
            next += horizontal_step(block, frame, predicted.xy, wanted_m - predicted.z);
            slope = row_form(block, first, frame, next).xy;
            let moved = distance(next, place);
            continues = length(slope) > rules.level && moved < LONGEST
                && (is_alone || stays_in_row(first, place, next, octave)) && dot(slope, predicted.xy) > 0.0;
            if continues {
                place = next;
                reach[side] = u32(i);
            }
            if i <= HALF {
                candidates[sample_word(at, sign * i)] = pack_place(place);
            }
        }
        // Samples beyond the end are at the end.
        for (var i = i32(reach[side]) + 1; i <= HALF; i++) {
            candidates[sample_word(at, sign * i)] = pack_place(place);
        }
        if !continues {
            // The next row has no mark here.
            reach[side] = min(reach[side], u32(HALF));
        } else if is_alone {
            reach[side] = u32(CORE);
        } else {
            // The next row takes over at the border.
            reach[side] = u32(CORE + sign * stagger);
        }
    }
    candidates[at + REACH] = reach.x | (reach.y << 8u);
}
