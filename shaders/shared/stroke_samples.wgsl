// What lasts of strokes from frame to frame: their samples. See src/lines/strokes/samples.rs and temporal.rs.
#define_import_path hachure::stroke_samples

// A place on a stroke.
struct Sample {
    // Camera-relative, in the frame that the list belongs to.
    position_m: vec3<f32>,
    // How strongly the pen is pressed: 0 nothing, 1 full.
    pressure: f32,
    // On the picture.
    px: vec2<f32>,
    // The texture's parameter.
    along_px: f32,
    // At full pressure.
    half_width_px: f32,
    // Distance along the view axis.
    depth_m: f32,
    // How far along the stroke it is to where drawing ends: above 0 the sample is drawn, below it is not.
    shown_px: f32,
    // Whose it is; lasts across frames. Not 0. When a stroke falls into several, all of them keep it.
    stroke: u32,
    // FIRST, LAST, FADING, IS_CLOSED, RUNS_OFF, and the kind of edge from bit 8 on.
    flags: u32,
    // How far from its own place it is held by the line before: a part of `px`.
    held_px: vec2<f32>,
    // Of its chain.
    length_px: f32,
    // How much it matters where strokes are crowded, 0 to 1.
    rank: f32,
}

// What a sample found in the frame before, or in the other eye.
struct Match {
    // 0: nothing.
    stroke: u32,
    along_px: f32,
    pressure: f32,
    // 1 if the old stroke runs the same way, -1 if the other.
    sense: f32,
    // From the sample to the old line.
    toward_px: vec2<f32>,
    half_width_px: f32,
    // Of the sample itself: arc length from its stroke's start.
    at_px: f32,
    shown_px: f32,
    // 1: the other eye sees the place.
    is_seen: u32,
}

// What a chain takes over.
struct Heritage {
    // 0: nothing, it is new.
    stroke: u32,
    sense: f32,
    offset_px: f32,
    padding: u32,
}

// How many samples there are.
struct SampleCounts {
    // All of the list.
    samples: u32,
    // Those of chains of this frame; the others fade.
    fresh: u32,
    // Strokes of this frame's chains.
    strokes: u32,
    // Strokes that the budget left out.
    left_out: u32,
    // Strokes that took over from others.
    carried: u32,
    // The shortest class of strokes that the budget had room for, four to an octave of pixels.
    least_class: u32,
    // Chains of this frame, as in StrokeCounts.
    chains: u32,
    padding: u32,
}

struct Temporal {
    // Takes the camera-relative positions of the frame before to this frame's.
    step_m: vec3<f32>,
    // 1: the other list is of the frame before.
    has_history: u32,
    // By how much the pressure may change in this frame.
    pressure_step: f32,
    // How far the line before holds the new one, 0 to 1.
    hold: f32,
    // How far the ends of strokes grow and shrink in this frame.
    growth_px: f32,
    // Samples that there is room for.
    capacity: u32,
    // Of the frame: no two strokes that are born get the same number.
    seed: u32,
    // 1: the camera is where it was.
    rests: u32,
    padding_a: u32,
    padding_b: u32,
    // The camera in the world: whole blocks of 4096 m, and the rest.
    camera_blocks: vec3<i32>,
    padding_c: u32,
    camera_rest_m: vec3<f32>,
    padding_d: u32,
    // Takes this frame's positions to the clip space of the last update.
    updated_clip_from_camera: mat4x4<f32>,
}

const FIRST: u32 = 1u;
const LAST: u32 = 2u;
const FADING: u32 = 4u;
const IS_CLOSED: u32 = 8u;
// The first or last of a stroke, at the picture's border: the stroke runs on, out of it.
const RUNS_OFF: u32 = 16u;
const KIND_SHIFT: u32 = 8u;

// Samples are at most so far apart along a stroke.
const SPACING_PX: f32 = 2.0;
// Classes of length, four for each octave.
const CLASSES: u32 = 64u;

// A line that is held back comes no nearer to its place than this in a frame.
const MOVE_PX: f32 = 0.5;
const RESTS_PX: f32 = 0.01;
// New strokes begin to grow, and old ones to shrink, in places so far apart: then all of them are done in the same
// time.
const SEEDS_PX: f32 = 64.0;
// Parameters that differ from arc length by more than this do not run on.
const SEAM_PX: f32 = 6.0;
// `shown_px` of what is far from any end.
const WHOLLY_PX: f32 = 8.0;
// Samples on either side that growth looks at.
const BESIDE: u32 = 8u;

// How far it is along a stroke to the nearest sample where growth begins: the last one before such a place.
fn to_seed_px(along_px: f32) -> f32 {
    let ahead_px = round(along_px / SEEDS_PX) * SEEDS_PX - along_px;
    return SPACING_PX * abs(ceil(ahead_px / SPACING_PX) - 1.0);
}

// Whether two samples that follow each other have parameters of different strokes.
fn is_seam(a_px: f32, b_px: f32, apart_px: f32) -> bool {
    return abs(abs(b_px - a_px) - apart_px) > SEAM_PX;
}

// What is left of a way that a line is held back by, a frame later.
fn let_go(held_px: vec2<f32>, hold: f32) -> vec2<f32> {
    let apart_px = length(held_px);
    let left_px = max(hold * apart_px, apart_px - MOVE_PX);
    // What rests stays to the bit.
    return select(vec2<f32>(0.0), held_px * (left_px / max(apart_px, 1e-6)), apart_px > RESTS_PX);
}

fn samples_of(length_px: f32) -> u32 {
    return max(u32(ceil(length_px / SPACING_PX)), 1u) + 1u;
}

fn class_of(length_px: f32) -> u32 {
    return u32(clamp(4.0 * log2(max(length_px, 1.0)), 0.0, f32(CLASSES - 1u)));
}

fn hash(value: u32) -> u32 {
    var h = value * 0x9e3779b1u;
    h = (h ^ (h >> 15u)) * 0x85ebca77u;
    h = (h ^ (h >> 13u)) * 0xc2b2ae3du;
    return h ^ (h >> 16u);
}

struct Nearest {
    // Between the ends of the segment: 0 to 1.
    t: f32,
    px: vec2<f32>,
}

fn nearest_on(a: vec2<f32>, b: vec2<f32>, px: vec2<f32>) -> Nearest {
    let along = b - a;
    let t = clamp(dot(px - a, along) / max(dot(along, along), 1e-12), 0.0, 1.0);
    return Nearest(t, a + along * t);
}
