// The curve that fits tones to the picture: it sets which tone of the light is left as paper and which is drawn dark,
// and makes near land lighter.
#define_import_path hachure::tone_curve

struct ToneCurve {
    // Tones of the light that become dark, and paper.
    dark: f32,
    white: f32,
    // Binary logarithm of the distance, in metres, within which half of the land in view lies.
    middle_octave: f32,
    // 1 once a frame has been measured, 0 before.
    is_known: f32,
}

// What the style makes of the curve.
struct ToneFit {
    // Values at which the two tones of the curve are placed; tones beyond them continue to 0 and 1.
    low: f32,
    high: f32,
    // Part of its darkness that the nearest land loses.
    recede: f32,
    pad: f32,
}

// Octaves of distance below the middle at which land begins to be foreground, and at which it is all foreground.
const NEAR_BEGINS: f32 = 0.25;
const NEAR_ENDS: f32 = 2.0;

// Returns how much land at a distance from the eye is foreground, from 0 to 1.
fn foreground_part(curve: ToneCurve, distance_m: f32) -> f32 {
    return curve.is_known * smoothstep(NEAR_BEGINS, NEAR_ENDS, curve.middle_octave - log2(max(distance_m, 1e-3)));
}

// Returns the fitted tone of light at a distance from the eye.
fn fitted(curve: ToneCurve, fit: ToneFit, lit: f32, distance_m: f32) -> f32 {
    if curve.is_known == 0.0 {
        return lit;
    }
    let along = (lit - curve.dark) / max(curve.white - curve.dark, 1e-3);
    let placed = clamp(mix(fit.low, fit.high, along), 0.0, 1.0);
    return 1.0 - (1.0 - placed) * (1.0 - fit.recede * foreground_part(curve, distance_m));
}
