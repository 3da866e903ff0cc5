//! The marks of a picture as vector lines: rows of hachures as they were placed; hatching and lines of water as lines
//! traced from their ink.
//!
//! A mark of a row is given by its samples, and its visibility is tested against the surface between them, as in
//! `shaders/surface/rows/ribbons.wgsl`. Marks from textures exist only as ink and are traced
//! ([`crate::vector::trace`]). Each layer of hatching is traced separately, so that its lines do not end at those of
//! another layer.

use rayon::prelude::*;

use super::aov::f32_from_f16;
use crate::composite::sky::SKY;
use crate::frame::Renderer;
use crate::gpu::readback::read_as;
use crate::gpu::target::Target;
use crate::gpu::{Gpu, GpuError};
use crate::lines::strokes::polylines::{Polyline, PolylinePoint};
use crate::lines::tone::ink::TONE_INK;
use crate::scene::Light;
use crate::scene::focus::Focus;
use crate::scene::view::{View, ViewUniform};
use crate::style::{Color, Style};
use crate::surface::cuts::CUT_INK;
use crate::surface::height_lines::HEIGHT_INK;
use crate::surface::id::Kind;
use crate::surface::rims::RIM;
use crate::surface::rows::marks::RowSample;
use crate::surface::rows::ribbons::allowed_m;
use crate::surface::{POSITION, SURFACE_ID};
use crate::tones::water::WATER_INK;
use crate::vector::trace::{InkPicture, dots, lines};
use crate::vector::{Group, GroupKind};

/// Shorter visible pieces of a row's mark are dropped.
const SHORTEST_PX: f32 = 1.5;

/// The visible surface of a frame, per pixel.
struct Surface {
    size_px: [usize; 2],
    /// Position relative to the eye in metres, and distance along the view axis in metres; 0 for the sky.
    position: Vec<[f32; 4]>,
    haze_m: f32,
    /// The view with which the frame was drawn.
    view: ViewUniform,
    focus: Option<Focus>,
}

/// How ink fades with distance.
#[derive(Clone, Copy)]
struct Left {
    /// Fraction of the ink that remains in full haze.
    faintest: f32,
    /// Whether the ink follows the tone, which has already faded.
    is_of_tone: bool,
}

impl Surface {
    fn pixel(&self, px: [f32; 2]) -> Option<usize> {
        let [x, y] = px.map(|px| px.floor());
        let [width, height] = self.size_px;
        let is_inside = x >= 0.0 && y >= 0.0 && x < width as f32 && y < height as f32;
        is_inside.then(|| y as usize * width + x as usize)
    }

    /// Returns the fraction of ink that haze and focus leave at a pixel, as in `shaders/composite/composite.wgsl`.
    fn clear(&self, px: [f32; 2], left: Left) -> f32 {
        let Some(at) = self.pixel(px).map(|pixel| self.position[pixel]).filter(|at| at[3] > 0.0) else { return 1.0 };
        let t = (at[0] * at[0] + at[1] * at[1] + at[2] * at[2]).sqrt() / self.haze_m;
        let seen = self.focus.map_or(1.0, |focus| focus.left(&self.view, [at[0], at[1], at[2]], px));
        let seen = if left.is_of_tone { seen.sqrt() } else { seen };
        seen * (left.faintest + (1.0 - left.faintest) * (-t * t).exp())
    }

    /// Sets the ink of lines to what haze and focus leave of it.
    fn hazed(&self, mut lines: Vec<Polyline>, left: Left) -> Vec<Polyline> {
        for point in lines.iter_mut().flat_map(|line| &mut line.points) {
            point.ink = self.clear(point.px, left);
        }
        lines
    }
}

