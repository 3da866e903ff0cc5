//! `hachure render`: draws a world into a file, or the frames of a camera path into several files or a film.

mod features;
mod frames;
pub(crate) mod hosted;
mod in_view;
mod job;
pub(crate) mod like;
mod look;
mod map;
mod mesh;
pub(crate) mod names;
mod numbers;
mod outputs;
mod paper;
mod sheets;
mod show;
mod title;
mod vector;

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::bail;
use clap::Args;

use self::frames::FrameRange;
use self::hosted::Host;
use self::job::Job;
use self::names::NamesArgs;
use self::sheets::SheetArgs;
use self::vector::SvgOptions;
use super::arguments;
use super::misuse::Misuse;
use super::place_args::{self, LookArgs, MapPlaceArgs};
use super::progress::Bar;
use super::quality_args::{QualityArgs, Use};
use super::stereo_args::StereoArgs;
use super::world_args::WorldArgs;
use super::{print, print_json};
use crate::file::frame_rate::FrameRate;
use crate::file::message::named;
use crate::file::pattern::{OutputKind, PictureFormat};
use crate::frame::Antialias;
use crate::gpu::Gpu;
use crate::gpu::device::AdapterWish;
use crate::picture::aov::{self, Names};
use crate::picture::{PartRule, PictureReport, map_frame};
use crate::pyramid::TileStore;
use crate::scene::camera::Camera;
use crate::scene::embedded;
use crate::scene::map::{Map, MapArea};
use crate::scene::ranges;
use crate::scene::stereo::Eyes;
use crate::scene::tone_curve::ToneCurve;
use crate::scene::view::Clock;
use crate::style::scale::REFERENCE_DPI;
use crate::style::set::SetValue;
use crate::tiles::terrain::{Loading, TerrainOptions};
use crate::vector::DrawingReport;
use crate::world::map::Edges;
use crate::world::{self, OpenWorld, path_fit};

