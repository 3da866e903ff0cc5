//! Tests of hatching: marks keep their size, their mean is the requested tone, they stick to the ground, and nothing
//! pops. Each measure is checked with a planted error that it must detect.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod calibrated;
mod constant;
mod continuous;
mod directions;
mod extremes;
mod grain;
mod places;
mod plane;
mod seams;
mod slopes;
mod stable;
