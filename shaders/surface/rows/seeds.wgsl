// Places seeds of hachures, evenly spaced, along the middles of rows.
//
// The middle of a row is a contour line of the form's height. It is followed through the cells of a block by marching
// squares (Lorensen and Cline 1987, in the plane): from where it enters the block, or land with the same row height, to
// where it leaves; or all around. A piece has a whole number of intervals of DENSITY candidates, so that its ends,
// which the next block knows as well, are seeds. One thread follows one piece. The thread of a cell owns a line if
// there is no cell before it; a closed line belongs to the cell with the least number, which is found by going around.
//
// Differences from Lehmann's rows: seeds are in the middle and not at the upper contour, since flow lines that leave a
// ridge diverge without limit, and those from the middle only half as far. And rows do not have the same height
// everywhere: their height follows the slope of the surrounding land in octaves, so that they are about as long on
// gentle land as on steep land. Where land is so folded that no row reaches it, single marks fill the rest: each cell
// has a seed for one.
#import hachure::terrain::terrain
#import hachure::rows::{RowRules, RowBlock, Frame, CELLS, MARGIN_CELLS, NODES, MARGIN, OCTAVES, FIRST_OCTAVE, RELIEF, STEPS, DENSITY, MAX_CANDIDATES}
#import hachure::rows::{INDEX, INTERVALS, REACH, HEIGHT, SEED, WORDS, CLOSED, ELSEWHERE, ALONE, cell_m, frame_at, world_offset}

// Largest number of cells of a piece, and of pieces that begin in a cell.
const MAX_STEPS: i32 = 4096;
const MAX_LINES: i32 = 8;
// Seeds of single marks in a cell that has rows, and in one that has none.
const ALONE_WITH_ROWS: i32 = 1;
const ALONE_WITHOUT_ROWS: i32 = 2;
const NEXT: array<vec2<i32>, 4> = array<vec2<i32>, 4>(vec2<i32>(0, -1), vec2<i32>(1, 0), vec2<i32>(0, 1), vec2<i32>(-1, 0));

@group(0) @binding(0) var<uniform> rules: RowRules;
@group(0) @binding(1) var<storage, read> jobs: array<RowBlock>;
@group(0) @binding(2) var<storage, read> relief: array<f32>;
@group(0) @binding(3) var<storage, read_write> counts: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read_write> candidates: array<u32>;

fn corners(first: i32, cell: vec2<i32>) -> vec4<f32> {
    let at = first + (cell.y + MARGIN_CELLS) * NODES + cell.x + MARGIN_CELLS;
    return vec4<f32>(relief[at], relief[at + 1], relief[at + NODES + 1], relief[at + NODES]);
}

fn octave_at(first: i32, cell: vec2<i32>) -> i32 {
    return i32(relief[first + FIRST_OCTAVE + (cell.y + MARGIN) * OCTAVES + cell.x + MARGIN]);
}

// Returns whether a cell has rows of this octave.
fn is_active(first: i32, cell: vec2<i32>, octave: i32) -> bool {
    if any(cell < vec2<i32>(0)) || any(cell >= vec2<i32>(CELLS)) {
        return false;
    }
    return octave_at(first, cell) == octave;
}

// Edge e is between corners e and e + 1, around the cell. A line enters where heights fall from corner to corner, and
// leaves where they rise: the next cell goes around the same edge the other way.
fn falls(h: vec4<f32>, edge: i32, height_m: f32) -> bool {
    return h[edge] >= height_m && h[(edge + 1) & 3] < height_m;
}

fn exit_of(h: vec4<f32>, enter: i32, height_m: f32) -> i32 {
    let high = h >= vec4<f32>(height_m);
    let is_saddle = high.x == high.z && high.y == high.w && high.x != high.y;
    if is_saddle {
        // The centre of the cell decides whether high corners or low ones are connected.
        return (enter + select(3, 1, dot(h, vec4<f32>(0.25)) >= height_m)) & 3;
    }
    var leave = 0;
    for (var edge = 0; edge < 4; edge++) {
        leave = select(leave, edge, h[edge] < height_m && h[(edge + 1) & 3] >= height_m);
    }
    return leave;
}

fn place_on_edge(h: vec4<f32>, cell: vec2<i32>, edge: i32, height_m: f32) -> vec2<f32> {
    let corner = array<vec2<f32>, 4>(vec2<f32>(0.0, 0.0), vec2<f32>(1.0, 0.0), vec2<f32>(1.0, 1.0), vec2<f32>(0.0, 1.0));
    let a = h[edge];
    let b = h[(edge + 1) & 3];
    return vec2<f32>(cell) + mix(corner[edge], corner[(edge + 1) & 3], (height_m - a) / (b - a));
}

struct Line {
    first: i32,
    octave: i32,
    height_m: f32,
}

// A step along a line: a cell, and the edge by which it is entered.
struct Step {
    cell: vec2<i32>,
    enter: i32,
}

fn after(line: Line, step: Step) -> Step {
    let leave = exit_of(corners(line.first, step.cell), step.enter, line.height_m);
    var next = NEXT;
    return Step(step.cell + next[leave], (leave + 2) & 3);
}

fn number_of(step: Step) -> i32 {
    return (step.cell.y * CELLS + step.cell.x) * 4 + step.enter;
}

