// Finds the shortest length class of strokes for which there is room, if longer strokes come first.
#import hachure::stroke_samples::{CLASSES, Temporal, SampleCounts, arguments_of}

@group(0) @binding(0) var<uniform> temporal: Temporal;
// Samples that the strokes of each length class need; this pass resets them to 0.
@group(0) @binding(1) var<storage, read_write> classes: array<u32>;
@group(0) @binding(2) var<storage, read_write> sample_counts: SampleCounts;
// Arguments of draws and dispatches; see `arguments_of`.
@group(0) @binding(3) var<storage, read_write> draws: array<u32, 16>;

@compute @workgroup_size(1)
fn main() {
    var total = 0u;
    var shortest_class = CLASSES;
    for (var i = CLASSES; i > 0u; i--) {
        let needed = classes[i - 1u];
        classes[i - 1u] = 0u;
        // If even the longest class exceeds the capacity, as many of its strokes are drawn as fit.
        let has_room = total + needed <= temporal.capacity || total == 0u;
        if has_room && shortest_class == i {
            total += needed;
            shortest_class = i - 1u;
        }
    }
    sample_counts = SampleCounts();
    sample_counts.fresh = min(total, temporal.capacity);
    sample_counts.samples = sample_counts.fresh;
    sample_counts.shortest_class = shortest_class;
    draws = arguments_of(sample_counts.fresh, sample_counts.fresh);
}
