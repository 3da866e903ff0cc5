//! `hachure bench`: flies a camera path without a window and reports what each style costs.
//!
//! Each style has its own renderer and terrain, so that each loads the tiles that it would load alone. The styles take
//! turns at every frame, and the order of turns rotates: changes of the machine during the run (clocks, heat, the
//! disk's cache) affect all styles alike, and ratios between them are fair.
//!
//! Strokes that did not fit into the buffers are counted in every frame, after its times have been taken. Some frames
//! are checked more closely: how far the terrain is from the data, how many strokes there are, and how steady the
//! drawing is from that frame to the next ([`crate::measure::temporal`]).

mod again;
mod against_reference;
mod built_in_suites;
mod governed;
#[cfg(test)]
mod noise_tests;
mod pairs;
mod passes;
pub(crate) mod portable;
mod style_run;
mod suite;
mod sweep;

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;

use self::governed::Governed;
use self::pairs::{Checks, PairPlan};
use self::style_run::StyleRun;
use self::sweep::{Sweep, Variant};
use super::arguments;
use super::misuse::Misuse;
use super::progress::Bar;
use super::quality_args::QualityArgs;
use super::render::parse_size;
use super::stereo_args::StereoArgs;
use super::world_args::WorldArgs;
use super::{inputs, print, print_json};
use crate::file::message::named;
use crate::file::unnamed;
use crate::frame::Antialias;
use crate::gpu::Gpu;
use crate::gpu::device::AdapterWish;
use crate::measure::comparison::Baseline;
use crate::measure::quality::{self, Front};
use crate::measure::report::{Report, WorldSize};
use crate::measure::report_html::{is_page, write_html};
use crate::measure::report_text;
use crate::measure::settings::{Settings, program_crc32};
use crate::measure::statistics::{RunFrames, is_frames_csv, write_frames_csv};
use crate::measure::trade;
use crate::scene::path::CameraPath;
use crate::scene::{Scene, ranges};
use crate::source::Progress;
use crate::style::Style;
use crate::world::{self, OpenWorld, path_fit};

/// Largest number of a run's frames that are compared with the full-resolution heights.
const CHECKED_FRAMES: usize = 32;
/// Number of cameras on the path at which the nearest land is measured.
const NEAREST_LAND_CAMERAS: usize = 24;
/// Frames per second along the path if `--frames` is not given.
const FPS: f64 = 30.0;
/// Largest number of frames of a flight that are drawn again after it.
const LAST_FRAMES: usize = 24;

/// The files written to the output folder.
const FILES: [&str; 3] = ["frames.csv", "report.html", "report.json"];
/// For each of them, whether hachure wrote the file at a path.
const IS_OWN: [fn(&Path) -> bool; 3] = [is_frames_csv, is_page, Report::is_report];

/// Options that the parts of a suite have, and the suite has not.
const PARTS_ONLY: [&str; 36] = [
    "antialias",
    "budget",
    "compare",
    "convergence",
    "date",
    "drape",
    "encoding",
    "exaggeration",
    "eyes",
    "focus",
    "fronts",
    "graticule",
    "haze",
    "height_offset",
    "height_scale",
    "height_unit",
    "ipd",
    "layer",
    "lod_error",
    "nodata",
    "path",
    "place",
    "quality",
    "real_time",
    "sea_level",
    "seed",
    "side_light",
    "styles",
    "sun",
    "sweep",
    "tile_rows",
    "trees",
    "trust_scene",
    "voids",
    "water",
    "world",
];

