// Counts the tones of the light on the land in view, and its distances, on every fourth pixel in each direction. Water
// and sky do not count; land counts as much as haze and focus leave of its contrast.
#import hachure::view::distance_from_eye
#import hachure::light::haze_clear
#import hachure::lit_surface::{view, light}
#import hachure::land_tone::land_tone
#import hachure::tone_counts::{BINS, WORDS, LEAST_OCTAVE, OCTAVES_PER_BIN}

// Weights of the bins of tones, then of those of distances.
@group(0) @binding(8) var<storage, read_write> tone_counts: array<atomic<u32>>;

// Pixels from one that is measured to the next.
const STEP_PX: u32 = 4u;
// Weight of a pixel whose contrast is whole.
const WHOLE: f32 = 16.0;

var<workgroup> counts: array<atomic<u32>, WORDS>;

fn bin_of(part: f32) -> u32 {
    return min(u32(max(part, 0.0)), BINS - 1u);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    for (var word = index; word < WORDS; word += 64u) {
        atomicStore(&counts[word], 0u);
    }
    workgroupBarrier();
    // A picture of few pixels is measured on its last row or column.
    let pixel = vec2<i32>(min(id.xy * STEP_PX + STEP_PX / 2u, view.size_px - 1u));
    let seen = land_tone(pixel);
    if all(id.xy * STEP_PX < view.size_px) && seen.is_land {
        let away_m = distance_from_eye(view, seen.at.xyz);
        let weight = u32(max(1.0, round(WHOLE * haze_clear(light, away_m) * seen.surface.clear)));
        atomicAdd(&counts[bin_of(seen.tone * f32(BINS))], weight);
        atomicAdd(&counts[BINS + bin_of((log2(max(away_m, 1e-3)) - LEAST_OCTAVE) / OCTAVES_PER_BIN)], u32(WHOLE));
    }
    workgroupBarrier();
    for (var word = index; word < WORDS; word += 64u) {
        let count = atomicLoad(&counts[word]);
        if count > 0u {
            atomicAdd(&tone_counts[word], count);
        }
    }
}
