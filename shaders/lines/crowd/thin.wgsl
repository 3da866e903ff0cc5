// Thins out crowded lines of pixels: ink below the bar of its rank is removed (crowd.wgsl).
#import hachure::view::View
#import hachure::crowd::{Crowd, bar_at, remaining_part}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> crowd: Crowd;
@group(0) @binding(2) var line: texture_2d<f32>;
// Rank of the line, and how far the cap holds for it, in 16 bits each (rank.wgsl).
@group(0) @binding(3) var rank: texture_2d<u32>;
@group(0) @binding(4) var bars: texture_2d<f32>;
@group(0) @binding(5) var thinned: texture_storage_2d<r32float, write>;

// Radius in pixels over which ranks are averaged, weighted by ink, because ranks are noisy along a line.
const RADIUS_PX: i32 = 3;

fn ranked(pixel: vec2<i32>) -> vec2<f32> {
    return unpack2x16unorm(textureLoad(rank, pixel, 0).r);
}

// Returns the mean rank of the ink around a pixel. Without ink the loop ends early, since a software driver runs both
// sides of a branch.
fn rank_at(pixel: vec2<i32>, has_ink: bool) -> f32 {
    var sum = vec2<f32>(0.0);
    let last = select(-RADIUS_PX, RADIUS_PX, has_ink);
    for (var y = -RADIUS_PX; y <= last; y++) {
        for (var x = -RADIUS_PX; x <= RADIUS_PX; x++) {
            let at = clamp(pixel + vec2<i32>(x, y), vec2<i32>(0), vec2<i32>(view.size_px) - 1);
            let ink = textureLoad(line, at, 0).r;
            sum += ink * vec2<f32>(ranked(at).x, 1.0);
        }
    }
    return sum.x / max(sum.y, 1e-6);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let ink = textureLoad(line, pixel, 0).r;
    var remaining = 0.0;
    if ink > 0.0 {
        let bar = bar_at(view, crowd, bars, vec2<f32>(pixel) + 0.5);
        remaining = ink * mix(1.0, remaining_part(bar, rank_at(pixel, ink > 0.0)), ranked(pixel).y);
    }
    textureStore(thinned, pixel, vec4<f32>(remaining));
}
