// How much farther away the land is behind a line: it says whether the line is a skyline, hides land, or lies within a
// slope.
#define_import_path hachure::line_step

// Distance to either side of a line at which the depth is compared.
const SIDE_PX: f32 = 3.0;
// Step from which a line hides land, and step from which it is a skyline; lines with less than the first lie within a
// slope, the more so the smaller the step.
const OCCLUDING_STEP: f32 = 0.3;
const SKYLINE_STEP: f32 = 0.9;
// Largest part of itself by which a reversed depth is extrapolated to a line.
const MOST_SLANT: f32 = 0.25;

fn nearness_on(depth: texture_depth_2d, px: vec2<f32>) -> f32 {
    let last = vec2<i32>(textureDimensions(depth)) - 1;
    return textureLoad(depth, clamp(vec2<i32>(floor(px)), vec2<i32>(0), last), 0);
}

// Returns how much farther the farther side of a line is, relative to its distance: 0 to 1, where 1 is the sky. `depth`
// is reversed: near / distance. `across` is the unit vector across the line.
fn step_behind(depth: texture_depth_2d, px: vec2<f32>, across: vec2<f32>) -> f32 {
    let sides = vec2<f32>(nearness_on(depth, px + across * SIDE_PX), nearness_on(depth, px - across * SIDE_PX));
    // What a headset hides has a reversed depth of 1, and is no step.
    if max(sides.x, sides.y) >= 1.0 {
        return 0.0;
    }
    return 1.0 - min(sides.x, sides.y) / max(max(sides.x, sides.y), 1e-9);
}

// Returns the reversed depth of the land on one side of a line, extrapolated to the line from two distances. The reversed
// depth of a plane is linear on the picture, so an oblique slope alone is no step.
fn nearness_up_to(depth: texture_depth_2d, px: vec2<f32>, toward: vec2<f32>) -> f32 {
    let beside = nearness_on(depth, px + toward * SIDE_PX);
    let rise = beside - nearness_on(depth, px + toward * (2.0 * SIDE_PX));
    return beside + clamp(rise, -MOST_SLANT * beside, MOST_SLANT * beside);
}

// Returns the step behind a line as `step_behind` does, without what the slopes on both sides add to it: how far behind
// the line the land continues.
fn hidden_behind(depth: texture_depth_2d, px: vec2<f32>, across: vec2<f32>) -> f32 {
    if max(nearness_on(depth, px + across * SIDE_PX), nearness_on(depth, px - across * SIDE_PX)) >= 1.0 {
        return 0.0;
    }
    let sides = vec2<f32>(nearness_up_to(depth, px, across), nearness_up_to(depth, px, -across));
    return 1.0 - min(sides.x, sides.y) / max(max(sides.x, sides.y), 1e-9);
}
