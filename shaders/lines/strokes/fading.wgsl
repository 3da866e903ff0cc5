// Finds the samples of the previous frame's strokes that are gone; the others stay, and fade.
//
// A sample is gone if a new stroke runs where it is now (within COVERED_PX, in the same direction), if the surface
// hides it, if it has left the picture, or if it has shrunk to nothing. Segments with at least one end that is not gone
// are retained.
#import hachure::view::View
#import hachure::stroke_samples::{Temporal, Sample, SampleCounts, nearest_on, LAST}

// The view without jitter; the depth is jittered.
@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> temporal: Temporal;
@group(0) @binding(2) var<storage, read> old_sample_counts: SampleCounts;
@group(0) @binding(3) var<storage, read> old_samples: array<Sample>;
@group(0) @binding(4) var<storage, read> samples: array<Sample>;
// Number of this frame's sample, plus 1.
@group(0) @binding(5) var ids: texture_2d<u32>;
// Reversed depth: near / distance; 0 is the sky.
@group(0) @binding(6) var depth: texture_depth_2d;
@group(0) @binding(7) var<storage, read_write> gone: array<u32>;

const COVERED_PX: f32 = 1.5;
const MIN_COSINE: f32 = 0.6;
// A sample is hidden if it is behind the surface by more than this part of its distance.
const HIDDEN: f32 = 0.01;

fn on_picture(at_m: vec3<f32>) -> vec3<f32> {
    let clip = view.clip_from_camera * vec4<f32>(at_m, 1.0);
    let ndc = clip.xy / max(clip.w, 1e-6);
    return vec3<f32>((ndc * vec2<f32>(0.5, -0.5) + 0.5) * vec2<f32>(view.size_px), clip.w);
}

fn is_gone(number: u32) -> bool {
    let own = old_samples[number];
    if own.shown_px <= -0.5 {
        return true;
    }
    let at = on_picture(own.position_m + temporal.step_m);
    let size = vec2<i32>(view.size_px);
    if at.z < view.near_m || any(at.xy < vec2<f32>(0.0)) || any(at.xy >= vec2<f32>(size)) {
        return true;
    }
    let is_last = (own.flags & LAST) != 0u;
    let next = old_samples[select(number + 1u, max(number, 1u) - 1u, is_last)];
    let way = normalize(on_picture(next.position_m + temporal.step_m).xy - at.xy + vec2<f32>(1e-6, 0.0));
    let middle = vec2<i32>(floor(at.xy));
    let seen = vec2<i32>(floor(at.xy + view.jitter_px));
    var farthest = 1.0;
    for (var i = 0; i < 49; i++) {
        let offset = vec2<i32>(i % 7, i / 7) - 3;
        let pixel = middle + offset;
        if any(pixel < vec2<i32>(0)) || any(pixel >= size) {
            continue;
        }
        if all(abs(offset) <= vec2<i32>(1)) {
            farthest = min(farthest, textureLoad(depth, clamp(seen + offset, vec2<i32>(0), size - 1), 0));
        }
        let id = textureLoad(ids, pixel, 0).r;
        if id == 0u {
            continue;
        }
        let a = samples[id - 1u];
        let b = samples[id];
        let near = nearest_on(a.px, b.px, at.xy);
        let cosine = dot(normalize(b.px - a.px + vec2<f32>(1e-6, 0.0)), way);
        if distance(near.px, at.xy) <= COVERED_PX && abs(cosine) >= MIN_COSINE {
            return true;
        }
    }
    return at.z * (1.0 - HIDDEN) > view.near_m / max(farthest, 1e-30);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < old_sample_counts.samples && temporal.has_history == 1u {
        gone[id.x] = u32(is_gone(id.x));
    }
}
