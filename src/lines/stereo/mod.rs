//! Lines of two eyes that agree (Zaidi and others, section 4.2).
//!
//! Contours lie elsewhere on the surface for each eye, and details smaller than a pixel are hit by one eye and missed
//! by the other. The first are softened toward where the other eye's contour is ([`fade_out`]), the second go
//! ([`agree`]). Both eyes are treated alike: each reads what the other has before anything of either has gone.
//!
//! Why: `docs/decisions/stereo.md`.

pub mod agree;
pub mod fade_out;
