//! The pipelines of a device. Each is compiled once, at its first use, and serves every renderer of the device.
//!
//! A renderer that must not wait lets other threads compile ([`Builds::InBackground`]) and goes without the pipeline
//! meanwhile. Where shaders are read from files that are being edited, a pipeline whose text has changed is compiled
//! again; the old pipeline stays in use until the new one has been compiled and bound without an error.
//!
//! Why: `docs/decisions/pipelines-in-background.md`.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::Gpu;
use super::bind::{BindGroups, Bound, Named};
pub(crate) use super::build::{Key, Raw};
use super::build::{On, Pipeline, build, in_scope};
use super::cache_counts::CacheCounts;
use super::shader::ShaderError;
use super::texts::{Texts, Watch, made_of};
use super::workers::Workers;

/// A variant of a compute shader, whose entry point is `main`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Compute {
    /// The name of the shader, which is also that of the pass.
    pub name: &'static str,
    /// The symbols that are defined for `#ifdef`.
    pub definitions: &'static [&'static str],
}

impl From<&'static str> for Compute {
    fn from(name: &'static str) -> Self {
        Self { name, definitions: &[] }
    }
}

/// Returns those of a shader's symbols that a variant defines, in the form that [`Compute`] and [`Draw`] hold.
///
/// Each combination is stored once for the life of the program; a shader has few of them.
pub(crate) fn defined(symbols: impl IntoIterator<Item = (&'static str, bool)>) -> &'static [&'static str] {
    static STORED: Mutex<Vec<&'static [&'static str]>> = Mutex::new(Vec::new());
    let symbols: Vec<&'static str> = symbols.into_iter().filter_map(|(name, is)| is.then_some(name)).collect();
    let mut stored = STORED.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = stored.iter().find(|known| **known == symbols) {
        return known;
    }
    let new: &'static [&'static str] = Vec::leak(symbols);
    stored.push(new);
    new
}

/// A render pipeline. Its vertex entry point is `vertex`; vertices come from buffers that the shader reads itself.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Draw {
    /// The name of the shader, which is also that of the pass.
    pub name: &'static str,
    /// The symbols that are defined for `#ifdef`.
    pub definitions: &'static [&'static str],
    /// The fragment entry point; empty for a pipeline without a fragment shader, which only writes depth.
    pub fragment: &'static str,
    /// The colour targets, in the order of the shader's outputs.
    pub colors: [Option<wgpu::ColorTargetState>; 5],
    /// The format of the depth target, if depth is tested: the greater depth wins, which is nearer.
    pub depth: Option<wgpu::TextureFormat>,
    /// Whether the depth target is written.
    pub writes_depth: bool,
    /// Whether the fragment shader writes depths that are nowhere nearer than the triangles. A GPU may then test the
    /// depth of the triangles first.
    pub writes_farther: bool,
    /// Triangles or lines.
    pub topology: wgpu::PrimitiveTopology,
}

impl Draw {
    /// Triangles without colour targets and without depth, drawn by the entry point `fragment`; the fields that differ
    /// replace these.
    pub(crate) const fn triangles(name: &'static str) -> Self {
        Self {
            name,
            definitions: &[],
            fragment: "fragment",
            colors: [None, None, None, None, None],
            depth: None,
            writes_depth: false,
            writes_farther: false,
            topology: wgpu::PrimitiveTopology::TriangleList,
        }
    }
}

/// A colour target without blending.
pub(crate) const fn replaced(format: wgpu::TextureFormat) -> Option<wgpu::ColorTargetState> {
    Some(wgpu::ColorTargetState { format, blend: None, write_mask: wgpu::ColorWrites::ALL })
}

/// A colour target that keeps the maximum: ink over ink would depend on the order of what is drawn, which is arbitrary.
pub(crate) const fn greatest(format: wgpu::TextureFormat) -> Option<wgpu::ColorTargetState> {
    let one = wgpu::BlendFactor::One;
    let max = wgpu::BlendComponent { src_factor: one, dst_factor: one, operation: wgpu::BlendOperation::Max };
    let blend = Some(wgpu::BlendState { color: max, alpha: max });
    Some(wgpu::ColorTargetState { format, blend, write_mask: wgpu::ColorWrites::ALL })
}

/// Which thread compiles a pipeline that is requested for the first time, and when.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Builds {
    /// The thread that requests it, which waits.
    #[default]
    AtOnce,
    /// Another thread. The renderer goes without the pipeline until it is compiled.
    InBackground,
    /// None yet: requests are collected for [`Pipelines::build_collected`]. For prewarming runs only.
    Collected,
    /// Another thread, when it has nothing else to compile: requests are collected for [`Pipelines::keep_spares`]. For
    /// prewarming runs only, which go without the values that are not cached.
    Spare,
}

