// Computes the number of samples of each stroke: none if it is too short, or too short for the budget.
//
// Longer strokes come first. Each workgroup finds the shortest length class for which there is room.
#import hachure::chain_lengths::{strokes, counts, chain_length_px}
#import hachure::stroke_samples::{CLASSES, Temporal, arguments_of, class_of}

// `SampleCounts` as an array of words, because its members cannot be atomic. budget.wgsl has set them to 0.
@group(0) @binding(4) var<storage, read_write> sample_counts: array<atomic<u32>>;
// Samples that each stroke needs, as budget.wgsl decided.
@group(0) @binding(5) var<storage, read_write> sizes: array<u32>;
// Samples that the strokes of each length class need.
@group(0) @binding(6) var<storage, read> classes: array<u32>;
// Arguments of draws and dispatches; see `arguments_of`.
@group(0) @binding(7) var<storage, read_write> draws: array<u32, 16>;
@group(0) @binding(8) var<uniform> temporal: Temporal;

// Indices of the members of `SampleCounts` in `sample_counts`.
const SAMPLES: u32 = 0u;
const FRESH: u32 = 1u;
const STROKES: u32 = 2u;
const LEFT_OUT: u32 = 3u;
const SHORTEST_CLASS: u32 = 5u;
const CHAINS: u32 = 6u;

var<workgroup> shortest_class: u32;

// Finds the shortest class, for one thread of each workgroup; the first of all also sets the counters.
fn choose(is_first: bool) {
    var total = 0u;
    var shortest = CLASSES;
    for (var i = CLASSES; i > 0u; i--) {
        let needed = classes[i - 1u];
        // If even the longest class exceeds the capacity, as many of its strokes are drawn as fit.
        let has_room = total + needed <= temporal.capacity || total == 0u;
        if has_room && shortest == i {
            total += needed;
            shortest = i - 1u;
        }
    }
    shortest_class = shortest;
    if is_first {
        let fresh = min(total, temporal.capacity);
        atomicStore(&sample_counts[SAMPLES], fresh);
        atomicStore(&sample_counts[FRESH], fresh);
        atomicStore(&sample_counts[SHORTEST_CLASS], shortest);
        atomicStore(&sample_counts[CHAINS], counts.chains);
        draws = arguments_of(fresh, fresh);
    }
}

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    if thread == 0u {
        choose(id.x == 0u);
    }
    workgroupBarrier();
    if id.x >= counts.chains {
        return;
    }
    if sizes[id.x] == 0u {
        return;
    }
    let is_chosen = class_of(chain_length_px(id.x)) >= shortest_class;
    atomicAdd(&sample_counts[select(LEFT_OUT, STROKES, is_chosen)], 1u);
    if !is_chosen {
        sizes[id.x] = 0u;
    }
}
