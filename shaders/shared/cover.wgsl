// The ink of marks in a pixel, and how it would change if the tone were a little darker, so that tones can be balanced
// once all marks are known (`tones/balance`).
#define_import_path hachure::cover
#import hachure::view::View

// Standard deviation of the Gaussian over which tones are balanced, and where it is cut off, in cells.
const SIGMA_CELLS: f32 = 1.6;
const REACH_CELLS: i32 = 4;

struct Balance {
    // Side of a cell in which ink is counted, in pixels: a power of two.
    cell_px: i32,
    pad: i32,
    // Number of cells of the pictures, across and down.
    cells: vec2<u32>,
}

// Returns the first cell of the target. Cells are counted in the whole picture, so that parts of a large one agree.
fn first_cell(view: View, balance: Balance) -> vec2<i32> {
    return view.origin_px >> vec2<u32>(firstTrailingBit(u32(balance.cell_px)));
}

struct Cover {
    // Ink of the pixel, 0 to 1.
    ink: f32,
    // Unclamped ink of the mark that reaches farthest: negative if the mark ends before the pixel, above 1 if it
    // extends beyond it.
    reach: f32,
    // Derivative of `reach` with respect to the requested darkness.
    rise: f32,
}

// Combines two covers that are independent of each other.
fn united(a: Cover, b: Cover) -> Cover {
    let ink = 1.0 - (1.0 - a.ink) * (1.0 - b.ink);
    return Cover(ink, max(a.reach, b.reach), select(b.rise, a.rise, a.reach > b.reach));
}

// Turns gaps into marks. Gaps close as marks grow, so `rise` keeps its sign.
fn turned(gaps: Cover) -> Cover {
    return Cover(1.0 - gaps.ink, 1.0 - gaps.reach, gaps.rise);
}

// Returns how fast a layer's darkness grows with the total darkness if the optical densities of all layers grow in
// proportion.
fn growth_of_share(share: f32, darkness: f32) -> f32 {
    let own = max(1.0 - share, 1e-4);
    let whole = max(1.0 - darkness, 1e-4);
    return own * log(own) / min(whole * log(whole), -1e-4);
}

// Packs a cover into a texel: unclamped ink, its rise, the requested darkness, and 1 for the surface; the sky is all 0.
// Balancing does not change full white and full black.
fn texel_of(cover: Cover, darkness: f32) -> vec4<f32> {
    if darkness > 0.998 {
        return vec4<f32>(2.0, 0.0, darkness, 1.0);
    }
    let unbounded = clamp(cover.reach, -100.0, 100.0) + cover.ink - clamp(cover.reach, 0.0, 1.0);
    let near_end = clamp(20.0 * min(darkness, 1.0 - darkness), 0.0, 1.0);
    return vec4<f32>(unbounded, min(cover.rise * near_end, 6e4), darkness, 1.0);
}

// Returns the clamped ink of a texel at a darkness that is `more` than was requested.
fn ink_of(texel: vec4<f32>, more: f32) -> f32 {
    return clamp(texel.x + texel.y * more, 0.0, 1.0);
}

// Returns the derivative of `ink_of` with respect to darkness; it is nonzero only at the border of a mark.
fn rise_of(texel: vec4<f32>) -> f32 {
    return select(0.0, texel.y, texel.x > 0.0 && texel.x < 1.0);
}
