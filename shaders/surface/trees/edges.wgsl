// Contours and open borders of the trees whose near meshes are drawn, on the triangles as drawn, including their lean
// in the wind. They are appended to the edges of the land and of models.
//
// A workgroup has 64 edges of a tree. Edges are in the order of trees (near.wgsl), then of their mesh: stage 0 counts
// them, 1 writes them (ordered.wgsl).
//
// An edge between two triangles is a contour if both are on the same side of the plane through the edge and the eye.
// Pietrok 2021, section 4.2.1, compares the sides of two triangles; this test is equivalent but independent of winding,
// because sheets of leaves wind both ways. A crown has hundreds of leaves, and their contours against each other would
// be black; so each edge requires something far behind it (id_image.wgsl), which leaves the outline and open arcs
// within it.
#import hachure::view::{View, is_off_screen}
#import hachure::earth::bend
#import hachure::edges::{Edge, is_outside, kind_with_clearance, KIND_CONTOUR, KIND_BORDER}
#import hachure::edge_list::{has_counted, place_in_list, put_edge}
#import hachure::dispatch::GROUPS_IN_ROW
#import hachure::ordered::{clear_marks, mark}
#import hachure::pcg::pcg
#import hachure::trees::{TreeInstance, place_on_tree, species_of, clear_m}
#ifdef WIND
#import hachure::wind::{Wind, Sway, moved_by_wind}
#endif

// An edge of a tree of height 1, and the opposite corner of each adjacent triangle. The last component is how far wind
// moves the point.
struct TreeEdge {
    a: vec4<f32>,
    b: vec4<f32>,
    c: vec4<f32>,
    // Negative w: there is no second triangle.
    d: vec4<f32>,
}

// The edges of a species among all edges: the first one, and their number.
struct TreeEdges {
    first: u32,
    count: u32,
}

// Edges of all species.
struct EdgesOfSpecies {
    rules: TreeEdgeRules,
    each: array<TreeEdges>,
}

struct TreeEdgeRules {
    // Workgroups per tree.
    groups: u32,
    // Distance beyond which something must be behind an edge, in heights of the tree.
    clearance: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(6) var<storage, read> tree_instances: array<TreeInstance>;
// Number of near trees, then the indices of their instances.
@group(0) @binding(7) var<storage, read> near_order: array<u32>;
// Edges of all species.
@group(0) @binding(8) var<storage, read> tree_edges: array<TreeEdge>;
@group(0) @binding(9) var<storage, read> edges_of_species: EdgesOfSpecies;
#ifdef WIND
@group(0) @binding(30) var<uniform> wind: Wind;
@group(0) @binding(31) var<storage, read> tree_sways: array<Sway>;
#endif

// Returns a point of a tree as drawn.
fn place_of(number: u32, own: vec4<f32>) -> vec3<f32> {
    let tree = tree_instances[number];
    var from_foot_m = place_on_tree(tree, own.xyz);
#ifdef WIND
    from_foot_m += moved_by_wind(wind, view.focal_px, tree, tree_sways[number], own, from_foot_m)[0];
#endif
    return bend(tree.flat_m + from_foot_m);
}

// Returns the depth of a point along the view axis.
fn along_of(at_m: vec3<f32>) -> f32 {
    return (view.clip_from_camera * vec4<f32>(at_m, 1.0)).w;
}

struct Found {
    is_edge: bool,
    edge: Edge,
}

fn edge_of(group: u32, thread: u32) -> Found {
    var found: Found;
    found.is_edge = false;
    let which = group / edges_of_species.rules.groups;
    if which >= near_order[0] {
        return found;
    }
    let number = near_order[1u + which];
    let tree = tree_instances[number];
    let all = edges_of_species.each[species_of(tree)];
    let own = group % edges_of_species.rules.groups * 64u + thread;
    // A tree of which only the shadow is in view has no edges in the picture.
    let reach_m = 0.6 * tree.height_m + tree.width_m;
    if own >= all.count || is_off_screen(view, bend(tree.flat_m + vec3<f32>(0.0, 0.0, 0.5 * tree.height_m)), reach_m) {
        return found;
    }
    let record = tree_edges[all.first + own];
    var a_m = place_of(number, record.a);
    var b_m = place_of(number, record.b);
    if is_outside(a_m, b_m, view.clip_from_camera, view.near_m) {
        return found;
    }
    let has_two = record.d.w >= 0.0;
    if has_two {
        let aside = cross(a_m - view.eye_m, b_m - a_m);
        let c_side = dot(aside, place_of(number, record.c) - a_m);
        let d_side = dot(aside, place_of(number, record.d) - a_m);
        if (c_side > 0.0) != (d_side > 0.0) {
            return found;
        }
    }
    // An edge ends where raster.wgsl clips the mesh.
    let along_m = vec2<f32>(along_of(a_m), along_of(b_m));
    let near_m = clear_m(tree, view.eye_m);
    if max(along_m.x, along_m.y) <= near_m {
        return found;
    }
    let cut = clamp((near_m - along_m) / (along_m.yx - along_m), vec2<f32>(0.0), vec2<f32>(1.0));
    let ends_m = array<vec3<f32>, 2>(a_m, b_m);
    if along_m.x < near_m {
        a_m = mix(ends_m[0], ends_m[1], cut.x);
    }
    if along_m.y < near_m {
        b_m = mix(ends_m[1], ends_m[0], cut.y);
    }
    let kind = kind_with_clearance(select(KIND_BORDER, KIND_CONTOUR, has_two), edges_of_species.rules.clearance * tree.height_m);
    found.is_edge = true;
    found.edge = Edge(a_m, pcg(vec2<u32>(tree.id, own)).x, b_m, kind);
    return found;
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    clear_marks(thread);
    workgroupBarrier();
    let own_group = group.x + group.y * GROUPS_IN_ROW;
    let found = edge_of(own_group, thread);
    if found.is_edge {
        mark(thread);
    }
    workgroupBarrier();
    if has_counted(own_group, groups.x * groups.y, thread) {
        return;
    }
    if found.is_edge {
        put_edge(place_in_list(own_group, thread), found.edge);
    }
}
