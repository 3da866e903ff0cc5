//! The pictures of `hachure render`: cameras, files, and the report on the drawing.

use std::ops::Range;
use std::path::{Path, PathBuf};

use anyhow::{anyhow, bail};
use serde::Serialize;

use super::frames::WarmUp;
use super::hosted::Take;
use super::map::{PlacedMap, Sidecars};
use super::names::{EyeLabels, Names};
use super::numbers::blocks_px;
use super::sheets::SheetsReport;
use super::vector::SvgOptions;
use super::{RenderArgs, like};
use crate::commands::progress::Bar;
use crate::file::exr::{self, ExrWriter, SampleKind, SamplesRef};
use crate::file::gif::GifWriter;
use crate::file::imprint::Notes;
use crate::file::jpg::JpgWriter;
use crate::file::pattern::{OutputKind, PictureFormat};
use crate::file::png::{PngPixels, PngWriter};
use crate::file::video::VideoWriter;
use crate::file::{FileError, unnamed};
use crate::frame::Renderer;
use crate::gpu::Gpu;
use crate::gpu::recorder::Submits;
use crate::imagery::ResidentImagery;
use crate::picture::aov::Plane;
use crate::picture::contour_numbers::Numbers;
use crate::picture::eyes::{self, joined};
use crate::picture::imprint::{Imprint, matrices};
use crate::picture::legend::{self, Legend};
use crate::picture::nearest::nearest_m;
use crate::picture::sheets::{EndedSheets, SheetWriter};
use crate::picture::title::LEGEND_HEIGHT;
use crate::picture::{self, Band, PictureReport, PictureRequest};
use crate::scene::camera::Camera;
use crate::scene::path::CameraPath;
use crate::scene::stereo::{Eyes, Pair};
use crate::scene::tone_curve::{FilmCurves, ToneCurve};
use crate::scene::view::{Clock, Pose, View};
use crate::source::Progress;
use crate::style::Style;
use crate::vector::DrawingReport;
use crate::vector::sheets::Sheets;
use crate::world::OpenWorld;
use crate::world::named_places::NamedPlace;

#[derive(Serialize)]
pub(super) struct Report {
    adapter: String,
    output: PathBuf,
    style: String,
    eyes: String,
    /// Distance between the eyes of a stereo pair.
    ipd_m: Option<f64>,
    /// Size of one eye's picture, in pixels.
    size: [u32; 2],
    frames: u64,
    /// Samples per pixel.
    samples: u32,
    wall_ms: f64,
    passes: Vec<PassReport>,
    triangles: u64,
    patches: u64,
    parts: u64,
    tiles_loaded: u64,
    tiles_missing: u64,
    /// Largest error of the mesh, in pixels: --lod-error, or more if that would need too many triangles.
    allowed_error_px: f64,
    over_budget_frames: u64,
    /// Pictures that show only sky or no-data.
    empty_frames: u64,
    gpu_bytes: u64,
    camera: String,
    /// Report on an SVG.
    svg: Option<DrawingReport>,
    /// Report on a picture that was cut into sheets.
    sheets: Option<SheetsReport>,
    /// Side of a pixel on paper, in millimetres.
    mm_per_px: Option<f64>,
    /// Side of a pixel of a map, in metres.
    m_per_px: Option<f64>,
}

#[derive(Serialize)]
struct PassReport {
    name: String,
    gpu_ms: f64,
}

/// The pictures to draw, and everything needed to draw them.
pub(super) struct Job<'a> {
    pub(super) args: &'a RenderArgs,
    /// Text of the file of `--path`.
    pub(super) flight: Option<String>,
    /// The places of `--names` that are on the land.
    pub(super) places: Vec<NamedPlace>,
    /// The places that may have labels, if there are options for them.
    pub(super) names: Option<Names>,
    pub(super) style: Style,
    pub(super) planes: Vec<Plane>,
    pub(super) gpu: Gpu,
    pub(super) world: OpenWorld,
    pub(super) renderer: Option<Renderer>,
    pub(super) svg: Option<SvgOptions>,
    /// How the picture is cut into sheets, if it is.
    pub(super) sheets: Option<Sheets>,
    pub(super) drawn: DrawingReport,
    /// The map, if one is drawn.
    pub(super) map: Option<PlacedMap>,
    /// The stereo pair, if two eyes are drawn.
    pub(super) pair: Option<Pair>,
    /// Time of the picture being drawn.
    pub(super) clock: Clock,
    /// Camera of the picture being drawn, as it was given.
    pub(super) camera: Camera,
    /// The curve that fits the tones to the picture being drawn, in a style that does so.
    pub(super) tone_curve: Option<ToneCurve>,
    /// Description of the picture that is stored in its file.
    pub(super) imprint: Imprint,
    /// How far the drawing is.
    pub(super) drawing: Drawing,
    /// Takes the pictures of a program in which hachure is embedded; they are not written to files.
    pub(super) take: Option<Take<'a>>,
}