/// Arguments of `render`.
#[derive(Clone, Debug, Args)]
pub(crate) struct RenderArgs {
    /// The world that is drawn.
    #[command(flatten)]
    pub world: WorldArgs,
    /// Output file: .png, .jpg, .exr, .svg or .pdf (of a style with strokes or marks, such as --style strokes), with
    /// --map also .tif or .geojson; of a --path .mp4 or .gif, or frames, named by a pattern like dir/%05d.png; or the
    /// land as a mesh, .glb (glTF) or .stl (a solid for 3D printers)
    #[arg(short, long)]
    pub output: PathBuf,
    /// Repeat a picture that hachure wrote (.png, .jpg, .exr, .svg, .pdf, .tif, .gif or .mp4), with its world, camera,
    /// sun, style, size and resolution; other options override these
    #[arg(long, value_name = "FILE")]
    pub like: Option<PathBuf>,
    /// Preset (`hachure styles` lists them) or style file [default: ink]
    #[arg(long)]
    pub style: Option<String>,
    /// Give a parameter of the style another value, such as strokes.width_px=2; may be repeated (`hachure styles show
    /// STYLE --all` lists the keys)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<SetValue>,
    /// Size of the picture in pixels; of one eye for a stereo pair [default: 1280x720]
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,
    /// Resolution on paper, in dots per inch: lengths of the style, which are pixels at 96 dpi, are multiplied by
    /// DOTS/96, except those of detected lines and of the grain of the paper [default: 300 for a raster picture with --paper]
    #[arg(long, value_name = "DOTS", allow_hyphen_values = true, value_parser = arguments::within(ranges::DPI))]
    pub dpi: Option<f64>,
    /// Camera: x,y,z,yaw,pitch,fov. x, y: metres east and north of the centre of the world; z: height in metres, or +h
    /// above the ground; yaw: degrees clockwise from north; pitch: degrees above the horizon; fov: vertical field of
    /// view in degrees [default: the scene's, or a view of the most prominent summit]
    #[arg(long, allow_hyphen_values = true, conflicts_with = "path")]
    pub camera: Option<Camera>,
    /// The place that the camera looks at.
    #[command(flatten)]
    pub look: LookArgs,
    /// Draw a georeferenced map from straight above, north up: its centre in metres east and north of the centre of the
    /// world, and its width in metres, which is left out with --map-scale; without a value, all of the land, or the land
    /// around --at
    #[arg(long, value_name = "EAST,NORTH,WIDTH", num_args = 0..=1, default_missing_value = "whole", conflicts_with_all = ["camera", "path"])]
    pub map: Option<MapArea>,
    /// Scale of a --map on --paper or with --dpi, such as 50000 or 1:50000: a millimetre on paper is 50 m in the world.
    /// The map has the middle of --map=EAST,NORTH, of --at, or of all of the land, and its width follows from the paper
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = parse_scale)]
    pub map_scale: Option<f64>,
    /// The place on which a map is centred.
    #[command(flatten)]
    pub map_place: MapPlaceArgs,
    /// GeoJSON: longitudes and latitudes in WGS 84, as RFC 7946 requires, instead of the reference system of the DEM
    #[arg(long)]
    pub wgs84: bool,
    /// Draw the frames of a camera path: a CSV file with the header t,x,y,z,yaw,pitch,fov, or a built-in path (tour,
    /// valley, teleport, ascent)
    #[arg(long)]
    pub path: Option<PathBuf>,
    /// Frames per second along the path, as a number or a fraction such as 30000/1001 [default: 30]
    #[arg(long, value_name = "RATE", allow_hyphen_values = true)]
    pub fps: Option<FrameRate>,
    /// Write only these frames of the path, so that several machines can draw one film: 100..200 are the frames 100 to
    /// 199, counted from 0. The parts join without a jump
    #[arg(long, value_name = "FIRST..END", allow_hyphen_values = true)]
    pub frames: Option<FrameRange>,
    /// Frames before --frames that are drawn and not written, for strokes, temporal anti-aliasing and labels, which
    /// continue from frame to frame [default: as many as the parts need to join]
    #[arg(long, value_name = "COUNT", value_parser = arguments::whole_within::<u64>(ranges::WARM_UP_FRAMES))]
    pub warm_up: Option<u64>,
    /// Time in seconds at which wind is drawn in a single picture; a path has its own times [default: 0]
    #[arg(long, conflicts_with = "path", allow_hyphen_values = true, value_parser = arguments::within(ranges::TIME_S))]
    pub time_s: Option<f64>,
    /// Which eyes are drawn.
    #[command(flatten)]
    pub stereo: StereoArgs,
    /// Set the tones of a style with tone.fit, for a series of pictures with equal ones: the tone of the light, from 0 to 1,
    /// that is drawn dark, the one that is left as paper, and the distance within which half of the land lies, in metres
    /// [default: measured in the picture; `hachure info PICTURE` prints them]
    #[arg(long, value_name = "DARK,WHITE,METRES", allow_hyphen_values = true)]
    pub tone_curve: Option<ToneCurve>,
    /// Samples per pixel, of which the picture is the mean: smoother edges at proportional cost. Additional EXR
    /// channels have one sample [default: 1]
    #[arg(long, value_parser = arguments::whole_within::<u32>(ranges::SAMPLES))]
    pub samples: Option<u32>,
    /// Smoothing of edges along a path: none, or temporal (the mean of consecutive frames) [default: none]
    #[arg(long)]
    pub antialias: Option<Antialias>,
    /// Largest error of the drawn surface, in pixels [default: 1]
    #[arg(long, value_parser = arguments::within(ranges::LOD_ERROR_PX), allow_hyphen_values = true)]
    pub lod_error: Option<f64>,
    /// Point of the measured front.
    #[command(flatten)]
    pub quality: QualityArgs,
    /// Additional EXR channels, separated by commas: depth, position, normal, surface, motion, lsa (error and line of
    /// the contour detector lsa), strokes, tone, hatch (the tone after hatching) [default: none]
    #[arg(long, default_value = "", hide_default_value = true)]
    pub aov: String,
    /// Names of the channels of --aov: hachure (depth.V, position.X, normal.X), or standard (Z, P.X, N.X) for
    /// compositors, where P is the position in the world: metres east, north, up
    #[arg(long, value_name = "NAMES", default_value_t)]
    pub aov_names: Names,
    /// Write this intermediate render target of the frame instead of the drawing. An unknown name lists the available
    /// ones. Prints a warning if a pass writes NaN or infinity
    #[arg(long, value_name = "NAME", conflicts_with_all = ["path", "aov"])]
    pub show: Option<String>,
    /// Add a title block below the picture: this text, the camera's position and the style; for a --map the interval
    /// of contour lines, a scale bar, north, and with --paper or --dpi the scale
    #[arg(long, value_name = "TEXT")]
    pub title: Option<String>,
    /// Write a line of small letters into the title block: the sources of the data, names, a year
    #[arg(long, value_name = "TEXT")]
    pub credits: Option<String>,
    /// Explain the lines and areas of the picture below the title: contour lines, streams, ridge lines, water, land without
    /// data and trees, as far as they are drawn, each with a sample in the inks and widths of the style
    #[arg(long)]
    pub legend: bool,
    #[command(flatten)]
    pub labels: NamesArgs,
    /// On a --map, label up to this many saddles with their heights: those that separate the most prominent summits from
    /// higher land
    #[arg(long, value_name = "COUNT", value_parser = arguments::whole_within::<u32>(ranges::PEAKS))]
    pub saddles: Option<u32>,
    /// On a --map, label up to this many lakes with the heights of their level water, the largest first
    #[arg(long, value_name = "COUNT", value_parser = arguments::whole_within::<u32>(ranges::PEAKS))]
    pub lakes: Option<u32>,
    /// Frame a --map: a border with ticks and labels at round coordinates, in the reference system of the height file.
    /// With --paper or --dpi, a map of all of the land is reduced to the next round scale, such as 1 : 50 000
    #[arg(long = "map-frame")]
    pub frame: bool,
    /// .glb and .stl: largest distance between the triangles and the land along the vertical, in metres [default: a
    /// thousandth of the longer side]
    #[arg(long, value_name = "METRES", value_parser = arguments::above_0, allow_hyphen_values = true)]
    pub mesh_error: Option<f64>,
    /// Memory for heights on the GPU, and as much again in main memory, in MiB; styles with shadows or water need a
    /// quarter more on the GPU for maps of the same tiles, and styles with both a half more [default: 512]
    #[arg(long, value_parser = arguments::whole_within::<u64>(ranges::TILE_MEMORY_MIB))]
    pub tile_memory: Option<u64>,
    /// SVG, PDF and GeoJSON: largest distance between fitted curves and strokes, in pixels [default: 0.25]
    #[arg(long, allow_hyphen_values = true, value_parser = arguments::within(ranges::TOLERANCE_PX))]
    pub tolerance_px: Option<f64>,
    /// Paper size: a0 to a6, letter, legal, tabloid or WIDTHxHEIGHT in millimetres; the size in pixels follows from
    /// --dpi. An .svg or .pdf without --dpi is scaled to fit, in the orientation of the picture
    #[arg(long)]
    pub paper: Option<String>,
    /// Landscape orientation of --paper (the default, except of an .svg or .pdf without --dpi, and of a --map of all of
    /// the land, which has the orientation in which the land is larger)
    #[arg(long, conflicts_with = "portrait")]
    pub landscape: bool,
    /// Portrait orientation of --paper
    #[arg(long)]
    pub portrait: bool,
    /// SVG and PDF on --paper: margin around the picture, in millimetres [default: 10]
    #[arg(long, allow_hyphen_values = true, value_parser = arguments::within(ranges::MARGIN_MM))]
    pub margin: Option<f64>,
    /// How the picture is cut into sheets of paper.
    #[command(flatten)]
    pub sheets: SheetArgs,
    /// SVG, PDF and GeoJSON: number of pens to draw with, 1 to 3, each of one width and opaque; the widths are chosen to
    /// suit the picture
    #[arg(long, value_name = "COUNT", value_parser = arguments::whole_within::<usize>(ranges::PENS))]
    pub pens: Option<usize>,
    /// Replace files that hachure did not write where their names follow from the output: frames, sheets, and the world
    /// file and .aux.xml of a map. The output itself is always replaced
    #[arg(long)]
    pub overwrite: bool,
    /// Print a report of the picture and its cost as JSON
    #[arg(long)]
    pub json: bool,
}

