// Sums, in square cells, the difference between the ink of marks and the requested tone.
#import hachure::view::View
#import hachure::cover::{Balance, first_cell, ink_of, rise_of}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> balance: Balance;
@group(0) @binding(2) var cover: texture_2d<f32>;
// Sums over a cell's pixels of the surface: missing ink, derivative of ink with respect to darkness, number of pixels.
@group(0) @binding(3) var sums: texture_storage_2d<rgba32float, write>;

var<workgroup> rows: array<vec3<f32>, 64>;

// Eight cells per workgroup and eight threads per cell, which take its rows in turn.
@compute @workgroup_size(8, 8)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>) {
    let cell = vec2<i32>(group.xy * vec2<u32>(8u, 1u)) + vec2<i32>(i32(local.x), 0);
    let first = (cell + first_cell(view, balance)) * balance.cell_px - view.origin_px;
    var sum = vec3<f32>(0.0);
    let low = max(first, vec2<i32>(0));
    let high = min(first + balance.cell_px, vec2<i32>(view.size_px));
    for (var y = low.y + i32(local.y); y < high.y; y += 8) {
        for (var x = low.x; x < high.x; x++) {
            let texel = textureLoad(cover, vec2<i32>(x, y), 0);
            sum += vec3<f32>(texel.z - ink_of(texel, 0.0), rise_of(texel), texel.w);
        }
    }
    rows[local.y * 8u + local.x] = sum;
    workgroupBarrier();
    if local.y == 0u && all(vec2<u32>(cell) < balance.cells) {
        for (var i = 1u; i < 8u; i++) {
            sum += rows[i * 8u + local.x];
        }
        textureStore(sums, cell, vec4<f32>(sum, 0.0));
    }
}
