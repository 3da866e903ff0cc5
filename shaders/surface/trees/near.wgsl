// Lists the trees that have strokes: those whose near meshes are drawn, from near to far.
//
// Near trees are a few hundred, so each counts the trees before it: those nearer to the eye or, at the same distance, with
// a lesser id. The count is its place.
#import hachure::view::View
#import hachure::trees::{TreeInstance, NEAR, DRAW_WORDS, has_strokes, list_of}
#import hachure::dispatch::GROUPS_IN_ROW

struct NearTrees {
    species: u32,
    // Capacity of each list of trees.
    capacity: u32,
    // Capacity for near trees.
    room: u32,
    // Workgroups for the edges of a tree.
    groups_of_tree: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> near_trees: NearTrees;
@group(0) @binding(2) var<storage, read> tree_instances: array<TreeInstance>;
@group(0) @binding(3) var<storage, read> tree_order: array<u32>;
@group(0) @binding(4) var<storage, read> tree_draws: array<u32>;
// Number of near trees, then the indices of their instances.
@group(0) @binding(5) var<storage, read_write> near_order: array<u32>;
// An indirect dispatch, and its number of workgroups.
@group(0) @binding(6) var<storage, read_write> near_dispatch: vec4<u32>;

const NEAR_GROUPS: u32 = 16u;
const NEAR_THREADS: u32 = 64u;

// Whether a tree has strokes, and the values by which trees are sorted.
struct Key {
    is_there: bool,
    // Bits of the squared distance: positive floats are in the order of their bits.
    away: u32,
    id: u32,
}

fn key_of(number: u32) -> Key {
    let tree = tree_instances[number];
    let toward_eye = view.eye_m - tree.flat_m;
    return Key(has_strokes(tree), bitcast<u32>(dot(toward_eye, toward_eye)), tree.id);
}

fn is_before(a: Key, b: Key) -> bool {
    return a.away < b.away || (a.away == b.away && a.id < b.id);
}

fn trees_of(species: u32) -> u32 {
    return min(tree_draws[list_of(near_trees.species, species, NEAR) * DRAW_WORDS + 1u], near_trees.capacity);
}

fn listed(species: u32, i: u32) -> u32 {
    return tree_order[list_of(near_trees.species, species, NEAR) * near_trees.capacity + i];
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    // The first thread counts all near trees, and computes the dispatch.
    if id.x == 0u {
        var count = 0u;
        for (var species = 0u; species < near_trees.species; species++) {
            for (var i = 0u; i < trees_of(species); i++) {
                count += u32(has_strokes(tree_instances[listed(species, i)]));
            }
        }
        let trees = min(count, near_trees.room);
        let groups = trees * near_trees.groups_of_tree;
        let rows = vec2<u32>(min(groups, GROUPS_IN_ROW), (groups + GROUPS_IN_ROW - 1u) / GROUPS_IN_ROW);
        near_dispatch = vec4<u32>(rows, 1u, rows.x * rows.y);
        near_order[0] = trees;
    }
    for (var species = 0u; species < near_trees.species; species++) {
        for (var i = id.x; i < trees_of(species); i += NEAR_GROUPS * NEAR_THREADS) {
            let number = listed(species, i);
            let own = key_of(number);
            if !own.is_there {
                continue;
            }
            var place = 0u;
            for (var other = 0u; other < near_trees.species; other++) {
                for (var j = 0u; j < trees_of(other); j++) {
                    let key = key_of(listed(other, j));
                    place += u32(key.is_there && is_before(key, own));
                }
            }
            if place < near_trees.room {
                near_order[1u + place] = number;
            }
        }
    }
}
