// Proposes the marks of a frame: which candidates may be drawn, which part of each, and how much room they have.
//
// A candidate has a rank, the number of factors of two in its index; the greatest rank comes first. It is drawn where
// the gap between its neighbours of greater rank is wide on the picture, and grows and tapers with that gap. So the
// spacing of marks stays within half an octave, where land spreads rows and where it gathers them, near and far,
// without forks. This is a function of position and view alone.
//
// A mark's room is its part of the gaps on either side. A candidate takes its part of a gap from its neighbours, also
// while it grows: the ink of a row does not depend on the number of marks in it.
//
// Candidates outside of any row, which fill the land that rows leave bare, are proposed as they are: `choice` decides
// which of all proposals are drawn on the picture, and `rooms` how much room they have.
#import hachure::view::{View, distance_from_eye}
#import hachure::seen::place_seen
#import hachure::terrain::terrain
#import hachure::surface::vertex_height_m
#import hachure::earth::bend
#import hachure::rows::{RowRules, RowBlock, Frame, CELLS, STEPS, MAX_CANDIDATES, HALF, CORE, SAMPLES, INDEX, INTERVALS, REACH, HEIGHT, WORDS, CLOSED, ELSEWHERE, ALONE, PROPOSAL, REACH_CELLS, REACH_PX}
#import hachure::rows::{cell_m, grid_of, frame_at, world_offset, sample_word, unpack_place, camera_height_m}

// Gaps between neighbours, in spacings, over which a mark between them grows.
const CLOSED_GAP: f32 = 1.3;
const OPEN_GAP: f32 = 1.45;
// Largest ratio of the gap to a mark's distance from its nearer neighbour that counts.
const ASIDE: f32 = 2.6;
// Half of the part of an octave over which two levels are blended.
const FADE: f32 = 0.02;
// Tolerance of the first, approximate test of a position, in octaves and in hundreds of pixels.
const SLACK: f32 = 0.2;
// Largest rank of neighbours that is examined.
const MAX_RANK: i32 = 5;
// Shortest mark that is proposed, in spacings.
const SHORTEST: f32 = 1.2;
// Cosine of the largest turn of a mark from where it is drawn most strongly: 70 degrees.
const STRAIGHT: f32 = 0.34;
// Spacings per cell, in the middle of the possible range. Lengths on the land are the same for every eye.
const MEAN_CELL: f32 = 1.4;
// Number of spacings by which marks of rows count as longer than others, while they grow and once they are fully grown.
const GROWING_AHEAD: f32 = 1.5;
const GROWN_AHEAD: f32 = 2.5;
// Distance along a mark between the points where the gaps are evaluated, in samples.
const SPAN: i32 = 4;
// Largest room of a mark, in spacings.
const MAX_ROOM: f32 = 1.5;
// Margin around the picture, in spacings.
const BORDER: f32 = 6.0;

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> rules: RowRules;
@group(0) @binding(2) var<storage, read> blocks: array<RowBlock>;
@group(0) @binding(3) var<storage, read> counts: array<u32>;
@group(0) @binding(4) var<storage, read> candidates: array<u32>;
// The first word is their number.
@group(0) @binding(5) var<storage, read_write> proposed: array<atomic<u32>, 4>;
// See PROPOSAL.
@group(0) @binding(6) var<storage, read_write> proposals: array<vec4<f32>>;
@group(0) @binding(7) var distance_m: texture_2d<f32>;

struct Candidate {
    // Offset of its first word, and of that of the first candidate of its piece.
    at: u32,
    first: u32,
    index: i32,
    intervals: i32,
    is_closed: bool,
    // True for a mark outside of any row.
    is_alone: bool,
    // Number of samples below and above the middle.
    down: i32,
    up: i32,
}

fn candidate(at: u32) -> Candidate {
    let index = candidates[at + INDEX] & ~ELSEWHERE;
    let reach = candidates[at + REACH];
    let intervals = candidates[at + INTERVALS];
    return Candidate(at, at - index * WORDS, i32(index), i32(intervals & ~CLOSED), (intervals & CLOSED) != 0u, intervals == ALONE,
        i32(reach & 255u), i32(reach >> 8u));
}

fn place_of(one: Candidate, sample: i32) -> vec2<f32> {
    return unpack_place(candidates[sample_word(one.at, sample)]);
}