/// How one renderer has its pipelines compiled.
#[derive(Clone, Copy, Debug, Default)]
pub struct Compiles {
    /// Whether pipelines are compiled at once or in the background.
    pub builds: Builds,
    /// Number of pipelines that have been compiled so far while the renderer waited.
    pub built_at_once: u64,
    /// Time to compile them in milliseconds, summed over all threads.
    pub build_ms: f64,
    /// Requests for a pipeline that was compiled already, and for one that was not.
    pub counts: CacheCounts,
}

/// The state of one pipeline.
#[derive(Default)]
struct Entry {
    current: Option<Arc<Pipeline>>,
    /// Replaces `current` when it has been bound without an error.
    next: Option<Arc<Pipeline>>,
    /// The number of the newest build under way, and who compiles it.
    building: Option<(u64, Builds)>,
}

impl Entry {
    fn is_built(&self) -> bool {
        self.current.is_some() || self.next.is_some()
    }
}

/// The result of a build in the background: the pipeline's key, the number of the build, and what came of it.
type Built = (Key, u64, Result<Pipeline, ShaderError>);

/// All pipelines of a device.
#[derive(Default)]
pub(crate) struct Pipelines {
    state: Mutex<State>,
    /// Signalled whenever a thread has compiled a pipeline at once: another one may wait for the same pipeline.
    built: Condvar,
}

struct State {
    entries: FxHashMap<Key, Entry>,
    texts: Texts,
    watch: Watch,
    workers: Option<Workers<Built>>,
    /// The requests with [`Builds::Collected`].
    collected: Vec<Key>,
    /// Pipelines that nothing needs yet. They are compiled one at a time, while nothing else is.
    spares: VecDeque<Key>,
    /// The spare pipeline that is being compiled, unless a frame has requested it since.
    spare: Option<Key>,
    /// The errors in the newest text of each pipeline that has any.
    shader_errors: FxHashMap<Key, ShaderError>,
    /// Counts builds; each pipeline carries the number of its build.
    builds: u64,
    /// Counts builds because of a changed text.
    rebuilds: u64,
}

impl Default for State {
    fn default() -> Self {
        let texts = Texts::of_environment();
        Self {
            entries: FxHashMap::default(),
            watch: Watch::new(&texts),
            texts,
            workers: None,
            collected: Vec::new(),
            spares: VecDeque::new(),
            spare: None,
            shader_errors: FxHashMap::default(),
            builds: 0,
            rebuilds: 0,
        }
    }
}

/// A pipeline with the bind group of its resources.
#[derive(Clone, Debug)]
pub(crate) struct Ready {
    /// The pipeline as wgpu has it.
    pub raw: Raw,
    /// Bind group 0.
    pub bound: Bound,
}

impl Pipelines {
    /// Returns a pipeline with its resources bound. Returns `None` while the pipeline is being compiled, and when its
    /// shader has an error ([`shader_errors`](Pipelines::shader_errors)).
    pub(crate) fn ready(
        &self,
        gpu: &Gpu,
        groups: &mut BindGroups,
        key: &Key,
        resources: &[Named],
        compiles: &mut Compiles,
    ) -> Option<(Ready, Arc<Pipeline>)> {
        // Nearly always the pipeline is there: then the table is looked up once.
        let is_there = |entry: &&Entry| entry.next.is_none();
        let there = self.lock().entries.get(key).filter(is_there).and_then(|entry| entry.current.clone());
        if there.is_none() && !self.request(gpu, key, compiles) {
            return None;
        }
        let mut bind = |pipeline: &Pipeline| {
            groups.bind(gpu, key.name(), (pipeline.number, &pipeline.layout), &pipeline.variables, resources)
        };
        let pipeline = if let Some(there) = there {
            there
        } else {
            let State { entries, shader_errors, .. } = &mut *self.lock();
            let entry = entries.get_mut(key)?;
            // An edited text may declare a variable that no pass binds, or bind one as another type: the old pipeline
            // then stays.
            if let Some(next) = entry.next.take() {
                match in_scope(&gpu.device, key.name(), || bind(&next)) {
                    Ok(_) => entry.current = Some(next),
                    Err(error) => report(shader_errors, key, error),
                }
            }
            Arc::clone(entry.current.as_ref()?)
        };
        match bind(&pipeline) {
            Ok(bound) => Some((Ready { raw: pipeline.raw.clone(), bound }, pipeline)),
            Err(error) => {
                report(&mut self.lock().shader_errors, key, error);
                None
            }
        }
    }

