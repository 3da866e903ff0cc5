// Lists the trees that are drawn: in each list the trees of near blocks come before those of far ones, and those of a
// block from near to far. The order depends on the trees alone, and not on timing. One workgroup takes a block.
//
// From front to back, most fragments of impostors are behind those that have been drawn, and end before their shader
// begins (impostor.wgsl).
#import hachure::dispatch::GROUPS_IN_ROW
#import hachure::trees::{DRAW_WORDS, INSTANCES_OF_TREE, NO_LIST}

struct TreeLists {
    // Number of blocks.
    blocks: u32,
    // Number of lists.
    lists: u32,
    // Capacity of each list.
    capacity: u32,
    padding: u32,
}

// The places of the trees of a block in the list of instances.
struct BlockPlaces {
    first_instance: u32,
    count: u32,
}

@group(0) @binding(0) var<uniform> tree_lists: TreeLists;
// See place.wgsl.
@group(0) @binding(1) var<storage, read> tree_keys: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> block_places: array<BlockPlaces>;
// The prefix sums of `tree_counts`, and after them the total.
@group(0) @binding(3) var<storage, read> tree_counts: array<u32>;
@group(0) @binding(4) var<storage, read_write> tree_order: array<u32>;
@group(0) @binding(5) var<storage, read_write> tree_draws: array<u32>;

// Three for each tree of a block.
var<workgroup> keys: array<vec2<u32>, 192>;

// Writes an instance into a list, behind those of the block that come before it. `shift` selects the half of the keys.
fn put(number: u32, list: u32, shift: u32, thread: u32, block: u32, count: u32) {
    if list == NO_LIST {
        return;
    }
    let own = keys[thread];
    var before = 0u;
    for (var i = 0u; i < count; i++) {
        let other = keys[i];
        let is_before = other.y < own.y || (other.y == own.y && i < thread);
        before += u32(is_before && ((other.x >> shift) & 0xffffu) == list);
    }
    let first = list * tree_lists.blocks;
    let slot = tree_counts[first + block] - tree_counts[first] + before;
    tree_order[list * tree_lists.capacity + slot] = number;
}

@compute @workgroup_size(192)
fn main(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let number = group.x + group.y * GROUPS_IN_ROW;
    if number >= tree_lists.blocks {
        return;
    }
    let places = block_places[number];
    let count = places.count * INSTANCES_OF_TREE;
    keys[thread] = vec2<u32>(NO_LIST | NO_LIST << 16u, 0u);
    if thread < count {
        keys[thread] = tree_keys[places.first_instance + thread];
    }
    workgroupBarrier();
    if number == 0u && thread < tree_lists.lists {
        let first = thread * tree_lists.blocks;
        tree_draws[thread * DRAW_WORDS + 1u] = tree_counts[first + tree_lists.blocks] - tree_counts[first];
    }
    let instance = places.first_instance + thread;
    put(instance, keys[thread].x & 0xffffu, 0u, thread, number, count);
    put(instance, keys[thread].x >> 16u, 16u, thread, number, count);
}
