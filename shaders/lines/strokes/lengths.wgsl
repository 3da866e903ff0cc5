// Computes the lengths of strokes between their points, in 1/16 px.
#import hachure::strokes::{StrokeCounts, UNITS_PER_PX}
#import hachure::stroke_style::Point

@group(0) @binding(0) var<storage, read> points: array<Point>;
@group(0) @binding(1) var<storage, read> counts: StrokeCounts;
@group(0) @binding(2) var<storage, read_write> lengths: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let i = id.x;
    let count = counts.points;
    if i >= count {
        return;
    }
    let own = points[i];
    let next = points[min(i + 1u, count - 1u)];
    let is_last = i + 1u == count || next.chain != own.chain;
    lengths[i] = select(u32(round(distance(own.px, next.px) * UNITS_PER_PX)), 0u, is_last);
}