/// Arguments of `bench`.
#[derive(Debug, Args)]
pub(crate) struct BenchArgs {
    /// The world that is drawn.
    #[command(flatten)]
    pub world: WorldArgs,
    /// Camera path: a CSV file with the header t,x,y,z,yaw,pitch,fov, or a built-in path (tour, valley, teleport,
    /// ascent); required without --suite
    #[arg(long, required_unless_present = "suite")]
    pub path: Option<PathBuf>,
    /// Run a list of benchmarks, and write one report that compares them with published figures: a built-in suite
    /// (pietrok, lsa, stereo, tone-lines, relief, hatching, forest, world), a TOML file, or a folder with suite.toml.
    /// --size, --frames, --tile-memory and --steadiness-pairs replace those of its benchmarks
    #[arg(long, value_name = "SUITE", conflicts_with_all = PARTS_ONLY)]
    pub suite: Option<PathBuf>,
    /// Presets (`hachure styles` lists them) or style files, separated by commas; the report compares times with those
    /// of the first
    #[arg(long, value_delimiter = ',', default_value = "ink")]
    pub styles: Vec<String>,
    /// Measure each style with other values too, and compare each setting with a converged reference. KEY is a parameter
    /// of all the styles, lod-error, antialias, scale (a factor on --size, 0.25 to 2), tree-detail (a factor;
    /// 2 keeps trees detailed down to half the size), or tile-error (heights rounded as by bake --max-error, in m). With several
    /// --sweep, every combination is measured (at most 64 settings of all styles)
    #[arg(long, value_name = "KEY=VALUE,…", conflicts_with = "real_time")]
    pub sweep: Vec<Sweep>,
    /// Number of frames, spread evenly over the path [default: 30 per second of the path]
    #[arg(long, value_parser = arguments::whole::<u32>(1, 1_000_000))]
    pub frames: Option<u32>,
    /// Size of the picture in pixels; of one eye for a stereo pair [default: 1280x720]
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,
    /// Which eyes are drawn.
    #[command(flatten)]
    pub stereo: StereoArgs,
    /// Smoothing of edges: none, or temporal (the mean of consecutive frames) [default: none]
    #[arg(long)]
    pub antialias: Option<Antialias>,
    /// Largest error of the drawn surface, in pixels [default: 1]
    #[arg(long, value_parser = arguments::within(ranges::LOD_ERROR_PX), allow_hyphen_values = true)]
    pub lod_error: Option<f64>,
    /// Point of the measured front.
    #[command(flatten)]
    pub quality: QualityArgs,
    /// Fly in real time: draw as many frames as fit into the duration of the path, one style after the other
    #[arg(long, conflicts_with = "frames")]
    pub real_time: bool,
    /// Time that a frame may take on the GPU, in milliseconds (11.1 for 90 a second): with --real-time, a governor
    /// chooses among the settings of the style's measured front, and the report says how the budget was held
    #[arg(long, value_name = "MS", requires = "real_time", conflicts_with_all = ["lod_error", "frames"], value_parser = arguments::budget_ms, allow_hyphen_values = true)]
    pub budget: Option<f64>,
    /// Memory for heights on the GPU, and as much again in main memory, in MiB per style and setting; styles with
    /// shadows or water need a quarter more on the GPU for maps of the same tiles, and styles with both a half more
    /// [default: 512]
    #[arg(long, value_name = "MIB", value_parser = arguments::whole_within::<u64>(ranges::TILE_MEMORY_MIB))]
    pub tile_memory: Option<u64>,
    /// Number of pairs of consecutive frames, spread over the path, on which steadiness is measured; 0 measures none
    /// [default: 24]
    #[arg(long = "steadiness-pairs", alias = "temporal", value_name = "PAIRS", value_parser = arguments::whole::<u32>(0, 1_000_000))]
    pub steadiness_pairs: Option<u32>,
    /// Report of an earlier run with the same world, --path, --frames, --size, --eyes, --antialias, --lod-error and
    /// --tile-memory: list what became worse or better, and by how much. Times are compared if frames.csv is in the
    /// report's folder and the GPU is the same
    #[arg(long, value_name = "OLD.json")]
    pub compare: Option<PathBuf>,
    /// Output folder: for report.json, frames.csv and report.html, the fronts of --sweep (front-STYLE.toml), or the
    /// report of a suite (suite.json, suite.html) with a folder for each of its benchmarks
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Replace these files in the output folder even if hachure did not write them
    #[arg(long)]
    pub overwrite: bool,
    /// Print report.json, or suite.json, instead of a table
    #[arg(long)]
    pub json: bool,
}

impl BenchArgs {
    /// Width and height of the picture; of one eye for a stereo pair.
    fn size_px(&self) -> [u32; 2] {
        self.size.unwrap_or([1280, 720])
    }

    fn tile_memory_mib(&self) -> u64 {
        self.tile_memory.unwrap_or(512)
    }

    fn steadiness_pairs(&self) -> u32 {
        self.steadiness_pairs.unwrap_or(24)
    }
}

