//! What is seen at a pixel: a kind of surface in the highest bits of its id, a number of that kind in the others.
//!
//! The code of a kind is a prefix: the more of a kind there are, the shorter it is. `shaders/shared/surface_id.wgsl`
//! defines it.

/// A kind of surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Nothing: the whole id is 0.
    Sky,
    /// A patch of the terrain: the highest bit is 0.
    Land,
    /// A triangle of a mesh, by its number among those of all that stands in the world: 10.
    Mesh,
    /// 110.
    Tree,
    /// 111.
    Water,
}

/// The id of the first mesh triangle.
pub const FIRST_MESH: u32 = crate::gpu::wgsl::shared::surface_id::FIRST_MESH;
/// The id of the first tree.
pub const FIRST_TREE: u32 = crate::gpu::wgsl::shared::surface_id::FIRST_TREE;
/// The id of the first water.
pub const FIRST_WATER: u32 = crate::gpu::wgsl::shared::surface_id::FIRST_WATER;

impl Kind {
    /// Of a pixel of the surface id picture.
    pub fn of(id: u32) -> Self {
        match id {
            0 => Self::Sky,
            1..FIRST_MESH => Self::Land,
            FIRST_MESH..FIRST_TREE => Self::Mesh,
            FIRST_TREE..FIRST_WATER => Self::Tree,
            FIRST_WATER.. => Self::Water,
        }
    }
}
