//! An open world, ready to be drawn: a scene file, a DEM, a baked pyramid, a model, or by default the built-in world.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;

use glam::DVec2;
use rustc_hash::FxHashSet;

use crate::draped::{Draped, DrapedError};
use crate::file::guard::Inputs;
use crate::file::message::named;
use crate::forest::cover::{Cover, CoverError};
use crate::gpu::Gpu;
use crate::imagery::{self, ImageError, Imagery};
use crate::mesh::{MeshError, obj};
use crate::pyramid::store::{Altered, ContinentStore, MemoryStore, MosaicStore};
use crate::pyramid::{self, PyramidError, TileStore};
use crate::scene::camera::Camera;
use crate::scene::embedded;
use crate::scene::mesh_list::{self, MeshListError};
use crate::scene::reach::Reach;
use crate::scene::scene_file::SceneError;
use crate::scene::sun_time::SunTimeError;
use crate::scene::view::Pose;
use crate::scene::{Light, MeshPositions, Scene, World};
use crate::source::georeference::Georeference;
use crate::source::mosaic::Choice;
use crate::source::samples::MAX_HEIGHT_M;
use crate::source::{self, EarthPlace, HeightGrid, OpenOptions, Progress, Silent};
use crate::tiles::Terrain;
use crate::tiles::terrain::{TerrainError, TerrainOptions};
use crate::world::given_water::{GivenWater, GivenWaterError};
use crate::world::{Surfaces, lone_model, meshes, tree_models};

/// A COG with at most this many samples is baked all the same: it takes two seconds, and then its errors are measured.
const BAKED_SAMPLES: usize = 1 << 24;

/// The name of heights that have no file, in messages.
const HEIGHTS_IN_MEMORY: &str = "heights in memory";