    /// Returns whether a pipeline is compiled. If it is not, its compilation starts, and with [`Builds::AtOnce`] ends
    /// before this function returns.
    pub(crate) fn request(&self, gpu: &Gpu, key: &Key, compiles: &mut Compiles) -> bool {
        let mut state = self.lock();
        compiles.counts.count(state.entries.get(key).is_some_and(Entry::is_built));
        loop {
            let building = match state.entries.get(key) {
                Some(entry) if entry.is_built() => return true,
                Some(entry) => entry.building,
                None => None,
            };
            match (building, compiles.builds) {
                (Some(_), Builds::InBackground) => {
                    state.spare.take_if(|spare| spare == key);
                    return false;
                }
                (Some(_), Builds::Collected | Builds::Spare) => return false,
                (Some((_, Builds::AtOnce)), Builds::AtOnce) => {
                    state = self.built.wait(state).unwrap_or_else(PoisonError::into_inner);
                }
                // A text that has an error has it until the text changes.
                _ if state.shader_errors.contains_key(key) => return false,
                (_, Builds::Collected | Builds::Spare) => {
                    state.collected.push(key.clone());
                    return false;
                }
                _ => {
                    drop(state);
                    self.build(gpu, key, compiles);
                    return self.lock().entries.get(key).is_some_and(Entry::is_built);
                }
            }
        }
    }

    /// Compiles the pipelines that were requested with [`Builds::Collected`], on all cores, and waits for them.
    pub(crate) fn build_collected(&self, gpu: &Gpu, compiles: &mut Compiles) {
        let keys = std::mem::take(&mut self.lock().collected);
        let build = |key: &Key| {
            let mut own = Compiles::default();
            // A key that was collected twice is compiled once: the second request finds it, or waits for it.
            self.request(gpu, key, &mut own);
            own
        };
        for own in keys.par_iter().map(build).collect::<Vec<_>>() {
            compiles.built_at_once += own.built_at_once;
            compiles.build_ms += own.build_ms;
        }
    }

    /// Compiles a pipeline, or has it compiled.
    fn build(&self, gpu: &Gpu, key: &Key, compiles: &mut Compiles) {
        let mut state = self.lock();
        state.builds += 1;
        let number = state.builds;
        // A shader module and a pipeline.
        gpu.count_object();
        gpu.count_object();
        state.entries.entry(key.clone()).or_default().building = Some((number, compiles.builds));
        let texts = state.texts.clone();
        match compiles.builds {
            Builds::AtOnce | Builds::Collected | Builds::Spare => {
                compiles.built_at_once += 1;
                drop(state);
                let begun = Instant::now();
                // If the parser panics on an edited text, threads that wait for this pipeline must not wait forever.
                let mut outcome = Outcome { pipelines: self, key, number, built: None };
                let on = On { device: &gpu.device, texts: &texts, stored: gpu.stored_pipelines() };
                outcome.built = Some(build(&on, key, number));
                compiles.build_ms += begun.elapsed().as_secs_f64() * 1000.0;
            }
            Builds::InBackground => {
                // The job holds the device and not the `Gpu`, which owns the threads that run the job.
                let (device, key) = (gpu.device.clone(), key.clone());
                let stored = gpu.stored_pipelines().cloned();
                state.workers.get_or_insert_default().start(move || {
                    let on = On { device: &device, texts: &texts, stored: stored.as_ref() };
                    let built = build(&on, &key, number);
                    (key, number, built)
                });
            }
        }
    }

    /// Takes over the pipelines that other threads have compiled. Does not wait.
    pub(crate) fn take_built(&self) {
        let state = &mut *self.lock();
        while let Some((key, number, built)) = state.workers.as_mut().and_then(Workers::take) {
            state.spare.take_if(|spare| *spare == key);
            state.take(&key, number, built);
        }
        if state.open() == 0 {
            // A job that panicked has no result.
            state.spare = None;
        }
    }

    /// Returns whether another thread is compiling a pipeline that a frame needs.
    pub(crate) fn is_building(&self) -> bool {
        self.being_built() > 0
    }

    /// Returns how many pipelines that a frame needs other threads are compiling, or will compile.
    pub(crate) fn being_built(&self) -> usize {
        let state = self.lock();
        // A spare pipeline whose job panicked is not open any more.
        state.open().saturating_sub(usize::from(state.spare.is_some()))
    }

    /// Makes the pipelines that were requested with [`Builds::Spare`] spare pipelines.
    pub(crate) fn keep_spares(&self) {
        let state = &mut *self.lock();
        let collected = std::mem::take(&mut state.collected);
        let State { spares, .. } = state;
        collected.into_iter().for_each(|key| {
            if !spares.contains(&key) {
                spares.push_back(key);
            }
        });
    }

