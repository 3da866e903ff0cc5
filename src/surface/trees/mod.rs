//! Trees of a forest: the visible ones are selected on the GPU in each frame, and drawn as instances.
//!
//! The CPU lists the blocks of points that the eye's frustum may see ([`crate::forest::blocks`]). For each of their
//! points, [`place`] decides on the GPU whether there is a tree and how it is drawn: as a mesh, as one of fewer
//! triangles ([`raster`]), from pictures ([`impostor`]), or as a part of the canopy. Large trees throw shadows
//! ([`shadow`]), and near ones have strokes ([`near`], [`edges`]). Nothing is read back: draws are indirect. In wind,
//! [`sway`] computes how each tree bends, and the passes that draw trees also write how far each pixel has moved.

pub(crate) mod colors;
pub(crate) mod edges;
pub(crate) mod impostor;
pub(crate) mod marks;
pub(crate) mod near;
pub(crate) mod place;
pub(crate) mod raster;
pub(crate) mod resolve;
pub(crate) mod shadow;
mod shared;
pub(crate) mod sway;

use std::sync::Arc;

use self::place::MAX_TREES;
pub(crate) use self::place::TreeInstance;
use self::shared::{Look, Shared};
use crate::forest::model::TreeModel;
use crate::forest::species::Grown;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::drawer::Drawer;
use crate::gpu::recorder::Recorder;
#[cfg(test)]
pub(crate) use crate::gpu::wgsl::shared::trees::{CANOPY, IMPOSTOR, MIDDLE, NEAR};
pub(crate) use crate::gpu::wgsl::shared::trees::{DRAW_WORDS, TREE_LEVELS};
use crate::scene::Forest;
use crate::scene::forest::Form;

/// The [`TreeInstance`]s of an eye.
pub(crate) const INSTANCES: BufferKind = BufferKind::storage("tree instances");
/// Lists of instance numbers: one for each species and level, then one for each species with the trees that throw
/// shadows.
pub(crate) const ORDER: BufferKind = BufferKind::storage("tree order");
/// The arguments of each list's draw ([`DRAW_WORDS`]), then the number of instances.
pub(crate) const DRAWS: BufferKind = BufferKind::indirect("tree draws");

/// Lists of a species: one for each level, and one for shadows.
pub(crate) const TREE_LISTS: u32 = TREE_LEVELS + 1;

/// The trees of one frame.
pub(crate) struct DrawnTrees {
    shared: Arc<Shared>,
    instances: Buffer,
    order: Buffer,
    draws: Buffer,
}

impl DrawnTrees {
    /// Creates the buffers of a frame, in which no trees are selected yet. Returns `None` while the species are grown
    /// in the background. A species whose model is not among `models` is drawn as a broadleaf.
    pub(crate) fn of(recorder: &mut Recorder<'_>, forest: &Forest, models: &[Arc<TreeModel>]) -> Option<Self> {
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
            instances: recorder.buffer(&INSTANCES, u64::from(MAX_TREES) * size_of::<TreeInstance>() as u64),
            order: recorder.buffer(&ORDER, lists * u64::from(MAX_TREES) * 4),
            draws: recorder.buffer(&DRAWS, (lists + 1) * u64::from(DRAW_WORDS) * 4),
        })
    }

    /// Returns the number of the list of a species' shadows.
    fn list_of_shadows(&self, species: usize) -> u32 {
        self.shared.species.len() as u32 * TREE_LEVELS + species as u32
    }

    /// Returns the instance numbers of a list.
    fn order_of(&self, list: u32) -> Buffer {
        let bytes = u64::from(MAX_TREES) * 4;
        self.order.slice(u64::from(list) * bytes, bytes)
    }

    /// Draws the trees of a list with the pipeline that is set.
    fn draw(&self, pass: &mut Drawer<'_>, list: u32) {
        pass.draw_indirect(&self.draws.raw, self.draws.offset + u64::from(list * DRAW_WORDS * 4));
    }
}
