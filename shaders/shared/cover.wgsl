// What marks ink of a pixel, and what they would if the tone were a little darker: so tones can be balanced after all
// marks are known (`tones/balance`).
#define_import_path hachure::cover
#import hachure::view::View

// Of the bell in which tones are balanced, and where it ends.
const SIGMA_CELLS: f32 = 1.6;
const REACH_CELLS: i32 = 4;

struct Balance {
    // Side of a cell in which ink is counted: a power of two.
    cell_px: i32,
    pad_a: i32,
    pad_b: i32,
    pad_c: i32,
}

// Cells are counted in the whole picture, so that parts of a large one agree.
fn first_cell(view: View, balance: Balance) -> vec2<i32> {
    return view.origin_px >> vec2<u32>(firstTrailingBit(u32(balance.cell_px)));
}

struct Cover {
    // 0 to 1.
    ink: f32,
    // The ink of the mark that reaches farthest, not bounded: below 0 it does not come to the pixel, above 1 it goes
    // on.
    reach: f32,
    // How fast that grows with the darkness that is asked for.
    rise: f32,
}

// Two covers that know nothing of each other.
fn united(a: Cover, b: Cover) -> Cover {
    let ink = 1.0 - (1.0 - a.ink) * (1.0 - b.ink);
    return Cover(ink, max(a.reach, b.reach), select(b.rise, a.rise, a.reach > b.reach));
}

// Gaps for marks: gaps close as marks grow.
fn turned(gaps: Cover) -> Cover {
    return Cover(1.0 - gaps.ink, 1.0 - gaps.reach, gaps.rise);
}

// How fast a layer's darkness grows with all darkness, when the optical densities of all layers grow alike.
fn growth_of_share(share: f32, darkness: f32) -> f32 {
    let own = max(1.0 - share, 1e-4);
    let whole = max(1.0 - darkness, 1e-4);
    return own * log(own) / min(whole * log(whole), -1e-4);
}

// As a texel: ink without bounds, its rise, the darkness that was asked for, and 1 for the surface; the sky is all 0.
// White paper and black stay what they are.
fn texel_of(cover: Cover, darkness: f32) -> vec4<f32> {
    if darkness > 0.998 {
        return vec4<f32>(2.0, 0.0, darkness, 1.0);
    }
    let unbounded = clamp(cover.reach, -100.0, 100.0) + cover.ink - clamp(cover.reach, 0.0, 1.0);
    let near_end = clamp(20.0 * min(darkness, 1.0 - darkness), 0.0, 1.0);
    return vec4<f32>(unbounded, min(cover.rise * near_end, 6e4), darkness, 1.0);
}

// The bounded ink of a texel at a darkness that is `more` than was asked for.
fn ink_of(texel: vec4<f32>, more: f32) -> f32 {
    return clamp(texel.x + texel.y * more, 0.0, 1.0);
}

// How fast that grows here: where a mark's border is, and nowhere else.
fn rise_of(texel: vec4<f32>) -> f32 {
    return select(0.0, texel.y, texel.x > 0.0 && texel.x < 1.0);
}
