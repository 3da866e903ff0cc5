//! What frames keep from one to the next: pipelines, buffers, uniforms, bind groups.

use std::any::{Any, TypeId};
use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::Gpu;
use super::arena::Arena;
use super::bind::BindGroups;
use super::buffer::Buffers;
use super::pipelines::Pipelines;

/// What nobody has asked for in so many frames goes: some seconds of a window.
pub const KEEP_FRAMES: u64 = 240;

/// The pools. All eyes and styles share them.
pub struct Pools {
    /// By what they are made of.
    pub pipelines: Pipelines,
    /// By name.
    pub buffers: Buffers,
    /// Of the frame that is being recorded.
    pub arena: Arena,
    /// By what they bind.
    pub groups: BindGroups,
    /// By type and content.
    pub kept: Kept,
}

impl Pools {
    /// Empty ones: what is asked for is made then.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            pipelines: Pipelines::default(),
            buffers: Buffers::default(),
            arena: Arena::new(gpu),
            groups: BindGroups::default(),
            kept: Kept::default(),
        }
    }

    /// Ends a frame, whose commands were submitted.
    pub fn end_frame(&mut self) {
        self.arena.begin_frame();
        self.buffers.end_frame();
        self.groups.end_frame();
        self.pipelines.end_frame();
        self.kept.end_frame();
    }
}

/// A value, and the last frame that asked for it.
type Aged = (Arc<dyn Any + Send + Sync>, u64);

/// Values of any type that are made from something: a style's colour ramp, a world's meshes.
#[derive(Default)]
pub struct Kept {
    values: FxHashMap<TypeId, Vec<Aged>>,
    frame: u64,
}

impl Kept {
    /// The value that `find` knows, or a new one.
    ///
    /// # Errors
    /// Those of `make`.
    pub fn get<T: Send + Sync + 'static, E>(
        &mut self,
        find: impl Fn(&T) -> bool,
        make: impl FnOnce() -> Result<T, E>,
    ) -> Result<Arc<T>, E> {
        let values = self.values.entry(TypeId::of::<T>()).or_default();
        for (value, used_in) in values.iter_mut() {
            if let Ok(value) = Arc::clone(value).downcast::<T>()
                && find(&value)
            {
                *used_in = self.frame;
                return Ok(value);
            }
        }
        let value = Arc::new(make()?);
        values.push((Arc::clone(&value) as Arc<dyn Any + Send + Sync>, self.frame));
        Ok(value)
    }

    fn end_frame(&mut self) {
        self.frame += 1;
        let frame = self.frame;
        for values in self.values.values_mut() {
            values.retain(|(_, used_in)| *used_in + KEEP_FRAMES > frame);
        }
    }
}
