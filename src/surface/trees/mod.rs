//! Trees of a forest: the visible ones are selected on the GPU in each frame, and drawn as instances.
//!
//! The CPU lists the blocks of points that the eye's frustum may see ([`crate::forest::blocks`]). For each of their
//! points, [`place`] decides on the GPU whether there is a tree and how it is drawn: as a mesh, as one of fewer
//! triangles ([`raster`]), from pictures ([`impostor`]), or as a part of the canopy; it leaves out trees that land and
//! models hide ([`tile_depth`]). [`list`] lists them from front to back. Large trees throw shadows ([`shadow`]), and
//! near ones have strokes ([`near`], [`edges`]). Nothing is read back: draws are indirect. In wind,
//! [`sway`] computes how each tree bends, and the passes that draw trees also write how far each pixel has moved.

pub(crate) mod colors;
pub(crate) mod edges;
pub(crate) mod impostor;
mod list;
pub(crate) mod marks;
pub(crate) mod near;
pub(crate) mod place;
pub(crate) mod raster;
pub(crate) mod resolve;
pub(crate) mod shadow;
mod shared;
pub(crate) mod sway;
pub(crate) mod tile_depth;

use std::sync::Arc;

pub(crate) use self::place::TreeInstance;
use self::place::{MAX_INSTANCES, MAX_TREES};
use self::shared::{Look, Shared};
use crate::forest::model::TreeModel;
use crate::forest::species::Grown;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::drawer::Drawer;
use crate::gpu::recorder::Recorder;
pub(crate) use crate::gpu::wgsl::shared::trees::DRAW_WORDS;
#[cfg(test)]
pub(crate) use crate::gpu::wgsl::shared::trees::{CANOPY, IMPOSTOR, MIDDLE, NEAR, NO_LIST, TREE_LEVELS};
use crate::gpu::wgsl::shared::trees::{LISTS_OF_ALL, LISTS_OF_SPECIES, MESH_LISTS};
use crate::scene::Forest;
use crate::scene::forest::Form;

/// The [`TreeInstance`]s of an eye, with room for the largest possible number.
pub(crate) const INSTANCES: BufferKind = BufferKind::storage("tree instances");
/// For each place the lists of its instance, if there is one, and the bits of its distance: `place.wgsl`.
pub(crate) const KEYS: BufferKind = BufferKind::storage("tree keys");
/// Lists of instance numbers, from front to back: [`list_of`] and [`DrawnTrees::list_of_shadows`] number them.
pub(crate) const ORDER: BufferKind = BufferKind::storage("tree order");
/// The arguments of each list's draw ([`DRAW_WORDS`]).
pub(crate) const DRAWS: BufferKind = BufferKind::indirect("tree draws");

/// Returns the number of lists in a forest of `all` species.
pub(crate) const fn lists(all: u32) -> u32 {
    all * LISTS_OF_SPECIES + LISTS_OF_ALL
}

/// Returns the list of a species and a level, in a forest of `all` species. All species share the lists of impostors
/// and of pieces of canopy.
pub(crate) const fn list_of(all: u32, species: u32, level: u32) -> u32 {
    if level < MESH_LISTS { species * MESH_LISTS + level } else { all * MESH_LISTS + level - MESH_LISTS }
}

/// The trees of one frame.
pub(crate) struct DrawnTrees {
    shared: Arc<Shared>,
    instances: Buffer,
    keys: Buffer,
    order: Buffer,
    draws: Buffer,
}

/// Returns the looks of the species of a forest.
fn looks(forest: &Forest, models: &[Arc<TreeModel>]) -> Vec<Look> {
    let look = |form: Form| match form {
        Form::Conifer => Look::Grown(Grown::Conifer),
        Form::Broadleaf => Look::Grown(Grown::Broadleaf),
        Form::Birch => Look::Grown(Grown::Birch),
        Form::Snag => Look::Grown(Grown::Snag),
        Form::Model(number) => {
            models.get(number).map_or(Look::Grown(Grown::Broadleaf), |model| Look::Model(Arc::clone(model)))
        }
    };
    forest.species.iter().map(|species| look(species.form)).collect()
}

