//! A world: the land and what stands on it, side by side.
//!
//! A frame draws [`Surfaces`]. [`open`] makes them of what a user names: a scene file, a DEM, a pyramid, an address.

pub mod given_water;
mod map;
mod meshes;
pub mod open;
pub mod scattered;
mod tree_models;

use std::sync::Arc;

use glam::DVec3;

use self::given_water::GivenWater;
pub use self::open::{OpenWorld, WorldError, inputs_of, open_store, scene_of};
use crate::forest::cover::Cover;
use crate::forest::model::TreeModel;
use crate::mesh::placed::Placed;
use crate::scene::{Forest, Wind};
use crate::tiles::Terrain;

/// The surfaces of a world, of every kind.
pub struct Surfaces {
    /// The land.
    pub terrain: Terrain,
    meshes: Option<Arc<Placed>>,
    forest: Option<Forest>,
    forest_cover: Option<Arc<Cover>>,
    tree_models: Vec<Arc<TreeModel>>,
    tree_detail: f64,
    wind: Option<Wind>,
    sea_level_m: Option<f64>,
    given_water: Option<Arc<GivenWater>>,
}

impl From<Terrain> for Surfaces {
    /// Bare land.
    fn from(terrain: Terrain) -> Self {
        Self {
            terrain,
            meshes: None,
            forest: None,
            forest_cover: None,
            tree_models: Vec::new(),
            tree_detail: 1.0,
            wind: None,
            sea_level_m: None,
            given_water: None,
        }
    }
}

impl Surfaces {
    /// Whether there is something that may have colours of its own.
    pub fn has_local_colors(&self) -> bool {
        self.meshes.is_some() || self.forest.is_some()
    }

    /// What stands on the land, if anything does.
    pub fn meshes(&self) -> Option<&Arc<Placed>> {
        self.meshes.as_ref()
    }

    /// Puts meshes onto the land, in place of those that stood there.
    pub fn set_meshes(&mut self, placed: Placed) {
        self.meshes = (!placed.standing.is_empty()).then(|| Arc::new(placed));
    }

    /// Its trees, if it has any.
    pub fn forest(&self) -> Option<&Forest> {
        self.forest.as_ref()
    }

    /// Grows another forest, or none.
    pub fn set_forest(&mut self, forest: Option<Forest>) {
        self.forest = forest;
    }

    /// What rasters say of where its trees stand, if any do.
    pub fn forest_cover(&self) -> Option<&Arc<Cover>> {
        self.forest_cover.as_ref()
    }

    /// Lets trees stand where rasters say it, or none of them.
    pub fn set_forest_cover(&mut self, cover: Option<Arc<Cover>>) {
        self.forest_cover = cover;
    }

    /// The models of its trees, as the forest counts them ([`Forest::models`]).
    pub fn tree_models(&self) -> &[Arc<TreeModel>] {
        &self.tree_models
    }

    /// Sets [`Surfaces::tree_models`]; a species whose model is missing is drawn as a broadleaf.
    pub fn set_tree_models(&mut self, models: Vec<Arc<TreeModel>>) {
        self.tree_models = models;
    }

    /// What moves its trees, if anything does.
    pub fn wind(&self) -> Option<Wind> {
        self.wind
    }

    /// Land that is no higher is the sea, if there is one; in metres, exaggerated as heights are.
    pub fn sea_level_m(&self) -> Option<f64> {
        self.sea_level_m
    }

    /// Lets the sea stand at another height, or nowhere.
    pub fn set_sea_level(&mut self, sea_level_m: Option<f64>) {
        self.sea_level_m = sea_level_m;
    }

    /// Water that is given beside what heights show, if any is.
    pub fn given_water(&self) -> Option<&Arc<GivenWater>> {
        self.given_water.as_ref()
    }

    /// Gives it other water, or none; to be called before the first frame, since maps of tiles are kept.
    pub fn set_given_water(&mut self, water: Option<Arc<GivenWater>>) {
        self.given_water = water;
    }

    /// Lets another wind blow, or none.
    pub fn set_wind(&mut self, wind: Option<Wind>) {
        self.wind = wind.filter(|wind| wind.speed_m_s > 0.0);
    }

    /// Trees go over to something simpler where they are so many times smaller than is usual.
    pub fn tree_detail(&self) -> f64 {
        self.tree_detail
    }

    /// Sets [`Surfaces::tree_detail`]; 1 until told.
    pub fn set_tree_detail(&mut self, detail: f64) {
        self.tree_detail = detail.clamp(0.01, 100.0);
    }

    /// No part of any surface is nearer to a camera than this.
    pub fn nearest_m(&self, camera_m: DVec3) -> f64 {
        let mesh_m = self.meshes().map_or(f64::INFINITY, |placed| placed.nearest_m(camera_m));
        self.terrain.nearest_m(camera_m).min(mesh_m)
    }
}
