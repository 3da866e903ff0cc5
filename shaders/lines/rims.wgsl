// Takes away the lines along the rims of holes: there the data end and not the land, and a rim has a line of its own.
//
// A detector's line lies on both sides of what it finds, up to two pixels away. Beside the rim of a hole is land that the
// rim knows as such; what is seen through the hole knows nothing, and asks around.
#import hachure::view::View

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var line: texture_2d<f32>;
// Ink of the rims; 1 on land beside a hole.
@group(0) @binding(2) var rim: texture_2d<f32>;
@group(0) @binding(3) var rimless: texture_storage_2d<r32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let p = vec2<i32>(id.xy);
    let last = vec2<i32>(view.size_px) - 1;
    let found = textureLoad(line, p, 0).r;
    var beside = 0.0;
    if found > 0.0 {
        for (var y = -2; y <= 2; y++) {
            for (var x = -2; x <= 2; x++) {
                let q = clamp(p + vec2<i32>(x, y), vec2<i32>(0), last);
                beside = max(beside, textureLoad(rim, q, 0).g);
            }
        }
    }
    textureStore(rimless, p, vec4<f32>(found * (1.0 - beside), 0.0, 0.0, 0.0));
}
