//! Checks that `hachure render` does not overwrite its inputs.

use std::path::PathBuf;

use super::{MAX_FRAMES, RenderArgs, map};
use crate::commands::inputs;
use crate::file::pattern::OutputKind;
use crate::scene::Scene;
use crate::scene::path::CameraPath;
use crate::style::Style;

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
    // The number of frames does not depend on the ground.
    let path = match (flight, &args.path) {
        (Some(flight), Some(name)) => CameraPath::parse_on_ground(name, flight.as_bytes(), |_, _| 0.0)?,
        _ => return Ok(inputs.check(&pattern.path(0))?),
    };
    // An invalid frame rate is refused before the first frame is drawn.
    let frames = path.frame_count(args.fps().clamp(0.0, 1000.0)).min(MAX_FRAMES) as u64;
    Ok((0..frames).try_for_each(|frame| inputs.check(&pattern.path(frame)))?)
}
