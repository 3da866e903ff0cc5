//! `hachure bench`: flies a camera path without a window and reports what each style costs.
//!
//! Each style has a frame and a terrain of its own, so that each loads the tiles that it would load alone. The styles
//! take turns at every frame, and the turn's order moves on with it: what the machine does meanwhile (clocks, heat,
//! the disk's cache) falls on all of them alike, and ratios between them are fair.
//!
//! What strokes found no room is counted in every frame, after its times have been taken. Some frames are looked at
//! more closely then: how far the terrain is from the data, how many strokes there are, and how steady the drawing is
//! from that frame to the next ([`temporal`]).

mod pairs;
mod passes;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::Context;
use clap::Args;

use self::pairs::{Checks, PairPlan};
use self::passes::TracedPasses;
use super::arguments;
use super::height_args::HeightArgs;
use super::progress::Bar;
use super::render::parse_size;
use super::{inputs, print, print_json};
use crate::file::message::named;
use crate::frame::Frame;
use crate::gpu::device::AdapterWish;
use crate::gpu::timer::FRAME;
use crate::gpu::{Gpu, GpuError};
use crate::measure::report::{Memory, Report, Run, WorldSize};
use crate::measure::report_html::write_html;
use crate::measure::statistics::{FrameRecord, RunFrames, write_frames_csv};
use crate::measure::temporal::{self, DrawnFrame, TemporalTotals};
use crate::measure::{lod_error, memory, report_text};
use crate::scene::Scene;
use crate::scene::camera::Camera;
use crate::scene::path::CameraPath;
use crate::scene::reach::Reach;
use crate::scene::view::{Pose, View};
use crate::source::{Progress, Silent};
use crate::style::Style;
use crate::tiles::terrain::{Loading, Prepared, TerrainOptions, TileCounts};
use crate::world::{self, OpenWorld};

/// Frames drawn before the first that counts: drivers finish pipelines and fill caches when they are first used.
const WARM_UP_FRAMES: u32 = 3;
/// After the last tiles came, strokes grow for no longer than this, if time runs quickly.
const SETTLING_FRAMES: u32 = 5;
/// From one frame of the warm-up to the next.
const WARM_UP_STEP_S: f64 = 10.0;
/// The longest wait for the tiles of the first frame.
const WARM_UP: Duration = Duration::from_secs(10);
/// Of a run's frames, so many at most are compared with the full-resolution heights.
const CHECKED_FRAMES: usize = 32;
/// Frames per second along the path where no number of frames is given.
const FPS: f64 = 30.0;

/// What is written.
const FILES: [&str; 3] = ["frames.csv", "report.html", "report.json"];

