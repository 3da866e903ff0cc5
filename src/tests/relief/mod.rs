//! Tests of relief by light: the warp and its inverse against the paper's formulas, curvature toward the eye against a
//! known hill, and bounds at the ends of all parameters. Each measure has planted errors that it must detect.
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a test may panic, and writes to scratch folders")]

mod gradient;
mod light;
mod warp;
