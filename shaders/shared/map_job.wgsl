// Maps that are made of heights: a tile for each tile of heights.
#define_import_path hachure::map_job

// A tile whose map is made.
struct MapJob {
    slot: i32,
    level: i32,
    // The tile's place in its level.
    tile: vec2<i32>,
}
