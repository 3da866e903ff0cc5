//! `fly --quality` and `--budget`, in a window and in a headset.

use super::FlyArgs;
use crate::commands::quality_args::Use;
use crate::ladder::Quality;
use crate::measure::quality::Front;

/// Returns the quality at the start of a flight, and the fronts of `--front`.
///
/// # Errors
/// The errors of [`QualityArgs::setting`](crate::commands::quality_args::QualityArgs::setting).
pub(super) fn at_start(args: &FlyArgs, style: &str) -> anyhow::Result<(Quality, Vec<Front>)> {
    let level = args.quality.quality.map(Quality::Level);
    let Some(quality) = args.budget.map(Quality::Budget).or(level) else {
        args.quality.setting(style, Use::Frames)?;
        return Ok((Quality::AsSet, Vec::new()));
    };
    // A budget needs no front: without one, the resolution alone changes.
    if level.is_some() || !args.quality.fronts.is_empty() {
        args.quality.front_of(style)?;
    }
    let fronts = args.quality.given()?;
    Ok((quality, fronts.into_iter().map(|(front, _)| front).collect()))
}
