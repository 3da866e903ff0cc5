//! Lines from pictures of the surface: a detector writes errors, the threshold turns them into lines, and smoothing
//! removes the stairs. [`crowd`] thins crowded lines. [`stereo`] makes the lines of two eyes agree. [`tone`] finds
//! lines from shading. [`strokes`] are lines as geometry.

pub mod apparent;
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
