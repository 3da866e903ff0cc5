//! The inks of a picture as vector lines. Strokes are not among them; [`super::strokes`] reads them back.
//!
//! The marks of rows of hachures are read back as they were placed: a mark is given by its samples, and its visibility
//! is tested against the surface between them, as in `shaders/surface/rows/ribbons.wgsl`. All other inks exist only as
//! pictures and are traced ([`crate::vector::trace`]). Each set of hatching marks is traced separately, so that its
//! lines do not end at those of another set.

use rayon::prelude::*;

use super::ink::channels;
use crate::composite::sky::SKY;
use crate::frame::Renderer;
use crate::gpu::readback::read_as;
use crate::gpu::target::Target;
use crate::gpu::{Gpu, GpuError};
use crate::lines::strokes::polylines::{Polyline, PolylinePoint};
use crate::scene::Light;
use crate::scene::focus::Focus;
use crate::scene::view::{View, ViewUniform};
use crate::style::layers::{Channels, Fading, Trace};
use crate::style::{DrainageLines, Layer, Style, StyleInk};
use crate::surface::id::Kind;
use crate::surface::rows::marks::RowSample;
use crate::surface::rows::ribbons::allowed_m;
use crate::vector::trace::{InkPicture, dots, lines};
use crate::vector::{Group, GroupKind, InkKind};

/// Shorter visible pieces of a row's mark are dropped.
const SHORTEST_PX: f32 = 1.5;

/// The visible surface of a frame, per pixel.
struct Surface {
    size_px: [usize; 2],
    /// Position relative to the eye in metres, and distance along the view axis in metres; 0 for the sky.
    position: Vec<[f32; 4]>,
    /// Distance at which haze has taken 63 % of the contrast, in metres.
    haze_m: f32,
    /// The view with which the frame was drawn.
    view: ViewUniform,
    focus: Option<Focus>,
}

impl Surface {
    /// Returns the index of the pixel at a position; `None` outside of the frame.
    fn pixel(&self, px: [f32; 2]) -> Option<usize> {
        let [x, y] = px.map(|px| px.floor());
        let [width, height] = self.size_px;
        let is_inside = x >= 0.0 && y >= 0.0 && x < width as f32 && y < height as f32;
        is_inside.then(|| y as usize * width + x as usize)
    }

    /// Returns the fraction of ink that haze and focus leave at a position, as in `shaders/composite/composite.wgsl`.
    /// It is 1 for detected lines, which are left out of vector files, and for ink that has already faded.
    fn ink_left(&self, px: [f32; 2], fading: Fading) -> f32 {
        let Fading::OnSurface { faintest, reach, follows_tone } = fading else { return 1.0 };
        let Some(at) = self.pixel(px).map(|pixel| self.position[pixel]).filter(|at| at[3] > 0.0) else { return 1.0 };
        let t = (at[0] * at[0] + at[1] * at[1] + at[2] * at[2]).sqrt() / (self.haze_m * reach);
        let focused = self.focus.map_or(1.0, |focus| focus.left(&self.view, [at[0], at[1], at[2]], px));
        let focused = if follows_tone { focused.sqrt() } else { focused };
        focused * (faintest + (1.0 - faintest) * (-t * t).exp())
    }

    /// Sets the ink of each point of lines to the fraction that haze and focus leave.
    fn faded(&self, mut lines: Vec<Polyline>, fading: Fading) -> Vec<Polyline> {
        for point in lines.iter_mut().flat_map(|line| &mut line.points) {
            point.ink = self.ink_left(point.px, fading);
        }
        lines
    }
}

/// The groups of lines of a picture, from the bottom to the top.
#[derive(Clone, Debug, Default)]
pub(super) struct InkLines {
    /// The groups below the strokes; all of them in a style without strokes.
    pub below: Vec<Group>,
    /// The groups above the strokes.
    pub above: Vec<Group>,
}

