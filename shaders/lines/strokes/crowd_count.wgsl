// Computes the rank of each sample of a stroke, and adds its ink to the cells.
//
// Half of the rank is the step in distance across the stroke, as for lines of pixels (lines/crowd/rank.wgsl), but
// averaged along 16 px to either side: a pen is not lifted for a notch. The other half is the stroke's length. A skyline
// has a rank above 1: 2 where there is only sky behind the samples around it. It is counted, and never left out.
#import hachure::view::View
#import hachure::crowd::{Crowd, cell_at, bin_of, capped, BINS, CELL_WORDS, UNITS}
#import hachure::stroke_samples::{LEAST_HALF_WIDTH_PX, Sample, SampleCounts, FIRST, LAST, NEIGHBOURS}

// The view without jitter; the depth is jittered.
@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> crowd: Crowd;
// Reversed depth: near / distance; 0 is the sky.
@group(0) @binding(2) var depth: texture_depth_2d;
@group(0) @binding(3) var<storage, read> sample_counts: SampleCounts;
@group(0) @binding(4) var<storage, read_write> samples: array<Sample>;
// CELL_WORDS for each cell.
@group(0) @binding(5) var<storage, read_write> counts: array<atomic<u32>>;

// Relative step in distance that counts half.
const STEP: f32 = 0.05;
const AROUND_PX: f32 = 2.5;
const TURNS: u32 = 8u;

// Returns the step around a position, and 1 if the sky is behind it.
fn step_at(px: vec2<f32>) -> vec2<f32> {
    let last = vec2<i32>(view.size_px) - 1;
    var nearness = vec2<f32>(1e30, 0.0);
    for (var i = 0u; i < TURNS; i++) {
        let angle = 6.2831853 * f32(i) / f32(TURNS);
        let around = px + view.jitter_px + AROUND_PX * vec2<f32>(cos(angle), sin(angle));
        let near = textureLoad(depth, clamp(vec2<i32>(floor(around)), vec2<i32>(0), last), 0);
        nearness = vec2<f32>(min(nearness.x, near), max(nearness.y, near));
    }
    let step = 1.0 - nearness.x / max(nearness.y, 1e-30);
    return vec2<f32>(step / (step + STEP), f32(nearness.x == 0.0));
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= sample_counts.fresh {
        return;
    }
    let own = samples[id.x];
    var steps = step_at(own.px);
    var count = 1.0;
    for (var way = 0u; way < 2u; way++) {
        let ends = select(LAST, FIRST, way == 1u);
        var at = id.x;
        for (var i = 0u; i < NEIGHBOURS && (samples[at].flags & ends) == 0u; i++) {
            at = select(at + 1u, at - 1u, way == 1u);
            steps += step_at(samples[at].px);
            count += 1.0;
        }
    }
    let window_px = 4.0 * f32(crowd.cell_px);
    let mean = steps / count;
    let skyline = smoothstep(0.25, 0.75, mean.y);
    let rank = select(0.5 * (mean.x + own.length_px / (own.length_px + 2.0 * window_px)), 1.0 + skyline, skyline > 0.0);
    samples[id.x].rank = rank;
    if (own.flags & LAST) != 0u || any(own.px < vec2<f32>(0.0)) || any(own.px >= vec2<f32>(view.size_px)) {
        return;
    }
    let wide_px = min(2.0 * max(own.half_width_px, LEAST_HALF_WIDTH_PX) * own.pressure * capped(crowd, own.depth_m), 1e3);
    let ink_px = distance(own.px, samples[id.x + 1u].px) * wide_px;
    let cell = vec2<u32>(cell_at(view, crowd, own.px));
    let first = (cell.y * crowd.cells.x + cell.x) * CELL_WORDS;
    atomicAdd(&counts[first + bin_of(rank)], u32(round(min(ink_px, 1e3) * UNITS)));
    atomicMax(&counts[first + BINS], u32(round(wide_px * UNITS)));
}
