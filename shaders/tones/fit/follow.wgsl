// Moves the curve of the tones toward the one that fits the counted tones, so slowly that no tone of the picture
// changes faster than a bound; a new scene gets its curve at once.
#import hachure::tone_counts::{BINS, LEAST_OCTAVE, OCTAVES_PER_BIN}
#import hachure::tone_curve::ToneCurve

struct Follow {
    // Parts of the land that are to be dark, and paper.
    dark_share: f32,
    white_share: f32,
    // Least difference of the two tones: the light is not spread farther.
    least_span: f32,
    // Fraction of the way that the curve moves in this frame, and the largest change of a tone.
    part: f32,
    most: f32,
    // Largest change of the middle distance, in octaves.
    most_octaves: f32,
    // 1: the curve begins anew.
    begins: u32,
    pad: u32,
}

@group(0) @binding(0) var<uniform> follow: Follow;
@group(0) @binding(1) var<storage, read> tone_counts: array<u32>;
@group(0) @binding(2) var<storage, read_write> tone_curve: ToneCurve;

// Returns the position, in bins, below which a part of the counts from `first` on lies.
fn quantile(first: u32, part: f32) -> f32 {
    var all = 0.0;
    for (var bin = 0u; bin < BINS; bin++) {
        all += f32(tone_counts[first + bin]);
    }
    var below = 0.0;
    for (var bin = 0u; bin < BINS; bin++) {
        let here = f32(tone_counts[first + bin]);
        if below + here >= part * all && here > 0.0 {
            return f32(bin) + (part * all - below) / here;
        }
        below += here;
    }
    return -1.0;
}

@compute @workgroup_size(1)
fn main() {
    let darkest = quantile(0u, follow.dark_share) / f32(BINS);
    let middle = quantile(BINS, 0.5);
    if darkest < 0.0 || middle < 0.0 {
        // There is no land in view.
        if follow.begins != 0u {
            tone_curve.is_known = 0.0;
        }
        return;
    }
    let lightest = quantile(0u, 1.0 - follow.white_share) / f32(BINS);
    // Where the light hardly varies, the lightest land stays paper.
    let white = max(lightest, follow.least_span);
    let dark = min(darkest, white - follow.least_span);
    let middle_octave = LEAST_OCTAVE + OCTAVES_PER_BIN * middle;
    let last = tone_curve;
    if follow.begins != 0u || last.is_known == 0.0 {
        tone_curve = ToneCurve(dark, white, middle_octave, 1.0);
        return;
    }
    let most = follow.most * (last.white - last.dark);
    let octaves = follow.most_octaves;
    tone_curve = ToneCurve(
        last.dark + clamp(follow.part * (dark - last.dark), -most, most),
        last.white + clamp(follow.part * (white - last.white), -most, most),
        last.middle_octave + clamp(follow.part * (middle_octave - last.middle_octave), -octaves, octaves),
        1.0,
    );
}
