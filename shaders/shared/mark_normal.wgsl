// The layout of the blocks of the `mark_normal` picture, and its value at a pixel.
#define_import_path hachure::mark_normal
#import hachure::view::{View, place_of_pixel, ray_of_pixel}

// Side of the block of pixels that shares a texel.
const BLOCK_PX: i32 = 4;

// Largest relative difference in distance between blocks that count as equally far away.
const NEAR: f32 = 0.1;

// Replaces the lightness of a tree's pixels: marks treat trees as flat.
const FLAT: f32 = -1.0;

// Returns the normal that marks follow where they do not follow the land. `surface` is a normal, and lightness or FLAT.
fn own_mark_normal(view: View, pixel: vec2<i32>, surface: vec4<f32>) -> vec3<f32> {
    return select(surface.xyz, -normalize(ray_of_pixel(view, pixel)), surface.w == FLAT);
}

// Returns the first block of the target. Blocks are counted in the whole picture, so that parts of a large one agree.
fn first_block(view: View) -> vec2<i32> {
    return view.origin_px >> vec2<u32>(2u);
}

// Returns the number of blocks of the target, across and down.
fn block_count(view: View) -> vec2<u32> {
    return (view.size_px + vec2<u32>(u32(BLOCK_PX) - 1u)) / u32(BLOCK_PX) + 1u;
}

// Returns the pixel of the target that represents a block.
fn pixel_of_block(view: View, block: vec2<i32>) -> vec2<i32> {
    let pixel = (block + first_block(view)) * BLOCK_PX + BLOCK_PX / 2 - view.origin_px;
    return clamp(pixel, vec2<i32>(0), vec2<i32>(view.size_px) - 1);
}

// Returns the mark normal at a pixel that sees `at` (w: distance along the view axis). It is interpolated between the
// four blocks around the pixel that see the same face of the land; if none does, and for trees, it is the pixel's own.
fn mark_normal_at(view: View, mark_normal: texture_2d<f32>, pixel: vec2<i32>, at: vec4<f32>, surface: vec4<f32>) -> vec3<f32> {
    let normal = own_mark_normal(view, pixel, surface);
    if surface.w == FLAT {
        return normal;
    }
    return between_blocks(view, mark_normal, pixel, at, normal, 0.0);
}

// The four blocks around a pixel: the first one, and the pixel's fractional position among them.
struct Around {
    first: vec2<i32>,
    f: vec2<f32>,
}

fn blocks_around(view: View, pixel: vec2<i32>) -> Around {
    let place = vec2<f32>(pixel + view.origin_px - BLOCK_PX / 2) / f32(BLOCK_PX);
    let whole = floor(place);
    return Around(vec2<i32>(whole) - first_block(view), place - whole);
}

// Returns one of the four blocks, clamped to the picture.
fn block_of(around: Around, i: i32, size: vec2<u32>) -> vec2<i32> {
    return clamp(around.first + vec2<i32>(i & 1, i >> 1u), vec2<i32>(0), vec2<i32>(size) - 1);
}

// Returns the weight of a block for a pixel that sees `at`: how far the block sees the same face of the land. `seen` is
// the block's normal and depth. A block that is about as far away has a weight of at least `min_weight`, whatever
// face it sees.
fn block_weight(view: View, around: Around, i: i32, block: vec2<i32>, seen: vec4<f32>, at: vec4<f32>, min_weight: f32) -> f32 {
    // Allowed distance of the pixel's point from the block's tangent plane: a block's width on the ground.
    let allowed_m = f32(BLOCK_PX) * at.w / view.focal_px;
    let away = at.xyz - place_of_pixel(view, pixel_of_block(view, block), seen.w);
    let miss = dot(away, seen.xyz) / allowed_m;
    let weight = mix(1.0 - around.f, around.f, vec2<f32>(vec2<i32>(i & 1, i >> 1u)));
    let near = select(0.0, min_weight, abs(seen.w - at.w) < NEAR * at.w);
    return weight.x * weight.y * f32(seen.w > 0.0) * (1.0 / (1.0 + miss * miss * miss * miss) + near);
}

// Returns a normal interpolated between the four blocks around a pixel; `own` if none sees the pixel's face.
fn between_blocks(view: View, blocks: texture_2d<f32>, pixel: vec2<i32>, at: vec4<f32>, own: vec3<f32>, min_weight: f32) -> vec3<f32> {
    let around = blocks_around(view, pixel);
    var sum = own * 1e-4;
    for (var i = 0; i < 4; i++) {
        let block = block_of(around, i, block_count(view));
        let seen = textureLoad(blocks, block, 0);
        sum += seen.xyz * block_weight(view, around, i, block, seen, at, min_weight);
    }
    return normalize(sum);
}

// Interpolates other values of blocks in the same way; returns 0 if no block sees the pixel's face.
fn values_between_blocks(view: View, blocks: texture_2d<f32>, values: texture_2d<f32>, pixel: vec2<i32>, at: vec4<f32>) -> vec4<f32> {
    let around = blocks_around(view, pixel);
    var sum = vec4<f32>(0.0);
    var weights = 1e-4;
    for (var i = 0; i < 4; i++) {
        let block = block_of(around, i, block_count(view));
        let weight = block_weight(view, around, i, block, textureLoad(blocks, block, 0), at, 0.0);
        sum += weight * textureLoad(values, block, 0);
        weights += weight;
    }
    return sum / weights;
}
