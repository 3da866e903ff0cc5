//! Surface ids: the highest bits hold the kind of surface that is seen at a pixel, the others a number within that
//! kind.
//!
//! The codes of the kinds are a prefix code: the more surfaces a kind may have, the shorter its code. No code begins
//! with 111, so the code never runs out: the next kind is 1110, with 2^28 numbers, and the one after it 11110. The ids
//! are defined in `shaders/shared/surface_id.wgsl`.

/// A kind of surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// No surface: the whole id is 0.
    Sky,
    /// A patch of the terrain; the code is 0.
    Land,
    /// A triangle of a mesh, numbered among those of all mesh instances of the world; the code is 10.
    Mesh,
    /// A tree; the code is 110.
    Tree,
}

/// The lowest id of a mesh triangle.
pub(crate) const FIRST_MESH: u32 = crate::gpu::wgsl::shared::surface_id::FIRST_MESH;
/// The lowest id of a tree.
pub(crate) const FIRST_TREE: u32 = crate::gpu::wgsl::shared::surface_id::FIRST_TREE;

impl Kind {
    /// Returns the kind of surface of a pixel of the surface id picture.
    pub(crate) fn of(id: u32) -> Self {
        match id {
            0 => Self::Sky,
            1..FIRST_MESH => Self::Land,
            FIRST_MESH..FIRST_TREE => Self::Mesh,
            FIRST_TREE.. => Self::Tree,
        }
    }
}