/// Runs the command.
///
/// # Errors
/// Fails if an input is invalid, if the GPU fails, or if the folder cannot be written.
pub(crate) fn run(args: &BenchArgs, adapter: &AdapterWish) -> anyhow::Result<()> {
    if let Some(name) = &args.suite {
        return suite::run(name, args, adapter);
    }
    let report = measured(args, || open_gpu(adapter))?;
    if args.json {
        return print_json(&report);
    }
    let [width, height] = report.size_px;
    let table = report_text::table(&report);
    let page = named(args.output.join(FILES[1]));
    print(&format!("{}, {width}x{height}\n{table}\nReport: {page} (it explains the columns)", report.adapter))
}

/// Measures one benchmark, and writes its report; `gpu` opens the GPU when the inputs are valid.
///
/// # Errors
/// Fails if an input is invalid, or if the report cannot be written.
pub(crate) fn measured(args: &BenchArgs, gpu: impl FnOnce() -> anyhow::Result<Gpu>) -> anyhow::Result<Report> {
    let planned = Planned::of(args)?;
    // Bakes the world once, if needed; then each style opens its own.
    planned.bake()?;
    planned.measure(&gpu()?)
}

fn open_gpu(adapter: &AdapterWish) -> anyhow::Result<Gpu> {
    let gpu = Gpu::open(adapter)?;
    world::store_pipelines(&gpu);
    Ok(gpu)
}

/// A benchmark whose arguments and inputs have been checked. Nothing has been drawn or baked.
struct Planned<'a> {
    args: &'a BenchArgs,
    path: &'a Path,
    path_text: String,
    scene: Scene,
    /// The settings of each style.
    variants: Vec<Vec<Variant>>,
    /// The governor of each style.
    governed: Vec<Option<Governed>>,
    baseline: Option<Baseline>,
}

impl<'a> Planned<'a> {
    /// Checks the arguments and the inputs, and makes the output folder.
    fn of(args: &'a BenchArgs) -> anyhow::Result<Self> {
        args.stereo.check()?;
        if args.output.exists() && !args.output.is_dir() {
            bail!("{}: is a file, and bench writes its report into a folder", named(&args.output));
        }
        sweep::check(args)?;
        if !args.sweep.is_empty() && args.quality.quality.is_some() {
            bail!(Misuse("--sweep: measures a front, and --quality draws with one; give one of them".to_owned()));
        }
        let path = args.path.as_deref().ok_or_else(|| Misuse("--path is missing".to_owned()))?;
        let variants = args.styles.iter().map(|name| Variant::all(args, name)).collect::<Result<Vec<_>, _>>()?;
        let governed = args.styles.iter().map(|name| Governed::of(args, name)).collect::<Result<Vec<_>, _>>()?;
        let styles: Vec<Style> = variants.iter().flatten().map(|variant| variant.style.clone()).collect();
        args.world.check()?;
        // Errors in the path are reported before a world is baked; ground heights come with the world. The file is read
        // once: it may be a pipe.
        let path_text = arguments::camera_path(path)?;
        CameraPath::parse_on_ground(path, path_text.as_bytes(), |_, _| 0.0)?;
        let scene = args.world.scene()?;
        path_fit::check_name(path, args.world.name(), &scene.world)?;
        let mut inputs = inputs::of(args.world.name(), &scene, &styles, Some(path));
        let baseline = args.compare.as_deref().map(Baseline::read).transpose()?;
        for path in args.compare.iter().flat_map(|path| [path.clone(), path.with_file_name("frames.csv")]) {
            inputs.add(&path);
        }
        FILES.iter().try_for_each(|name| inputs.check(&args.output.join(name)))?;
        let mut own = FILES.iter().zip(IS_OWN);
        own.try_for_each(|(name, is_own)| unnamed::check(&args.output.join(name), args.overwrite, is_own))?;
        for (index, settings) in variants.iter().enumerate().filter(|(_, settings)| settings.len() > 1) {
            let name = &settings[0].style.name;
            let is_same = |other: &Vec<Variant>| quality::file_name(&other[0].style.name) == quality::file_name(name);
            if variants[..index].iter().any(is_same) {
                bail!(Misuse(format!(
                    "--sweep: two of the styles are called {name}, and their fronts would be one file"
                )));
            }
            let front = args.output.join(quality::file_name(name));
            inputs.check(&front)?;
            unnamed::check(&front, args.overwrite, Front::is_own)?;
        }
        std::fs::create_dir_all(&args.output).with_context(|| format!("cannot create {}", named(&args.output)))?;
        Ok(Self { args, path, path_text, scene, variants, governed, baseline })
    }

    fn bake(&self) -> anyhow::Result<()> {
        let store = world::open_store(&self.scene, &Bar::default());
        store.map(drop).map_err(|error| self.args.world.or_drawing(error))
    }