/// The size without `--size`, in pixels.
const SIZE_PX: [u32; 2] = [1280, 720];
/// The memory for tiles without `--tile-memory`, in MiB.
pub(crate) const TILE_MEMORY_MIB: u64 = 512;
/// The style without `--style`.
const STYLE: &str = "ink";

impl RenderArgs {
    /// Returns the size of one eye's picture, in pixels.
    pub(crate) fn size(&self) -> [u32; 2] {
        self.size.unwrap_or(SIZE_PX)
    }

    /// Returns the size of the whole picture, in pixels: side by side, it is twice as wide.
    pub(crate) fn size_of_all(&self) -> [u32; 2] {
        let [width, height] = self.size();
        [if self.stereo.eyes() == Eyes::SideBySide { 2 * width } else { width }, height]
    }

    /// Returns the frames per second along the path.
    pub(crate) fn fps(&self) -> FrameRate {
        self.fps.unwrap_or(FrameRate::Number(30.0))
    }

    /// Returns the samples per pixel.
    pub(crate) fn samples(&self) -> u32 {
        self.samples.unwrap_or(1)
    }

    /// Returns the largest error of the drawn surface, in pixels.
    pub(crate) fn lod_error(&self) -> f64 {
        self.lod_error.unwrap_or(1.0)
    }

