//! `hachure render`: a DEM becomes a drawing in a file, or a camera path a row of them.

mod job;
mod like;
mod map;
mod outputs;
mod paper;
mod sheets;
mod show;
mod title;
mod vector;

use std::path::PathBuf;

use anyhow::bail;
use clap::Args;

use self::job::Job;
use self::sheets::SheetArgs;
use self::vector::SvgOptions;
use super::arguments;
use super::height_args::HeightArgs;
use super::light_args::LightArgs;
use super::misuse::Misuse;
use super::progress::Bar;
use super::stereo_args::StereoArgs;
use super::water_args::WaterArgs;
use super::{print, print_json};
use crate::file::message::named;
use crate::file::pattern::{OutputKind, PictureFormat};
use crate::frame::Antialias;
use crate::gpu::Gpu;
use crate::gpu::device::AdapterWish;
use crate::picture::aov::{self, Names};
use crate::picture::imprint::DPI_RANGE;
use crate::picture::{PartRule, PictureReport};
use crate::scene::camera::Camera;
use crate::scene::map::{Map, MapArea};
use crate::scene::path::CameraPath;
use crate::scene::reach::Reach;
use crate::scene::stereo::Eyes;
use crate::scene::view::Clock;
use crate::style::scale::REFERENCE_DPI;
use crate::tiles::terrain::{Loading, TerrainOptions};
use crate::vector::DrawingReport;
use crate::vector::pens::MOST_PENS;
use crate::world::{self, OpenWorld};

