//! The device, shaders, targets, timers and readback. Knows nothing of terrain.
