//! Allowed values of parameters.

use std::fmt::{Display, Formatter, Result};

/// The allowed values of a parameter, in addition to its type.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Range {
    /// Every value of the type.
    Any,
    /// A number from the first to the second, both included.
    Within(f32, f32),
    /// A finite number greater than or equal to this.
    AtLeast(f32),
    /// A finite number greater than this.
    Above(f32),
    /// A power of two from the first to the second, both included.
    PowerOfTwo(u32, u32),
    /// 0, or a number from the first to the second, both included.
    ZeroOr(u32, u32),
    /// Two finite numbers: the first at least this, the second greater than the first.
    Rising(f32),
    /// Two numbers from the first to the second, both included, in ascending order; they may be equal.
    Span(f32, f32),
    /// A list with at least the first and at most the second number of entries.
    Entries(usize, usize),
}

impl Range {
    /// Returns the smallest and the largest allowed number, where they exist.
    pub(crate) fn ends(&self) -> [Option<f32>; 2] {
        match *self {
            Self::Any | Self::Entries(..) => [None, None],
            Self::Within(low, high) | Self::Span(low, high) => [Some(low), Some(high)],
            Self::AtLeast(low) | Self::Above(low) | Self::Rising(low) => [Some(low), None],
            Self::PowerOfTwo(low, high) => [Some(low as f32), Some(high as f32)],
            Self::ZeroOr(_, high) => [Some(0.0), Some(high as f32)],
        }
    }
}

impl Display for Range {
    /// Writes the range in words for a table; nothing for [`Range::Any`].
    fn fmt(&self, formatter: &mut Formatter<'_>) -> Result {
        match self {
            Self::Any => Ok(()),
            Self::Within(low, high) => write!(formatter, "{low} to {high}"),
            Self::AtLeast(low) => write!(formatter, "{low} or more"),
            Self::Above(low) => write!(formatter, "above {low}"),
            Self::PowerOfTwo(low, high) => write!(formatter, "a power of two, {low} to {high}"),
            Self::ZeroOr(low, high) => write!(formatter, "0, or {low} to {high}"),
            Self::Rising(low) => write!(formatter, "two increasing numbers, {low} or more"),
            Self::Span(low, high) => write!(formatter, "two numbers from {low} to {high}"),
            Self::Entries(low, high) => write!(formatter, "{low} to {high} entries"),
        }
    }
}
