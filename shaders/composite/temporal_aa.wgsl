// Temporal anti-aliasing: the picture is the mean of frames whose content is moved by parts of a pixel (Karis 2014,
// High-Quality Temporal Supersampling; Yang, Liu and Salvi 2020, A Survey of Temporal Antialiasing Techniques).
//
// Each pixel fetches what was drawn where its content was in the frame before, by Catmull and Rom's cubic, so that a
// long flight does not blur it. The motion is that of the nearest surface within a pixel, for a line lies on both sides
// of its edge. The mean takes 2 / (age + 2) of a frame, so that the first ones are forgotten as the square of the age.
//
// What we changed: what was drawn is clamped to what the frame has in the 3 × 3 pixels around only where another surface
// was seen before. On the same surface the clamp takes a part: a line that one sample misses, and the next one finds,
// would else come and go as quickly as without a history. Distances tell the surface: motion is exact, so a surface is
// where it is expected or was not seen. A picture at rest is not clamped at all, and becomes the mean of its samples.
//
// The grain of the paper is fixed to the sheet and does not move with what is drawn: it is laid over the mean. So are
// strokes (STROKES): they cover their borders exactly and follow their world by themselves, and would only lose by being
// fetched from between pixels again and again. Of their ink just the half is new, which takes the flicker out of it.
#import hachure::view::{View, motion_of, ray_of_pixel}
#import hachure::color::hash
#import hachure::paper::{bordered, paper_grain}

struct TemporalAa {
    // 1: there is a frame before.
    has_history: u32,
    // Of this frame, if the one before had the same view of the same world; else 0.
    rest_weight: f32,
    // How much of the paper's grain shows.
    grain: f32,
    // The number of the frame.
    frame: i32,
    stroke_ink: vec3<f32>,
    // 1: the sheet has a margin or a border, of so many pixels.
    is_bordered: u32,
    paper: vec3<f32>,
    pad_paper: f32,
    border: vec3<f32>,
    pad_border: f32,
    border_px: vec2<f32>,
    // Of bare paper below the picture.
    foot_px: f32,
    pad_px: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> temporal_aa: TemporalAa;
// This frame: linear colour, and in the fourth channel the ink of lines.
@group(0) @binding(2) var sample_picture: texture_2d<f32>;
@group(0) @binding(3) var position: texture_2d<f32>;
// Pixels from the previous frame to this one.
@group(0) @binding(4) var motion: texture_2d<f32>;
#ifdef STROKES
// In this frame.
@group(0) @binding(5) var ink: texture_2d<f32>;
#endif
@group(0) @binding(6) var history_before: texture_2d<f32>;
// Of the nearest surface within a pixel, log2 of its distance along the view axis; the age; the ink of strokes.
@group(0) @binding(7) var seen_before: texture_2d<f32>;
@group(0) @binding(8) var history: texture_storage_2d<rgba16float, write>;
@group(0) @binding(9) var seen: texture_storage_2d<rgba16float, write>;
@group(0) @binding(10) var picture: texture_storage_2d<rgba16float, write>;

// In a flight a sixth of the picture is new: what is older was fetched from between pixels too often to be sharp.
const MOST_AGE: f32 = 10.0;
// What is left of the difference to what is around, on the same surface.
const KEPT: f32 = 0.85;
// A contour slides over its surface as the eye goes on: so much motion in a frame leaves all, and nothing, of that.
const SLOW_PX: f32 = 0.25;
const QUICK_PX: f32 = 1.0;
// From QUICK_PX to this more of the picture is new, since there is not the time to see flicker, but blur: up to NEW_FAST.
const FAST_PX: f32 = 6.0;
const NEW_FAST: f32 = 0.75;
// At the same distance: to 3 % of it.
const SAME: f32 = 0.04;
// log2 of the distance of the sky.
const SKY: f32 = 100.0;
// Of the ink of strokes.
const NEW_INK: f32 = 0.5;

// What was drawn at a place.
struct Before {
    drawn: vec4<f32>,
    ink: f32,
    // How long the surface has been seen there: -1 if it was another one.
    age: f32,
}

// Catmull and Rom's cubic through what was drawn. It may swing beyond that: thin lines would else become faint.
fn drawn_before(place: vec2<f32>, distance: f32) -> Before {
    let last = vec2<i32>(view.size_px) - 1;
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

// log2 of a distance.
fn log_of(depth_m: f32) -> f32 {
    return log2(max(depth_m, 1e-6));
}

// Rounded to 16 bits, up or down by chance: a mean that takes little of a frame would else stand still, or sink where
// a driver cuts bits off.
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
    // The nearest surface around, and which pixel shows it.
    var nearest = pixel;
    var distance = SKY;
    for (var i = 0; i < 9; i++) {
        let around = clamp(pixel + vec2<i32>(i % 3, i / 3) - 1, vec2<i32>(0), last);
        let drawn = textureLoad(sample_picture, around, 0);
        least = min(least, drawn);
        most = max(most, drawn);
        let depth_m = textureLoad(position, around, 0).w;
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
        age = MOST_AGE;
        mean = mix(textureLoad(history_before, pixel, 0), now, temporal_aa.rest_weight);
    } else if temporal_aa.has_history == 1u {
        let moved_px = textureLoad(motion, nearest, 0).xy;
        let place = vec2<f32>(pixel) + 0.5 - moved_px;
        if all(place >= vec2<f32>(0.0)) && all(place < vec2<f32>(view.size_px)) {
            let at = textureLoad(position, nearest, 0);
            let was_m = (view.previous_clip_from_camera * vec4<f32>(at.xyz, 1.0)).w;
            let before = drawn_before(place, select(SKY, log_of(was_m), at.w > 0.0));
            let is_same = before.age >= 0.0;
            // How far it moved because the eye did, and did not only turn.
            let turned_px = motion_of(view, nearest, vec4<f32>(ray_of_pixel(view, nearest), 0.0));
            let slid_px = length(moved_px - turned_px);
            let kept = select(0.0, KEPT * (1.0 - smoothstep(SLOW_PX, QUICK_PX, slid_px)), is_same);
            let clamped = mix(clamp(before.drawn, least, most), before.drawn, kept);
            age = min(before.age + 1.0, MOST_AGE);
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
