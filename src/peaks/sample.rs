//! The order of samples by height, in which no two samples are equal.

/// A sample, ordered by its height. Of two samples of equal height, the one that comes first in row order counts as the
/// higher one. So a plateau has a single highest sample, and every saddle is a single sample, whatever the tiles are.
///
/// The upper 64 bits hold the [`ordered`] height, the lower 64 bits the complement of the index in row order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Sample(u128);

impl Sample {
    /// Stands for no sample, and is lower than every sample.
    pub(super) const NONE: Self = Self(0);

    /// Returns the sample with an [`ordered`] height at an index in row order. Returns [`Self::NONE`] for no data.
    pub(super) fn new(height: u32, index: u64) -> Self {
        if height == NO_DATA { Self::NONE } else { Self(u128::from(height) << 64 | u128::from(!index)) }
    }

    /// Returns the [`ordered`] height.
    pub(super) fn height(self) -> u32 {
        (self.0 >> 64) as u32
    }

    /// Returns the height in metres.
    pub(super) fn height_m(self) -> f32 {
        metres(self.height())
    }

    /// Returns the column and the row on a DEM with this number of columns.
    pub(super) fn place(self, columns: usize) -> [usize; 2] {
        let index = !(self.0 as u64);
        [(index % columns as u64) as usize, (index / columns as u64) as usize]
    }
}

/// The [`ordered`] height of a sample without data. It is lower than that of every finite height.
pub(super) const NO_DATA: u32 = 0;

/// Returns a number that is ordered as the heights are; [`NO_DATA`] for NaN and infinities. −0 and +0 are equal.
pub(super) fn ordered(height_m: f32) -> u32 {
    if !height_m.is_finite() {
        return NO_DATA;
    }
    // −0 + 0 is +0.
    let bits = (height_m + 0.0).to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}

/// Returns the height in metres of an [`ordered`] height; NaN for [`NO_DATA`].
pub(super) fn metres(height: u32) -> f32 {
    f32::from_bits(if height >> 31 == 1 { height & !(1 << 31) } else { !height })
}