impl DrawnTrees {
    /// Creates the buffers of a frame, in which no trees are selected yet. Returns `None` while the species are grown
    /// in the background. A species whose model is not among `models` is drawn as a broadleaf.
    pub(crate) fn of(recorder: &mut Recorder<'_>, forest: &Forest, models: &[Arc<TreeModel>]) -> Option<Self> {
        let looks = looks(forest, models);
        let asked = looks.clone();
        let shared = recorder
            .cached_in_background(move |shared: &Shared| shared.looks == asked, move |gpu| Shared::new(gpu, looks))?;
        let lists = u64::from(lists(forest.species.len() as u32));
        Some(Self {
            shared,
            instances: recorder.buffer(&INSTANCES, u64::from(MAX_INSTANCES) * size_of::<TreeInstance>() as u64),
            keys: recorder.buffer(&KEYS, u64::from(MAX_INSTANCES) * 8),
            order: recorder.buffer(&ORDER, lists * u64::from(MAX_TREES) * 4),
            draws: recorder.buffer(&DRAWS, lists * u64::from(DRAW_WORDS) * 4),
        })
    }

    /// Returns the number of species.
    fn species(&self) -> u32 {
        self.shared.species.len() as u32
    }

    /// Returns the number of the list of a species' shadows.
    fn list_of_shadows(&self, species: u32) -> u32 {
        self.species() * MESH_LISTS + LISTS_OF_ALL + species
    }

    /// Returns the instance numbers of a list.
    fn order_of(&self, list: u32) -> Buffer {
        let bytes = u64::from(MAX_TREES) * 4;
        self.order.slice(u64::from(list) * bytes, bytes)
    }

    /// Draws the trees of a list with the pipeline that is set, by the indices of their mesh if they have one.
    fn draw(&self, pass: &mut Drawer<'_>, list: u32, indices: Option<&Buffer>) {
        let arguments = self.draws.offset + u64::from(list * DRAW_WORDS * 4);
        let Some(indices) = indices else { return pass.draw_indirect(&self.draws.raw, arguments) };
        pass.set_index_buffer(indices.raw.slice(..), wgpu::IndexFormat::Uint16);
        pass.draw_indexed_indirect(&self.draws.raw, arguments);
    }
}

/// The pictures of impostors, as tests see them.
#[cfg(test)]
pub(crate) struct Pictured {
    pub species: Vec<PicturedSpecies>,
    pub frame_px: u32,
    pub levels: u32,
    pub hulls: Vec<Hull>,
}

/// The bounds of the pictures of a species.
#[cfg(test)]
pub(crate) struct PicturedSpecies {
    pub middle: [f32; 3],
    pub radius: f32,
    pub cylinder: [f32; 4],
}

#[cfg(test)]
pub(crate) use crate::gpu::wgsl::surface::trees::impostor::TreeHull as Hull;

/// Returns the pictures of trees and of pieces of canopy of a forest without models that a device has drawn.
#[cfg(test)]
pub(crate) fn pictured(gpu: &crate::gpu::Gpu, forest: &Forest) -> [Pictured; 2] {
    let looks = looks(forest, &[]);
    let shared = gpu.cache().known(|shared: &Shared| shared.looks == looks).unwrap();
    let of = |pictures: &shared::TreePictures, species: fn(&shared::SpeciesModel) -> &shared::SpeciesPictures| {
        let bytes = pictures.hulls.raw.size() as usize;
        let hulls = crate::gpu::readback::read_buffer(gpu, &pictures.hulls.raw, bytes / size_of::<Hull>()).unwrap();
        let all: Vec<&shared::SpeciesPictures> = shared.species.iter().map(species).collect();
        let sizes = &all[0].color_indices;
        let bounds = |own: &&shared::SpeciesPictures| PicturedSpecies {
            middle: own.middle,
            radius: own.radius,
            cylinder: own.cylinder,
        };
        let species = all.iter().map(bounds).collect();
        Pictured { species, frame_px: sizes[0].0, levels: sizes.len() as u32, hulls }
    };
    [of(&shared.alone, |model| &model.alone), of(&shared.canopy, |model| &model.canopy)]
}
