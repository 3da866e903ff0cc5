//! A world: the land and everything on it.
//!
//! A frame draws [`Surfaces`]. [`open`] creates them from a scene file, a DEM, a pyramid, or an address.

pub(crate) mod given_water;
pub(crate) mod lone_model;
pub(crate) mod map;
mod meshes;
pub(crate) mod named_places;
pub(crate) mod path_fit;
pub(crate) mod open;
pub(crate) mod scattered;
mod start_view;
mod tree_models;

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use self::given_water::GivenWater;
pub(crate) use self::open::inputs_of;
pub use self::open::{OpenWorld, WorldError, open_store, scene_of};
pub(crate) use self::open::{exaggerated, rounded};
use crate::drainage::{Drainage, Land};
use crate::draped::{Draped, LandInView, Resident};
use crate::forest::cover::Cover;
use crate::forest::model::TreeModel;
use crate::gpu::Gpu;
use crate::imagery::{Imagery, ResidentImagery};
pub use crate::mesh::MeshError;
use crate::mesh::placed::Placed;
use crate::scene::view::Rig;
use crate::scene::{Forest, Wind};
use crate::style::{Features, Layer, Style};
use crate::tiles::terrain::Loading;
pub use crate::tiles::terrain::{Terrain, TerrainError, TerrainOptions};

/// Keeps pipelines, as the driver compiled them, in hachure's cache folder. Without a cache folder each run compiles
/// all of them.
pub(crate) fn store_pipelines(gpu: &Gpu) {
    if let Ok(folder) = crate::pyramid::store::cache_folder(None) {
        gpu.store_pipelines(&folder);
    }
}

/// The surfaces of a world, of all kinds.
pub struct Surfaces {
    pub terrain: Terrain,
    meshes: Option<Arc<Placed>>,
    forest: Option<Forest>,
    forest_cover: Option<Arc<Cover>>,
    tree_models: Vec<Arc<TreeModel>>,
    tree_detail: f64,
    wind: Option<Wind>,
    sea_level_m: Option<f64>,
    exaggeration: f64,
    given_water: Option<Arc<GivenWater>>,
    drainage: Drainage,
    features: Option<Resident>,
    imagery: Option<ResidentImagery>,
}

impl From<Terrain> for Surfaces {
    /// Creates the surfaces of bare land.
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
            exaggeration: 1.0,
            given_water: None,
            drainage: Drainage::default(),
            features: None,
            imagery: None,
        }
    }
}

impl Surfaces {
    /// Returns whether there are surfaces that may have colours of their own.
    pub(crate) fn has_local_colors(&self) -> bool {
        self.meshes.is_some() || self.forest.is_some()
    }

    /// Returns the models on the land, if there are any.
    pub(crate) fn meshes(&self) -> Option<&Arc<Placed>> {
        self.meshes.as_ref()
    }

    /// Replaces the models on the land.
    pub(crate) fn set_meshes(&mut self, placed: Placed) {
        self.meshes = (!placed.standing.is_empty()).then(|| Arc::new(placed));
    }

    /// Returns the forest, if there is one.
    pub fn forest(&self) -> Option<&Forest> {
        self.forest.as_ref()
    }

    /// Replaces or removes the forest.
    pub fn set_forest(&mut self, forest: Option<Forest>) {
        self.forest = forest;
    }

    /// Returns the rasters that define where the forest's trees are, if there are any.
    pub(crate) fn forest_cover(&self) -> Option<&Arc<Cover>> {
        self.forest_cover.as_ref()
    }

    /// Replaces or removes the rasters that define where trees are.
    pub(crate) fn set_forest_cover(&mut self, cover: Option<Arc<Cover>>) {
        self.forest_cover = cover;
    }

    /// Returns whether everything that a forest needs from files has been read.
    #[cfg(feature = "window")]
    pub(crate) fn has_files_of(&self, forest: &Forest) -> bool {
        let has_cover = forest.cover.files().next().is_none() || self.forest_cover.is_some();
        has_cover && forest.models.len() <= self.tree_models.len()
    }

    /// Returns the models of the trees, in the order of the forest ([`Forest::models`]).
    pub(crate) fn tree_models(&self) -> &[Arc<TreeModel>] {
        &self.tree_models
    }

    /// Sets [`Surfaces::tree_models`]; a species whose model is missing is drawn as a broadleaf.
    pub(crate) fn set_tree_models(&mut self, models: Vec<Arc<TreeModel>>) {
        self.tree_models = models;
    }

    /// Returns the wind, if there is any.
    pub fn wind(&self) -> Option<Wind> {
        self.wind
    }

    /// Returns the sea level in metres, exaggerated as heights are, if there is a sea: land that is not higher is sea.
    pub fn sea_level_m(&self) -> Option<f64> {
        self.sea_level_m
    }

    /// Changes the sea level, or removes the sea.
    pub fn set_sea_level(&mut self, sea_level_m: Option<f64>) {
        self.sea_level_m = sea_level_m;
    }

    /// Returns the factor by which the heights of the land are multiplied; 1 is true to scale.
    pub(crate) fn exaggeration(&self) -> f64 {
        self.exaggeration
    }

