//! The records that the passes of strokes hand to each other, and the rules by which pieces are joined.

use bytemuck::{Pod, Zeroable};

use crate::gpu::shared::describe;

/// Positions and lengths are whole numbers of 1/16 px: the GPU and its twin then agree to the bit.
pub const UNITS_PER_PX: f32 = 16.0;

/// A straight piece of a line.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Piece {
    /// One end, in 1/16 px of the full picture. It may lie outside of it; farther than 2²¹ it is taken as there.
    pub a: [i32; 2],
    /// The other end.
    pub b: [i32; 2],
    /// Distance along the view axis, at a and b. Carried along: it does not decide what is joined.
    pub depths_m: [f32; 2],
    /// Which edge of the picture it comes from.
    pub edge: u32,
    /// Lasts across frames; several pieces may share it.
    pub key: u32,
}

describe!(Piece as "Piece" in "lines/strokes/chain_bin": a, b, depths_m, edge, key);

/// How many there are of everything, on the GPU.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct StrokeCounts {
    /// Edges that were found.
    pub edges: u32,
    /// Pieces to chain, at byte 4. More than there is room for are passed over.
    pub pieces: u32,
    /// Chains: what [`chain::run`](super::chain::run) writes.
    pub chains: u32,
    /// Points of strokes.
    pub points: u32,
    /// Edges that found no room.
    pub edges_lost: u32,
    /// Pieces that found no room.
    pub pieces_lost: u32,
    /// Which rounds of ranking chains had something to do.
    pub progress: u32,
    /// Nothing.
    pub padding: u32,
}

describe!(StrokeCounts as "StrokeCounts" in "lines/strokes/chain_begin":
    edges, pieces, chains, points, edges_lost, pieces_lost, progress, padding);

/// Pieces that run on from each other.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Pod, Zeroable)]
pub struct Chain {
    /// Its first place in the order.
    pub first: u32,
    /// Its pieces.
    pub count: u32,
    /// 1 if its end runs on into its beginning.
    pub is_closed: u32,
    /// The key of its first piece.
    pub key: u32,
    /// From its first end to its last, with the gaps between pieces; of a closed one all the way round. Modulo 2³².
    pub length_units: u32,
    /// Nothing.
    pub padding: [u32; 3],
}

describe!(Chain as "Chain" in "lines/strokes/chain_order": first, count, is_closed, key, length_units, padding);

/// A place in the order of pieces.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Pod, Zeroable)]
pub struct Place {
    /// The chain that has it.
    pub chain: u32,
    /// From the chain's start to the start of the piece. Modulo 2³².
    pub begin_units: u32,
}

/// A [`Place`] with the piece that has it, as the GPU writes it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Pod, Zeroable)]
pub struct PieceInOrder {
    /// Twice the number of the piece, and 1 more if it runs from b to a.
    pub state: u32,
    /// The chain that has it.
    pub chain: u32,
    /// From the chain's start to the start of the piece. Modulo 2³².
    pub begin_units: u32,
}

describe!(PieceInOrder as "Place" in "lines/strokes/chain_order": state, chain, begin_units);

/// Which ends are joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChainRules {
    /// D: ends farther apart are not joined. 1 to [`ChainRules::WIDEST_REACH_UNITS`].
    pub reach_units: u32,
    /// cos² of the widest angle A between one piece's way out and the other's way on, in 1/4096. 0 to 4096.
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

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct ChainRulesUniform {
    pub capacity: u32,
    pub reach_units: u32,
    pub least_cos_squared: u32,
    pub overlap_units: u32,
}

describe!(ChainRulesUniform as "ChainRules" in "lines/strokes/chain_bin":
    capacity, reach_units, least_cos_squared, overlap_units);

/// Only the GPU writes it; the order of its fields is that of the numbers that scans are told.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct ChainPlan {
    pub pieces: u32,
    pub ends: u32,
    pub buckets: u32,
    pub padding: u32,
}

describe!(ChainPlan as "ChainPlan" in "lines/strokes/chain_begin": pieces, ends, buckets, padding);