/// Returns the inks of the last frame, which must have a single eye, as groups of lines; groups without lines are left
/// out. `view` and `light` are those with which the frame was drawn. The renderer must have drawn the sets of hatching
/// marks separately ([`Renderer::set_wants_mark_sets`]).
///
/// # Errors
/// [`GpuError::Readback`] if the device is lost or out of memory.
pub(super) fn read(
    gpu: &Gpu,
    renderer: &Renderer,
    style: &Style,
    view: &View,
    light: &Light,
) -> Result<InkLines, GpuError> {
    let mut ink_lines = InkLines::default();
    // Every frame has positions; without a frame there is nothing to read.
    let size_px = view.part.size_px;
    let Some(position) = renderer.places(gpu, 0, [0, 0], size_px)? else { return Ok(ink_lines) };
    let (haze_m, focus) = (light.haze_m as f32, light.focus);
    let view_uniform = view.still_uniform(view.pose.position_m);
    let size = size_px.map(|side| side as usize);
    let surface = Surface { size_px: size, position, haze_m, view: view_uniform, focus };
    let mut has_strokes = false;
    for style_ink in style.inks() {
        let groups = match &style_ink.ink.trace {
            Trace::LeftOut(_) => continue,
            Trace::Strokes => {
                has_strokes = true;
                continue;
            }
            Trace::Picture => {
                let target = match style_ink.layer {
                    Some(index) => renderer.ink_target(0, index),
                    None => renderer.target(&SKY),
                };
                target.map_or_else(|| Ok(Vec::new()), |target| traced(gpu, target, &style_ink, &surface))?
            }
            Trace::Sets(sets) => {
                let drawn =
                    (1..).zip(sets).filter_map(|(number, set)| Some((number, set, renderer.mark_set(number - 1)?)));
                let drawn: Vec<_> = drawn
                    .map(|(number, set, target)| {
                        Ok((number, set, InkPicture { size_px, ink: read_as(gpu, target, [0, 0], size_px)? }))
                    })
                    .collect::<Result<_, GpuError>>()?;
                let traced = drawn.par_iter().map(|(number, set, picture)| {
                    let traced = if set.is_of_dots { dots(picture) } else { lines(picture) };
                    group(&style_ink, Some(*number), set.label.clone(), surface.faded(traced, style_ink.ink.fading))
                });
                traced.collect()
            }
            Trace::Rows { spacing_px } => {
                let visible = rows(gpu, renderer, view, &surface, *spacing_px)?;
                vec![group(&style_ink, None, style_ink.ink.label.clone(), surface.faded(visible, style_ink.ink.fading))]
            }
        };
        let kind = GroupKind::Ink(kind_of(style, &style_ink));
        let groups = groups.into_iter().filter(|group| !group.lines.is_empty()).map(|group| Group { kind, ..group });
        if has_strokes { ink_lines.above.extend(groups) } else { ink_lines.below.extend(groups) }
    }
    Ok(ink_lines)
}

/// Returns the kind of the lines of an ink.
fn kind_of(style: &Style, style_ink: &StyleInk) -> InkKind {
    match style_ink.layer.and_then(|layer| style.layers.get(layer)) {
        Some(Layer::HeightLines(_)) => InkKind::ContourLine,
        Some(Layer::Drainage(drainage)) => match drainage.of {
            DrainageLines::Streams => InkKind::Stream,
            DrainageLines::Ridges => InkKind::RidgeLine,
        },
        Some(Layer::Features(_)) => InkKind::Feature,
        Some(Layer::Rims(_)) => InkKind::Rim,
        Some(Layer::Water(water)) if water.has_only_shores() => InkKind::Shoreline,
        Some(Layer::Water(_)) => InkKind::WaterLine,
        _ => InkKind::Mark,
    }
}

