// Appends to the edge list (edges.wgsl) in an order that does not depend on timing (ordered.wgsl).
//
// A pass that appends edges runs in three stages:
// - Stages 0 and 1: each workgroup clears its marks, and marks the threads that have found edges.
// - Stage 0 ends with `has_counted`, which stores the number of edges of each workgroup.
// - Stage 1 writes the edges, from `place_in_list` on.
// - Stage 2 only adds the number of new edges to the total (`has_updated_total`).
#define_import_path hachure::edge_list
#import hachure::edges::{Edge, MAX_EDGES}
#import hachure::ordered::{Order, all_marks, marks_before}

@group(0) @binding(25) var<storage, read_write> edges: array<Edge>;
// Arguments of an indirect draw of lines: vertices (two for each edge), instances, 0, 0.
@group(0) @binding(26) var<storage, read_write> edge_draw: array<u32>;
@group(0) @binding(27) var<storage, read_write> order: Order;

// Adds the number of new edges to the total at stage 2. Returns whether this is stage 2, in which case the pass has
// nothing else to do.
fn has_updated_total(thread: u32) -> bool {
    if order.stage == 2u && thread == 0u {
        edge_draw[0] += 2u * order.starts[order.groups];
    }
    return order.stage == 2u;
}

// Stores the workgroup's count at stage 0, after all of its marks. Returns whether this is stage 0, which ends here.
fn has_counted(group: u32, thread: u32) -> bool {
    if order.stage == 0u && thread == 0u {
        order.starts[group] = all_marks();
    }
    return order.stage == 0u;
}

// Returns the index in the list of the edge that a workgroup marked by `number`.
fn place_in_list(group: u32, number: u32) -> u32 {
    return edge_draw[0] / 2u + order.starts[group] + marks_before(number);
}

// Writes an edge; edges beyond the list's capacity are dropped.
fn put_edge(place: u32, edge: Edge) {
    if place < MAX_EDGES {
        edges[place] = edge;
    }
}
