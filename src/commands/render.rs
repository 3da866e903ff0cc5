//! `hachure render`: a DEM becomes a drawing in a file, or a camera path a row of them.

mod vector;

use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::Args;
use serde::Serialize;

use self::vector::SvgOptions;
use super::progress::Bar;
use super::{inputs, tell, tell_json};
use crate::file::FileError;
use crate::file::exr::{ExrWriter, SampleKind, SamplesRef};
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
use crate::style::Style;
use crate::surface::view::Pose;
use crate::tiles::terrain::{Loading, TerrainOptions};
use crate::tones::hatching::maps;
use crate::vector::DrawingReport;
use crate::world::{self, OpenWorld};

/// Arguments of `render`.
#[derive(Debug, Args)]
pub struct RenderArgs {
    /// Scene file, DEM or baked pyramid; without one, the embedded world
    pub world: Option<String>,
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
    /// Camera path: CSV with the header t,x,y,z,yaw,pitch,fov
    #[arg(long)]
    pub path: Option<PathBuf>,
    /// Frames per second along the path
    #[arg(long, default_value_t = 30.0)]
    pub fps: f64,
    /// How many eyes: mono
    #[arg(long, default_value = "mono", value_parser = super::parse_eyes)]
    pub eyes: String,
    /// Height error that may be seen, in pixels
    #[arg(long, default_value_t = 1.0)]
    pub lod_error: f64,
    /// Channels of an EXR beside its colour: depth, position, normal, surface, motion, lsa, strokes, tone,
    /// hatch (the tone after the marks)
    #[arg(long, default_value = "")]
    pub aov: String,
    /// Memory for tiles on the GPU, in MiB
    #[arg(long, default_value_t = 512, value_parser = clap::value_parser!(u64).range(1..=1 << 20))]
    pub tile_memory: u64,
    /// Of an .svg: how far its curves may be from the strokes, in pixels [default: 0.25]
    #[arg(long, allow_hyphen_values = true)]
    pub tolerance_px: Option<f64>,
    /// Of an .svg: the sheet, a0 to a6, letter, legal, tabloid or WIDTHxHEIGHT in millimetres, turned as the picture
    /// is; without it, a unit of the file is a pixel
    #[arg(long)]
    pub paper: Option<String>,
    /// Of an .svg on --paper: what stays free around the picture, in millimetres [default: 10]
    #[arg(long, allow_hyphen_values = true)]
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
        .ok_or_else(|| format!("{text:?} is not a size like 1280x720"))
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
    let kind = OutputKind::of(&args.output)?;
    let style = Style::load(&args.style)?;
    maps::check(&style)?;
    let svg = SvgOptions::new(args, &kind, &style)?;
    let planes = aov::planes(&args.aov, &style)?;
    if !planes.is_empty()
        && !matches!(kind, OutputKind::Picture(PictureFormat::Exr) | OutputKind::Frames(_, PictureFormat::Exr))
    {
        bail!(
            "--aov: only an .exr has room for channels beside the colour, and the output is {}",
            args.output.display()
        );
    }
    if !(args.lod_error > 0.0 && args.lod_error.is_finite()) {
        bail!("--lod-error {}: it must be a number above 0", args.lod_error);
    }
    let folder = args.output.parent().filter(|folder| !folder.as_os_str().is_empty());
    if let Some(folder) = folder.filter(|folder| !matches!(kind, OutputKind::Frames(..)) && !folder.is_dir()) {
        bail!("cannot write {}: there is no folder {}", args.output.display(), folder.display());
    }
    // The world first: what is wrong with it needs no GPU to be told.
    let scene = world::scene_of(args.world.as_deref(), Reach::trusting(args.trust_scene))?;
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
    let cameras = job.cameras(&kind)?;
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
    if args.json {
        let report = job.report(&cameras, report);
        return tell_json(&report);
    }
    match &job.svg {
        Some(svg) => tell(&svg.told(&job.drawn)),
        None => Ok(()),
    }
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
    fn cameras(&self, kind: &OutputKind) -> anyhow::Result<Vec<Camera>> {
        let (Some(name), Some(flight)) = (&self.args.path, &self.flight) else {
            return Ok(vec![self.args.camera.unwrap_or_else(|| self.world.default_camera())]);
        };
        if !(self.args.fps > 0.0 && self.args.fps <= 1000.0) {
            bail!("--fps {}: it must be a number above 0, at most 1000", self.args.fps);
        }
        let path = CameraPath::parse_on_ground(name, flight.as_bytes(), |x, y| self.world.ground_m(x, y))?;
        let frames = path.frame_count(self.args.fps);
        if frames > MOST_FRAMES {
            bail!("--path at {} frames a second has {frames} frames, more than {MOST_FRAMES}", self.args.fps);
        }
        // One picture of a path is its first.
        let most = if matches!(kind, OutputKind::Picture(_)) { 1 } else { usize::MAX };
        Ok(path.frames(self.args.fps).take(most).collect())
    }

    /// Draws a thumbnail for nobody: drivers compile pipelines on their first use, which is no part of a pass's time.
    fn warm_up(&mut self, camera: &Camera) -> anyhow::Result<()> {
        let eye = self.world.pose(camera);
        let light = self.world.light();
        let request =
            PictureRequest { planes: &self.planes, ..PictureRequest::still(eye, [64, 36], &self.style, light) };
        picture::render(&self.gpu, &mut self.frame, &mut self.world.terrain, &request, |_| Ok::<_, FileError>(()))?;
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
        let report = picture::render(&self.gpu, &mut self.frame, &mut self.world.terrain, &request, take)?;
        self.whole(report)
    }

    /// The report, if it is of all that was to be drawn.
    fn whole(&self, report: PictureReport) -> anyhow::Result<PictureReport> {
        // A drawing of something else than the data is no drawing; what went wrong was told as it happened.
        if report.tiles_failed > 0 {
            let path = self.world.terrain.store().name();
            bail!("{path}: {} tiles could not be read; the file is damaged", report.tiles_failed);
        }
        Ok(report)
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
            gpu_bytes: report.target_bytes + self.world.terrain.gpu_bytes(),
            camera,
            mm_per_px: self.svg.as_ref().and_then(SvgOptions::mm_per_px),
            svg: self.svg.is_some().then(|| self.drawn.clone()),
        }
    }
}
