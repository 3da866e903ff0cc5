//! Opens another world in the background, while the window shows the current one.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::background::{Background, NoResult};
use super::works::BackgroundTask;
use super::{FlightWorld, Lasting};
use crate::file::message::{chain, named};
use crate::frame::{self, Light};
use crate::gpu::Gpu;
use crate::picture::imprint::More;
use crate::scene::Scene;
use crate::scene::overrides::Overrides;
use crate::scene::reach::Reach;
use crate::scene::view::{Rig, View};
use crate::style::Style;
use crate::tiles::terrain::TerrainOptions;
use crate::world::{OpenWorld, Surfaces, exaggerated, open_store, scene_of, title, title_with_seed};

/// Longest time in which the tiles of a view are awaited.
const LONGEST: Duration = Duration::from_secs(20);
/// Interval at which the program checks whether tiles have arrived.
const LOOK: Duration = Duration::from_millis(3);

/// The world to open, and the window that shows it.
pub(super) struct WorldToOpen {
    /// The device of the window.
    pub gpu: Gpu,
    /// Path of a scene, a DEM or a folder, an address, or the name of a built-in scene; `None` is the built-in world.
    pub name: Option<String>,
    /// The files that a scene may name.
    pub reach: Reach,
    /// Values that replace those of the world's scene.
    pub overrides: Overrides,
    /// Factor on heights that replaces the scene's.
    pub exaggeration: Option<f64>,
    /// The options of the window's terrain.
    pub options: TerrainOptions,
    /// The memory for tiles, if it is not the default, for imprints.
    pub tile_memory_mib: Option<u64>,
    /// Size of a picture.
    pub size_px: [u32; 2],
    /// The style in which the world is drawn first.
    pub style: Style,
}

/// A world that is being opened.
pub(super) struct OtherWorld {
    /// The name of the world, as it was given.
    pub name: String,
    /// The seed that replaces that of the scene, if this is the current world with another seed.
    pub seed: Option<u32>,
    /// The progress of opening, and its cancellation.
    pub work: Arc<BackgroundTask>,
    done: Background<Result<Box<FlightWorld>, String>>,
}

impl OtherWorld {
    /// Begins to open a world, and calls `wake` when there is progress and when it is open.
    pub(super) fn start(to_open: WorldToOpen, wake: impl Fn() + Send + Sync + 'static) -> Self {
        let name = to_open.name.clone().unwrap_or_default();
        let seed = to_open.overrides.seed;
        let title = format!("Opening {}", title_with_seed(to_open.name.as_deref(), seed));
        let work = Arc::new(BackgroundTask::new(title, wake));
        let [of_thread, at_end] = [Arc::clone(&work), Arc::clone(&work)];
        let open = move || open(to_open, &of_thread).map(Box::new);
        let done = Background::start("world", open, move || at_end.wake());
        Self { name, seed, work, done }
    }

    /// Takes the world, or why it could not be opened; `None` while it is being opened.
    pub(super) fn take(&self) -> Option<Result<Box<FlightWorld>, String>> {
        let done = self.done.take()?;
        Some(
            done.unwrap_or_else(|NoResult| {
                Err(format!("{}: cannot be opened, for an unknown reason", named(&self.name)))
            }),
        )
    }
}

/// Opens a world as `fly` does, and loads the tiles of its start view.
fn open(to_open: WorldToOpen, work: &BackgroundTask) -> Result<FlightWorld, String> {
    let WorldToOpen { gpu, name, reach, overrides, exaggeration, options, tile_memory_mib, size_px, style } = to_open;
    let scene = scene_of(name.as_deref(), reach).map_err(|error| chain(&error))?;
    let own_forest = scene.forest.clone();
    let scene = overrides.apply_to(scene).map_err(|error| format!("{}: {error}", title(name.as_deref())))?;
    let vertical_exaggeration = exaggeration.unwrap_or(scene.vertical_exaggeration);
    let scene = Scene { vertical_exaggeration, ..scene };
    let true_to_scale = Scene { vertical_exaggeration: 1.0, ..scene.clone() };
    let heights = open_store(&true_to_scale, work).map_err(|error| chain(&error))?;
    let store = exaggerated(Arc::clone(&heights), scene.vertical_exaggeration);
    let world = OpenWorld::on_gpu_with(&gpu, scene, store, options, work).map_err(|error| chain(&error))?;
    let [width, height] = size_px.map(f64::from);
    let start = world.start_camera(width / height.max(1.0));
    let start = start.on_ground(|east_m, north_m| world.ground_m(east_m, north_m));
    world.ground_was_read().map_err(|error| chain(&error))?;
    let Overrides { sea_level, trees, seed } = overrides;
    let more = More {
        tile_memory: tile_memory_mib,
        exaggeration,
        sea_level: sea_level.map(|level| level.to_string()),
        trees: trees.map(|trees| trees.to_string()),
        seed,
        ..More::default()
    };
    let (pose, light) = (world.pose(&start), world.light());
    let lasting = Lasting { heights, own_forest };
    let mut world = FlightWorld::new(world, start, name, more, lasting);
    let rig = Rig::mono(View::whole(pose, pose, size_px));
    work.report_tiles();
    settle(&gpu, &mut world.surfaces, &rig, &style, &light, || work.is_cancelled());
    Ok(world)
}