    /// Returns whether spare pipelines are still to be compiled.
    pub(crate) fn has_spares(&self) -> bool {
        let state = self.lock();
        state.spare.is_some() || !state.spares.is_empty()
    }

    /// Has the next spare pipeline compiled on another thread, if that is idle. A frame that needs pipelines thus waits
    /// for one spare pipeline at most.
    pub(crate) fn build_spare(&self, gpu: &Gpu) {
        let next = {
            let state = &mut *self.lock();
            if state.open() > 0 {
                return;
            }
            let State { spares, entries, shader_errors, spare, .. } = state;
            let is_needed = |key: &Key| {
                let is_known = entries.get(key).is_some_and(|entry| entry.is_built() || entry.building.is_some());
                !is_known && !shader_errors.contains_key(key)
            };
            *spare = std::iter::from_fn(|| spares.pop_front()).find(is_needed);
            spare.clone()
        };
        if let Some(key) = next {
            self.build(gpu, &key, &mut Compiles { builds: Builds::InBackground, ..Compiles::default() });
        }
    }

    /// Returns how many pipelines have been compiled so far, at once or in the background.
    #[cfg(test)]
    pub(crate) fn builds(&self) -> u64 {
        self.lock().builds
    }

    /// Reads shaders from other texts from now on. Existing pipelines stay until a reload finds that their
    /// text has changed.
    #[cfg(test)]
    pub(crate) fn set_texts(&self, texts: Texts) {
        let mut state = self.lock();
        state.watch = Watch::new(&texts);
        state.texts = texts;
    }

    /// Returns whether shaders are files, which may change.
    pub(crate) fn watches(&self) -> bool {
        self.lock().texts.are_files()
    }

    /// Compiles again the pipelines whose text has changed since the last call. [`Pipelines::rebuilds`] counts them.
    pub(crate) fn reload(&self, gpu: &Gpu, compiles: &mut Compiles) {
        let keys: Vec<Key> = {
            let state = &mut *self.lock();
            let changed = state.watch.changed(&state.texts);
            if changed.is_empty() {
                return;
            }
            let changed = made_of(&state.texts, &changed);
            // The error of a pipeline may be in any of the texts that it imports.
            let is_changed = |key: &&Key| changed.contains(key.name()) || state.shader_errors.contains_key(*key);
            let keys: Vec<Key> = state.entries.keys().filter(is_changed).cloned().collect();
            state.rebuilds += keys.len() as u64;
            keys
        };
        for key in &keys {
            self.build(gpu, key, compiles);
        }
    }

    /// Returns how many pipelines have been compiled again because their text had changed.
    pub(crate) fn rebuilds(&self) -> u64 {
        self.lock().rebuilds
    }

    /// Returns the errors in shaders as they are now, each once and sorted.
    pub(crate) fn shader_errors(&self) -> Vec<ShaderError> {
        let mut shader_errors: Vec<_> = self.lock().shader_errors.values().cloned().collect();
        shader_errors.sort_by_key(ToString::to_string);
        shader_errors.dedup();
        shader_errors
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        // No code that may panic runs under the lock while an entry is half changed.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    /// Returns how many builds in the background are queued, under way, or have a result that has not been taken.
    fn open(&self) -> usize {
        self.workers.as_ref().map_or(0, Workers::open)
    }

    fn take(&mut self, key: &Key, number: u64, built: Result<Pipeline, ShaderError>) {
        let is_newest = |entry: &&mut Entry| entry.building.is_some_and(|(newest, _)| newest == number);
        let Some(entry) = self.entries.get_mut(key).filter(is_newest) else { return };
        entry.building = None;
        match built {
            Ok(pipeline) => {
                entry.next = Some(Arc::new(pipeline));
                self.shader_errors.remove(key);
            }
            Err(error) => report(&mut self.shader_errors, key, error),
        }
    }
}

/// A build at once. When it is dropped, also by a panic, its result is taken over and waiting threads go on.
struct Outcome<'a> {
    pipelines: &'a Pipelines,
    key: &'a Key,
    number: u64,
    built: Option<Result<Pipeline, ShaderError>>,
}

impl Drop for Outcome<'_> {
    fn drop(&mut self) {
        let panicked = || Err(ShaderError::new(self.key.name(), "the shader compiler panicked"));
        let built = self.built.take().unwrap_or_else(panicked);
        self.pipelines.lock().take(self.key, self.number, built);
        self.pipelines.built.notify_all();
    }
}

/// Remembers the error of a pipeline's text, and logs it if it is new.
fn report(shader_errors: &mut FxHashMap<Key, ShaderError>, key: &Key, error: ShaderError) {
    if !shader_errors.values().any(|known| *known == error) {
        tracing::warn!("{error}");
    }
    shader_errors.insert(key.clone(), error);
}
