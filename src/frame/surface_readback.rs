//! Reads the visible surface of the last frame back to the CPU, as positions and normals instead of the packed words of
//! its pictures.

use super::Renderer;
use crate::gpu::{Gpu, GpuError, readback};
use crate::scene::view::ViewUniform;
use crate::surface::id::Kind;
use crate::surface::{DISTANCE, NORMAL, NORMAL_AND_LIGHTNESS, SURFACE_ID, seen};

/// The distances of the surface that an eye saw in all pixels of a picture.
pub(crate) struct SeenDistances {
    pub(crate) size_px: [u32; 2],
    /// Distances along the view axis in metres, row by row from the top; 0 in the sky.
    distances_m: Vec<f32>,
    /// The view with the jitter of its frame.
    view: ViewUniform,
}

impl SeenDistances {
    /// Creates the distances of a picture, of which there must be one for each pixel.
    pub(crate) fn new(view: ViewUniform, size_px: [u32; 2], distances_m: Vec<f32>) -> Option<Self> {
        let pixels = size_px[0] as usize * size_px[1] as usize;
        (distances_m.len() == pixels && pixels > 0).then_some(Self { size_px, distances_m, view })
    }

    /// Returns the distance along the view axis in metres; 0 in the sky. The pixel must be in the picture.
    pub(crate) fn distance_m(&self, [x, y]: [u32; 2]) -> f32 {
        self.distances_m[y as usize * self.size_px[0] as usize + x as usize]
    }

    /// Returns the position that a pixel sees, in metres from the rig's origin, and its distance along the view axis; all
    /// 0 in the sky. The pixel must be in the picture.
    pub(crate) fn place(&self, pixel: [u32; 2]) -> [f32; 4] {
        seen::place_at(&self.view, pixel, self.distance_m(pixel))
    }
}

impl Renderer {
    /// Reads the distances of the picture of an eye. Returns `None` if the last frame has no picture of the eye.
    ///
    /// # Errors
    /// [`GpuError::Readback`] if the device is lost or out of memory.
    pub(crate) fn distances(&self, gpu: &Gpu, eye: usize) -> Result<Option<SeenDistances>, GpuError> {
        let view = self.eyes.get(eye).and_then(|memory| memory.view);
        let Some((distance, view)) = self.eye_target(eye, &DISTANCE).zip(view) else { return Ok(None) };
        let size_px = distance.size_px();
        Ok(SeenDistances::new(view, size_px, readback::read_as(gpu, distance, [0, 0], size_px)?))
    }

    /// Reads the position that each pixel of a window of an eye's picture sees, in metres from the rig's origin, and
    /// its distance along the view axis; all 0 in the sky. Returns `None` if the last frame has no picture of the eye.
    ///
    /// # Errors
    /// [`GpuError::Readback`] if the device is lost or out of memory.
    pub fn places(
        &self,
        gpu: &Gpu,
        eye: usize,
        origin_px: [u32; 2],
        size_px: [u32; 2],
    ) -> Result<Option<Vec<[f32; 4]>>, GpuError> {
        let view = self.eyes.get(eye).and_then(|memory| memory.view);
        let Some((distance, view)) = self.eye_target(eye, &DISTANCE).zip(view) else { return Ok(None) };
        let distances_m: Vec<f32> = readback::read_as(gpu, distance, origin_px, size_px)?;
        let pixels = (0..size_px[1]).flat_map(|y| (0..size_px[0]).map(move |x| [x + origin_px[0], y + origin_px[1]]));
        let place = |(pixel, along_m)| seen::place_at(&view, pixel, along_m);
        Ok(Some(pixels.zip(distances_m).map(place).collect()))
    }

    /// Reads the unit normal and the lightness of each pixel of a window of an eye's picture; all 0 in the sky. Returns
    /// `None` if the last frame has no picture of the eye.
    ///
    /// # Errors
    /// The errors of [`places`](Self::places).
    pub fn normals(
        &self,
        gpu: &Gpu,
        eye: usize,
        origin_px: [u32; 2],
        size_px: [u32; 2],
    ) -> Result<Option<Vec<[f32; 4]>>, GpuError> {
        if let Some(normal) = self.eye_target(eye, &NORMAL) {
            let words: Vec<u32> = readback::read_as(gpu, normal, origin_px, size_px)?;
            return Ok(Some(words.into_iter().map(|word| seen::surface_of([word, 0])).collect()));
        }
        let Some(normal) = self.eye_target(eye, &NORMAL_AND_LIGHTNESS) else { return Ok(None) };
        let words: Vec<[u32; 2]> = readback::read_as(gpu, normal, origin_px, size_px)?;
        Ok(Some(words.into_iter().map(seen::surface_of).collect()))
    }

    /// Reads the kind of surface of each pixel of a window of an eye's picture. Returns `None` if the last frame has no
    /// picture of the eye.
    ///
    /// # Errors
    /// The errors of [`places`](Self::places).
    pub(crate) fn kinds(
        &self,
        gpu: &Gpu,
        eye: usize,
        origin_px: [u32; 2],
        size_px: [u32; 2],
    ) -> Result<Option<Vec<Kind>>, GpuError> {
        if let Some(ids) = self.eye_target(eye, &SURFACE_ID) {
            let ids: Vec<u32> = readback::read_as(gpu, ids, origin_px, size_px)?;
            return Ok(Some(ids.into_iter().map(Kind::of).collect()));
        }
        // Without ids all is land.
        let Some(distance) = self.eye_target(eye, &DISTANCE) else { return Ok(None) };
        let distances_m: Vec<f32> = readback::read_as(gpu, distance, origin_px, size_px)?;
        Ok(Some(distances_m.into_iter().map(|along_m| if along_m > 0.0 { Kind::Land } else { Kind::Sky }).collect()))
    }
}
