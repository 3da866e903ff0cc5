//! The records that the passes of strokes hand to each other, and the rules by which segments are joined.

pub use crate::gpu::wgsl::shared::strokes::Chain;
pub(crate) use crate::gpu::wgsl::shared::strokes::ChainRules as ChainRulesUniform;
pub use crate::gpu::wgsl::shared::strokes::Segment;
pub use crate::gpu::wgsl::shared::strokes::SegmentInOrder;
pub use crate::gpu::wgsl::shared::strokes::{StrokeCounts, UNITS_PER_PX};
use bytemuck::{Pod, Zeroable};

/// A place in the order of segments.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Pod, Zeroable)]
pub struct ChainPosition {
    /// The chain that has it.
    pub chain: u32,
    /// From the chain's start to the start of the segment. Modulo 2³².
    pub begin_units: u32,
}

/// Which ends are joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChainRules {
    /// D: ends farther apart are not joined. 1 to [`ChainRules::WIDEST_REACH_UNITS`].
    pub reach_units: u32,
    /// cos² of the widest angle A between one segment's way out and the other's way on, in 1/4096. 0 to 4096.
    pub least_cos_squared: u32,
}

impl ChainRules {
    /// Squares of longer distances do not fit 32 bits when they are scaled.
    pub const WIDEST_REACH_UNITS: u32 = 1023;
    /// How far an end may lie behind the one that it is joined to: 1 px.
    pub const OVERLAP_UNITS: u32 = 16;
    /// Rounds of choosing: an end whose choice preferred another has two more tries.
    pub const ROUNDS: usize = 3;

    /// Rules from lengths and angles that people use; what is out of range is taken as the nearest that is not.
    pub fn new(reach_px: f32, widest_angle_rad: f32) -> Self {
        let cosine = widest_angle_rad.clamp(0.0, std::f32::consts::FRAC_PI_2).cos();
        let widest = Self::WIDEST_REACH_UNITS as f32;
        Self {
            reach_units: (reach_px * UNITS_PER_PX).round().clamp(1.0, widest) as u32,
            least_cos_squared: (cosine * cosine * 4096.0).round() as u32,
        }
    }

    /// The same, with every number in its range.
    pub(crate) fn in_range(self) -> Self {
        Self {
            reach_units: self.reach_units.clamp(1, Self::WIDEST_REACH_UNITS),
            least_cos_squared: self.least_cos_squared.min(4096),
        }
    }
}

impl Default for ChainRules {
    /// 4 px and 60°.
    fn default() -> Self {
        Self { reach_units: 64, least_cos_squared: 1024 }
    }
}