/// Returns the marks of the last frame, which must have a single eye, as a group for each kind; groups without lines
/// are left out. `view` and `light` are those with which the frame was drawn. The renderer must have been set to keep
/// the layers of marks ([`Renderer::set_wants_mark_layers`]).
///
/// # Errors
/// [`GpuError::Readback`] if the device is lost or out of memory.
pub(super) fn read(
    gpu: &Gpu,
    renderer: &Renderer,
    style: &Style,
    view: &View,
    light: &Light,
) -> Result<Vec<Group>, GpuError> {
    let Some(position) = renderer.target(&POSITION) else { return Ok(Vec::new()) };
    let size_px = view.part.size_px;
    let position: Vec<[f32; 4]> = read_as(gpu, position, [0, 0], size_px)?;
    let (haze_m, focus) = (light.haze_m as f32, light.focus);
    let view_uniform = view.still_uniform(view.pose.position_m);
    let size = size_px.map(|side| side as usize);
    let surface = Surface { size_px: size, position, haze_m, view: view_uniform, focus };
    // In the order of `shaders/composite/composite.wgsl`.
    let mut groups = Vec::new();
    if let Some(sky) = renderer.target(&SKY).filter(|_| style.sky.has_lines()) {
        let texels: Vec<[u16; 4]> = read_as(gpu, sky, [0, 0], size_px)?;
        let shown = texels.iter().zip(&surface.position);
        let ink = shown.map(|(texel, at)| if at[3] > 0.0 { 0.0 } else { f32_from_f16(texel[3]) }).collect();
        groups.push(group("sky", "Sky".to_owned(), style.sky.ink, lines(&InkPicture { size_px, ink })));
    }
    if let Some((style, ink)) = style.tone_lines.as_ref().and_then(|lines| Some((lines, renderer.target(&TONE_INK)?))) {
        let texels: Vec<[u16; 4]> = read_as(gpu, ink, [0, 0], size_px)?;
        let left = Left { faintest: style.faintest, is_of_tone: false };
        let kinds = [
            ("tone-highlights", "Highlight lines from shading", style.highlight_ink, 1),
            ("tone-lines", "Dark lines from shading", style.ink, 0),
        ];
        for (id, label, color, channel) in kinds {
            let ink = texels.iter().map(|texel| f32_from_f16(texel[channel])).collect();
            let traced = surface.hazed(lines(&InkPicture { size_px, ink }), left);
            groups.push(group(id, label.to_owned(), color, traced));
        }
    }
    if let Some(lines) = style.drawn_height_lines() {
        let traced = renderer.target(&HEIGHT_INK).map(|ink| traced(gpu, ink, size_px)).transpose()?;
        let traced = surface.hazed(traced.unwrap_or_default(), Left { faintest: lines.faintest, is_of_tone: false });
        groups.push(group("heights", "Contour lines of height".to_owned(), lines.ink, traced));
    }
    if let Some(hatching) = &style.hatching {
        let layers = hatching.layers.iter().zip(1..);
        let drawn = layers.filter_map(|(layer, number)| Some((layer, number, renderer.mark_layer(number - 1)?)));
        let drawn: Vec<_> = drawn
            .map(|(layer, number, ink)| Ok((layer, number, picture(gpu, ink, size_px)?)))
            .collect::<Result<_, GpuError>>()?;
        let drawn: Vec<Group> = drawn
            .into_par_iter()
            .map(|(layer, number, picture)| {
                let has_dots = layer.recipe.as_ref().is_some_and(|recipe| recipe.kind.is_of_dots());
                let traced = if has_dots { dots(&picture) } else { lines(&picture) };
                let lines = surface.hazed(traced, Left { faintest: hatching.faintest, is_of_tone: true });
                group(&format!("marks-{number}"), format!("Hatching {number}, {}", layer.marks), hatching.ink, lines)
            })
            .collect();
        groups.extend(drawn);
    }
    if let Some((cuts, ink)) = style.cuts.as_ref().zip(renderer.target(&CUT_INK)) {
        let texels: Vec<[u16; 4]> = read_as(gpu, ink, [0, 0], size_px)?;
        let families: Vec<Group> = (0..cuts.layers.len())
            .into_par_iter()
            .map(|family| {
                let ink = texels.iter().map(|texel| f32_from_f16(texel[family])).collect();
                let left = Left { faintest: cuts.faintest, is_of_tone: true };
                let lines = surface.hazed(lines(&InkPicture { size_px, ink }), left);
                let number = family + 1;
                group(&format!("cuts-{number}"), format!("Cut lines {number}"), cuts.ink, lines)
            })
            .collect();
        groups.extend(families);
    }
    if let Some(rows) = &style.rows {
        let ids: Vec<u32> = match renderer.target(&SURFACE_ID) {
            Some(ids) => read_as(gpu, ids, [0, 0], size_px)?,
            None => Vec::new(),
        };
        let spacing = rows.spacing_px / view.focal_px() as f32;
        let is_shown = |px: [f32; 2], depth_m: f32| {
            surface.pixel(px).is_some_and(|pixel| {
                let land_m = surface.position[pixel][3];
                let is_land = ids.get(pixel).is_some_and(|id| Kind::of(*id) == Kind::Land);
                land_m > 0.0 && depth_m <= allowed_m(land_m, spacing) && is_land
            })
        };
        let left = Left { faintest: rows.faintest, is_of_tone: true };
        let drawn = renderer.drawn_rows(gpu)?.unwrap_or_default();
        let lines: Vec<Polyline> = drawn.par_iter().flat_map_iter(|mark| seen(mark, is_shown)).collect();
        groups.push(group("hachures", "Hachures".to_owned(), rows.ink, surface.hazed(lines, left)));
    }
    if let Some(water) = &style.water {
        let traced = renderer.target(&WATER_INK).map(|ink| traced(gpu, ink, size_px)).transpose()?;
        let lines = surface.hazed(traced.unwrap_or_default(), Left { faintest: water.faintest, is_of_tone: false });
        groups.push(group("water", "Shores and water lines".to_owned(), water.ink, lines));
    }
    if let Some(rim) = renderer.target(&RIM) {
        let texels: Vec<[f32; 2]> = read_as(gpu, rim, [0, 0], size_px)?;
        let ink = texels.iter().map(|texel| texel[0]).collect();
        let left = Left { faintest: style.rims.faintest, is_of_tone: false };
        let traced = surface.hazed(lines(&InkPicture { size_px, ink }), left);
        groups.push(group("rims", "Outlines of no-data areas".to_owned(), style.rim_ink(), traced));
    }
    groups.retain(|group| !group.lines.is_empty());
    Ok(groups)
}

fn group(id: &str, label: String, ink: Color, lines: Vec<Polyline>) -> Group {
    Group { id: id.to_owned(), label, ink, kind: GroupKind::Marks, lines }
}

fn picture(gpu: &Gpu, ink: &Target, size_px: [u32; 2]) -> Result<InkPicture, GpuError> {
    Ok(InkPicture { size_px, ink: read_as(gpu, ink, [0, 0], size_px)? })
}

fn traced(gpu: &Gpu, ink: &Target, size_px: [u32; 2]) -> Result<Vec<Polyline>, GpuError> {
    Ok(lines(&picture(gpu, ink, size_px)?))
}

/// Returns the visible pieces of a mark, tested every half pixel.
fn seen(mark: &[RowSample], is_shown: impl Fn([f32; 2], f32) -> bool) -> Vec<Polyline> {
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