    /// Sets [`Surfaces::exaggeration`] to that of the store of the terrain's tiles.
    pub(crate) fn set_exaggeration(&mut self, factor: f64) {
        self.exaggeration = factor;
    }

    /// Returns the water given in addition to that which heights show, if there is any.
    pub(crate) fn given_water(&self) -> Option<&Arc<GivenWater>> {
        self.given_water.as_ref()
    }

    /// Replaces or removes the given water. To be called before the first frame, because maps of tiles are cached.
    pub(crate) fn set_given_water(&mut self, water: Option<Arc<GivenWater>>) {
        self.given_water = water;
    }

    /// Returns the streams and ridge lines of what is in view.
    pub(crate) fn drainage(&self) -> &Drainage {
        &self.drainage
    }

    /// Updates the streams and ridge lines that a style draws for what a rig sees.
    pub(crate) fn follow_drainage(&mut self, gpu: &Gpu, rig: &Rig, style: &Style) {
        self.drainage.take_arrived(gpu);
        let waits = self.terrain.options().loading == Loading::Wait;
        for of in style.drainage_lines() {
            let land =
                Land { store: Arc::clone(self.terrain.store()), projection: self.terrain.grid_projection().clone() };
            self.drainage.follow(gpu, &land, rig, of, waits);
        }
    }

    /// Returns the features on the land, if there are any.
    pub(crate) fn features(&self) -> Option<&Resident> {
        self.features.as_ref()
    }

    /// Returns whether features of files are on the land, and whether a graticule is.
    pub(crate) fn has_features_and_graticule(&self) -> [bool; 2] {
        self.features.as_ref().map_or([false; 2], Resident::has_features_and_graticule)
    }

    /// Returns what is wrong with the layers of features of a style, each as a clause.
    pub(crate) fn feature_doubts(&self, style: &Style) -> Vec<String> {
        self.features.as_ref().map_or_else(Vec::new, |features| features.doubts(&layers_of_features(style)))
    }

    /// Replaces the features on the land.
    pub(crate) fn set_features(&mut self, features: Draped) {
        self.features = (!features.is_empty()).then(|| Resident::new(Arc::new(features)));
    }

    /// Prepares the features that a style draws for what a rig sees.
    pub(crate) fn follow_features(&mut self, gpu: &Gpu, rig: &Rig, style: &Style) {
        let Some(features) = &mut self.features else { return };
        let terrain = &self.terrain;
        let range_m = terrain.range_m().map(f64::from);
        let land = LandInView { range_m, earth_curvature: &|camera_z_m| terrain.earth_curvature(camera_z_m) };
        features.follow(gpu, &layers_of_features(style), rig, &land);
    }

    /// Returns the images on the land, if there are any.
    pub(crate) fn imagery(&self) -> Option<&ResidentImagery> {
        self.imagery.as_ref()
    }

    /// Replaces the images on the land.
    pub(crate) fn set_imagery(&mut self, gpu: &Gpu, imagery: Imagery) {
        self.imagery = (!imagery.is_empty()).then(|| ResidentImagery::new(gpu, imagery));
    }

    /// Prepares the images on the land for what a rig sees, in a style that draws them.
    pub(crate) fn follow_imagery(&mut self, gpu: &Gpu, rig: &Rig, style: &Style) {
        if let Some(imagery) = self.imagery.as_mut().filter(|_| style.image.is_used()) {
            imagery.follow(gpu, &self.terrain, rig);
        }
    }

    /// Replaces or removes the wind.
    pub fn set_wind(&mut self, wind: Option<Wind>) {
        self.wind = wind.filter(|wind| wind.speed_m_s > 0.0);
    }

    /// Returns the factor of tree detail: trees switch to simpler forms at a size that is smaller by this factor.
    pub fn tree_detail(&self) -> f64 {
        self.tree_detail
    }

    /// Sets [`Surfaces::tree_detail`], within 0.01 to 100; the default is 1.
    pub fn set_tree_detail(&mut self, detail: f64) {
        self.tree_detail = detail.clamp(0.01, 100.0);
    }

    /// Returns a lower bound of the distance of all surfaces from a camera, in metres.
    pub(crate) fn nearest_m(&self, camera_m: DVec3) -> f64 {
        let mesh_m = self.meshes().map_or(f64::INFINITY, |placed| placed.nearest_m(camera_m));
        self.terrain.nearest_m(camera_m).min(mesh_m)
    }
}

fn layers_of_features(style: &Style) -> Vec<&Features> {
    let layers = style.layers.iter().filter_map(|layer| match layer {
        Layer::Features(layer) => Some(layer),
        _ => None,
    });
    layers.collect()
}

/// Returns the name of a world for people, with the seed that replaces its own.
#[cfg(feature = "window")]
pub(crate) fn title_with_seed(world: Option<&str>, seed: Option<u32>) -> String {
    let title = title(world);
    seed.map_or_else(|| title.clone(), |seed| format!("{title}, seed {seed}"))
}

/// Returns the name of a world for people: that of its file without the folder.
pub(crate) fn title(world: Option<&str>) -> String {
    let Some(world) = world else { return "the built-in world".to_owned() };
    Path::new(world).file_name().map_or_else(|| world.to_owned(), |name| name.to_string_lossy().into_owned())
}
