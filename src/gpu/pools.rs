//! What a renderer keeps from one frame to the next: buffers, uniforms, bind groups. Pipelines belong to the device.

use super::Gpu;
use super::arena::Arena;
use super::bind::BindGroups;
use super::buffer::Buffers;
use super::pipelines::Compiles;

/// What nobody has asked for in so many frames goes: some seconds of a window.
pub const KEEP_FRAMES: u64 = 240;

/// The pools. All eyes and styles share them.
pub struct Pools {
    /// How the device's pipelines are compiled for this renderer.
    pub compiles: Compiles,
    /// By name.
    pub buffers: Buffers,
    /// Of the frame that is being recorded.
    pub arena: Arena,
    /// By what they bind.
    pub groups: BindGroups,
}

impl Pools {
    /// Empty ones: what is asked for is made then.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            compiles: Compiles::default(),
            buffers: Buffers::default(),
            arena: Arena::new(gpu),
            groups: BindGroups::default(),
        }
    }

    /// Ends a frame, whose commands were submitted.
    pub fn end_frame(&mut self) {
        self.arena.begin_frame();
        self.buffers.end_frame();
        self.groups.end_frame();
    }
}
