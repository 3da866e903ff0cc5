// Which meshes an eye sees: those whose sphere touches the view, is not hidden by the earth, and is not smaller than a
// pixel. Of each, the coarsest level whose error is small enough where the mesh is nearest to an eye of the rig. What is
// drawn of them, and how many threads place their vertices and look for their edges, is counted here and dispatched
// indirectly; the CPU knows neither.
//
// The list holds what is seen, in the order of the scene: a thread looks up its mesh among those that begin before it.
// Three stages: 0, each workgroup counts what its 256 meshes have; 1, one workgroup turns counts into beginnings (at most
// 256 of them) and writes the indirect arguments; 2, each workgroup writes its part of the list.
//
// Where a world has more vertices than there is room for, stage 3 comes first: it finds how many are in view if errors may
// be as large as usual, three times, nine times, or of any size, and the first of these that has room is taken. What has no
// room even then is at the end of the list, without vertices and triangles: the first such mesh corrects what is drawn.
//
// A mesh's place in the world has more digits than f32. It comes in units of 64 m and of 2^-24 m, so that the
// difference to the rig's origin is rounded once.
#import hachure::dispatch::GROUPS_IN_ROW
#import hachure::view::{View, distance_from_eye, is_beside}
#import hachure::terrain::terrain
#import hachure::earth::{bend, camera_z_m}
#import hachure::meshes::MeshInstance

// A mesh that stands somewhere, in view or not.
struct Standing {
    // Rows of the matrix from the mesh, which counts from its middle, to the world.
    east: vec3<f32>,
    // Its levels among those of all meshes, finest first, and how many it has.
    first_level: u32,
    north: vec3<f32>,
    levels: u32,
    up: vec3<f32>,
    // Its first triangle among those of all that stands in the world, level by level.
    first_number: u32,
    // Where its middle is in the world.
    coarse: vec3<i32>,
    // World metres for each of the mesh's.
    scale: f32,
    fine: vec3<i32>,
    // No vertex is farther from the middle; in world metres.
    radius_m: f32,
}

// A mesh, or a coarser one that stands for it.
struct MeshLevel {
    // Among those of all levels of all meshes.
    first_vertex: u32,
    vertices: u32,
    first_triangle: u32,
    triangles: u32,
    // Its first triangle among those of all levels of its mesh.
    first_number: u32,
    is_solid: u32,
    // In the mesh's unit.
    mean_edge_m: f32,
    // How far it lies from the whole mesh, in the mesh's unit.
    error_m: f32,
}

struct Cull {
    // Of the rig, as the places of meshes.
    origin_coarse: vec3<i32>,
    stage: u32,
    origin_fine: vec3<i32>,
    // How far the eyes of the rig are from there.
    eyes_m: f32,
    // What is smaller is not drawn, and meshes with shorter edges have none.
    smallest_px: f32,
    shortest_edge_px: f32,
    // The error that a level may have at a distance of 1 m.
    error_m: f32,
    // Vertices, and triangles that are near enough for edges, that there is room for.
    room_vertices: u32,
    room_triangles: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

// Times the usual error that is tried, where room is short.
const TRIES: u32 = 4u;

// Arguments of indirect draws and dispatches.
struct MeshDraws {
    // Vertices, instances, and the first of each.
    draw: vec4<u32>,
    // Workgroups for the vertices.
    vertex_groups: vec4<u32>,
    // Workgroups for the triangles that are near enough for edges; the last is their number.
    near_groups: vec4<u32>,
    // Meshes in the list, and those of them that have no room.
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
// Of each workgroup.
@group(0) @binding(5) var<storage, read_write> mesh_counts: array<vec4<u32>>;
@group(0) @binding(6) var<storage, read_write> mesh_draws: MeshDraws;
// Vertices in view, for each of the errors that are tried; all 0 where there is room in any case.
@group(0) @binding(7) var<storage, read_write> mesh_demand: array<atomic<u32>, TRIES>;

// Threads of a workgroup, in the passes that are dispatched.
const WORKGROUP: u32 = 64u;

var<workgroup> sums: array<vec4<u32>, 256>;

// The sum of what the threads up to this one have (Hillis, Steele 1986).
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
    // Both parts of the sum before the last are exact within 4 km.
    let most = vec3<f32>(coarse) * 64.0 + vec3<f32>(fine >> vec3<u32>(12u)) * 0x1p-12;
    return most + vec3<f32>(fine & vec3<i32>(4095)) * 0x1p-24;
}

// Whether the earth itself hides what lies at a place of the flat map: it rises to a place beyond the horizon of a
// camera that stands on the lowest land.
fn is_beyond_horizon(flat_m: vec3<f32>, radius_m: f32) -> bool {
    let k = terrain.inverse_radius;
    let away = max(length(flat_m.xy) - radius_m, 0.0) * k;
    // At least the angle whose cosine is r / (r + h).
    let dips = sqrt(2.0 * k * max(vec2<f32>(-terrain.min_z_m, flat_m.z + radius_m - terrain.min_z_m), vec2<f32>(0.0)));
    return k > 0.0 && away > dips.x + dips.y + 1e-5;
}

// What stands at a number, as it is seen.
struct Seen {
    // Vertices, triangles that are near enough for edges, all triangles, 1; all are 0 if it is not seen.
    counts: vec4<u32>,
    // Which of all levels.
    level: u32,
    // The error that it may have.
    allowed_m: f32,
}

fn times_of_try(number: u32) -> f32 {
    return select(select(select(1e30, 9.0, number == 2u), 3.0, number == 1u), 1.0, number == 0u);
}

// The coarsest level with no larger error.
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
    // Heights above the sea are stretched.
    let radius_m = standing.radius_m
        * max(1.0 + (flat_m.z + camera_z_m() + standing.radius_m) * terrain.inverse_radius, 1.0);
    let away_m = distance_from_eye(view, at_m);
    let is_small = 2.0 * radius_m * view.focal_px < cull.smallest_px * away_m;
    if is_small || is_beside(view, at_m, radius_m) || is_beyond_horizon(flat_m, radius_m) {
        return nothing;
    }
    // The nearest that any eye of the rig may be to it: they draw the same.
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
