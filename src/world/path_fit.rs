//! Checks that a camera path suits the world along which it is flown.

use std::path::Path;
use std::sync::Arc;

use glam::DVec2;

use crate::file::message::named;
use crate::pyramid::PyramidError;
use crate::scene::World;
use crate::scene::embedded;
use crate::scene::path::{CameraPath, Key, PathError};
use crate::tiles::terrain::GroundHeights;

/// Why a path cannot be flown over a world. The message is one line.
#[derive(Debug, thiserror::Error)]
pub(crate) enum PathFitError {
    /// The path is made for another world.
    #[error("{0}")]
    Other(String),
    /// The file is not a valid path.
    #[error(transparent)]
    Path(#[from] PathError),
    /// The ground below the cameras cannot be read.
    #[error("cannot read ground heights: {0}")]
    Ground(#[source] Arc<PyramidError>),
}

/// A camera may be this part of the longer side of the land away from it.
const BESIDE_PART: f64 = 0.5;
/// Depth below the ground from which on a camera is underground, in metres: rounded coordinates are not.
const DEEP_M: f64 = 1.0;

/// How a camera of a path does not suit a world.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Misfit {
    /// Distance from the land, in metres.
    Outside(f64),
    /// Depth below the ground, in metres.
    Below(f64),
}

/// Refuses a built-in path that is made for another world, before that is opened.
///
/// # Errors
/// Names the world for which the path is made.
pub(crate) fn check_name(path: &Path, world_name: Option<&str>, world: &World) -> Result<(), PathFitError> {
    let Some(made_for) = embedded::path_world(path) else { return Ok(()) };
    if made_for.is(world) {
        return Ok(());
    }
    let other = world_name.map_or_else(|| "the built-in world".to_owned(), named);
    let other = match world.seed() {
        Some(seed) if seed != 1 => format!("{other} with seed {seed}"),
        _ => other,
    };
    Err(PathFitError::Other(format!(
        "--path {}: this built-in path is made for {}, not for {other}; a path for {other} is a CSV file with the header \
         t,x,y,z,yaw,pitch,fov, in metres from its centre, with z as +h above the ground",
        path.display(),
        made_for.words
    )))
}

/// Refuses a path if more than half of its cameras are outside of the world or below the ground. Returns a warning if
/// some are.
///
/// # Errors
/// Names the first such row of the file.
pub(crate) fn check_places(path: &Path, text: &str, ground: &GroundHeights) -> Result<Option<String>, PathFitError> {
    let [low_m, high_m] = ground.corners_m();
    let keys = CameraPath::keys(path, text.as_bytes())?;
    let misfits: Vec<Option<Misfit>> =
        keys.iter().map(|key| misfit(key, [low_m, high_m], |x, y| ground.height_m(x, y))).collect();
    ground.failure().map_or(Ok(()), |failure| Err(PathFitError::Ground(failure)))?;
    let wrong = misfits.iter().flatten().count();
    let Some((Key { line, camera, .. }, misfit)) =
        keys.iter().zip(&misfits).find_map(|(key, misfit)| Some((key, (*misfit)?)))
    else {
        return Ok(None);
    };
    let at = format!("x {:.0}, y {:.0}", camera.position_m.x, camera.position_m.y);
    let what = match misfit {
        Misfit::Outside(away_m) => format!("its camera at {at} is {away_m:.0} m outside of the world"),
        Misfit::Below(depth_m) => format!("its camera at {at} is {depth_m:.0} m below the ground"),
    };
    let place = format!("{}:{line}", named(path));
    let all = keys.len();
    let extent = format!(
        "the world is from {:.0} to {:.0} m east and {:.0} to {:.0} m north",
        low_m.x, high_m.x, low_m.y, high_m.y
    );
    if 2 * wrong > all {
        return Err(PathFitError::Other(format!(
            "{place}: {what}, as are {wrong} of {all} rows outside or below; the path is made for another world: {extent}"
        )));
    }
    let is_outside = misfits.iter().flatten().any(|misfit| matches!(misfit, Misfit::Outside(_)));
    Ok(is_outside.then(|| format!("{place}: {what}; {wrong} of {all} rows are outside or below: {extent}")))
}

/// Returns how a camera does not suit the land between two corners, whose ground is `ground_m(x, y)` high.
fn misfit(key: &Key, [low_m, high_m]: [DVec2; 2], ground_m: impl Fn(f64, f64) -> f64) -> Option<Misfit> {
    let at_m = key.camera.position_m;
    let flat_m = at_m.truncate();
    let away_m = flat_m.distance(flat_m.clamp(low_m, high_m));
    if away_m > BESIDE_PART * (high_m - low_m).max_element() {
        return Some(Misfit::Outside(away_m));
    }
    if away_m > 0.0 || key.camera.height_above_ground {
        return None;
    }
    let depth_m = ground_m(at_m.x, at_m.y) - at_m.z;
    (depth_m > DEEP_M).then_some(Misfit::Below(depth_m))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;

    #[test]
    fn cameras_outside_and_below_do_not_suit() {
        let land = [DVec2::splat(-500.0), DVec2::splat(500.0)];
        let of = |camera: &str| {
            misfit(&Key { line: 2, time_s: 0.0, camera: camera.parse().unwrap(), ease: 0.0 }, land, |x, _| 100.0 + x)
        };
        assert_eq!(of("0,0,150,0,0,50"), None);
        assert_eq!(of("0,0,99.5,0,0,50"), None, "rounded");
        assert_eq!(of("0,0,+2,0,0,50"), None);
        assert_eq!(of("200,0,150,0,0,50"), Some(Misfit::Below(150.0)));
        assert_eq!(of("900,0,10,270,0,50"), None, "a view from beside the land");
        assert_eq!(of("0,5500,+200,0,0,50"), Some(Misfit::Outside(5000.0)));
    }

    #[test]
    fn built_in_paths_have_their_worlds() {
        let check = |path: &str, name: &str, world: World| check_name(Path::new(path), Some(name), &world);
        let own = World::File("own.tif".into());
        let error = check("tour", "own.tif", own.clone()).unwrap_err().to_string();
        assert!(error.contains("--path tour: this built-in path is made for the built-in world"), "{error}");
        assert!(error.contains("not for own.tif"), "{error}");
        let error = check("valley", "own.tif", own.clone()).unwrap_err().to_string();
        assert!(error.contains("made for the built-in scene continent"), "{error}");
        assert!(check("tour", "forest", World::Procedural { seed: 1 }).is_ok());
        let error = check_name(Path::new("tour"), None, &World::Procedural { seed: 2 }).unwrap_err().to_string();
        assert!(error.contains("not for the built-in world with seed 2;"), "{error}");
        assert!(check("tour.csv", "own.tif", own).is_ok());
        let continent = World::Continent { seed: 1, size_samples: 2048, spacing_m: 10.0 };
        assert!(check("valley", "continent_small", continent).is_ok());
    }
}