    /// Flies the path in all styles, and writes the report.
    fn measure(self, gpu: &Gpu) -> anyhow::Result<Report> {
        let Self { args, path: path_name, path_text, scene, variants, governed, baseline } = self;
        let settings_of_style = variants.first().map_or(1, Vec::len);
        let variants = variants.into_iter().flatten();
        let runs = variants.map(|variant| StyleRun::new(gpu, variant, args.tile_memory_mib(), &scene));
        let mut runs = runs.collect::<anyhow::Result<Vec<_>>>()?;
        // A flight with a budget has no sweep, so each style has one run.
        runs.iter_mut().zip(governed).for_each(|(run, governed)| run.set_governed(governed));
        let path = CameraPath::parse_on_ground(path_name, path_text.as_bytes(), |x, y| runs[0].world.ground_m(x, y))?;
        runs[0].world.ground_was_read()?;
        path_fit::check_places(path_name, &path_text, &runs[0].world.surfaces.terrain.ground_heights())?
            .iter()
            .for_each(|warning| tracing::warn!("{warning}"));
        if let Some(first) = path.frames(1.0).next() {
            runs.iter_mut().for_each(|run| args.world.light.place_sun(&mut run.world.scene.sun, &first));
        }
        place_eyes(gpu, &path, args, &mut runs)?;
        fly(gpu, &path, args, &mut runs)?;
        if !args.sweep.is_empty() {
            for (name, runs) in args.styles.iter().zip(runs.chunks_mut(settings_of_style)) {
                against_reference::measure(gpu, args, &scene, &path, name, runs)?;
            }
        }
        let mut report = Report {
            adapter: gpu.description(),
            size_px: args.size_px(),
            world: world_size(&runs[0].world),
            is_software: gpu.is_software(),
            settings: Some(settings(args, path_name, &path, &path_text)),
            runs: runs.iter().map(|run| run.run(args.stereo.eyes())).collect(),
            comparison: None,
        };
        trade::fill(&mut report);
        let frames: Vec<RunFrames> = runs
            .into_iter()
            .map(|run| RunFrames {
                style: run.variant.style.name,
                eyes: args.stereo.eyes().to_string(),
                frames: run.records,
            })
            .collect();
        report.comparison = baseline.map(|baseline| baseline.compare(&report, &frames));
        let [frames_csv, page, json] = FILES.map(|name| args.output.join(name));
        write_frames_csv(&frames_csv, &frames)?;
        write_html(&page, &report, &frames)?;
        report.write_json(&json)?;
        Front::all(&report).iter().try_for_each(|front| front.write(&args.output.join(front.file_name())))?;
        Ok(report)
    }
}

/// Sets the stereo pair: the same for all styles and all frames.
fn place_eyes(gpu: &Gpu, path: &CameraPath, args: &BenchArgs, runs: &mut [StyleRun]) -> anyhow::Result<()> {
    let mut nearest = f64::INFINITY;
    if args.stereo.requests_nearest() {
        for camera in path.spread(NEAREST_LAND_CAMERAS) {
            nearest = nearest.min(runs[0].nearest_m(gpu, &camera)?);
        }
    }
    let pair = args.stereo.pair(nearest);
    runs.iter_mut().for_each(|run| run.pair = pair);
    Ok(())
}

fn world_size(world: &OpenWorld) -> WorldSize {
    let finest = world.surfaces.terrain.store().levels()[0];
    WorldSize { samples: u64::from(finest.width) * u64::from(finest.height), extent_m: world.extent_m() }
}

/// Returns how the report is made, for comparison with others.
fn settings(args: &BenchArgs, path_name: &Path, path: &CameraPath, path_text: &str) -> Settings {
    Settings {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        program_crc32: program_crc32(),
        world: args.world.name().map(str::to_owned),
        path: path_name.display().to_string(),
        path_crc32: format!("{:08x}", crc32fast::hash(path_text.as_bytes())),
        duration_s: path.duration_s(),
        frames: (!args.real_time).then(|| frame_count(args, path) as u64),
        real_time: args.real_time,
        lod_error_px: args.lod_error.unwrap_or(sweep::DEFAULT_LOD_ERROR_PX),
        quality: args.quality.quality.map(|level| level.name().to_owned()),
        tile_memory_mib: args.tile_memory_mib(),
        exaggeration: args.world.exaggeration,
        sea_level: args.world.land.sea_level.map(|level| level.to_string()),
        trees: args.world.land.trees.map(|trees| trees.to_string()),
        seed: args.world.land.seed,
    }
}

