//! The camera of a single picture: given, looking at a place, or chosen for the world.

use super::RenderArgs;
use crate::commands::misuse::Misuse;
use crate::scene::camera::Camera;
use crate::scene::map::MapArea;
use crate::scene::path::CameraPath;
use crate::world::OpenWorld;

/// Returns the width of the picture over its height.
pub(super) fn aspect(args: &RenderArgs) -> f64 {
    let [width, height] = args.size();
    f64::from(width) / f64::from(height)
}

/// Returns the camera of `--camera`, or else the start view; for a path, whose cameras replace it, any.
pub(super) fn start_camera(args: &RenderArgs, world: &OpenWorld) -> Camera {
    match args.path {
        Some(_) => CameraPath::ORIGIN,
        None => args.camera.unwrap_or_else(|| world.start_camera(aspect(args))),
    }
}

/// Checks that `--look-at` is for a single picture in perspective, and that only a map without an area has a place.
pub(super) fn check(args: &RenderArgs) -> Result<(), Misuse> {
    let wrong = |option: &str, why: &str| Err(Misuse(format!("{option}: {why}")));
    match (args.look.look_at, args.map_place.at) {
        (Some(_), _) if args.path.is_some() => wrong("--look-at", "cannot be combined with --path, which has cameras"),
        (Some(_), _) if args.map.is_some() => {
            wrong("--look-at", "cannot be combined with --map; use --map --at LAT,LON")
        }
        (_, Some(_)) if matches!(args.map, Some(MapArea::Around { .. } | MapArea::At { .. })) => {
            let with = if args.map_scale.is_some() { "--map-scale N" } else { "--map-width METRES" };
            wrong("--at", &format!("cannot be combined with --map=EAST,NORTH; use --map --at LAT,LON {with}"))
        }
        _ => Ok(()),
    }
}
