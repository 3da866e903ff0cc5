//! Light that brings out relief: the warp and its inverse against the paper's formulas, curvature toward the eye against a
//! hill that is known, and what must hold at the ends of all parameters. Each measure has planted errors that it must find.
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a test fails by panicking, into scratch folders")]

mod gradient;
mod light;
mod warp;