/// Arguments of `bench`.
#[derive(Debug, Args)]
pub struct BenchArgs {
    /// Scene file, DEM, baked pyramid, or a scene inside hachure (continent, hut); without one, the embedded world
    pub world: Option<String>,
    /// What height files leave open.
    #[command(flatten)]
    pub heights: HeightArgs,
    /// Let a scene file name files outside of its folder, and addresses
    #[arg(long)]
    pub trust_scene: bool,
    /// Camera path: CSV with the header t,x,y,z,yaw,pitch,fov, or one inside hachure (tour, valley, teleport)
    #[arg(long)]
    pub path: PathBuf,
    /// Presets or style files; ratios are to the first
    #[arg(long, value_delimiter = ',', default_value = "ink")]
    pub styles: Vec<String>,
    /// Spread so many frames over the path; without it, 30 for each second
    #[arg(long, value_parser = arguments::whole::<u32>(1, 1_000_000))]
    pub frames: Option<u32>,
    /// Width and height in pixels, like 1280x720
    #[arg(long, default_value = "1280x720", value_parser = parse_size)]
    pub size: [u32; 2],
    /// How many eyes: mono
    #[arg(long, default_value = "mono", value_parser = super::parse_eyes)]
    pub eyes: String,
    /// Height error that may be seen, in pixels
    #[arg(long, default_value_t = 1.0, value_parser = arguments::above_0, allow_hyphen_values = true)]
    pub lod_error: f64,
    /// Let the camera follow the clock on the wall: as many frames as there is time for, one style after the other
    #[arg(long, conflicts_with = "frames")]
    pub real_time: bool,
    /// Memory for tiles on the GPU, and as much for tiles in memory, in MiB, for each style
    #[arg(long, default_value_t = 512, value_parser = arguments::whole::<u64>(1, 1 << 20))]
    pub tile_memory: u64,
    /// Measure steadiness on so many pairs of consecutive frames, spread over the path; 0 measures none
    #[arg(long, value_name = "PAIRS", default_value_t = 24, value_parser = arguments::whole::<u32>(0, 1_000_000))]
    pub temporal: u32,
    /// Folder for report.json, frames.csv and report.html
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Print report.json rather than a table
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
///
/// # Errors
/// When an input does not hold, the GPU fails, or the folder cannot be written.
pub fn run(args: &BenchArgs, adapter: &AdapterWish) -> anyhow::Result<()> {
    let styles = args.styles.iter().map(|name| arguments::style(name)).collect::<Result<Vec<_>, _>>()?;
    arguments::check_world(args.world.as_deref())?;
    // Its mistakes are told before a world is baked; its ground comes with the world. Read once: it may be a pipe.
    let path_text = CameraPath::read_text(&args.path)?;
    CameraPath::parse_on_ground(&args.path, path_text.as_bytes(), |_, _| 0.0)?;
    let scene = world::scene_of(args.world.as_deref(), Reach::trusting(args.trust_scene))?;
    let scene = args.heights.over(scene);
    let inputs = inputs::of(args.world.as_deref(), &scene, &styles, Some(&args.path));
    FILES.iter().try_for_each(|name| inputs.check(&args.output.join(name)))?;
    std::fs::create_dir_all(&args.output).with_context(|| format!("cannot create {}", named(&args.output)))?;
    // Baked once, where it is not yet; then each style opens its own.
    drop(world::open_store(&scene, &Bar::default())?);
    let gpu = Gpu::open(adapter)?;
    let runs = styles.into_iter().map(|style| StyleRun::new(&gpu, args, &scene, style));
    let mut runs = runs.collect::<anyhow::Result<Vec<_>>>()?;
    let path = CameraPath::parse_on_ground(&args.path, path_text.as_bytes(), |x, y| runs[0].world.ground_m(x, y))?;
    runs[0].world.ground_was_read()?;
    fly(&gpu, &path, args, &mut runs)?;

    let report = Report {
        adapter: gpu.description(),
        size: args.size,
        world: world_size(&runs[0].world),
        runs: runs.iter().map(|run| run.run(&args.eyes)).collect(),
    };
    let frames: Vec<RunFrames> = runs
        .into_iter()
        .map(|run| RunFrames { style: run.style.name, eyes: args.eyes.clone(), frames: run.records })
        .collect();
    let [frames_csv, page, json] = FILES.map(|name| args.output.join(name));
    write_frames_csv(&frames_csv, &frames)?;
    write_html(&page, &report, &frames)?;
    report.write_json(&json)?;
    if args.json {
        return print_json(&report);
    }
    let [width, height] = report.size;
    print(&format!("{}, {width}x{height}\n{}{}", report.adapter, report_text::table(&report), named(page)))
}

fn world_size(world: &OpenWorld) -> WorldSize {
    let finest = world.surfaces.terrain.store().levels()[0];
    WorldSize { samples: Some(u64::from(finest.width) * u64::from(finest.height)), extent_m: world.extent_m() }
}

fn fly(gpu: &Gpu, path: &CameraPath, args: &BenchArgs, runs: &mut [StyleRun]) -> anyhow::Result<()> {
    let bar = Bar::default();
    bar.report("warming up", 0.0);
    let first = path.sample(path.times_s()[0]);
    for run in runs.iter_mut() {
        run.warm_up(gpu, args.size, &first)?;
    }
    if args.real_time {
        fly_by_the_clock(gpu, path, args, runs, &bar)
    } else {
        fly_by_frames(gpu, path, args, runs, &bar)
    }
}

/// Every style draws the same frames, in turns.
fn fly_by_frames(
    gpu: &Gpu,
    path: &CameraPath,
    args: &BenchArgs,
    runs: &mut [StyleRun],
    bar: &Bar,
) -> anyhow::Result<()> {
    let frames = args.frames.map_or_else(|| path.frame_count(FPS), |frames| frames as usize);
    let step_s = match args.frames {
        // As `CameraPath::spread` has them: the first and the last row included.
        Some(frames) => path.duration_s() / f64::from(frames.saturating_sub(1).max(1)),
        None => 1.0 / FPS,
    };
    let start_s = path.times_s()[0];
    let between_checks = frames.div_ceil(CHECKED_FRAMES);
    let pairs = PairPlan::new(frames, args.temporal);
    for frame in 0..frames {
        bar.report("flying", frame as f32 / frames as f32);
        let t_s = start_s + frame as f64 * step_s;
        let camera = path.sample(t_s);
        for turn in 0..runs.len() {
            let run = &mut runs[(frame + turn) % runs.len()];
            let checks = Checks { lod_error: frame % between_checks == 0, begins_pair: pairs.begins_at(frame) };
            run.fly(gpu, args.size, &camera, t_s, checks)?;
        }
    }
    Ok(())
}

/// Every style draws what it can in the time of the path. The clock stands while a frame is checked.
fn fly_by_the_clock(
    gpu: &Gpu,
    path: &CameraPath,
    args: &BenchArgs,
    runs: &mut [StyleRun],
    bar: &Bar,
) -> anyhow::Result<()> {
    let (start_s, duration_s) = (path.times_s()[0], path.duration_s());
    let between_checks_s = duration_s / CHECKED_FRAMES as f64;
    let between_pairs_s = duration_s / f64::from(args.temporal);
    for run in runs {
        // No pairs: the first would come after infinite time.
        let (mut next_check_s, mut next_pair_s) = (0.0, if args.temporal > 0 { 0.0 } else { f64::INFINITY });
        loop {
            let now_s = run.wall_s();
            if now_s >= duration_s {
                break;
            }
            bar.report("flying", (now_s / duration_s) as f32);
            let checks = Checks { lod_error: now_s >= next_check_s, begins_pair: now_s >= next_pair_s };
            next_check_s += if checks.lod_error { between_checks_s } else { 0.0 };
            next_pair_s += if checks.begins_pair { between_pairs_s } else { 0.0 };
            run.fly(gpu, args.size, &path.sample(start_s + now_s), start_s + now_s, checks)?;
        }
    }
    Ok(())
}

/// A style on its way along the path.
struct StyleRun {
    style: Style,
    world: OpenWorld,
    /// What this style's world and frames have allocated on the GPU: styles take turns on one device.
    gpu_bytes: i64,
    frame: Frame,
    /// Of the frames before those that count.
    passes: TracedPasses,
    previous: Option<Pose>,
    before: TileCounts,
    failed_tiles: u64,
    /// When the first frame that counts began; none before.
    begun: Option<Instant>,
    /// What checks took since then.
    checks: Duration,
    records: Vec<FrameRecord>,
    /// The frame before, where the next one is compared with it.
    pair: Option<DrawnFrame>,
    steadiness: TemporalTotals,
}

/// A frame that was drawn.
struct Drawn {
    frame_ms: f64,
    /// [`FRAME`] is the whole; empty where the GPU has no timers.
    gpu_ms: Vec<(String, f64)>,
    prepared: Prepared,
}

impl StyleRun {
    fn new(gpu: &Gpu, args: &BenchArgs, scene: &Scene, style: Style) -> anyhow::Result<Self> {
        let (lod_error_px, tile_memory_bytes) = (args.lod_error, args.tile_memory << 20);
        let options =
            TerrainOptions { lod_error_px, tile_memory_bytes, loading: Loading::Stream, ..TerrainOptions::default() };
        let bytes_before = gpu.memory_bytes() as i64;
        let world = OpenWorld::on_gpu(gpu, scene.clone(), world::open_store(scene, &Silent)?, options)?;
        Ok(Self {
            world,
            gpu_bytes: gpu.memory_bytes() as i64 - bytes_before,
            frame: Frame::new(gpu)?,
            passes: TracedPasses::default(),
            style,
            previous: None,
            before: TileCounts::default(),
            failed_tiles: 0,
            begun: None,
            checks: Duration::ZERO,
            records: Vec::new(),
            pair: None,
            steadiness: TemporalTotals::default(),
        })
    }

