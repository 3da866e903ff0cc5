// What the bar leaves of lines.
//
// PAIR: two eyes count in cells of their own pictures. Each takes the mean of the bars of both at a place of the
// surface, so that both leave out the same lines.
#import hachure::view::View
#import hachure::crowd::{Crowd, bar_at, left_of}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> crowd: Crowd;
@group(0) @binding(2) var line: texture_2d<f32>;
@group(0) @binding(3) var rank: texture_2d<f32>;
@group(0) @binding(4) var bars: texture_2d<f32>;
@group(0) @binding(5) var thinned: texture_storage_2d<r32float, write>;
#ifdef PAIR
@group(0) @binding(6) var<uniform> other_view: View;
@group(0) @binding(7) var position: texture_2d<f32>;
@group(0) @binding(8) var other_bars: texture_2d<f32>;
#endif

// Pixels to either side whose ranks a line's rank is the mean of, by their ink: a rank is noisy, and a line whole.
const AROUND: i32 = 3;

fn rank_at(pixel: vec2<i32>) -> f32 {
    var sum = vec2<f32>(0.0);
    for (var y = -AROUND; y <= AROUND; y++) {
        for (var x = -AROUND; x <= AROUND; x++) {
            let at = clamp(pixel + vec2<i32>(x, y), vec2<i32>(0), vec2<i32>(view.size_px) - 1);
            let ink = textureLoad(line, at, 0).r;
            sum += ink * vec2<f32>(textureLoad(rank, at, 0).r, 1.0);
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
    var left = 0.0;
    if ink > 0.0 {
        var bar = bar_at(view, crowd, bars, vec2<f32>(pixel) + 0.5);
#ifdef PAIR
        let at = textureLoad(position, pixel, 0);
        let clip = other_view.clip_from_camera * vec4<f32>(at.xyz, 1.0);
        let ndc = clip.xy / max(clip.w, 1e-6);
        let there = vec2<f32>(ndc.x * 0.5 + 0.5, 0.5 - ndc.y * 0.5) * vec2<f32>(other_view.size_px);
        let is_inside = all(there >= vec2<f32>(0.0)) && all(there < vec2<f32>(other_view.size_px));
        if at.w > 0.0 && is_inside {
            bar = 0.5 * (bar + bar_at(other_view, crowd, other_bars, there));
        }
#endif
        left = ink * left_of(bar, rank_at(pixel));
    }
    textureStore(thinned, pixel, vec4<f32>(left));
}