    /// Returns how edges are smoothed along a path.
    pub(crate) fn antialias(&self) -> Antialias {
        self.antialias.unwrap_or_default()
    }

    /// Returns the memory for tiles, in MiB.
    pub(crate) fn tile_memory(&self) -> u64 {
        self.tile_memory.unwrap_or(TILE_MEMORY_MIB)
    }

    /// Returns how many output pixels are one pixel of the style.
    pub(crate) fn px_per_style_px(&self) -> f64 {
        self.dpi.map_or(1.0, |dpi| dpi / REFERENCE_DPI)
    }
}

/// Largest number of frames along a path: more than a day at 60 frames per second.
const MAX_FRAMES: usize = 10_000_000;

/// Parses a size such as `1280x720`.
///
/// # Errors
/// Returns the required form of the value.
pub(crate) fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let wrong = || "it must be a size like 1280x720".to_owned();
    let (width, height) = text.split_once(['x', 'X']).ok_or_else(wrong)?;
    let is_number = |side: &str| !side.is_empty() && side.bytes().all(|byte| byte.is_ascii_digit());
    if !is_number(width) || !is_number(height) {
        return Err(wrong());
    }
    let parse = |side: &str| ranges::SIDE_PX.parse_whole(side).map_err(|rule| rule.replacen("it", "each side", 1));
    let size = [parse(width)?, parse(height)?];
    ranges::check_pixels(size)?;
    Ok(size)
}

/// Parses the scale of a map, `50000` or `1:50000`; blanks are ignored.
///
/// # Errors
/// Returns the required form of the value.
fn parse_scale(text: &str) -> Result<f64, String> {
    let bare: String = text.chars().filter(|it| !it.is_whitespace()).collect();
    let digits = bare.strip_prefix("1:").unwrap_or(&bare);
    let number = digits.parse().ok().filter(|number| ranges::MAP_SCALE.holds(*number));
    number.ok_or_else(|| format!("{}, such as 50000 or 1:50000", ranges::MAP_SCALE.rule()))
}

