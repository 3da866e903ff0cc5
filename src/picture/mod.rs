//! Pictures of any size: rendered in tiles that join without a seam, and delivered in bands of rows. A tile is called a
//! part here.
//!
//! A part is rendered with a margin, because lines depend on their neighbourhood. The level of detail follows from the
//! pixels of the whole picture, and the surface is a function of position and distance, so both sides of a seam compute
//! the same values.
//!
//! Why: `docs/decisions/large-pictures.md`.

pub mod aov;
pub(crate) mod eyes;
pub(crate) mod imprint;
pub(crate) mod contour_numbers;
mod ink;
mod in_view;
mod ink_lines;
pub(crate) mod names;
pub(crate) mod legend;
pub(crate) mod map_frame;
pub(crate) mod nearest;
mod report;
pub(crate) mod sheets;
pub(crate) mod show;
pub(crate) mod strokes;
pub(crate) mod supersampling;
pub(crate) mod title;
pub(crate) mod tones;

use std::path::Path;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use aov::{Plane, PlaneSource};
use in_view::Seen;
pub use report::PictureReport;

use crate::composite::PICTURE;
use crate::file::FileError;
use crate::file::exr::Samples;
use crate::file::png::PngWriter;
use crate::frame::{self, Antialias, Light, LineGap, Renderer, terrain_view_of};
use crate::gpu::readback;
use crate::gpu::target::Target;
use crate::gpu::{Gpu, GpuError};
use crate::scene::stereo::Pair;
use crate::scene::tone_curve::ToneCurve;
use crate::scene::view::{Clock, Part, Pose, Rig, View};
use crate::style::Style;
use crate::style::color::srgb_from_linear;
use crate::surface::form;
use crate::tiles::terrain::Loading;
use crate::tones::relief;
use crate::world::Surfaces;

/// Largest size of a band of rows in memory, in bytes.
const BAND_BYTES: u64 = 512 << 20;

/// How a picture is split into parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PartRule {
    /// A picture with at most this many pixels is rendered as one part.
    pub whole_px: u64,
    /// Largest side of a part without its margin, in pixels.
    pub part_px: u32,
    /// Margin that is rendered around a part and discarded, in pixels: the radius of the neighbourhood that lines
    /// depend on.
    pub margin_px: u32,
}

impl Default for PartRule {
    fn default() -> Self {
        // The margin: LSA 1, density 2, smoothing 5, composite 1, and a reserve.
        Self { whole_px: 8 << 20, part_px: 2048, margin_px: 12 }
    }
}

impl PartRule {
    /// Returns whether a picture of this size has few enough pixels to be one part.
    pub(crate) fn is_whole(&self, size_px: [u32; 2]) -> bool {
        u64::from(size_px[0]) * u64::from(size_px[1]) <= self.whole_px
    }
}

/// Largest margin for the search of matching lines in the other eye. It grows with the parallax of the nearest land.
const PARALLAX_MARGIN_PX: f64 = 256.0;

/// The description of a picture to render.
pub struct PictureRequest<'a> {
    /// Pose of the eye.
    pub pose: Pose,
    /// Pose of the eye in the previous frame.
    pub previous: Pose,
    /// Time, by which trees sway.
    pub clock: Clock,
    /// Size of the picture in pixels.
    pub size_px: [u32; 2],
    /// Style of the drawing.
    pub style: &'a Style,
    /// Sun, haze and focus.
    pub light: Light,
    /// AOV channels to deliver with the colour.
    pub planes: &'a [Plane],
    /// Number of frames whose mean is the colour of a pixel, each moved by a fraction of a pixel ([`supersampling`]).
    /// AOV channels have one sample at the pixel's centre.
    pub samples: u32,
    /// Anti-aliasing over consecutive frames; only used for pictures of one part and one sample.
    pub antialias: Antialias,
    /// The curve that fits the tones of a style that does so; without it, the picture is measured.
    pub tone_curve: Option<ToneCurve>,
    /// The gaps of contour lines, for numbers that are drawn over the picture.
    pub line_gaps: &'a [LineGap],
}

impl<'a> PictureRequest<'a> {
    /// Creates a request for an eye that does not move, at time 0, without AOV channels.
    pub fn still(pose: Pose, size_px: [u32; 2], style: &'a Style, light: Light) -> Self {
        let (clock, antialias) = (Clock::default(), Antialias::None);
        Self {
            pose,
            previous: pose,
            clock,
            size_px,
            style,
            light,
            planes: &[],
            samples: 1,
            antialias,
            tone_curve: None,
            line_gaps: &[],
        }
    }
}

/// Complete rows of a picture; bands are delivered from top to bottom.
pub struct Band {
    /// First row of the band, from the top of the picture.
    pub first_row: u32,
    pub rows: u32,
    /// Linear colour and alpha, rows × width.
    pub picture: Vec<[f32; 4]>,
    /// AOV channels in the order of the request, rows × width samples each.
    pub planes: Vec<Samples>,
}

