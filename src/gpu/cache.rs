//! Values of any type that are made for a device and that frames use again: a style's colour ramp, tonal art maps, a
//! world's meshes. They belong to the device, so all renderers share them.

use std::any::{Any, TypeId};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rustc_hash::{FxHashMap, FxHashSet};

use super::pools::KEEP_FRAMES;
use super::workers::Workers;

type Value = Arc<dyn Any + Send + Sync>;

/// The values. One that no frame has used for [`KEEP_FRAMES`] frames of the device is dropped.
#[derive(Default)]
pub(crate) struct Cache {
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    /// Each value with the number of the last frame that used it.
    values: FxHashMap<TypeId, Vec<(Value, u64)>>,
    /// Counts the frames of all renderers of the device.
    frame: u64,
    workers: Option<Workers<(TypeId, Value)>>,
    /// The types of which a value is being made in the background: one of a type at a time.
    being_made: FxHashSet<TypeId>,
}

impl Cache {
    /// Returns the value of type `T` that `find` accepts, or makes it.
    ///
    /// # Errors
    /// The errors of `make`.
    pub(crate) fn get<T: Send + Sync + 'static, E>(
        &self,
        find: impl Fn(&T) -> bool,
        make: impl FnOnce() -> Result<T, E>,
    ) -> Result<Arc<T>, E> {
        if let Some(value) = self.lock().find(find) {
            return Ok(value);
        }
        // Making a value may take long, so the cache is not locked meanwhile.
        let value = Arc::new(make()?);
        self.lock().add(TypeId::of::<T>(), Arc::clone(&value) as Value);
        Ok(value)
    }

    /// Returns the value of type `T` that `find` accepts, if there is one.
    pub(crate) fn known<T: Send + Sync + 'static>(&self, find: impl Fn(&T) -> bool) -> Option<Arc<T>> {
        self.lock().find(find)
    }

    /// Returns the value of type `T` that `find` accepts. If there is none, `make` starts on another thread.
    pub(crate) fn request<T: Send + Sync + 'static>(
        &self,
        find: impl Fn(&T) -> bool,
        make: impl FnOnce() -> T + Send + 'static,
    ) -> Option<Arc<T>> {
        let kind = TypeId::of::<T>();
        let state = &mut *self.lock();
        let found = state.find(find);
        if found.is_none() && state.being_made.insert(kind) {
            state.workers.get_or_insert_default().start(move || (kind, Arc::new(make()) as Value));
        }
        found
    }

    /// Takes over the values that other threads have made. Does not wait.
    pub(crate) fn take_made(&self) {
        let state = &mut *self.lock();
        while let Some((kind, value)) = state.workers.as_mut().and_then(Workers::take) {
            state.being_made.remove(&kind);
            state.add(kind, value);
        }
    }

    /// Returns whether another thread is making a value.
    pub(crate) fn is_making(&self) -> bool {
        self.lock().workers.as_ref().is_some_and(|workers| workers.open() > 0)
    }

    /// Counts a frame, and drops the values that have not been used for long.
    pub(crate) fn end_frame(&self) {
        let state = &mut *self.lock();
        state.frame += 1;
        let frame = state.frame;
        for values in state.values.values_mut() {
            values.retain(|(_, used_in)| *used_in + KEEP_FRAMES > frame);
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn find<T: Send + Sync + 'static>(&mut self, find: impl Fn(&T) -> bool) -> Option<Arc<T>> {
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

    fn add(&mut self, kind: TypeId, value: Value) {
        self.values.entry(kind).or_default().push((value, self.frame));
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use std::convert::Infallible;

    use super::*;

    #[test]
    fn a_value_is_made_once_and_dropped_when_unused() {
        let cache = Cache::default();
        let get = |wanted: u32| {
            let mut made = false;
            let make = || {
                made = true;
                Ok::<_, Infallible>(wanted)
            };
            (*cache.get(|known: &u32| *known == wanted, make).unwrap(), made)
        };
        assert_eq!((get(1), get(2), get(1)), ((1, true), (2, true), (1, false)));
        for _ in 0..KEEP_FRAMES - 1 {
            cache.end_frame();
        }
        // Planted: a value that was used in time stays, one that was not is made again.
        assert_eq!(get(1), (1, false));
        cache.end_frame();
        assert_eq!((get(1), get(2)), ((1, false), (2, true)));
    }
}