/// Returns the arguments with what `--quality` sets. A picture has the size of `--size`, whatever the render scale of the
/// quality is, and only frames of a path are smoothed in time.
///
/// # Errors
/// The errors of [`QualityArgs::setting`], and [`Misuse`] for a picture that is drawn again.
fn with_quality(mut args: RenderArgs) -> anyhow::Result<RenderArgs> {
    if args.like.is_some() && args.quality.quality.is_some() {
        bail!(Misuse("--quality: does not apply to --like, which draws with the values of the picture".to_owned()));
    }
    let Some(setting) = args.quality.setting(args.style.as_deref().unwrap_or(STYLE), Use::Picture)? else {
        return Ok(args);
    };
    args.lod_error = args.lod_error.or(setting.lod_error_px);
    if args.path.is_some() {
        args.antialias = args.antialias.or(setting.antialias);
    }
    // Values of the command line come last, and win.
    args.set.splice(0..0, setting.values);
    Ok(args)
}

/// Runs the command.
///
/// # Errors
/// Fails if an input is invalid or if the output cannot be written.
pub(crate) fn run(args: &RenderArgs, adapter: &AdapterWish) -> anyhow::Result<()> {
    run_with(args, None, adapter, &mut Host::default())
}

/// Runs the command inside another program, which gives the GPU.
///
/// # Errors
/// The errors of the command.
pub(crate) fn run_hosted(args: &RenderArgs, mut host: Host<'_>) -> anyhow::Result<()> {
    run_with(args, None, &AdapterWish::Best, &mut host)
}