impl BackgroundTask {
    fn report_tiles(&self) {
        crate::source::Progress::report(self, "loading tiles", 1.0);
    }
}

/// Loads the tiles of a view, so that the first picture is not coarse.
pub(super) fn settle(
    gpu: &Gpu,
    surfaces: &mut Surfaces,
    rig: &Rig,
    style: &Style,
    light: &Light,
    stops: impl Fn() -> bool,
) {
    let begun = Instant::now();
    while begun.elapsed() < LONGEST && !stops() {
        let prepared = frame::prepare(gpu, surfaces, rig, style, light);
        if prepared.tiles.pending == 0 && !prepared.tiles.late && prepared.tiles.loaded == 0 {
            break;
        }
        std::thread::sleep(LOOK);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

    use std::path::Path;
    use std::sync::mpsc::channel;

    use super::*;
    use crate::pyramid::{BakeOptions, PyramidError, bake, store};
    use crate::source::{HeightGrid, Silent, SourceError};
    use crate::tests::common::{gpu, grid_of, rough_height_m};

    fn grid() -> HeightGrid {
        grid_of(150, 130, 30.0, rough_height_m)
    }

    fn world_to_open(gpu: &Gpu, name: &Path) -> WorldToOpen {
        WorldToOpen {
            gpu: gpu.clone(),
            name: Some(name.display().to_string()),
            reach: Reach::SceneFolder,
            overrides: Overrides::default(),
            exaggeration: None,
            options: TerrainOptions { loading: crate::tiles::terrain::Loading::Stream, ..TerrainOptions::default() },
            tile_memory_mib: Some(64),
            size_px: [160, 90],
            style: Style::load("ink").unwrap(),
        }
    }

    fn opened(to_open: WorldToOpen) -> Result<Box<FlightWorld>, String> {
        let (sender, woken) = channel();
        let sender = std::sync::Mutex::new(sender);
        let opening = OtherWorld::start(to_open, move || _ = sender.lock().unwrap().send(()));
        loop {
            if let Some(done) = opening.take() {
                return done;
            }
            woken.recv_timeout(Duration::from_secs(120)).unwrap();
        }
    }

    #[test]
    fn a_world_is_opened_with_its_start_view() {
        let Some(gpu) = gpu() else { return };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("land.tif");
        bake(&grid(), &path, &BakeOptions::default(), &Silent).unwrap();
        let world = opened(world_to_open(&gpu, &path)).unwrap();
        assert_eq!((&*world.name, world.world.as_deref()), ("land.tif", path.to_str()));
        assert_eq!(world.more, More { tile_memory: Some(64), ..More::default() });
        let ground_m = world.surfaces.terrain.height_m(world.start.position_m.truncate());
        assert!(ground_m.is_none_or(|ground_m| world.start.position_m.z > ground_m), "{:?}", world.start);
        // The first picture is not coarse.
        assert!(world.surfaces.terrain.tile_counts().on_gpu > 0);
    }

    #[test]
    fn an_error_names_the_file() {
        let Some(gpu) = gpu() else { return };
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in [("gone.tif", None), ("broken.tif", Some("II*\0broken")), ("a.toml", Some("[world]\n"))] {
            let path = folder.path().join(name);
            if let Some(text) = text {
                crate::file::atomic::write(&path, text.as_bytes()).unwrap();
            }
            let Err(error) = opened(world_to_open(&gpu, &path)) else { panic!("{name}") };
            assert!(error.contains(name) && !error.contains('\n'), "{error}");
        }
        // A scene reaches no further than on the command line.
        let scene = folder.path().join("far.toml");
        crate::file::atomic::write(&scene, b"[world]\ndem = \"/etc/passwd\"\n").unwrap();
        let Err(error) = opened(world_to_open(&gpu, &scene)) else { panic!() };
        assert!(error.contains("outside the scene's folder"), "{error}");
    }

    #[test]
    fn a_cancelled_bake_stops() {
        let cache = tempfile::tempdir().unwrap();
        let bake_with = |work: &BackgroundTask| {
            let load = || Ok::<_, SourceError>(grid());
            store::open_or_bake_key("a key", "a name", load, Some(cache.path()), work)
        };
        let work = BackgroundTask::new("a bake".to_owned(), || ());
        work.cancel();
        assert!(matches!(bake_with(&work), Err(PyramidError::Stopped)));
        let work = BackgroundTask::new("a bake".to_owned(), || ());
        assert!(bake_with(&work).is_ok(), "planted: a bake that is not cancelled");
        // Nor are the files of a folder read one after the other.
        let Some(gpu) = gpu() else { return };
        let path = cache.path().join("land.tif");
        bake(&grid(), &path, &BakeOptions::default(), &Silent).unwrap();
        work.cancel();
        assert!(open(world_to_open(&gpu, &path), &work).is_err_and(|error| error.contains("stopped")));
    }
}
