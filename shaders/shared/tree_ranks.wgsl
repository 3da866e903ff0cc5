// The order in which points get trees: the points below any rank are evenly distributed. See src/forest/points.rs and
// src/forest/blocks.rs.
#define_import_path hachure::tree_ranks
#import hachure::pcg::pcg

// How often four groups of tiles merge into one: WIDEST − SPARSE of src/forest/blocks.rs.
const MAX_SPARSE: u32 = 5u;
// Seed of the choice among four tiles, or groups of them: the chosen one has a point in the next level.
const CHOOSES: u32 = 2654435769u;

// Returns the tile of a group that has a point. See src/forest/blocks.rs.
fn chosen_tile(group: vec2<i32>, sparseness: u32) -> vec2<i32> {
    var at = group;
    for (var level = i32(sparseness) - 1; level >= 0; level--) {
        let mixed = pcg(bitcast<vec2<u32>>(at) ^ vec2<u32>(CHOOSES, u32(level))).x >> 16u;
        at = at * 2 + vec2<i32>(i32(mixed & 1u), i32((mixed >> 1u) & 1u));
    }
    return at;
}

// Returns the rank of a tile's point. The first point of a tile has a lower rank where its tile is chosen.
fn rank_of(tile: vec2<i32>, number: u32, points: f32) -> f32 {
    if number > 0u {
        return (f32(number) + 0.5) / points;
    }
    var level = 0u;
    while level < MAX_SPARSE && all(chosen_tile(tile >> vec2<u32>(level + 1u), level + 1u) == tile) {
        level += 1u;
    }
    let own = f32(pcg(bitcast<vec2<u32>>(tile)).y >> 8u) / 16777216.0;
    return (0.25 + 0.75 * own) / points * exp2(-2.0 * f32(level));
}
