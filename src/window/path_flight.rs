//! Reads a camera path for the window, and the clock by which it is flown.
//!
//! The file is read in the background, because heights above the ground may have to be read from disk; there it is also
//! compared with the world.

use std::path::{Path, PathBuf};
use std::time::Instant;

use super::background::{Background, NoResult};
use crate::file::message::named;
use crate::scene::World;
use crate::scene::embedded;
use crate::scene::path::CameraPath;
use crate::studio::camera_path::PathDocument;
use crate::tiles::terrain::GroundHeights;
use crate::world::path_fit;

/// The path to read, and the world in which it is flown.
pub(super) struct PathToRead {
    /// The file, or the name of a built-in path.
    pub path: PathBuf,
    /// The world's name as it was given; `None` is the built-in world.
    pub world_name: Option<String>,
    /// The world in which the path is flown.
    pub world: World,
    /// The ground of that world, for heights above it.
    pub ground: GroundHeights,
}

/// A path that suits the world, ready to be flown.
#[derive(Debug)]
pub(super) struct Read {
    /// The path as it was given.
    pub name: PathBuf,
    /// The path, open for editing.
    pub document: PathDocument,
    /// A warning for the user.
    pub warning: Option<String>,
}

/// A path that is being read.
pub(super) struct Reading(Background<Result<Read, String>>, PathBuf);

impl Reading {
    /// Begins to read a path, and calls `wake` when it is read.
    pub(super) fn start(to_read: PathToRead, wake: impl Fn() + Send + 'static) -> Self {
        let path = to_read.path.clone();
        Self(Background::start("camera path", move || read(to_read), wake), path)
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
pub(super) fn read(to_read: PathToRead) -> Result<Read, String> {
    let PathToRead { path: name, world_name, world, ground } = to_read;
    path_fit::check_name(&name, world_name.as_deref(), &world).map_err(|error| {
        // In a window there is no option `--path` to name.
        error.to_string().trim_start_matches("--path ").to_owned()
    })?;
    let text = CameraPath::read_text(&name).map_err(|error| error.to_string())?;
    let warning = path_fit::check_places(&name, &text, &ground).map_err(|error| error.to_string())?;
    let file = embedded::path(&name).is_none().then(|| name.clone());
    let document = PathDocument::of_text(&name.to_string_lossy(), file, &text, |x, y| ground.height_m(x, y));
    Ok(Read { name, document: document.map_err(|error| error.to_string())?, warning })
}

/// Reads the heights of the ground at places (east and north in metres) in the background, because the land has changed.
pub(super) struct Grounds(Background<Vec<([f64; 2], f64)>>);

impl Grounds {
    /// Begins to read, and calls `wake` at the end.
    pub(super) fn start(places: Vec<[f64; 2]>, ground: GroundHeights, wake: impl Fn() + Send + 'static) -> Self {
        let work = move || places.into_iter().map(|[x, y]| ([x, y], ground.height_m(x, y))).collect();
        Self(Background::start("camera path", work, wake))
    }

    /// Takes the heights when they are read; none if they could not be.
    pub(super) fn take(&self) -> Option<Vec<([f64; 2], f64)>> {
        Some(self.0.take()?.unwrap_or_default())
    }
}

/// The clock of a path: a playhead that stands, or moves in the path's own time.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Player {
    /// Time on the path's own clock.
    pub playhead_s: f64,
    /// Whether it begins again after the last key.
    pub loops: bool,
    is_playing: bool,
    /// The time of the first frame and where the playhead was then, while it plays.
    began: Option<(Instant, f64)>,
}

impl Player {
    /// Returns whether the playhead moves.
    pub(super) fn is_playing(&self) -> bool {
        self.is_playing
    }

    /// Moves the playhead from the next frame on. At the end, it begins again. `span_s` are the times of the first and the
    /// last key.
    pub(super) fn play(&mut self, [first_s, last_s]: [f64; 2]) {
        if self.playhead_s >= last_s || self.playhead_s < first_s {
            self.playhead_s = first_s;
        }
        (self.is_playing, self.began) = (first_s < last_s, None);
    }

