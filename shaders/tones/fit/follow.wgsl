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
    // How far the shares may be from those of the style, and at most by half of them, so that few places have the tone
    // at the border of a step: the border is then where tones change most, on ridges and in gullies. 0: not at all.
    give: f32,
}

// Bins on each side of a tone over which counts are averaged.
const AROUND: u32 = 2u;

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

// Returns the position, in bins, below which about a part of the counts lies: the one with the fewest counts around it, as
// far as its part is near the one that is asked for.
fn gap(part: f32) -> f32 {
    let exact = quantile(0u, part);
    // There is land on both sides of a gap.
    let give = min(follow.give, 0.5 * min(part, 1.0 - part));
    if give <= 0.0 || exact < 0.0 {
        return exact;
    }
    var all = 0.0;
    for (var bin = 0u; bin < BINS; bin++) {
        all += f32(tone_counts[bin]);
    }
    var best = exact;
    var least = 1e30;
    var below = 0.0;
    for (var bin = AROUND; bin <= BINS - AROUND; bin++) {
        var around = 0.0;
        below = 0.0;
        for (var other = 0u; other < BINS; other++) {
            let here = f32(tone_counts[other]);
            below += select(0.0, here, other < bin);
            around += select(0.0, here, other + AROUND >= bin && other < bin + AROUND);
        }
        let off = (below / all - part) / give;
        // A part that is as far off as allowed is chosen only if no place has its tone.
        let cost = (around / all + 1e-3) / max(1.0 - off * off, 1e-6);
        if abs(off) < 1.0 && cost < least {
            least = cost;
            best = f32(bin);
        }
    }
    return best;
}

@compute @workgroup_size(1)
fn main() {
    let darkest = gap(follow.dark_share) / f32(BINS);
    let middle = quantile(BINS, 0.5);
    if darkest < 0.0 || middle < 0.0 {
        // There is no land in view.
        if follow.begins != 0u {
            tone_curve.is_known = 0.0;
        }
        return;
    }
    let lightest = gap(1.0 - follow.white_share) / f32(BINS);
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
