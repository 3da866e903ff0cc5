// The bar that a line's rank must reach to be drawn, for each cell. It is set so that the lines above it have no more
// ink than the style allows, in a window of four cells to a side.
//
// Ink is summed from the highest rank down until the limit is reached. Within the last step of ranks the bar is
// interpolated as if ink were distributed evenly. If the lines of the highest step alone are too many, they become
// paler. A single stroke never counts as a crowd, however broad.
#import hachure::view::View
#import hachure::crowd::{Crowd, first_cell, BINS, CELL_WORDS, UNITS, SOFT}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> crowd: Crowd;
@group(0) @binding(2) var<storage, read> counts: array<u32>;
// The bar, and the part that is left of lines above it.
@group(0) @binding(3) var bars: texture_storage_2d<rgba32float, write>;

const REACH: i32 = 2;
// Lowest rank of lines that are not short fragments.
const MIN_RANK: f32 = 0.25;
// Length of a stroke that crosses the window diagonally, in sides of the window.
const THROUGH: f32 = 1.4;
// Least area assumed for a window that the border cuts, as a part of the whole window.
const MIN_AREA: f32 = 0.6;

// Returns the number of pixels of a cell on the target.
fn area_of(cell: vec2<i32>) -> f32 {
    let first = (cell + first_cell(view, crowd)) * i32(crowd.cell_px) - view.origin_px;
    let low = max(first, vec2<i32>(0));
    let side = max(min(first + i32(crowd.cell_px), vec2<i32>(view.size_px)) - low, vec2<i32>(0));
    return f32(side.x * side.y);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= crowd.cells) {
        return;
    }
    let cell = vec2<i32>(id.xy);
    var inks: array<f32, BINS>;
    var area = 0.0;
    var broadest_px = 0.0;
    for (var y = max(-REACH, -cell.y); y <= min(REACH, i32(crowd.cells.y) - 1 - cell.y); y++) {
        for (var x = max(-REACH, -cell.x); x <= min(REACH, i32(crowd.cells.x) - 1 - cell.x); x++) {
            // Outer cells count half: the window has four cells to a side.
            let weight = select(1.0, 0.5, abs(x) == REACH) * select(1.0, 0.5, abs(y) == REACH);
            let around = vec2<u32>(cell + vec2<i32>(x, y));
            area += weight * area_of(vec2<i32>(around));
            let first = (around.y * crowd.cells.x + around.x) * CELL_WORDS;
            for (var bin = 0u; bin < BINS; bin++) {
                inks[bin] += weight / UNITS * f32(counts[first + bin]);
            }
            broadest_px = max(broadest_px, weight / UNITS * f32(counts[first + BINS]));
        }
    }
    // In a corner of the sheet, a single broad stroke that leaves the sheet does not count as a crowd.
    let whole = f32(16u * crowd.cell_px * crowd.cell_px);
    let lone = broadest_px * THROUGH * f32(4u * crowd.cell_px);
    let room = max(crowd.most * max(area, MIN_AREA * whole), lone);
    // Where all lines fit, the bar is below all ranks.
    var bar = -SOFT;
    var above = 0.0;
    for (var bin = i32(BINS) - 1; bin >= 0; bin--) {
        let ink = inks[bin];
        if above + ink > room {
            // The part of this bin's ink that fits.
            let part = (room - above) / max(ink, 1e-6);
            bar = (f32(bin) + 1.0 - part) / f32(BINS);
            break;
        }
        above += ink;
    }
    // Short fragments are dropped where there is nearly enough ink without them, before lines become paler.
    var all = 0.0;
    for (var bin = 0u; bin < BINS; bin++) {
        all += inks[bin];
    }
    bar = max(bar, mix(-SOFT, MIN_RANK, smoothstep(0.5, 1.0, all / max(room, 1e-6))));
    // Ranks end at 1, so lines that no bar can exclude become paler.
    var left = 0.0;
    for (var bin = 0u; bin < BINS; bin++) {
        let rank = (f32(bin) + 0.5) / f32(BINS);
        left += inks[bin] * smoothstep(bar - SOFT, bar + SOFT, rank);
    }
    textureStore(bars, cell, vec4<f32>(bar, min(1.0, room / max(left, 1e-6)), 0.0, 0.0));
}
