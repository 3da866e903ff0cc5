// Contour edges: edges between a triangle that faces the eye and one that does not, on the triangles as drawn.
//
// There is one workgroup for each patch and one thread for each of its quads. A quad has three edges of its own: its
// first column's, its first row's, and its diagonal. Where patches meet, the edges between them belong to one of them
// (`Patch.sides`); the triangles beyond are those that this patch would have there (Pietrok 2021, section 4.2.1, uses a
// geometry shader and one mesh).
//
// A patch that is morphing to a coarser level has coincident vertices, so some triangles have no area. They have no
// side of their own: quads are examined on the patch's current level, and a triangle without area there follows the
// other triangle of its quad.
//
// Triangles in a hole are not drawn, and their heights are not measured: they have no edges.
//
// Edges are in the order of patches and quads (edge_list.wgsl): stage 0 examines the quads and stores the result, two bits
// for each of their edges, after the numbers of `order`; 1 writes the edges. Stage 0 is a
// variant of its own (FIND), and so is one for patches with holes (HOLES): a software driver executes both sides of
// every branch, and would examine all quads at each stage.
#import hachure::view::{View, from_eye}
#import hachure::mesh::{Patch, QUADS, VERTICES}
#import hachure::terrain::{terrain, grid_from_world, world_from_grid}
#import hachure::surface::{vertex_height_m, is_void}
#import hachure::earth::{bend, unbend}
#import hachure::edges::{Edge, EdgeRules, is_outside, KIND_CONTOUR, KIND_BORDER, KIND_CREASE}
#import hachure::edge_list::{has_counted, place_in_list, put_edge, order}
#import hachure::ordered::{clear_marks, mark}

@group(0) @binding(0) var<storage, read> patches: array<Patch>;
@group(0) @binding(1) var<storage, read> positions: array<vec4<f32>>;
@group(0) @binding(2) var<uniform> view: View;
@group(0) @binding(3) var<uniform> edge_rules: EdgeRules;

// Vertices along a side of the patch with a ring of vertices around it, the number of vertices in that ring, and quads
// along a side.
const RING: i32 = QUADS + 3;
const RING_VERTICES: u32 = 72u;
const RING_QUADS: i32 = QUADS + 2;
// Edges that a quad may add: its diagonal, its first column's, its first row's, and at the end of the patch its last
// column's and last row's. Their numbers are called slots.
const QUAD_EDGES: u32 = 5u;

// Positions of the patch's vertices and of the ring.
var<workgroup> at_m: array<vec3<f32>, 361>;
// For each quad of patch and ring, the unit normals of its two triangles; 0 for a triangle without area.
var<workgroup> upper: array<vec3<f32>, 324>;
var<workgroup> lower: array<vec3<f32>, 324>;

// Returns the position of the vertex in a column and row of the patch; those of the ring are -1 and QUADS + 1.
fn vertex_of(ij: vec2<i32>) -> vec3<f32> {
    let place = ij + 1;
    return at_m[place.y * RING + place.x];
}

// Returns the column and row of a vertex around the patch, by its number: the row above, the row below, and both
// columns.
fn ring_vertex(number: i32) -> vec2<i32> {
    if number < 2 * RING {
        return vec2<i32>(number % RING - 1, select(-1, QUADS + 1, number >= RING));
    }
    let place = number - 2 * RING;
    return vec2<i32>(select(-1, QUADS + 1, place > QUADS), place % (QUADS + 1));
}

// Computes the position of a vertex of the ring, as the neighbouring patch has it on its own level.
fn beyond(quads: Patch, ij: vec2<i32>) -> vec3<f32> {
    let units = clamp(quads.origin_units + (ij << vec2<u32>(quads.stride_exponent)),
        terrain.extent_units.xy, terrain.extent_units.zw);
    let xy_m = world_from_grid(vec2<f32>(units) / terrain.units_per_sample);
    let dz_m = max(max(terrain.min_z_m, -terrain.max_z_m), 0.0);
    let distance_m = sqrt(dot(xy_m, xy_m) + dz_m * dz_m);
    return bend(vec3<f32>(xy_m, vertex_height_m(vec2<f32>(units) / terrain.units_per_sample, distance_m)));
}

