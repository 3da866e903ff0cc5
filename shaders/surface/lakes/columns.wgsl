// For each sample, finds the nearest shore in its column: the first half of a distance transform that processes one
// axis after the other (Felzenszwalb and Huttenlocher 2012, "Distance Transforms of Sampled Functions").
#import hachure::water_maps::{SIDE, SHORE_REACH}
#import hachure::shores::{IS_SHORE, ROW_SHIFT, ROW_ZERO, FIRST_WET}

@group(0) @binding(0) var<storage, read> found: array<u32>;
@group(0) @binding(1) var<storage, read_write> shores: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(workgroup_id) group: vec3<u32>) {
    let column = i32(id.x);
    if column >= SIDE {
        return;
    }
    let first = i32(found[FIRST_WET + group.y]) * SIDE * SIDE + column;
    var above = -SIDE;
    for (var row = 0; row < SIDE; row++) {
        let at = first + row * SIDE;
        let word = shores[at];
        above = select(above, row, (word & IS_SHORE) != 0u);
        if row - above <= SHORE_REACH {
            shores[at] = word | (u32(above - row + ROW_ZERO) << ROW_SHIFT);
        }
    }
    var below = 2 * SIDE;
    for (var row = SIDE - 1; row >= 0; row--) {
        let at = first + row * SIDE;
        let word = shores[at];
        below = select(below, row, (word & IS_SHORE) != 0u);
        let known = i32(word >> ROW_SHIFT);
        let is_nearer = below - row < select(ROW_ZERO - known, SHORE_REACH + 1, known == 0);
        if is_nearer {
            shores[at] = (word & ((1u << ROW_SHIFT) - 1u)) | (u32(below - row + ROW_ZERO) << ROW_SHIFT);
        }
    }
}
