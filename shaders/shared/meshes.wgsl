// Triangle meshes on the land, and their positions for this eye.
#define_import_path hachure::meshes

// An instance in view. An instance without room has no vertices and no triangles.
struct MeshInstance {
    // Rows of the matrix from the mesh, centred on its middle, to the flat map around the rig.
    east: vec4<f32>,
    north: vec4<f32>,
    up: vec4<f32>,
    // First vertex among those of all levels of all meshes; number of vertices; first index in `mesh_places`.
    first_vertex: u32,
    vertices: u32,
    first_place: u32,
    // First triangle among those of all levels of all meshes, and number of triangles.
    first_triangle: u32,
    triangles: u32,
    // Number of triangles of earlier instances that are near enough for edges; the instance's own count only if
    // `is_near` is 1.
    near_before: u32,
    is_near: u32,
    // 1: the mesh is closed, and its front faces are outside.
    is_solid: u32,
    // Number of its first triangle among the triangles of all instances of the world, at all levels.
    first_number: u32,
    // Number of triangles in view of earlier instances.
    triangles_before: u32,
    // Index of the instance in the world.
    standing: u32,
    // Number of instances in the list.
    listed: u32,
}

struct MeshTriangle {
    corner_a: u32,
    corner_b: u32,
    corner_c: u32,
    // Neighbour across the edges ab, bc, ca: BORDER, AGAIN, or twice the neighbour's number, plus 1 if it has the
    // opposite orientation.
    across_ab: u32,
    across_bc: u32,
    across_ca: u32,
    // Normals at the corners, octahedral, 2 × 16 bits.
    normal_a: u32,
    normal_b: u32,
    normal_c: u32,
    // Lightness of the material, always less than 1, which is bare land.
    lightness: f32,
}

const BORDER: u32 = 0xffffffffu;
const AGAIN: u32 = 0xfffffffeu;

@group(0) @binding(20) var<storage, read> mesh_instances: array<MeshInstance>;
@group(0) @binding(21) var<storage, read> mesh_triangles: array<MeshTriangle>;
// Vertices of everything in view, as drawn: metres from the rig's origin.
@group(0) @binding(22) var<storage, read> mesh_places: array<vec4<f32>>;

// The quantity by which `instance_of` counts: vertices in view, triangles in view that are near enough for edges,
// triangles in view, or all triangles of the world at all levels.
const BY_VERTEX: u32 = 0u;
const BY_NEAR: u32 = 1u;
const BY_TRIANGLE: u32 = 2u;
const BY_NUMBER: u32 = 3u;

// Returns the instance that an item belongs to: the last one whose first item has this number or a lower one.
fn instance_of(number: u32, by: u32) -> u32 {
    var low = 0u;
    var high = mesh_instances[0].listed;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        let instance = mesh_instances[middle];
        let begins = select(
            select(instance.first_number, instance.triangles_before, by == BY_TRIANGLE),
            select(instance.near_before, instance.first_place, by == BY_VERTEX), by <= BY_NEAR);
        if begins <= number { low = middle; } else { high = middle; }
    }
    return low;
}

struct Corners {
    a_m: vec3<f32>,
    b_m: vec3<f32>,
    c_m: vec3<f32>,
}

// Returns the corners of a triangle of an instance, as drawn.
fn corners_of(first_place: u32, triangle: MeshTriangle) -> Corners {
    return Corners(
        mesh_places[first_place + triangle.corner_a].xyz,
        mesh_places[first_place + triangle.corner_b].xyz,
        mesh_places[first_place + triangle.corner_c].xyz,
    );
}

// Decodes a unit vector from its octahedral map (Cigolle and others 2014).
fn normal_from(packed: u32) -> vec3<f32> {
    let xy = unpack2x16snorm(packed);
    let z = 1.0 - abs(xy.x) - abs(xy.y);
    let folded = (1.0 - abs(xy.yx)) * select(vec2<f32>(-1.0), vec2<f32>(1.0), xy >= vec2<f32>(0.0));
    return normalize(vec3<f32>(select(folded, xy, z >= 0.0), z));
}
