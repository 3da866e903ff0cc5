//! Pipelines by what they are made of: each is built at its first use and goes when nobody has used it for a while.
//!
//! Where a frame must not wait, they are built on other threads, and whoever asks goes without meanwhile. Where shaders
//! are files that are being worked on, a pipeline whose text has changed is built anew; the old one stays until the new
//! one has been built and bound without an error.
//!
//! Why: `docs/decisions/pipelines-in-background.md`.

use rustc_hash::FxHashMap;

use super::Gpu;
use super::bind::{BindGroups, Bound, Named};
pub use super::build::{Key, Raw};
use super::build::{Pipeline, build, in_scope};
use super::pools::KEEP_FRAMES;
use super::reflection::Variable;
use super::shader::ShaderError;
use super::texts::{Texts, Watch, made_of};
use super::workers::Workers;

/// A variant of a compute shader, whose entry point is `main`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Compute {
    /// Of the shader, and of the pass.
    pub name: &'static str,
    /// What is turned on by `#ifdef`.
    pub definitions: &'static [&'static str],
}

impl From<&'static str> for Compute {
    fn from(name: &'static str) -> Self {
        Self { name, definitions: &[] }
    }
}

/// A render pipeline: its vertex entry point is `vertex`, vertices come from buffers that the shader reads itself.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Draw {
    /// Of the shader, and of the pass.
    pub name: &'static str,
    /// What is turned on by `#ifdef`.
    pub definitions: &'static [&'static str],
    /// The entry point of fragments.
    pub fragment: &'static str,
    /// What it draws on.
    pub colors: [Option<wgpu::ColorTargetState>; 5],
    /// The format of a depth picture that is tested: nearer wins, which is greater.
    pub depth: Option<wgpu::TextureFormat>,
    /// Whether what wins is written to it.
    pub writes_depth: bool,
    /// Triangles or lines.
    pub topology: wgpu::PrimitiveTopology,
}

/// A colour that is replaced.
pub const fn replaced(format: wgpu::TextureFormat) -> Option<wgpu::ColorTargetState> {
    Some(wgpu::ColorTargetState { format, blend: None, write_mask: wgpu::ColorWrites::ALL })
}

/// Where a pipeline is built that is asked for the first time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Builds {
    /// At once: whoever asks waits.
    #[default]
    AtOnce,
    /// On another thread: whoever asks goes without until it is there.
    InBackground,
}

/// What is known of a pipeline.
#[derive(Default)]
struct Entry {
    current: Option<Pipeline>,
    /// What replaces it when it has been bound for the first time.
    next: Option<Pipeline>,
    /// The number of the newest that is being built; 0 if none is.
    building: u64,
    used_in: u64,
}

/// What a worker hands back.
type Built = (Key, u64, Result<Pipeline, ShaderError>);

/// The pipelines.
pub struct Pipelines {
    entries: FxHashMap<Key, Entry>,
    texts: Texts,
    watch: Watch,
    builds: Builds,
    workers: Option<Workers<Built>>,
    /// What is wrong with the newest text of a pipeline.
    troubles: FxHashMap<Key, ShaderError>,
    made: u64,
    built_at_once: u64,
    frame: u64,
}

/// A pipeline and what it binds, ready to run.
#[derive(Clone, Debug)]
pub struct Ready {
    /// Compute or render.
    pub raw: Raw,
    /// Group 0.
    pub bound: Bound,
}

impl Default for Pipelines {
    fn default() -> Self {
        let texts = Texts::of_environment();
        Self {
            entries: FxHashMap::default(),
            watch: Watch::new(&texts),
            texts,
            builds: Builds::default(),
            workers: None,
            troubles: FxHashMap::default(),
            made: 0,
            built_at_once: 0,
            frame: 0,
        }
    }
}

impl Pipelines {
    /// A pipeline with its resources; none while it is being built, or when its shader does not hold ([`troubles`]).
    ///
    /// [`troubles`]: Pipelines::troubles
    pub fn ready(
        &mut self,
        gpu: &Gpu,
        groups: &mut BindGroups,
        key: &Key,
        resources: &[Named],
    ) -> Option<(Ready, &[Variable])> {
        if !self.ask(gpu, key) {
            return None;
        }
        let entry = self.entries.get_mut(key)?;
        let mut bind = |pipeline: &Pipeline| {
            groups.bind(gpu, key.name(), (pipeline.number, &pipeline.layout), &pipeline.variables, resources)
        };
        // A new text may bind what nobody hands, or as something else: then the old pipeline stays.
        if let Some(next) = entry.next.take() {
            match in_scope(gpu, key.name(), || bind(&next)) {
                Ok(_) => entry.current = Some(next),
                Err(error) => report(&mut self.troubles, key, error),
            }
        }
        let pipeline = entry.current.as_ref()?;
        match bind(pipeline) {
            Ok(bound) => Some((Ready { raw: pipeline.raw.clone(), bound }, &pipeline.variables)),
            Err(error) => {
                report(&mut self.troubles, key, error);
                None
            }
        }
    }

