// The samples of strokes, which persist from frame to frame. See src/lines/strokes/samples.rs and temporal.rs.
#define_import_path hachure::stroke_samples

// Strokes are not drawn thinner than this to either side.
const LEAST_HALF_WIDTH_PX: f32 = 0.4;

// A point of a stroke.
struct Sample {
    // Camera-relative, in metres, in the frame of the list.
    position_m: vec3<f32>,
    // Pressure of the pen: 0 none, 1 full.
    pressure: f32,
    // Position on the picture, in pixels.
    px: vec2<f32>,
    // Parameter of the texture along the stroke, in pixels.
    along_px: f32,
    // Half width at full pressure, in pixels.
    half_width_px: f32,
    // Distance along the view axis, in metres.
    depth_m: f32,
    // Distance along the stroke to the end of the drawn part, in pixels: positive where the sample is drawn.
    shown_px: f32,
    // Identity of the stroke across frames, never 0. A stroke that splits passes it on to all of its parts. In samples
    // that temporal.wgsl has not yet reached, the index of the chain.
    stroke: u32,
    // FIRST, LAST, FADING, IS_CLOSED, RUNS_OFF, and the kind of edge from bit 8 on.
    flags: u32,
    // Displacement by which the previous frame's line holds the sample back, in pixels; `px` includes it.
    held_px: vec2<f32>,
    // Length of the sample's chain, in pixels.
    length_px: f32,
    // Rank where strokes are crowded, 0 to 1; the highest stay. Skylines have more than 1, and 2 at most.
    rank: f32,
}

// The stroke that a sample found in the previous frame, or in the other eye.
struct Match {
    // Identity of the stroke; 0 is none.
    stroke: u32,
    // Texture parameter and pressure of the old stroke there.
    along_px: f32,
    pressure: f32,
    // 1 if the texture parameter of the old stroke grows along the sample's chain, -1 if it falls.
    direction_sign: f32,
    // From the sample to the old line, in pixels.
    to_old_line_px: vec2<f32>,
    half_width_px: f32,
    // Arc length of the sample itself from its stroke's start, in pixels.
    at_px: f32,
    shown_px: f32,
    // 1: the other eye sees the point.
    is_seen: u32,
}

// The old stroke for which the samples of a chain voted.
struct Heritage {
    // Identity of the stroke; 0 if the chain is new.
    stroke: u32,
    // As in Match.
    direction_sign: f32,
    // Texture parameter at the start of the chain.
    offset_px: f32,
    padding: u32,
}

// Counters of samples and strokes.
struct SampleCounts {
    // Number of samples in the list.
    samples: u32,
    // Number of samples of this frame's chains; the others are fading.
    fresh: u32,
    // Number of strokes of this frame's chains.
    strokes: u32,
    // Number of strokes that the budget left out.
    left_out: u32,
    // Number of strokes that continue earlier ones.
    carried: u32,
    // Shortest class of strokes within the budget, four classes per octave of pixels.
    shortest_class: u32,
    // Number of chains of this frame, as in StrokeCounts.
    chains: u32,
    padding: u32,
}

