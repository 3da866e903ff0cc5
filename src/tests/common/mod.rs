//! Helpers of the tests of drawing: a GPU, data, worlds, pictures.
//!
//! Many tests have planted errors: deliberate mistakes that a check must catch, which shows that the check works.
#![allow(dead_code, reason = "each test file uses only some of this")]
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

pub(crate) mod draw;
pub(crate) mod equations;
pub(crate) mod field;
pub(crate) mod hill;
pub(crate) mod log;
pub(crate) mod shot;
pub(crate) mod silhouette;
pub(crate) mod stores;

use std::cell::RefCell;
use std::collections::VecDeque;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec2;
use hachure::gpu::Gpu;
use hachure::gpu::device::AdapterWish;
use hachure::pyramid::store::MemoryStore;
use hachure::pyramid::{self, BakeOptions, Pyramid, TileStore};
use hachure::scene::camera::Camera;
use hachure::scene::view::Pose;
use hachure::source::georeference::{Crs, Georeference};
use hachure::source::{self, HeightGrid, OpenOptions, Silent, VoidMode, WorldMapping};
use hachure::style::{self, Layer, Style, Tone};
use hachure::world::{Surfaces, Terrain, TerrainOptions};

/// A device that tests share, with its pipelines and its cache: one for each test that runs at the same time. Returns
/// `None` where there is no GPU and prints why; `HACHURE_REQUIRE_GPU=1` turns that into a failure.
pub(crate) fn gpu() -> Option<Gpu> {
    LEASE.with_borrow_mut(|lease| {
        if lease.is_none() {
            let spare = SPARE.lock().unwrap().pop();
            *lease = spare.or_else(own_gpu).map(Lease);
        }
        lease.as_ref().map(|lease| lease.0.clone())
    })
}

/// The devices that no test is using.
static SPARE: Mutex<Vec<Gpu>> = Mutex::new(Vec::new());

thread_local! {
    /// The device of the test that runs on this thread: libtest starts a thread for each test.
    static LEASE: RefCell<Option<Lease>> = const { RefCell::new(None) };
}

/// A device that returns to [`SPARE`] when its test ends.
struct Lease(Gpu);

impl Drop for Lease {
    fn drop(&mut self) {
        // The errors of a test that failed are not those of the next one.
        let _ = self.0.check();
        if let Ok(mut spare) = SPARE.lock() {
            spare.push(self.0.clone());
        }
    }
}

/// Opens a separate device, for a test that counts what a device creates, replaces its shaders, or breaks it.
pub(crate) fn own_gpu() -> Option<Gpu> {
    match Gpu::open(&AdapterWish::Best) {
        Ok(gpu) => Some(gpu),
        Err(error) => {
            assert!(std::env::var_os("HACHURE_REQUIRE_GPU").is_none_or(|value| value != "1"), "{error}");
            println!("skipped: {error}");
            None
        }
    }
}

/// Returns whether the long tier of the tests is wanted (`./check --full`): large pictures, many cases, long flights.
pub(crate) fn full() -> bool {
    std::env::var("HACHURE_TESTS").is_ok_and(|tier| tier == "full")
}

/// Returns the presets that a test of all kinds of ink draws: in the long tier all of them, otherwise one for each kind
/// of lines, strokes, marks, tones, water and sky.
pub(crate) fn presets() -> Vec<&'static str> {
    const EACH_KIND: [&str; 14] = [
        "plain",
        "lsa",
        "roystan",
        "strokes",
        "charcoal",
        "hachures",
        "crosshatch",
        "stipple",
        "engraving",
        "wash",
        "night",
        "suggestive",
        "tone-lines",
        "relief",
    ];
    let is_wanted = |name: &&str| full() || EACH_KIND.contains(name);
    style::names().into_iter().filter(is_wanted).collect()
}

/// Loads a preset with the tones of its light, which are not fitted to the picture: what a test expects of a tone does not
/// depend on the rest of the picture.
pub(crate) fn absolute(name: &str) -> Style {
    let mut style = Style::load(name).unwrap();
    if let Tone::Toon(toon) = &mut style.tone {
        toon.fit = false;
    }
    style
}

/// Loads a preset for a test of all kinds of ink that measures no rows of hachures. In the fast tier rows have twice the
/// spacing: at the sizes of the tests, `hachures` otherwise takes as long as ten other presets.
pub(crate) fn preset(name: &str) -> Style {
    let mut style = absolute(name);
    for layer in style.layers.iter_mut().filter(|_| !full()) {
        if let Layer::Rows(rows) = layer {
            rows.spacing_px *= 2.0;
        }
    }
    style
}

/// Returns a folder for data that takes long to make and is reused between runs.
pub(crate) fn between_runs(name: &str) -> PathBuf {
    let target = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("target");
    std::env::var_os("CARGO_TARGET_DIR").map_or(target, PathBuf::from).join("tmp").join(name)
}

