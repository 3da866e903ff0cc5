//! The layer over wgpu: device, shaders, pipelines, passes, targets, buffers, timers and readback. It knows nothing of
//! terrain.

pub(crate) mod arena;
pub(crate) mod bind;
pub(crate) mod buffer;
mod build;
pub(crate) mod cache;
pub(crate) mod cache_counts;
pub mod device;
pub(crate) mod drawer;
pub(crate) mod finite;
pub(crate) mod full_screen;
pub(crate) mod async_readback;
pub(crate) mod pipelines;
pub(crate) mod pools;
pub(crate) mod readback;
pub(crate) mod recorder;
mod reflection;
pub(crate) mod scan;
pub(crate) mod shader;
pub(crate) mod stored_pipelines;

pub(crate) mod target;
pub(crate) mod texts;
pub(crate) mod timer;
pub(crate) mod trace;
pub(crate) mod upload_ring;
pub(crate) mod wgsl;
pub(crate) mod workers;

pub use device::{Gpu, GpuError};
pub use target::{Target, TargetKind};
pub use timer::PassTime;
