// Culls meshes: it selects those whose sphere intersects the view, is not hidden by the earth, and is not smaller than
// a pixel. For each it selects the coarsest level whose error is small enough at the mesh's nearest distance to an eye
// of the rig. It also counts what is drawn, and the threads that compute vertices and find edges, for indirect
// dispatches; the CPU knows neither.
//
// The list holds the visible meshes in the order of the scene; a thread finds its mesh by its number. There are three
// stages: 0, each workgroup counts the items of its 256 meshes; 1, one workgroup turns counts into offsets (at most 256
// of them) and writes the indirect arguments; 2, each workgroup writes its part of the list.
//
// If a world has more vertices than the capacity, stage 3 comes first: it counts the vertices in view for the usual
// allowed error, three times that, nine times, and any error, and the first of these that fits is used. Meshes that do
// not fit even then are at the end of the list, without vertices and triangles: the first such mesh corrects the draw
// arguments.
//
// The position of a mesh in the world needs more digits than f32 has. It is given in units of 64 m and of 2^-24 m, so
// that the difference to the rig's origin is rounded only once.
#import hachure::dispatch::GROUPS_IN_ROW
#import hachure::view::{View, distance_from_eye, is_off_screen}
#import hachure::terrain::terrain
#import hachure::earth::{bend, camera_z_m}
#import hachure::meshes::MeshInstance

// A mesh placed in the world, in view or not.
struct Standing {
    // Rows of the matrix from the mesh, centred on its middle, to the world.
    east: vec3<f32>,
    // Its first level among those of all meshes, finest first, and the number of its levels.
    first_level: u32,
    north: vec3<f32>,
    levels: u32,
    up: vec3<f32>,
    // Number of its first triangle among those of all instances of the world, level by level.
    first_number: u32,
    // Position of its middle in the world: `coarse` in units of 64 m, and `fine` in units of 2^-24 m.
    coarse: vec3<i32>,
    // World metres per unit of the mesh.
    scale: f32,
    fine: vec3<i32>,
    // Largest distance of a vertex from the middle, in world metres.
    radius_m: f32,
}

// A mesh, or a coarser level of detail of it.
struct MeshLevel {
    // First index among those of all levels of all meshes.
    first_vertex: u32,
    vertices: u32,
    first_triangle: u32,
    triangles: u32,
    // Number of its first triangle among those of all levels of its mesh.
    first_number: u32,
    is_solid: u32,
    // Mean length of an edge, in the mesh's unit.
    mean_edge_m: f32,
    // Largest distance from the full mesh, in the mesh's unit.
    error_m: f32,
}

