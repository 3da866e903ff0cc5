// From numbers of things to numbers of workgroups and instances: what the GPU counted, it draws.
#import hachure::strokes::StrokeCounts
#import hachure::stroke_edges::Strokes

@group(0) @binding(0) var<uniform> strokes: Strokes;
@group(0) @binding(1) var<storage, read> edge_draw: array<u32>;
@group(0) @binding(2) var<storage, read_write> counts: StrokeCounts;
// Workgroups for pieces, workgroups for points, and the indirect draw of points: see `src/lines/strokes/points.rs`.
@group(0) @binding(3) var<storage, read_write> arguments: array<vec4<u32>, 3>;

@compute @workgroup_size(1)
fn main() {
    counts.edges = edge_draw[0] / 2u;
    counts.edges_lost = max(counts.edges, strokes.edge_capacity) - strokes.edge_capacity;
    counts.pieces_lost = max(counts.pieces, strokes.piece_capacity) - strokes.piece_capacity;
    counts.pieces = min(counts.pieces, strokes.piece_capacity);
    counts.points = counts.pieces + counts.chains;
    arguments[0] = vec4<u32>((counts.pieces + 255u) / 256u, 1u, 1u, 0u);
    arguments[1] = vec4<u32>((counts.points + 255u) / 256u, 1u, 1u, 0u);
    arguments[2] = vec4<u32>(6u, counts.points, 0u, 0u);
}
