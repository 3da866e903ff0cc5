// Applies the bar to strokes: the pressure falls, so a stroke becomes thinner, then pale, then vanishes. Pressure is
// carried from frame to frame, so that nothing appears or disappears suddenly.
//
// A draughtsman draws a line or does not draw it: the mean along PLACES places to either side decides, and the change
// from drawn to left out is quick.
//
// FOLLOWER: the bars are the leading eye's, read at the sample's position in its picture. Both eyes then omit the same
// strokes; with bars of its own picture each eye would omit different ones.
#import hachure::view::View
#import hachure::crowd::{Crowd, bar_at, remaining_part, capped}
#import hachure::stroke_samples::{Sample, SampleCounts, FIRST, LAST}

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

fn bar_of(number: u32) -> vec2<f32> {
#ifdef FOLLOWER
    let clip = other_view.clip_from_camera * vec4<f32>(samples[number].position_m, 1.0);
    // Points that are off-screen or behind the leading eye are nearer than the range of the cap.
    let ndc = clip.xy / max(clip.w, other_view.near_m);
    return bar_at(other_view, crowd, bars, (ndc * vec2<f32>(0.5, -0.5) + 0.5) * vec2<f32>(other_view.size_px));
#else
    return bar_at(view, crowd, bars, samples[number].px);
#endif
}

// Places along a stroke, and the samples from one to the next: 8 px.
const PLACES: u32 = 6u;
const STRIDE: u32 = 4u;
// Parts of the places with ink between which a stroke goes from left out to drawn.
const DRAWN: vec2<f32> = vec2<f32>(0.35, 0.65);

// Returns whether the stroke is above the bar at a sample, 0 to 1, and the fraction that remains of strokes that are. Of
// the neighbours only members are read that no thread of this pass writes.
fn above_bar(number: u32) -> vec2<f32> {
    let bar = bar_of(number);
    return vec2<f32>(remaining_part(vec2<f32>(bar.x, 1.0), min(samples[number].rank, 1.0)), bar.y);
}

// Returns the mean of `above_bar` along the stroke around sample `number`.
fn above_bar_around(number: u32) -> vec2<f32> {
    var sum = above_bar(number);
    var count = 1.0;
    for (var way = 0u; way < 2u; way++) {
        let ends = select(LAST, FIRST, way == 1u);
        var at = number;
        for (var i = 1u; i <= PLACES * STRIDE && (samples[at].flags & ends) == 0u; i++) {
            at = select(at + 1u, at - 1u, way == 1u);
            if i % STRIDE == 0u {
                sum += above_bar(at);
                count += 1.0;
            }
        }
    }
    return sum / count;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < sample_counts.fresh {
        let own = samples[id.x];
        // Skylines have ranks above 1, and stay.
        let above = above_bar_around(id.x);
        let lowered = mix(above.y * smoothstep(DRAWN.x, DRAWN.y, above.x), 1.0, saturate(own.rank - 1.0));
        let left = mix(1.0, lowered, capped(crowd, own.depth_m));
        // Without pressure a stroke still has a third of its width, so ink falls slower than pressure.
        samples[id.x].pressure = own.pressure * left * left * left;
    }
}