/// Runs the command with the heights of the world, if they are open already, and with what the host gives.
fn run_with(
    given: &RenderArgs,
    heights: Option<Arc<dyn TileStore>>,
    adapter: &AdapterWish,
    host: &mut Host<'_>,
) -> anyhow::Result<()> {
    let args = given;
    let kind = OutputKind::of(&args.output).map_err(Misuse::of)?;
    mesh::check(args, &kind)?;
    if let OutputKind::Mesh(format) = kind {
        args.world.check()?;
        return mesh::run(args, format, &args.world.scene()?);
    }
    let has_curve = args.tone_curve.is_some();
    map::check_scale(args)?;
    let args = paper::measured(args, &kind)?;
    let (args, liked) = like::resolved(&args, &kind)?;
    let args = &with_quality(args)?;
    map::check(args, &kind)?;
    names::check(args, &kind)?;
    look::check(args)?;
    check_path(args, &kind)?;
    frames::check(args, &kind)?;
    show::check(args, &kind)?;
    check_eyes(args, &kind)?;
    check_antialias(args, &kind)?;
    let style = match host.style.clone().or(liked.style) {
        Some(style) => arguments::with_values(style, &args.set)?,
        None => arguments::style_with("--set", args.style.as_deref().unwrap_or(STYLE), &args.set)?,
    };
    if has_curve && !style.fits_tones() {
        let misuse = format!(
            "--tone-curve: the style {} does not fit its tones to the picture; choose one with tone.fit = true, such as pencil",
            style.name
        );
        return Err(Misuse(misuse).into());
    }
    // Read the world before the GPU is opened: its errors can be reported without one.
    let scene = match host.has_heights_in_memory() {
        true => args.world.scene_in_memory(),
        false => liked.names.world(args.world.scene()),
    };
    let style = match &scene {
        Ok(scene) => style.with_features([!scene.features.is_empty(), scene.graticule.is_some()]),
        Err(_) => style,
    };
    let of_view = if args.map.is_some() { style.clone().on_map()? } else { style.clone() };
    let (style, as_written) = (of_view.scaled(args.px_per_style_px()), style);
    let titled = title::with_foot(style.clone(), args, &kind)?;
    // On a map, contour lines of height have an interval, whatever its scale.
    let of_map = args.map.is_some().then(|| style.clone().for_map(1.0)).transpose()?;
    let svg = SvgOptions::new(args, &kind, of_map.as_ref().unwrap_or(&style))?;
    map::check_paper(args, paper::mm_per_px(args, svg.as_ref()))?;
    let sheets = sheets::plan(args, &kind, args.size_of_all(), svg.as_ref())?;
    let left_out = vector::left_out(of_map.as_ref().unwrap_or(&style), args.stereo.eyes()).filter(|_| svg.is_some());
    let planes = aov::planes_named(&args.aov, args.aov_names, of_map.as_ref().unwrap_or(&style)).map_err(Misuse::of)?;
    if !planes.is_empty()
        && !matches!(kind, OutputKind::Picture(PictureFormat::Exr) | OutputKind::Frames(_, PictureFormat::Exr))
    {
        let output = named(&args.output);
        let misuse = format!("--aov: only an .exr can hold additional channels, and the output is {output}");
        return Err(Misuse(misuse).into());
    }
    if planes.is_empty() && args.aov_names != Names::Hachure {
        return Err(Misuse("--aov-names: requires --aov, which is not given".to_owned()).into());
    }
    let folder = args.output.parent().filter(|folder| !folder.as_os_str().is_empty());
    if let Some(folder) = folder.filter(|folder| !matches!(kind, OutputKind::Frames(..)) && !folder.is_dir()) {
        bail!("cannot write {}: there is no folder {}", named(&args.output), named(folder));
    }
    if !host.has_heights_in_memory() {
        args.world.check()?;
    }
    let scene = scene?;
    let scene = if args.map.is_some() { scene.for_map() } else { scene };
    // Read only once: it may be a pipe.
    let flight = args.path.as_deref().map(arguments::camera_path).transpose()?;
    if let (Some(name), Some(flight)) = (&args.path, &flight) {
        path_fit::check_name(name, args.world.name(), &scene.world)?;
        liked.names.path(outputs::check_flight(args, name, flight))?;
    }
    place_args::check_procedural(&args.look, &args.map_place, args.world.name(), &scene.world)?;
    outputs::check(args, &kind, sheets.as_ref(), &scene, &style, flight.as_deref())?;
    let store = match heights.map_or_else(|| host.store(&scene), |store| Ok(Some(store)))? {
        Some(store) => store,
        None => {
            let store = world::open_store(&scene, &Bar::default()).map_err(|error| args.world.or_drawing(error));
            liked.names.world(store)?
        }
    };
    let page = map::Page {
        edges: Edges {
            foot_px: titled.paper.foot_px as u32,
            frame_px: if args.frame { map_frame::edge_px(&titled.paper) } else { 0 },
        },
        mm_per_px: paper::mm_per_px(args, svg.as_ref()),
    };
    if let Some(upright) = paper::upright(given, args, &*store, &page)? {
        return run_with(&upright, Some(store), adapter, host);
    }
    if let Some(unscaled) = as_written.unscaled().filter(|_| args.px_per_style_px() != 1.0) {
        let dpi = args.dpi.unwrap_or(REFERENCE_DPI);
        tracing::warn!("at {dpi} dots per inch, these values of the style keep their size in pixels: {unscaled}");
    }
    map::check_place(args, &kind, store.georeference())?;
    let is_own = liked.names.has_own_labels();
    let places = liked.names.labels(names::places(&args.labels, &*store, is_own))?;
    let looked_at_m = args.look.place_m(args.world.name(), &*store)?;
    let around = map::around_place(args, &*store)?;
    let args = around.as_ref().unwrap_or(args);
    let gpu = match &host.gpu {
        Some(gpu) => gpu.clone(),
        None => {
            let gpu = Gpu::open(adapter)?;
            world::store_pipelines(&gpu);
            gpu
        }
    };
    let options = TerrainOptions {
        lod_error_px: args.lod_error(),
        tile_memory_bytes: args.tile_memory() << 20,
        loading: Loading::Wait,
        ..TerrainOptions::default()
    };
    let (asked, asked_options) = (scene.clone(), options);
    let world = match host.opened(&asked, &asked_options) {
        Some(world) => world,
        None => liked.names.world(OpenWorld::on_gpu_with(&gpu, scene, store, options, &Bar::default()))?,
    };
    let opened_scene = world.scene.clone();
    args.world.land.warn(&world, &style);
    world.surfaces.feature_doubts(&style).iter().for_each(|doubt| tracing::warn!("{doubt}"));
    let looking = looked_at_m.map(|place_m| args.look.camera(place_m, &world, look::aspect(args))).transpose()?;
    let looking = looking.map(|camera| RenderArgs { camera: Some(camera), ..args.clone() });
    let args = looking.as_ref().unwrap_or(args);
    let scaled = map::at_scale(args, &world, &page)?;
    let args = scaled.as_ref().unwrap_or(args);
    let on_the_earth = map::on_the_earth(args, &kind, &world, &page)?;
    let args = on_the_earth.as_ref().unwrap_or(args);
    let drawn = DrawingReport::default();
    let clock = Clock::still(args.time_s.unwrap_or(0.0));
    let map = map::PlacedMap::new(args, &kind, &world, &page)?;
    let style = match &map {
        Some(map) => titled.for_map(map.map.pixel_m * args.px_per_style_px())?,
        None => titled,
    };
    let camera = map.as_ref().map_or_else(|| host.start_camera(args, &world), |map| Map::camera(&map.pose));
    let imprint = like::imprint(args, &kind, &as_written, &camera);
    let mut job = Job {
        args,
        flight,
        places,
        names: None,
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
        tone_curve: None,
        imprint,
        drawing: job::Drawing::default(),
        take: host.take.take(),
    };
    if let (Some(name), Some(flight)) = (&args.path, &job.flight) {
        path_fit::check_places(name, flight, &job.world.surfaces.terrain.ground_heights())?
            .iter()
            .for_each(|warning| tracing::warn!("{warning}"));
    }
    let cameras = job.cameras()?;
    args.world.light.place_sun(&mut job.world.scene.sun, &cameras[0]);
    job.imprint.sun = job.world.scene.sun;
    job.warn_of_camera_below_ground(&cameras);
    job.world.ground_was_read()?;
    job.place_eyes(&cameras)?;
    if args.json {
        job.warm_up(&cameras[0])?;
    }
    let written = frames::written(args, cameras.len())?;
    job.warn_of_short_part(&written);
    let is_on_earth = matches!(kind, OutputKind::Picture(PictureFormat::GeoJson));
    let report = job.run(kind, &cameras, written.clone())?;
    job.warn_of_absence(&report);
    job.sheets.iter().for_each(|cut| sheets::warn_of_older(args, cut));
    if report.tiles_missing > 0 {
        tracing::warn!(
            "{} tiles did not fit into --tile-memory {}; coarser ones were drawn instead",
            report.tiles_missing,
            args.tile_memory()
        );
    }
    if report.memory_factor > 1.0 {
        tracing::warn!(
            "the heights of this view do not fit into --tile-memory {}: the surface may be off by {:.1} px instead of {} px",
            args.tile_memory(),
            args.lod_error() * report.memory_factor,
            args.lod_error()
        );
    }
    if report.over_budget > 0 {
        tracing::warn!("{}", over_budget_warning(&report, written.clone().count(), args.lod_error()));
    }
    if let Some(left_out) = left_out {
        tracing::warn!("{}: leaves out {left_out} of the style", named(&args.output));
    }
    if !is_on_earth && job.leaves_out_tints() {
        tracing::warn!(
            "{}: leaves out the tints of areas; features.hatch_px (--set features.hatch_px=6) fills them with lines",
            named(&args.output)
        );
    }
    if host.is_given() {
        job.world.scene = opened_scene;
        host.keep(asked, asked_options, job.world);
        return Ok(());
    }
    if args.json {
        let report = job.report(&cameras, written, report);
        return print_json(&report);
    }
    let summaries = job.svg.as_ref().map(|svg| svg.summary(&job.drawn, is_on_earth)).into_iter();
    summaries.chain(job.sheets.as_ref().map(|cut| sheets::summary(args, cut))).try_for_each(|line| print(&line))
}

