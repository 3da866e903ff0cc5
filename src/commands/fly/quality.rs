//! `fly --quality` and `--budget`, in a window and in a headset.

use super::FlyArgs;
use crate::commands::quality_args::Use;
use crate::ladder::Quality;
use crate::measure::quality::Front;

/// Returns the quality at the start of a flight, and the front of `--front`.
///
/// # Errors
/// Those of [`QualityArgs::setting`](crate::commands::quality_args::QualityArgs::setting).
pub(super) fn at_start(args: &FlyArgs, style: &str) -> anyhow::Result<(Quality, Option<Front>)> {
    let level = args.quality.quality.map(Quality::Level);
    let Some(quality) = args.budget.map(Quality::Budget).or(level) else {
        args.quality.setting(style, Use::Frames)?;
        return Ok((Quality::AsSet, None));
    };
    // A budget needs no front: without one, the resolution alone changes.
    let is_needed = level.is_some() || args.quality.front.is_some();
    let front = if is_needed { Some(args.quality.front_of(style)?.0) } else { None };
    Ok((quality, front))
}