/// Returns the number of frames that are drawn with every style, except in real time.
fn frame_count(args: &BenchArgs, path: &CameraPath) -> usize {
    args.frames.map_or_else(|| path.frame_count(FPS), |frames| frames as usize)
}

fn fly(gpu: &Gpu, path: &CameraPath, args: &BenchArgs, runs: &mut [StyleRun]) -> anyhow::Result<()> {
    let bar = Bar::default();
    bar.report("warming up", 0.0);
    let start_s = path.times_s()[0];
    let first = path.sample(start_s);
    for run in runs.iter_mut() {
        run.warm_up(gpu, &first, start_s)?;
    }
    if args.real_time {
        fly_by_the_clock(gpu, path, args, runs, &bar)?;
    } else {
        fly_by_frames(gpu, path, args, runs, &bar)?;
    }
    fly_back(gpu, path, runs)
}

/// Draws the last frames again, from the last one back, since their tiles are loaded: without a timer around each pass,
/// with timers but without a pause, and with traces. Each style draws alone, since frames that follow each other are
/// measured.
fn fly_back(gpu: &Gpu, path: &CameraPath, runs: &mut [StyleRun]) -> anyhow::Result<()> {
    for run in runs.iter_mut() {
        run.end_flight();
        let times_s = run.records.iter().rev().take(LAST_FRAMES).map(|record| record.t_s);
        let cameras: Vec<_> = times_s.map(|t_s| (path.sample(t_s), t_s)).collect();
        run.measure_untimed(gpu, &cameras)?;
        run.measure_busy(gpu, &cameras)?;
        run.trace(gpu, &cameras)?;
    }
    Ok(())
}

/// Draws the same frames with every style, in turns.
fn fly_by_frames(
    gpu: &Gpu,
    path: &CameraPath,
    args: &BenchArgs,
    runs: &mut [StyleRun],
    bar: &Bar,
) -> anyhow::Result<()> {
    let frames = frame_count(args, path);
    let step_s = match args.frames {
        // As in `CameraPath::spread`, the first and the last row are included.
        Some(frames) => path.duration_s() / f64::from(frames.saturating_sub(1).max(1)),
        None => 1.0 / FPS,
    };
    let start_s = path.times_s()[0];
    let between_checks = frames.div_ceil(CHECKED_FRAMES);
    let pairs = PairPlan::new(frames, args.steadiness_pairs());
    for frame in 0..frames {
        bar.report("flying", frame as f32 / frames as f32);
        let t_s = start_s + frame as f64 * step_s;
        let camera = path.sample(t_s);
        for turn in 0..runs.len() {
            let run = &mut runs[(frame + turn) % runs.len()];
            let checks = Checks { lod_error: frame % between_checks == 0, begins_pair: pairs.begins_at(frame) };
            run.fly(gpu, &camera, t_s, checks)?;
        }
    }
    Ok(())
}

/// Draws as many frames as each style can in the duration of the path. The clock is paused while a frame is checked.
fn fly_by_the_clock(
    gpu: &Gpu,
    path: &CameraPath,
    args: &BenchArgs,
    runs: &mut [StyleRun],
    bar: &Bar,
) -> anyhow::Result<()> {
    let (start_s, duration_s) = (path.times_s()[0], path.duration_s());
    let between_checks_s = duration_s / CHECKED_FRAMES as f64;
    let between_pairs_s = duration_s / f64::from(args.steadiness_pairs());
    for run in runs {
        // Without pairs, the first one is due after infinite time.
        let (mut next_check_s, mut next_pair_s) = (0.0, if args.steadiness_pairs() > 0 { 0.0 } else { f64::INFINITY });
        loop {
            let now_s = run.wall_s();
            if now_s >= duration_s {
                break;
            }
            bar.report("flying", (now_s / duration_s) as f32);
            let checks = Checks { lod_error: now_s >= next_check_s, begins_pair: now_s >= next_pair_s };
            next_check_s += if checks.lod_error { between_checks_s } else { 0.0 };
            next_pair_s += if checks.begins_pair { between_pairs_s } else { 0.0 };
            run.fly(gpu, &path.sample(start_s + now_s), start_s + now_s, checks)?;
            run.govern();
        }
    }
    Ok(())
}
