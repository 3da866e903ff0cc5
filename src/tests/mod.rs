//! The tests of the library, in one program: they share a device with its pipelines, and can use private items.
//!
//! `tests/` contains the tests of the program: its command line, its files, its window.
#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "a test may panic, and writes to scratch folders")]
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "libtest captures what a test prints")]
#![allow(unreachable_pub, reason = "modules of tests share their helpers")]

pub(crate) mod common;
mod helpers;

mod antialias;
mod aov;
mod border;
mod chain;
mod coherence;
mod continent;
mod crowd;
mod curvature;
mod cuts;
mod depth;
mod derive;
mod device;
mod extremes;
mod eyes;
mod files;
mod flights;
mod focus;
mod forest;
mod forest_colors;
mod forest_cover;
mod forest_eyes;
mod forest_ink;
mod forest_levels;
mod forest_models;
mod forest_strokes;
mod forest_tones;
mod forest_wind;
mod form_light;
mod form_marks;
mod frame_passes;
mod gallery;
mod given_water;
mod grid_projection;
mod hatching;
mod ground_metres;
mod height_lines;
mod ink;
mod light;
mod line_pictures;
mod load;
mod lsa;
mod measure;
mod memory_world;
mod meshes;
mod mirror;
mod mosaic;
mod motion;
mod panorama;
mod parts;
mod popping;
mod portable;
mod procedural;
mod pyramid;
mod relief;
mod rig;
mod rims;
mod rows;
mod scene;
mod selection;
mod shaders;
mod shared_structs;
mod sky;
mod source;
mod source_place;
mod streaming;
mod stroke_texture;
mod strokes;
mod style_parameters;
mod sun_time;
mod surface;
mod temporal;
mod tonal_art_map;
mod tonal_art_map_stack;
mod tone_lines;
mod vector;
mod visible_edges;
mod voids;
mod wash;
mod water;
