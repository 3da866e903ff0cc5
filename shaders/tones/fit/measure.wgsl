// Counts the tones of the light on the land in view, and its distances, on every fourth pixel in each direction. Water
// and sky do not count; land counts as much as haze and focus leave of its contrast.
#import hachure::view::distance_from_eye
#import hachure::seen::place_seen
#import hachure::light::haze_clear
#import hachure::lit_surface::{lit_surface, view, light, distance_m}
#import hachure::lit_tone::lit_tone
#import hachure::tone_counts::{BINS, WORDS, LEAST_OCTAVE, OCTAVES_PER_BIN}

// Whether the tone comes from light that emphasises relief, and whether crests are lighter. They are no uniform, since a
// pass has at most three (docs/decisions/software-drivers.md).
#ifdef RELIEF
const HAS_RELIEF: bool = true;
#else
const HAS_RELIEF: bool = false;
#endif
#ifdef CRESTS
const HAS_CRESTS: bool = true;
#else
const HAS_CRESTS: bool = false;
#endif

// Weights of the bins of tones, then of those of distances.
@group(0) @binding(8) var<storage, read_write> tone_counts: array<atomic<u32>>;
#ifdef WATER
// See surface/water.wgsl.
@group(0) @binding(9) var water: texture_2d<f32>;
#endif

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
    var is_land = all(id.xy * STEP_PX < view.size_px);
    let at = place_seen(view, distance_m, pixel);
    is_land = is_land && at.w > 0.0;
#ifdef WATER
    is_land = is_land && textureLoad(water, pixel, 0).r <= 0.0;
#endif
    if is_land {
        let surface = lit_surface(pixel, at);
        let lit = lit_tone(surface, pixel, HAS_RELIEF, HAS_CRESTS);
        let away_m = distance_from_eye(view, at.xyz);
        let weight = u32(max(1.0, round(WHOLE * haze_clear(light, away_m) * surface.clear)));
        atomicAdd(&counts[bin_of(lit * f32(BINS))], weight);
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
