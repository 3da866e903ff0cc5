//! The run of one style along the path of `hachure bench`: its renderer, its terrain, and its measurements.

use std::time::{Duration, Instant};

use super::against_reference::Flown;
use super::governed::Governed;
use super::pairs::Checks;
use super::passes::TracedPasses;
use super::sweep::Variant;
use crate::frame::{self, FrameCpu, Renderer};
use crate::gpu::cache_counts::CacheCounts;
use crate::gpu::recorder::Submits;
use crate::gpu::timer::{FRAME, PassTime};
use crate::gpu::{Gpu, GpuError};
use crate::measure::exactness::ExactnessTotals;
use crate::measure::report::{Memory, Run};
use crate::measure::statistics::FrameRecord;
use crate::measure::stereo::StereoTotals;
use crate::measure::temporal::{self, DrawnFrame, TemporalTotals};
use crate::measure::work::{BusyGpu, CPU_TILES, CacheUse, FrameWork, GPU_TILES, Start, Untimed};
use crate::measure::{lod_error, memory};
use crate::picture::nearest;
use crate::scene::camera::Camera;
use crate::scene::stereo::{Eyes, Pair};
use crate::scene::view::{Clock, Pose, Rig, View};
use crate::scene::{Light, Scene};
use crate::source::Silent;
use crate::tiles::terrain::{Loading, Prepared, TerrainOptions, TileCounts};
use crate::world::{self, OpenWorld};

/// Frames drawn before the first one that counts: drivers finish pipelines and fill caches on first use.
const WARM_UP_FRAMES: u32 = 3;
/// After the last tiles have arrived, strokes need at most this many frames of the warm-up to settle.
const SETTLING_FRAMES: u32 = 5;
/// Simulated time between two frames of the warm-up.
const WARM_UP_STEP_S: f64 = 10.0;
/// Longest wait for the tiles of the first frame.
const WARM_UP: Duration = Duration::from_secs(10);

/// The run of one style along the path.
pub(super) struct StyleRun {
    pub(super) variant: Variant,
    pub(super) world: OpenWorld,
    /// Bytes allocated on the GPU by this style's world and renderer; the styles share one device.
    gpu_bytes: i64,
    renderer: Renderer,
    /// Passes of the frames that were traced: those of the warm-up, and some that are drawn again after the flight.
    passes: TracedPasses,
    /// Pose and time of the previous frame, in seconds along the path.
    previous: Option<(Pose, f64)>,
    /// Counts before the first frame that counts, and after the last.
    before: Counts,
    after: Counts,
    start: Option<Start>,
    pub(super) untimed: Option<Untimed>,
    pub(super) busy: Option<BusyGpu>,
    failed_tiles: u64,
    /// Start of the first frame that counts; none before it.
    begun: Option<Instant>,
    /// Time spent on checks since then.
    checks: Duration,
    pub(super) records: Vec<FrameRecord>,
    /// The stereo pair, if two eyes are drawn.
    pub(super) pair: Option<Pair>,
    /// The previous frame, if the next one is compared with it; for a stereo pair, its left eye.
    before_it: Option<DrawnFrame>,
    steadiness: TemporalTotals,
    agreement: StereoTotals,
    pub(super) exactness: ExactnessTotals,
    pub(super) flown: Flown,
    /// The governor that chooses the settings in a flight with a budget.
    pub(super) governed: Option<Governed>,
}