/// Why a picture was not rendered or not delivered.
#[derive(Debug, thiserror::Error)]
pub enum PictureError<E> {
    /// The GPU failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// There is too little memory for a band of rows.
    #[error(
        "not enough memory for {rows} rows of {width} pixels: {} MiB are needed; reduce the size of the picture",
        needed_bytes.div_ceil(1 << 20)
    )]
    Memory { rows: u32, width: u32, needed_bytes: u64 },
    /// The receiver of the bands failed.
    #[error(transparent)]
    Sink(E),
}

/// Renders a picture and passes it to `take`, band by band.
///
/// # Errors
/// [`PictureError`].
pub fn render<E>(
    gpu: &Gpu,
    renderer: &mut Option<Renderer>,
    world: &mut Surfaces,
    request: &PictureRequest<'_>,
    take: impl FnMut(Band) -> Result<(), E>,
) -> Result<PictureReport, PictureError<E>> {
    render_in_parts(gpu, renderer, world, request, &PartRule::default(), take)
}

/// Like [`render`], with parts of the caller's choice.
///
/// # Errors
/// [`PictureError`].
pub fn render_in_parts<E>(
    gpu: &Gpu,
    renderer: &mut Option<Renderer>,
    world: &mut Surfaces,
    request: &PictureRequest<'_>,
    parts: &PartRule,
    mut take: impl FnMut(Band) -> Result<(), E>,
) -> Result<PictureReport, PictureError<E>> {
    let one = |bands: Vec<Band>| bands.into_iter().try_for_each(&mut take);
    render_eyes(gpu, renderer, world, request, None, parts, one)
}

/// Renders a stereo pair with one selection of tiles and patches. `take` gets the band of the left eye first.
///
/// # Errors
/// [`PictureError`].
pub fn render_pair<E>(
    gpu: &Gpu,
    renderer: &mut Option<Renderer>,
    world: &mut Surfaces,
    request: &PictureRequest<'_>,
    pair: &Pair,
    take: impl FnMut(Vec<Band>) -> Result<(), E>,
) -> Result<PictureReport, PictureError<E>> {
    render_eyes(gpu, renderer, world, request, Some(pair), &PartRule::default(), take)
}

fn render_eyes<E>(
    gpu: &Gpu,
    renderer: &mut Option<Renderer>,
    world: &mut Surfaces,
    request: &PictureRequest<'_>,
    pair: Option<&Pair>,
    parts: &PartRule,
    take: impl FnMut(Vec<Band>) -> Result<(), E>,
) -> Result<PictureReport, PictureError<E>> {
    let drawn = draw_parts(gpu, renderer, world, request, pair, parts, take);
    // Later frames are fitted to themselves, also after a picture that failed.
    world.terrain.hold_error_px(0.0);
    for renderer in renderer.iter_mut() {
        renderer.set_tone_curve(None);
        renderer.set_line_gaps(Vec::new());
        renderer.set_masses(None);
    }
    drawn
}

