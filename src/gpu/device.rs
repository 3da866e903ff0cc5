//! Opens a GPU: adapter, device and queue.

use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use super::cache::Cache;
use super::pipelines::Pipelines;
use super::shader::ShaderError;
use super::stored_pipelines::StoredPipelines;
use crate::file::message::quoted;

/// An error of the GPU or of its driver.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// No adapter matches the request.
    #[error(
        "no Vulkan, Metal or DirectX 12 adapter matches {wish}; available: {found}{}",
        if found == "none" { " (Mesa's software driver is enough: mesa-vulkan-drivers on Debian)" } else { "" }
    )]
    NoAdapter {
        /// The request as words for the message, for example `--adapter software`.
        wish: String,
        /// The names of all adapters, or `none`.
        found: String,
    },
    /// The adapter opens no device.
    #[error("cannot open the GPU {adapter}: {source}")]
    NoDevice {
        /// Name of the adapter.
        adapter: String,
        #[source]
        source: wgpu::RequestDeviceError,
    },
    /// A picture or buffer is larger than the device allows.
    #[error("{what} would be {wanted}, but this GPU allows at most {limit}")]
    Limit {
        /// The size that is too large, with its unit.
        what: &'static str,
        /// The requested value.
        wanted: u64,
        /// The largest value that the device allows.
        limit: u64,
    },
    /// Reading a picture or buffer back failed.
    #[error("reading from the GPU failed: {0}")]
    Readback(String),
    /// wgpu reported a validation error, lack of memory, or a lost device.
    #[error("the GPU reported: {0}")]
    Device(String),
    /// A shader does not compile, for example one that is being edited.
    #[error(transparent)]
    Shader(#[from] ShaderError),
}

/// An open device with its pipelines, which all renderers of the device share. A clone refers to the same device.
#[derive(Clone)]
pub struct Gpu {
    /// Creates window surfaces.
    pub instance: wgpu::Instance,
    /// Reports names, limits, and what surfaces support.
    pub adapter: wgpu::Adapter,
    /// Creates buffers, textures and pipelines.
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    /// The errors that wgpu has reported since the last [`check`](Self::check).
    errors: Arc<Mutex<Vec<String>>>,
    /// Count of GPU objects that [`objects_made`](Self::objects_made) returns.
    objects: Arc<AtomicU64>,
    pipelines: Arc<Pipelines>,
    cache: Arc<Cache>,
    /// Pipelines of earlier runs, once [`store_pipelines`](Self::store_pipelines) has named a folder.
    stored: Arc<OnceLock<StoredPipelines>>,
}

/// A request for an adapter, as `--adapter` makes it.
#[derive(Clone, Debug, Default)]
pub enum AdapterWish {
    /// The adapter with the highest performance.
    #[default]
    Best,
    /// A software driver.
    Software,
    /// The first adapter whose name contains this text, in any case.
    Name(String),
}

impl std::str::FromStr for AdapterWish {
    type Err = std::convert::Infallible;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(match text {
            "best" => Self::Best,
            "software" => Self::Software,
            name => Self::Name(name.to_owned()),
        })
    }
}

/// The instance of all devices that are opened without a window. It is never dropped: with the last instance of a
/// process the Vulkan loader unloads the driver, while other threads may be opening a device or ending.
static INSTANCE: OnceLock<wgpu::Instance> = OnceLock::new();

/// Held while adapters are listed and a device is opened: one thread at a time. Two devices that two threads opened at
/// once ended a process on a machine with an NVIDIA GPU (`docs/decisions/gpu-drivers.md`).
static OPENING: Mutex<()> = Mutex::new(());

impl Gpu {
    /// Opens a device without a window.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`], [`GpuError::NoDevice`].
    pub fn open(wish: &AdapterWish) -> Result<Self, GpuError> {
        Self::open_with(INSTANCE.get_or_init(|| wgpu::Instance::new(instance_descriptor())).clone(), wish, None)
    }

