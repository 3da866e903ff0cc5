// The surface id of a pixel: the highest bits are a kind of surface, the others a number within that kind. See
// src/surface/id.rs.
//
// A pass that draws surfaces of one kind compares the kind. All other passes test a trait, so that they need no list of
// kinds.
#define_import_path hachure::surface_id

// A kind is 1 plus the number of leading ones of its ids, except the sky, whose whole id is 0.
const SKY: u32 = 0u;
const LAND: u32 = 1u;
const MESH: u32 = 2u;
const TREE: u32 = 3u;

const FIRST_MESH: u32 = 0x80000000u;
const FIRST_TREE: u32 = 0xc0000000u;

// Traits. ON_GRID: each place has a place on the grid of heights, and with it levels, smoothed forms, water and rims.
const ON_GRID: u32 = 1u;
// Neighbouring pixels show one surface whose normals change gradually; each leaf of a tree has its own.
const SMOOTH: u32 = 2u;
// The pixel may have a local colour of its own (see shared/local_color.wgsl).
const LOCALLY_COLORED: u32 = 4u;
// The surface moves: its step since the last frame is in `tree_step`.
const MOVING: u32 = 8u;

const TRAIT_BITS: u32 = 4u;
const TRAITS: u32 = ((ON_GRID | SMOOTH) << (TRAIT_BITS * LAND))
    | ((SMOOTH | LOCALLY_COLORED) << (TRAIT_BITS * MESH))
    | ((LOCALLY_COLORED | MOVING) << (TRAIT_BITS * TREE));

fn kind_of(id: u32) -> u32 {
    return select(countLeadingZeros(~id) + 1u, SKY, id == 0u);
}

// Returns the id of the surface that a pixel sees. In a world that is only land the picture has one texel, an id of land,
// so a pass tests first whether a pixel sees the sky.
fn id_seen(surface_id: texture_2d<u32>, pixel: vec2<i32>) -> u32 {
    return textureLoad(surface_id, min(pixel, vec2<i32>(textureDimensions(surface_id)) - 1), 0).r;
}

// Returns whether the surface of an id has a trait. The sky has none.
fn has_trait(id: u32, asked: u32) -> bool {
    return ((TRAITS >> (TRAIT_BITS * kind_of(id))) & asked) != 0u;
}
