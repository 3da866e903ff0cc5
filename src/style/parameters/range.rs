//! What the values of parameters may be.

use std::fmt::{Display, Formatter, Result};

/// What a value may be, beside being of its type.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// Whatever the type holds.
    Any,
    /// From the one to the other.
    Within(f32, f32),
    /// This, or a finite number above it.
    AtLeast(f32),
    /// A finite number above this.
    Above(f32),
    /// A power of two from the one to the other.
    PowerOfTwo(u32, u32),
    /// 0, or from the one to the other.
    ZeroOr(u32, u32),
    /// Two finite numbers, the first at least this and the second above the first.
    Rising(f32),
    /// Two numbers from the one to the other, the second not below the first.
    Span(f32, f32),
    /// A list with so many entries.
    Entries(usize, usize),
}

impl Range {
    /// The least and the largest number, where there are such.
    pub fn ends(&self) -> [Option<f32>; 2] {
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
    /// For tables; nothing for [`Range::Any`].
    fn fmt(&self, formatter: &mut Formatter<'_>) -> Result {
        match self {
            Self::Any => Ok(()),
            Self::Within(low, high) => write!(formatter, "{low} to {high}"),
            Self::AtLeast(low) => write!(formatter, "{low} or more"),
            Self::Above(low) => write!(formatter, "above {low}"),
            Self::PowerOfTwo(low, high) => write!(formatter, "a power of two, {low} to {high}"),
            Self::ZeroOr(low, high) => write!(formatter, "0, or {low} to {high}"),
            Self::Rising(low) => write!(formatter, "two that rise, {low} or more"),
            Self::Span(low, high) => write!(formatter, "two from {low} to {high}"),
            Self::Entries(low, high) => write!(formatter, "{low} to {high} entries"),
        }
    }
}
