//! Measurements: the cost of a drawing, its steadiness, and the difference between two drawings. Statistics of runs,
//! the report of a benchmark, comparison of pictures and of frames.

pub(crate) mod comparison;
pub(crate) mod exactness;
pub(crate) mod figures;
pub(crate) mod front;
pub(crate) mod governed;
pub mod image_compare;
pub(crate) mod lod_error;
pub(crate) mod memory;
pub(crate) mod paired;
pub(crate) mod quality;
pub(crate) mod report;
pub(crate) mod report_html;
pub(crate) mod report_text;
pub(crate) mod setting;
pub(crate) mod settings;
pub(crate) mod statistics;
pub mod stereo;
pub(crate) mod suite;
pub mod temporal;
pub(crate) mod trade;
#[cfg(test)]
mod trade_page;
mod trade_plot;
pub(crate) mod work;