/// Arguments of `render`.
#[derive(Clone, Debug, Args)]
pub struct RenderArgs {
    /// Scene file, DEM, baked pyramid, or a scene inside hachure (continent, forest, hut); without one, the embedded world
    pub world: Option<String>,
    /// What height files leave open.
    #[command(flatten)]
    pub heights: HeightArgs,
    /// How light falls.
    #[command(flatten)]
    pub light: LightArgs,
    /// Where water is.
    #[command(flatten)]
    pub water: WaterArgs,
    /// Let a scene file name files outside of its folder, and addresses
    #[arg(long)]
    pub trust_scene: bool,
    /// .png, .exr, .mp4, .svg (strokes and marks), of a --map also .tif or .geojson, or frames: a pattern like dir/%05d.png
    #[arg(short, long)]
    pub output: PathBuf,
    /// Draw a picture that hachure wrote (.png, .exr, .svg or .mp4) again: its world, camera, sun, style, size and dpi,
    /// but for what other arguments say
    #[arg(long, value_name = "FILE")]
    pub like: Option<PathBuf>,
    /// A preset or a style file [default: ink]
    #[arg(long)]
    pub style: Option<String>,
    /// Width and height in pixels, like 1280x720, which they are without it
    #[arg(long, value_parser = parse_size)]
    pub size: Option<[u32; 2]>,
    /// Dots to an inch of paper: lengths of the style, which are meant for 96, become as many more pixels
    #[arg(long, value_name = "DOTS", allow_hyphen_values = true, value_parser = arguments::from_to(DPI_RANGE[0], DPI_RANGE[1]))]
    pub dpi: Option<f64>,
    /// x,y,z,yaw,pitch,fov: metres (z as +h above ground), degrees
    #[arg(long, allow_hyphen_values = true, conflicts_with = "path")]
    pub camera: Option<Camera>,
    /// A map seen from straight above, north up, with its place on the earth: east, north and width in metres; alone, all of the land.
    #[arg(long, value_name = "EAST,NORTH,WIDTH", num_args = 0..=1, default_missing_value = "whole", conflicts_with_all = ["camera", "path"])]
    pub map: Option<MapArea>,
    /// Camera path: CSV with the header t,x,y,z,yaw,pitch,fov, or one inside hachure (tour, valley, teleport, ascent)
    #[arg(long)]
    pub path: Option<PathBuf>,
    /// Frames per second along the path [default: 30]
    #[arg(long, value_parser = arguments::frame_rate, allow_hyphen_values = true)]
    pub fps: Option<f64>,
    /// When one picture of a scene with wind is drawn, in seconds; along a path its own time counts [default: 0]
    #[arg(long, conflicts_with = "path", allow_hyphen_values = true, value_parser = arguments::from_to(0.0, 1e7))]
    pub time_s: Option<f64>,
    /// How many eyes, and how they stand.
    #[command(flatten)]
    pub stereo: StereoArgs,
    /// Draw each picture so many times, moved by parts of a pixel, and take the mean: smooth edges at so many times the
    /// cost. Channels of an EXR beside its colour keep one sample [default: 1]
    #[arg(long, value_parser = arguments::whole::<u32>(1, 1024))]
    pub samples: Option<u32>,
    /// How frames along a path smooth their edges: none, or temporal, by the mean of frames that follow each other
    #[arg(long, default_value = "none")]
    pub antialias: Antialias,
    /// Height error that may be seen, in pixels [default: 1]
    #[arg(long, value_parser = arguments::above_0, allow_hyphen_values = true)]
    pub lod_error: Option<f64>,
    /// Channels of an EXR beside its colour: depth, position, normal, surface, motion, lsa, strokes, tone,
    /// hatch (the tone after the marks)
    #[arg(long, default_value = "")]
    pub aov: String,
    /// What --aov calls its channels: hachure (depth.V, position.X, normal.X), or standard (Z, P.X, N.X) for compositors;
    /// P is in the world and not from the camera: metres east, north, up
    #[arg(long, value_name = "NAMES", default_value_t)]
    pub aov_names: Names,
    /// Write this picture of the frame, as its passes left it, instead of the drawing; a name that there is not tells
    /// which there are
    #[arg(long, value_name = "NAME", conflicts_with_all = ["path", "aov"])]
    pub show: Option<String>,
    /// Write this below the picture, with where the camera stands and the style; of a --map with a scale bar, north, and
    /// its scale with --paper or --dpi
    #[arg(long, value_name = "TEXT")]
    pub title: Option<String>,
    /// Memory for tiles on the GPU, in MiB
    #[arg(long, default_value_t = 512, value_parser = arguments::whole::<u64>(1, 1 << 20))]
    pub tile_memory: u64,
    /// Of an .svg: how far its curves may be from the strokes, in pixels [default: 0.25]
    #[arg(long, allow_hyphen_values = true, value_parser = arguments::from_to(0.01, 100.0))]
    pub tolerance_px: Option<f64>,
    /// The sheet, a0 to a6, letter, legal, tabloid or WIDTHxHEIGHT in millimetres: its pixels follow from --dpi, which is
    /// 300 without it. An .svg without --dpi is as large as fits, and turned as the picture is
    #[arg(long)]
    pub paper: Option<String>,
    /// --paper lies; it does without this
    #[arg(long, conflicts_with = "portrait")]
    pub landscape: bool,
    /// --paper stands upright
    #[arg(long)]
    pub portrait: bool,
    /// Of an .svg on --paper: what stays free around the picture, in millimetres [default: 10]
    #[arg(long, allow_hyphen_values = true, value_parser = arguments::from_to(0.0, 100_000.0))]
    pub margin: Option<f64>,
    /// How it is cut.
    #[command(flatten)]
    pub sheets: SheetArgs,
    /// Of an .svg: draw it with so many pens, 1 to 3, each of one width and in full ink; their widths follow from the
    /// picture
    #[arg(long, value_name = "COUNT", value_parser = arguments::whole::<usize>(1, MOST_PENS as u64))]
    pub pens: Option<usize>,
    /// Print what it cost, for programs
    #[arg(long)]
    pub json: bool,
}

/// The size without `--size`.
const SIZE_PX: [u32; 2] = [1280, 720];
/// The style without `--style`.
const STYLE: &str = "ink";

impl RenderArgs {
    /// Of an eye's picture, in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size.unwrap_or(SIZE_PX)
    }

    /// Of the whole picture: side by side it is twice as wide.
    pub fn size_of_all(&self) -> [u32; 2] {
        let [width, height] = self.size();
        [if self.stereo.eyes() == Eyes::SideBySide { 2 * width } else { width }, height]
    }

    /// Frames in a second.
    pub fn fps(&self) -> f64 {
        self.fps.unwrap_or(30.0)
    }

    /// Frames of which a pixel is the mean.
    pub fn samples(&self) -> u32 {
        self.samples.unwrap_or(1)
    }

    /// Height error that may be seen, in pixels.
    pub fn lod_error(&self) -> f64 {
        self.lod_error.unwrap_or(1.0)
    }

    /// How many pixels one of the style is.
    pub fn px_per_style_px(&self) -> f64 {
        self.dpi.map_or(1.0, |dpi| dpi / REFERENCE_DPI)
    }
}

/// Frames of a path: a day at 60 frames a second is less than that.
const MOST_FRAMES: usize = 10_000_000;

