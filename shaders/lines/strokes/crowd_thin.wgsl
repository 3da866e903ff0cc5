// Applies the bar to strokes: the pressure falls, so a stroke becomes thinner, then pale, then vanishes. Pressure is
// carried from frame to frame, so that nothing appears or disappears suddenly.
//
// FOLLOWER: the bars are the leading eye's, read at the sample's position in its picture. Both eyes then omit the same
// strokes; with bars of its own picture each eye would omit different ones.
#import hachure::view::View
#import hachure::crowd::{Crowd, bar_at, remaining_part, capped}
#import hachure::stroke_samples::{Sample, SampleCounts}

// The view without jitter.
@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> crowd: Crowd;
@group(0) @binding(2) var bars: texture_2d<f32>;
@group(0) @binding(3) var<storage, read> sample_counts: SampleCounts;
@group(0) @binding(4) var<storage, read_write> samples: array<Sample>;
#ifdef FOLLOWER
// The leading eye's view.
@group(0) @binding(5) var<uniform> other_view: View;
#endif

fn bar_of(own: Sample) -> vec2<f32> {
#ifdef FOLLOWER
    let clip = other_view.clip_from_camera * vec4<f32>(own.position_m, 1.0);
    // Points that are off-screen or behind the leading eye are nearer than the range of the cap.
    let ndc = clip.xy / max(clip.w, other_view.near_m);
    return bar_at(other_view, crowd, bars, (ndc * vec2<f32>(0.5, -0.5) + 0.5) * vec2<f32>(other_view.size_px));
#else
    return bar_at(view, crowd, bars, own.px);
#endif
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < sample_counts.fresh {
        let own = samples[id.x];
        let left = mix(1.0, remaining_part(bar_of(own), own.rank), capped(crowd, own.depth_m));
        // Without pressure a stroke still has a third of its width, so ink falls slower than pressure.
        samples[id.x].pressure = own.pressure * left * left * left;
    }
}