/// Draws all parts of a picture, and leaves what it fitted to the picture in the renderer and in the world.
fn draw_parts<E>(
    gpu: &Gpu,
    renderer: &mut Option<Renderer>,
    world: &mut Surfaces,
    request: &PictureRequest<'_>,
    pair: Option<&Pair>,
    parts: &PartRule,
    mut take: impl FnMut(Vec<Band>) -> Result<(), E>,
) -> Result<PictureReport, PictureError<E>> {
    let jittered = |previous: Pose, clock: Clock, part: Part, jitter_px: DVec2| {
        let camera = View { jitter_px, clock, ..View::of_part(previous, request.pose, request.size_px, part) };
        pair.map_or_else(|| Rig::mono(camera), |pair| pair.rig(&camera))
    };
    let rig_of = |part| jittered(request.previous, request.clock, part, DVec2::ZERO);
    let samples = supersampling::samples(request.samples, !request.planes.is_empty());
    let eyes = if pair.is_some() { 2 } else { 1 };
    let start = std::time::Instant::now();
    let [width, height] = request.size_px;
    let mut report = PictureReport::default();
    let mut seen = Seen::NOTHING;

    let limit_px = gpu.device.limits().max_texture_dimension_2d;
    let single = parts.is_whole(request.size_px) && width.max(height) <= limit_px;
    let bytes_per_row = eyes * u64::from(width) * (16 + 4 * request.planes.len() as u64);
    let part_px = parts.part_px.max(1);
    let max_rows = u64::from(part_px);
    let band_rows = if single { height } else { (BAND_BYTES / bytes_per_row).clamp(max_rows.min(64), max_rows) as u32 };
    let part_columns = if single { width } else { part_px };
    let parallax_px = pair.map_or(0.0, |pair| {
        let camera = View::whole(request.pose, request.pose, request.size_px);
        camera.focal_px() * pair.ipd_m / world.nearest_m(request.pose.position_m)
    });
    let parallax_px = parallax_px.min(PARALLAX_MARGIN_PX).ceil() as u32;
    let is_flight = single && request.samples <= 1;
    let antialias = if is_flight { request.antialias } else { Antialias::None };
    let relief_px = request.style.drawn_relief().map_or(0, relief::diffuse::reach_px);
    let planes_px = if request.style.has_planes() { form::reach_px(&request.style.light) } else { 0 };
    let margins = || request.style.layers.iter().map(|layer| layer.behaviour().margins());
    let added_px: u32 = margins().map(|margins| margins.added_px).sum();
    let margin_px = margins().map(|margins| margins.margin_px).fold(relief_px.max(planes_px), u32::max);
    let margin_px = margin_px.max(parts.margin_px + parallax_px + added_px);

    world.terrain.hold_error_px(0.0);
    let tone_curve = tones::curve(gpu, world, request)?;
    let masses = if single || eyes > 1 { None } else { tones::masses(gpu, world, request, tone_curve)? };
    if !single {
        // Both sides of a seam use meshes with the same allowed error: the largest that any part needs.
        let mut error_px = 0.0_f64;
        for (first_row, first_column) in (0..height)
            .step_by(band_rows as usize)
            .flat_map(|row| (0..width).step_by(part_columns as usize).map(move |column| (row, column)))
        {
            let size = [part_columns.min(width - first_column), band_rows.min(height - first_row)];
            let (part, _) = part_with_margin([first_column, first_row], size, request.size_px, margin_px);
            let view = terrain_view_of(&rig_of(part), request.style.panorama.horizon_rad());
            error_px = error_px.max(world.terrain.detail_of(gpu, &view).error_px);
        }
        world.terrain.hold_error_px(error_px);
    }
    for first_row in (0..height).step_by(band_rows as usize) {
        let rows = band_rows.min(height - first_row);
        let pixels = rows as usize * width as usize;
        // The receiver converts the rows to sRGB, and joins those of two eyes.
        let needed_bytes = u64::from(rows) * (bytes_per_row + 8 * eyes * u64::from(width));
        if !has_room(needed_bytes) {
            return Err(PictureError::Memory { rows, width, needed_bytes });
        }
        let band = |_| Band {
            first_row,
            rows,
            picture: vec![[0.0; 4]; pixels],
            planes: request.planes.iter().map(|plane| plane.source.samples(pixels)).collect(),
        };
        let mut bands: Vec<Band> = (0..eyes).map(band).collect();
        for first_column in (0..width).step_by(part_columns as usize) {
            if report.tiles_failed > 0 && world.terrain.options().loading == Loading::Wait {
                // The picture has failed; its other parts must not wait for tiles that cannot be read either.
                break;
            }
            let columns = part_columns.min(width - first_column);
            let (part, inset) =
                part_with_margin([first_column, first_row], [columns, rows], request.size_px, margin_px);
            let renderer = Renderer::or_new(renderer, gpu)?;
            renderer.set_antialias(antialias);
            renderer.set_tone_curve(tone_curve);
            renderer.set_line_gaps(request.line_gaps.to_vec());
            renderer.set_masses(masses.clone());
            let wants = |is: fn(PlaneSource) -> bool| request.planes.iter().any(|plane| is(plane.source));
            renderer.set_wants_motion(wants(|source| matches!(source, PlaneSource::Motion(_))));
            if wants(|source| source == PlaneSource::SurfaceId) {
                renderer.set_wants_ids(true);
            }
            let window = |eye| Window {
                eye,
                inset,
                size_px: [columns, rows],
                first_column,
                width,
                origin_m: request.pose.position_m,
            };
            let step_s = renderer.step_s();
            for (number, &(jitter_px, weight)) in samples.iter().enumerate() {
                // No time passes between samples, so strokes do not fade.
                let (previous, clock) = match number {
                    0 => (request.previous, request.clock),
                    _ => (request.pose, Clock::still(request.clock.now_s)),
                };
                renderer.set_step_s(if number == 0 { step_s } else { 0.0 });
                let rig = renderer.jittered(&jittered(previous, clock, part, jitter_px), request.style);
                let prepared = frame::prepare(gpu, world, &rig, request.style, &request.light);
                renderer.render_rig(gpu, world, &prepared, &rig, request.style, &request.light)?;
                for (eye, band) in bands.iter_mut().enumerate() {
                    if weight > 0.0 {
                        add_picture(gpu, renderer, &window(eye), weight, band)?;
                    }
                    if number == 0 {
                        seen.look(gpu, renderer)?;
                        aov::read_planes(gpu, renderer, request.style, &window(eye), request.planes, &mut band.planes)?;
                    }
                }
                report.add(&prepared, renderer);
            }
            renderer.set_step_s(step_s);
            if let Some(strokes) = renderer.strokes() {
                report.left_out = report.left_out.most(strokes.left_out(gpu)?);
            }
            let models = if world.meshes().is_some() { renderer.drawn_meshes(gpu)? } else { None };
            report.models_left_out = report.models_left_out.max(models.map_or(0, |models| models.left_out));
            gpu.check()?;
        }
        bands.first().into_iter().for_each(|band| seen.add(band));
        take(bands).map_err(PictureError::Sink)?;
    }
    report.count(seen.surface, seen.is_pale());
    report.wall_ms = start.elapsed().as_secs_f64() * 1000.0;
    Ok(report)
}