    /// Opens a device with exactly `limits`, without features and in strict compliance with WebGPU. With
    /// [`wgpu::Limits::default`], work that succeeds on it succeeds on every WebGPU device.
    ///
    /// # Errors
    /// The errors of [`Gpu::open`]; [`GpuError::NoDevice`] also if the adapter has lower limits.
    #[cfg(test)]
    pub(crate) fn open_within(wish: &AdapterWish, limits: wgpu::Limits) -> Result<Self, GpuError> {
        let mut descriptor = instance_descriptor();
        descriptor.flags |= wgpu::InstanceFlags::STRICT_WEBGPU_COMPLIANCE;
        let instance = wgpu::Instance::new(descriptor);
        let adapter = choose_adapter(&instance, wish, None)?;
        Self::of(instance, adapter, wgpu::Features::empty(), limits)
    }

    /// Opens a device that can present to `surface`.
    ///
    /// # Errors
    /// The errors of [`Gpu::open`].
    pub fn open_with(
        instance: wgpu::Instance,
        wish: &AdapterWish,
        surface: Option<&wgpu::Surface>,
    ) -> Result<Self, GpuError> {
        let _opening = OPENING.lock().unwrap_or_else(PoisonError::into_inner);
        let adapter = choose_adapter(&instance, wish, surface)?;
        let wanted = wgpu_profiler::GpuProfiler::ALL_WGPU_TIMER_FEATURES
            | wgpu::Features::PIPELINE_CACHE
            | wgpu::Features::SHADER_EARLY_DEPTH_TEST;
        let features = adapter.features() & wanted;
        let limits = adapter.limits();
        Self::of(instance, adapter, features, limits)
    }

    fn of(
        instance: wgpu::Instance,
        adapter: wgpu::Adapter,
        required_features: wgpu::Features,
        required_limits: wgpu::Limits,
    ) -> Result<Self, GpuError> {
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("hachure"),
            required_features,
            required_limits,
            ..Default::default()
        }))
        .map_err(|source| GpuError::NoDevice { adapter: adapter.get_info().name, source })?;
        Ok(Self::of_device(instance, adapter, device, queue))
    }

    /// Wraps a device that was opened elsewhere, such as by the runtime of a headset.
    pub fn of_device(
        instance: wgpu::Instance,
        adapter: wgpu::Adapter,
        device: wgpu::Device,
        queue: wgpu::Queue,
    ) -> Self {
        let errors = Arc::new(Mutex::new(Vec::new()));
        let sink = Arc::clone(&errors);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            // `check` returns the first of them, in one line.
            tracing::debug!("{error}");
            if let Ok(mut list) = sink.lock() {
                list.push(error.to_string());
            }
        }));
        Self {
            instance,
            adapter,
            device,
            queue,
            errors,
            objects: Arc::default(),
            pipelines: Arc::default(),
            cache: Arc::default(),
            stored: Arc::default(),
        }
    }

    /// Returns the pipelines of the device.
    pub(crate) fn pipelines(&self) -> &Pipelines {
        &self.pipelines
    }

    /// Reads compiled pipelines of earlier runs from a folder, and writes those of this run there when the device is
    /// dropped. Does nothing if the driver cannot store pipelines, or if it is a software driver, which stores them by
    /// itself. Pipelines that have been compiled before are not stored.
    pub fn store_pipelines(&self, folder: &Path) {
        let info = self.adapter.get_info();
        if info.device_type == wgpu::DeviceType::Cpu {
            return;
        }
        if let Some(stored) = StoredPipelines::open(&self.device, &info, folder) {
            // A second call has no effect.
            let _ = self.stored.set(stored);
        }
    }

    /// Returns the cache for the descriptor of a pipeline.
    pub(super) fn stored_pipelines(&self) -> Option<&wgpu::PipelineCache> {
        self.stored.get().map(StoredPipelines::cache)
    }

    /// Returns the values that renderers of the device share.
    pub(crate) fn cache(&self) -> &Cache {
        &self.cache
    }

    /// Returns the same device with pipelines and a cache of its own, for a job in the background: the original
    /// pipelines and cache own the threads on which such jobs run.
    pub(super) fn for_background(&self) -> Self {
        Self { pipelines: Arc::default(), cache: Arc::default(), ..self.clone() }
    }

    /// Returns whether the driver draws on the CPU.
    pub(crate) fn is_software(&self) -> bool {
        self.adapter.get_info().device_type == wgpu::DeviceType::Cpu
    }

    /// Returns the name of the adapter, its backend, and its driver with the version, for reports.
    pub fn description(&self) -> String {
        let info = self.adapter.get_info();
        format!("{} ({:?}, {} {})", info.name, info.backend, info.driver, info.driver_info)
    }

    /// Checks whether wgpu has reported an error since the last call: validation, or out of memory.
    ///
    /// # Errors
    /// [`GpuError::Device`] with the first error.
    pub fn check(&self) -> Result<(), GpuError> {
        match self.errors.lock() {
            Ok(mut list) if !list.is_empty() => {
                let first = list.swap_remove(0);
                list.clear();
                Err(GpuError::Device(first.split_whitespace().collect::<Vec<_>>().join(" ")))
            }
            _ => Ok(()),
        }
    }

    /// Returns the memory of all buffers and textures on the device, in bytes as allocated.
    pub fn memory_bytes(&self) -> u64 {
        let counters = self.device.get_internal_counters().hal;
        [counters.buffer_memory, counters.texture_memory].iter().map(|bytes| bytes.read().max(0) as u64).sum()
    }

    /// Counts a buffer, texture, bind group or pipeline that a frame had to create.
    pub(crate) fn count_object(&self) {
        self.objects.fetch_add(1, Ordering::Relaxed);
    }

    /// Returns how many buffers, textures, bind groups and pipelines frames have created so far. A frame that needs the
    /// same as the one before creates none.
    #[cfg(test)]
    pub(crate) fn objects_made(&self) -> u64 {
        self.objects.load(Ordering::Relaxed)
    }

    /// Waits until a submit and all earlier ones are done.
    pub(crate) fn wait_for(&self, submission_index: wgpu::SubmissionIndex) {
        // As in `wait`.
        let _ = self.device.poll(wgpu::PollType::Wait { submission_index: Some(submission_index), timeout: None });
    }

    /// Waits until all submitted work is done.
    pub fn wait(&self) {
        // `check` reports a lost device; nothing else can be done about it here.
        let _ = self.device.poll(wgpu::PollType::wait_indefinitely());
    }
}

