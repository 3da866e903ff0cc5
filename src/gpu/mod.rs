//! The layer over wgpu: device, shaders, pipelines, passes, targets, buffers, timers and readback. It knows nothing of
//! terrain.

pub mod arena;
pub mod bind;
pub mod buffer;
mod build;
pub mod cache;
pub mod device;
pub(crate) mod full_screen;
pub mod async_readback;
pub mod pipelines;
pub mod pools;
pub mod readback;
pub mod recorder;
mod reflection;
pub mod scan;
pub mod shader;
pub(crate) mod stored_pipelines;

pub mod target;
pub mod texts;
pub mod timer;
pub mod trace;
pub mod upload_ring;
pub mod wgsl;
pub mod workers;

pub use device::{Gpu, GpuError};
