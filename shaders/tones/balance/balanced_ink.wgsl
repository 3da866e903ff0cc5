// Computes the ink of marks at a darkness that is interpolated between balanced cells.
//
// PAIR: two eyes count the same marks in cells of their own pictures, which are at different positions on the surface.
// Each adds the mean of what both would add at a point of the surface, so that its marks are equally dark for both.
#import hachure::view::View
#import hachure::seen::place_seen
#import hachure::cover::{Balance, first_cell, ink_of}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> balance: Balance;
@group(0) @binding(2) var cover: texture_2d<f32>;
@group(0) @binding(3) var more: texture_2d<f32>;
// Ink, 0 to 1.
@group(0) @binding(4) var marks: texture_storage_2d<r32float, write>;
#ifdef PAIR
@group(0) @binding(5) var<uniform> other_view: View;
@group(0) @binding(6) var distance_m: texture_2d<f32>;
@group(0) @binding(7) var other_more: texture_2d<f32>;
#endif

// Interpolates between cells, at a position on the targets of a view.
fn balanced_at(eye: View, cells: texture_2d<f32>, px: vec2<f32>) -> f32 {
    let place = (px + vec2<f32>(eye.origin_px)) / f32(balance.cell_px) - 0.5;
    let whole = floor(place);
    let f = place - whole;
    let first = vec2<i32>(whole) - first_cell(eye, balance);
    let last = vec2<i32>(balance.cells) - 1;
    var balanced = 0.0;
    for (var i = 0; i < 4; i++) {
        let offset = vec2<i32>(i & 1, i >> 1u);
        let weight = mix(1.0 - f, f, vec2<f32>(offset));
        balanced += weight.x * weight.y * textureLoad(cells, clamp(first + offset, vec2<i32>(0), last), 0).r;
    }
    return balanced;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    var balanced = balanced_at(view, more, vec2<f32>(pixel) + 0.5);
#ifdef PAIR
    let at = place_seen(view, distance_m, pixel);
    let clip = other_view.clip_from_camera * vec4<f32>(at.xyz, 1.0);
    let ndc = clip.xy / max(clip.w, 1e-6);
    let there = vec2<f32>(ndc.x * 0.5 + 0.5, 0.5 - ndc.y * 0.5) * vec2<f32>(other_view.size_px);
    // A point outside of the other eye's picture has been counted by this eye alone.
    let is_inside = all(there >= vec2<f32>(0.0)) && all(there < vec2<f32>(other_view.size_px));
    if at.w > 0.0 && is_inside {
        balanced = 0.5 * (balanced + balanced_at(other_view, other_more, there));
    }
#endif
    textureStore(marks, pixel, vec4<f32>(ink_of(textureLoad(cover, pixel, 0), balanced)));
}
