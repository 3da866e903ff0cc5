//! Layout of labels, in pixels: which names are drawn, and where.
//!
//! ```text
//! panorama: names of peaks in rows above the land, with leaders ─▶ chain: dynamic programme ─▶ settle: positions
//! slanted:  names of peaks in one row at 45°
//! points:   names of points on a map ─▶ grid: which boxes overlap
//! flight:   the layouts of successive frames ─▶ steady: which label may change, and its opacity
//! ```
//!
//! Nothing here draws or measures text. The caller gives the sizes of labels and receives their positions. Numbers that
//! are not finite never cause a panic: a label that has one is left out.

pub(crate) mod flight;
mod chain;
mod grid;
mod improve;
#[cfg_attr(
    not(test),
    expect(
        dead_code,
        reason = "names on moving maps, and slanted names, are laid out and tested; nothing draws them yet"
    )
)]
pub(crate) mod map_flight;
pub(crate) mod panorama;
pub(crate) mod points;
mod settle;
#[cfg_attr(
    not(test),
    expect(
        dead_code,
        reason = "names on moving maps, and slanted names, are laid out and tested; nothing draws them yet"
    )
)]
pub(crate) mod slanted;
pub(crate) mod steady;

#[cfg(test)]
pub(crate) mod check;
#[cfg(test)]
mod exact;
#[cfg(test)]
mod instances;
#[cfg(test)]
mod points_tests;
#[cfg(test)]
mod flight_tests;
#[cfg(test)]
mod tests;

/// The part by which the weight of a label counts more if it remains where it is.
const KEPT_BONUS: f64 = 0.25;

/// Additional gap of the layouts of a flight, in heights of labels, so that labels leave before they overlap.
const AHEAD: f64 = 0.3;

/// What the layout of the last frame requires of a label. A slot is a row of a panorama, or a side of a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Hold {
    /// The label may be placed anywhere, or left out.
    #[default]
    Free,
    /// The label is in this slot, and remains there unless something better needs the space.
    Kept(usize),
    /// The label must remain in this slot. It is left out only if another label must remain in the same space.
    Fixed(usize),
    /// The label must not be placed.
    Out,
}

impl Hold {
    /// Returns what a label is worth in a slot; negative infinity if it may not be there. `bond` is more than all other
    /// labels are worth together.
    fn gain(self, slot: usize, weight: f64, bond: f64) -> f64 {
        match self {
            Self::Kept(kept) if kept == slot => weight * (1.0 + KEPT_BONUS),
            Self::Free | Self::Kept(_) => weight,
            Self::Fixed(fixed) if fixed == slot => weight + bond,
            Self::Fixed(_) | Self::Out => f64::NEG_INFINITY,
        }
    }
}

/// A box with sides along the axes, in pixels; y goes down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rect {
    /// Left and upper side.
    pub from_px: [f64; 2],
    /// Right and lower side.
    pub to_px: [f64; 2],
}

impl Rect {
    /// Returns whether two boxes have a common area after this one has grown by a gap on all sides.
    pub(crate) fn overlaps(&self, other: &Self, gap_px: f64) -> bool {
        (0..2).all(|axis| {
            self.from_px[axis] - gap_px < other.to_px[axis] && other.from_px[axis] < self.to_px[axis] + gap_px
        })
    }

    /// Returns whether all numbers are finite, and no side is negative.
    fn is_valid(&self) -> bool {
        (0..2).all(|axis| {
            let [from, to] = [self.from_px[axis], self.to_px[axis]];
            from.is_finite() && to.is_finite() && from <= to
        })
    }
}

/// Returns a gap, or 0 if it is not a length.
fn usual(gap_px: f64) -> f64 {
    if gap_px.is_finite() { gap_px.max(0.0) } else { 0.0 }
}

/// A sequence of numbers that look random and are the same in each run: SplitMix64 (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    /// Returns the next number.
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^ (bits >> 31)
    }

    /// Returns a number from 0 to 1, without 1.
    fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Returns an index below `count`, which must not be 0.
    fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count.saturating_sub(1))
    }
}
