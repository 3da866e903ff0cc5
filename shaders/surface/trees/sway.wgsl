// How the trees that an eye sees sway in the wind: a thread for each, and then for the one so many farther on. All corners
// of a tree, and all pixels of its impostor, sway as its foot's place says. Pieces of canopy stand still.
#import hachure::trees::{TreeInstance, CANOPY, TREE_LEVELS}
#import hachure::wind::{Wind, Sway, sway_at}

@group(0) @binding(0) var<uniform> wind: Wind;
@group(0) @binding(1) var<storage, read> tree_instances: array<TreeInstance>;
@group(0) @binding(2) var<storage, read> tree_draws: array<u32>;
@group(0) @binding(3) var<storage, read_write> tree_sways: array<Sway>;

const SWAY_GROUPS: u32 = 256u;
const SWAY_THREADS: u32 = 64u;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    // What found no room is counted all the same.
    let count = min(tree_draws[wind.counter], arrayLength(&tree_instances));
    for (var i = id.x; i < count; i += SWAY_GROUPS * SWAY_THREADS) {
        let tree = tree_instances[i];
        if (tree.bucket & 0xffffu) % TREE_LEVELS == CANOPY {
            tree_sways[i] = Sway(vec2<f32>(0.0), vec2<f32>(0.0));
        } else {
            tree_sways[i] = sway_at(wind, tree.flat_m.xy);
        }
    }
}