// Returns the unit normal of a triangle; 0 for a sliver.
fn normal_of(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> vec3<f32> {
    let u = b - a;
    let v = c - a;
    let n = cross(v, u);
    // A sliver has no side: its normal is rounding noise.
    let longest = max(max(dot(u, u), dot(v, v)), dot(v - u, v - u));
    let area = length(n);
    return select(vec3<f32>(0.0), n / area, area > 2e-3 * longest && area > 0.0);
}

// Returns whether a triangle with this normal, through this point, faces the eye.
fn faces(n: vec3<f32>, through_m: vec3<f32>) -> bool {
    return dot(n, from_eye(view, through_m)) < 0.0;
}

#ifdef HOLES
// Whether the patch has holes.
var<private> has_holes: bool;
#endif

// Returns whether the edge from a to b may be drawn: it is in view, has a length, and is not in a hole.
fn may_be_drawn(a: vec3<f32>, b: vec3<f32>) -> bool {
    var may = !is_outside(a, b, view.clip_from_camera, view.near_m) && any(a != b);
#ifdef HOLES
    if may && has_holes {
        let flat_m = unbend(0.5 * (a + b)).flat_m;
        may = !is_void(grid_from_world(flat_m.xy).g, length(flat_m));
    }
#endif
    return may;
}

// Returns two bits for an edge through a between triangles with normals m and n, shifted to its slot: 0 for none, or
// its kind plus 1.
fn consider(a: vec3<f32>, m: vec3<f32>, n: vec3<f32>, slot: u32) -> u32 {
    let have_sides = any(m != vec3<f32>(0.0)) && any(n != vec3<f32>(0.0));
    let is_contour = faces(m, a) != faces(n, a);
    let is_crease = dot(m, n) < edge_rules.crease_cosine && faces(m, a);
    let kind = select(select(0u, KIND_CREASE + 1u, is_crease), KIND_CONTOUR + 1u, is_contour);
    return select(0u, kind << (2u * slot), have_sides);
}

// Returns the bits of an edge at the border of the world, if the style draws borders.
fn border(slot: u32) -> u32 {
    return select(0u, (KIND_BORDER + 1u) << (2u * slot), edge_rules.borders == 1u);
}

// Computes the vertices and normals of a patch and its ring, for all threads. `step` is the distance of the vertices of
// the patch's current level.
fn compute_ring(quads: Patch, step: i32, group: u32, thread: u32) {
    for (var i = thread; i < VERTICES; i += 256u) {
        let ij = vec2<i32>(i32(i) % (QUADS + 1), i32(i) / (QUADS + 1)) + 1;
        at_m[ij.y * RING + ij.x] = positions[group * VERTICES + i].xyz;
    }
    for (var i = thread; i < RING_VERTICES; i += 256u) {
        let ij = ring_vertex(i32(i));
        // On the patch's current level.
        let out = select(vec2<i32>(0), vec2<i32>(1 - step), ij < vec2<i32>(0))
            + select(vec2<i32>(0), vec2<i32>(step - 1), ij > vec2<i32>(QUADS));
        at_m[(ij.y + 1) * RING + ij.x + 1] = beyond(quads, ij + out);
    }
    workgroupBarrier();

    // Quads of the patch's current level, and one more on each side, in columns and rows -1 and QUADS.
    for (var i = thread; i < 324u; i += 256u) {
        let ij = vec2<i32>(i32(i) % RING_QUADS, i32(i) / RING_QUADS) - 1;
        let size = select(vec2<i32>(step), vec2<i32>(1), (ij < vec2<i32>(0)) | (ij >= vec2<i32>(QUADS)));
        let end = min(ij + size, vec2<i32>(QUADS + 1));
        let nw = vertex_of(ij);
        let se = vertex_of(end);
        var above = normal_of(nw, vertex_of(vec2<i32>(end.x, ij.y)), se);
        var below = normal_of(nw, se, vertex_of(vec2<i32>(ij.x, end.y)));
        if all(above == vec3<f32>(0.0)) { above = below; }
        if all(below == vec3<f32>(0.0)) { below = above; }
        upper[i] = above;
        lower[i] = below;
    }
    workgroupBarrier();
}

// Returns the kinds of a quad's edges, two bits each, whether or not they may be drawn.
fn edges_of(quads: Patch, step: i32, ij: vec2<i32>) -> u32 {
    if any((ij & vec2<i32>(step - 1)) != vec2<i32>(0)) {
        return 0u;
    }
    let end = ij + step;
    let here = (ij.y + 1) * RING_QUADS + ij.x + 1;
    let nw = vertex_of(ij);
    let ne = vertex_of(vec2<i32>(end.x, ij.y));
    let sw = vertex_of(vec2<i32>(ij.x, end.y));
    var edges_found = consider(nw, upper[here], lower[here], 0u);
    // The previous quads: one index away outside of the patch, and a step away inside.
    let west = select(here - step, here - 1, ij.x == 0);
    let north = select(here - step * RING_QUADS, here - RING_QUADS, ij.y == 0);
    let origin = quads.origin_units;
    let side = i32(1u << quads.stride_exponent) * QUADS;
    if ij.x > 0 || (quads.sides & 1u) != 0u {
        if ij.x == 0 && origin.x <= terrain.extent_units.x {
            edges_found |= border(1u);
        } else {
            edges_found |= consider(nw, upper[west], lower[here], 1u);
        }
    }
    if ij.y > 0 || (quads.sides & 4u) != 0u {
        if ij.y == 0 && origin.y <= terrain.extent_units.y {
            edges_found |= border(2u);
        } else {
            edges_found |= consider(nw, lower[north], upper[here], 2u);
        }
    }
    if end.x == QUADS && (quads.sides & 2u) != 0u {
        if origin.x + side >= terrain.extent_units.z {
            edges_found |= border(3u);
        } else {
            edges_found |= consider(ne, upper[here], lower[(ij.y + 1) * RING_QUADS + QUADS + 1], 3u);
        }
    }
    if end.y == QUADS && (quads.sides & 8u) != 0u {
        if origin.y + side >= terrain.extent_units.w {
            edges_found |= border(4u);
        } else {
            edges_found |= consider(sw, lower[here], upper[(QUADS + 1) * RING_QUADS + ij.x + 1], 4u);
        }
    }
    return edges_found;
}

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    let quads = patches[group.x];
#ifdef HOLES
    has_holes = quads.has_holes == 1u;
#endif
    // Near the end of a morph quads are slivers, and count as gone.
    let step = 1 << u32(quads.inner_level + 0.01);
    let ij = vec2<i32>(i32(thread) % QUADS, i32(thread) / QUADS);
    let stored_at = groups.x + 1u + group.x * 256u + thread;
    clear_marks(thread);
#ifdef FIND
    compute_ring(quads, step, group.x, thread);
    var corners = array<vec2<i32>, 4>(ij, vec2<i32>(ij.x + step, ij.y), vec2<i32>(ij.x, ij.y + step), ij + step);
    var begins = array<u32, 5>(0u, 0u, 0u, 1u, 2u);
    var ends = array<u32, 5>(3u, 2u, 1u, 3u, 3u);
    // Few quads have an edge, so only those edges are looked at further.
    var edges_found = 0u;
    for (var rest = edges_of(quads, step, ij); rest != 0u;) {
        let slot = firstTrailingBit(rest) / 2u;
        let bits = 3u << (2u * slot);
        if may_be_drawn(vertex_of(corners[begins[slot]]), vertex_of(corners[ends[slot]])) {
            edges_found |= rest & bits;
        }
        rest &= ~bits;
    }
    order.starts[stored_at] = edges_found;
#else
    let edges_found = order.starts[stored_at];
#endif
    workgroupBarrier();
    for (var slot = 0u; slot < QUAD_EDGES; slot++) {
        if ((edges_found >> (2u * slot)) & 3u) != 0u {
            mark(thread * QUAD_EDGES + slot);
        }
    }
    workgroupBarrier();
    if has_counted(group.x, groups.x, thread) {
        return;
    }
#ifndef FIND
    if edges_found == 0u {
        return;
    }
    let end = ij + step;
    let first = group.x * VERTICES;
    let nw = positions[first + u32(ij.y * (QUADS + 1) + ij.x)].xyz;
    let ne = positions[first + u32(ij.y * (QUADS + 1) + end.x)].xyz;
    let sw = positions[first + u32(end.y * (QUADS + 1) + ij.x)].xyz;
    let se = positions[first + u32(end.y * (QUADS + 1) + end.x)].xyz;
    let begins = array<vec3<f32>, 5>(nw, nw, nw, ne, sw);
    let ends = array<vec3<f32>, 5>(se, sw, ne, se, se);
    let key = quads.id ^ (thread * 0x9e3779b1u);
    var index = place_in_list(group.x, thread * QUAD_EDGES);
    for (var slot = 0u; slot < QUAD_EDGES; slot++) {
        let kind = (edges_found >> (2u * slot)) & 3u;
        if kind != 0u {
            put_edge(index, Edge(begins[slot], key + slot, ends[slot], kind - 1u));
            index += 1u;
        }
    }
#endif
}