// Returns whether a line that continues before `start` is closed, and `start` is its step with the least number.
fn leads(line: Line, start: Step) -> bool {
    let own = number_of(start);
    var step = after(line, start);
    for (var i = 0; i < MAX_STEPS; i++) {
        if !is_active(line.first, step.cell, line.octave) {
            return false;
        }
        let number = number_of(step);
        if number <= own {
            return number == own;
        }
        step = after(line, step);
    }
    return false;
}

fn length_in(frame: Frame, a: vec2<f32>, b: vec2<f32>) -> f32 {
    return length(world_offset(frame, b - a));
}

fn put(slot: u32, number: u32, index: u32, intervals: u32, height: i32, place: vec2<f32>) {
    let at = (slot * MAX_CANDIDATES + number) * WORDS;
    candidates[at + INDEX] = index;
    candidates[at + INTERVALS] = intervals;
    candidates[at + REACH] = 0u;
    candidates[at + HEIGHT] = bitcast<u32>(height);
    candidates[at + SEED] = bitcast<u32>(place.x);
    candidates[at + SEED + 1u] = bitcast<u32>(place.y);
}

// Follows a piece, and places its seeds.
fn sow(block: RowBlock, line: Line, start: Step, height: i32, is_closed: bool) {
    let frame = frame_at(block, vec2<f32>(start.cell) + 0.5);
    let begin = place_on_edge(corners(line.first, start.cell), start.cell, start.enter, line.height_m);
    var length_m = 0.0;
    var intervals = 0u;
    var first = 0u;
    // The first pass measures the length, the second places the seeds.
    for (var turn = 0; turn < 2; turn++) {
        var step = start;
        var place = begin;
        var gone_m = 0.0;
        var laid = 0u;
        for (var i = 0; i < MAX_STEPS; i++) {
            let h = corners(line.first, step.cell);
            let leave = exit_of(h, step.enter, line.height_m);
            let end = place_on_edge(h, step.cell, leave, line.height_m);
            let way_m = length_in(frame, place, end);
            if turn == 1 {
                let interval_m = length_m / f32(intervals);
                while laid < intervals && f32(laid) * interval_m <= gone_m + way_m {
                    let part = clamp((f32(laid) * interval_m - gone_m) / max(way_m, 1e-20), 0.0, 1.0);
                    put(block.slot, first + laid, laid, intervals | select(0u, CLOSED, is_closed), height, mix(place, end, part));
                    laid++;
                }
            }
            gone_m += way_m;
            place = end;
            step = after(line, step);
            if (is_closed && all(step.cell == start.cell) && step.enter == start.enter) || !is_active(line.first, step.cell, line.octave) {
                break;
            }
        }
        if turn == 0 {
            length_m = gone_m;
            // A line that cuts off a corner has no room for a mark.
            let cells = length_m / cell_m(block);
            if cells < 0.5 {
                return;
            }
            intervals = DENSITY * max(u32(round(cells)), 1u);
            let wanted = intervals + select(1u, 0u, is_closed);
            first = atomicAdd(&counts[block.slot], wanted);
            if first + wanted > MAX_CANDIDATES {
                return;
            }
        } else if !is_closed {
            while laid < intervals {
                put(block.slot, first + laid, laid, intervals, height, place);
                laid++;
            }
            let leaves = any(step.cell < vec2<i32>(0)) || any(step.cell >= vec2<i32>(CELLS));
            put(block.slot, first + intervals, intervals | select(0u, ELSEWHERE, leaves), intervals, height, place);
        }
    }
}

// Returns the seed of a single mark in a cell: a random offset, 0 to 1.
fn shaken(cell: vec2<i32>) -> vec2<f32> {
    var word = u32(cell.x) * 0x9e3779b9u + u32(cell.y) * 0x85ebca6bu;
    word = (word ^ (word >> 16u)) * 0x7feb352du;
    word = (word ^ (word >> 15u)) * 0x846ca68bu;
    return vec2<f32>(f32(word & 0xffffu), f32(word >> 16u)) / 65536.0;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let block = jobs[id.y];
    let cell = vec2<i32>(i32(id.x) % CELLS, i32(id.x) / CELLS);
    let first = i32(id.y) * RELIEF;
    let h = corners(first, cell);
    if cell.y >= CELLS {
        return;
    }
    let octave = octave_at(first, cell);
    for (var i = 0; i < select(ALONE_WITH_ROWS, ALONE_WITHOUT_ROWS, octave == 0); i++) {
        let number = atomicAdd(&counts[block.slot], 1u);
        if number < MAX_CANDIDATES {
            put(block.slot, number, 0u, ALONE, 0, vec2<f32>(cell) + shaken(cell + CELLS * i));
        }
    }
    if octave == 0 {
        return;
    }
    let unit_m = cell_m(block) / STEPS;
    let row_m = unit_m * exp2(f32(octave));
    let low = min(min(h.x, h.y), min(h.z, h.w)) / row_m - 0.5;
    let high = max(max(h.x, h.y), max(h.z, h.w)) / row_m - 0.5;
    let rows = vec2<i32>(i32(ceil(low)), i32(floor(high)));
    for (var row = rows.x; row <= min(rows.y, rows.x + MAX_LINES - 1); row++) {
        let height = (2 * row + 1) * (1 << u32(octave - 1));
        let line = Line(first, octave, f32(height) * unit_m);
        for (var enter = 0; enter < 4; enter++) {
            if !falls(h, enter, line.height_m) {
                continue;
            }
            var next = NEXT;
            let start = Step(cell, enter);
            let is_first = !is_active(first, cell + next[enter], octave);
            if is_first || leads(line, start) {
                sow(block, line, start, height, !is_first);
            }
        }
    }
}