/// Counts of a world's tiles and of a renderer's caches.
#[derive(Clone, Copy, Default)]
struct Counts {
    tiles: TileCounts,
    caches: [(&'static str, CacheCounts); 3],
}

/// Measurements of one drawn frame.
pub(super) struct Drawn {
    frame_ms: f64,
    /// GPU time per pass in milliseconds; [`FRAME`] is the whole frame. Empty if the GPU has no timestamp queries.
    gpu_ms: Vec<(String, f64)>,
    prepared: Prepared,
    cpu: FrameCpu,
    wait_ms: f64,
}

/// A frame whose tiles and patches have been chosen.
pub(super) struct BegunFrame {
    rig: Rig,
    prepared: Prepared,
    light: Light,
}

impl StyleRun {
    pub(super) fn new(gpu: &Gpu, variant: Variant, tile_memory_mib: u64, scene: &Scene) -> anyhow::Result<Self> {
        let (lod_error_px, tile_memory_bytes) = (variant.lod_error_px, tile_memory_mib << 20);
        let options =
            TerrainOptions { lod_error_px, tile_memory_bytes, loading: Loading::Stream, ..TerrainOptions::default() };
        let bytes_before = gpu.memory_bytes() as i64;
        let mut renderer = Renderer::new(gpu)?;
        renderer.set_submits(Submits::Timed);
        renderer.set_antialias(variant.antialias);
        // The heights of the store are exaggerated already.
        let tile_error_m = variant.tile_error_m * scene.vertical_exaggeration;
        let heights = world::rounded(world::open_store(scene, &Silent)?, tile_error_m);
        let mut world = OpenWorld::on_gpu(gpu, scene.clone(), heights, options)?;
        world.surfaces.set_tree_detail(variant.tree_detail);
        let style = variant.style.clone().with_features(world.surfaces.has_features_and_graticule());
        let variant = Variant { style, ..variant };
        Ok(Self {
            world,
            gpu_bytes: gpu.memory_bytes() as i64 - bytes_before,
            renderer,
            passes: TracedPasses::default(),
            variant,
            previous: None,
            before: Counts::default(),
            after: Counts::default(),
            start: None,
            untimed: None,
            busy: None,
            failed_tiles: 0,
            begun: None,
            checks: Duration::ZERO,
            records: Vec::new(),
            pair: None,
            before_it: None,
            steadiness: TemporalTotals::default(),
            agreement: StereoTotals::default(),
            exactness: ExactnessTotals::default(),
            flown: Flown::default(),
            governed: None,
        })
    }

    /// Lets a governor choose the settings, from its first one.
    pub(super) fn set_governed(&mut self, governed: Option<Governed>) {
        if let Some(governed) = &governed {
            // Strokes continue when the size changes, and no textures are made.
            self.renderer.set_room(Some(governed.largest_px()));
            self.take_setting(governed.variant().clone());
        }
        self.governed = governed;
    }

    /// Draws the next frames with another setting of the style.
    pub(super) fn take_setting(&mut self, variant: Variant) {
        self.renderer.set_antialias(variant.antialias);
        self.world.surfaces.terrain.set_lod_error_px(variant.lod_error_px);
        self.world.surfaces.set_tree_detail(variant.tree_detail);
        if self.variant.size_px != variant.size_px {
            // Pictures of different sizes cannot be compared.
            self.before_it = None;
        }
        self.variant = variant;
    }

    /// Returns the eyes for a camera's view.
    fn rig(&self, camera: &View) -> Rig {
        self.pair.map_or_else(|| Rig::mono(*camera), |pair| pair.rig(camera))
    }

    /// Returns the distance to the nearest land that a camera sees, in metres; infinite if it sees none.
    pub(super) fn nearest_m(&mut self, gpu: &Gpu, camera: &Camera) -> Result<f64, GpuError> {
        let pose = self.world.pose(camera);
        let found = nearest::nearest_m(gpu, &mut self.renderer, &mut self.world.surfaces, pose, &self.variant.style)?;
        Ok(found.unwrap_or(f64::INFINITY))
    }

    /// Draws a frame and waits for the GPU.
    pub(super) fn draw(&mut self, gpu: &Gpu, camera: &Camera, t_s: f64) -> Result<(Rig, Drawn), GpuError> {
        let pose = self.world.pose(camera);
        let (previous, before_s) = self.previous.replace((pose, t_s)).unwrap_or((pose, t_s));
        let view = View::whole(previous, pose, self.variant.size_px).at(Clock { now_s: t_s, before_s });
        let light = self.world.light();
        let bytes_before = gpu.memory_bytes() as i64;
        let start = Instant::now();
        let rig = self.renderer.jittered(&self.rig(&view), &self.variant.style);
        let prepared = frame::prepare(gpu, &mut self.world.surfaces, &rig, &self.variant.style, &light);
        self.renderer.render_rig(gpu, &self.world.surfaces, &prepared, &rig, &self.variant.style, &light)?;
        let waits = Instant::now();
        gpu.wait();
        let (frame_ms, wait_ms) = (start.elapsed().as_secs_f64() * 1000.0, waits.elapsed().as_secs_f64() * 1000.0);
        gpu.check()?;
        self.gpu_bytes += gpu.memory_bytes() as i64 - bytes_before;
        let times = std::iter::from_fn(|| self.renderer.take_times()).last().unwrap_or_default();
        let gpu_ms = times.into_iter().map(|time| (time.name, time.gpu_ms)).collect();
        Ok((rig, Drawn { frame_ms, gpu_ms, prepared, cpu: self.renderer.cpu(), wait_ms }))
    }

    /// Draws a frame without waiting for the GPU, and returns the milliseconds for tiles and patches.
    pub(super) fn draw_only(&mut self, gpu: &Gpu, camera: &Camera, t_s: f64) -> Result<f64, GpuError> {
        let begun = self.begin_frame(gpu, camera, t_s);
        self.draw_begun(gpu, &begun)?;
        Ok(begun.prepared.prepare_ms)
    }

    /// Chooses the tiles and patches of a frame.
    pub(super) fn begin_frame(&mut self, gpu: &Gpu, camera: &Camera, t_s: f64) -> BegunFrame {
        let pose = self.world.pose(camera);
        let (previous, before_s) = self.previous.replace((pose, t_s)).unwrap_or((pose, t_s));
        let view = View::whole(previous, pose, self.variant.size_px).at(Clock { now_s: t_s, before_s });
        let light = self.world.light();
        self.renderer.set_step_s((t_s - before_s).abs());
        let rig = self.renderer.jittered(&self.rig(&view), &self.variant.style);
        let prepared = frame::prepare(gpu, &mut self.world.surfaces, &rig, &self.variant.style, &light);
        BegunFrame { rig, prepared, light }
    }

    /// Records and submits a frame of [`StyleRun::begin_frame`], also more than once.
    pub(super) fn draw_begun(&mut self, gpu: &Gpu, frame: &BegunFrame) -> Result<(), GpuError> {
        let BegunFrame { rig, prepared, light } = frame;
        self.renderer.render_rig(gpu, &self.world.surfaces, prepared, rig, &self.variant.style, light)
    }

    /// Returns the GPU times of the oldest frame whose times have not been taken, if the GPU has finished it.
    pub(super) fn take_times(&mut self) -> Option<Vec<PassTime>> {
        self.renderer.take_times()
    }

    /// Returns the work that the last frame gave the GPU, and notes its passes; `None` if it was not traced.
    pub(super) fn take_work(&mut self) -> Option<FrameWork> {
        let trace = Some(self.renderer.trace()).filter(|trace| !trace.is_empty());
        let drawing_bytes = self.renderer.drawing_bytes(&self.world.surfaces);
        trace.map(|trace| self.passes.take(trace, drawing_bytes))
    }

    pub(super) fn set_traces(&mut self, traces: bool) {
        self.renderer.set_traces(traces);
    }

    pub(super) fn set_submits(&mut self, submits: Submits) {
        self.renderer.set_submits(submits);
    }

    /// Returns the processor's time for the last frame.
    pub(super) fn cpu(&self) -> FrameCpu {
        self.renderer.cpu()
    }

    /// Draws frames that do not count, until the tiles of the first frame have been loaded, and notes their passes.
    pub(super) fn warm_up(&mut self, gpu: &Gpu, camera: &Camera, t_s: f64) -> Result<(), GpuError> {
        // The first frame is timed.
        let (_, drawn) = self.draw(gpu, camera, t_s)?;
        let (pipelines, compile_ms) = self.renderer.compiled();
        self.start = Some(Start { pipelines, compile_ms, frame_ms: drawn.frame_ms });
        self.renderer.set_traces(true);
        self.settle(gpu, camera, t_s, WARM_UP)?;
        self.renderer.set_traces(false);
        self.before = self.counts();
        Ok(())
    }

    /// Draws a view until its tiles have been loaded and its strokes have settled. Returns whether the tiles have been
    /// loaded within the time `most`.
    pub(super) fn settle(&mut self, gpu: &Gpu, camera: &Camera, t_s: f64, most: Duration) -> Result<bool, GpuError> {
        let start = Instant::now();
        self.renderer.set_step_s(WARM_UP_STEP_S);
        // Strokes may be older than the tiles, and fade in and out over several frames.
        let mut updates = self.variant.style.strokes().map_or(0, |strokes| strokes.update_every.max(SETTLING_FRAMES));
        for frame in 1.. {
            let (_, drawn) = self.draw(gpu, camera, t_s)?;
            self.take_work();
            let is_settled = !drawn.prepared.tiles.late || start.elapsed() > most;
            if frame >= WARM_UP_FRAMES && is_settled {
                if updates == 0 {
                    return Ok(!drawn.prepared.tiles.late);
                }
                updates -= 1;
            }
        }
        unreachable!("the frames have no end")
    }

    /// Forgets the last frame: the next one continues nothing.
    pub(super) fn forget(&mut self) {
        self.renderer.forget();
        self.previous = None;
    }

    /// Returns the renderer, which has the pictures of the last frame.
    pub(super) fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    fn counts(&self) -> Counts {
        Counts { tiles: self.world.surfaces.terrain.tile_counts(), caches: self.renderer.cache_counts() }
    }

    /// Ends the frames that count.
    pub(super) fn end_flight(&mut self) {
        self.after = self.counts();
    }

    /// Returns the seconds since the first frame that counts, without the time for checks.
    pub(super) fn wall_s(&mut self) -> f64 {
        (self.begun.get_or_insert_with(Instant::now).elapsed() - self.checks).as_secs_f64()
    }

    /// Draws a frame that counts, and checks it.
    pub(super) fn fly(&mut self, gpu: &Gpu, camera: &Camera, t_s: f64, checks: Checks) -> anyhow::Result<()> {
        self.wall_s();
        if let Some(last) = self.records.last() {
            self.renderer.set_step_s(t_s - last.t_s);
        }
        let (rig, drawn) = self.draw(gpu, camera, t_s)?;
        let wall_s = self.wall_s();
        let is_software = gpu.is_software();
        let mut record = self.record(t_s, wall_s, is_software, drawn);
        let start = Instant::now();
        let is_pair = checks.begins_pair || self.before_it.is_some();
        record.strokes_left_out = temporal::strokes_left_out(gpu, &self.renderer, &self.variant.style)?;
        if checks.lod_error {
            let terrain = &self.world.surfaces.terrain;
            record.lod_error_px =
                lod_error::largest_px(gpu, &self.renderer, &rig.eyes[0], terrain, record.frame as u32)?;
        }
        if checks.lod_error || is_pair {
            record.strokes = temporal::count_strokes(gpu, &self.renderer, &self.variant.style)?;
        }
        if is_pair {
            self.compare(gpu, &rig, record.jumped == Some(true), checks.begins_pair)?;
        }
        self.checks += start.elapsed();
        self.records.push(record);
        Ok(())
    }

    /// Compares the frame with the previous one if that began a pair, and stores it if it begins a pair itself.
    fn compare(&mut self, gpu: &Gpu, rig: &Rig, jumped: bool, begins_pair: bool) -> anyhow::Result<()> {
        let drawn = temporal::read_drawn(gpu, &self.renderer, rig, 0, &self.variant.style)?;
        if begins_pair && rig.eyes.len() > 1 {
            self.agreement.add(&drawn, &temporal::read_drawn(gpu, &self.renderer, rig, 1, &self.variant.style)?)?;
        }
        // After a jump, steadiness has no meaning.
        if let Some(before) = self.before_it.take().filter(|_| !jumped) {
            self.steadiness.add(temporal::compare(&before, &drawn)?);
        }
        self.before_it = begins_pair.then_some(drawn);
        Ok(())
    }

    fn record(&mut self, t_s: f64, wall_s: f64, is_software: bool, drawn: Drawn) -> FrameRecord {
        let Drawn { frame_ms, gpu_ms, prepared, cpu, wait_ms } = drawn;
        let Prepared { selection, tiles, prepare_ms, jumped, detail } = prepared;
        self.failed_tiles = self.failed_tiles.max(tiles.failed);
        let (whole, passes): (Vec<_>, Vec<_>) = gpu_ms.into_iter().partition(|(name, _)| name == FRAME);
        FrameRecord {
            frame: self.records.len() as u64,
            t_s,
            frame_ms: Some(frame_ms),
            gpu_ms: whole.first().map(|(_, gpu_ms)| *gpu_ms),
            pass_gpu_ms: passes,
            lod_error_px: None,
            triangles: Some(selection.triangles()),
            strokes: None,
            strokes_left_out: None,
            tiles_loaded: Some(tiles.loaded),
            late: Some(tiles.late),
            allowed_error_px: Some(detail.error_px),
            over_budget: Some(detail.is_over_budget),
            memory_factor: Some(detail.memory_factor),
            prepare_ms: Some(prepare_ms),
            jumped: Some(jumped),
            wall_s: Some(wall_s),
            record_ms: Some(cpu.record_ms),
            // Passes that are submitted and waited for one by one have no such times.
            submit_ms: (!is_software).then_some(cpu.submit_ms),
            wait_ms: (!is_software).then_some(wait_ms),
            work: None,
        }
    }

    pub(super) fn run(&self, eyes: Eyes) -> Run {
        let mut run = Run::of_frames(&self.variant.style.name, &eyes.to_string(), &self.records);
        self.passes.fill(&mut run);
        run.antialias = self.renderer.antialias().to_string();
        run.start = self.start;
        run.untimed = self.untimed;
        run.busy = self.busy.clone();
        let used = |((name, after), (_, before)): ((&'static str, CacheCounts), (_, CacheCounts))| {
            let CacheCounts { hits, misses } = after.since(before);
            (name.to_owned(), CacheUse { hits, misses })
        };
        run.caches = self.after.caches.into_iter().zip(self.before.caches).map(used).collect();
        let (before, counts) = (self.before.tiles, self.after.tiles);
        let (hits, misses) = (counts.gpu_hits - before.gpu_hits, counts.gpu_misses - before.gpu_misses);
        run.caches.insert(GPU_TILES.to_owned(), CacheUse { hits, misses });
        let (uploaded, read) = (counts.uploaded - before.uploaded, counts.read - before.read);
        run.caches.insert(CPU_TILES.to_owned(), CacheUse { hits: uploaded.saturating_sub(read), misses: read });
        run.temporal = self.steadiness.metrics();
        run.stereo = self.agreement.metrics();
        run.flight_bytes = self.flown.mean_bytes();
        run.setting.clone_from(&self.variant.setting);
        run.exactness = self.exactness.metrics();
        run.governed = self.governed.as_ref().map(Governed::run);
        run.memory = Memory {
            gpu_bytes: Some(self.gpu_bytes.max(0) as u64),
            gpu_tile_bytes: Some(counts.gpu_bytes),
            cpu_tile_bytes: Some(counts.cache_bytes),
            rss_bytes: memory::rss_bytes(),
            ..run.memory
        };
        run.tiles.loaded = Some(self.records.iter().filter_map(|record| record.tiles_loaded).sum());
        run.tiles.evicted = Some(counts.evicted - before.evicted);
        run.tiles.cancelled = Some(counts.cancelled - before.cancelled);
        run.tiles.failed = Some(self.failed_tiles);
        run
    }
}
