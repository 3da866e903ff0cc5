//! What a frame drew, from the GPU.
//!
//! The ink of strokes is what haze has left of it; that of line pictures is what the composite reads, before haze takes
//! its part. Where a style has both, the darker one counts.

use super::{DrawnFrame, read_stroke_pictures};
use crate::composite::PICTURE;
use crate::frame::Frame;
use crate::gpu::target::Target;
use crate::gpu::{Gpu, GpuError, readback};
use crate::lines::strokes::centres::CENTRES;
use crate::lines::strokes::stroke::{INK, STROKE_IDS};
use crate::scene::view::Rig;
use crate::style::Style;
use crate::style::color::srgb_from_linear;
use crate::surface::POSITION;
use crate::tones::balance::MARKS;

/// Reads what an eye of `frame` drew last: with `rig` and `style`. Waits for the GPU.
///
/// # Errors
/// [`GpuError::Readback`].
pub fn read_drawn(gpu: &Gpu, frame: &Frame, rig: &Rig, eye: usize, style: &Style) -> Result<DrawnFrame, GpuError> {
    let (Some(picture), Some(position)) = (frame.eye_target(eye, &PICTURE), frame.eye_target(eye, &POSITION)) else {
        return Err(GpuError::Readback("no frame was drawn".to_owned()));
    };
    let size_px = picture.size_px();
    let line = frame.line_target(eye, style);
    let line: Option<Vec<f32>> = line.map(|line| readback::read_as(gpu, line, [0, 0], size_px)).transpose()?;
    let drawn = frame.eye_target(eye, &INK).filter(|_| style.strokes.is_some());
    let ink = drawn.map(|drawn| halves::<1>(gpu, drawn, size_px)).transpose()?;
    let ink = ink.map(|ink| ink.into_iter().map(|[ink]| ink).collect::<Vec<f32>>());
    let marks = frame.eye_target(eye, &MARKS).filter(|_| style.hatching.is_some());
    let luma = halves::<4>(gpu, picture, size_px)?
        .into_iter()
        .map(|[red, green, blue, _]| srgb_from_linear(0.2126 * red + 0.7152 * green + 0.0722 * blue));
    Ok(DrawnFrame {
        view: rig.eyes[eye],
        origin_m: rig.origin_m,
        position: readback::read_as(gpu, position, [0, 0], size_px)?,
        ink: match (line, ink) {
            (Some(line), Some(ink)) => Some(line.into_iter().zip(ink).map(|(line, ink)| line.max(ink)).collect()),
            (line, ink) => line.or(ink),
        },
        strokes: read_stroke_pictures(gpu, frame, eye, style, &STROKE_IDS)?,
        centres: read_stroke_pictures(gpu, frame, eye, style, &CENTRES)?,
        marks: marks.map(|marks| readback::read_as(gpu, marks, [0, 0], size_px)).transpose()?,
        luma: luma.collect(),
    })
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
