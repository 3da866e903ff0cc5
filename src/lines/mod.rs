//! Lines from pictures of the surface: a detector writes errors, the threshold makes lines of them, smoothing takes the
//! stairs away. [`crowd`] thins crowded ones out. [`stereo`] lets lines of two eyes agree. [`tone`] has
//! lines of its own, from light. [`strokes`] has lines as geometry.

pub mod apparent;
pub mod apparent_ridges;
pub mod crowd;
pub mod curvature;
pub mod detector;
pub mod lsa;
pub mod radial;
pub mod ridges;
pub mod rims;
pub mod smooth;
pub mod stereo;
pub mod strokes;
pub mod suggestive;
pub mod threshold;
pub mod tone;
pub mod trees;
