// Anti-aliasing of lines: an average along the line.
//
// The line image has stairs where a line is nearly horizontal or vertical. Its structure tensor over 3 x 3 pixels gives
// the direction of the line; an average of bilinear samples along it turns stairs into slopes and leaves the width
// alone (the idea is that of flow-based filters: Kang et al. 2007).
#import hachure::view::View

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var line: texture_2d<f32>;
@group(0) @binding(2) var smoothed: texture_storage_2d<r32float, write>;

fn load(pixel: vec2<i32>) -> f32 {
    return textureLoad(line, clamp(pixel, vec2<i32>(0), vec2<i32>(view.size_px) - 1), 0).r;
}

fn bilinear(p: vec2<f32>) -> f32 {
    let whole = floor(p);
    let f = p - whole;
    let i = vec2<i32>(whole);
    return mix(
        mix(load(i), load(i + vec2<i32>(1, 0)), f.x),
        mix(load(i + vec2<i32>(0, 1)), load(i + vec2<i32>(1, 1)), f.x),
        f.y);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let p = vec2<i32>(id.xy);
    var v: array<f32, 25>;
    var most = 0.0;
    for (var y = 0; y < 5; y++) {
        for (var x = 0; x < 5; x++) {
            let value = load(p + vec2<i32>(x - 2, y - 2));
            v[y * 5 + x] = value;
            most = max(most, value);
        }
    }
    if most <= 0.0 {
        textureStore(smoothed, p, vec4<f32>(0.0));
        return;
    }
    // Structure tensor of the 5 x 5 neighbourhood.
    var xx = 0.0;
    var yy = 0.0;
    var xy = 0.0;
    for (var y = 1; y < 4; y++) {
        for (var x = 1; x < 4; x++) {
            let gx = v[y * 5 + x + 1] - v[y * 5 + x - 1];
            let gy = v[(y + 1) * 5 + x] - v[(y - 1) * 5 + x];
            xx += gx * gx;
            yy += gy * gy;
            xy += gx * gy;
        }
    }
    // The direction in which the image changes least; where none is better, do nothing.
    let difference = sqrt((xx - yy) * (xx - yy) + 4.0 * xy * xy);
    let coherence = difference / max(xx + yy, 1e-6);
    let angle = 0.5 * atan2(2.0 * xy, xx - yy) + 1.5707963;
    let along = vec2<f32>(cos(angle), sin(angle)) * coherence;
    let at = vec2<f32>(p);
    var sum = 0.3 * v[12];
    sum += 0.2 * (bilinear(at + along) + bilinear(at - along));
    sum += 0.15 * (bilinear(at + 2.2 * along) + bilinear(at - 2.2 * along));
    textureStore(smoothed, p, vec4<f32>(sum, 0.0, 0.0, 0.0));
}
