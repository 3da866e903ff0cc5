// The ink of marks at a darkness that is balanced between the cells around.
#import hachure::view::View
#import hachure::cover::{Balance, first_cell, ink_of}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> balance: Balance;
@group(0) @binding(2) var cover: texture_2d<f32>;
@group(0) @binding(3) var more: texture_2d<f32>;
// Ink, 0 to 1.
@group(0) @binding(4) var marks: texture_storage_2d<r32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let place = (vec2<f32>(pixel + view.origin_px) + 0.5) / f32(balance.cell_px) - 0.5;
    let whole = floor(place);
    let f = place - whole;
    let first = vec2<i32>(whole) - first_cell(view, balance);
    let last = vec2<i32>(textureDimensions(more)) - 1;
    var balanced = 0.0;
    for (var i = 0; i < 4; i++) {
        let offset = vec2<i32>(i & 1, i >> 1u);
        let weight = mix(1.0 - f, f, vec2<f32>(offset));
        balanced += weight.x * weight.y * textureLoad(more, clamp(first + offset, vec2<i32>(0), last), 0).r;
    }
    textureStore(marks, pixel, vec4<f32>(ink_of(textureLoad(cover, pixel, 0), balanced)));
}
