// Temporal anti-aliasing: the picture is the mean of frames with subpixel jitter (Karis 2014, High-Quality Temporal
// Supersampling; Yang, Liu and Salvi 2020, A Survey of Temporal Antialiasing Techniques).
//
// Each pixel fetches the history at the position that its content had in the previous frame, by Catmull-Rom
// interpolation, so that a long flight does not blur it. The motion is that of the nearest surface within a pixel,
// since a line covers both sides of its edge. A frame's weight in the mean is 2 / (age + 2), so that the weight of
// early frames falls as the square of the age.
//
// Changes: history is fully clamped to the frame's 3 × 3 neighbourhood only where another surface was visible before.
// On the same surface the clamp is partial: a line that one sample misses and the next one hits would otherwise flicker
// as if there were no history. Distance identifies the surface: motion is exact, so a surface is either where it is
// expected or was not visible. A picture at rest is not clamped at all, and becomes the mean of its samples.
//
// The paper's grain is fixed to the sheet and does not move with the content, so it is applied after the mean. So are
// strokes (STROKES): their borders are antialiased and they follow the world by themselves, and repeated interpolation
// would only degrade them. Half of their ink is from the history, which removes flicker.
#import hachure::view::{View, motion_of, ray_of_pixel}
#import hachure::seen::place_seen
#import hachure::color::hash
#import hachure::paper::{bordered, paper_grain}

