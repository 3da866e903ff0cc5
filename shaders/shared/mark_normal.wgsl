// Where the blocks of the `mark_normal` picture lie, and what it says at a pixel.
#define_import_path hachure::mark_normal
#import hachure::view::{View, place_of_pixel, ray_of_pixel}

// Side of the block of pixels that shares a texel.
const BLOCK_PX: i32 = 4;

// Blocks are about as far away within this, by the distance.
const NEAR: f32 = 0.1;

// In place of the lightness of what is seen: it is a tree, flat to marks.
const FLAT: f32 = -1.0;

// What marks follow where they do not follow the land. `surface`: a normal, and FLAT or lightness.
fn own_mark_normal(view: View, pixel: vec2<i32>, surface: vec4<f32>) -> vec3<f32> {
    return select(surface.xyz, -normalize(ray_of_pixel(view, pixel)), surface.w == FLAT);
}

// Blocks are counted in the whole picture, so that the parts of a large picture agree.
fn first_block(view: View) -> vec2<i32> {
    return view.origin_px >> vec2<u32>(2u);
}

// The pixel of the targets that stands for a block.
fn pixel_of_block(view: View, block: vec2<i32>) -> vec2<i32> {
    let pixel = (block + first_block(view)) * BLOCK_PX + BLOCK_PX / 2 - view.origin_px;
    return clamp(pixel, vec2<i32>(0), vec2<i32>(view.size_px) - 1);
}

// The normal at a pixel that sees `at` (w: along the view axis): between the four blocks around it, as far as they
// see the same face of the land; what `surface` has where none does, and where a tree is.
fn mark_normal_at(view: View, mark_normal: texture_2d<f32>, pixel: vec2<i32>, at: vec4<f32>, surface: vec4<f32>) -> vec3<f32> {
    let normal = own_mark_normal(view, pixel, surface);
    if surface.w == FLAT {
        return normal;
    }
    return between_blocks(view, mark_normal, pixel, at, normal, 0.0);
}

// The four blocks around a pixel: the first one, and where the pixel lies among them.
struct Around {
    first: vec2<i32>,
    f: vec2<f32>,
}

fn blocks_around(view: View, pixel: vec2<i32>) -> Around {
    let place = vec2<f32>(pixel + view.origin_px - BLOCK_PX / 2) / f32(BLOCK_PX);
    let whole = floor(place);
    return Around(vec2<i32>(whole) - first_block(view), place - whole);
}

// One of them, within the picture.
fn block_of(around: Around, i: i32, size: vec2<u32>) -> vec2<i32> {
    return clamp(around.first + vec2<i32>(i & 1, i >> 1u), vec2<i32>(0), vec2<i32>(size) - 1);
}

// How much it counts for a pixel that sees `at`: as far as it sees the same face of the land. `seen` is its normal, and how
// far it sees. One that is about as far away counts for `beside` at least, whichever face it sees.
fn block_weight(view: View, around: Around, i: i32, block: vec2<i32>, seen: vec4<f32>, at: vec4<f32>, beside: f32) -> f32 {
    // What the plane through a block may miss the pixel's place by: a block's width on the ground.
    let allowed_m = f32(BLOCK_PX) * at.w / view.focal_px;
    let away = at.xyz - place_of_pixel(view, pixel_of_block(view, block), seen.w);
    let miss = dot(away, seen.xyz) / allowed_m;
    let weight = mix(1.0 - around.f, around.f, vec2<f32>(vec2<i32>(i & 1, i >> 1u)));
    let near = select(0.0, beside, abs(seen.w - at.w) < NEAR * at.w);
    return weight.x * weight.y * f32(seen.w > 0.0) * (1.0 / (1.0 + miss * miss * miss * miss) + near);
}

// Normals between the four blocks around a pixel; `own` where none sees its face.
fn between_blocks(view: View, blocks: texture_2d<f32>, pixel: vec2<i32>, at: vec4<f32>, own: vec3<f32>, beside: f32) -> vec3<f32> {
    let around = blocks_around(view, pixel);
    var sum = own * 1e-4;
    for (var i = 0; i < 4; i++) {
        let block = block_of(around, i, textureDimensions(blocks));
        let seen = textureLoad(blocks, block, 0);
        sum += seen.xyz * block_weight(view, around, i, block, seen, at, beside);
    }
    return normalize(sum);
}

// What else blocks say, between them in the same way; 0 where none sees the pixel's face.
fn values_between_blocks(view: View, blocks: texture_2d<f32>, values: texture_2d<f32>, pixel: vec2<i32>, at: vec4<f32>) -> vec4<f32> {
    let around = blocks_around(view, pixel);
    var sum = vec4<f32>(0.0);
    var weights = 1e-4;
    for (var i = 0; i < 4; i++) {
        let block = block_of(around, i, textureDimensions(blocks));
        let weight = block_weight(view, around, i, block, textureLoad(blocks, block, 0), at, 0.0);
        sum += weight * textureLoad(values, block, 0);
        weights += weight;
    }
    return sum / weights;
}