// Returns another candidate of the piece; a closed piece wraps around.
fn neighbour(one: Candidate, index: i32) -> Candidate {
    let around = select(index, (index + one.intervals) % one.intervals, one.is_closed);
    return candidate(one.first + u32(clamp(around, 0, one.intervals)) * WORDS);
}

fn rank(one: Candidate, index: i32) -> i32 {
    let is_end = index == 0 || index == one.intervals;
    return select(i32(firstTrailingBit(u32(index))), MAX_RANK + 1, is_end);
}

// Returns a position in pixels, and the distance along the view axis.
fn project(flat_m: vec3<f32>) -> vec3<f32> {
    let clip = view.clip_from_camera * vec4<f32>(bend(flat_m), 1.0);
    let ndc = clip.xy / max(clip.w, 1e-6);
    return vec3<f32>((ndc * vec2<f32>(0.5, -0.5) + 0.5) * vec2<f32>(view.size_px), clip.w);
}

// A point on a mark from which gaps are measured.
struct Stand {
    flat_m: vec3<f32>,
    px: vec2<f32>,
    // Unit vector across the mark on the picture.
    across: vec2<f32>,
    sample: i32,
}

// Returns the gap between two candidates, in pixels across the mark.
fn gap_px(frame: Frame, stand: Stand, a: Candidate, b: Candidate) -> f32 {
    let sample = clamp(stand.sample, -min(a.down, b.down), min(a.up, b.up));
    let way_m = world_offset(frame, place_of(b, sample) - place_of(a, sample));
    return abs(dot(project(stand.flat_m + vec3<f32>(way_m, 0.0)).xy - stand.px, stand.across));
}

// Returns how strongly a candidate is drawn, 0 to 1, by the gap around it.
fn share(frame: Frame, stand: Stand, one: Candidate) -> f32 {
    if one.is_alone {
        return 1.0;
    }
    let z = rank(one, one.index);
    if z > MAX_RANK {
        return 1.0;
    }
    let stride = 1 << u32(z);
    let a = gap_px(frame, stand, one, neighbour(one, one.index - stride));
    let b = gap_px(frame, stand, one, neighbour(one, min(one.index + stride, one.intervals)));
    let gap = min(a + b, ASIDE * min(a, b)) / rules.spacing_px;
    return smoothstep(CLOSED_GAP, OPEN_GAP, gap);
}

// Returns the gap to the next drawn mark on one side; negative if there is none.
fn gap_on_side(frame: Frame, stand: Stand, one: Candidate, side: i32) -> f32 {
    let end = select(0, one.intervals, side > 0);
    if one.index == end && !one.is_closed {
        return -1.0;
    }
    let z = min(rank(one, one.index), MAX_RANK);
    let last = select(end, select(-one.intervals, 2 * one.intervals, side > 0), one.is_closed);
    let far = select(max(one.index - (1 << u32(z)), last), min(one.index + (1 << u32(z)), last), side > 0);
    var gap = gap_px(frame, stand, one, neighbour(one, far));
    for (var y = z - 1; y >= 0; y--) {
        let index = one.index + side * (1 << u32(y));
        let is_there = (side > 0 && index < last) || (side < 0 && index > last);
        if is_there {
            let other = neighbour(one, index);
            gap = mix(gap, gap_px(frame, stand, one, other), share(frame, stand, other));
        }
    }
    return gap;
}

// Returns a mark's room: its part of the gaps on both sides. The last mark of a piece has as much room on its outer
// side.
fn room_of(frame: Frame, stand: Stand, one: Candidate) -> f32 {
    let a = gap_on_side(frame, stand, one, -1);
    let b = gap_on_side(frame, stand, one, 1);
    return min(0.5 * (select(a, b, a < 0.0) + select(b, a, b < 0.0)), MAX_ROOM * rules.spacing_px);
}