/// Returns whether so much memory can be allocated now. An allocation that fails later would abort the program.
fn has_room(bytes: u64) -> bool {
    usize::try_from(bytes).is_ok_and(|bytes| Vec::<u8>::new().try_reserve_exact(bytes).is_ok())
}

/// Renders a picture into a PNG file. On failure no file is written.
///
/// # Errors
/// [`PictureError`].
pub fn write_png(
    gpu: &Gpu,
    world: &mut Surfaces,
    request: &PictureRequest<'_>,
    path: &Path,
) -> Result<PictureReport, PictureError<FileError>> {
    let [width, height] = request.size_px;
    let mut png = PngWriter::create(path, width, height).map_err(PictureError::Sink)?;
    let report = render(gpu, &mut None, world, request, |band| png.write_rows(&srgb8(&band.picture)))?;
    png.finish().map_err(PictureError::Sink)?;
    Ok(report)
}

/// Returns a part with its margin, clipped to the picture, and the offset of the wanted pixels inside it.
fn part_with_margin(origin: [u32; 2], size: [u32; 2], picture: [u32; 2], margin_px: u32) -> (Part, [u32; 2]) {
    let inset = origin.map(|first| first.min(margin_px));
    let end = [0, 1].map(|i| (origin[i] + size[i] + margin_px).min(picture[i]));
    let origin_px = [0, 1].map(|i| (origin[i] - inset[i]) as i32);
    let size_px = [0, 1].map(|i| end[i] - origin[i] + inset[i]);
    (Part { origin_px, size_px }, inset)
}

/// The mapping from a part's pixels in the targets of an eye to the band.
struct Window {
    eye: usize,
    inset: [u32; 2],
    size_px: [u32; 2],
    first_column: u32,
    width: u32,
    /// World position to which the positions in the targets are relative.
    origin_m: DVec3,
}

impl Window {
    /// Reads the part from a target and calls `put(index in the band, texel)` for each pixel.
    fn scatter<T: Copy + bytemuck::Pod>(
        &self,
        gpu: &Gpu,
        target: &Target,
        mut put: impl FnMut(usize, T),
    ) -> Result<(), GpuError> {
        let texels: Vec<T> = readback::read_as(gpu, target, self.inset, self.size_px)?;
        self.place(&texels, &mut put);
        Ok(())
    }

    /// Calls `put(index in the band, texel)` for each texel of the part.
    fn place<T: Copy>(&self, texels: &[T], mut put: impl FnMut(usize, T)) {
        for (y, row) in texels.chunks_exact(self.size_px[0] as usize).enumerate() {
            let first = y * self.width as usize + self.first_column as usize;
            for (x, texel) in row.iter().enumerate() {
                put(first + x, *texel);
            }
        }
    }
}

/// Adds a part's picture to the band, multiplied by `weight`.
fn add_picture(gpu: &Gpu, renderer: &Renderer, window: &Window, weight: f32, band: &mut Band) -> Result<(), GpuError> {
    let Some(drawn) = renderer.eye_target(window.eye, &PICTURE) else { return Ok(()) };
    window.scatter(gpu, drawn, |i, texel: [u16; 4]| {
        for (sum, value) in band.picture[i].iter_mut().zip(texel.map(aov::f32_from_f16)) {
            *sum += weight * value;
        }
    })
}

/// Converts linear colour to rounded sRGB bytes, RGBA with an alpha of 255.
pub fn srgb8(picture: &[[f32; 4]]) -> Vec<u8> {
    let mut bytes = vec![0; picture.len() * 4];
    bytes.par_chunks_exact_mut(4).zip(picture).for_each(|(bytes, texel)| {
        for (byte, value) in bytes.iter_mut().zip(&texel[..3]) {
            *byte = (srgb_from_linear(value.clamp(0.0, 1.0)) * 255.0).round() as u8;
        }
        bytes[3] = 255;
    });
    bytes
}
