// Combines paper, sky, tones, haze, focus and inks into the picture.
//
// SKY: the sky is drawn. INK_0 and on: the frame has so many inks. LINES: one of them is that of detected lines. GRAIN:
// the paper has grain. BORDERED: the sheet has a margin or a border.
#import hachure::focus::{Focus, in_focus, half_of_focus, focus_width}
#import hachure::view::{View, above_horizon, distance_from_eye, ray_of_pixel}
#import hachure::seen::place_seen
#import hachure::paper::{bordered, paper_grain}

// Ink of one colour, over the tones and over the inks before it.
struct Ink {
    // Linear colour.
    color: vec3<f32>,
    // Fraction of the ink that remains in full haze.
    faintest: f32,
    // Channel mask: 1 for the channel of the picture that holds the ink, 0 for the others.
    channel_mask: vec4<f32>,
    // How many times farther than tones the ink reaches into the haze.
    reach: f32,
    // ALREADY_FADED, ON_SURFACE, ON_SURFACE_WITH_TONE or ON_NEAREST.
    fading: u32,
    // 1: the first three channels are families of lines that cross each other.
    is_crossed: u32,
}

// The layer's own passes have already faded the ink.
const ALREADY_FADED: u32 = 0u;
// The ink fades with the surface below it.
const ON_SURFACE: u32 = 1u;
// The ink fades with the surface below it, but away from the focus only by the square root of the focus, because its
// amount follows the tone, which has faded already.
const ON_SURFACE_WITH_TONE: u32 = 2u;
// The ink fades with the nearest surface around it (detected lines, which cover both sides of an edge).
const ON_NEAREST: u32 = 3u;

