// Computes distance and normal where a mesh is visible, with the lightness of its material: the pixel's ray is
// intersected with the plane of the triangle that the rasteriser found there, and the normals of its corners are
// interpolated.
//
// This runs after surface/land/resolve, and overwrites its output. Pixels of the land are not touched, so they are
// bit-identical to those without meshes. Where the ray is almost parallel to the triangle, its plane is inaccurate, and
// the rasteriser's depth is used.
#import hachure::view::{View, from_eye, place_of_pixel, ray_of_pixel}
#import hachure::seen::words_of_surface
#import hachure::meshes::{mesh_instances, mesh_triangles, mesh_places, instance_of, BY_NUMBER, corners_of, normal_from}
#import hachure::surface_id::{kind_of, FIRST_MESH, MESH}
#import hachure::earth::unbend

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var surface_id: texture_2d<u32>;
@group(0) @binding(2) var depth: texture_depth_2d;
@group(0) @binding(3) var distance_m: texture_storage_2d<r32float, write>;
@group(0) @binding(4) var normal: texture_storage_2d<rg32uint, write>;
#ifdef LOCAL_COLOR
// Colour of each triangle of the meshes themselves: see hachure::local_color.
@group(0) @binding(5) var<storage, read> mesh_colors: array<u32>;
@group(0) @binding(6) var local_color: texture_storage_2d<r32uint, write>;
#endif

// Largest relative difference between the depths of the plane and of the rasteriser.
const LIKE: f32 = 1e-3;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let found = textureLoad(surface_id, pixel, 0).r;
    if kind_of(found) != MESH {
        return;
    }
    let number = found ^ FIRST_MESH;
    let standing = mesh_instances[instance_of(number, BY_NUMBER)];
    let own = standing.first_triangle + number - standing.first_number;
    let triangle = mesh_triangles[own];
    let corners = corners_of(standing.first_place, triangle);
    let u = corners.b_m - corners.a_m;
    let v = corners.c_m - corners.a_m;
    let face = cross(u, v);

    let ray = ray_of_pixel(view, pixel);
    let drawn_m = view.near_m / textureLoad(depth, pixel, 0);
    let closing = dot(face, ray);
    let cut_m = dot(face, from_eye(view, corners.a_m)) / select(closing, 1.0, closing == 0.0);
    let is_like = closing != 0.0 && abs(cut_m - drawn_m) <= LIKE * drawn_m;
    let along_m = select(drawn_m, cut_m, is_like);
    let at_m = place_of_pixel(view, pixel, along_m);

    // Position in the triangle; a pixel at its edge may be slightly outside.
    let from_a = at_m - corners.a_m;
    let scale = 1.0 / max(dot(face, face), 1e-30);
    let by_b = dot(cross(from_a, v), face) * scale;
    let by_c = dot(cross(u, from_a), face) * scale;
    let parts = clamp(vec3<f32>(1.0 - by_b - by_c, by_b, by_c), vec3<f32>(0.0), vec3<f32>(1.0));
    let mixed = normal_from(triangle.normal_a) * parts.x + normal_from(triangle.normal_b) * parts.y
        + normal_from(triangle.normal_c) * parts.z;
    let turned = vec3<f32>(dot(standing.east.xyz, mixed), dot(standing.north.xyz, mixed), dot(standing.up.xyz, mixed));
    // The normal of the visible side. At the rim of a round shape the interpolated normal may face away from the eye,
    // but not away from its own triangle's front.
    let front = select(face, -face, closing > 0.0);
    var n = turned * inverseSqrt(max(dot(turned, turned), 1e-30));
    if dot(turned, turned) < 1e-20 {
        n = front * inverseSqrt(max(dot(front, front), 1e-30));
    }
    n = select(n, -n, dot(n, front) < 0.0);
    textureStore(distance_m, pixel, vec4<f32>(along_m, 0.0, 0.0, 0.0));
    textureStore(normal, pixel, words_of_surface(vec4<f32>(n, triangle.lightness)));
#ifdef LOCAL_COLOR
    textureStore(local_color, pixel, vec4<u32>(mesh_colors[own], 0u, 0u, 0u));
#endif
}
