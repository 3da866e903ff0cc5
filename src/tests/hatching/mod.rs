//! Hatching: marks keep their size, their mean is the tone that was asked for, they stick to the ground, and nothing
//! pops. Each measure is held against a planted error that it must catch.
#![allow(clippy::unwrap_used, reason = "a test fails by it")]

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
