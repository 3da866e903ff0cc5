// Appends the samples of fading strokes after those of this frame. They shrink from their ends, and from points
// SEEDS_PX apart, just as strokes grow (temporal.wgsl).
//
// `stage` 0 marks the samples that are retained, for the prefix sum that follows; 1 moves them with the world, puts
// them into the list, and sets their number in the list and in the draw arguments.
#import hachure::view::View
#import hachure::stroke_samples::{Temporal, Sample, SampleCounts, FIRST, LAST, FADING, RUNS_OFF, SPACING_PX, NEIGHBOURS, ALL_GROUPS, to_seed_px, groups_of}

@group(0) @binding(0) var<uniform> stage: u32;
@group(0) @binding(1) var<uniform> view: View;
@group(0) @binding(2) var<uniform> temporal: Temporal;
@group(0) @binding(3) var<storage, read> old_sample_counts: SampleCounts;
@group(0) @binding(4) var<storage, read> old_samples: array<Sample>;
@group(0) @binding(5) var<storage, read> gone: array<u32>;
@group(0) @binding(6) var<storage, read_write> places: array<u32>;
@group(0) @binding(7) var<storage, read_write> sample_counts: SampleCounts;
@group(0) @binding(8) var<storage, read_write> samples: array<Sample>;
// Arguments of draws and dispatches; see `arguments_of`.
@group(0) @binding(9) var<storage, read_write> draws: array<u32, 16>;

// Returns whether the segment from a sample to the next one is retained.
fn is_kept(number: u32) -> bool {
    if number + 1u >= old_sample_counts.samples || (old_samples[number].flags & LAST) != 0u {
        return false;
    }
    return gone[number] == 0u || gone[number + 1u] == 0u;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let count = select(0u, old_sample_counts.samples, temporal.has_history == 1u);
    if stage == 1u && id.x == 0u {
        let fading = select(0u, min(places[count], temporal.capacity - sample_counts.fresh), count > 0u);
        sample_counts.samples = sample_counts.fresh + fading;
        draws[5] = fading;
        draws[ALL_GROUPS] = groups_of(sample_counts.fresh + fading);
    }
    if id.x >= count {
        return;
    }
    let runs_on = is_kept(id.x);
    let came = id.x > 0u && is_kept(id.x - 1u);
    if stage == 0u {
        places[id.x] = u32(runs_on || came);
        return;
    }
    let place = sample_counts.fresh + places[id.x];
    if !(runs_on || came) || place >= temporal.capacity {
        return;
    }
    var own = old_samples[id.x];
    own.position_m += temporal.step_m;
    let clip = view.clip_from_camera * vec4<f32>(own.position_m, 1.0);
    let ndc = clip.xy / max(clip.w, 1e-6);
    own.px = (ndc * vec2<f32>(0.5, -0.5) + 0.5) * vec2<f32>(view.size_px);
    own.depth_m = clip.w;
    own.shown_px = shrunk_px(id.x);
    own.flags = (own.flags & ~(FIRST | LAST | RUNS_OFF)) | FADING;
    own.flags |= select(0u, FIRST, !came) | select(0u, LAST, !runs_on || place + 1u == temporal.capacity);
    samples[place] = own;
}

fn shrunk_px(number: u32) -> f32 {
    let own = old_samples[number];
    var left_px = min(own.shown_px, 0.5 * temporal.growth_px + to_seed_px(own.along_px));
    // In both directions, as far as the stroke is retained. Where something else covers the rest, the end counts as one
    // segment farther, so that what is retained for a single sample does not vanish at once.
    for (var way = 0u; way < 2u; way++) {
        var at = number;
        for (var i = 0u; i <= NEIGHBOURS; i++) {
            let apart_px = SPACING_PX * f32(i);
            left_px = min(left_px, old_samples[at].shown_px + apart_px);
            if !select(is_kept(at), at > 0u && is_kept(at - 1u), way == 1u) {
                left_px = min(left_px, apart_px + SPACING_PX);
                break;
            }
            at = select(at + 1u, at - 1u, way == 1u);
        }
    }
    return left_px - temporal.growth_px;
}