/// `1280x720`.
///
/// # Errors
/// Says what it should look like.
pub fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let parse = |side: &str| side.parse::<u32>().ok().filter(|side| (1..=1 << 20).contains(side));
    text.split_once(['x', 'X'])
        .and_then(|(width, height)| Some([parse(width)?, parse(height)?]))
        .ok_or_else(|| "it must be a size like 1280x720".to_owned())
}

/// Runs the command.
///
/// # Errors
/// When an input does not hold or the output cannot be written.
pub fn run(args: &RenderArgs, adapter: &AdapterWish) -> anyhow::Result<()> {
    let kind = OutputKind::of(&args.output).map_err(Misuse::of)?;
    let args = paper::measured(args, &kind)?;
    let (args, style) = like::resolved(&args, &kind)?;
    let args = &args;
    map::check(args, &kind)?;
    check_path(args, &kind)?;
    show::check(args, &kind)?;
    check_eyes(args, &kind)?;
    check_antialias(args, &kind)?;
    let style = match style {
        Some(style) => style,
        None => arguments::style(args.style.as_deref().unwrap_or(STYLE))?,
    };
    let (style, as_written) = (style.scaled(args.px_per_style_px()), style);
    let titled = title::with_foot(style.clone(), args, &kind)?;
    let svg = SvgOptions::new(args, &kind, &style)?;
    let sheets = sheets::plan(args, &kind, args.size_of_all(), svg.as_ref())?;
    let left_out = vector::left_out(&style, args.stereo.eyes()).filter(|_| svg.is_some());
    let holder = if matches!(kind, OutputKind::Picture(PictureFormat::GeoJson)) { "a .geojson" } else { "an .svg" };
    let planes = aov::planes_named(&args.aov, args.aov_names, &style).map_err(Misuse::of)?;
    if !planes.is_empty()
        && !matches!(kind, OutputKind::Picture(PictureFormat::Exr) | OutputKind::Frames(_, PictureFormat::Exr))
    {
        let output = named(&args.output);
        let misuse = format!("--aov: only an .exr has room for channels beside the colour, and the output is {output}");
        return Err(Misuse(misuse).into());
    }
    if planes.is_empty() && args.aov_names != Names::Hachure {
        return Err(Misuse("--aov-names: it names the channels of --aov, which is not given".to_owned()).into());
    }
    let folder = args.output.parent().filter(|folder| !folder.as_os_str().is_empty());
    if let Some(folder) = folder.filter(|folder| !matches!(kind, OutputKind::Frames(..)) && !folder.is_dir()) {
        bail!("cannot write {}: there is no folder {}", named(&args.output), named(folder));
    }
    arguments::check_world(args.world.as_deref())?;
    // The world first: what is wrong with it needs no GPU to be told.
    let scene = world::scene_of(args.world.as_deref(), Reach::trusting(args.trust_scene))?;
    let scene = args.water.over(args.light.over(args.heights.over(scene)));
    let scene = if args.map.is_some() { scene.for_map() } else { scene };
    if let Some(unscaled) = as_written.unscaled().filter(|_| style != as_written) {
        let dpi = args.dpi.unwrap_or(REFERENCE_DPI);
        tracing::warn!("at {dpi} dots to an inch these stay as many pixels as on a screen: {unscaled}");
    }
    // Read once: it may be a pipe.
    let flight = args.path.as_deref().map(CameraPath::read_text).transpose()?;
    outputs::check(args, &kind, &sheets::paths(args, sheets.as_ref()), &scene, &style, flight.as_deref())?;
    let store = world::open_store(&scene, &Bar::default())?;
    map::check_place(args, &kind, store.georeference())?;
    let gpu = Gpu::open(adapter)?;
    let options = TerrainOptions {
        lod_error_px: args.lod_error(),
        tile_memory_bytes: args.tile_memory << 20,
        loading: Loading::Wait,
        ..TerrainOptions::default()
    };
    let world = OpenWorld::on_gpu_with(&gpu, scene, store, options, &Bar::default())?;
    let drawn = DrawingReport::default();
    let clock = Clock::still(args.time_s.unwrap_or(0.0));
    let map = map::PlacedMap::new(args, &world, titled.paper.foot_px);
    let style = match &map {
        Some(map) => titled.for_map(map.map.pixel_m * args.px_per_style_px()),
        None => titled,
    };
    let camera = map.as_ref().map_or_else(|| world.default_camera(), |map| Map::camera(&map.pose));
    let imprint = like::imprint(args, &kind, &as_written, &camera);
    let mut job = Job {
        args,
        flight,
        style,
        planes,
        gpu,
        world,
        renderer: None,
        svg,
        sheets,
        drawn,
        map,
        pair: None,
        clock,
        camera,
        imprint,
    };
    let cameras = job.cameras()?;
    args.light.beside(&mut job.world.scene.sun, &cameras[0]);
    job.imprint.sun = job.world.scene.sun;
    job.world.ground_was_read()?;
    job.place_eyes(&cameras)?;
    if args.json {
        job.warm_up(&cameras[0])?;
    }
    let report = job.run(kind, &cameras)?;
    if report.tiles_missing > 0 {
        tracing::warn!(
            "{} tiles had no room in --tile-memory {}: coarser ones stood in for them",
            report.tiles_missing,
            args.tile_memory
        );
    }
    if report.over_budget > 0 {
        tracing::warn!("{}", told_over_budget(&report, cameras.len(), args.lod_error()));
    }
    if let Some(left_out) = left_out {
        tracing::warn!("{holder} has no {left_out}");
    }
    if args.json {
        let report = job.report(&cameras, report);
        return print_json(&report);
    }
    let told = job.svg.as_ref().map(|svg| svg.told(&job.drawn)).into_iter();
    told.chain(job.sheets.as_ref().map(|cut| sheets::told(args, cut))).try_for_each(|line| print(&line))
}

