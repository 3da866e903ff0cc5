//! Strokes: lines as geometry. Pieces of lines become chains, on the GPU and without a word from the CPU (Loadholt 2021,
//! "hybrid overlay strokes", section 4.2).
//!
//! Counts live on the GPU ([`StrokeCounts`]), and dispatches take their size from there. What a chain is says [`twin`],
//! in plain Rust; the passes of [`chain`] must give the same, to the bit.

mod records;
pub mod scan;
pub mod chain;
pub mod twin;

pub use records::{Chain, ChainRules, Piece, Place, StrokeCounts, UNITS_PER_PX};
pub(crate) use records::{ChainPlan, ChainRulesUniform};
