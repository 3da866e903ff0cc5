// Chooses which proposals are drawn, and which part of each: no two marks are nearer to each other than a part of a
// spacing.
//
// Evenly spaced streamlines (Jobard and Lefer 1997) are grown one after the other. Here all proposals are processed in
// rounds (Luby 1986, "A simple parallel algorithm for the maximal independent set problem"): in each round, a proposal
// loses the parts that are too near to a drawn mark; the rest is written to a raster with its priority; and it is drawn
// if no other nearby proposal has a greater priority. Long marks have the greatest priority, and marks of rows before
// others; otherwise priorities are random numbers that depend on a mark's position on the land. So the choice depends
// on a mark's surroundings alone. A round has two stages, since all threads must finish one before any begins the
// next. The first stage reads the raster of drawn marks and writes claims, the second reads claims and writes drawn
// marks. A mark that is chosen at the second stage is written to that of drawn marks at once, and to the claims at the
// next first stage.
#import hachure::rows::{HALF, PROPOSAL, UNDECIDED, CHOSEN, DRAWN, DROPPED, SAMPLES}
#import hachure::row_places::{places, rules, proposed, proposals, TAKEN, WALK, CELLS_PER_SPACING, CHOICE_ROUNDS, cell_px, cell_at, word_at}
#import hachure::row_places::{sample_of, along_at, across_at, is_seen}

// Least distance to another mark, in spacings: sideways, sideways for a mark outside of any row, and ahead of its ends.
const APART: f32 = 0.4;
const APART_ALONE: f32 = 0.6;
const AHEAD: f32 = 0.0;
// Shortest remainder of a proposal that is drawn, in spacings.
const SHORTEST: f32 = 1.2;
const CLAIM: u32 = 0u;

// The raster that this stage writes.
@group(0) @binding(6) var<storage, read_write> raster: array<atomic<u32>>;

// Returns the greatest word across a sample of a mark, and ahead of its ends.
fn greatest_near(number: u32, j: i32, begin: i32, end: i32) -> u32 {
    let px = sample_of(number, j).xy;
    let along = along_at(number, j, begin, end);
    let across = vec2<f32>(-along.y, along.x);
    var word = word_at(px);
    let apart = select(APART, APART_ALONE, sample_of(number, j).z < 0.0);
    for (var t = WALK; t <= apart * CELLS_PER_SPACING; t += WALK) {
        word = max(word, max(word_at(px + across * (t * cell_px())), word_at(px - across * (t * cell_px()))));
    }
    if j == begin || j == end {
        let ahead = select(along, -along, j == begin);
        for (var t = WALK; t <= AHEAD * CELLS_PER_SPACING; t += WALK) {
            word = max(word, word_at(px + ahead * (t * cell_px())));
        }
    }
    return word;
}

// Writes the visible part of a mark to the raster.
fn put_down(number: u32, begin: i32, end: i32, first: vec4<f32>, word: u32) {
    for (var j = begin; j < end; j++) {
        if !is_seen(first, j) && !is_seen(first, j + 1) {
            continue;
        }
        let start = sample_of(number, j).xy;
        let way = sample_of(number, j + 1).xy - start;
        let steps = i32(min(ceil(length(way) / (WALK * cell_px())), 64.0));
        for (var i = 0; i <= steps; i++) {
            let cell = cell_at(start + way * (f32(i) / f32(max(steps, 1))));
            if cell >= 0 {
                atomicMax(&raster[cell], word);
            }
        }
    }
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let number = id.x;
    if number >= min(atomicLoad(&proposed[0]), rules.max_marks) {
        return;
    }
    let at = number * u32(PROPOSAL);
    var first = proposals[at];
    let begin = i32(first.x) % 32;
    let end = i32(first.x) / 32;
    let turn = (places.round << 22u) | u32(first.z);
    if places.stage == CLAIM {
        if first.w == CHOSEN {
            proposals[at].w = DRAWN;
            put_down(number, begin, end, first, TAKEN | u32(first.z));
            return;
        }
        if first.w != UNDECIDED {
            return;
        }
        // The longest free piece of the proposal.
        var longest = vec2<i32>(0, -1);
        var longest_px = 0.0;
        var clear = begin;
        var length_px = 0.0;
        for (var j = begin; j <= end; j++) {
            let is_taken = is_seen(first, j) && (greatest_near(number, j, begin, end) & TAKEN) != 0u;
            if j > clear {
                length_px += distance(sample_of(number, j).xy, sample_of(number, j - 1).xy);
            }
            if is_taken {
                clear = j + 1;
                length_px = 0.0;
            } else if length_px > longest_px {
                longest = vec2<i32>(clear, j);
                longest_px = length_px;
            }
        }
        if longest_px < SHORTEST * rules.spacing_px {
            proposals[at].w = DROPPED;
            return;
        }
        proposals[at].x = f32(longest.x + 32 * longest.y);
        put_down(number, longest.x, longest.y, first, turn);
    } else {
        if first.w != UNDECIDED {
            return;
        }
        for (var j = begin; j <= end; j++) {
            if is_seen(first, j) && greatest_near(number, j, begin, end) > turn {
                // Outside of the raster everything is taken, so such a proposal stays undecided.
                return;
            }
        }
        proposals[at].w = select(CHOSEN, DRAWN, places.round + 1u == CHOICE_ROUNDS);
        put_down(number, begin, end, first, TAKEN | u32(first.z));
    }
}
