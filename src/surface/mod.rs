//! From the terrain and a view to pictures of the surface: depth and id, then position and normal, then motion.

pub mod form;
pub mod horizons;
pub mod mesh_resolve;
pub mod mesh_vertices;
pub mod meshes;
pub mod motion;
pub mod resolve;
pub mod terrain;
pub mod view;
pub mod vertices;
