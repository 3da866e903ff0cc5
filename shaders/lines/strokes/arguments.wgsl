// Converts counts on the GPU into workgroup counts of indirect dispatches.
#import hachure::strokes::StrokeCounts
#import hachure::edges::MAX_EDGES
#import hachure::stroke_style::Strokes

@group(0) @binding(0) var<uniform> strokes: Strokes;
@group(0) @binding(2) var<storage, read> edge_draw: array<u32>;
@group(0) @binding(3) var<storage, read_write> counts: StrokeCounts;
// Workgroups for segments and for points: see `src/lines/strokes/points.rs`.
@group(0) @binding(4) var<storage, read_write> arguments: array<vec4<u32>, 2>;

@compute @workgroup_size(1)
fn main() {
    counts.edges = edge_draw[0] / 2u;
    counts.edges_lost = max(counts.edges, MAX_EDGES) - MAX_EDGES;
    counts.segments_lost = max(counts.segments, strokes.segment_capacity) - strokes.segment_capacity;
    counts.segments = min(counts.segments, strokes.segment_capacity);
    counts.points = counts.segments + counts.chains;
    arguments[0] = vec4<u32>((counts.segments + 255u) / 256u, 1u, 1u, 0u);
    arguments[1] = vec4<u32>((counts.points + 255u) / 256u, 1u, 1u, 0u);
}
