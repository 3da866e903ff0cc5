// A patch of the terrain mesh: 16 x 16 quads. See src/tiles/selection.rs.
#define_import_path hachure::mesh

struct Patch {
    // Position of the first vertex, in grid units relative to the anchor.
    origin_units: vec2<i32>,
    // Log2 of the grid units between vertices.
    stride_exponent: u32,
    // Value for the surface id target.
    id: u32,
    // Continuous level, relative to the patch's own, at its first column, last column, first row and last row.
    edge_levels: vec4<f32>,
    // Continuous level, relative to the patch's own, inside the patch.
    inner_level: f32,
    // Sides whose edges belong to this patch: bit 0 for its first column, 1 last column, 2 first row, 3 last row.
    sides: u32,
    // 1: the patch has no-data samples.
    has_holes: u32,
    padding: f32,
}

const QUADS: i32 = 16;
const VERTICES: u32 = 289u;
