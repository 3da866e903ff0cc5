// Suggestive contours become edges: where the surface would be a contour for an eye nearby (DeCarlo, Finkelstein,
// Rusinkiewicz, Santella 2003, "Suggestive Contours for Conveying Shape"; Pietrok 2021, section 4.1, draws their pixels).
//
// They are the zeros of the radial curvature at which it rises toward the eye. Their edges go into the list that
// contours are in, so strokes chain both, and a suggestive contour takes up a contour where that ends.
//
// Curves by marching squares over the blocks of `lines/radial` (cells.wgsl). A curve ends where the rise falls below
// `least_rise`, where the surface faces the eye too much for a contour to be near, or where it turns away.
//
// Edges stand in the order of cells (ordered.wgsl): `stage` 0 counts them, 1 writes them, 2 says how many there are now.
#import hachure::view::View
#import hachure::cells::{Corner, Curves, corner_at, curves_of, on_surface, key_of_cell}
#import hachure::edges::{Edge, KIND_SUGGESTIVE}
#import hachure::edge_list::{has_told, has_counted, place_in_list, put_edge}
#import hachure::ordered::{clear_marks, mark}

struct SuggestiveRules {
    least_rise: f32,
    // A cosine: what faces the eye more has none.
    most_facing: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> suggestive_rules: SuggestiveRules;
@group(0) @binding(2) var position: texture_2d<f32>;
@group(0) @binding(3) var normal: texture_2d<f32>;
@group(0) @binding(4) var shape_normal: texture_2d<f32>;
@group(0) @binding(5) var radial: texture_2d<f32>;

fn corner_of(block: vec2<i32>) -> Corner {
    let own = textureLoad(radial, block, 0);
    let rise = (own.y - suggestive_rules.least_rise) / max(suggestive_rules.least_rise, 0.01);
    let room = min(rise, min(suggestive_rules.most_facing - own.z, own.z));
    return corner_at(view, block, textureLoad(shape_normal, block, 0), own.x, room);
}

fn look(block: vec2<i32>) -> Curves {
    if any(block + 1 >= vec2<i32>(textureDimensions(radial))) {
        return Curves();
    }
    return curves_of(view, corner_of(block), corner_of(block + vec2<i32>(1, 0)), corner_of(block + vec2<i32>(1, 1)),
        corner_of(block + vec2<i32>(0, 1)));
}

@compute @workgroup_size(8, 8)
fn main(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    if has_told(thread) {
        return;
    }
    clear_marks(thread);
    workgroupBarrier();
    var found = look(vec2<i32>(id.xy));
    for (var i = 0u; i < found.count; i++) {
        mark(2u * thread + i);
    }
    workgroupBarrier();
    let own_group = group.x + group.y * groups.x;
    if has_counted(own_group, thread) {
        return;
    }
    let first = place_in_list(own_group, 2u * thread);
    for (var i = 0u; i < found.count; i++) {
        put_edge(first + i, Edge(on_surface(view, position, normal, found.lines[i].xy), key_of_cell(view, vec2<i32>(id.xy)) + i,
            on_surface(view, position, normal, found.lines[i].zw), KIND_SUGGESTIVE));
    }
}