// Returns how strongly a block's level is shown at a point: 0 if the point is off-screen. `slack` is a tolerance in
// octaves and in hundreds of pixels.
fn level_share(block: RowBlock, at_m: vec3<f32>, slack: f32) -> f32 {
    let cell_px = rules.cell_px_m * exp2(block.level) / length(at_m);
    var f = 1.0 - log2(cell_px / rules.spacing_px);
    f = select(f, max(f, 0.5), block.level <= rules.min_level);
    f = select(f, min(f, 0.5), block.level >= rules.greatest_level);
    let middle = project(at_m);
    // The planner of blocks culls by the same distance (src/surface/rows/reach.rs).
    let room_px = REACH_PX + REACH_CELLS * cell_px + 100.0 * slack;
    let is_off_screen = any(middle.xy < vec2<f32>(-room_px)) || any(middle.xy > vec2<f32>(view.size_px) + room_px);
    if middle.z < view.near_m || is_off_screen {
        return 0.0;
    }
    return clamp(0.5 + 0.5 * (f + slack) / FADE, 0.0, 1.0) * clamp(0.5 + 0.5 * (1.0 - f + slack) / FADE, 0.0, 1.0);
}

// Returns the height of a mark's middle, and its rise from sample to sample, in metres.
fn rise_of(block: RowBlock, one: Candidate) -> vec2<f32> {
    if one.is_alone {
        return vec2<f32>(bitcast<f32>(candidates[one.at + HEIGHT]), bitcast<f32>(candidates[one.at + INDEX]));
    }
    let height = bitcast<i32>(candidates[one.at + HEIGHT]);
    let unit_m = cell_m(block) / STEPS;
    return vec2<f32>(f32(height), f32(height & -height) / f32(CORE)) * unit_m;
}

