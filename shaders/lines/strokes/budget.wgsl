// How many samples strokes of each class of length want, longest first.
#import hachure::strokes::{Chain, StrokeCounts}
#import hachure::stroke_edges::Strokes
#import hachure::stroke_samples::{class_of, samples_of}

@group(0) @binding(0) var<uniform> strokes: Strokes;
@group(0) @binding(1) var<storage, read> counts: StrokeCounts;
@group(0) @binding(2) var<storage, read> chains: array<Chain>;
// Arc length at each point since the first of all, in 1/16 px.
@group(0) @binding(3) var<storage, read> along_units: array<u32>;
@group(0) @binding(4) var<storage, read_write> classes: array<atomic<u32>>;

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= counts.chains {
        return;
    }
    let chain = chains[id.x];
    let first = chain.first + id.x;
    let length_px = f32(along_units[first + chain.count] - along_units[first]) / 16.0;
    if length_px >= strokes.shortest_px {
        atomicAdd(&classes[class_of(length_px)], samples_of(length_px));
    }
}
