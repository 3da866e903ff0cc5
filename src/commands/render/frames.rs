//! `render --frames A..B`: draws a part of a film, so that many machines can draw one film.
//!
//! A film has a memory: strokes carry over from frame to frame, and temporal anti-aliasing is a mean of frames. A part
//! must begin with the memory that the whole film has there, or the parts would not join. So the frames before it are
//! drawn first and not written. Why so many: `docs/decisions/parts-of-films.md`.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use super::{Job, RenderArgs};
use crate::commands::misuse::Misuse;
use crate::file::gif;
use crate::file::message::named;
use crate::file::pattern::OutputKind;
use crate::frame::Antialias;
use crate::picture::PartRule;
use crate::style::Style;

/// Frames before a part after which the mean of temporal anti-aliasing no longer depends on where it began.
const MEAN_FRAMES: u64 = 64;

/// Some frames of a film, by numbers from 0: from the first up to the one before the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FrameRange {
    first: u64,
    /// The first frame that no longer belongs to it; `None` is the end of the film.
    end: Option<u64>,
}

impl FromStr for FrameRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| match text.trim() {
            "" => Some(None),
            text => text.parse::<u64>().ok().map(Some),
        };
        let parts = text.split_once("..").and_then(|(first, end)| Some((number(first)?, number(end)?)));
        parts
            .map(|(first, end)| Self { first: first.unwrap_or(0), end })
            .filter(|range| range.end.is_none_or(|end| range.first < end))
            .ok_or_else(|| "it must be like 100..200: from frame 100 up to frame 199, counted from 0".to_owned())
    }
}

impl fmt::Display for FrameRange {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}..{}", self.first, self.end.map_or_else(String::new, |end| end.to_string()))
    }
}

impl FrameRange {
    /// Returns the numbers of the frames in a film of `count` frames.
    ///
    /// # Errors
    /// Fails if the film ends before the first of them.
    fn of(self, count: u64) -> Result<Range<u64>, Misuse> {
        if self.first >= count {
            return Err(Misuse(format!(
                "--frames {self}: the film has {count} frames, with the numbers 0 to {}",
                count - 1
            )));
        }
        Ok(self.first..self.end.unwrap_or(count).min(count))
    }
}

/// Checks that `--frames`, `--warm-up` and `--fps` are given for a film.
///
/// # Errors
/// Returns the misuse, in one line.
pub(super) fn check(args: &RenderArgs, kind: &OutputKind) -> Result<(), Misuse> {
    let given =
        [("--frames", args.frames.is_some()), ("--warm-up", args.warm_up.is_some()), ("--fps", args.fps.is_some())];
    let is_film = matches!(kind, OutputKind::Frames(..) | OutputKind::Mp4 | OutputKind::Gif);
    match given.into_iter().find(|(_, is_given)| *is_given) {
        Some((option, _)) if !is_film => Err(Misuse(format!(
            "{option}: applies to the frames of a --path, and {} is one picture",
            named(&args.output)
        ))),
        _ if matches!(kind, OutputKind::Gif) && args.fps().per_second() > gif::LARGEST_RATE => {
            Err(Misuse(format!("--fps {}: a GIF shows at most {} frames per second", args.fps(), gif::LARGEST_RATE)))
        }
        _ if args.warm_up.is_some() && args.frames.is_none() => {
            Err(Misuse("--warm-up: requires --frames, which is not given".to_owned()))
        }
        _ => Ok(()),
    }
}

/// Returns the numbers of the frames to write, of a film of `count` frames.
///
/// # Errors
/// Returns the misuse, in one line.
pub(super) fn written(args: &RenderArgs, count: usize) -> Result<Range<u64>, Misuse> {
    let count = count as u64;
    args.frames.map_or(Ok(0..count), |frames| frames.of(count))
}

/// How the frames before a part are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct WarmUp {
    /// The first frame that is drawn.
    pub(super) first: u64,
    /// Whether only strokes are needed of them.
    pub(super) only_strokes: bool,
    /// The first frame whose labels are laid out, at or before `first`.
    pub(super) first_of_labels: u64,
}

impl WarmUp {
    /// Plans the frames before the part that begins with frame `first`.
    pub(super) fn new(args: &RenderArgs, kind: &OutputKind, style: &Style, first: u64) -> Self {
        // Pictures of several parts and pictures of several samples have no memory.
        let remembers = PartRule::default().is_whole(args.size());
        let carries = remembers && style.strokes().is_some_and(|strokes| strokes.carry);
        let is_mean = remembers && args.antialias() == Antialias::Temporal;
        let frames = match args.warm_up {
            Some(frames) => frames,
            // A stroke may be as old as the film.
            None if carries => first,
            None if is_mean => MEAN_FRAMES,
            None => 0,
        };
        // A label may be as old as the film.
        let of_labels = if !args.has_labels() { 0 } else { args.warm_up.unwrap_or(first) };
        Self {
            first: first.saturating_sub(frames),
            only_strokes: carries && !is_mean && !kind.is_drawing(),
            first_of_labels: first.saturating_sub(frames.max(of_labels)),
        }
    }
}

impl Job<'_> {
    /// Warns if the film ends before the part that `--frames` selects.
    pub(super) fn warn_of_short_part(&self, written: &Range<u64>) {
        if let Some(end) = self.args.frames.and_then(|frames| frames.end).filter(|end| *end > written.end) {
            tracing::warn!("{}", short_part(written, end));
        }
    }
}

/// Returns the warning that the film ends with the frames `written`, and --frames before `end`.
fn short_part(written: &Range<u64>, end: u64) -> String {
    let (Range { start, end: count }, last) = (written, end - 1);
    let missing = if *count == last { format!("frame {last} is") } else { format!("frames {count} to {last} are") };
    format!("--frames {start}..{end}: the film ends with frame {}; {missing} not written", count - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_read_as_they_are_written() {
        for (text, part) in [("3..7", 3..7), ("..4", 0..4), ("8..", 8..10), ("8..99", 8..10), ("..", 0..10)] {
            assert_eq!(text.parse::<FrameRange>().and_then(|range| range.of(10).map_err(|error| error.0)), Ok(part));
        }
        assert_eq!("3..7".parse::<FrameRange>().map(|range| range.to_string()), Ok("3..7".to_owned()));
        for text in ["", "5", "5..5", "7..3", "-1..3", "a..b", "1..2..3", "1.5..3"] {
            assert!(text.parse::<FrameRange>().is_err(), "{text}");
        }
        let warning = "--frames 899..1005: the film ends with frame 900; frames 901 to 1004 are not written";
        assert_eq!(short_part(&(899..901), 1005), warning);
        assert!(short_part(&(0..9), 10).ends_with("ends with frame 8; frame 9 is not written"));
        assert!("10..20".parse::<FrameRange>().is_ok_and(|range| range.of(10).is_err()));
    }
}