    /// Draws a frame and waits for the GPU.
    fn draw(&mut self, gpu: &Gpu, size_px: [u32; 2], camera: &Camera) -> Result<(View, Drawn), GpuError> {
        let pose = self.world.pose(camera);
        let previous = self.previous.replace(pose).unwrap_or(pose);
        let view = View::whole(previous, pose, size_px);
        let light = self.world.light();
        let bytes_before = gpu.memory_bytes() as i64;
        let start = Instant::now();
        let prepared = self.frame.render(gpu, &mut self.world.surfaces, &view, &self.style, &light)?;
        gpu.wait();
        let frame_ms = start.elapsed().as_secs_f64() * 1000.0;
        gpu.check()?;
        self.gpu_bytes += gpu.memory_bytes() as i64 - bytes_before;
        let times = std::iter::from_fn(|| self.frame.take_times()).last().unwrap_or_default();
        let gpu_ms = times.into_iter().map(|time| (time.name, time.gpu_ms)).collect();
        Ok((view, Drawn { frame_ms, gpu_ms, prepared }))
    }

    /// Draws a few frames that do not count, until the tiles of the first are there.
    fn warm_up(&mut self, gpu: &Gpu, size_px: [u32; 2], camera: &Camera) -> Result<(), GpuError> {
        let start = Instant::now();
        self.frame.set_step_s(WARM_UP_STEP_S);
        self.frame.set_traces(true);
        // Strokes may be older than the tiles, and take their time to come and go.
        let mut updates = self.style.strokes.as_ref().map_or(0, |strokes| strokes.update_every.max(SETTLING_FRAMES));
        for frame in 1.. {
            let (_, drawn) = self.draw(gpu, size_px, camera)?;
            self.passes.take(self.frame.trace());
            let is_settled = !drawn.prepared.tiles.late || start.elapsed() > WARM_UP;
            if frame >= WARM_UP_FRAMES && is_settled {
                if updates == 0 {
                    break;
                }
                updates -= 1;
            }
        }
        self.frame.set_traces(false);
        self.before = self.world.surfaces.terrain.tile_counts();
        Ok(())
    }