struct Cull {
    // Position of the rig's origin, in the same units as the positions of meshes.
    origin_coarse: vec3<i32>,
    stage: u32,
    origin_fine: vec3<i32>,
    // Largest distance of an eye of the rig from there, in metres.
    eyes_m: f32,
    // Size on the picture below which a mesh is not drawn; mean length of edges below which a mesh gets no edges.
    smallest_px: f32,
    shortest_edge_px: f32,
    // Allowed error of a level at a distance of 1 m, in metres.
    error_m: f32,
    // Capacity for vertices, and for triangles that are near enough for edges.
    room_vertices: u32,
    room_triangles: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

// Number of factors of the allowed error that are tried if the capacity is short.
const TRIES: u32 = 4u;

// Arguments of indirect draws and dispatches.
struct MeshDraws {
    // Vertices, instances, and the first of each.
    draw: vec4<u32>,
    // Workgroups for the vertices.
    vertex_groups: vec4<u32>,
    // Workgroups for the triangles that are near enough for edges; the last word is the number of these workgroups.
    near_groups: vec4<u32>,
    // Number of meshes in the list, and of those among them that did not fit.
    listed: u32,
    left_out: u32,
    padding_a: u32,
    padding_b: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> cull: Cull;
@group(0) @binding(2) var<storage, read> standings: array<Standing>;
@group(0) @binding(3) var<storage, read> mesh_levels: array<MeshLevel>;
@group(0) @binding(4) var<storage, read_write> mesh_instances: array<MeshInstance>;
// Counts of each workgroup.
@group(0) @binding(5) var<storage, read_write> mesh_counts: array<vec4<u32>>;
@group(0) @binding(6) var<storage, read_write> mesh_draws: MeshDraws;
// Vertices in view for each of the errors that are tried; all 0 if everything fits in any case.
@group(0) @binding(7) var<storage, read_write> mesh_demand: array<atomic<u32>, TRIES>;

// Threads of a workgroup in the dispatched passes.
const WORKGROUP: u32 = 64u;

var<workgroup> sums: array<vec4<u32>, 256>;

// Returns the inclusive prefix sum over the threads of the workgroup (Hillis, Steele 1986).
fn sum_of_threads(thread: u32, own: vec4<u32>) -> vec4<u32> {
    sums[thread] = own;
    workgroupBarrier();
    for (var reach = 1u; reach < 256u; reach *= 2u) {
        var before = vec4<u32>(0u);
        if thread >= reach {
            before = sums[thread - reach];
        }
        workgroupBarrier();
        sums[thread] += before;
        workgroupBarrier();
    }
    return sums[thread];
}

fn middle_m(standing: Standing) -> vec3<f32> {
    let coarse = standing.coarse - cull.origin_coarse;
    let fine = standing.fine - cull.origin_fine;
    // Both terms of the first sum are exact within 4 km.
    let most = vec3<f32>(coarse) * 64.0 + vec3<f32>(fine >> vec3<u32>(12u)) * 0x1p-12;
    return most + vec3<f32>(fine & vec3<i32>(4095)) * 0x1p-24;
}

// Returns whether the earth itself hides a point of the flat map: the point is beyond the horizon of a camera on the
// lowest land.
fn is_beyond_horizon(flat_m: vec3<f32>, radius_m: f32) -> bool {
    let k = terrain.inverse_radius;
    let away = max(length(flat_m.xy) - radius_m, 0.0) * k;
    // At least the angle whose cosine is r / (r + h).
    let dips = sqrt(2.0 * k * max(vec2<f32>(-terrain.min_z_m, flat_m.z + radius_m - terrain.min_z_m), vec2<f32>(0.0)));
    return k > 0.0 && away > dips.x + dips.y + 1e-5;
}

// An instance as it is seen.
struct Seen {
    // Vertices, triangles that are near enough for edges, all triangles, and 1; all are 0 if it is not visible.
    counts: vec4<u32>,
    // Index among all levels.
    level: u32,
    // Allowed error, in metres.
    allowed_m: f32,
}

fn times_of_try(number: u32) -> f32 {
    return select(select(select(1e30, 9.0, number == 2u), 3.0, number == 1u), 1.0, number == 0u);
}

// Returns the coarsest level with no larger error.
fn level_of(standing: Standing, allowed_m: f32) -> u32 {
    var level = standing.first_level;
    let end = standing.first_level + standing.levels;
    while level + 1u < end && mesh_levels[level + 1u].error_m * standing.scale <= allowed_m {
        level += 1u;
    }
    return level;
}

fn seen_of(number: u32) -> Seen {
    let nothing = Seen(vec4<u32>(0u), 0u, 0.0);
    if number >= arrayLength(&standings) {
        return nothing;
    }
    let standing = standings[number];
    let flat_m = middle_m(standing);
    let at_m = bend(flat_m);
    // Heights above the sea are stretched on the bent earth.
    let radius_m = standing.radius_m
        * max(1.0 + (flat_m.z + camera_z_m() + standing.radius_m) * terrain.inverse_radius, 1.0);
    let away_m = distance_from_eye(view, at_m);
    let is_small = 2.0 * radius_m * view.focal_px < cull.smallest_px * away_m;
    if is_small || is_off_screen(view, at_m, radius_m) || is_beyond_horizon(flat_m, radius_m) {
        return nothing;
    }
    // The nearest distance to any eye of the rig, because all eyes draw the same.
    let allowed_m = cull.error_m * max(length(at_m) - cull.eyes_m - radius_m, 0.0);
    var times = 1.0;
    if cull.stage < 3u {
        var number = 0u;
        while number + 1u < TRIES && atomicLoad(&mesh_demand[number]) > cull.room_vertices {
            number += 1u;
        }
        times = times_of_try(number);
    }
    let level = level_of(standing, allowed_m * times);
    let drawn = mesh_levels[level];
    let edge_px_m = drawn.mean_edge_m * standing.scale * view.focal_px;
    let is_near = edge_px_m >= cull.shortest_edge_px * (away_m - radius_m);
    return Seen(vec4<u32>(drawn.vertices, select(0u, drawn.triangles, is_near), drawn.triangles, 1u), level, allowed_m);
}

fn groups_of(threads: u32) -> vec4<u32> {
    let groups = (threads + WORKGROUP - 1u) / WORKGROUP;
    let row = min(groups, GROUPS_IN_ROW);
    let rows = (groups + GROUPS_IN_ROW - 1u) / GROUPS_IN_ROW;
    return vec4<u32>(row, rows, 1u, row * rows);
}

@compute @workgroup_size(256)
fn main(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    var seen = Seen(vec4<u32>(0u), 0u, 0.0);
    if cull.stage != 1u {
        seen = seen_of(id.x);
    } else if thread < arrayLength(&mesh_counts) {
        seen.counts = mesh_counts[thread];
    }
    let own = seen.counts;
    if cull.stage == 3u {
        for (var number = 0u; number < TRIES && own.w > 0u; number++) {
            let level = level_of(standings[id.x], seen.allowed_m * times_of_try(number));
            atomicAdd(&mesh_demand[number], mesh_levels[level].vertices);
        }
        return;
    }
    let through = sum_of_threads(thread, own);
    if cull.stage == 0u {
        if thread == 255u {
            mesh_counts[group.x] = through;
        }
        return;
    }
    if cull.stage == 1u {
        if thread < arrayLength(&mesh_counts) {
            mesh_counts[thread] = through - own;
        }
        if thread == 255u {
            mesh_draws = MeshDraws(
                vec4<u32>(3u * through.z, 1u, 0u, 0u), groups_of(through.x),
                groups_of(min(through.y, cull.room_triangles)), through.w, 0u, 0u, 0u);
        }
        return;
    }
    if own.w == 0u {
        return;
    }
    let before = mesh_counts[group.x] + through - own;
    let has_room = before.x + own.x <= cull.room_vertices;
    if !has_room && before.x <= cull.room_vertices {
        mesh_draws.draw.x = 3u * before.z;
        mesh_draws.vertex_groups = groups_of(before.x);
        mesh_draws.left_out = mesh_draws.listed - before.w;
    }
    let is_near = own.y > 0u && has_room && before.y + own.y <= cull.room_triangles;
    let standing = standings[id.x];
    let drawn = mesh_levels[seen.level];
    let at_m = middle_m(standing);
    mesh_instances[before.w] = MeshInstance(
        vec4<f32>(standing.east, at_m.x), vec4<f32>(standing.north, at_m.y), vec4<f32>(standing.up, at_m.z),
        drawn.first_vertex, select(0u, own.x, has_room), before.x,
        drawn.first_triangle, select(0u, own.z, has_room), before.y, u32(is_near),
        drawn.is_solid, standing.first_number + drawn.first_number, before.z, id.x, mesh_draws.listed);
}
