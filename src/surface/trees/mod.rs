//! Trees of a forest: those that an eye may see are found on the GPU in each frame, and drawn as instances.
//!
//! The CPU lists the blocks of points that the eye's frustum may see ([`crate::forest::blocks`]); each of their points is
//! asked on the GPU whether a tree stands there and how it is drawn ([`place`]): as a mesh, as one of fewer triangles
//! ([`raster`]), from pictures ([`impostor`]), or as a part of the canopy. Large ones throw shadows ([`shadow`]), and near ones have
//! strokes ([`near`], [`edges`]). Nothing
//! is read back: draws are indirect. Where wind blows, [`sway`] tells how each bends, and those who draw them also how far
//! what they draw has moved.

pub mod colors;
pub mod edges;
pub mod impostor;
pub mod marks;
pub mod near;
pub mod place;
pub mod raster;
pub mod resolve;
pub mod shadow;
mod shared;
pub mod sway;

use std::sync::Arc;

use self::place::MOST_TREES;
pub use self::place::TreeInstance;
use self::shared::{Look, Shared};
use crate::forest::model::TreeModel;
use crate::forest::species::Grown;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
pub use crate::gpu::wgsl::shared::trees::{CANOPY, DRAW_WORDS, IMPOSTOR, MIDDLE, NEAR, TREE_LEVELS};
use crate::scene::Forest;
use crate::scene::forest::Form;

/// [`TreeInstance`]s of an eye.
pub const INSTANCES: BufferKind = BufferKind::storage("tree instances");
/// Lists of numbers of instances: for each species and level, then for each species those that throw shadows.
pub const ORDER: BufferKind = BufferKind::storage("tree order");
/// For each list the arguments of its draw ([`DRAW_WORDS`]), then the number of instances.
pub const DRAWS: BufferKind = BufferKind::indirect("tree draws");

/// Lists of a species: one for each level, and one of shadows.
pub const TREE_LISTS: u32 = TREE_LEVELS + 1;

/// The trees of a frame.
pub struct DrawnTrees {
    shared: Arc<Shared>,
    instances: Buffer,
    order: Buffer,
    draws: Buffer,
}

impl DrawnTrees {
    /// None are found yet. Nothing while its species are grown beside the frame. A species whose model is not among
    /// `models` is a broadleaf.
    pub fn of(recorder: &mut Recorder<'_>, forest: &Forest, models: &[Arc<TreeModel>]) -> Option<Self> {
        let look = |form: Form| match form {
            Form::Conifer => Look::Grown(Grown::Conifer),
            Form::Broadleaf => Look::Grown(Grown::Broadleaf),
            Form::Birch => Look::Grown(Grown::Birch),
            Form::Snag => Look::Grown(Grown::Snag),
            Form::Model(number) => {
                models.get(number).map_or(Look::Grown(Grown::Broadleaf), |model| Look::Model(Arc::clone(model)))
            }
        };
        let looks: Vec<Look> = forest.species.iter().map(|species| look(species.form)).collect();
        let asked = looks.clone();
        let shared = recorder
            .cached_in_background(move |shared: &Shared| shared.looks == asked, move |gpu| Shared::new(gpu, looks))?;
        let lists = u64::from(TREE_LISTS) * forest.species.len() as u64;
        Some(Self {
            shared,
            instances: recorder.buffer(&INSTANCES, u64::from(MOST_TREES) * size_of::<TreeInstance>() as u64),
            order: recorder.buffer(&ORDER, lists * u64::from(MOST_TREES) * 4),
            draws: recorder.buffer(&DRAWS, (lists + 1) * u64::from(DRAW_WORDS) * 4),
        })
    }

    /// The list of the shadows of a species.
    fn list_of_shadows(&self, species: usize) -> u32 {
        self.shared.species.len() as u32 * TREE_LEVELS + species as u32
    }

    /// The numbers of the instances in a list.
    fn order_of(&self, list: u32) -> Buffer {
        let bytes = u64::from(MOST_TREES) * 4;
        self.order.slice(u64::from(list) * bytes, bytes)
    }

    /// Draws those of a list, with a pipeline that is set.
    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, list: u32) {
        pass.draw_indirect(&self.draws.raw, self.draws.offset + u64::from(list * DRAW_WORDS * 4));
    }
}
