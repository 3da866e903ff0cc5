// Jobs of maps that are derived from heights, one for each tile of heights.
#define_import_path hachure::map_job

// A tile whose map is made.
struct MapJob {
    slot: i32,
    level: i32,
    // Position of the tile in its level, in tiles.
    tile: vec2<i32>,
}
