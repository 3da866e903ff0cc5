// What the bar leaves of strokes: the pen is pressed less, so a stroke is thinner, then pale, then gone. It is carried
// from frame to frame as all pressure is, so that nothing comes or goes at once.
#import hachure::view::View
#import hachure::crowd::{Crowd, bar_at, left_of}
#import hachure::stroke_samples::{Sample, SampleCounts}

// Not moved.
@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> crowd: Crowd;
@group(0) @binding(2) var bars: texture_2d<f32>;
@group(0) @binding(3) var<storage, read> list: SampleCounts;
@group(0) @binding(4) var<storage, read_write> samples: array<Sample>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < list.fresh {
        let own = samples[id.x];
        let left = left_of(bar_at(view, crowd, bars, own.px), own.rank);
        // A stroke has a third of its width where the pen is hardly pressed: ink goes slower than pressure.
        samples[id.x].pressure = own.pressure * left * left * left;
    }
}
