// Curves of cells (cells.wgsl) go into the list of edges (edge_list.wgsl), in the order of cells.
#define_import_path hachure::cell_edges
#import hachure::view::View
#import hachure::cells::{Curves, on_surface, key_of_cell}
#import hachure::edges::Edge
#import hachure::edge_list::{has_counted, place_in_list, put_edge}
#import hachure::ordered::{clear_marks, mark}

// What runs a pass over cells, one to a thread.
struct Cell {
    block: vec2<i32>,
    thread: u32,
    group: u32,
}

// At stages 0 and 1, by all threads of a workgroup. `first_key` tells the curves of one pass from those of another one.
fn put_curves(view: View, position: texture_2d<f32>, normal: texture_2d<f32>, cell: Cell, found: Curves, kind: u32, first_key: u32) {
    var curves = found;
    clear_marks(cell.thread);
    workgroupBarrier();
    for (var i = 0u; i < curves.count; i++) {
        mark(2u * cell.thread + i);
    }
    workgroupBarrier();
    if has_counted(cell.group, cell.thread) {
        return;
    }
    let first = place_in_list(cell.group, 2u * cell.thread);
    for (var i = 0u; i < curves.count; i++) {
        let line = curves.lines[i];
        put_edge(first + i, Edge(on_surface(view, position, normal, line.xy), key_of_cell(view, cell.block) + i + first_key,
            on_surface(view, position, normal, line.zw), kind));
    }
}