/// The progress of a drawing: the pictures of a film share one bar.
#[derive(Default)]
pub(super) struct Drawing {
    bar: Option<Bar>,
    /// Pictures that are drawn, and all.
    pictures: [u64; 2],
}

impl Drawing {
    /// Reports the fraction of the current picture that is drawn, from 0 to 1.
    fn report(&self, part: f64) {
        let [drawn, all] = self.pictures.map(|count| count as f64);
        self.bar.iter().for_each(|bar| bar.report("drawing", ((drawn + part) / all.max(1.0)) as f32));
    }
}

/// A film in one file that is being written.
enum Film {
    Mp4(VideoWriter),
    Gif(GifWriter),
}

impl Film {
    fn write_frame(&mut self, rgba: &[u8]) -> Result<(), FileError> {
        match self {
            Self::Mp4(film) => film.write_frame(rgba),
            Self::Gif(film) => film.write_frame(rgba),
        }
    }

    fn finish(self) -> Result<(), FileError> {
        match self {
            Self::Mp4(film) => film.finish(),
            Self::Gif(film) => film.finish(),
        }
    }
}

/// Largest number of cameras of a path at which the nearest land is measured.
const ASKED_CAMERAS: usize = 24;

impl Job<'_> {
    /// Returns the cameras of the frames, at least one, and sets the clock to the first.
    pub(super) fn cameras(&mut self) -> anyhow::Result<Vec<Camera>> {
        if self.map.is_some() {
            return Ok(vec![self.camera]);
        }
        let (Some(name), Some(flight)) = (&self.args.path, &self.flight) else {
            return Ok(vec![self.camera]);
        };
        let path = CameraPath::parse_on_ground(name, flight.as_bytes(), |x, y| self.world.ground_m(x, y))?;
        self.clock = Clock::still(path.times_s()[0]);
        Ok(path.frames(self.args.fps().per_second()).collect())
    }

    /// Returns the pose of a camera; for a map, the pose of the map.
    fn pose(&self, camera: &Camera) -> Pose {
        self.map.as_ref().map_or_else(|| self.world.pose(camera), |map| map.pose)
    }

    /// Sets the stereo pair, which is the same for all pictures, so that depth in a film does not pulsate.
    pub(super) fn place_eyes(&mut self, cameras: &[Camera]) -> anyhow::Result<()> {
        let mut nearest = f64::INFINITY;
        if self.args.stereo.requests_nearest() {
            let (gpu, renderer) = (&self.gpu, Renderer::or_new(&mut self.renderer, &self.gpu)?);
            for camera in cameras.iter().step_by(cameras.len().div_ceil(ASKED_CAMERAS)) {
                let pose = self.world.pose(camera);
                let found = nearest_m(gpu, renderer, &mut self.world.surfaces, pose, &self.style)?;
                nearest = nearest.min(found.unwrap_or(f64::INFINITY));
            }
            self.renderer = None;
        }
        self.pair = self.args.stereo.pair(nearest);
        Ok(())
    }

    /// Draws a thumbnail and discards it: drivers compile pipelines on first use, which must not count as a pass's
    /// time.
    pub(super) fn warm_up(&mut self, camera: &Camera) -> anyhow::Result<()> {
        let eye = self.pose(camera);
        let light = self.world.light();
        let still = PictureRequest::still(eye, [64, 36], &self.style, light);
        let request = PictureRequest { planes: &self.planes, tone_curve: self.args.tone_curve, ..still };
        picture::render(&self.gpu, &mut self.renderer, &mut self.world.surfaces, &request, |_| Ok::<_, FileError>(()))?;
        Ok(())
    }

    /// Draws the pictures of `cameras`, and writes those with the numbers `written`.
    pub(super) fn run(
        &mut self,
        kind: OutputKind,
        cameras: &[Camera],
        written: Range<u64>,
    ) -> anyhow::Result<PictureReport> {
        let output = self.args.output.clone();
        let mut film = self.film(&kind, &cameras[written.start as usize])?;
        self.warn_of_letters(&self.pose(&cameras[0]));
        self.warn_of_frame();
        let mut total = PictureReport::default();
        let start_s = self.clock.now_s;
        self.find_names()?;
        let warm_up = WarmUp::new(self.args, &kind, &self.style, written.start);
        let first = warm_up.first_of_labels;
        if first > 0 {
            Renderer::or_new(&mut self.renderer, &self.gpu)?.begin_at(first);
        }
        let curves = self.film_curves(cameras, warm_up.first..written.end, start_s)?;
        self.drawing = Drawing { bar: Some(Bar::default()), pictures: [0, written.end - first] };
        for number in first..written.end {
            self.drawing.pictures[0] = number - first;
            self.drawing.report(0.0);
            let camera = &cameras[number as usize];
            let at_s = |number: u64| start_s + self.args.fps().time_s(number);
            self.clock = Clock { now_s: at_s(number), before_s: at_s(number.saturating_sub(1)) };
            self.camera = *camera;
            let pose = self.pose(camera);
            let previous = self.pose(&cameras[number.saturating_sub(1) as usize]);
            self.tone_curve = curves.of_frame(number as usize);
            if !matches!(kind, OutputKind::Mp4 | OutputKind::Gif) {
                self.imprint.more.tone_curve = self.tone_curve.map(|curve| curve.to_string());
            }
            if number < warm_up.first {
                self.remember_labels(pose, previous)?;
                if number + 1 == warm_up.first {
                    // These frames drew the surface alone.
                    Renderer::or_new(&mut self.renderer, &self.gpu)?.forget();
                }
                continue;
            }
            if number < written.start {
                self.remember(&kind, warm_up, pose, previous)?;
                continue;
            }
            let report = match (&kind, &mut film) {
                (OutputKind::Picture(_) | OutputKind::Frames(..), _) if self.take.is_some() => {
                    self.in_memory(pose, previous)?
                }
                (OutputKind::Picture(_), _) if self.args.show.is_some() => self.show(&output, pose)?,
                (OutputKind::Picture(format), _) => self.picture(&output, *format, pose, previous)?,
                (OutputKind::Frames(pattern, format), _) => {
                    self.picture(&pattern.prepare(number)?, *format, pose, previous)?
                }
                (_, Some(film)) => {
                    let width = self.args.size_of_all()[0];
                    let mut rows = Vec::new();
                    let report = self.render(pose, previous, |bands| {
                        rows.extend(picture::srgb8(&joined(width, bands)));
                        Ok(())
                    })?;
                    film.write_frame(&rows)?;
                    report
                }
                (_, None) => unreachable!("the film was created above, and meshes are written elsewhere"),
            };
            total.append(report);
        }
        film.map_or(Ok(()), Film::finish)?;
        self.warn_of_names();
        self.drawing = Drawing::default();
        Ok(total)
    }

    /// Returns the curves that fit the tones to the pictures `drawn`: that of `--tone-curve`, or measured ones. There are
    /// none if the style does not fit its tones.
    fn film_curves(&mut self, cameras: &[Camera], drawn: Range<u64>, start_s: f64) -> anyhow::Result<FilmCurves> {
        if !self.style.fits_tones() {
            return Ok(FilmCurves::default());
        }
        let fps = self.args.fps();
        let frames = drawn.start as usize..drawn.end as usize;
        FilmCurves::measured(cameras.len(), fps.per_second(), frames, |number| {
            let pose = self.pose(&cameras[number]);
            let still = PictureRequest::still(pose, self.args.size(), &self.style, self.world.light());
            let clock = Clock::still(start_s + fps.time_s(number as u64));
            let request = PictureRequest { clock, tone_curve: self.args.tone_curve, ..still };
            Ok(picture::tones::curve(&self.gpu, &mut self.world.surfaces, &request)?)
        })
    }

    /// Starts a film, if the output is one.
    fn film(&self, kind: &OutputKind, first: &Camera) -> Result<Option<Film>, FileError> {
        let imprint = like::text_at(&self.imprint, first, Clock::default());
        let notes = Notes { imprint: Some(&imprint), ..Notes::default() };
        let (output, size, fps) = (&self.args.output, self.args.size_of_all(), self.args.fps());
        Ok(match kind {
            OutputKind::Mp4 => {
                Some(Film::Mp4(VideoWriter::create_noted("ffmpeg".as_ref(), output, size, fps, &notes)?))
            }
            OutputKind::Gif => Some(Film::Gif(GifWriter::create(output, size, fps, &notes)?)),
            OutputKind::Picture(_) | OutputKind::Frames(..) | OutputKind::Mesh(_) => None,
        })
    }

    /// Draws a frame before the part that is written, so that the renderer remembers it.
    fn remember(&mut self, kind: &OutputKind, warm_up: WarmUp, pose: Pose, previous: Pose) -> anyhow::Result<()> {
        if kind.is_drawing() {
            self.layers(Path::new("a frame before --frames"), pose, false)?;
            return Ok(());
        }
        Renderer::or_new(&mut self.renderer, &self.gpu)?.set_only_strokes(warm_up.only_strokes);
        let drawn = self.render(pose, previous, |_| Ok(()));
        Renderer::or_new(&mut self.renderer, &self.gpu)?.set_only_strokes(false);
        drawn.map(drop)
    }

    /// Looks at a frame before those that are drawn, so that the labels of the film are remembered.
    fn remember_labels(&mut self, pose: Pose, previous: Pose) -> anyhow::Result<()> {
        if !self.labels_follow_frame() {
            return self.labels(pose).map(drop);
        }
        Renderer::or_new(&mut self.renderer, &self.gpu)?.set_only_strokes(true);
        let drawn = self.render(pose, previous, |_| Ok(()));
        Renderer::or_new(&mut self.renderer, &self.gpu)?.set_only_strokes(false);
        drawn.map(drop)
    }

    fn picture(
        &mut self,
        path: &Path,
        format: PictureFormat,
        pose: Pose,
        previous: Pose,
    ) -> anyhow::Result<PictureReport> {
        let [width, height] = self.args.size_of_all();
        let side_files = self.map.as_ref().map(|map| map.side_files.clone()).unwrap_or_default();
        let imprint = unnamed::imprint_with(&self.imprint_text(), &side_files);
        let notes = self.notes(&imprint, pose);
        match format {
            PictureFormat::Png => {
                let mut writer = PngWriter::create_noted(path, width, height, PngPixels::Rgba8, &notes)?;
                let mut sheets = self.sheets.map(|sheets| SheetWriter::new(sheets, path, notes));
                let take = |bands| {
                    let rows = picture::srgb8(&joined(width, bands));
                    sheets.iter_mut().try_for_each(|sheets| sheets.write_rows(&rows))?;
                    writer.write_rows(&rows)
                };
                let sidecars = Sidecars::create(path, &side_files, self.args.overwrite)?;
                let report = self.render(pose, previous, take)?;
                let sheets = sheets.map(SheetWriter::end).transpose()?;
                writer.finish_after(|| {
                    sidecars.commit()?;
                    sheets.map_or(Ok(()), EndedSheets::commit)
                })?;
                Ok(report)
            }
            PictureFormat::Exr => {
                let channels = self.exr_channels();
                let channels: Vec<_> = channels.iter().map(|(name, kind)| (name.as_str(), *kind)).collect();
                let attributes = [("camera".to_owned(), self.camera_text(pose))];
                let [width, height] = self.args.size();
                let mut writer = ExrWriter::create_noted(path, width, height, &channels, &attributes, &notes)?;
                let report = self.render(pose, previous, |bands| {
                    let colour = |band: &Band| {
                        [0, 1, 2, 3].map(|i| band.picture.iter().map(|texel| texel[i]).collect::<Vec<f32>>())
                    };
                    let colours: Vec<_> = bands.iter().map(colour).collect();
                    let mut rows = Vec::new();
                    for (band, colour) in bands.iter().zip(&colours) {
                        rows.extend(colour.iter().map(|samples| SamplesRef::F32(samples)));
                        rows.extend(band.planes.iter().map(|samples| samples.as_ref()));
                    }
                    writer.write_rows(&rows)
                })?;
                writer.finish()?;
                Ok(report)
            }
            PictureFormat::Jpg => {
                let mut writer = JpgWriter::create(path, width, height, &notes)?;
                let sidecars = Sidecars::create(path, &side_files, self.args.overwrite)?;
                let take = |bands| writer.write_rows(&picture::srgb8(&joined(width, bands)));
                let report = self.render(pose, previous, take)?;
                writer.finish_after(|| sidecars.commit())?;
                Ok(report)
            }
            PictureFormat::Svg | PictureFormat::Pdf => self.lines(path, format, pose),
            PictureFormat::GeoTiff => self.geotiff(path, pose),
            PictureFormat::GeoJson => self.features(path, pose),
        }
    }

    /// Returns the channels of an EXR. Both eyes of a stereo pair are views of one file, each of the size of one eye.
    pub(super) fn exr_channels(&self) -> Vec<(String, SampleKind)> {
        let colour = ["R", "G", "B", "A"].map(|name| (name, SampleKind::F32));
        let planes = self.planes.iter().map(|plane| (plane.name.as_str(), plane.source.kind()));
        let channels: Vec<_> = colour.into_iter().chain(planes).collect();
        let of_view = |view: usize| channels.iter().map(move |(name, kind)| (exr::channel_of_view(name, view), *kind));
        match self.args.stereo.eyes() {
            Eyes::SideBySide => (0..exr::VIEWS.len()).flat_map(of_view).collect(),
            _ => channels.iter().map(|(name, kind)| ((*name).to_owned(), *kind)).collect(),
        }
    }

    /// Draws, and passes the bands of each eye that is shown to `take`; an anaglyph has only one.
    pub(super) fn render(
        &mut self,
        pose: Pose,
        previous: Pose,
        mut take: impl FnMut(Vec<Band>) -> Result<(), FileError>,
    ) -> anyhow::Result<PictureReport> {
        let title = self.title_block(&pose);
        let follows_frame = self.labels_follow_frame();
        let labels = if follows_frame { Vec::new() } else { self.labels(pose)? };
        let mut legend = self.legend().filter(|_| title.as_ref().is_some_and(|title| title.legend.is_some()));
        let numbers = self.contour_numbers(&blocks_px(labels.iter().flat_map(EyeLabels::blocks)))?;
        let line_gaps = numbers.as_ref().map(Numbers::gaps).unwrap_or_default();
        let numbers = numbers.as_ref().map(Numbers::blocks).unwrap_or_default();
        let mut planes = self.planes.clone();
        planes.extend(legend.as_ref().map(Legend::planes).unwrap_or_default());
        let request = PictureRequest {
            pose,
            previous,
            clock: self.clock,
            size_px: self.args.size(),
            style: &self.style,
            light: self.world.light(),
            planes: &planes,
            samples: self.args.samples(),
            antialias: self.args.antialias(),
            tone_curve: self.tone_curve,
            line_gaps: &line_gaps,
        };
        if self.args.json && self.args.show.is_none() {
            // The report has the time of each pass.
            Renderer::or_new(&mut self.renderer, &self.gpu)?.set_submits(Submits::Timed);
        }
        if let Some(renderer) = &mut self.renderer {
            renderer.set_step_s(1.0 / self.args.fps().per_second());
        }
        let (gpu, renderer, surfaces) = (&self.gpu, &mut self.renderer, &mut self.world.surfaces);
        let shown = self.args.stereo.eyes();
        let [width, height] = self.args.size().map(|side| side as usize);
        // Taken, because labels borrow the job below. After an error the run ends, so it need not come back.
        let (drawing, mut drawn_rows) = (std::mem::take(&mut self.drawing), 0);
        let area = legend::drawn_area(&self.style.paper, self.args.size());
        let mut take = |mut bands: Vec<Band>| {
            drawn_rows += bands.first().map_or(0, |band| band.rows);
            drawing.report(f64::from(drawn_rows) / height as f64);
            // The legend is below the picture, so that it is drawn when all of the picture has been seen.
            if let (Some(legend), Some(place)) = (&mut legend, title.as_ref().and_then(|title| title.legend)) {
                bands.iter_mut().for_each(|band| legend.look(band, width, area));
                let has_foot =
                    |band: &Band| f64::from(band.first_row + band.rows) > place.at.y - LEGEND_HEIGHT * place.px;
                let blocks = if bands.iter().any(has_foot) { legend.blocks(&place) } else { Vec::new() };
                blocks.iter().for_each(|block| bands.iter_mut().for_each(|band| block.draw(band, width)));
            }
            let drawn_over = numbers.iter().chain(&title);
            drawn_over.for_each(|block| bands.iter_mut().for_each(|band| block.draw(band, width)));
            take(bands)
        };
        // A name is at the distance of its summit, so each eye has its own picture of it.
        let labelled = |mut bands: Vec<Band>, labels: &[EyeLabels]| {
            for (band, labels) in bands.iter_mut().zip(labels) {
                labels.blocks().for_each(|block| block.draw(band, width));
            }
            if shown.of_pair().is_empty() { bands } else { eyes::shown(shown, bands) }
        };
        let mut waiting = Vec::new();
        let mut take_or_wait = |bands: Vec<Band>| {
            if follows_frame {
                waiting.push(bands);
                return Ok(());
            }
            take(labelled(bands, &labels))
        };
        let report = match shown.of_pair() {
            [] => picture::render(gpu, renderer, surfaces, &request, |band| take_or_wait(vec![band]))?,
            _ => {
                let pair = self.pair.unwrap_or_default();
                picture::render_pair(gpu, renderer, surfaces, &request, &pair, take_or_wait)?
            }
        };
        if follows_frame {
            let labels = self.labels_of_frame(pose, previous)?;
            waiting.into_iter().try_for_each(|bands| take(labelled(bands, &labels)))?;
        }
        self.drawing = drawing;
        legend.iter().for_each(|legend| self.warn_of_legend(legend));
        self.whole(report)
    }

    /// Returns the description of the picture being drawn, for its file.
    pub(super) fn imprint_text(&self) -> String {
        like::text_at(&self.imprint, &self.camera, self.clock)
    }

    /// Returns the description with what its file format has fields for. An anaglyph has no matrices, since its eyes
    /// share their pixels.
    pub(super) fn notes<'a>(&self, imprint: &'a str, pose: Pose) -> Notes<'a> {
        let camera = View::whole(pose, pose, self.args.size());
        let eyes = self.args.stereo.eyes();
        let seen = match eyes.of_pair() {
            [] => vec![camera],
            _ if eyes.are_merged() => Vec::new(),
            shown => {
                let pair = self.pair.unwrap_or_default().rig(&camera).eyes;
                shown.iter().filter_map(|eye| pair.get(*eye).copied()).collect()
            }
        };
        let mut seen = seen.iter().map(matrices);
        Notes { imprint: Some(imprint), dpi: self.args.dpi, matrices: seen.next(), second_view: seen.next() }
    }

    /// Returns the report, or an error if some tiles could not be read.
    pub(super) fn whole(&self, report: PictureReport) -> anyhow::Result<PictureReport> {
        self.world.ground_was_read()?;
        // A drawing with missing tiles must not be written.
        if let Some(failure) = self.world.surfaces.imagery().and_then(ResidentImagery::failure) {
            bail!("an image on the land could not be read: {failure}");
        }
        match (report.tiles_failed, self.world.surfaces.terrain.failure()) {
            (0, _) => Ok(report),
            (1, Some(failure)) => Err(anyhow!(failure).context("a tile could not be read")),
            (tiles, Some(failure)) => Err(anyhow!(failure).context(format!("{tiles} tiles could not be read"))),
            (tiles, None) => bail!("{}: {tiles} tiles could not be read", self.world.surfaces.terrain.store().name()),
        }
    }

    /// Returns the camera in the world's frame, which converts camera-relative positions to world positions.
    pub(super) fn camera_text(&self, pose: Pose) -> String {
        let camera = self.world.camera(&pose);
        camera.to_string()
    }

    pub(super) fn report(&self, cameras: &[Camera], written: Range<u64>, report: PictureReport) -> Report {
        let camera = self.world.camera(&self.pose(&cameras[written.start as usize])).to_string();
        Report {
            adapter: self.gpu.description(),
            output: self.args.output.clone(),
            style: self.style.name.clone(),
            eyes: self.args.stereo.eyes().to_string(),
            ipd_m: self.pair.map(|pair| pair.ipd_m),
            size: self.args.size(),
            frames: written.end - written.start,
            samples: self.args.samples(),
            wall_ms: report.wall_ms,
            passes: report.passes.into_iter().map(|time| PassReport { name: time.name, gpu_ms: time.gpu_ms }).collect(),
            triangles: report.triangles,
            patches: report.patches,
            parts: report.parts,
            tiles_loaded: report.tiles_loaded,
            tiles_missing: report.tiles_missing,
            allowed_error_px: report.error_px,
            over_budget_frames: report.over_budget,
            empty_frames: report.empty,
            gpu_bytes: self.gpu.memory_bytes(),
            camera,
            sheets: self.sheets.as_ref().map(|sheets| SheetsReport::new(self.args, sheets)),
            mm_per_px: self.svg.as_ref().and_then(SvgOptions::mm_per_px),
            m_per_px: self.map.as_ref().map(|map| map.map.pixel_m),
            svg: self.svg.is_some().then(|| self.drawn.clone()),
        }
    }
}