    /// Seconds since the first frame that counts, without checks.
    fn wall_s(&mut self) -> f64 {
        (self.begun.get_or_insert_with(Instant::now).elapsed() - self.checks).as_secs_f64()
    }

    /// Draws a frame that counts.
    fn fly(&mut self, gpu: &Gpu, size_px: [u32; 2], camera: &Camera, t_s: f64, checks: Checks) -> anyhow::Result<()> {
        self.wall_s();
        if let Some(last) = self.records.last() {
            self.frame.set_step_s(t_s - last.t_s);
        }
        let (view, drawn) = self.draw(gpu, size_px, camera)?;
        let wall_s = self.wall_s();
        let mut record = self.record(t_s, wall_s, drawn);
        let start = Instant::now();
        let is_pair = checks.begins_pair || self.pair.is_some();
        record.strokes_left_out = temporal::strokes_left_out(gpu, &self.frame, &self.style)?;
        if checks.lod_error {
            let terrain = &self.world.surfaces.terrain;
            record.lod_error_px = lod_error::largest_px(gpu, &self.frame, &view, terrain, record.frame as u32)?;
        }
        if checks.lod_error || is_pair {
            record.strokes = temporal::count_strokes(gpu, &self.frame, &self.style)?;
        }
        if is_pair {
            self.compare(gpu, &view, record.jumped == Some(true), checks.begins_pair)?;
        }
        self.checks += start.elapsed();
        self.records.push(record);
        Ok(())
    }

    /// Compares the frame with the one before, if that began a pair, and keeps it if it begins one itself.
    fn compare(&mut self, gpu: &Gpu, view: &View, jumped: bool, begins_pair: bool) -> anyhow::Result<()> {
        let drawn = temporal::read_drawn(gpu, &self.frame, view, &self.style)?;
        // After a jump there is nothing that could be steady.
        if let Some(before) = self.pair.take().filter(|_| !jumped) {
            self.steadiness.add(temporal::compare(&before, &drawn)?);
        }
        self.pair = begins_pair.then_some(drawn);
        Ok(())
    }

    fn record(&mut self, t_s: f64, wall_s: f64, drawn: Drawn) -> FrameRecord {
        let Drawn { frame_ms, gpu_ms, prepared: Prepared { selection, tiles, prepare_ms, jumped, detail } } = drawn;
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
            prepare_ms: Some(prepare_ms),
            jumped: Some(jumped),
            wall_s: Some(wall_s),
        }
    }

    fn run(&self, eyes: &str) -> Run {
        let mut run = Run::of_frames(&self.style.name, eyes, &self.records);
        self.passes.fill(&mut run);
        run.temporal = self.steadiness.metrics();
        let counts = self.world.surfaces.terrain.tile_counts();
        run.memory = Memory {
            gpu_bytes: Some(self.gpu_bytes.max(0) as u64),
            tile_cache_bytes: Some(counts.gpu_bytes),
            cpu_tile_bytes: Some(counts.cache_bytes),
            rss_bytes: memory::rss_bytes(),
        };
        run.tiles.loaded = Some(self.records.iter().filter_map(|record| record.tiles_loaded).sum());
        run.tiles.evicted = Some(counts.evicted - self.before.evicted);
        run.tiles.cancelled = Some(counts.cancelled - self.before.cancelled);
        run.tiles.failed = Some(self.failed_tiles);
        run
    }
}