/// Returns the description of an instance with Vulkan, Metal and DirectX 12, unless `WGPU_BACKEND` names others. OpenGL
/// lacks features that the passes need, and its libraries write to the terminal if there is no display.
pub(crate) fn instance_descriptor() -> wgpu::InstanceDescriptor {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    if std::env::var_os("WGPU_BACKEND").is_none() {
        descriptor.backends = wgpu::Backends::PRIMARY;
    }
    // Before each indirect dispatch wgpu would run a dispatch of one thread, with two barriers, that compares the
    // numbers of workgroups with the device's limit. Our shaders compute them, and keep below WebGPU's least limit
    // (`shaders/shared/dispatch.wgsl`). DirectX 12 needs the dispatch: shaders get `num_workgroups` from it.
    if cfg!(not(windows)) && std::env::var_os("WGPU_VALIDATION_INDIRECT_CALL").is_none() {
        descriptor.flags.remove(wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL);
    }
    descriptor
}

fn choose_adapter(
    instance: &wgpu::Instance,
    wish: &AdapterWish,
    surface: Option<&wgpu::Surface>,
) -> Result<wgpu::Adapter, GpuError> {
    if matches!(wish, AdapterWish::Best) {
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            compatible_surface: surface,
            ..Default::default()
        };
        if let Ok(adapter) = pollster::block_on(instance.request_adapter(&options)) {
            return Ok(adapter);
        }
    }
    let all = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
    let found = all.iter().map(|adapter| adapter.get_info().name).collect::<Vec<_>>().join(", ");
    all.into_iter()
        .filter(|adapter| surface.is_none_or(|surface| adapter.is_surface_supported(surface)))
        .find(|adapter| {
            let info = adapter.get_info();
            match wish {
                AdapterWish::Best => true,
                AdapterWish::Software => info.device_type == wgpu::DeviceType::Cpu,
                AdapterWish::Name(name) => info.name.to_lowercase().contains(&name.to_lowercase()),
            }
        })
        .ok_or_else(|| GpuError::NoAdapter {
            wish: match wish {
                AdapterWish::Best => "--adapter best".to_owned(),
                AdapterWish::Software => "--adapter software".to_owned(),
                AdapterWish::Name(name) => format!("--adapter {}", quoted(name)),
            },
            found: if found.is_empty() { "none".to_owned() } else { found },
        })
}
