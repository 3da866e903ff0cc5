// Clears the ink of all cells.
#import hachure::crowd::{Crowd, CELL_WORDS}

@group(0) @binding(0) var<uniform> crowd: Crowd;
@group(0) @binding(1) var<storage, read_write> counts: array<u32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if all(id.xy < crowd.cells) {
        for (var word = 0u; word < CELL_WORDS; word++) {
            counts[(id.y * crowd.cells.x + id.x) * CELL_WORDS + word] = 0u;
        }
    }
}
