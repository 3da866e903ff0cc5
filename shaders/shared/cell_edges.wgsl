// Appends curves of cells (cells.wgsl) to the edge list (edge_list.wgsl), in the order of the cells.
#define_import_path hachure::cell_edges
#import hachure::view::View
#import hachure::cells::{Curves, on_surface, key_of_cell}
#import hachure::edges::Edge
#import hachure::edge_list::{has_counted, place_in_list, put_edge}
#import hachure::ordered::{clear_marks, mark}

// The cell that a thread works on; each thread has one.
struct Cell {
    block: vec2<i32>,
    thread: u32,
    group: u32,
    // Number of workgroups.
    groups: u32,
}

// Appends the curves of a cell. All threads of a workgroup call it, at stages 0 and 1. `first_key` separates the keys
// of one pass from those of another.
fn put_curves(view: View, distance_m: texture_2d<f32>, normal: texture_2d<u32>, cell: Cell, found: Curves, kind: u32, first_key: u32) {
    var curves = found;
    clear_marks(cell.thread);
    workgroupBarrier();
    for (var i = 0u; i < curves.count; i++) {
        mark(2u * cell.thread + i);
    }
    workgroupBarrier();
    if has_counted(cell.group, cell.groups, cell.thread) {
        return;
    }
    let first = place_in_list(cell.group, 2u * cell.thread);
    for (var i = 0u; i < curves.count; i++) {
        let line = curves.lines[i];
        put_edge(first + i, Edge(on_surface(view, distance_m, normal, line.xy), key_of_cell(view, cell.block) + i + first_key,
            on_surface(view, distance_m, normal, line.zw), kind));
    }
}
