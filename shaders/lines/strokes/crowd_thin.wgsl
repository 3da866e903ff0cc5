// What the bar leaves of strokes: the pen is pressed less, so a stroke is thinner, then pale, then gone. It is carried
// from frame to frame as all pressure is, so that nothing comes or goes at once.
//
// FOLLOWER: the bars are the leading eye's, read where its picture has the sample. Both eyes then leave out the same
// strokes; with bars of its own picture each eye had other ones.
#import hachure::view::View
#import hachure::crowd::{Crowd, bar_at, left_of, capped}
#import hachure::stroke_samples::{Sample, SampleCounts}

// Not moved.
@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> crowd: Crowd;
@group(0) @binding(2) var bars: texture_2d<f32>;
@group(0) @binding(3) var<storage, read> list: SampleCounts;
@group(0) @binding(4) var<storage, read_write> samples: array<Sample>;
#ifdef FOLLOWER
// Of the leading eye.
@group(0) @binding(5) var<uniform> other_view: View;
#endif

fn bar_of(own: Sample) -> vec2<f32> {
#ifdef FOLLOWER
    let clip = other_view.clip_from_camera * vec4<f32>(own.position_m, 1.0);
    // What the leading eye has beside it or behind is nearer than any cap holds.
    let ndc = clip.xy / max(clip.w, other_view.near_m);
    return bar_at(other_view, crowd, bars, (ndc * vec2<f32>(0.5, -0.5) + 0.5) * vec2<f32>(other_view.size_px));
#else
    return bar_at(view, crowd, bars, own.px);
#endif
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < list.fresh {
        let own = samples[id.x];
        let left = mix(1.0, left_of(bar_of(own), own.rank), capped(crowd, own.depth_m));
        // A stroke has a third of its width where the pen is hardly pressed: ink goes slower than pressure.
        samples[id.x].pressure = own.pressure * left * left * left;
    }
}