    /// Stops the playhead where it is. Returns whether it moved.
    pub(super) fn pause(&mut self) -> bool {
        self.began = None;
        std::mem::take(&mut self.is_playing)
    }

    /// Stops the playhead, and returns it to 0.
    pub(super) fn rewind(&mut self) {
        *self = Self { loops: self.loops, ..Self::default() };
    }

    /// Moves the playhead by the time that has passed, if it plays. Returns whether it plays, or has just ended.
    pub(super) fn advance(&mut self, now: Instant, [first_s, last_s]: [f64; 2]) -> bool {
        if !self.is_playing {
            return false;
        }
        let (began, from_s) = *self.began.get_or_insert((now, self.playhead_s));
        self.playhead_s = from_s + now.saturating_duration_since(began).as_secs_f64();
        let duration_s = last_s - first_s;
        if self.playhead_s < last_s {
            return true;
        }
        if self.loops && duration_s > 0.0 {
            self.playhead_s = first_s + (self.playhead_s - first_s).rem_euclid(duration_s);
            self.began = Some((now, self.playhead_s));
        } else {
            self.playhead_s = last_s;
            self.pause();
        }
        true
    }
}

/// Returns the message about a path that begins.
pub(super) fn begins(name: &Path, path: &CameraPath) -> String {
    format!("Flying {} for {:.0} s; a key that flies, a drag or Esc pauses it", named(name), path.duration_s())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use std::time::Duration;

    use super::*;

    #[test]
    fn a_path_is_flown_in_its_own_time() {
        let text = "t,x,y,z,yaw,pitch,fov\n2,0,0,100,350,0,50\n6,40,0,100,10,0,50\n";
        let document = PathDocument::of_text("a.csv", None, text, |_, _| 0.0).unwrap();
        let (path, span_s) = (document.curve().unwrap(), document.span_s());
        assert_eq!(begins(Path::new("a.csv"), path), "Flying a.csv for 4 s; a key that flies, a drag or Esc pauses it");
        let mut player = Player::default();
        let now = Instant::now();
        assert!(!player.advance(now, span_s), "it stands");
        player.play(span_s);
        // A frame each tenth of a second, as a film with ten frames a second has them.
        for (frame, camera) in path.frames(10.0).enumerate() {
            assert!(player.advance(now + Duration::from_millis(100 * frame as u64), span_s));
            let seen = path.sample(player.playhead_s);
            assert!((seen.position_m - camera.position_m).length() < 1e-6, "{frame}: {seen:?} instead of {camera:?}");
            assert!((seen.yaw_deg - camera.yaw_deg).abs() < 1e-6, "over north, not around: {seen:?}");
        }
        assert!(!player.is_playing() && player.playhead_s == 6.0, "{player:?}");
        player.loops = true;
        player.play(span_s);
        assert_eq!(player.playhead_s, 2.0, "from the beginning");
        for ms in [0, 3900, 4500] {
            assert!(player.advance(now + Duration::from_millis(ms), span_s));
        }
        assert!(player.is_playing() && (player.playhead_s - 2.5).abs() < 1e-9, "{player:?}");
        assert!(player.pause() && !player.pause() && !player.advance(now + Duration::from_secs(9), span_s));
        player.play([3.0, 3.0]);
        assert!(!player.is_playing(), "one key does not move");
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
            read(PathToRead { path, world_name: Some("own.tif".to_owned()), world, ground: terrain.ground_heights() })
        };
        let header = "t,x,y,z,yaw,pitch,fov\n";
        let fits = read_text("fits.csv", &format!("{header}0,100,0,+50,0,0,50\n1,200,0,900,0,0,50\n")).unwrap();
        assert_eq!(fits.warning, None);
        // Heights above the ground are absolute now.
        let first = fits.document.curve().unwrap().sample(0.0);
        assert!((first.position_m.z - 560.0).abs() < 0.5, "{first:?}");
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
