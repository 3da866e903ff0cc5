// Computes the number of samples of each stroke: none if it is too short, or too short for the budget.
#import hachure::chain_lengths::{strokes, counts, chain_length_px}
#import hachure::stroke_samples::{class_of, samples_of}

// SampleCounts as words: strokes are the third, then those left out; the least class is the sixth, the chains are the
// seventh.
@group(0) @binding(4) var<storage, read_write> list: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> sizes: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x == 0u {
        atomicStore(&list[6], counts.chains);
    }
    if id.x >= counts.chains {
        return;
    }
    let length_px = chain_length_px(id.x);
    var size = 0u;
    if length_px >= strokes.shortest_px {
        let is_chosen = class_of(length_px) >= atomicLoad(&list[5]);
        size = select(0u, samples_of(length_px), is_chosen);
        atomicAdd(&list[select(3u, 2u, is_chosen)], 1u);
    }
    sizes[id.x] = size;
}
