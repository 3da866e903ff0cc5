//! Lines from pictures of the surface: a detector writes errors, the threshold turns them into lines, and smoothing
//! removes the stairs. [`crowd`] thins crowded lines. [`stereo`] makes the lines of two eyes agree. [`tone`] finds
//! lines from shading. [`strokes`] are lines as geometry.

pub(crate) mod apparent;
pub(crate) mod crowd;
pub(crate) mod curvature;
pub(crate) mod detector;
pub(crate) mod drainage;
pub(crate) mod draped;
pub(crate) mod lsa;
pub(crate) mod radial;
pub(crate) mod ridges;
pub(crate) mod rims;
pub(crate) mod smooth;
pub(crate) mod stereo;
pub(crate) mod strokes;
pub(crate) mod suggestive;
pub(crate) mod threshold;
pub(crate) mod tone;
pub(crate) mod trees;
