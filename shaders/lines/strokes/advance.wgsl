// Moves strokes with the world between full updates. Pietrok (2021, section 4.3) moves them by the motion field; here
// each sample knows its distance, so its own motion is exact.
#import hachure::view::{View, place_at}
#import hachure::stroke_samples::{Temporal, Sample, SampleCounts, decayed, arguments_of, FIRST, LAST, FADING, IS_CLOSED, SPACING_PX, WHOLLY_PX}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> temporal: Temporal;
@group(0) @binding(2) var<storage, read> old_sample_counts: SampleCounts;
@group(0) @binding(3) var<storage, read> old_samples: array<Sample>;
@group(0) @binding(4) var<storage, read_write> sample_counts: SampleCounts;
@group(0) @binding(5) var<storage, read_write> samples: array<Sample>;
// Arguments of draws and dispatches; see `arguments_of`.
@group(0) @binding(6) var<storage, read_write> draws: array<u32, 16>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x == 0u {
        sample_counts = old_sample_counts;
        draws = arguments_of(old_sample_counts.fresh, old_sample_counts.samples);
    }
    if id.x >= old_sample_counts.samples {
        return;
    }
    var own = old_samples[id.x];
    own.position_m += temporal.step_m;
    let clip = view.clip_from_camera * vec4<f32>(own.position_m, 1.0);
    // Samples behind the eye keep a valid position; the shader of strokes omits them.
    let ndc = clip.xy / max(clip.w, 1e-6);
    if temporal.rests == 0u {
        own.px = (ndc * vec2<f32>(0.5, -0.5) + 0.5) * vec2<f32>(view.size_px);
        own.depth_m = clip.w;
    }
    if any(own.held_px != vec2<f32>(0.0)) {
        let left_px = decayed(own.held_px, temporal.hold);
        own.px += left_px - own.held_px;
        own.held_px = left_px;
        own.position_m = place_at(view, own.px, own.depth_m);
    }
    if (own.flags & FADING) != 0u {
        own.shown_px -= temporal.growth_px;
    } else {
        own.shown_px = min(own.shown_px + temporal.growth_px, to_end_px(id.x));
    }
    samples[id.x] = own;
}

// Returns the distance to the stroke's end, at most WHOLLY_PX, as samples.wgsl does.
fn to_end_px(number: u32) -> f32 {
    if (old_samples[number].flags & IS_CLOSED) != 0u {
        return WHOLLY_PX;
    }
    for (var i = 0u; f32(i) * SPACING_PX < WHOLLY_PX; i++) {
        let is_first = i <= number && (old_samples[number - min(i, number)].flags & FIRST) != 0u;
        let is_last = number + i < old_sample_counts.samples && (old_samples[number + i].flags & LAST) != 0u;
        if is_first || is_last {
            return f32(i) * SPACING_PX + 0.5;
        }
    }
    return WHOLLY_PX;
}
