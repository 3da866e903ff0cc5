// Computes the sway of the visible trees in the wind; each thread takes every tree at a stride. All vertices of a tree,
// and all pixels of its impostor, sway by the position of its foot. Pieces of canopy do not move.
#import hachure::trees::{TreeInstance, CANOPY, TREE_LEVELS, NO_LIST}
#import hachure::wind::{Wind, Sway, sway_at}

@group(0) @binding(0) var<uniform> wind: Wind;
@group(0) @binding(1) var<storage, read> tree_instances: array<TreeInstance>;
// See place.wgsl.
@group(0) @binding(2) var<storage, read> tree_keys: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read_write> tree_sways: array<Sway>;

const SWAY_GROUPS: u32 = 256u;
const SWAY_THREADS: u32 = 64u;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    for (var i = id.x; i < wind.instances; i += SWAY_GROUPS * SWAY_THREADS) {
        if tree_keys[i].x == (NO_LIST | NO_LIST << 16u) {
            continue;
        }
        let tree = tree_instances[i];
        if (tree.bucket & 0xffffu) % TREE_LEVELS == CANOPY {
            tree_sways[i] = Sway(vec2<f32>(0.0), vec2<f32>(0.0));
        } else {
            tree_sways[i] = sway_at(wind, tree.flat_m.xy);
        }
    }
}
