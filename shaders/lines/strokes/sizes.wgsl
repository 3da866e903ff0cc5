// How many samples each stroke gets: none if it is short, or shorter than the budget has room for.
#import hachure::strokes::{Chain, StrokeCounts}
#import hachure::stroke_edges::Strokes
#import hachure::stroke_samples::{class_of, samples_of}

@group(0) @binding(0) var<uniform> strokes: Strokes;
@group(0) @binding(1) var<storage, read> counts: StrokeCounts;
@group(0) @binding(2) var<storage, read> chains: array<Chain>;
@group(0) @binding(3) var<storage, read> along_units: array<u32>;
// SampleCounts: strokes are the third number, then those left out, the class is the sixth.
@group(0) @binding(4) var<storage, read_write> list: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> sizes: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= counts.chains {
        return;
    }
    let chain = chains[id.x];
    let first = chain.first + id.x;
    let length_px = f32(along_units[first + chain.count] - along_units[first]) / 16.0;
    var size = 0u;
    if length_px >= strokes.shortest_px {
        let is_chosen = class_of(length_px) >= atomicLoad(&list[5]);
        size = select(0u, samples_of(length_px), is_chosen);
        atomicAdd(&list[select(3u, 2u, is_chosen)], 1u);
    }
    sizes[id.x] = size;
}