// The times and steps that the passes need.
struct Temporal {
    // Added to camera-relative positions of the previous frame to give this frame's, in metres.
    step_m: vec3<f32>,
    // 1: the other list is of the previous frame.
    has_history: u32,
    // Largest change of pressure in this frame.
    pressure_step: f32,
    // Weight with which the previous line holds the new one, 0 to 1.
    hold: f32,
    // Distance by which the ends of strokes grow and shrink in this frame.
    growth_px: f32,
    // Capacity for samples.
    capacity: u32,
    // Seed of the frame, so that no two new strokes get the same identity.
    seed: u32,
    // 1: the camera has not moved.
    rests: u32,
    // Size of the previous frame's picture.
    last_px: vec2<u32>,
    // Position of the camera in the world: whole blocks of 4096 m, and the rest.
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
// The first or last sample of a stroke, at the picture's border: the stroke continues outside of it.
const RUNS_OFF: u32 = 16u;
const KIND_SHIFT: u32 = 8u;

// Largest distance between samples along a stroke.
const SPACING_PX: f32 = 2.0;
// Number of length classes, four per octave.
const CLASSES: u32 = 64u;

// Smallest step per frame by which a line that is held back moves to its place; and the distance below which it has
// arrived.
const MOVE_PX: f32 = 0.5;
const RESTS_PX: f32 = 0.01;
// Distance between the points where new strokes begin to grow and old ones to shrink: this way all of them finish in
// the same time.
const SEEDS_PX: f32 = 64.0;
// Difference between texture parameter and arc length beyond which the texture has a seam.
const SEAM_PX: f32 = 6.0;
// Largest `shown_px`: that of samples far from any end.
const WHOLLY_PX: f32 = 8.0;
// Samples on either side that growth reads.
const NEIGHBOURS: u32 = 8u;

// Returns the distance along a stroke to the nearest sample where growth begins: the last one before a seed point.
fn to_seed_px(along_px: f32) -> f32 {
    let ahead_px = round(along_px / SEEDS_PX) * SEEDS_PX - along_px;
    return SPACING_PX * abs(ceil(ahead_px / SPACING_PX) - 1.0);
}

// Returns whether two consecutive samples have parameters of different strokes.
fn is_seam(a_px: f32, b_px: f32, apart_px: f32) -> bool {
    return abs(abs(b_px - a_px) - apart_px) > SEAM_PX;
}

// Returns what is left, one frame later, of the displacement by which a line is held back, in pixels.
fn decayed(held_px: vec2<f32>, hold: f32) -> vec2<f32> {
    let apart_px = length(held_px);
    let left_px = max(hold * apart_px, apart_px - MOVE_PX);
    // A line that has arrived stays bit-identical.
    return select(vec2<f32>(0.0), held_px * (left_px / max(apart_px, 1e-6)), apart_px > RESTS_PX);
}

// Returns the number of samples of a chain.
fn samples_of(length_px: f32) -> u32 {
    return max(u32(ceil(length_px / SPACING_PX)), 1u) + 1u;
}

// Returns the length class of a chain, 0 to CLASSES - 1.
fn class_of(length_px: f32) -> u32 {
    return u32(clamp(4.0 * log2(max(length_px, 1.0)), 0.0, f32(CLASSES - 1u)));
}

// Returns a well mixed word: the final mix of xxHash32, after a multiplication by its first prime.
fn hash(value: u32) -> u32 {
    var h = value * 0x9e3779b1u;
    h = (h ^ (h >> 15u)) * 0x85ebca77u;
    h = (h ^ (h >> 13u)) * 0xc2b2ae3du;
    return h ^ (h >> 16u);
}

// A point of a segment.
struct Nearest {
    // Position between the ends of the segment, 0 to 1.
    t: f32,
    px: vec2<f32>,
}

// Returns the point of the segment from `a` to `b` that is nearest to `px`.
fn nearest_on(a: vec2<f32>, b: vec2<f32>, px: vec2<f32>) -> Nearest {
    let along = b - a;
    let t = clamp(dot(px - a, along) / max(dot(along, along), 1e-12), 0.0, 1.0);
    return Nearest(t, a + along * t);
}

// Index of the number of workgroups for all samples in the arguments of a list.
const ALL_GROUPS: u32 = 12u;

// Returns the number of workgroups of 64 threads with one thread per sample: at least one, whose first thread may write
// the counters.
fn groups_of(samples: u32) -> u32 {
    return max((samples + 63u) / 64u, 1u);
}

// Returns the arguments of a list: two indirect draws, of strokes of this frame and of fading ones, and two indirect
// dispatches, with a thread for each fresh sample and for each sample. The first draw is of all `samples`.
fn arguments_of(fresh: u32, samples: u32) -> array<u32, 16> {
    return array<u32, 16>(
        6u, samples, 0u, 0u,
        6u, 0u, 0u, 0u,
        groups_of(fresh), 1u, 1u, 0u,
        groups_of(samples), 1u, 1u, 0u,
    );
}