    /// Whether a pipeline is there. If not, it is built: at once, or beside.
    pub fn ask(&mut self, gpu: &Gpu, key: &Key) -> bool {
        let frame = self.frame;
        if let Some(entry) = self.entries.get_mut(key) {
            entry.used_in = frame;
            if entry.current.is_some() || entry.next.is_some() || entry.building != 0 {
                return entry.current.is_some() || entry.next.is_some();
            }
        }
        // Asking again changes nothing; another text does.
        if !self.troubles.contains_key(key) {
            self.build(gpu, key);
        }
        self.entries.get(key).is_some_and(|entry| entry.next.is_some())
    }

    fn build(&mut self, gpu: &Gpu, key: &Key) {
        self.made += 1;
        let number = self.made;
        let entry = self.entries.entry(key.clone()).or_default();
        (entry.building, entry.used_in) = (number, self.frame);
        match self.builds {
            Builds::AtOnce => {
                self.built_at_once += 1;
                let built = build(gpu, &self.texts, key, number);
                self.take(key.clone(), number, built);
            }
            Builds::InBackground => {
                let (gpu, texts, key) = (gpu.clone(), self.texts.clone(), key.clone());
                self.workers.get_or_insert_default().start(move || {
                    let built = build(&gpu, &texts, &key, number);
                    (key, number, built)
                });
            }
        }
    }

    fn take(&mut self, key: Key, number: u64, built: Result<Pipeline, ShaderError>) {
        let Some(entry) = self.entries.get_mut(&key).filter(|entry| entry.building == number) else { return };
        entry.building = 0;
        match built {
            Ok(pipeline) => {
                entry.next = Some(pipeline);
                self.troubles.remove(&key);
            }
            Err(error) => report(&mut self.troubles, &key, error),
        }
    }

    /// Takes what was built beside; waits for nothing.
    pub fn take_built(&mut self) {
        while let Some((key, number, built)) = self.workers.as_mut().and_then(Workers::take) {
            self.take(key, number, built);
        }
    }

    /// Whether something is being built beside.
    pub fn is_building(&self) -> bool {
        self.workers.as_ref().is_some_and(|workers| workers.open() > 0)
    }

    /// Where pipelines are built from now on. What is under way is waited for where others are.
    pub fn set_builds(&mut self, gpu: &Gpu, builds: Builds) {
        self.builds = builds;
        if builds == Builds::AtOnce {
            self.workers = None;
            let is_building = |(_, entry): &(&Key, &Entry)| entry.building != 0;
            let keys: Vec<Key> = self.entries.iter().filter(is_building).map(|(key, _)| key.clone()).collect();
            keys.iter().for_each(|key| self.build(gpu, key));
        }
    }

    /// Where pipelines are built.
    pub fn builds(&self) -> Builds {
        self.builds
    }

    /// How many pipelines somebody who asked has waited for.
    pub fn built_at_once(&self) -> u64 {
        self.built_at_once
    }

    /// Other texts from now on; what is made of the old ones stays until [`Pipelines::reload`] finds a change.
    pub fn set_texts(&mut self, texts: Texts) {
        self.watch = Watch::new(&texts);
        self.texts = texts;
    }

    /// Whether texts may change.
    pub fn watches(&self) -> bool {
        self.texts.are_files()
    }

    /// Builds anew what is made of texts that have changed since the last call. How many pipelines that are.
    pub fn reload(&mut self, gpu: &Gpu) -> usize {
        let changed = self.watch.changed(&self.texts);
        if changed.is_empty() {
            return 0;
        }
        let changed = made_of(&self.texts, &changed);
        // What did not hold may have failed by any text.
        let is_changed = |key: &&Key| changed.contains(key.name()) || self.troubles.contains_key(*key);
        let keys: Vec<Key> = self.entries.keys().filter(is_changed).cloned().collect();
        for key in &keys {
            self.build(gpu, key);
        }
        keys.len()
    }

    /// What is wrong with shaders now, each once and in order.
    pub fn troubles(&self) -> Vec<&ShaderError> {
        let mut troubles: Vec<_> = self.troubles.values().collect();
        troubles.sort_by_key(|error| error.to_string());
        troubles.dedup();
        troubles
    }

    /// Drops what was not used in the last frames.
    pub fn end_frame(&mut self) {
        self.frame += 1;
        let frame = self.frame;
        self.entries.retain(|_, entry| entry.used_in + KEEP_FRAMES > frame || entry.building != 0);
        let entries = &self.entries;
        self.troubles.retain(|key, _| entries.contains_key(key));
    }
}

/// Keeps what is wrong with a pipeline's text, and logs it if it was not known.
fn report(troubles: &mut FxHashMap<Key, ShaderError>, key: &Key, error: ShaderError) {
    if !troubles.values().any(|known| *known == error) {
        tracing::warn!("{error}");
    }
    troubles.insert(key.clone(), error);
}
