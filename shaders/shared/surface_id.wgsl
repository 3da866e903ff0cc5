// The surface id of a pixel: the highest bits are a kind of surface, the others a number within that kind. See
// src/surface/id.rs.
#define_import_path hachure::surface_id

const SKY: u32 = 0u;
const LAND: u32 = 1u;
const MESH: u32 = 2u;
const TREE: u32 = 3u;

const FIRST_MESH: u32 = 0x80000000u;
const FIRST_TREE: u32 = 0xc0000000u;

fn kind_of(id: u32) -> u32 {
    if id < FIRST_MESH {
        return select(LAND, SKY, id == 0u);
    }
    return select(TREE, MESH, id < FIRST_TREE);
}
