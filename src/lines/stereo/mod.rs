//! Agreement of the lines of two eyes (Zaidi and others, section 4.2).
//!
//! Contours are at different places of the surface for each eye, and details smaller than a pixel are hit by one eye
//! and missed by the other. The former are softened toward the other eye's contour ([`fade_out`]), the latter are
//! removed ([`agree`]). Both eyes are treated alike: each reads the other's lines as they were before any were removed.
//!
//! Why: `docs/decisions/stereo.md`.

pub(crate) mod agree;
pub(crate) mod fade_out;
