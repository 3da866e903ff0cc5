// Meshes that stand on the land: their triangles, and where they stand for this eye.
#define_import_path hachure::meshes

// One that is in view. What has no room has no vertices and no triangles.
struct MeshInstance {
    // Rows of the matrix from the mesh to the flat map around the rig; the mesh counts from its middle.
    east: vec4<f32>,
    north: vec4<f32>,
    up: vec4<f32>,
    // Its vertices among those of all levels of all meshes; and where they are, in the order of the list.
    first_vertex: u32,
    vertices: u32,
    first_place: u32,
    // Its triangles among those of all levels of all meshes.
    first_triangle: u32,
    triangles: u32,
    // How many triangles come before that are near enough for edges; its own are not unless is_near is 1.
    near_before: u32,
    is_near: u32,
    // Its fronts are outside.
    is_solid: u32,
    // Its first triangle among those of all that stands in the world, level by level.
    first_number: u32,
    // How many triangles in view come before.
    triangles_before: u32,
    // Its number in the world.
    standing: u32,
    // How many there are in the list.
    listed: u32,
}

struct MeshTriangle {
    corner_a: u32,
    corner_b: u32,
    corner_c: u32,
    // Across the edges ab, bc, ca: BORDER, AGAIN, or twice the number of the triangle there, plus 1 if it is turned.
    across_ab: u32,
    across_bc: u32,
    across_ca: u32,
    // Octahedral, 2 × 16 bits.
    normal_a: u32,
    normal_b: u32,
    normal_c: u32,
    // Of its material: 1 is bare land, and it is always less.
    lightness: f32,
}

const BORDER: u32 = 0xffffffffu;
const AGAIN: u32 = 0xfffffffeu;

@group(0) @binding(20) var<storage, read> mesh_instances: array<MeshInstance>;
@group(0) @binding(21) var<storage, read> mesh_triangles: array<MeshTriangle>;
// Of all that is in view, as drawn: metres from the origin of the rig.
@group(0) @binding(22) var<storage, read> mesh_places: array<vec4<f32>>;

// What instances are counted by: vertices in view, triangles in view that are near enough for edges, triangles in view,
// all triangles of the world at all levels.
const BY_VERTEX: u32 = 0u;
const BY_NEAR: u32 = 1u;
const BY_TRIANGLE: u32 = 2u;
const BY_NUMBER: u32 = 3u;

// The instance that something belongs to: the last one that begins at its number or before.
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

// The corners of a triangle of an instance, as drawn.
fn corners_of(first_place: u32, triangle: MeshTriangle) -> Corners {
    return Corners(
        mesh_places[first_place + triangle.corner_a].xyz,
        mesh_places[first_place + triangle.corner_b].xyz,
        mesh_places[first_place + triangle.corner_c].xyz,
    );
}

// A unit vector from its octahedral map (Cigolle and others 2014).
fn normal_from(packed: u32) -> vec3<f32> {
    let xy = unpack2x16snorm(packed);
    let z = 1.0 - abs(xy.x) - abs(xy.y);
    let folded = (1.0 - abs(xy.yx)) * select(vec2<f32>(-1.0), vec2<f32>(1.0), xy >= vec2<f32>(0.0));
    return normalize(vec3<f32>(select(folded, xy, z >= 0.0), z));
}
