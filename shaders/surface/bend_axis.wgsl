// The line along which the land bends most, at one pixel of sixteen: the direction of hatching that follows curvature
// (Hertzmann and Zorin 2000, "Illustrating Smooth Surfaces", section 4: hatches follow principal directions where these
// are well defined, and the field is smoothed in between).
//
// They smooth a field of crosses by optimisation. Here the squared second fundamental form (the third one, which has no
// sense and no sign, so that a rib and the gully next to it agree) is averaged over the surrounding blocks, as far as
// they see the same land, and its larger eigenvector is the line. Where the average hardly bends, in radians of the
// normal over a sample of the form, a line of equal height replaces it: rows around a hill continue over its even
// faces.
#import hachure::curvature::{frame_of, form2, principal_of}

struct BendAxisRules {
    // Distance between the blocks that are averaged, in blocks.
    step: i32,
    pad: i32,
    // Number of blocks of the pictures, across and down.
    blocks: vec2<u32>,
}

// Blocks that are averaged on each side.
const REACH: i32 = 2;
// Largest relative difference of distance to blocks that see the same land.
const NEAR: f32 = 0.15;
// Weight of the line of equal height, in squared radians of the normal over a sample.
const EVEN: f32 = 0.0001;

@group(0) @binding(0) var<uniform> bend_axis_rules: BendAxisRules;
@group(0) @binding(1) var shape_normal: texture_2d<f32>;
@group(0) @binding(2) var shape_bend: texture_2d<f32>;
// xy: cosine and sine of twice the line's angle on the map, counter-clockwise from east, times its certainty, 0 to 1.
@group(0) @binding(3) var bend_axis: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let block = vec2<i32>(id.xy);
    let size = bend_axis_rules.blocks;
    if any(id.xy >= size) {
        return;
    }
    let own = textureLoad(shape_normal, block, 0);
    if own.w <= 0.0 {
        textureStore(bend_axis, block, vec4<f32>(0.0));
        return;
    }
    let frame = frame_of(own.xyz);
    var sum = vec3<f32>(0.0);
    var weights = 0.0;
    for (var j = -REACH; j <= REACH; j++) {
        for (var i = -REACH; i <= REACH; i++) {
            let at = clamp(block + bend_axis_rules.step * vec2<i32>(i, j), vec2<i32>(0), vec2<i32>(size) - 1);
            let there = textureLoad(shape_normal, at, 0);
            if there.w <= 0.0 || abs(there.w - own.w) > NEAR * own.w {
                continue;
            }
            let shape = textureLoad(shape_bend, at, 0);
            let bend = shape.xyz * shape.w;
            let squared = vec3<f32>(bend.x * bend.x + bend.y * bend.y, bend.y * (bend.x + bend.z), bend.y * bend.y + bend.z * bend.z);
            // In this block's tangent frame.
            let other = frame_of(there.xyz);
            let u = frame[0] * other;
            let v = frame[1] * other;
            let weight = exp(-0.5 * f32(i * i + j * j));
            sum += weight * vec3<f32>(form2(squared, u, u), form2(squared, u, v), form2(squared, v, v));
            weights += weight;
        }
    }
    sum /= weights;
    // Adds the line of equal height; level land has none.
    let level = vec3<f32>(-own.y, own.x, 0.0) * frame;
    sum += EVEN * vec3<f32>(level.x * level.x, level.x * level.y, level.y * level.y);
    let found = principal_of(sum);
    let line = (frame * found.along).xy;
    let decided = (found.most - found.least) / max(found.most + found.least, 1e-12);
    let doubled = vec2<f32>(line.x * line.x - line.y * line.y, 2.0 * line.x * line.y) / max(dot(line, line), 1e-12);
    textureStore(bend_axis, block, vec4<f32>(decided * doubled, 0.0, 0.0));
}
