// Turns lengths of the previous frame's samples into pixels of this frame's picture, which has another size.
#import hachure::view::View
#import hachure::stroke_samples::{Temporal, Sample, SampleCounts}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> temporal: Temporal;
@group(0) @binding(2) var<storage, read> old_sample_counts: SampleCounts;
@group(0) @binding(3) var<storage, read_write> old_samples: array<Sample>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= old_sample_counts.samples {
        return;
    }
    var own = old_samples[id.x];
    let scale = vec2<f32>(view.size_px) / vec2<f32>(temporal.last_px);
    own.px *= scale;
    own.held_px *= scale;
    own.along_px *= scale.y;
    own.half_width_px *= scale.y;
    own.length_px *= scale.y;
    old_samples[id.x] = own;
}