struct TemporalAa {
    // 1: there is a previous frame.
    has_history: u32,
    // Weight of this frame if the previous one had the same view of the same world; else 0.
    rest_weight: f32,
    // Strength of the paper's grain.
    grain: f32,
    // Number of the frame.
    frame: i32,
    stroke_ink: vec3<f32>,
    // 1: the sheet has a margin or a border, whose widths are `border_px`.
    is_bordered: u32,
    paper: vec3<f32>,
    // Part of a difference to the neighbourhood that is retained on the same surface.
    kept: f32,
    border: vec3<f32>,
    pad_border: f32,
    border_px: vec2<f32>,
    // Height of the bare paper below the picture.
    foot_px: f32,
    pad_px: f32,
    // Size of the previous frame's pictures.
    history_px: vec2<f32>,
    pad_history: vec2<f32>,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> temporal_aa: TemporalAa;
// This frame: linear colour, and in the fourth channel the ink of lines.
@group(0) @binding(2) var sample_picture: texture_2d<f32>;
@group(0) @binding(3) var distance_m: texture_2d<f32>;
// Motion from the previous frame to this one, in pixels.
@group(0) @binding(4) var motion: texture_2d<f32>;
#ifdef STROKES
// Ink of strokes in this frame.
@group(0) @binding(5) var ink: texture_2d<f32>;
#endif
@group(0) @binding(6) var history_before: texture_2d<f32>;
// For the nearest surface within a pixel: log2 of its distance along the view axis, its age, and the ink of strokes.
@group(0) @binding(7) var seen_before: texture_2d<f32>;
@group(0) @binding(8) var history: texture_storage_2d<rgba16float, write>;
@group(0) @binding(9) var seen: texture_storage_2d<rgba16float, write>;
@group(0) @binding(10) var picture: texture_storage_2d<rgba16float, write>;

// Limits the age, so that in a flight a sixth of the picture is new: older content has been interpolated too often to
// be sharp.
const MAX_AGE: f32 = 10.0;
// A contour slides over its surface as the eye moves. Below the first motion per frame `kept` applies fully, above the
// second not at all.
const SLOW_PX: f32 = 0.25;
const QUICK_PX: f32 = 1.0;
// From QUICK_PX to this motion the weight of the new frame rises, up to NEW_FAST: fast motion shows blur, not flicker.
const FAST_PX: f32 = 6.0;
const NEW_FAST: f32 = 0.75;
// Largest difference of log2 distance on the same surface: 3 % of the distance.
const SAME: f32 = 0.04;
// log2 of the distance that represents the sky.
const SKY: f32 = 100.0;
// Weight of this frame in the ink of strokes.
const NEW_INK: f32 = 0.5;

// The history at a position.
struct Before {
    drawn: vec4<f32>,
    ink: f32,
    // Number of frames for which the surface has been visible there; -1 if another one was.
    age: f32,
}

// Interpolates the history by Catmull-Rom. The result may overshoot, without which thin lines would fade.
fn drawn_before(place_now: vec2<f32>, distance: f32) -> Before {
    let place = place_now * (temporal_aa.history_px / vec2<f32>(view.size_px));
    let last = vec2<i32>(temporal_aa.history_px) - 1;
    let corner = vec2<i32>(floor(place - 0.5));
    let f = place - 0.5 - vec2<f32>(corner);
    let weights = array<vec2<f32>, 4>(
        f * (-0.5 + f * (1.0 - 0.5 * f)),
        1.0 + f * f * (-2.5 + 1.5 * f),
        f * (0.5 + f * (2.0 - 1.5 * f)),
        f * f * (-0.5 + 0.5 * f),
    );
    var before = Before(vec4<f32>(0.0), 0.0, -1.0);
    for (var y = 0; y < 4; y++) {
        for (var x = 0; x < 4; x++) {
            let pixel = clamp(corner + vec2<i32>(x, y) - 1, vec2<i32>(0), last);
            let weight = weights[x].x * weights[y].y;
            before.drawn += textureLoad(history_before, pixel, 0) * weight;
            let is_middle = x % 3 != 0 && y % 3 != 0;
#ifdef STROKES
            let was = textureLoad(seen_before, pixel, 0);
            before.ink += was.z * weight;
#else
            var was = vec4<f32>(-SKY);
            if is_middle {
                was = textureLoad(seen_before, pixel, 0);
            }
#endif
            if is_middle && abs(was.x - distance) <= SAME {
                before.age = max(before.age, was.y);
            }
        }
    }
    before.drawn = max(before.drawn, vec4<f32>(0.0));
    before.ink = clamp(before.ink, 0.0, 1.0);
    return before;
}

// Returns log2 of a distance.
fn log_of(depth_m: f32) -> f32 {
    return log2(max(depth_m, 1e-6));
}

// Rounds to 16 bits, up or down at random. Otherwise a mean that takes little of each frame would stop changing, or
// drift down on drivers that truncate.
fn dithered(mean: vec4<f32>, pixel: vec2<i32>) -> vec4<f32> {
    let unit = exp2(floor(log2(max(mean, vec4<f32>(1e-4)))) - 10.0);
    return floor(mean / unit + hash(pixel + vec2<i32>(7919 * temporal_aa.frame, 0))) * unit;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let last = vec2<i32>(view.size_px) - 1;
    let now = textureLoad(sample_picture, pixel, 0);
    var least = now;
    var most = now;
    // The nearest surface around the pixel, and the pixel that shows it.
    var nearest = pixel;
    var distance = SKY;
    for (var i = 0; i < 9; i++) {
        let around = clamp(pixel + vec2<i32>(i % 3, i / 3) - 1, vec2<i32>(0), last);
        let drawn = textureLoad(sample_picture, around, 0);
        least = min(least, drawn);
        most = max(most, drawn);
        let depth_m = textureLoad(distance_m, around, 0).r;
        if depth_m > 0.0 && log_of(depth_m) < distance {
            distance = log_of(depth_m);
            nearest = around;
        }
    }
    var mean = now;
    var age = 0.0;
    var strokes = 0.0;
#ifdef STROKES
    strokes = textureLoad(ink, pixel, 0).r;
#endif
    if temporal_aa.rest_weight > 0.0 {
        age = MAX_AGE;
        mean = mix(textureLoad(history_before, pixel, 0), now, temporal_aa.rest_weight);
    } else if temporal_aa.has_history == 1u {
        let moved_px = textureLoad(motion, nearest, 0).xy;
        let place = vec2<f32>(pixel) + 0.5 - moved_px;
        if all(place >= vec2<f32>(0.0)) && all(place < vec2<f32>(view.size_px)) {
            let at = place_seen(view, distance_m, nearest);
            let was_m = (view.previous_clip_from_camera * vec4<f32>(at.xyz, 1.0)).w;
            let before = drawn_before(place, select(SKY, log_of(was_m), at.w > 0.0));
            let is_same = before.age >= 0.0;
            // Motion that is due to the eye's translation, without its rotation.
            let turned_px = motion_of(view, nearest, vec4<f32>(ray_of_pixel(view, nearest), 0.0));
            let slid_px = length(moved_px - turned_px);
            let kept = select(0.0, temporal_aa.kept * (1.0 - smoothstep(SLOW_PX, QUICK_PX, slid_px)), is_same);
            let clamped = mix(clamp(before.drawn, least, most), before.drawn, kept);
            age = min(before.age + 1.0, MAX_AGE);
            let hurry = smoothstep(QUICK_PX, FAST_PX, length(moved_px));
            mean = mix(clamped, now, max(2.0 / (age + 2.0), hurry * NEW_FAST));
            strokes = mix(strokes, before.ink, select(0.0, 1.0 - mix(NEW_INK, 1.0, hurry), is_same));
        }
    }
    textureStore(history, pixel, dithered(mean, pixel));
    textureStore(seen, pixel, vec4<f32>(distance, age, strokes, 0.0));
    let sheet = vec2<f32>(pixel + view.origin_px);
    var grain = 0.0;
    if temporal_aa.grain > 0.0 {
        grain = temporal_aa.grain * paper_grain(sheet);
    }
    var color = mix(mean.rgb * (1.0 + grain), temporal_aa.stroke_ink, strokes);
    if temporal_aa.is_bordered == 1u {
        let bare = temporal_aa.paper * (1.0 + grain);
        color = bordered(color, bare, temporal_aa.border, temporal_aa.border_px, temporal_aa.foot_px, sheet + 0.5, view.picture_px);
    }
    textureStore(picture, pixel, vec4<f32>(color, 1.0));
}
