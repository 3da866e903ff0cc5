// What the passes of strokes share beside their records: the style's numbers, and the points of strokes.
#define_import_path hachure::stroke_style

// A point of a stroke.
struct Point {
    // On the picture.
    px: vec2<f32>,
    // Distance along the view axis.
    depth_m: f32,
    // Whose it is.
    chain: u32,
    // Of the edge that begins here.
    kind: u32,
    padding: u32,
}

struct Strokes {
    // Pixels of the reference image per pixel of the picture: 1 to 1/4.
    resolution: f32,
    segment_capacity: u32,
    // Of the reference image.
    image_px: vec2<u32>,
    half_width_px: f32,
    taper_px: f32,
    // Camera distance at which haze has taken 63 % of a stroke, and what is left of it at last.
    haze_m: f32,
    faintest: f32,
    // How much the width follows nearness, 0 to 1.
    depth_width: f32,
    // How much thinner strokes are where the step in depth behind them is small, 0 to 1.
    step_width: f32,
    // Strokes that are shorter are left out.
    shortest_px: f32,
    // How much wider strokes are where they bend; below 0 thinner.
    curve_width: f32,
    // How far strokes stray from their line.
    wobble_px: f32,
    // Edges that run side by side within this are one line; 0: none are.
    merge_px: f32,
    // How many times as long as wide strokes are where they are not thinner; 0: all have their width.
    slender: f32,
    // As parts of that of contours.
    suggestive_width: f32,
    ridge_width: f32,
    valley_width: f32,
}
