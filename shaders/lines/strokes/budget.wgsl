// Counts the samples that the strokes of each length class need, and begins the counters of samples.
#import hachure::chain_lengths::{strokes, counts, chain_length_px}
#import hachure::stroke_samples::{SampleCounts, class_of, samples_of}

// samples.wgsl resets them to 0.
@group(0) @binding(4) var<storage, read_write> classes: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> sample_counts: SampleCounts;

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x == 0u {
        sample_counts = SampleCounts();
    }
    if id.x >= counts.chains {
        return;
    }
    let length_px = chain_length_px(id.x);
    if length_px >= strokes.shortest_px {
        atomicAdd(&classes[class_of(length_px)], samples_of(length_px));
    }
}
