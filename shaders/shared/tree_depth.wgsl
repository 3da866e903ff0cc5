// How much nearer to the eye pieces of canopy are drawn, and the tiles in which the depth of the land is known.
#define_import_path hachure::tree_depth

// Distance by which a piece of canopy is drawn nearer: relative to its width beyond its height, and limited relative to
// its distance.
const NEARER: f32 = 0.5;
const MAX_NEARER: f32 = 0.05;
// Side of a tile of the picture.
const TILE_PX: u32 = 8u;