/// A path is for many pictures, and many pictures are of a path: else somebody waits for a film of one frame.
fn check_path(args: &RenderArgs, kind: &OutputKind) -> Result<(), Misuse> {
    let output = named(&args.output);
    match (kind, &args.path) {
        (OutputKind::Picture(_), Some(_)) => Err(Misuse(format!(
            "--path flies through many pictures, and {output} is one; frames are written to a pattern like \
             dir/%05d.png, a film to .mp4, and --camera is for one picture"
        ))),
        (OutputKind::Frames(..), None) => {
            Err(Misuse(format!("{output} is a pattern of frames, which needs --path FILE, a camera path")))
        }
        (OutputKind::Mp4, None) => Err(Misuse(format!(
            "{output} is a film, which needs --path FILE, a camera path; one picture is written to .png, .exr or .svg"
        ))),
        _ => Ok(()),
    }
}

/// Two eyes are drawn into pictures that have room for what is asked of both.
fn check_eyes(args: &RenderArgs, kind: &OutputKind) -> Result<(), Misuse> {
    args.stereo.check()?;
    let (eyes, output) = (args.stereo.eyes(), named(&args.output));
    if eyes == Eyes::Mono {
        return Ok(());
    }
    let is_svg = matches!(kind, OutputKind::Picture(PictureFormat::Svg) | OutputKind::Frames(_, PictureFormat::Svg));
    if is_svg && eyes == Eyes::SideBySide {
        let misuse = format!("--eyes {eyes}: an .svg has one eye, or both as an anaglyph, and the output is {output}");
        return Err(Misuse(misuse));
    }
    if args.show.is_some() {
        return Err(Misuse(format!("--eyes {eyes}: --show is of one eye's frame")));
    }
    if eyes.are_merged() && !args.aov.is_empty() {
        return Err(Misuse(
            "--aov: an anaglyph is both eyes in one picture; side-by-side has the channels of each".into(),
        ));
    }
    Ok(())
}

/// The mean of frames is of frames that follow each other, each of one sample in one part.
fn check_antialias(args: &RenderArgs, kind: &OutputKind) -> Result<(), Misuse> {
    if args.antialias == Antialias::None {
        return Ok(());
    }
    let why = match kind {
        _ if args.path.is_none() => "it is for frames that follow each other, along a --path; a picture has --samples",
        OutputKind::Frames(_, PictureFormat::Svg) => "the lines of an .svg have no pixels",
        _ if args.samples() > 1 => "a frame is one sample, and --samples asks for more",
        _ if !args.aov.is_empty() => "--aov is of frames that are not moved",
        _ if !PartRule::default().is_whole(args.size()) => {
            "frames as large as --size are drawn in parts; they have --samples"
        }
        _ => return Ok(()),
    };
    Err(Misuse(format!("--antialias temporal: {why}")))
}

/// What a picture, or some of a film's, is drawn with instead of `--lod-error`.
fn told_over_budget(report: &PictureReport, frames: usize, lod_error: f64) -> String {
    let of = if frames > 1 { format!(" in {} of {frames} frames", report.over_budget) } else { String::new() };
    format!(
        "the surface was drawn to within {:.2} px{of} instead of --lod-error {lod_error}: that takes more triangles than a \
         picture of this size has",
        report.error_px
    )
}
