//! `hachure render`: a DEM becomes a drawing in a file, or a camera path a row of them.

mod show;
mod vector;

use std::path::{Path, PathBuf};

use anyhow::{anyhow, bail};
use clap::Args;
use serde::Serialize;

use self::vector::SvgOptions;
use super::arguments;
use super::height_args::HeightArgs;
use super::misuse::Misuse;
use super::progress::Bar;
use super::{inputs, print, print_json};
use crate::file::FileError;
use crate::file::exr::{ExrWriter, SampleKind, SamplesRef};
use crate::file::message::named;
use crate::file::pattern::{OutputKind, PictureFormat};
use crate::file::png::PngWriter;
use crate::file::video::VideoWriter;
use crate::frame::Frame;
use crate::gpu::Gpu;
use crate::gpu::device::AdapterWish;
use crate::picture::aov::{self, Plane};
use crate::picture::{self, Band, PictureReport, PictureRequest};
use crate::scene::Scene;
use crate::scene::camera::Camera;
use crate::scene::path::CameraPath;
use crate::scene::reach::Reach;
use crate::scene::view::Pose;
use crate::style::Style;
use crate::tiles::terrain::{Loading, TerrainOptions};
use crate::vector::DrawingReport;
use crate::world::{self, OpenWorld};

/// Arguments of `render`.
#[derive(Debug, Args)]
pub struct RenderArgs {
    /// Scene file, DEM, baked pyramid, or a scene inside hachure (continent, hut); without one, the embedded world
    pub world: Option<String>,
    /// What height files leave open.
    #[command(flatten)]
    pub heights: HeightArgs,
    /// Let a scene file name files outside of its folder, and addresses
    #[arg(long)]
    pub trust_scene: bool,
    /// .png, .exr, .mp4 or .svg (the strokes of a style that has them), or frames: a pattern like dir/%05d.png
    #[arg(short, long)]
    pub output: PathBuf,
    /// A preset or a style file
    #[arg(long, default_value = "ink")]
    pub style: String,
    /// Width and height in pixels, like 1280x720
    #[arg(long, default_value = "1280x720", value_parser = parse_size)]
    pub size: [u32; 2],
    /// x,y,z,yaw,pitch,fov: metres (z as +h above ground), degrees
    #[arg(long, allow_hyphen_values = true, conflicts_with = "path")]
    pub camera: Option<Camera>,
    /// Camera path: CSV with the header t,x,y,z,yaw,pitch,fov, or one inside hachure (tour, valley, teleport)
    #[arg(long)]
    pub path: Option<PathBuf>,
    /// Frames per second along the path
    #[arg(long, default_value_t = 30.0, value_parser = arguments::frame_rate, allow_hyphen_values = true)]
    pub fps: f64,
    /// How many eyes: mono
    #[arg(long, default_value = "mono", value_parser = super::parse_eyes)]
    pub eyes: String,
    /// Height error that may be seen, in pixels
    #[arg(long, default_value_t = 1.0, value_parser = arguments::above_0, allow_hyphen_values = true)]
    pub lod_error: f64,
    /// Channels of an EXR beside its colour: depth, position, normal, surface, motion, lsa, strokes, tone,
    /// hatch (the tone after the marks)
    #[arg(long, default_value = "")]
    pub aov: String,
    /// Write this picture of the frame, as its passes left it, instead of the drawing; a name that there is not tells
    /// which there are
    #[arg(long, value_name = "NAME", conflicts_with_all = ["path", "aov"])]
    pub show: Option<String>,
    /// Memory for tiles on the GPU, in MiB
    #[arg(long, default_value_t = 512, value_parser = arguments::whole::<u64>(1, 1 << 20))]
    pub tile_memory: u64,
    /// Of an .svg: how far its curves may be from the strokes, in pixels [default: 0.25]
    #[arg(long, allow_hyphen_values = true, value_parser = arguments::from_to(0.01, 100.0))]
    pub tolerance_px: Option<f64>,
    /// Of an .svg: the sheet, a0 to a6, letter, legal, tabloid or WIDTHxHEIGHT in millimetres, turned as the picture
    /// is; without it, a unit of the file is a pixel
    #[arg(long)]
    pub paper: Option<String>,
    /// Of an .svg on --paper: what stays free around the picture, in millimetres [default: 10]
    #[arg(long, allow_hyphen_values = true, value_parser = arguments::from_to(0.0, 100_000.0))]
    pub margin: Option<f64>,
    /// Print what it cost, for programs
    #[arg(long)]
    pub json: bool,
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

#[derive(Serialize)]
struct Report {
    adapter: String,
    output: PathBuf,
    style: String,
    size: [u32; 2],
    frames: u64,
    wall_ms: f64,
    passes: Vec<PassReport>,
    triangles: u64,
    patches: u64,
    parts: u64,
    tiles_loaded: u64,
    tiles_missing: u64,
    /// The height error that the mesh was allowed, in pixels: --lod-error, or more where that takes too many triangles.
    allowed_error_px: f64,
    over_budget_frames: u64,
    gpu_bytes: u64,
    camera: String,
    /// Of an SVG.
    svg: Option<DrawingReport>,
    /// On paper.
    mm_per_px: Option<f64>,
}

#[derive(Serialize)]
struct PassReport {
    name: String,
    gpu_ms: f64,
}

/// Runs the command.
///
/// # Errors
/// When an input does not hold or the output cannot be written.
pub fn run(args: &RenderArgs, adapter: &AdapterWish) -> anyhow::Result<()> {
    let kind = OutputKind::of(&args.output).map_err(Misuse::of)?;
    check_path(args, &kind)?;
    show::check(args, &kind)?;
    let style = arguments::style(&args.style)?;
    let svg = SvgOptions::new(args, &kind, &style)?;
    let planes = aov::planes(&args.aov, &style).map_err(Misuse::of)?;
    if !planes.is_empty()
        && !matches!(kind, OutputKind::Picture(PictureFormat::Exr) | OutputKind::Frames(_, PictureFormat::Exr))
    {
        let output = named(&args.output);
        let misuse = format!("--aov: only an .exr has room for channels beside the colour, and the output is {output}");
        return Err(Misuse(misuse).into());
    }
    let folder = args.output.parent().filter(|folder| !folder.as_os_str().is_empty());
    if let Some(folder) = folder.filter(|folder| !matches!(kind, OutputKind::Frames(..)) && !folder.is_dir()) {
        bail!("cannot write {}: there is no folder {}", named(&args.output), named(folder));
    }
    arguments::check_world(args.world.as_deref())?;
    // The world first: what is wrong with it needs no GPU to be told.
    let scene = args.heights.over(world::scene_of(args.world.as_deref(), Reach::trusting(args.trust_scene))?);
    // Read once: it may be a pipe.
    let flight = args.path.as_deref().map(CameraPath::read_text).transpose()?;
    check_outputs(args, &kind, &scene, &style, flight.as_deref())?;
    let store = world::open_store(&scene, &Bar::default())?;
    let gpu = Gpu::open(adapter)?;
    let options = TerrainOptions {
        lod_error_px: args.lod_error,
        tile_memory_bytes: args.tile_memory << 20,
        loading: Loading::Wait,
        ..TerrainOptions::default()
    };
    let world = OpenWorld::on_gpu(&gpu, scene, store, options)?;
    let mut job = Job { args, flight, style, planes, gpu, world, frame: None, svg, drawn: DrawingReport::default() };
    let cameras = job.cameras()?;
    job.world.ground_was_read()?;
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
        tracing::warn!("{}", told_over_budget(&report, cameras.len(), args.lod_error));
    }
    if args.json {
        let report = job.report(&cameras, report);
        return print_json(&report);
    }
    match &job.svg {
        Some(svg) => print(&svg.told(&job.drawn)),
        None => Ok(()),
    }
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

/// What a picture, or some of a film's, is drawn with instead of `--lod-error`.
fn told_over_budget(report: &PictureReport, frames: usize, lod_error: f64) -> String {
    let of = if frames > 1 { format!(" in {} of {frames} frames", report.over_budget) } else { String::new() };
    format!(
        "the surface was drawn to within {:.2} px{of} instead of --lod-error {lod_error}: that takes more triangles than a \
         picture of this size has",
        report.error_px
    )
}

/// Whether nothing that is to be written is read.
fn check_outputs(
    args: &RenderArgs,
    kind: &OutputKind,
    scene: &Scene,
    style: &Style,
    flight: Option<&str>,
) -> anyhow::Result<()> {
    let inputs = inputs::of(args.world.as_deref(), scene, std::slice::from_ref(style), args.path.as_deref());
    let OutputKind::Frames(pattern, _) = kind else { return Ok(inputs.check(&args.output)?) };
    // How many frames there are does not depend on the ground.
    let path = match (flight, &args.path) {
        (Some(flight), Some(name)) => CameraPath::parse_on_ground(name, flight.as_bytes(), |_, _| 0.0)?,
        _ => return Ok(inputs.check(&pattern.path(0))?),
    };
    // A rate that makes no sense is refused before the first frame.
    let frames = path.frame_count(args.fps.clamp(0.0, 1000.0)).min(MOST_FRAMES) as u64;
    Ok((0..frames).try_for_each(|frame| inputs.check(&pattern.path(frame)))?)
}

struct Job<'a> {
    args: &'a RenderArgs,
    /// The text of `--path`.
    flight: Option<String>,
    style: Style,
    planes: Vec<Plane>,
    gpu: Gpu,
    world: OpenWorld,
    frame: Option<Frame>,
    svg: Option<SvgOptions>,
    drawn: DrawingReport,
}

