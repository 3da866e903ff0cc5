// Computes the room on either side of a mark, and the ink that it would have at the requested tone.
//
// A mark of a row knows its room from its neighbours in the row. The distance across to the next mark on the picture
// limits that room where another row or a single mark is near, and is the whole room of a single mark. The ink is
// summed in squares, for `balance`.
#import hachure::rows::{HALF, PROPOSAL, DRAWN, SAMPLES}
#import hachure::row_places::{view, places, rules, proposed, proposals, TAKEN, WALK, CELLS_PER_SPACING, cell_px, word_at}
#import hachure::row_places::{sample_of, across_at, is_seen}
#import hachure::row_ink::{SLENDER, INK_UNIT, square_px, squares_of}

@group(0) @binding(6) var<storage, read_write> inks: array<atomic<u32>>;
@group(0) @binding(7) var tone: texture_2d<f32>;

// Largest distance at which the next mark is searched, in spacings, and the distance that is assumed if there is none.
const FARTHEST: f32 = 1.6;
const ALONE_GAP: f32 = 1.2;
// Largest room of a mark, in widths of the nearer gap.
const OF_NEARER: f32 = 1.5;

// Returns the distance to the next mark on one side, in spacings.
fn gap(own_turn: u32, px: vec2<f32>, across: vec2<f32>) -> f32 {
    for (var t = WALK; t <= FARTHEST * CELLS_PER_SPACING; t += WALK) {
        let word = word_at(px + across * (t * cell_px()));
        if (word & TAKEN) != 0u && word != TAKEN && word != (TAKEN | own_turn) {
            return t / CELLS_PER_SPACING;
        }
    }
    return ALONE_GAP;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let number = id.x;
    if number >= min(atomicLoad(&proposed[0]), rules.max_marks) {
        return;
    }
    let at = number * u32(PROPOSAL);
    let first = proposals[at];
    if first.w != DRAWN {
        return;
    }
    let begin = i32(first.x) % 32;
    let end = i32(first.x) / 32;
    var rooms: array<f32, 17>;
    for (var j = begin; j <= end; j++) {
        let own = sample_of(number, j);
        let across = across_at(number, j, begin, end);
        let gaps = vec2<f32>(gap(u32(first.z), own.xy, across), gap(u32(first.z), own.xy, -across)) * rules.spacing_px;
        let most = OF_NEARER * min(gaps.x, gaps.y);
        rooms[j] = select(min(own.z, most), min(0.5 * (gaps.x + gaps.y), most) * -own.z, own.z < 0.0);
    }
    let size = vec2<i32>(view.size_px);
    // Short marks are narrow.
    var whole_px = 0.0;
    var widest_px = 0.0;
    for (var j = begin; j <= end; j++) {
        let px = sample_of(number, j).xy;
        whole_px += distance(px, sample_of(number, max(j - 1, begin)).xy);
        let dark = 1.0 - textureLoad(tone, clamp(vec2<i32>(floor(px)), vec2<i32>(0), size - 1), 0).a;
        widest_px = max(widest_px, rooms[j] * clamp(dark, 0.0, rules.darkest));
    }
    let slim = min(1.0, whole_px / (SLENDER * max(widest_px, 1e-6)));
    for (var j = begin; j <= end; j++) {
        let own = sample_of(number, j);
        // Smoothed along the mark.
        let room = 0.25 * (rooms[max(j - 1, begin)] + 2.0 * rooms[j] + rooms[min(j + 1, end)]);
        proposals[at + 1u + u32(j)].z = room;
        let pixel = vec2<i32>(floor(own.xy));
        if !is_seen(first, j) || any(pixel < vec2<i32>(0)) || any(pixel >= size) {
            continue;
        }
        let length_px = 0.5 * (distance(own.xy, sample_of(number, min(j + 1, end)).xy) + distance(own.xy, sample_of(number, max(j - 1, begin)).xy));
        let dark = clamp(1.0 - textureLoad(tone, pixel, 0).a, 0.0, rules.darkest);
        let square = pixel / square_px(rules);
        let squares = squares_of(rules, view.size_px);
        atomicAdd(&inks[square.y * squares.x + square.x], u32(dark * room * slim * length_px * INK_UNIT));
    }
}