/// Checks that `--path` and an output of many pictures are given together, so that nobody waits for a film of one
/// frame.
fn check_path(args: &RenderArgs, kind: &OutputKind) -> Result<(), Misuse> {
    let output = named(&args.output);
    match (kind, &args.path) {
        (OutputKind::Picture(_), Some(_)) => Err(Misuse(format!(
            "--path draws many frames, and {output} is one picture; write frames to a pattern like dir/%05d.png or a \
             film to .mp4 or .gif, or use --camera for one picture"
        ))),
        (OutputKind::Frames(..), None) => {
            let paths = embedded::path_names();
            Err(Misuse(format!(
                "{output}: a pattern of frames requires a camera path; add --path FILE, or a built-in path ({paths})"
            )))
        }
        (OutputKind::Mp4 | OutputKind::Gif, None) => {
            let paths = embedded::path_names();
            Err(Misuse(format!(
                "{output}: a film requires a camera path; add --path FILE, or a built-in path ({paths}), or write one \
                 picture to .png, .jpg, .exr, .svg or .pdf"
            )))
        }
        _ => Ok(()),
    }
}

/// Checks that the output can hold the eyes, and that the other options support them.
fn check_eyes(args: &RenderArgs, kind: &OutputKind) -> Result<(), Misuse> {
    args.stereo.check()?;
    let (eyes, output) = (args.stereo.eyes(), named(&args.output));
    if eyes == Eyes::Mono {
        return Ok(());
    }
    if kind.is_drawing() && eyes == Eyes::SideBySide {
        let holder = kind.lines_name();
        let misuse = format!("--eyes {eyes}: {holder} shows one eye or an anaglyph, and the output is {output}");
        return Err(Misuse(misuse));
    }
    if args.show.is_some() {
        return Err(Misuse(format!("--eyes {eyes}: --show requires --eyes mono")));
    }
    if eyes.are_merged() && !args.aov.is_empty() {
        return Err(Misuse(
            "--aov: an anaglyph merges both eyes into one picture; use --eyes side-by-side for the channels of each"
                .into(),
        ));
    }
    Ok(())
}

