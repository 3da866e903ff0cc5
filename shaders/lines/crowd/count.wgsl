// Counts the ink of each rank in each cell.
#import hachure::view::View
#import hachure::crowd::{Crowd, first_cell, bin_of, BINS, CELL_WORDS, UNITS}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> crowd: Crowd;
@group(0) @binding(2) var line: texture_2d<f32>;
@group(0) @binding(3) var rank: texture_2d<f32>;
// CELL_WORDS for each cell. Lines of pixels are narrow, so their width is not stored.
@group(0) @binding(4) var<storage, read_write> counts: array<u32>;

var<workgroup> sums: array<atomic<u32>, BINS>;

// One workgroup per cell.
@compute @workgroup_size(8, 8)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>) {
    let number = local.y * 8u + local.x;
    if number < BINS {
        atomicStore(&sums[number], 0u);
    }
    workgroupBarrier();
    let cell = vec2<i32>(group.xy) + first_cell(view, crowd);
    let first = cell * i32(crowd.cell_px) - view.origin_px;
    let low = max(first, vec2<i32>(0));
    let high = min(first + i32(crowd.cell_px), vec2<i32>(view.size_px));
    for (var y = low.y + i32(local.y); y < high.y; y += 8) {
        for (var x = low.x + i32(local.x); x < high.x; x += 8) {
            let ink = textureLoad(line, vec2<i32>(x, y), 0).r;
            if ink > 0.0 {
                let own = textureLoad(rank, vec2<i32>(x, y), 0).rg;
                atomicAdd(&sums[bin_of(own.x)], u32(round(ink * own.y * UNITS)));
            }
        }
    }
    workgroupBarrier();
    if number < CELL_WORDS {
        let sum = select(0u, atomicLoad(&sums[min(number, BINS - 1u)]), number < BINS);
        counts[(group.y * crowd.cells.x + group.x) * CELL_WORDS + number] = sum;
    }
}
