// A patch of the mesh: 16 x 16 quads. See src/tiles/selection.rs.
#define_import_path hachure::mesh

struct Patch {
    // In grid units relative to the anchor.
    origin_units: vec2<i32>,
    // Log2 of the units between vertices.
    stride_exponent: u32,
    // What the surface id target gets.
    id: u32,
    // Levels above the patch's own, at its first column, last column, first row, last row.
    edge_levels: vec4<f32>,
    // Levels above the patch's own inside of it.
    inner_level: f32,
    // The sides whose edges are this patch's: bit 0 for its first column, 1 last column, 2 first row, 3 last row.
    sides: u32,
    // 1: it has void samples.
    has_holes: u32,
    padding: f32,
}

const QUADS: i32 = 16;
const VERTICES: u32 = 289u;