/// Returns the path of a real data file (`dem/geotiff/…`), or prints the path and returns `None` if there is none.
pub(crate) fn real_data(name: &str) -> Option<PathBuf> {
    let default_folder = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let path = std::env::var_os("HACHURE_TEST_DATA").map_or_else(default_folder, PathBuf::from).join(name);
    if path.is_file() {
        return Some(path);
    }
    println!("skipped: {} does not exist", path.display());
    None
}

/// Reads the heights of a file with small holes filled.
pub(crate) fn filled_grid(path: &Path) -> HeightGrid {
    let options = OpenOptions { voids: VoidMode::Fill, ..OpenOptions::default() };
    source::read_all(&*source::open_reader_with(path, &options).unwrap(), path, &Silent).unwrap()
}

/// Loads a preset without its cap on crowded lines and strokes, so that it draws all of them.
pub(crate) fn all_lines(name: &str) -> Style {
    let mut style = Style::load(name).unwrap();
    for layer in style.layers.iter_mut() {
        match layer {
            Layer::Lines(lines) => lines.crowd = 1.0,
            Layer::Strokes(strokes) => strokes.crowd = 1.0,
            _ => {}
        }
    }
    style
}

/// A height grid and its terrain.
pub(crate) struct World {
    pub gpu: Gpu,
    pub grid: HeightGrid,
    pub mapping: WorldMapping,
    pub surfaces: Surfaces,
    /// The temporary folder with the files of the store, if it has any. It is removed with the world.
    folder: Option<tempfile::TempDir>,
}

impl World {
    /// Opens the world of `grid`, whose tiles are in memory; `None` where there is no GPU.
    pub(crate) fn new(grid: HeightGrid, lod_error_px: f64) -> Option<Self> {
        let gpu = gpu()?;
        Self::on(gpu, grid, lod_error_px)
    }

    /// Does the same as [`World::new`] on a device that no other test uses.
    pub(crate) fn on_own_device(grid: HeightGrid, lod_error_px: f64) -> Option<Self> {
        let gpu = own_gpu()?;
        Self::on(gpu, grid, lod_error_px)
    }

    fn on(gpu: Gpu, grid: HeightGrid, lod_error_px: f64) -> Option<Self> {
        let store = in_memory(&grid);
        Self::of_store_on(gpu, grid, None, store, lod_error_px)
    }

    /// Bakes `grid` to a file and opens that; `None` where there is no GPU.
    pub(crate) fn of_file(grid: HeightGrid, lod_error_px: f64) -> Option<Self> {
        let (folder, pyramid) = baked(&grid);
        Self::of_store(grid, folder, Arc::new(pyramid), lod_error_px)
    }

    /// Opens the world of a store whose files are in `folder`; `grid` is the reference for comparisons.
    pub(crate) fn of_store(
        grid: HeightGrid,
        folder: tempfile::TempDir,
        store: Arc<dyn TileStore>,
        lod_error_px: f64,
    ) -> Option<Self> {
        let gpu = gpu()?;
        Self::of_store_on(gpu, grid, Some(folder), store, lod_error_px)
    }

    fn of_store_on(
        gpu: Gpu,
        grid: HeightGrid,
        folder: Option<tempfile::TempDir>,
        store: Arc<dyn TileStore>,
        lod_error_px: f64,
    ) -> Option<Self> {
        let size = store.levels()[0];
        let mapping = WorldMapping::new(store.georeference(), size.width, size.height).unwrap();
        let options = TerrainOptions { lod_error_px, ..TerrainOptions::default() };
        let surfaces = Terrain::new(&gpu, store, options).unwrap().into();
        Some(Self { gpu, grid, mapping, surfaces, folder })
    }

    /// Opens a real DEM; `None` where the file does not exist.
    pub(crate) fn real(name: &str, lod_error_px: f64) -> Option<Self> {
        let grid = source::open(&real_data(name)?, &Silent).unwrap();
        Self::new(grid, lod_error_px)
    }

    /// Opens a real DEM with small holes filled, as pictures have them: jumps at holes are no contours.
    pub(crate) fn filled(name: &str, lod_error_px: f64) -> Option<Self> {
        Self::new(filled_grid(&real_data(name)?), lod_error_px)
    }

    /// Returns the pose of a camera `x,y,z,yaw,pitch,fov`.
    pub(crate) fn pose(&self, camera: &str) -> Pose {
        let camera: Camera = camera.parse().unwrap();
        pose_of(&camera.on_ground(|x, y| {
            let terrain = &self.surfaces.terrain;
            terrain.height_m(DVec2::new(x, y)).unwrap_or_else(|| f64::from(terrain.range_m()[1]))
        }))
    }
}

/// Returns the pose of a camera whose height is above sea level.
pub(crate) fn pose_of(camera: &Camera) -> Pose {
    Pose {
        position_m: camera.position_m,
        forward: camera.forward(),
        right: camera.right(),
        up: camera.up(),
        fov_rad: camera.fov_deg.to_radians(),
    }
}

