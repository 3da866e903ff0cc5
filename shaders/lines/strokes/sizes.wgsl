// Computes the number of samples of each stroke: none if it is too short, or too short for the budget.
#import hachure::chain_lengths::{strokes, counts, chain_length_px}
#import hachure::stroke_samples::{class_of, samples_of}

// `SampleCounts` as an array of words, because its members cannot be atomic.
@group(0) @binding(4) var<storage, read_write> sample_counts: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> sizes: array<u32>;

// Indices of the members of `SampleCounts` in `sample_counts`.
const STROKES: u32 = 2u;
const LEFT_OUT: u32 = 3u;
const SHORTEST_CLASS: u32 = 5u;
const CHAINS: u32 = 6u;

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x == 0u {
        atomicStore(&sample_counts[CHAINS], counts.chains);
    }
    if id.x >= counts.chains {
        return;
    }
    let length_px = chain_length_px(id.x);
    var size = 0u;
    if length_px >= strokes.shortest_px {
        let is_chosen = class_of(length_px) >= atomicLoad(&sample_counts[SHORTEST_CLASS]);
        size = select(0u, samples_of(length_px), is_chosen);
        atomicAdd(&sample_counts[select(LEFT_OUT, STROKES, is_chosen)], 1u);
    }
    sizes[id.x] = size;
}
