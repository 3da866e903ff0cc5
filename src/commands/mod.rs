//! The commands of the program, one file each.

pub mod fly;
pub mod progress;
pub mod render;
pub mod world;
