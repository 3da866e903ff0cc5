//! Flies a camera path in the window.
//!
//! The file is read in the background, because heights above the ground may have to be read from disk; there it is also
//! compared with the world.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::background::{Background, NoResult};
use crate::file::message::named;
use crate::scene::World;
use crate::scene::camera::Camera;
use crate::scene::path::CameraPath;
use crate::tiles::terrain::GroundHeights;
use crate::world::path_fit;

/// The path to read, and the world in which it is flown.
pub(super) struct Wanted {
    /// The file, or the name of a built-in path.
    pub path: PathBuf,
    /// The world's name as it was given; `None` is the built-in world.
    pub world_name: Option<String>,
    /// The world.
    pub world: World,
    /// Its ground.
    pub ground: GroundHeights,
}

/// A path that suits the world, ready to be flown.
#[derive(Debug)]
pub(super) struct Read {
    /// The path as it was given.
    pub name: PathBuf,
    /// The cameras, in the world's frame.
    pub path: CameraPath,
    /// A warning for the user.
    pub warning: Option<String>,
}

/// A path that is being read.
pub(super) struct Reading(Background<Result<Read, String>>, PathBuf);

impl Reading {
    /// Begins to read a path, and calls `wake` when it is read.
    pub(super) fn start(wanted: Wanted, wake: impl Fn() + Send + 'static) -> Self {
        let path = wanted.path.clone();
        Self(Background::start("camera path", move || read(wanted), wake), path)
    }

    /// Takes the path, or why it cannot be flown; `None` while it is being read.
    pub(super) fn take(&self) -> Option<Result<Read, String>> {
        let done = self.0.take()?;
        Some(done.unwrap_or_else(|NoResult| Err(format!("{}: cannot be read", named(&self.1)))))
    }
}

/// Reads a path for a world as `render` does.
///
/// # Errors
/// One line with the file and the cause: it is invalid, or made for another world.
pub(super) fn read(wanted: Wanted) -> Result<Read, String> {
    let Wanted { path: name, world_name, world, ground } = wanted;
    path_fit::check_name(&name, world_name.as_deref(), &world).map_err(|error| {
        // There is no option in a window.
        error.to_string().trim_start_matches("--path ").to_owned()
    })?;
    let text = CameraPath::read_text(&name).map_err(|error| error.to_string())?;
    let warning = path_fit::check_places(&name, &text, &ground).map_err(|error| error.to_string())?;
    let path = CameraPath::parse_on_ground(&name, text.as_bytes(), |x, y| ground.height_m(x, y));
    Ok(Read { name, path: path.map_err(|error| error.to_string())?, warning })
}

/// A path that is being flown.
#[derive(Debug)]
pub(super) struct PathFlight {
    path: CameraPath,
    begun: Option<Instant>,
}

impl PathFlight {
    /// Creates a flight that begins with the next frame.
    pub(super) fn new(path: CameraPath) -> Self {
        Self { path, begun: None }
    }

    /// Returns the camera at a time, and whether it is the last one.
    pub(super) fn at(&mut self, now: Instant) -> (Camera, bool) {
        let begun = *self.begun.get_or_insert(now);
        let flown = now.saturating_duration_since(begun);
        let camera = self.path.sample(self.path.times_s()[0] + flown.as_secs_f64());
        (camera, flown >= self.duration())
    }

    fn duration(&self) -> Duration {
        Duration::from_secs_f64(self.path.duration_s())
    }
}

/// Returns the message about a path that begins.
pub(super) fn begins(name: &Path, path: &CameraPath) -> String {
    format!("Flying {} for {:.0} s; a key that flies, a drag or Esc ends it", named(name), path.duration_s())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;

    #[test]
    fn a_path_is_flown_in_its_own_time() {
        let text = "t,x,y,z,yaw,pitch,fov\n2,0,0,100,350,0,50\n6,40,0,100,10,0,50\n";
        let path = CameraPath::parse(Path::new("a.csv"), text.as_bytes()).unwrap();
        assert_eq!(begins(Path::new("a.csv"), &path), "Flying a.csv for 4 s; a key that flies, a drag or Esc ends it");
        let mut flight = PathFlight::new(path);
        let now = Instant::now();
        let at = |flight: &mut PathFlight, s: f64| flight.at(now + Duration::from_secs_f64(s));
        let (first, ends) = at(&mut flight, 0.0);
        assert!(first.position_m.x == 0.0 && !ends);
        let (middle, ends) = at(&mut flight, 2.0);
        assert!((middle.position_m.x - 20.0).abs() < 1e-9 && !ends, "{middle:?}");
        assert!((middle.yaw_deg - 360.0).abs() < 1e-9, "over north, not around: {middle:?}");
        let (last, ends) = at(&mut flight, 4.5);
        assert!(last.position_m.x == 40.0 && ends);
    }

    #[test]
    fn a_path_of_another_world_is_refused() {
        let Some(gpu) = crate::tests::common::gpu() else { return };
        let grid = crate::tests::common::grid_of(150, 130, 30.0, |east_m, _| 500.0 + 0.1 * east_m);
        let store = crate::tests::common::in_memory(&grid);
        let options = crate::tiles::terrain::TerrainOptions::default();
        let terrain = crate::tiles::Terrain::new(&gpu, store, options).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let read_text = |name: &str, text: &str| {
            let path = folder.path().join(name);
            if !text.is_empty() {
                crate::file::atomic::write(&path, text.as_bytes()).unwrap();
            }
            let path = if text.is_empty() { PathBuf::from(name) } else { path };
            let world = World::File("own.tif".into());
            read(Wanted { path, world_name: Some("own.tif".to_owned()), world, ground: terrain.ground_heights() })
        };
        let header = "t,x,y,z,yaw,pitch,fov\n";
        let fits = read_text("fits.csv", &format!("{header}0,100,0,+50,0,0,50\n1,200,0,900,0,0,50\n")).unwrap();
        assert_eq!(fits.warning, None);
        // Heights above the ground are absolute now.
        assert!((fits.path.sample(0.0).position_m.z - 560.0).abs() < 0.5, "{:?}", fits.path.sample(0.0));
        let far = read_text("far.csv", &format!("{header}0,90000,0,+50,0,0,50\n1,91000,0,+50,0,0,50\n")).unwrap_err();
        assert!(far.contains("far.csv:2: its camera at x 90000") && far.contains("another world"), "{far}");
        let below = read_text("below.csv", &format!("{header}0,0,0,20,0,0,50\n1,9,0,20,0,0,50\n")).unwrap_err();
        assert!(below.contains("m below the ground") && below.contains("another world"), "{below}");
        let tour = read_text("tour", "").unwrap_err();
        assert!(tour.starts_with("tour: this built-in path is made for the built-in world"), "{tour}");
        let wrong = read_text("wrong.csv", "t,x,y\n").unwrap_err();
        assert!(wrong.contains("wrong.csv:1: the header is"), "{wrong}");
    }
}
