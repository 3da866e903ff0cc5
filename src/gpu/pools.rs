//! The resources that a renderer reuses from one frame to the next: buffers, uniforms and bind groups. Pipelines
//! and cached values belong to the device.

use super::Gpu;
use super::arena::Arena;
use super::bind::BindGroups;
use super::buffer::Buffers;
use super::cache_counts::CacheCounts;
use super::pipelines::Compiles;

/// A resource that has not been requested for this many frames is released. In a window, that is a few seconds.
pub(crate) const KEEP_FRAMES: u64 = 240;

/// The pools of a renderer, which all eyes and styles share.
pub struct Pools {
    /// How the device's pipelines are compiled for this renderer.
    pub compiles: Compiles,
    pub buffers: Buffers,
    /// The uniforms of the frame that is being recorded.
    pub arena: Arena,
    pub groups: BindGroups,
}

impl Pools {
    /// Creates empty pools. A resource is created when it is first requested.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            compiles: Compiles::default(),
            buffers: Buffers::default(),
            arena: Arena::new(gpu),
            groups: BindGroups::default(),
        }
    }

    /// Returns the hits and misses of each cache, by its name.
    pub(crate) fn cache_counts(&self) -> [(&'static str, CacheCounts); 3] {
        [("pipelines", self.compiles.counts), ("bind_groups", self.groups.counts()), ("buffers", self.buffers.counts())]
    }

    /// Ends a frame, after its commands have been submitted or dropped.
    pub fn end_frame(&mut self) {
        self.arena.begin_frame();
        self.buffers.end_frame();
        self.groups.end_frame();
    }
}
