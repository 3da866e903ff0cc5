// Roystan's outline: Roberts crosses on depth and on normals ("Honks" in the comparison of Zaidi et al.).
//
// A pixel is an edge where 100 sqrt(sum of squared depth differences) > 1.5 depth k, with k growing from 1 to 8 as the
// surface turns away from the eye, or where the normals, packed to [0, 1], differ by more than 0.4. The depth is the
// reversed device depth, near / distance, as in the original.
//
// There are three differences from the original (Roystan, "Outline Shader", 2019). Its crosses span one pixel and are
// centred between pixels; these span two and are centred on the pixel, so that lines are at the same positions as those
// of the other detectors. The threshold grows with the depth of the pixel itself or of the corner, whichever is nearer;
// in the original with that of the corner alone, which misses edges from one side. And the orientation of the surface
// is that of the pixel, not of the corner.
#import hachure::view::{View, ray_of_pixel}
#import hachure::seen::normal_seen

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var distance_m: texture_2d<f32>;
@group(0) @binding(2) var normal: texture_2d<u32>;
@group(0) @binding(3) var errors: texture_storage_2d<rgba16float, write>;

fn inside(pixel: vec2<i32>) -> vec2<i32> {
    return clamp(pixel, vec2<i32>(0), vec2<i32>(view.size_px) - 1);
}

fn inverse_depth(pixel: vec2<i32>) -> f32 {
    let d = textureLoad(distance_m, inside(pixel), 0).r;
    return select(1.0 / d, 0.0, d <= 0.0);
}

fn packed_normal(pixel: vec2<i32>) -> vec3<f32> {
    return normal_seen(normal, inside(pixel)) * 0.5 + 0.5;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let p = vec2<i32>(id.xy);
    let a = p + vec2<i32>(-1, -1);
    let b = p + vec2<i32>(1, 1);
    let c = p + vec2<i32>(1, -1);
    let d = p + vec2<i32>(-1, 1);
    let depth_here = inverse_depth(p);
    let across = vec2<f32>(inverse_depth(b) - inverse_depth(a), inverse_depth(d) - inverse_depth(c));
    let n = normal_seen(normal, p);
    let facing = dot(n, -normalize(ray_of_pixel(view, p)));
    let k = 1.0 + 7.0 * clamp((1.0 - facing - 0.5) / 0.5, 0.0, 1.0);
    // The device depth is 1 / distance times a constant, which cancels.
    let depth_edge = 100.0 * length(across) > 1.5 * max(depth_here, inverse_depth(a)) * k;
    let n1 = packed_normal(b) - packed_normal(a);
    let n2 = packed_normal(d) - packed_normal(c);
    let normal_edge = sqrt(dot(n1, n1) + dot(n2, n2)) > 0.4;
    textureStore(errors, p, vec4<f32>(select(0.0, 1.0, depth_edge || normal_edge)));
}