/// Checks that temporal anti-aliasing is possible: it needs consecutive frames, each of one sample and drawn in one
/// part.
fn check_antialias(args: &RenderArgs, kind: &OutputKind) -> Result<(), Misuse> {
    if args.antialias() == Antialias::None {
        return Ok(());
    }
    let why = match kind {
        _ if args.path.is_none() => "requires consecutive frames along a --path; use --samples for a single picture",
        _ if kind.is_drawing() => "an .svg or .pdf has no pixels to smooth",
        _ if args.samples() > 1 => "cannot be combined with --samples above 1",
        _ if !args.aov.is_empty() => "cannot be combined with --aov, which needs frames without jitter",
        _ if !PartRule::default().is_whole(args.size()) => {
            "frames as large as --size are drawn in parts; use --samples"
        }
        _ => return Ok(()),
    };
    Err(Misuse(format!("--antialias temporal: {why}")))
}

/// Returns the warning that a picture, or some frames of a film, exceed `--lod-error`.
fn over_budget_warning(report: &PictureReport, frames: usize, lod_error: f64) -> String {
    let of = if frames > 1 { format!(" in {} of {frames} frames", report.over_budget) } else { String::new() };
    format!(
        "the surface error is {:.2} px{of} instead of --lod-error {lod_error}, which would need more triangles than \
         are allowed for a picture of this size",
        report.error_px
    )
}