/// Opens the tiles of a grid in memory. Tests with the same grid share its store: the most recently used stores are
/// cached, up to [`CACHED_BYTES`].
pub(crate) fn in_memory(grid: &HeightGrid) -> Arc<dyn TileStore> {
    static STORES: Mutex<VecDeque<(u64, Arc<MemoryStore>)>> = Mutex::new(VecDeque::new());
    let key = content_hash(grid);
    let stores = || STORES.lock().unwrap_or_else(PoisonError::into_inner);
    let found = {
        let mut stores = stores();
        let at = stores.iter().position(|(known, _)| *known == key);
        at.and_then(|at| stores.remove(at)).map(|(_, store)| store)
    };
    // The lock is not held meanwhile, so two tests may make the same store; only one of these is cached.
    let store = found.unwrap_or_else(|| Arc::new(MemoryStore::new(grid.clone(), "test", &Silent).unwrap()));
    // A store that would take the place of many others is not cached.
    if store.bytes() <= CACHED_BYTES / 4 {
        let mut stores = stores();
        stores.retain(|(known, _)| *known != key);
        stores.push_front((key, Arc::clone(&store)));
        let mut bytes = 0;
        stores.retain(|(_, store)| {
            bytes += store.bytes();
            bytes <= CACHED_BYTES
        });
    }
    store
}

/// The memory of cached stores: about 110 of 321 × 321 samples.
const CACHED_BYTES: u64 = 64 << 20;

/// Hashes everything that a store depends on.
fn content_hash(grid: &HeightGrid) -> u64 {
    let mut hasher = DefaultHasher::new();
    (grid.width, grid.height).hash(&mut hasher);
    format!("{:?}", grid.georeference).hash(&mut hasher);
    bytemuck::cast_slice::<f32, u8>(&grid.heights_m).hash(&mut hasher);
    hasher.finish()
}

/// Bakes a grid into a pyramid in a temporary folder.
pub(crate) fn baked(grid: &HeightGrid) -> (tempfile::TempDir, Pyramid) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("world.tif");
    pyramid::bake(grid, &path, &BakeOptions::default(), &Silent).unwrap();
    let pyramid = Pyramid::open(&path).unwrap();
    (folder, pyramid)
}

/// Returns the heights of a function of (east, north) on a grid in metres whose centre is the origin.
pub(crate) fn grid_of(width: u32, height: u32, spacing_m: f64, height_m: impl Fn(f64, f64) -> f64) -> HeightGrid {
    let half = [f64::from(width - 1), f64::from(height - 1)].map(|last| 0.5 * last * spacing_m);
    let heights_m = (0..height)
        .flat_map(|row| (0..width).map(move |column| (column, row)))
        .map(|(column, row)| {
            height_m(f64::from(column) * spacing_m - half[0], half[1] - f64::from(row) * spacing_m) as f32
        })
        .collect();
    HeightGrid {
        width,
        height,
        heights_m,
        georeference: Georeference {
            crs_from_grid: [-half[0], spacing_m, 0.0, half[1], 0.0, -spacing_m],
            crs: Crs::Local,
            geokeys: Default::default(),
        },
    }
}

/// Returns a pseudorandom number in [0, 1) for each (i, j), by SplitMix64.
pub(crate) fn random(i: i64, j: i64) -> f64 {
    let mut z = (i as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ (j as u64).wrapping_mul(0xD1B5_4A32_D192_ED03);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Returns the height of rough land: octaves of value noise down to the sample spacing, with cliffs.
pub(crate) fn rough_height_m(x_m: f64, y_m: f64) -> f64 {
    let mut sum = 0.0;
    for octave in 0..9 {
        let size_m = 3000.0 / f64::from(1 << octave);
        let (u, v) = (x_m / size_m, y_m / size_m);
        let (i, j) = (u.floor(), v.floor());
        let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
        let (s, t) = (smooth(u - i), smooth(v - j));
        let at = |di: i64, dj: i64| random(i as i64 + di + 1000 * octave, j as i64 + dj);
        let value = (at(0, 0) * (1.0 - s) + at(1, 0) * s) * (1.0 - t) + (at(0, 1) * (1.0 - s) + at(1, 1) * s) * t;
        sum += value * 0.35 * size_m;
    }
    // Cliffs: terraces of 120 m in some of the land.
    let terrace = (sum / 120.0).floor() * 120.0 + 120.0 * ((sum / 120.0).fract() * 6.0).min(1.0);
    if random((x_m / 2500.0).floor() as i64, (y_m / 2500.0).floor() as i64 + 77) < 0.4 { terrace } else { sum }
}

/// Returns the value below which the fraction `part` of the values is; sorts the values.
pub(crate) fn quantile(values: &mut [f64], part: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1);
    values.get((last as f64 * part).ceil() as usize).copied().unwrap_or(f64::NAN)
}
