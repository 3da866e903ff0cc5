// The style of strokes as their passes read it, and the points of strokes.
#define_import_path hachure::stroke_style

// A point of a stroke.
struct Point {
    // Position on the picture, in pixels.
    px: vec2<f32>,
    // Distance along the view axis, in metres.
    depth_m: f32,
    // Number of the chain that the point belongs to.
    chain: u32,
    // Kind of the edge that begins here.
    kind: u32,
    // At the ends of a chain: IS_MET if another line goes on there, so that the pen is not lifted, and at the first one how
    // much the line is a fold of a slope, from bit 8 on (budget.wgsl).
    end: u32,
}

const IS_MET: u32 = 1u;
const FOLD_SHIFT: u32 = 8u;

fn is_met_at(end: Point) -> bool {
    return (end.end & IS_MET) != 0u;
}

// Returns how much the chain that begins at this point is a fold of a slope: 0 to 1.
fn fold_of(first: Point) -> f32 {
    return f32(first.end >> FOLD_SHIFT) / 255.0;
}

struct Strokes {
    // Pixels of the reference image per pixel of the picture: 1 to 1/4.
    resolution: f32,
    segment_capacity: u32,
    // Size of the reference image.
    image_px: vec2<u32>,
    half_width_px: f32,
    taper_px: f32,
    // Camera distance at which haze has taken 63 % of a stroke, and the part of it that is left at infinity.
    haze_m: f32,
    faintest: f32,
    // How much the width grows toward the eye, 0 to 1.
    depth_width: f32,
    // Widths relative to that of skylines: of strokes that hide land, and of those within a slope.
    occluding_width: f32,
    interior_width: f32,
    // Length below which strokes are left out, and the same for strokes within a slope.
    shortest_px: f32,
    shortest_interior_px: f32,
    // How much wider strokes are at bends; negative makes them thinner.
    curve_width: f32,
    // How far strokes stray from their line.
    wobble_px: f32,
    // Distance within which parallel edges are merged into one line; 0 merges none.
    merge_px: f32,
    // Least length of a stroke in widths: shorter strokes are thinner; 0 sets no bound.
    slender: f32,
    // Widths relative to that of contours.
    suggestive_width: f32,
    ridge_width: f32,
    valley_width: f32,
}

// How many times farther skylines merge edges in full haze, and how many times as far from the eye as an edge beyond
// `merge_px` a skyline that takes it may be.
const FAR_MERGE: f32 = 2.0;
const MOST_BEHIND: f32 = 1.5;

// Returns the distance within which a skyline takes the place of an edge that is `depth_m` from the eye: ranges in haze
// are close to each other on the picture, and their lines would tangle.
fn sky_merge_px(strokes: Strokes, depth_m: f32) -> f32 {
    let t = depth_m / strokes.haze_m;
    return strokes.merge_px * mix(FAR_MERGE, 1.0, exp(-t * t));
}