// Returns a random number of 16 bits that is the same in every frame.
fn lot(one: Candidate) -> f32 {
    var word = candidates[sample_word(one.at, 0)];
    word = (word ^ (word >> 16u)) * 0x7feb352du;
    word = (word ^ (word >> 15u)) * 0x846ca68bu;
    return f32(word >> 16u);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let block = blocks[id.y];
    if id.x >= min(counts[block.slot], MAX_CANDIDATES) {
        return;
    }
    let one = candidate((block.slot * MAX_CANDIDATES + id.x) * WORDS);
    if (candidates[one.at + INDEX] & ELSEWHERE) != 0u || one.down + one.up < 2 {
        return;
    }
    let seed = place_of(one, 0);
    let rise = rise_of(block, one);
    let middle_m = rise.x - camera_height_m();
    let step_m = rise.y;
    // The position of the block's middle rejects most candidates, and the exact position is expensive.
    let aside = seed - 0.5 * f32(CELLS);
    let about_m = vec3<f32>(block.middle_m + block.along_x * aside.x + block.along_y * aside.y, middle_m);
    if level_share(block, about_m, SLACK) <= 0.0 {
        return;
    }
    let frame = frame_at(block, seed);
    let share_of_level = level_share(block, vec3<f32>(frame.world_m, middle_m), 0.0);
    if share_of_level <= 0.0 {
        return;
    }

    // On the form of the land: the position of the mark, and how strongly each part of it is drawn.
    var px: array<vec3<f32>, 17>;
    var flat_m: array<vec3<f32>, 17>;
    for (var j = -one.down; j <= one.up; j++) {
        let at = vec3<f32>(frame.world_m + world_offset(frame, place_of(one, j) - seed), middle_m + step_m * f32(j));
        flat_m[j + HALF] = at;
        px[j + HALF] = project(at);
        if px[j + HALF].z < view.near_m {
            return;
        }
    }
    var shares: array<f32, 17>;
    var stands: array<vec2<f32>, 17>;
    var most = 0.0;
    var best = 0;
    for (var j = -one.down; j <= one.up; j++) {
        let along = px[min(j + 1, one.up) + HALF].xy - px[max(j - 1, -one.down) + HALF].xy;
        stands[j + HALF] = vec2<f32>(-along.y, along.x) / max(length(along), 1e-6);
    }
    // At every second sample, and interpolated in between.
    for (var i = 0; i < one.down + one.up + 2; i += 2) {
        let j = min(i - one.down, one.up);
        shares[j + HALF] = share(frame, Stand(flat_m[j + HALF], px[j + HALF].xy, stands[j + HALF], j), one);
    }
    for (var j = 1 - one.down; j < one.up; j += 2) {
        shares[j + HALF] = 0.5 * (shares[j - 1 + HALF] + shares[j + 1 + HALF]);
    }
    for (var j = -one.down; j <= one.up; j++) {
        let own = shares[j + HALF];
        if own > most || (own == most && abs(j) < abs(best)) {
            most = own;
            best = j;
        }
    }
    if most <= 0.0 {
        return;
    }
    // A single piece of it.
    var begin = best;
    var end = best;
    while begin > -one.down && shares[begin + HALF] > 0.0 && dot(stands[begin - 1 + HALF], stands[best + HALF]) > STRAIGHT {
        begin--;
    }
    while end < one.up && shares[end + HALF] > 0.0 && dot(stands[end + 1 + HALF], stands[best + HALF]) > STRAIGHT {
        end++;
    }

    // The land itself is higher or lower than its form: evaluated at every second sample, and interpolated in between.
    var lifts: array<f32, 17>;
    for (var i = 0; i < end - begin + 2; i += 2) {
        let j = min(begin + i, end);
        let at = flat_m[j + HALF];
        lifts[j + HALF] = vertex_height_m(grid_of(block, place_of(one, j)), length(at)) - at.z;
    }
    for (var j = begin + 1; j < end; j += 2) {
        lifts[j + HALF] = 0.5 * (lifts[j - 1 + HALF] + lifts[j + 1 + HALF]);
    }
    let border_px = BORDER * rules.spacing_px;
    var rooms: array<f32, 17>;
    var length_px = 0.0;
    var seen_samples = 0u;
    // Gaps change slowly along the mark, so they are evaluated at the ends of spans.
    var room_ahead = vec2<f32>(0.0);
    if !one.is_alone {
        room_ahead.y = room_of(frame, Stand(flat_m[begin + HALF], px[begin + HALF].xy, stands[begin + HALF], begin), one);
    }
    var span = vec2<i32>(begin);
    for (var j = begin; j <= end; j++) {
        if j >= span.y && j < end && !one.is_alone {
            span = vec2<i32>(j, min(j + SPAN, end));
            let there = Stand(flat_m[span.y + HALF], px[span.y + HALF].xy, stands[span.y + HALF], span.y);
            room_ahead = vec2<f32>(room_ahead.y, room_of(frame, there, one));
        }
        let part = f32(j - span.x) / f32(max(span.y - span.x, 1));
        rooms[j + HALF] = shares[j + HALF] * mix(room_ahead.x, room_ahead.y, part);
        let seen = project(flat_m[j + HALF] + vec3<f32>(0.0, 0.0, lifts[j + HALF]));
        let is_inside = all(seen.xy >= vec2<f32>(0.0)) && all(seen.xy < vec2<f32>(view.size_px));
        let land = place_seen(view, distance_m, clamp(vec2<i32>(floor(seen.xy)), vec2<i32>(0), vec2<i32>(view.size_px) - 1));
        // Hidden parts take no space on the picture. Visibility off-screen is not known, and far off-screen it affects
        // no visible mark.
        let is_near = all(seen.xy >= vec2<f32>(-border_px)) && all(seen.xy < vec2<f32>(view.size_px) + border_px);
        let is_seen = is_near && (!is_inside || (land.w > 0.0 && seen.z < land.w + 2.0 * cell_m(block)));
        seen_samples |= select(0u, 1u << u32(j + HALF), is_seen);
        if j > begin {
            length_px += distance(seen.xy, px[j - 1 + HALF].xy);
        }
        px[j + HALF] = seen;
    }
    if length_px < SHORTEST * rules.spacing_px || seen_samples == 0u {
        return;
    }
    let number = atomicAdd(&proposed[0], 1u);
    if number >= rules.max_marks {
        return;
    }
    // Long marks come first, and marks of rows before those that fill gaps: they count as longer, fully grown ones
    // most.
    let ahead = select(select(GROWING_AHEAD, GROWN_AHEAD, most >= 1.0), 0.0, one.is_alone);
    let chord = distance(place_of(one, begin), place_of(one, end)) * MEAN_CELL;
    let order = floor(min(chord + ahead, 9.9));
    let turn = order * 65536.0 + lot(one);
    let at = number * u32(PROPOSAL);
    proposals[at] = vec4<f32>(f32(begin + HALF + 32 * (end + HALF)), f32(seen_samples), turn, 0.0);
    for (var j = -HALF; j <= HALF; j++) {
        let k = clamp(j, begin, end) + HALF;
        let room = select(rooms[k], -1.0, one.is_alone) * share_of_level;
        proposals[at + 1u + u32(j + HALF)] = vec4<f32>(px[k].xy, room, px[k].z);
    }
}
