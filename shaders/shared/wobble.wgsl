// The wobble of a hand-drawn line: smooth noise that is fixed in the world and has one size on the picture.
//
// Two octaves of value noise, whose cells are powers of two of a metre, are blended by distance. So a place keeps its
// noise while the camera approaches, until finer noise takes over (Benard et al. 2009 do so with textures).
#define_import_path hachure::wobble

#import hachure::stroke_samples::hash

// Position of the camera in the world: whole blocks of 4096 m, and the rest.
struct Anchor {
    blocks: vec3<i32>,
    pad_a: u32,
    rest_m: vec3<f32>,
    pad_b: u32,
}

// Size of a cell of the noise on the picture.
const CELL_PX: f32 = 24.0;

fn corner(cell: vec3<i32>) -> f32 {
    let wrapped = vec3<u32>(cell & vec3<i32>(255));
    return f32(hash(wrapped.x | (wrapped.y << 8u) | (wrapped.z << 16u)) >> 8u) / 8388608.0 - 1.0;
}

// Returns noise of -1 to 1. It repeats after 256 cells.
fn noise(anchor: Anchor, at_m: vec3<f32>, octave: i32) -> f32 {
    let cell_m = exp2(f32(octave));
    // Blocks of 4096 m are 2^(12 - octave) cells, and 256 or more of these are whole repetitions.
    let blocks = vec3<f32>(anchor.blocks) * exp2(f32(12 - octave));
    let far = select(blocks - 256.0 * floor(blocks / 256.0), vec3<f32>(0.0), octave <= 4);
    // Blocks are fractions of cells that are larger than a block.
    let place = (anchor.rest_m + at_m) / cell_m + fract(far);
    let cell = floor(place);
    let t = place - cell;
    let s = t * t * (3.0 - 2.0 * t);
    let c = vec3<i32>(cell - 256.0 * floor(cell / 256.0)) + vec3<i32>(far);
    var sum = 0.0;
    for (var i = 0; i < 8; i++) {
        let offset = vec3<i32>(i & 1, (i >> 1u) & 1, i >> 2u);
        let weight = mix(1.0 - s, s, vec3<f32>(offset));
        sum += weight.x * weight.y * weight.z * corner(c + offset);
    }
    return sum;
}

// Returns a wobble of -1 to 1, at a camera-relative point where a pixel is `pixel_m` wide.
fn wobble(anchor: Anchor, at_m: vec3<f32>, pixel_m: f32) -> f32 {
    let octave = clamp(log2(max(CELL_PX * pixel_m, 1e-3)), -8.0, 16.0);
    let t = octave - floor(octave);
    let fine = noise(anchor, at_m, i32(floor(octave)));
    let coarse = noise(anchor, at_m, i32(floor(octave)) + 1);
    // Mixing two noises lowers the amplitude in the middle; this restores it.
    return mix(fine, coarse, t) / sqrt(t * t + (1.0 - t) * (1.0 - t));
}
