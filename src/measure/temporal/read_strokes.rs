//! Reading back which strokes are at which pixels, from the buffers that the stroke passes leave on the GPU.

use glam::Vec2;
use rayon::prelude::*;

use super::StrokePictures;
use crate::frame::Renderer;
use crate::gpu::readback::{self, read_buffer};
use crate::gpu::target::TargetKind;
use crate::gpu::{Gpu, GpuError};
use crate::lines::strokes::LeftOut;
use crate::lines::strokes::samples::{Sample, SampleCounts};
use crate::style::Style;

/// Returns the number of strokes that the last frame drew, without those that only fade out; `None` if the style has
/// none.
///
/// # Errors
/// [`GpuError::Readback`].
pub(crate) fn count_strokes(gpu: &Gpu, renderer: &Renderer, style: &Style) -> Result<Option<u64>, GpuError> {
    let (Some(_), Some(passes)) = (style.strokes(), renderer.strokes()) else { return Ok(None) };
    let counts: Vec<SampleCounts> = read_buffer(gpu, &passes.samples().counts.raw, 1)?;
    Ok(counts.first().map(|counts| u64::from(counts.strokes)))
}

/// Returns the strokes of the last frame that were left out for lack of room; `None` if the style has no strokes.
///
/// # Errors
/// [`GpuError::Readback`].
pub(crate) fn strokes_left_out(gpu: &Gpu, renderer: &Renderer, style: &Style) -> Result<Option<LeftOut>, GpuError> {
    let (Some(_), Some(passes)) = (style.strokes(), renderer.strokes()) else { return Ok(None) };
    passes.left_out(gpu).map(Some)
}

/// Reads the strokes at each pixel of an eye's last frame from `numbers`, a picture of sample numbers; `None` if the
/// frame has none. The parameter is that of the nearest point on the segment drawn at the pixel.
///
/// # Errors
/// [`GpuError::Readback`].
pub(crate) fn read_stroke_pictures(
    gpu: &Gpu,
    renderer: &Renderer,
    eye: usize,
    style: &Style,
    numbers: &TargetKind,
) -> Result<Option<StrokePictures>, GpuError> {
    let drawn = renderer.eye_strokes(eye).zip(renderer.eye_target(eye, numbers));
    let Some((passes, ids)) = drawn.filter(|_| style.strokes().is_some()) else {
        return Ok(None);
    };
    let size_px = ids.size_px();
    let numbers: Vec<u32> = readback::read_as(gpu, ids, [0, 0], size_px)?;
    let (_, samples) = passes.samples().read(gpu)?;
    let width = size_px[0] as usize;
    let places: Vec<(u32, [f32; 3])> = numbers
        .into_par_iter()
        .enumerate()
        .map(|(pixel, number)| {
            // A segment connects the sample with its number to the next one.
            let segment = (number as usize).checked_sub(1).and_then(|first| samples.get(first..first + 2));
            let Some([a, b]) = segment else { return (0, [f32::NAN; 3]) };
            let at = Vec2::new((pixel % width) as f32 + 0.5, (pixel / width) as f32 + 0.5);
            let (begin, way) = (Vec2::from(a.px), Vec2::from(b.px) - Vec2::from(a.px));
            // Strokes that run off the page are extrapolated beyond their last sample.
            let runs_off = |own: &Sample| own.flags & Sample::RUNS_OFF != 0;
            let least = if runs_off(a) && a.flags & Sample::FIRST != 0 { f32::NEG_INFINITY } else { 0.0 };
            let most = if runs_off(b) && b.flags & Sample::LAST != 0 { f32::INFINITY } else { 1.0 };
            let part = (at - begin).dot(way) / way.length_squared().max(1e-12);
            let between = |a: f32, b: f32| a + part.clamp(0.0, 1.0) * (b - a);
            let half_width_px = between(a.half_width_px, b.half_width_px);
            let along_px = a.along_px + part.clamp(least, most) * (b.along_px - a.along_px);
            (a.stroke, [along_px, half_width_px, between(a.depth_m, b.depth_m)])
        })
        .collect();
    Ok(Some(StrokePictures {
        id: places.iter().map(|(id, ..)| *id).collect(),
        along_px: places.iter().map(|(_, at)| at[0]).collect(),
        half_width_px: places.iter().map(|(_, at)| at[1]).collect(),
        depth_m: places.iter().map(|(_, at)| at[2]).collect(),
        identities_last: true,
        rebuilt: passes.rebuilt(),
    }))
}
