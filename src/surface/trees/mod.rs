//! Trees of a forest: those that an eye may see are found on the GPU in each frame, and drawn as instances.
//!
//! The CPU lists the blocks of points that the eye's frustum may see ([`crate::forest::blocks`]); each of their points is
//! asked on the GPU whether a tree stands there and how it is drawn ([`place`]): as a mesh, as one of fewer triangles
//! ([`raster`]), from pictures ([`impostor`]), or as a part of the canopy. Nothing is read back: draws are indirect.

pub mod impostor;
pub mod place;
pub mod raster;
pub mod resolve;
mod shared;

use std::sync::Arc;

use self::place::MOST_TREES;
pub use self::place::TreeInstance;
use self::shared::Shared;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Cx;
pub use crate::gpu::wgsl::shared::trees::{CANOPY, IMPOSTOR, MIDDLE, NEAR, TREE_LEVELS};
use crate::scene::Forest;

/// [`TreeInstance`]s of an eye.
pub const INSTANCES: BufferKind = BufferKind::storage("tree instances");
/// For each species and level the numbers of its instances.
pub const ORDER: BufferKind = BufferKind::storage("tree order");
/// For each species and level the arguments of its draw ([`DRAW_WORDS`]), then the number of instances.
pub const DRAWS: BufferKind = BufferKind::indirect("tree draws");
/// Vertices of a tree, trees, and the first of each.
pub const DRAW_WORDS: u32 = 4;

/// The trees of a frame.
pub struct DrawnTrees {
    shared: Arc<Shared>,
    instances: Buffer,
    order: Buffer,
    draws: Buffer,
}

impl DrawnTrees {
    /// None are found yet. Nothing while its species are grown beside the frame.
    pub fn of(cx: &mut Cx<'_>, forest: &Forest) -> Option<Self> {
        let forms: Vec<_> = forest.species.iter().map(|species| species.form).collect();
        let asked = forms.clone();
        let shared =
            cx.kept_beside(move |shared: &Shared| shared.forms == asked, move |gpu| Shared::new(gpu, forms))?;
        let buckets = u64::from(TREE_LEVELS) * forest.species.len() as u64;
        Some(Self {
            shared,
            instances: cx.buffer(&INSTANCES, u64::from(MOST_TREES) * size_of::<TreeInstance>() as u64),
            order: cx.buffer(&ORDER, buckets * u64::from(MOST_TREES) * 4),
            draws: cx.buffer(&DRAWS, (buckets + 1) * u64::from(DRAW_WORDS) * 4),
        })
    }

    /// The numbers of the instances of a species at a level.
    fn order_of(&self, bucket: u32) -> Buffer {
        let bytes = u64::from(MOST_TREES) * 4;
        self.order.slice(u64::from(bucket) * bytes, bytes)
    }

    /// Draws those of a species at a level, with a pipeline that is set.
    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, bucket: u32) {
        pass.draw_indirect(&self.draws.raw, self.draws.offset + u64::from(bucket * DRAW_WORDS * 4));
    }
}
