// The curvature of meshes, at the blocks of pixels that see one: interpolated between the corners of the triangle,
// where it was computed when the mesh was loaded (src/mesh/curvature.rs).
//
// This runs after surface/curvature, and overwrites its output. The forms of corners are transformed to the tangent
// frame of the pixel's normal. A mesh has no smoothed forms as the land has, so its curvature is used as it is.
#import hachure::view::{View, from_eye, place_of_pixel, ray_of_pixel, distance_from_eye}
#import hachure::seen::{normal_seen, place_seen}
#import hachure::meshes::{mesh_instances, mesh_triangles, mesh_places, instance_of, BY_NUMBER, corners_of, MeshInstance}
#import hachure::mark_normal::{block_count, pixel_of_block}
#import hachure::curvature::{frame_of, form2, form3}
#import hachure::surface_id::{kind_of, FIRST_MESH, MESH}

struct CurvatureRules {
    // Size of a feature, in pixels.
    feature_px: f32,
}

// The curvature at a vertex, in the axes and the unit of its mesh.
struct VertexShape {
    normal: vec3<f32>,
    padding_a: f32,
    // Second fundamental form in 1/unit, and its derivative in 1/unit².
    bend: vec3<f32>,
    padding_b: f32,
    change: vec4<f32>,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> curvature_rules: CurvatureRules;
@group(0) @binding(2) var surface_id: texture_2d<u32>;
@group(0) @binding(3) var distance_m: texture_2d<f32>;
@group(0) @binding(4) var normal: texture_2d<u32>;
@group(0) @binding(5) var<storage, read> mesh_shapes: array<VertexShape>;
@group(0) @binding(6) var shape_normal: texture_storage_2d<rgba32float, write>;
@group(0) @binding(7) var shape_bend: texture_storage_2d<rgba32float, write>;
@group(0) @binding(8) var shape_change: texture_storage_2d<rgba32float, write>;

// Sum over the corners, in the pixel's tangent frame.
struct Sum {
    bend: vec3<f32>,
    change: vec4<f32>,
}

fn with_corner(sum: Sum, standing: MeshInstance, corner: u32, part: f32, n: vec3<f32>, frame: mat2x3<f32>, scale: f32) -> Sum {
    let shape = mesh_shapes[standing.first_vertex + corner];
    let axes = mat3x3<f32>(standing.east.xyz, standing.north.xyz, standing.up.xyz) * (1.0 / scale);
    // Seen from its back a surface bends the other way.
    let side = part * sign(dot(n, shape.normal * axes));
    let own = frame_of(shape.normal);
    let from_own = mat2x3<f32>(own[0] * axes, own[1] * axes);
    let u = frame[0] * from_own;
    let v = frame[1] * from_own;
    let bend = vec3<f32>(form2(shape.bend, u, u), form2(shape.bend, u, v), form2(shape.bend, v, v));
    let change = vec4<f32>(form3(shape.change, u, u, u), form3(shape.change, u, u, v), form3(shape.change, u, v, v),
        form3(shape.change, v, v, v));
    return Sum(sum.bend + side / scale * bend, sum.change + side / (scale * scale) * change);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let block = vec2<i32>(id.xy);
    if any(id.xy >= block_count(view)) {
        return;
    }
    let pixel = pixel_of_block(view, block);
    let found = textureLoad(surface_id, pixel, 0).r;
    if kind_of(found) != MESH {
        return;
    }
    let number = found ^ FIRST_MESH;
    let standing = mesh_instances[instance_of(number, BY_NUMBER)];
    let triangle = mesh_triangles[standing.first_triangle + number - standing.first_number];
    let corners = corners_of(standing.first_place, triangle);
    let at = place_seen(view, distance_m, pixel);
    let n = normal_seen(normal, pixel);
    let u = corners.b_m - corners.a_m;
    let v = corners.c_m - corners.a_m;
    let face = cross(u, v);
    let from_a = at.xyz - corners.a_m;
    let by_area = 1.0 / max(dot(face, face), 1e-30);
    let by_b = clamp(dot(cross(from_a, v), face) * by_area, 0.0, 1.0);
    let by_c = clamp(dot(cross(u, from_a), face) * by_area, 0.0, 1.0 - by_b);
    // All columns of the matrix have the same length.
    let scale = max(length(vec3<f32>(standing.east.x, standing.north.x, standing.up.x)), 1e-30);
    let frame = frame_of(n);
    var sum = Sum(vec3<f32>(0.0), vec4<f32>(0.0));
    sum = with_corner(sum, standing, triangle.corner_a, 1.0 - by_b - by_c, n, frame, scale);
    sum = with_corner(sum, standing, triangle.corner_b, by_b, n, frame, scale);
    sum = with_corner(sum, standing, triangle.corner_c, by_c, n, frame, scale);
    let feature_m = curvature_rules.feature_px * distance_from_eye(view, at.xyz) / view.focal_px;
    textureStore(shape_normal, block, vec4<f32>(n, at.w));
    textureStore(shape_bend, block, vec4<f32>(sum.bend, feature_m));
    textureStore(shape_change, block, sum.change);
}
