//! The device, shaders, targets, timers and readback. Knows nothing of terrain.

pub mod buffer;
pub mod device;
pub mod later;
pub mod pass;
pub mod readback;
pub mod shader;
pub mod shared;
pub mod target;
pub mod timer;
pub mod upload_ring;

pub use device::{Gpu, GpuError};
