// Draws the centre lines of strokes, a pixel and a half wide, with the id of their samples. The ink of a wide stroke
// covers the centres of its neighbours, so the image of its ids does not show where they are.
#import hachure::view::View
#import hachure::stroke_samples::{Sample, SampleCounts, LAST}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> sample_counts: SampleCounts;
@group(0) @binding(2) var<storage, read> samples: array<Sample>;

struct Vertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) id: u32,
}

const HALF_WIDTH_PX: f32 = 0.75;
// Largest coordinate at which anything is drawn; rounding fails beyond.
const FAR_OUT_PX: f32 = 32768.0;

fn is_out(own: Sample) -> bool {
    return own.depth_m < view.near_m || any(abs(own.px) > vec2<f32>(FAR_OUT_PX));
}

@vertex
fn vertex(@builtin(vertex_index) corner: u32, @builtin(instance_index) number: u32) -> Vertex {
    let begin = samples[number];
    let nothing = Vertex(vec4<f32>(2.0, 2.0, 0.0, 1.0), 0u);
    if number + 1u >= sample_counts.fresh || (begin.flags & LAST) != 0u {
        return nothing;
    }
    let end = samples[number + 1u];
    let along = end.px - begin.px;
    if is_out(begin) || is_out(end) || length(along) < 1e-4 {
        return nothing;
    }
    let way = normalize(along) * HALF_WIDTH_PX;
    // Corners 0 1 2, 2 1 3: even ones at this sample, odd ones at the next; the first two on the left.
    let slot = array<u32, 6>(0u, 1u, 2u, 2u, 1u, 3u)[corner];
    let side = select(1.0, -1.0, slot >= 2u);
    let is_next = (slot & 1u) == 1u;
    let px = select(begin.px - way, end.px + way, is_next) + vec2<f32>(way.y, -way.x) * side;
    let ndc = px / vec2<f32>(view.size_px) * vec2<f32>(2.0, -2.0) + vec2<f32>(-1.0, 1.0);
    return Vertex(vec4<f32>(ndc, 0.0, 1.0), number + 1u);
}

@fragment
fn fragment(in: Vertex) -> @location(0) u32 {
    return in.id;
}
