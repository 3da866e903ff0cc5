//! The records that the stroke passes share, and the rules by which segments are joined.

pub(crate) use crate::gpu::wgsl::shared::strokes::Chain;
pub(crate) use crate::gpu::wgsl::shared::strokes::ChainRules as ChainRulesUniform;
pub(crate) use crate::gpu::wgsl::shared::strokes::Segment;
pub(crate) use crate::gpu::wgsl::shared::strokes::SegmentInOrder;
pub(crate) use crate::gpu::wgsl::shared::strokes::{StrokeCounts, UNITS_PER_PX};
use bytemuck::{Pod, Zeroable};

/// A position in the order of segments.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Pod, Zeroable)]
pub(crate) struct ChainPosition {
    /// Number of the chain.
    pub chain: u32,
    /// Arc length from the chain's start to the start of the segment, in 1/16 px, modulo 2³².
    pub begin_units: u32,
}

/// The rules by which ends are joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ChainRules {
    /// D: ends farther apart are not joined. 1 to [`ChainRules::WIDEST_REACH_UNITS`], in 1/16 px.
    pub reach_units: u32,
    /// cos² of the widest angle A between one segment's outward direction and the other's onward direction, in 1/4096.
    /// 0 to 4096.
    pub min_cos_squared: u32,
}

impl ChainRules {
    /// The widest reach: squares of longer distances do not fit 32 bits when they are scaled.
    pub(crate) const WIDEST_REACH_UNITS: u32 = 1023;
    /// Largest distance of an end behind the one that it is joined to: 1 px.
    pub(crate) const OVERLAP_UNITS: u32 = 16;
    /// Rounds of choosing: an end whose choice preferred another one has two more tries.
    pub(crate) const ROUNDS: usize = 3;

    /// Creates rules from a length in pixels and an angle in radians; values out of range are clamped.
    pub(crate) fn new(reach_px: f32, widest_angle_rad: f32) -> Self {
        let cosine = widest_angle_rad.clamp(0.0, std::f32::consts::FRAC_PI_2).cos();
        let widest = Self::WIDEST_REACH_UNITS as f32;
        Self {
            reach_units: (reach_px * UNITS_PER_PX).round().clamp(1.0, widest) as u32,
            min_cos_squared: (cosine * cosine * 4096.0).round() as u32,
        }
    }

    /// Returns the rules with every number clamped to its range.
    pub(crate) fn in_range(self) -> Self {
        Self {
            reach_units: self.reach_units.clamp(1, Self::WIDEST_REACH_UNITS),
            min_cos_squared: self.min_cos_squared.min(4096),
        }
    }
}

impl Default for ChainRules {
    /// Returns a reach of 4 px and an angle of 60°.
    fn default() -> Self {
        Self { reach_units: 64, min_cos_squared: 1024 }
    }
}
