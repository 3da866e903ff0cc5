//! Surface ids: the highest bits hold the kind of surface that is seen at a pixel, the others a number within that
//! kind.
//!
//! The codes of the kinds are a prefix code: the more surfaces a kind may have, the shorter its code. A kind is the
//! number of leading ones, so the code never runs out: the next kind is 1110, with 2^28 numbers, and the one after it
//! 11110.
//!
//! `shaders/shared/surface_id.wgsl` defines the kinds and what each of them has (its traits). Passes that draw more than
//! one kind test a trait, so a new kind is one line there, one here, and the passes that draw it.

use std::convert::Infallible;

use super::ID_FORMAT;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};

/// A picture of one texel that stands for [`SURFACE_ID`](super::SURFACE_ID) in a world that is only land.
const ONLY_LAND: TargetKind = TargetKind {
    name: "only land",
    content: Group::Surface.shows("One texel that stands for the surface ids of a world without models and trees"),
    format: ID_FORMAT,
    usage: wgpu::TextureUsages::COPY_DST,
};

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
#[cfg(test)]
pub(crate) const FIRST_MESH: u32 = crate::gpu::wgsl::shared::surface_id::FIRST_MESH;
/// The lowest id of a tree.
#[cfg(test)]
pub(crate) const FIRST_TREE: u32 = crate::gpu::wgsl::shared::surface_id::FIRST_TREE;

impl Kind {
    /// Returns the kind of surface of a pixel of the surface id picture.
    pub(crate) fn of(id: u32) -> Self {
        match id.leading_ones() {
            _ if id == 0 => Self::Sky,
            0 => Self::Land,
            1 => Self::Mesh,
            // No id has more leading ones today.
            _ => Self::Tree,
        }
    }
}

struct OnlyLand(Target);

/// Returns the picture that passes read in place of surface ids if every pixel shows land or sky, so that no ids are
/// drawn.
pub(crate) fn only_land(recorder: &mut Recorder<'_>) -> Target {
    let made = recorder.cached(
        |_: &OnlyLand| true,
        |gpu| {
            let target = Target::new(gpu, &ONLY_LAND, [1, 1]);
            let size = target.texture.size();
            // An id of land: the highest bit is 0.
            let texel = 1_u32.to_le_bytes();
            gpu.queue.write_texture(
                target.texture.as_image_copy(),
                &texel,
                wgpu::TexelCopyBufferLayout::default(),
                size,
            );
            Ok::<_, Infallible>(OnlyLand(target))
        },
    );
    let Ok(only_land) = made;
    only_land.0.clone()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::wgsl::shared::surface_id::{LAND, MESH, SKY, TREE};

    #[test]
    fn the_leading_ones_of_an_id_are_its_kind() {
        let kinds = [
            (Kind::Sky, SKY, [0, 0]),
            (Kind::Land, LAND, [1, FIRST_MESH - 1]),
            (Kind::Mesh, MESH, [FIRST_MESH, FIRST_TREE - 1]),
            (Kind::Tree, TREE, [FIRST_TREE, FIRST_TREE | 0x1fff_ffff]),
        ];
        for (kind, number, ids) in kinds {
            for id in ids {
                // `kind_of` of the shader counts in the same way.
                let in_shader = if id == 0 { SKY } else { id.leading_ones() + 1 };
                assert_eq!((Kind::of(id), in_shader), (kind, number), "{id:#x}");
            }
        }
    }
}