/// Traces an ink that exists only as a picture. Returns one group, or one for each family of lines.
fn traced(gpu: &Gpu, target: &Target, style_ink: &StyleInk, surface: &Surface) -> Result<Vec<Group>, GpuError> {
    let size_px = surface.size_px.map(|side| side as u32);
    let texels = channels(gpu, target, [0, 0], size_px)?;
    let is_sky = style_ink.layer.is_none();
    let of_channel = |channel: usize| {
        // The sky's picture also covers pixels in front of which there is a surface; its ink is not shown there.
        let ink = texels.iter().zip(&surface.position);
        let ink = ink.map(|(texel, at)| if is_sky && at[3] > 0.0 { 0.0 } else { texel[channel] }).collect();
        surface.faded(lines(&InkPicture { size_px, ink }), style_ink.ink.fading)
    };
    Ok(match style_ink.ink.channels {
        Channels::One(channel) => vec![group(style_ink, None, style_ink.ink.label.clone(), of_channel(channel))],
        Channels::Crossed(families) => {
            let family = |family| {
                group(
                    style_ink,
                    Some(family + 1),
                    format!("{} {}", style_ink.ink.label, family + 1),
                    of_channel(family),
                )
            };
            (0..families).into_par_iter().map(family).collect()
        }
    })
}

/// Returns the visible pieces of the marks of rows.
fn rows(
    gpu: &Gpu,
    renderer: &Renderer,
    view: &View,
    surface: &Surface,
    spacing_px: f32,
) -> Result<Vec<Polyline>, GpuError> {
    let kinds = renderer.kinds(gpu, 0, [0, 0], view.part.size_px)?.unwrap_or_default();
    let spacing = spacing_px / view.focal_px() as f32;
    let is_shown = |px: [f32; 2], depth_m: f32| {
        surface.pixel(px).is_some_and(|pixel| {
            let land_m = surface.position[pixel][3];
            let is_land = kinds.get(pixel) == Some(&Kind::Land);
            land_m > 0.0 && depth_m <= allowed_m(land_m, spacing) && is_land
        })
    };
    let drawn = renderer.drawn_rows(gpu)?.unwrap_or_default();
    Ok(drawn.par_iter().flat_map_iter(|mark| visible_pieces(mark, is_shown)).collect())
}

/// Returns lines of an ink as a group. `part` is the number of a family of lines or of a set of marks, from 1.
fn group(style_ink: &StyleInk, part: Option<usize>, label: String, lines: Vec<Polyline>) -> Group {
    let label = if style_ink.number > 0 { format!("{label} (layer {})", style_ink.number + 1) } else { label };
    Group {
        id: style_ink.id(part),
        label,
        ink: style_ink.color,
        kind: GroupKind::Ink(InkKind::Mark),
        lines,
        fills: Vec::new(),
        texts: Vec::new(),
    }
}

/// Returns the visible pieces of a mark, tested every half pixel.
fn visible_pieces(mark: &[RowSample], is_shown: impl Fn([f32; 2], f32) -> bool) -> Vec<Polyline> {
    let mut lines: Vec<Polyline> = Vec::new();
    let mut points: Vec<PolylinePoint> = Vec::new();
    let mut end = |points: &mut Vec<PolylinePoint>| {
        let points = std::mem::take(points);
        let length = |pair: &[PolylinePoint]| (pair[1].px[0] - pair[0].px[0]).hypot(pair[1].px[1] - pair[0].px[1]);
        if points.windows(2).map(length).sum::<f32>() > SHORTEST_PX {
            lines.push(Polyline { points, ..Polyline::default() });
        }
    };
    for (number, pair) in mark.windows(2).enumerate() {
        let [a, b] = [pair[0], pair[1]];
        let steps = (2.0 * (b.px[0] - a.px[0]).hypot(b.px[1] - a.px[1])).ceil().max(1.0) as usize;
        for step in usize::from(number > 0)..=steps {
            let part = step as f32 / steps as f32;
            let mix = |a: f32, b: f32| a + (b - a) * part;
            let px = [mix(a.px[0], b.px[0]), mix(a.px[1], b.px[1])];
            if is_shown(px, mix(a.depth_m, b.depth_m)) {
                points.push(PolylinePoint { px, half_width_px: 0.5 * mix(a.width_px, b.width_px), ink: 1.0 });
            } else {
                end(&mut points);
            }
        }
    }
    end(&mut points);
    lines
}
