// Edges of the meshes that are near enough, on the triangles as drawn: contours (one side faces the eye, the other does
// not), open borders, and creases where the style wants them. They join the edges of the land (contour_edges.wgsl).
//
// One thread for each triangle. An edge between two belongs to the one with the lesser number. Neighbours that wind the
// other way round (is_turned) have their front where this one has its back, so their side counts the other way.
//
// Pietrok 2021, section 4.2.1, finds edges in a geometry shader with adjacency; here adjacency is in the triangles.
#import hachure::view::View
#import hachure::meshes::{mesh_instances, mesh_triangles, mesh_places, instance_of, BY_NEAR, corners_of, BORDER, AGAIN}
#import hachure::stroke_edges::{Edge, Strokes, is_outside, KIND_CONTOUR, KIND_BORDER, KIND_CREASE}

@group(0) @binding(0) var<storage, read> mesh_sides: array<vec4<f32>>;
@group(0) @binding(1) var<uniform> view: View;
@group(0) @binding(2) var<uniform> strokes: Strokes;
@group(0) @binding(3) var<storage, read_write> edges: array<Edge>;
// An indirect draw of lines: vertices, two for each edge; instances; 0; 0.
@group(0) @binding(4) var<storage, read_write> edge_draw: array<atomic<u32>>;

const ROW: u32 = 65535u;

fn emit(a: vec3<f32>, b: vec3<f32>, kind: u32, key: u32) {
    if is_outside(a, b, view.clip_from_camera, view.near_m) || all(a == b) {
        return;
    }
    let index = atomicAdd(&edge_draw[0], 2u) / 2u;
    if index < strokes.edge_capacity {
        edges[index] = Edge(a, key, b, kind);
    }
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let number = id.x + id.y * ROW * 64u;
    let standing = mesh_instances[instance_of(number, BY_NEAR)];
    let own = number - standing.near_before;
    if standing.is_near == 0u || own >= standing.triangles {
        return;
    }
    let triangle = mesh_triangles[standing.first_triangle + own];
    let corners = corners_of(standing.first_place, triangle);
    let side = mesh_sides[number];
    for (var i = 0u; i < 3u; i++) {
        let from_m = select(select(corners.c_m, corners.b_m, i == 1u), corners.a_m, i == 0u);
        let to_m = select(select(corners.a_m, corners.c_m, i == 1u), corners.b_m, i == 0u);
        let across = select(select(triangle.across_ca, triangle.across_bc, i == 1u), triangle.across_ab, i == 0u);
        // The land's keys are hashes too.
        let key = ((standing.first_number + own) * 3u + i) * 0x9e3779b1u ^ 0x5bd1e995u;
        if across == BORDER {
            emit(from_m, to_m, KIND_BORDER, key);
        } else if across != AGAIN && (across >> 1u) > own {
            let other = mesh_sides[standing.near_before + (across >> 1u)] * select(1.0, -1.0, (across & 1u) == 1u);
            if (side.w > 0.0) != (other.w > 0.0) {
                emit(from_m, to_m, KIND_CONTOUR, key);
            } else if dot(side.xyz, other.xyz) < strokes.crease_cosine && (side.w > 0.0 || standing.is_solid == 0u) {
                emit(from_m, to_m, KIND_CREASE, key);
            }
        }
    }
}
