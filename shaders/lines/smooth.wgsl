// Anti-aliasing of lines: an average along the line that removes specks.
//
// The line image has stairs where a line is nearly horizontal or vertical. Its structure tensor over 3 x 3 pixels gives
// the direction of the line; an average of bilinear samples along it turns stairs into slopes without changing the
// width (the idea is that of flow-based filters: Kang et al. 2007). A line that crosses the neighbourhood has about ten
// inked pixels in it; fewer than a few are a speck, and fade.
#import hachure::view::View

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var line: texture_2d<f32>;
@group(0) @binding(2) var smoothed: texture_storage_2d<r32float, write>;

// Ink within 5 x 5 pixels, in whole pixels, at which a line begins to show, and shows fully.
const SPECK: vec2<f32> = vec2<f32>(2.0, 4.5);

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
    // Rows of three pixels around p.
    let above = vec3<f32>(load(p + vec2<i32>(-1, -1)), load(p + vec2<i32>(0, -1)), load(p + vec2<i32>(1, -1)));
    let here = vec3<f32>(load(p + vec2<i32>(-1, 0)), load(p), load(p + vec2<i32>(1, 0)));
    let below = vec3<f32>(load(p + vec2<i32>(-1, 1)), load(p + vec2<i32>(0, 1)), load(p + vec2<i32>(1, 1)));
    var ink = dot(above + here + below, vec3<f32>(1.0));
    if ink <= 0.0 {
        textureStore(smoothed, p, vec4<f32>(0.0));
        return;
    }
    // The ring around those nine pixels.
    var top = vec3<f32>(0.0);
    var bottom = vec3<f32>(0.0);
    var left = vec3<f32>(0.0);
    var right = vec3<f32>(0.0);
    for (var i = 0; i < 3; i++) {
        top[i] = load(p + vec2<i32>(i - 1, -2));
        bottom[i] = load(p + vec2<i32>(i - 1, 2));
        left[i] = load(p + vec2<i32>(-2, i - 1));
        right[i] = load(p + vec2<i32>(2, i - 1));
    }
    ink += dot(top + bottom + left + right, vec3<f32>(1.0));
    ink += load(p + vec2<i32>(-2, -2)) + load(p + vec2<i32>(2, -2)) + load(p + vec2<i32>(-2, 2)) + load(p + vec2<i32>(2, 2));

    // Structure tensor over the nine pixels, from central differences.
    let dx_above = vec3<f32>(above.y - left.x, above.z - above.x, right.x - above.y);
    let dx_here = vec3<f32>(here.y - left.y, here.z - here.x, right.y - here.y);
    let dx_below = vec3<f32>(below.y - left.z, below.z - below.x, right.z - below.y);
    let dy_above = here - top;
    let dy_here = below - above;
    let dy_below = bottom - here;
    let xx = dot(dx_above, dx_above) + dot(dx_here, dx_here) + dot(dx_below, dx_below);
    let yy = dot(dy_above, dy_above) + dot(dy_here, dy_here) + dot(dy_below, dy_below);
    let xy = dot(dx_above, dy_above) + dot(dx_here, dy_here) + dot(dx_below, dy_below);
    // The direction in which the image changes least. Without a preferred direction nothing is averaged.
    let difference = sqrt((xx - yy) * (xx - yy) + 4.0 * xy * xy);
    let coherence = difference / max(xx + yy, 1e-6);
    let angle = 0.5 * atan2(2.0 * xy, xx - yy) + 1.5707963;
    let along = vec2<f32>(cos(angle), sin(angle)) * coherence;
    let at = vec2<f32>(p);
    var sum = 0.3 * here.y;
    // Without ink the loop ends early, since a software driver runs both sides of a branch.
    let steps = select(1, 2, ink > 0.0);
    for (var i = 0; i < steps; i++) {
        let way = along * select(1.0, 2.2, i == 1);
        sum += select(0.2, 0.15, i == 1) * (bilinear(at + way) + bilinear(at - way));
    }
    // Restores the ink that the average took from the core of a line.
    let value = min(1.25 * sum, 1.0) * smoothstep(SPECK.x, SPECK.y, ink);
    textureStore(smoothed, p, vec4<f32>(value, 0.0, 0.0, 0.0));
}
