//! Checks that `hachure render` overwrites neither its inputs nor files of the user that nobody named.

use std::path::Path;

use anyhow::bail;

use super::{MAX_FRAMES, RenderArgs, frames, map, sheets};
use crate::commands::inputs;
use crate::file::pattern::OutputKind;
use crate::file::{FileError, unnamed};
use crate::scene::Scene;
use crate::scene::path::CameraPath;
use crate::style::Style;
use crate::vector::sheets::Sheets;

/// Number of frames that are compared with the inputs whether they exist or not.
const LOOKED_AT: u64 = 1000;

/// Checks that no output file is an input, and that sheets and frames replace only those that hachure drew. The files
/// of a map are checked when their content is known ([`map::PlacedMap::new`]).
///
/// # Errors
/// Names the output that would replace another file.
pub(super) fn check(
    args: &RenderArgs,
    kind: &OutputKind,
    sheets: Option<&Sheets>,
    scene: &Scene,
    style: &Style,
    flight: Option<&str>,
) -> anyhow::Result<()> {
    let mut inputs = inputs::of(args.world.name(), scene, std::slice::from_ref(style), args.path.as_deref());
    args.like.iter().for_each(|like| inputs.add(like));
    map::side_paths(args, kind).iter().try_for_each(|written| inputs.check(written))?;
    for (path, name) in sheets::paths(args, sheets).iter().zip(sheets::names(sheets)) {
        inputs.check(path)?;
        unnamed::check(path, args.overwrite, |path| unnamed::is_sheet(path, &name))?;
    }
    let OutputKind::Frames(pattern, _) = kind else { return Ok(inputs.check(&args.output)?) };
    let check = |path: &Path| -> Result<(), FileError> {
        inputs.check(path)?;
        unnamed::check(path, args.overwrite, unnamed::is_drawing)
    };
    let (Some(flight), Some(name)) = (flight, &args.path) else { return Ok(check(&pattern.path(0))?) };
    let written = frames::written(args, check_flight(args, name, flight)? as usize)?;
    // Of many frames, only those that exist are looked at: there are fewer files than there may be frames.
    let first = written.end.min(written.start + LOOKED_AT);
    let existing = if written.end > first { pattern.existing() } else { Default::default() };
    let rest = existing.into_iter().filter(|frame| (first..written.end).contains(frame));
    Ok((written.start..first).chain(rest).try_for_each(|frame| check(&pattern.path(frame)))?)
}

/// Checks the camera path before anything is opened, and returns its number of frames, which does not depend on the
/// ground.
///
/// # Errors
/// Fails if the path is invalid or has more than [`MAX_FRAMES`] frames.
pub(super) fn check_flight(args: &RenderArgs, name: &Path, flight: &str) -> anyhow::Result<u64> {
    let path = CameraPath::parse_on_ground(name, flight.as_bytes(), |_, _| 0.0)?;
    let frames = path.frame_count(args.fps().per_second());
    if frames > MAX_FRAMES {
        let fps = args.fps();
        bail!("--path: at {fps} frames per second it has {frames} frames, more than {MAX_FRAMES}; lower --fps");
    }
    Ok(frames as u64)
}
