//! The commands of the program, one file each.

pub mod adapter;
pub mod bake;
pub mod bench;
pub mod fly;
pub mod info;
pub mod progress;
pub mod render;
pub mod styles;
pub mod world;
