//! What a renderer keeps from one frame to the next: buffers, uniforms, bind groups. Pipelines belong to the device.

use std::any::{Any, TypeId};
use std::sync::Arc;

use rustc_hash::{FxHashMap, FxHashSet};

use super::Gpu;
use super::arena::Arena;
use super::bind::BindGroups;
use super::buffer::Buffers;
use super::pipelines::Compiles;
use super::workers::Workers;

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
    /// By type and content.
    pub kept: Kept,
}

impl Pools {
    /// Empty ones: what is asked for is made then.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            compiles: Compiles::default(),
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
    workers: Option<Workers<(TypeId, Arc<dyn Any + Send + Sync>)>>,
    /// One of a type at a time.
    being_made: FxHashSet<TypeId>,
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
        if let Some(value) = self.known(find) {
            return Ok(value);
        }
        let value = Arc::new(make()?);
        let values = self.values.entry(TypeId::of::<T>()).or_default();
        values.push((Arc::clone(&value) as Arc<dyn Any + Send + Sync>, self.frame));
        Ok(value)
    }

    /// The value that `find` knows; if there is none, `make` begins on another thread.
    pub fn ask<T: Send + Sync + 'static>(
        &mut self,
        find: impl Fn(&T) -> bool,
        make: impl FnOnce() -> T + Send + 'static,
    ) -> Option<Arc<T>> {
        let known = self.known(find);
        let kind = TypeId::of::<T>();
        if known.is_none() && self.being_made.insert(kind) {
            self.workers.get_or_insert_default().start(move || (kind, Arc::new(make()) as Arc<dyn Any + Send + Sync>));
        }
        known
    }

    /// Takes what was made on other threads; waits for nothing.
    pub fn take_made(&mut self) {
        while let Some((kind, value)) = self.workers.as_mut().and_then(Workers::take) {
            self.being_made.remove(&kind);
            self.values.entry(kind).or_default().push((value, self.frame));
        }
    }

    /// Whether something is being made on another thread.
    pub fn is_making(&self) -> bool {
        self.workers.as_ref().is_some_and(|workers| workers.open() > 0)
    }

    fn known<T: Send + Sync + 'static>(&mut self, find: impl Fn(&T) -> bool) -> Option<Arc<T>> {
        for (value, used_in) in self.values.get_mut(&TypeId::of::<T>())? {
            if let Ok(value) = Arc::clone(value).downcast::<T>()
                && find(&value)
            {
                *used_in = self.frame;
                return Some(value);
            }
        }
        None
    }

    fn end_frame(&mut self) {
        self.frame += 1;
        let frame = self.frame;
        for values in self.values.values_mut() {
            values.retain(|(_, used_in)| *used_in + KEEP_FRAMES > frame);
        }
    }
}
