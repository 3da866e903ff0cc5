//! Checks that `hachure render` does not overwrite its inputs.

use std::path::{Path, PathBuf};

use anyhow::bail;

use super::{MAX_FRAMES, RenderArgs, map};
use crate::commands::inputs;
use crate::file::pattern::OutputKind;
use crate::scene::Scene;
use crate::scene::path::CameraPath;
use crate::style::Style;

/// Number of frames that are compared with the inputs whether they exist or not.
const LOOKED_AT: u64 = 1000;

/// Checks that no output file is an input. `sheets` are written in addition to the picture.
///
/// # Errors
/// Names the output that is an input.
pub(super) fn check(
    args: &RenderArgs,
    kind: &OutputKind,
    sheets: &[PathBuf],
    scene: &Scene,
    style: &Style,
    flight: Option<&str>,
) -> anyhow::Result<()> {
    let mut inputs = inputs::of(args.world.name(), scene, std::slice::from_ref(style), args.path.as_deref());
    args.like.iter().for_each(|like| inputs.add(like));
    map::side_paths(args, kind).iter().chain(sheets).try_for_each(|written| inputs.check(written))?;
    let OutputKind::Frames(pattern, _) = kind else { return Ok(inputs.check(&args.output)?) };
    let (Some(flight), Some(name)) = (flight, &args.path) else { return Ok(inputs.check(&pattern.path(0))?) };
    let frames = check_flight(args, name, flight)?;
    // Of many frames, only those that exist are looked at: there are fewer files than there may be frames.
    let first = frames.min(LOOKED_AT);
    let existing = (frames > first).then(|| pattern.existing()).unwrap_or_default();
    let rest = existing.into_iter().filter(|frame| (first..frames).contains(frame));
    Ok((0..first).chain(rest).try_for_each(|frame| inputs.check(&pattern.path(frame)))?)
}

/// Checks the camera path before anything is opened, and returns its number of frames, which does not depend on the
/// ground.
///
/// # Errors
/// Fails if the path is invalid or has more than [`MAX_FRAMES`] frames.
pub(super) fn check_flight(args: &RenderArgs, name: &Path, flight: &str) -> anyhow::Result<u64> {
    let path = CameraPath::parse_on_ground(name, flight.as_bytes(), |_, _| 0.0)?;
    let frames = path.frame_count(args.fps());
    if frames > MAX_FRAMES {
        let fps = args.fps();
        bail!("--path: at {fps} frames per second it has {frames} frames, more than {MAX_FRAMES}; lower --fps");
    }
    Ok(frames as u64)
}