impl Job<'_> {
    /// The cameras of the frames: at least one.
    fn cameras(&self) -> anyhow::Result<Vec<Camera>> {
        let (Some(name), Some(flight)) = (&self.args.path, &self.flight) else {
            return Ok(vec![self.args.camera.unwrap_or_else(|| self.world.default_camera())]);
        };
        let path = CameraPath::parse_on_ground(name, flight.as_bytes(), |x, y| self.world.ground_m(x, y))?;
        let frames = path.frame_count(self.args.fps);
        if frames > MOST_FRAMES {
            bail!("--path at {} frames a second has {frames} frames, more than {MOST_FRAMES}", self.args.fps);
        }
        Ok(path.frames(self.args.fps).collect())
    }

    /// Draws a thumbnail for nobody: drivers compile pipelines on their first use, which is no part of a pass's time.
    fn warm_up(&mut self, camera: &Camera) -> anyhow::Result<()> {
        let eye = self.world.pose(camera);
        let light = self.world.light();
        let request =
            PictureRequest { planes: &self.planes, ..PictureRequest::still(eye, [64, 36], &self.style, light) };
        picture::render(&self.gpu, &mut self.frame, &mut self.world.surfaces, &request, |_| Ok::<_, FileError>(()))?;
        Ok(())
    }

    fn run(&mut self, kind: OutputKind, cameras: &[Camera]) -> anyhow::Result<PictureReport> {
        let [width, height] = self.args.size;
        let output = self.args.output.clone();
        let mut film = match kind {
            OutputKind::Mp4 => Some(VideoWriter::create(&output, width, height, self.args.fps)?),
            _ => None,
        };
        let mut total = PictureReport::default();
        let mut previous = None;
        for (number, camera) in cameras.iter().enumerate() {
            let pose = self.world.pose(camera);
            let previous = previous.replace(pose).unwrap_or(pose);
            let report = match (&kind, &mut film) {
                (OutputKind::Picture(_), _) if self.args.show.is_some() => self.show(&output, pose)?,
                (OutputKind::Picture(format), _) => self.picture(&output, *format, pose, previous)?,
                (OutputKind::Frames(pattern, format), _) => {
                    self.picture(&pattern.prepare(number as u64)?, *format, pose, previous)?
                }
                (OutputKind::Mp4, Some(film)) => {
                    let mut rows = Vec::new();
                    let report = self.render(pose, previous, |band| {
                        rows.extend(picture::srgb8(&band.picture));
                        Ok(())
                    })?;
                    film.write_frame(&rows)?;
                    report
                }
                (OutputKind::Mp4, None) => unreachable!("the film was made above"),
            };
            total.append(report);
        }
        if let Some(film) = film {
            film.finish()?;
        }
        Ok(total)
    }

    fn picture(
        &mut self,
        path: &Path,
        format: PictureFormat,
        pose: Pose,
        previous: Pose,
    ) -> anyhow::Result<PictureReport> {
        let [width, height] = self.args.size;
        match format {
            PictureFormat::Png => {
                let mut writer = PngWriter::create(path, width, height)?;
                let report = self.render(pose, previous, |band| writer.write_rows(&picture::srgb8(&band.picture)))?;
                writer.finish()?;
                Ok(report)
            }
            PictureFormat::Exr => {
                let mut channels = ["R", "G", "B", "A"].map(|name| (name, SampleKind::F32)).to_vec();
                channels.extend(self.planes.iter().map(|plane| (plane.name.as_str(), plane.source.kind())));
                let attributes = [("camera".to_owned(), self.camera_text(pose))];
                let mut writer = ExrWriter::create(path, width, height, &channels, &attributes)?;
                let report = self.render(pose, previous, |band| {
                    let colour: [Vec<f32>; 4] =
                        [0, 1, 2, 3].map(|i| band.picture.iter().map(|texel| texel[i]).collect());
                    let mut rows: Vec<_> = colour.iter().map(|samples| SamplesRef::F32(samples)).collect();
                    rows.extend(band.planes.iter().map(|samples| samples.as_ref()));
                    writer.write_rows(&rows)
                })?;
                writer.finish()?;
                Ok(report)
            }
            PictureFormat::Svg => self.lines(path, pose),
        }
    }

    fn render(
        &mut self,
        pose: Pose,
        previous: Pose,
        take: impl FnMut(Band) -> Result<(), FileError>,
    ) -> anyhow::Result<PictureReport> {
        let request = PictureRequest {
            pose,
            previous,
            size_px: self.args.size,
            style: &self.style,
            light: self.world.light(),
            planes: &self.planes,
        };
        if let Some(frame) = &mut self.frame {
            frame.set_step_s(1.0 / self.args.fps);
        }
        let report = picture::render(&self.gpu, &mut self.frame, &mut self.world.surfaces, &request, take)?;
        self.whole(report)
    }

    /// The report, if it is of all that was to be drawn.
    fn whole(&self, report: PictureReport) -> anyhow::Result<PictureReport> {
        self.world.ground_was_read()?;
        // A drawing of something else than the data is no drawing.
        match (report.tiles_failed, self.world.surfaces.terrain.failure()) {
            (0, _) => Ok(report),
            (1, Some(failure)) => Err(anyhow!(failure).context("a tile could not be read")),
            (tiles, Some(failure)) => Err(anyhow!(failure).context(format!("{tiles} tiles could not be read"))),
            (tiles, None) => bail!("{}: {tiles} tiles could not be read", self.world.surfaces.terrain.store().name()),
        }
    }

    /// The eye in the world's frame: what turns camera-relative positions into places.
    fn camera_text(&self, pose: Pose) -> String {
        let camera = self.world.camera(&pose);
        camera.to_string()
    }

    fn report(&self, cameras: &[Camera], report: PictureReport) -> Report {
        let camera = self.world.camera(&self.world.pose(&cameras[0])).to_string();
        Report {
            adapter: self.gpu.description(),
            output: self.args.output.clone(),
            style: self.style.name.clone(),
            size: self.args.size,
            frames: cameras.len() as u64,
            wall_ms: report.wall_ms,
            passes: report.passes.into_iter().map(|time| PassReport { name: time.name, gpu_ms: time.gpu_ms }).collect(),
            triangles: report.triangles,
            patches: report.patches,
            parts: report.parts,
            tiles_loaded: report.tiles_loaded,
            tiles_missing: report.tiles_missing,
            allowed_error_px: report.error_px,
            over_budget_frames: report.over_budget,
            gpu_bytes: self.gpu.memory_bytes(),
            camera,
            mm_per_px: self.svg.as_ref().and_then(SvgOptions::mm_per_px),
            svg: self.svg.is_some().then(|| self.drawn.clone()),
        }
    }
}
