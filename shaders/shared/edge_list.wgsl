// How passes add to the list of edges (edges.wgsl), in an order that does not depend on timing (ordered.wgsl).
//
// A pass runs at three stages. At 0 and 1 each workgroup clears its marks and marks what it has found; `has_counted` ends
// stage 0, and at stage 1 edges go from `place_in_list` on. `has_told` is stage 2, which says how many edges there are
// now.
#define_import_path hachure::edge_list
#import hachure::edges::{Edge, MOST_EDGES}
#import hachure::ordered::{Order, all_marks, marks_before}

@group(0) @binding(25) var<storage, read_write> edges: array<Edge>;
// An indirect draw of lines: vertices, two for each edge; instances; 0; 0.
@group(0) @binding(26) var<storage, read_write> edge_draw: array<u32>;
@group(0) @binding(27) var<storage, read_write> order: Order;

// At stage 2 nothing else is to be done.
fn has_told(thread: u32) -> bool {
    if order.stage == 2u && thread == 0u {
        edge_draw[0] += 2u * order.starts[order.groups];
    }
    return order.stage == 2u;
}

// After all marks of a workgroup; at stage 0 that was all.
fn has_counted(group: u32, thread: u32) -> bool {
    if order.stage == 0u && thread == 0u {
        order.starts[group] = all_marks();
    }
    return order.stage == 0u;
}

// Where the list has the edge that a workgroup marked by this number.
fn place_in_list(group: u32, number: u32) -> u32 {
    return edge_draw[0] / 2u + order.starts[group] + marks_before(number);
}

// Edges for which there is no room are left out.
fn put_edge(place: u32, edge: Edge) {
    if place < MOST_EDGES {
        edges[place] = edge;
    }
}
