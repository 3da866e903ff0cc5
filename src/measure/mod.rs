//! What a drawing cost, how steady it is, and how far it is from another: statistics of runs, the report of a bench,
//! comparison of pictures and of frames.

pub mod image_compare;
pub mod lod_error;
pub mod memory;
pub mod report;
pub mod report_html;
pub mod report_text;
pub mod statistics;
pub mod stereo;
pub mod temporal;
