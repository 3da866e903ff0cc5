// Edges of the meshes that are near enough, on the triangles as drawn: contours (one side faces the eye, the other does
// not), open borders, and creases if the style wants them. They are appended to the edges of the land
// (land/edges.wgsl).
//
// There is one thread per triangle, and edges are in the order of triangles (ordered.wgsl): `stage` 0 counts them, 1
// writes them, 2 updates their number. An edge between two triangles belongs to the one with the lesser number. A
// neighbour with opposite winding (is_turned) has its front where this triangle has its back, so its side is negated.
//
// Pietrok 2021, section 4.2.1, finds edges in a geometry shader with adjacency; here adjacency is stored in the
// triangles.
#import hachure::view::View
#import hachure::meshes::{mesh_instances, mesh_triangles, mesh_places, instance_of, BY_NEAR, corners_of, BORDER, AGAIN}
#import hachure::edges::{Edge, EdgeRules, is_outside, KIND_CONTOUR, KIND_BORDER, KIND_CREASE}
#import hachure::edge_list::{has_counted, place_in_list, put_edge}
#import hachure::dispatch::thread_number
#import hachure::ordered::{clear_marks, mark}

@group(0) @binding(0) var<storage, read> mesh_sides: array<vec4<f32>>;
@group(0) @binding(1) var<uniform> view: View;
@group(0) @binding(2) var<uniform> edge_rules: EdgeRules;

// The edges of a triangle; `count` of them are valid.
struct Found {
    edges: array<Edge, 3>,
    count: u32,
}

fn edges_of(number: u32) -> Found {
    var found: Found;
    found.count = 0u;
    let standing = mesh_instances[instance_of(number, BY_NEAR)];
    let own = number - standing.near_before;
    if standing.is_near == 0u || own >= standing.triangles {
        return found;
    }
    let triangle = mesh_triangles[standing.first_triangle + own];
    let corners = corners_of(standing.first_place, triangle);
    let side = mesh_sides[number];
    for (var i = 0u; i < 3u; i++) {
        let from_m = select(select(corners.c_m, corners.b_m, i == 1u), corners.a_m, i == 0u);
        let to_m = select(select(corners.a_m, corners.c_m, i == 1u), corners.b_m, i == 0u);
        let across = select(select(triangle.across_ca, triangle.across_bc, i == 1u), triangle.across_ab, i == 0u);
        if is_outside(from_m, to_m, view.clip_from_camera, view.near_m) || all(from_m == to_m) {
            continue;
        }
        var is_edge = across == BORDER;
        var kind = KIND_BORDER;
        if across != BORDER && across != AGAIN && (across >> 1u) > own {
            let other = mesh_sides[standing.near_before + (across >> 1u)] * select(1.0, -1.0, (across & 1u) == 1u);
            let is_contour = (side.w > 0.0) != (other.w > 0.0);
            let is_shown = side.w > 0.0 || standing.is_solid == 0u;
            kind = select(KIND_CREASE, KIND_CONTOUR, is_contour);
            is_edge = is_contour || dot(side.xyz, other.xyz) < edge_rules.crease_cosine && is_shown;
        }
        if is_edge {
            // The land's keys are hashes too.
            let key = ((standing.first_number + own) * 3u + i) * 0x9e3779b1u ^ 0x5bd1e995u;
            found.edges[found.count] = Edge(from_m, key, to_m, kind);
            found.count += 1u;
        }
    }
    return found;
}

@compute @workgroup_size(64)
fn main(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    clear_marks(thread);
    workgroupBarrier();
    let found = edges_of(thread_number(id));
    for (var i = 0u; i < found.count; i++) {
        mark(thread * 3u + i);
    }
    workgroupBarrier();
    let own_group = group.x + group.y * groups.x;
    if has_counted(own_group, groups.x * groups.y, thread) {
        return;
    }
    let first = place_in_list(own_group, thread * 3u);
    for (var i = 0u; i < found.count; i++) {
        put_edge(first + i, found.edges[i]);
    }
}
