// Marks of candidates: from its seed each runs up and down the slope to the heights at which its row ends.
//
// Samples stand at even heights, so those of neighbours with the same number are abreast, and their distance is the
// local gap. Between samples a mark follows the gradient of the land's form by two steps of the midpoint rule, by height;
// a step of Newton's method then takes it back to the height that is meant. It ends early where the form is level, where
// rows have another height, and where there is no land.
//
// Beyond the border of its row a mark goes on where no mark of the next row would come: where the land ends to rise, or to
// fall, before the middle of that row. So crests and valleys between rows are not bare.
#import hachure::terrain::{terrain, place_on_level, as_far_as_there}
#import hachure::surface::{Surface, surface_near, form_at}
#import hachure::rows::{RowRules, RowBlock, Frame, CELLS, NODES, SLOPE_CELLS, SLOPE_NODES, RELIEF, STEPS, MOST_CANDIDATES}
#import hachure::rows::{WORDS, HALF, CORE, NO_LAND, cell_m, grid_of, frame_at, octave_of, pack_place, camera_height_m}

// Of a step, in cells.
const LONGEST: f32 = 2.0;
// Beside the block, in cells.
const MARGIN: f32 = 8.0;

@group(0) @binding(0) var<uniform> rules: RowRules;
@group(0) @binding(1) var<storage, read> jobs: array<RowBlock>;
@group(0) @binding(2) var<storage, read> relief: array<f32>;
@group(0) @binding(3) var<storage, read> counts: array<u32>;
@group(0) @binding(4) var<storage, read_write> candidates: array<u32>;

fn octave_at(first: i32, place: vec2<f32>) -> i32 {
    let at_node = (floor(place) + 0.5) / f32(SLOPE_CELLS) + 1.0;
    let node = clamp(vec2<i32>(floor(at_node)), vec2<i32>(0), vec2<i32>(SLOPE_NODES - 2));
    let f = at_node - vec2<f32>(node);
    let at = first + NODES * NODES + node.y * SLOPE_NODES + node.x;
    let slope = mix(mix(relief[at], relief[at + 1], f.x), mix(relief[at + SLOPE_NODES], relief[at + SLOPE_NODES + 1], f.x), f.y);
    return octave_of(slope, rules.row_cells);
}

// Whether marks may be there: cells of the block, as its heights have it; beside it, wherever there is a grid.
fn is_land(first: i32, block: RowBlock, place: vec2<f32>) -> bool {
    let g = grid_of(block, place);
    let low = vec2<f32>(terrain.extent_units.xy) / terrain.units_per_sample;
    let high = vec2<f32>(terrain.extent_units.zw) / terrain.units_per_sample;
    if any(g < low) || any(g > high) || any(place < vec2<f32>(-MARGIN)) || any(place > vec2<f32>(f32(CELLS) + MARGIN)) {
        return false;
    }
    let node = clamp(vec2<i32>(round(place)), vec2<i32>(0), vec2<i32>(NODES - 1));
    return relief[first + node.y * NODES + node.x] != NO_LAND;
}

// Height of the world, and the slope by east and north.
fn form(block: RowBlock, frame: Frame, place: vec2<f32>) -> vec3<f32> {
    let g = grid_of(block, place);
    let wanted = clamp(block.level, 0.0, f32(terrain.level_count - 1));
    let at = form_at(surface_near(g, as_far_as_there(wanted, place_on_level(i32(wanted), g), g)));
    return vec3<f32>(dot(at.gradient, frame.point.dg_dx), dot(at.gradient, frame.point.dg_dy), at.height_m + camera_height_m());
}

// The way in cells along the slope that rises by `rise_m`.
fn way(block: RowBlock, frame: Frame, slope: vec2<f32>, rise_m: f32) -> vec2<f32> {
    let by_m = slope * (rise_m / max(dot(slope, slope), 1e-12));
    return (frame.point.dg_dx * by_m.x + frame.point.dg_dy * by_m.y) / block.cell;
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
    let height = bitcast<i32>(candidates[at + 3u]);
    let unit_m = cell_m(block) / STEPS;
    let middle_m = f32(height) * unit_m;
    // The lowest bit that is set is half of the row.
    let half_row = height & -height;
    let octave = i32(firstTrailingBit(u32(half_row))) + 1;
    let step_m = f32(half_row) * unit_m / f32(CORE);
    let frame = frame_at(block, seed);
    var reach = vec2<u32>(0u);
    candidates[at + 4u + u32(HALF)] = pack_place(seed);
    for (var side = 0; side < 2; side++) {
        let sign = select(-1.0, 1.0, side == 1);
        var place = seed;
        var slope = form(block, frame, place).xy;
        // Clear of the threshold at the seed, a mark may be.
        var goes = length(slope) > rules.level;
        for (var i = 1; i <= 2 * CORE && goes; i++) {
            var next = place;
            for (var part = 0; part < 2; part++) {
                let half = next + 0.25 * way(block, frame, slope, sign * step_m);
                let there = form(block, frame, half).xy;
                next += 0.5 * way(block, frame, there, sign * step_m);
                slope = there;
            }
            let end = form(block, frame, next);
            let wanted_m = middle_m + sign * step_m * f32(i);
            next += way(block, frame, end.xy, wanted_m - end.z);
            slope = form(block, frame, next).xy;
            let gone = distance(next, place);
            goes = length(slope) > rules.level && gone < LONGEST && is_land(first, block, next)
                && octave_at(first, next) == octave && dot(slope, end.xy) > 0.0;
            if goes {
                place = next;
                reach[side] = u32(i);
            }
            if i <= HALF {
                candidates[at + u32(4 + HALF + select(-i, i, side == 1))] = pack_place(place);
            }
        }
        // The next row goes on from here, or what is beyond is too far for this one.
        reach[side] = select(min(reach[side], u32(HALF)), u32(CORE), goes);
        for (var i = i32(reach[side]) + 1; i <= HALF; i++) {
            if i <= HALF {
                candidates[at + u32(4 + HALF + select(-i, i, side == 1))] = pack_place(place);
            }
        }
        // The next row goes on from here, or what is beyond is too far for this one.
        reach[side] = select(min(reach[side], u32(HALF)), u32(CORE), goes);
    }
    candidates[at + 2u] = reach.x | (reach.y << 8u);
}
