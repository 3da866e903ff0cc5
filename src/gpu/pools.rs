//! The resources that a renderer reuses from one frame to the next: buffers, uniforms, bind groups and values of any
//! type. Pipelines belong to the device.

use std::any::{Any, TypeId};
use std::sync::Arc;

use rustc_hash::{FxHashMap, FxHashSet};

use super::Gpu;
use super::arena::Arena;
use super::bind::BindGroups;
use super::buffer::Buffers;
use super::pipelines::Compiles;
use super::workers::Workers;

/// A resource that has not been requested for this many frames is released. In a window, that is a few seconds.
pub const KEEP_FRAMES: u64 = 240;

/// The pools of a renderer, which all eyes and styles share.
pub struct Pools {
    /// How the device's pipelines are compiled for this renderer.
    pub compiles: Compiles,
    pub buffers: Buffers,
    /// The uniforms of the frame that is being recorded.
    pub arena: Arena,
    pub groups: BindGroups,
    pub kept: Kept,
}

impl Pools {
    /// Creates empty pools. A resource is created when it is first requested.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            compiles: Compiles::default(),
            buffers: Buffers::default(),
            arena: Arena::new(gpu),
            groups: BindGroups::default(),
            kept: Kept::default(),
        }
    }

    /// Ends a frame, after its commands have been submitted or dropped.
    pub fn end_frame(&mut self) {
        self.arena.begin_frame();
        self.buffers.end_frame();
        self.groups.end_frame();
        self.kept.end_frame();
    }
}

/// A cached value, and the last frame that requested it.
type Aged = (Arc<dyn Any + Send + Sync>, u64);

/// A cache of values of any type that take time to create, such as a style's colour ramp or a world's meshes.
#[derive(Default)]
pub struct Kept {
    values: FxHashMap<TypeId, Vec<Aged>>,
    frame: u64,
    workers: Option<Workers<(TypeId, Arc<dyn Any + Send + Sync>)>>,
    /// The types of which a worker is creating a value, one value of a type at a time.
    being_made: FxHashSet<TypeId>,
}

impl Kept {
    /// Returns the cached value that `find` accepts; without one, creates it with `make`.
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

    /// Returns the cached value that `find` accepts; without one, starts `make` on another thread and returns `None`.
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

    /// Adds the values that other threads have finished to the cache. Does not wait.
    pub fn take_made(&mut self) {
        while let Some((kind, value)) = self.workers.as_mut().and_then(Workers::take) {
            self.being_made.remove(&kind);
            self.values.entry(kind).or_default().push((value, self.frame));
        }
    }

    /// Returns whether another thread is creating a value.
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
