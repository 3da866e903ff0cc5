// For each triangle of the meshes that are near enough: its unit normal, and whether it faces the eye (1) or not (-1).
//
// This is decided once per triangle, so that both triangles at an edge agree: contours are then closed, even where a
// triangle is seen edge-on and rounding decides. A triangle that is thinner than the precision of its vertices has no
// side of its own; it takes that of its neighbour across its longest edge, as do rows of such triangles.
#import hachure::dispatch::thread_number
#import hachure::view::{View, from_eye}
#import hachure::meshes::{mesh_instances, mesh_triangles, mesh_places, instance_of, BY_NEAR, corners_of, MeshTriangle, AGAIN}

@group(0) @binding(0) var<storage, read_write> mesh_sides: array<vec4<f32>>;
@group(0) @binding(1) var<uniform> view: View;

// Precision of vertices, relative to their distance.
const EXACT: f32 = 2.5e-7;
// Longest row of thin triangles that is followed; longer ones take the side of the last.
const LONGEST_ROW: i32 = 6;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let number = thread_number(id);
    let standing = mesh_instances[instance_of(number, BY_NEAR)];
    if standing.is_near == 0u || number - standing.near_before >= standing.triangles {
        return;
    }
    var at = number - standing.near_before;
    var sign = 1.0;
    var n = vec3<f32>(0.0);
    var through_m = vec3<f32>(0.0);
    for (var i = 0; i < LONGEST_ROW; i++) {
        let triangle = mesh_triangles[standing.first_triangle + at];
        let corners = corners_of(standing.first_place, triangle);
        let ab = corners.b_m - corners.a_m;
        let bc = corners.c_m - corners.b_m;
        let ca = corners.a_m - corners.c_m;
        let lengths = vec3<f32>(dot(ab, ab), dot(bc, bc), dot(ca, ca));
        let longest = max(max(lengths.x, lengths.y), lengths.z);
        through_m = corners.a_m;
        n = cross(ab, -ca) * sign;
        // Height over the longest edge.
        let height_m = length(n) * inverseSqrt(max(longest, 1e-30));
        if height_m > EXACT * length(through_m) {
            break;
        }
        let across = select(
            select(triangle.across_ca, triangle.across_bc, lengths.y == longest),
            triangle.across_ab, lengths.x == longest);
        if across >= AGAIN {
            break;
        }
        at = across >> 1u;
        sign = select(sign, -sign, (across & 1u) == 1u);
    }
    let area = length(n);
    n = select(vec3<f32>(0.0), n / max(area, 1e-30), area > 0.0);
    mesh_sides[number] = vec4<f32>(n, select(-1.0, 1.0, dot(n, from_eye(view, through_m)) < 0.0));
}