struct Composite {
    paper: vec3<f32>,
    // Distance at which haze has taken 63 % of the contrast.
    haze_m: f32,
    sky_zenith: vec3<f32>,
    // Strength of the paper's grain, with GRAIN.
    grain: f32,
    sky_horizon: vec3<f32>,
    // Fraction of a tone that remains in full haze, 0 to 1.
    faintest_tone: f32,
    haze: vec3<f32>,
    // 1: the picture is one sample of the temporal mean, and its fourth channel is the ink of detected lines.
    is_sample: u32,
    // Linear colour of ruled lines and outlines in the sky.
    sky_ink: vec3<f32>,
    pad_a: u32,
    // Linear colour of the border, whose width and that of the margin are `border_px`.
    border: vec3<f32>,
    // Height of the bare paper below the picture.
    foot_px: f32,
    border_px: vec2<f32>,
    // Cosine and sine of the dip of the horizon, its angle below horizontal.
    horizon: vec2<f32>,
    // Linear colour that tones far from the focus approach.
    unfocused: vec3<f32>,
    inks: array<Ink, 13>,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> composite: Composite;
@group(0) @binding(2) var distance_m: texture_2d<f32>;
@group(0) @binding(3) var tone: texture_2d<f32>;
@group(0) @binding(4) var<storage, read> focus: Focus;
#ifdef SKY
// A drawn sky: linear colour, and the ink of its lines.
@group(0) @binding(5) var sky: texture_2d<f32>;
#endif
// Linear colour; alpha is 1, or in a sample the ink of detected lines.
@group(0) @binding(6) var picture: texture_storage_2d<rgba16float, write>;
// The pictures that hold the inks, from the bottom to the top; as many are bound as the frame has inks.
#ifdef INK_0
@group(0) @binding(7) var ink_0: texture_2d<f32>;
#endif
#ifdef INK_1
@group(0) @binding(8) var ink_1: texture_2d<f32>;
#endif
#ifdef INK_2
@group(0) @binding(9) var ink_2: texture_2d<f32>;
#endif
#ifdef INK_3
@group(0) @binding(10) var ink_3: texture_2d<f32>;
#endif
#ifdef INK_4
@group(0) @binding(11) var ink_4: texture_2d<f32>;
#endif
#ifdef INK_5
@group(0) @binding(12) var ink_5: texture_2d<f32>;
#endif
#ifdef INK_6
@group(0) @binding(13) var ink_6: texture_2d<f32>;
#endif
#ifdef INK_7
@group(0) @binding(14) var ink_7: texture_2d<f32>;
#endif
#ifdef INK_8
@group(0) @binding(15) var ink_8: texture_2d<f32>;
#endif
#ifdef INK_9
@group(0) @binding(16) var ink_9: texture_2d<f32>;
#endif
#ifdef INK_10
@group(0) @binding(17) var ink_10: texture_2d<f32>;
#endif
#ifdef INK_11
@group(0) @binding(18) var ink_11: texture_2d<f32>;
#endif
#ifdef INK_12
@group(0) @binding(19) var ink_12: texture_2d<f32>;
#endif

// Returns the fraction of the contrast that haze leaves at a distance; `reach` is how many times farther than tones the
// ink reaches.
fn clearness(distance_m: f32, reach: f32) -> f32 {
    let t = distance_m / (composite.haze_m * reach);
    return exp(-t * t);
}

#ifdef LINES
// Returns the nearest surface point among a pixel and its eight neighbours, and its distance in the fourth component. A
// line at the pixel belongs to that surface: a silhouette belongs to the occluding one. Without a line the loop ends
// early, since a software driver runs both sides of a branch.
fn nearest_surface(pixel: vec2<i32>, has_line: bool) -> vec4<f32> {
    let last = vec2<i32>(view.size_px) - 1;
    let last_row = select(-1, 1, has_line);
    var nearest = vec4<f32>(vec3<f32>(0.0), 1e30);
    for (var y = -1; y <= last_row; y++) {
        for (var x = -1; x <= 1; x++) {
            let at = place_seen(view, distance_m, clamp(pixel + vec2<i32>(x, y), vec2<i32>(0), last));
            if at.w > 0.0 {
                let distance_m = distance_from_eye(view, at.xyz);
                nearest = select(nearest, vec4<f32>(at.xyz, distance_m), distance_m < nearest.w);
            }
        }
    }
    return nearest;
}
#endif

// The values on which the inks of a pixel depend.
struct Place {
    pixel: vec2<i32>,
    // Position on the whole sheet, in pixels.
    sheet_px: vec2<f32>,
    is_sky: bool,
    // Distance from the eye.
    distance_m: f32,
    // Fraction of the contrast of tones that haze leaves.
    clear: f32,
    // Fraction of the contrast that the focus leaves.
    focused: f32,
    // The surface that a detected line belongs to: its point, and its distance from the eye.
    nearest: vec4<f32>,
}

#ifdef LINES
// Returns what is left of the ink of a detected line. A line covers both sides of its edge; in the distance the farther
// side fades, so that lines are thin. Away from the focus the palest ink, that at the sides of a line, is cut off, so
// that lines are thinner there.
fn line_left(ink: Ink, drawn: f32, place: Place) -> f32 {
    if drawn <= 0.0 {
        return 0.0;
    }
    let nearest = place.nearest;
    let clear = clearness(nearest.w, ink.reach);
    let focused = in_focus(focus, view, nearest.xyz, place.sheet_px);
    let is_behind = place.is_sky || place.distance_m > 1.01 * nearest.w;
    let side = select(1.0, clear, is_behind);
    let lost = 1.0 - focus_width(focused);
    let kept = max(drawn - lost, 0.0) / (1.0 - lost);
    return kept * side * mix(ink.faintest, 1.0, clear) * half_of_focus(focused);
}

// Returns the ink of a detected line at a texel of the picture of ink `i`; 0 if that is another ink.
fn line_ink(i: u32, texel: vec4<f32>) -> f32 {
    return select(0.0, dot(texel, composite.inks[i].channel_mask), composite.inks[i].fading == ON_NEAREST);
}
#endif

// Returns a colour with ink `i` drawn over it; `texel` is that of the ink's picture.
fn inked(color: vec3<f32>, i: u32, texel: vec4<f32>, place: Place) -> vec3<f32> {
    let ink = composite.inks[i];
    let bare = 1.0 - texel.rgb;
    var amount = select(dot(texel, ink.channel_mask), 1.0 - bare.r * bare.g * bare.b, ink.is_crossed == 1u);
    if ink.fading != ALREADY_FADED && ink.fading != ON_NEAREST && !place.is_sky {
        // Most inks reach as far as tones, whose clearness is known.
        let clear = select(clearness(place.distance_m, ink.reach), place.clear, ink.reach == 1.0);
        let focused = select(place.focused, half_of_focus(place.focused), ink.fading == ON_SURFACE_WITH_TONE);
        amount *= mix(ink.faintest, 1.0, clear) * focused;
    }
#ifdef LINES
    if ink.fading == ON_NEAREST {
        amount = line_left(ink, amount, place);
    }
#endif
    return mix(color, ink.color, amount);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let at = place_seen(view, distance_m, pixel);
    let shaded = textureLoad(tone, pixel, 0);
    let sheet = vec2<f32>(pixel + view.origin_px);
    var place = Place(pixel, sheet + 0.5, at.w <= 0.0, 0.0, 1.0, 1.0, vec4<f32>(0.0));
    var color: vec3<f32>;
    if place.is_sky {
#ifdef SKY
        color = textureLoad(sky, pixel, 0).rgb;
#else
        let up = above_horizon(normalize(ray_of_pixel(view, pixel)).z, composite.horizon);
        color = mix(composite.sky_horizon, composite.sky_zenith, clamp(up * 2.0, 0.0, 1.0));
#endif
    } else {
        place.distance_m = distance_from_eye(view, at.xyz);
        place.clear = clearness(place.distance_m, 1.0);
        place.focused = in_focus(focus, view, at.xyz, place.sheet_px);
        color = mix(composite.haze, shaded.rgb, mix(composite.faintest_tone, 1.0, place.clear));
        color = select(mix(composite.unfocused, color, place.focused), color, place.focused == 1.0);
    }
    color *= composite.paper;
#ifdef GRAIN
    let grain = 1.0 + composite.grain * paper_grain(sheet);
    color *= grain;
#endif
#ifdef SKY
    if place.is_sky {
        color = mix(color, composite.sky_ink, textureLoad(sky, pixel, 0).a);
    }
#endif
#ifdef INK_0
    let texel_0 = textureLoad(ink_0, pixel, 0);
#endif
#ifdef INK_1
    let texel_1 = textureLoad(ink_1, pixel, 0);
#endif
#ifdef INK_2
    let texel_2 = textureLoad(ink_2, pixel, 0);
#endif
#ifdef INK_3
    let texel_3 = textureLoad(ink_3, pixel, 0);
#endif
#ifdef INK_4
    let texel_4 = textureLoad(ink_4, pixel, 0);
#endif
#ifdef INK_5
    let texel_5 = textureLoad(ink_5, pixel, 0);
#endif
#ifdef INK_6
    let texel_6 = textureLoad(ink_6, pixel, 0);
#endif
#ifdef INK_7
    let texel_7 = textureLoad(ink_7, pixel, 0);
#endif
#ifdef INK_8
    let texel_8 = textureLoad(ink_8, pixel, 0);
#endif
#ifdef INK_9
    let texel_9 = textureLoad(ink_9, pixel, 0);
#endif
#ifdef INK_10
    let texel_10 = textureLoad(ink_10, pixel, 0);
#endif
#ifdef INK_11
    let texel_11 = textureLoad(ink_11, pixel, 0);
#endif
#ifdef INK_12
    let texel_12 = textureLoad(ink_12, pixel, 0);
#endif
#ifdef LINES
    var line = 0.0;
#ifdef INK_0
    line = max(line, line_ink(0u, texel_0));
#endif
#ifdef INK_1
    line = max(line, line_ink(1u, texel_1));
#endif
#ifdef INK_2
    line = max(line, line_ink(2u, texel_2));
#endif
#ifdef INK_3
    line = max(line, line_ink(3u, texel_3));
#endif
#ifdef INK_4
    line = max(line, line_ink(4u, texel_4));
#endif
#ifdef INK_5
    line = max(line, line_ink(5u, texel_5));
#endif
#ifdef INK_6
    line = max(line, line_ink(6u, texel_6));
#endif
#ifdef INK_7
    line = max(line, line_ink(7u, texel_7));
#endif
#ifdef INK_8
    line = max(line, line_ink(8u, texel_8));
#endif
#ifdef INK_9
    line = max(line, line_ink(9u, texel_9));
#endif
#ifdef INK_10
    line = max(line, line_ink(10u, texel_10));
#endif
#ifdef INK_11
    line = max(line, line_ink(11u, texel_11));
#endif
#ifdef INK_12
    line = max(line, line_ink(12u, texel_12));
#endif
    place.nearest = nearest_surface(pixel, line > 0.0);
#endif
#ifdef INK_0
    color = inked(color, 0u, texel_0, place);
#endif
#ifdef INK_1
    color = inked(color, 1u, texel_1, place);
#endif
#ifdef INK_2
    color = inked(color, 2u, texel_2, place);
#endif
#ifdef INK_3
    color = inked(color, 3u, texel_3, place);
#endif
#ifdef INK_4
    color = inked(color, 4u, texel_4, place);
#endif
#ifdef INK_5
    color = inked(color, 5u, texel_5, place);
#endif
#ifdef INK_6
    color = inked(color, 6u, texel_6, place);
#endif
#ifdef INK_7
    color = inked(color, 7u, texel_7, place);
#endif
#ifdef INK_8
    color = inked(color, 8u, texel_8, place);
#endif
#ifdef INK_9
    color = inked(color, 9u, texel_9, place);
#endif
#ifdef INK_10
    color = inked(color, 10u, texel_10, place);
#endif
#ifdef INK_11
    color = inked(color, 11u, texel_11, place);
#endif
#ifdef INK_12
    color = inked(color, 12u, texel_12, place);
#endif
#ifdef BORDERED
#ifdef GRAIN
    let bare = composite.paper * grain;
#else
    let bare = composite.paper;
#endif
    color = bordered(color, bare, composite.border, composite.border_px, composite.foot_px, sheet + 0.5, view.picture_px);
#endif
    // The alpha of a sample is the ink of detected lines before haze, because distant lines are lines as well.
    var alpha = 1.0;
    if composite.is_sample == 1u {
#ifdef LINES
        alpha = line;
#else
        alpha = 0.0;
#endif
    }
    textureStore(picture, pixel, vec4<f32>(color, alpha));
}