/// The reason why a world could not be opened. The message is one line that names the file; the causes follow as
/// sources.
#[derive(Debug, thiserror::Error)]
pub enum WorldError {
    /// The scene file is invalid.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The DEM cannot be read, or the cache cannot be written.
    #[error(transparent)]
    Pyramid(#[from] PyramidError),
    /// A file that the scene names cannot be drawn.
    #[error("{}: {source}", named(scene))]
    InScene {
        scene: PathBuf,
        /// The error of the file that it names.
        source: Box<WorldError>,
    },
    /// The DEM has no valid georeference, or is too wide.
    #[error("{}: {source}", named(name))]
    Terrain {
        /// Name of the pyramid.
        name: String,
        source: TerrainError,
    },
    /// The ground under a camera or a mesh, from which its height is counted, cannot be read.
    #[error("cannot read ground heights: {0}")]
    Ground(#[source] Arc<PyramidError>),
    /// A mesh of the scene cannot be read, or there are too many.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A list of mesh places cannot be read.
    #[error(transparent)]
    MeshList(#[from] MeshListError),
    /// A tree model cannot be read, or is not a tree.
    #[error("forest.species.file: {0}")]
    TreeModel(#[source] MeshError),
    /// A raster of the scene's forest cannot be read, or is outside the world.
    #[error(transparent)]
    Cover(#[from] CoverError),
    /// A water file of the scene is invalid.
    #[error(transparent)]
    Water(#[from] GivenWaterError),
    /// A file of features of the scene cannot be used.
    #[error(transparent)]
    Features(#[from] DrapedError),
    /// An image of the scene cannot be on the land.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The sun cannot be computed for the scene's date.
    #[error(transparent)]
    SunTime(#[from] SunTimeError),
    /// The distance between samples is not a length.
    #[error("{HEIGHTS_IN_MEMORY}: a spacing of {spacing_m} m is not possible; it must be a finite number above 0")]
    Spacing {
        /// The distance that was given, in metres.
        spacing_m: f64,
    },
    /// The scene's heights are those that an earlier call gave.
    #[error(
        "{HEIGHTS_IN_MEMORY}: a scene cannot contain heights from memory; open the world with OpenWorld::from_heights"
    )]
    Given,
    /// A no-data value or a unit is given for heights that are not baked here.
    #[error("{}: --nodata and --height-unit work only for local DEM files; bake the file with them first", named(name))]
    NoData {
        /// Name of the world.
        name: String,
    },
}

impl WorldError {
    /// Adds the name of the scene file, if there is one, because the error may be about another file.
    fn of(self, scene: &Scene) -> Self {
        match &scene.file {
            Some(scene) => Self::InScene { scene: scene.clone(), source: Box::new(self) },
            None => self,
        }
    }
}

/// An open world.
pub struct OpenWorld {
    /// Light, atmosphere and start.
    pub scene: Scene,
    /// The land and everything on it.
    pub surfaces: Surfaces,
}

/// Finds the scene of a world, named by the path of a scene file, a DEM, a pyramid or a model, by a URL, by the name of an
/// embedded scene, or not at all.
///
/// # Errors
/// If the scene file is invalid, or names files beyond its `reach`.
pub fn scene_of(world: Option<&str>, reach: Reach) -> Result<Scene, WorldError> {
    let Some(world) = world else { return Ok(Scene::default()) };
    if world.contains("://") {
        return Ok(Scene::of_world(World::Url(world.to_owned())));
    }
    if let Some(scene) = embedded::scene(world) {
        return Ok(scene.read()?);
    }
    let path = Path::new(world);
    if is_scene(path) {
        let scene = Scene::read(path)?;
        scene.check_reach(path, reach)?;
        return Ok(scene);
    }
    Ok(if is_model(path) { Scene::of_model(path) } else { Scene::of_world(World::File(path.to_owned())) })
}

fn is_scene(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"))
}

/// Returns whether a name is that of a model, which is a world by itself.
fn is_model(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("obj")) && !path.is_dir()
}

/// Returns all local files that a world is read from: the scene file, DEMs and rasters with their sidecar files, meshes
/// with their materials and textures.
pub(crate) fn inputs_of(world: Option<&str>, scene: &Scene) -> Inputs {
    let mut inputs = Inputs::default();
    if let Some(path) = world.map(Path::new).filter(|path| is_scene(path)) {
        inputs.add(path);
    }
    match &scene.world {
        World::File(path) => source::add_inputs(path, &mut inputs),
        World::Files(paths) => paths.iter().for_each(|path| source::add_inputs(path, &mut inputs)),
        World::Url(_) | World::Procedural { .. } | World::Continent { .. } | World::Model(_) | World::Memory => {}
    }
    let rasters = scene.forest.iter().flat_map(|forest| forest.cover.files());
    rasters.for_each(|(_, path)| source::add_inputs(path, &mut inputs));
    scene.water.files().for_each(|(_, path)| source::add_inputs(path, &mut inputs));
    scene.features.iter().for_each(|file| inputs.add(&file.path));
    scene.images.iter().for_each(|file| source::add_inputs(&file.path, &mut inputs));
    if scene.embedded.is_none() {
        let mut known: FxHashSet<&Path> = FxHashSet::default();
        let trees = scene.forest.iter().flat_map(|forest| &forest.models).map(|model| &model.file);
        for file in scene.meshes.iter().map(|mesh| &mesh.file).chain(trees) {
            if !known.insert(file) {
                continue;
            }
            inputs.add(file);
            obj::sidecar_files(file).iter().for_each(|file| inputs.add(file));
        }
        scene.mesh_lists().for_each(|list| inputs.add(list));
    }
    inputs
}

/// Opens the tiles of a scene's world. A DEM that is not a pyramid is baked into the cache.
///
/// # Errors
/// If the DEM cannot be read or the cache cannot be written.
pub fn open_store(scene: &Scene, progress: &dyn Progress) -> Result<Arc<dyn TileStore>, WorldError> {
    open_store_unnamed(scene, progress).map_err(|error| error.of(scene))
}

/// Returns the tiles of a store with exaggerated heights; `store` itself if the factor is 1.
pub(crate) fn exaggerated(store: Arc<dyn TileStore>, factor: f64) -> Arc<dyn TileStore> {
    Altered::exaggerated(store, factor)
}

/// Returns the tiles of a store with heights rounded as by `hachure bake --max-error`; `store` itself if the error is 0.
pub(crate) fn rounded(store: Arc<dyn TileStore>, error_m: f64) -> Arc<dyn TileStore> {
    Altered::rounded(store, error_m)
}

fn open_store_unnamed(scene: &Scene, progress: &dyn Progress) -> Result<Arc<dyn TileStore>, WorldError> {
    let store: Arc<dyn TileStore> = match &scene.world {
        World::File(path) => several(std::slice::from_ref(path), &scene.heights, progress)?,
        World::Files(paths) => several(paths, &scene.heights, progress)?,
        World::Url(name) if scene.heights.changes_heights() => return Err(WorldError::NoData { name: name.clone() }),
        World::Url(url) => pyramid::store::open_remote(url, scene.heights.voids)?,
        World::Procedural { seed } => {
            let key = format!("procedural {} seed {seed}", source::procedural::VERSION);
            let seed = *seed;
            let grow = move |progress: &dyn Progress| source::procedural::generate(seed, progress);
            pyramid::store::open_or_grow_store(&key, &format!("procedural-{seed}"), grow, None, progress)?
        }
        World::Continent { seed, size_samples, spacing_m } => {
            Arc::new(ContinentStore::open(*seed, *size_samples, *spacing_m, None, progress)?)
        }
        World::Model(model) => lone_model::ground(model, progress)?,
        World::Memory => return Err(WorldError::Given),
    };
    Ok(Altered::exaggerated(store, scene.vertical_exaggeration))
}

/// Opens a DEM, or several as one world: files, and the height files of folders.
fn several(
    inputs: &[PathBuf],
    options: &OpenOptions,
    progress: &dyn Progress,
) -> Result<Arc<dyn TileStore>, WorldError> {
    let choice = Choice::of(inputs, options).map_err(|error| PyramidError::Load(Box::new(error)))?;
    choice.warn();
    let files = &choice.files;
    let options = source::mosaic::member_options(files, options);
    let open = |(file, options): (&PathBuf, &OpenOptions)| match progress.stop().load(Ordering::Relaxed) {
        true => Err(PyramidError::Stopped.into()),
        false => open_file(file, options, progress),
    };
    let mut stores = files.iter().zip(&options).map(open).collect::<Result<Vec<_>, _>>()?;
    Ok(if stores.len() == 1 { stores.remove(0) } else { Arc::new(MosaicStore::new(stores)?) })
}

/// Opens a baked pyramid or a large COG directly, and everything else from the cache, into which it is baked.
fn open_file(path: &Path, options: &OpenOptions, progress: &dyn Progress) -> Result<Arc<dyn TileStore>, WorldError> {
    let is_own = pyramid::format::sidecar_path(path).exists() || !path.is_file();
    let as_it_is = if is_own || options.changes_heights() {
        None
    } else {
        pyramid::store::open_local_cog_with(path, options.voids)?
    };
    match as_it_is {
        Some(store) if store.levels()[0].samples() > BAKED_SAMPLES => {
            options.warn_unused(path, "a GeoTIFF", &[]);
            Ok(store)
        }
        Some(store) => match pyramid::store::open_or_bake_store(path, options, progress) {
            Err(error @ PyramidError::Cache { .. }) => {
                let name = path.display();
                tracing::warn!("{}. Reading {name} without baking, with estimated errors", error.message());
                Ok(store)
            }
            opened => Ok(opened?),
        },
        None => Ok(pyramid::store::open_or_bake_store(path, options, progress)?),
    }
}

impl OpenWorld {
    /// Opens `world` for drawing. A DEM that has not been baked yet is baked into the cache, without progress.
    ///
    /// # Errors
    /// If the scene or its DEM is invalid, or the scene names files outside of its folder.
    pub fn open(gpu: &Gpu, world: Option<&str>, options: TerrainOptions) -> Result<Self, WorldError> {
        let scene = scene_of(world, Reach::SceneFolder)?;
        let store = open_store(&scene, &Silent)?;
        Self::on_gpu(gpu, scene, store, options)
    }

    /// Opens heights in memory for drawing: an array that was computed, or read by other means. Nothing is written to
    /// disk, and the errors of all tiles are measured.
    ///
    /// `heights_m` has `width` × `height` heights in metres, row by row: the first row is the northernmost, and each
    /// runs from west to east. NaN is no-data, as is everything that is infinite or beyond ±1000 km. Samples are
    /// `spacing_m` metres apart in both directions. The world's origin is the middle of the grid, and the world has no
    /// position on the earth; [`OpenWorld::from_grid`] takes a georeference.
    ///
    /// Light and atmosphere are those of a bare DEM, and may be changed in [`OpenWorld::scene`]. The heights are moved,
    /// not copied, and take 5⅓ bytes per sample.
    ///
    /// # Errors
    /// [`WorldError::Spacing`]; [`WorldError::Pyramid`] if there are fewer than 2 × 2 or more than 2³¹ samples, if
    /// their number is not `width` × `height`, if all are no-data, or if there is not enough memory; and
    /// [`WorldError::Terrain`] if a side has more than 2²⁴ samples. The message is one line.
    pub fn from_heights(
        gpu: &Gpu,
        heights_m: Vec<f32>,
        [width, height]: [u32; 2],
        spacing_m: f64,
        options: TerrainOptions,
    ) -> Result<Self, WorldError> {
        if !(spacing_m.is_finite() && spacing_m > 0.0) {
            return Err(WorldError::Spacing { spacing_m });
        }
        let georeference = Georeference::local(width, height, spacing_m);
        Self::from_grid(gpu, HeightGrid { width, height, heights_m, georeference }, options)
    }

    /// Opens a grid in memory like [`OpenWorld::from_heights`], at the position on the earth that its georeference
    /// gives. The rows are in the order of the georeference.
    ///
    /// # Errors
    /// The errors of [`OpenWorld::from_heights`], and [`WorldError::Terrain`] or [`WorldError::Pyramid`] if the
    /// georeference is invalid.
    pub fn from_grid(gpu: &Gpu, mut grid: HeightGrid, options: TerrainOptions) -> Result<Self, WorldError> {
        let is_height = |height_m: f32| f64::from(height_m).abs() <= MAX_HEIGHT_M;
        grid.heights_m.iter_mut().filter(|height| !is_height(**height)).for_each(|height| *height = f32::NAN);
        let store = MemoryStore::new(grid, HEIGHTS_IN_MEMORY, &Silent)?;
        Self::on_gpu(gpu, Scene::of_world(World::Memory), Arc::new(store), options)
    }

    /// Prepares an open store of tiles for drawing.
    ///
    /// # Errors
    /// If the georeference is invalid, or a file of the scene cannot be used.
    pub fn on_gpu(
        gpu: &Gpu,
        scene: Scene,
        store: Arc<dyn TileStore>,
        options: TerrainOptions,
    ) -> Result<Self, WorldError> {
        Self::on_gpu_with(gpu, scene, store, options, &Silent)
    }

    /// Prepares a store like [`OpenWorld::on_gpu`], with progress for meshes that take long to read.
    ///
    /// # Errors
    /// The errors of [`OpenWorld::on_gpu`].
    pub(crate) fn on_gpu_with(
        gpu: &Gpu,
        mut scene: Scene,
        store: Arc<dyn TileStore>,
        options: TerrainOptions,
        progress: &dyn Progress,
    ) -> Result<Self, WorldError> {
        let name = store.name();
        lone_model::set_haze(&mut scene, progress)?;
        if let Some(time) = scene.sun_time {
            let size = store.levels()[0];
            let earth = EarthPlace::of_grid(store.georeference(), size.width, size.height);
            scene.sun = time.sun(earth).map_err(|error| WorldError::from(error).of(&scene))?;
        }
        let inverse_radius = scene.earth.map_or(0.0, |earth| earth.inverse_radius());
        let options = TerrainOptions { inverse_radius, ..options };
        let terrain =
            Terrain::new(gpu, store, options).map_err(|source| WorldError::Terrain { name, source }.of(&scene))?;
        let mut world = Self { scene, surfaces: terrain.into() };
        let placed = meshes::place(&world, progress).map_err(|error| error.of(&world.scene))?;
        world.surfaces.set_meshes(placed);
        let cover = world.forest_cover().map_err(|error| WorldError::from(error).of(&world.scene))?;
        world.surfaces.set_forest_cover(cover.map(Arc::new));
        let models = tree_models::read(&world.scene, progress);
        world.surfaces.set_tree_models(models.map_err(|error| WorldError::TreeModel(error).of(&world.scene))?);
        let factor = world.scene.vertical_exaggeration;
        world.surfaces.set_exaggeration(factor);
        world.surfaces.set_forest(world.scene.forest.as_ref().map(|forest| forest.exaggerated(factor)));
        world.surfaces.set_wind(world.scene.wind);
        world.surfaces.set_sea_level(world.scene.sea_level_m.map(|level_m| level_m * factor));
        let water = world.given_water().map_err(|error| WorldError::from(error).of(&world.scene))?;
        world.surfaces.set_given_water(water.map(Arc::new));
        let features = world.read_features().map_err(|error| WorldError::from(error).of(&world.scene))?;
        world.surfaces.set_features(features);
        let imagery = world.open_imagery().map_err(|error| WorldError::from(error).of(&world.scene))?;
        world.surfaces.set_imagery(gpu, imagery);
        Ok(world)
    }

    /// Reads the files of a scene for a world with this place and size, without a GPU: rasters and models of its forest,
    /// its water, and its meshes with their lists.
    ///
    /// # Errors
    /// The first file that is invalid.
    pub fn read_files(scene: &Scene, place: &Georeference, samples: [u32; 2]) -> Result<(), WorldError> {
        if let Some(forest) = &scene.forest {
            Cover::load(&forest.cover, place, samples).map_err(|error| WorldError::from(error).of(scene))?;
        }
        tree_models::read(scene, &Silent).map_err(|error| WorldError::TreeModel(error).of(scene))?;
        GivenWater::load(&scene.water, place, samples).map_err(|error| WorldError::from(error).of(scene))?;
        Draped::read(&scene.features, scene.graticule, place, samples)
            .map_err(|error| WorldError::from(error).of(scene))?;
        imagery::check(&scene.images, place, samples).map_err(|error| WorldError::from(error).of(scene))?;
        for placement in &scene.meshes {
            let mesh = scene.read_mesh_with(&placement.file, &Silent);
            mesh.map_err(|error| WorldError::from(error).of(scene))?;
            if let MeshPositions::Listed(list) = &placement.positions {
                mesh_list::read(list).map_err(|error| WorldError::from(error).of(scene))?;
            }
        }
        Ok(())
    }

    /// Reads the scene's water files, if it has any.
    fn given_water(&self) -> Result<Option<GivenWater>, GivenWaterError> {
        let store = self.surfaces.terrain.store();
        let size = store.levels()[0];
        GivenWater::load(&self.scene.water, store.georeference(), [size.width, size.height])
    }

    /// Reads the scene's files of features.
    fn read_features(&self) -> Result<Draped, DrapedError> {
        let store = self.surfaces.terrain.store();
        let size = store.levels()[0];
        Draped::read(&self.scene.features, self.scene.graticule, store.georeference(), [size.width, size.height])
    }

    /// Opens the scene's images.
    fn open_imagery(&self) -> Result<Imagery, ImageError> {
        let store = self.surfaces.terrain.store();
        let size = store.levels()[0];
        Imagery::open(&self.scene.images, store.georeference(), [size.width, size.height])
    }

    /// Reads the rasters of the scene's forest, if it has any.
    fn forest_cover(&self) -> Result<Option<Cover>, CoverError> {
        let Some(forest) = &self.scene.forest else { return Ok(None) };
        let store = self.surfaces.terrain.store();
        let size = store.levels()[0];
        Cover::load(&forest.cover, store.georeference(), [size.width, size.height])
    }

    /// Returns the extent to the east and to the north, in metres.
    pub fn extent_m(&self) -> [f64; 2] {
        self.surfaces.terrain.extent_m()
    }

    /// Returns the light and atmosphere of the scene. Land that is higher than it is wide is as clear as land that is as
    /// wide as it is high.
    pub fn light(&self) -> Light {
        let [east_m, north_m] = self.extent_m();
        let [low_m, high_m] = self.surfaces.terrain.range_m().map(f64::from);
        let tallness = 2.0 * (high_m - low_m) / east_m.hypot(north_m);
        let scale = if tallness.is_finite() { tallness.max(1.0) } else { 1.0 };
        self.scene.light([scale * east_m, scale * north_m])
    }

    /// Returns the ground height in metres; in holes and outside, the lowest height.
    pub fn ground_m(&self, east_m: f64, north_m: f64) -> f64 {
        self.surfaces
            .terrain
            .height_m(DVec2::new(east_m, north_m))
            .unwrap_or_else(|| f64::from(self.surfaces.terrain.range_m()[0]))
    }

    /// Returns an error if [`OpenWorld::ground_m`] could not read a tile so far.
    ///
    /// # Errors
    /// [`WorldError::Ground`] with the reason.
    pub fn ground_was_read(&self) -> Result<(), WorldError> {
        self.surfaces.terrain.ground().failure().map_or(Ok(()), |failure| Err(WorldError::Ground(failure)))
    }

    /// Converts a camera to a pose: heights above ground become absolute heights.
    pub fn pose(&self, camera: &Camera) -> Pose {
        let camera = camera.on_ground(|x, y| self.ground_m(x, y));
        Pose {
            position_m: camera.position_m,
            forward: camera.forward(),
            right: camera.right(),
            up: camera.up(),
            fov_rad: camera.fov_deg.to_radians(),
        }
    }

    /// Converts a pose to a camera.
    pub fn camera(&self, pose: &Pose) -> Camera {
        let forward = pose.forward;
        Camera {
            position_m: pose.position_m,
            height_above_ground: false,
            yaw_deg: pose.yaw_deg(),
            pitch_deg: forward.z.clamp(-1.0, 1.0).asin().to_degrees(),
            fov_deg: pose.fov_rad.to_degrees(),
        }
    }
}
