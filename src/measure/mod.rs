//! Measurements: what a drawing costs, how steady it is, and how far two drawings differ. Statistics of runs, the
//! report of a benchmark, comparison of pictures and of frames.

pub mod image_compare;
pub mod lod_error;
pub mod memory;
pub mod report;
pub mod report_html;
pub mod report_text;
pub mod statistics;
pub mod stereo;
pub mod temporal;
