// Appends to the edge list (edges.wgsl) in an order that does not depend on timing (ordered.wgsl).
//
// A pass that appends edges runs in two stages. At both, each workgroup clears its marks, and marks the threads that
// have found edges. Stage 0 then ends with `has_counted`, which stores the number of edges of each workgroup; stage 1
// goes on, and writes the edges from `place_in_list` on.
#define_import_path hachure::edge_list
#import hachure::edges::{Edge, MAX_EDGES}
#import hachure::ordered::{Order, all_marks, is_counting, marks_before}

@group(0) @binding(25) var<storage, read_write> edges: array<Edge>;
// Arguments of an indirect draw of lines: vertices (two for each edge), instances, 0, 0.
@group(0) @binding(26) var<storage, read_write> edge_draw: array<u32>;
@group(0) @binding(27) var<storage, read_write> order: Order;

// Stores the workgroup's count at stage 0, after all of its marks; at stage 1, the first of all `groups` workgroups
// updates the number of edges. Returns whether this is stage 0, which ends here.
fn has_counted(group: u32, groups: u32, thread: u32) -> bool {
    let counts = is_counting();
    if counts && thread == 0u {
        order.starts[group] = all_marks();
        if group == 0u {
            order.before = edge_draw[0] / 2u;
        }
    }
    if !counts && group == 0u && thread == 0u {
        edge_draw[0] = 2u * (order.before + order.starts[groups]);
    }
    return counts;
}

// Returns the index in the list of the edge that a workgroup marked by `number`.
fn place_in_list(group: u32, number: u32) -> u32 {
    return order.before + order.starts[group] + marks_before(number);
}

// Writes an edge; edges beyond the list's capacity are dropped.
fn put_edge(place: u32, edge: Edge) {
    if place < MAX_EDGES {
        edges[place] = edge;
    }
}
