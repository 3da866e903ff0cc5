//! Reads back the pictures of a frame. `rig` is the rig with jitter, as it was sampled; the result is without jitter.
//!
//! Ink of strokes includes the effect of haze; ink of line pictures is read as the composite reads it, before haze. If
//! a style has both, the larger ink counts.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::{DrawnFrame, read_stroke_pictures};
use crate::composite::PICTURE;
use crate::frame::Renderer;
use crate::gpu::target::Target;
use crate::gpu::{Gpu, GpuError, readback};
use crate::lines::strokes::centres::CENTRES;
use crate::lines::strokes::stroke::{INK, STROKE_IDS};
use crate::scene::view::{Rig, View};
use crate::style::Style;
use crate::style::color::srgb_from_linear;
use crate::surface::rows::ribbons::ROW_INK;
use crate::tones::balance::MARKS;

/// Reads what an eye drew last, with `rig` and `style`. Waits for the GPU.
///
/// # Errors
/// [`GpuError::Readback`].
pub fn read_drawn(
    gpu: &Gpu,
    renderer: &Renderer,
    rig: &Rig,
    eye: usize,
    style: &Style,
) -> Result<DrawnFrame, GpuError> {
    let no_frame = || GpuError::Readback("no frame was drawn".to_owned());
    let picture = renderer.eye_target(eye, &PICTURE).ok_or_else(no_frame)?;
    let size_px = picture.size_px();
    // The displayed lines and strokes may be the mean of several frames.
    let mean = renderer.history_targets(eye);
    let line: Option<Vec<f32>> = match (renderer.line_target(eye, style), mean) {
        (Some(_), Some([history, _])) => Some(channel::<4>(gpu, history, size_px, 3)?),
        (line, _) => line.map(|line| readback::read_as(gpu, line, [0, 0], size_px)).transpose()?,
    };
    let ink = match (renderer.eye_target(eye, &INK).filter(|_| style.strokes().is_some()), mean) {
        (Some(_), Some([_, seen])) => Some(channel::<4>(gpu, seen, size_px, 2)?),
        (drawn, _) => drawn.map(|drawn| channel::<1>(gpu, drawn, size_px, 0)).transpose()?,
    };
    let marks = renderer.eye_target(eye, &MARKS).filter(|_| style.hatching().is_some());
    let marks: Option<Vec<f32>> = marks.map(|marks| readback::read_as(gpu, marks, [0, 0], size_px)).transpose()?;
    let rows = renderer.eye_target(eye, &ROW_INK).filter(|_| style.rows().is_some());
    let rows = rows.map(|rows| channel::<1>(gpu, rows, size_px, 0)).transpose()?;
    let (mut luma, mut colors) = (Vec::new(), Vec::new());
    for [red, green, blue, _] in halves::<4>(gpu, picture, size_px)? {
        luma.push(srgb_from_linear(0.2126 * red + 0.7152 * green + 0.0722 * blue));
        colors.push([red, green, blue].map(|value| (255.0 * srgb_from_linear(value)).round() as u8));
    }
    let view = View { jitter_px: DVec2::ZERO, ..rig.eyes[eye] };
    let mut position = renderer.places(gpu, eye, [0, 0], size_px)?.ok_or_else(no_frame)?;
    if view != rig.eyes[eye] {
        unmove(&mut position, &view, rig.origin_m);
    }
    Ok(DrawnFrame {
        view,
        origin_m: rig.origin_m,
        position,
        ink: match (line, ink) {
            (Some(line), Some(ink)) => Some(line.into_iter().zip(ink).map(|(line, ink)| line.max(ink)).collect()),
            (line, ink) => line.or(ink),
        },
        strokes: read_stroke_pictures(gpu, renderer, eye, style, &STROKE_IDS)?,
        centres: read_stroke_pictures(gpu, renderer, eye, style, &CENTRES)?,
        // In styles with rows, the land's marks are the rows, and the other marks are those of objects on the land.
        marks: match (marks, rows) {
            (Some(marks), Some(rows)) => Some(marks.into_iter().zip(rows).map(|(mark, row)| mark.max(row)).collect()),
            (marks, rows) => marks.or(rows),
        },
        luma,
        colors,
    })
}

/// Moves the positions of a jittered picture to the rays through pixel centres, at the same distances.
fn unmove(position: &mut [[f32; 4]], view: &View, origin_m: DVec3) {
    let width = view.part.size_px[0] as usize;
    let origin_px = DVec2::new(view.part.origin_px[0].into(), view.part.origin_px[1].into());
    position.par_iter_mut().enumerate().filter(|(_, at)| at[3] > 0.0).for_each(|(pixel, at)| {
        let centre_px = DVec2::new((pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5) + origin_px;
        let place_m = view.ray(centre_px) * f64::from(at[3]) + (view.pose.position_m - origin_m);
        [at[0], at[1], at[2]] = place_m.as_vec3().to_array();
    });
}

fn channel<const CHANNELS: usize>(
    gpu: &Gpu,
    target: &Target,
    size_px: [u32; 2],
    channel: usize,
) -> Result<Vec<f32>, GpuError> {
    Ok(halves::<CHANNELS>(gpu, target, size_px)?.into_iter().map(|texel| texel[channel]).collect())
}

fn halves<const CHANNELS: usize>(
    gpu: &Gpu,
    target: &Target,
    size_px: [u32; 2],
) -> Result<Vec<[f32; CHANNELS]>, GpuError> {
    let halves: Vec<u16> = readback::read_as(gpu, target, [0, 0], size_px)?;
    let texels = halves.as_chunks::<CHANNELS>().0.iter();
    Ok(texels.map(|texel| texel.map(|bits| half::f16::from_bits(bits).to_f32())).collect())
}
