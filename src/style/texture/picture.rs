//! A picture of a stroke, as a user draws or scans it: a horizontal stroke of dark ink on white or transparent paper. The
//! left end joins the right end, because the picture repeats along strokes.

use std::path::Path;

use crate::style::{StyleError, images};

/// Least and largest width and height of a picture, in pixels.
const SIDES_PX: [[u32; 2]; 2] = [[8, 8192], [4, 2048]];
/// Least darkness of the darkest pixel: a paler picture has no stroke.
const LEAST_DARKNESS: f32 = 0.1;
/// A row that is less dark than this part of the darkest row is paper, with specks of dust.
const PAPER_ROW: f32 = 0.1;
/// Pixels less dark than this part of the darkest one are those of the paper, if they are at least `LEAST_PAPER` of all and
/// no darker than `DARKEST_PAPER`.
const PALE: f32 = 0.4;
const LEAST_PAPER: f32 = 0.1;
const DARKEST_PAPER: f32 = 0.35;
/// Noise that a scanner adds to the tone of paper, as darkness, 0 to 1.
const PAPER_NOISE: f32 = 0.05;

/// The darkness of a picture of a stroke. Paper is white, and rows of paper above and below the stroke are left out.
#[derive(Clone)]
pub struct StrokePicture {
    size_px: [usize; 2],
    /// 0 (paper) to 1, in rows along the stroke.
    darkness: Vec<f32>,
    /// Checksum of the darkness.
    crc32: u32,
}

/// Pictures are compared in every frame, so their checksums are.
impl PartialEq for StrokePicture {
    fn eq(&self, other: &Self) -> bool {
        (self.size_px, self.crc32) == (other.size_px, other.crc32)
    }
}

impl std::fmt::Debug for StrokePicture {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "StrokePicture {:?}", self.size_px)
    }
}

impl StrokePicture {
    /// Returns how many times the stroke is longer than it is wide.
    pub(crate) fn length_to_width(&self) -> f32 {
        self.size_px[0] as f32 / self.size_px[1] as f32
    }

    /// Returns the darkness in `size_px` texels along and across the stroke: means over the area of each texel, or
    /// linear interpolation where texels are smaller than pixels. The picture repeats along the stroke.
    pub(crate) fn resampled(&self, size_px: [usize; 2]) -> Vec<f32> {
        let [width, height] = self.size_px;
        let along = taps(width, size_px[0], true);
        let across = taps(height, size_px[1], false);
        let rows: Vec<f32> = (0..height)
            .flat_map(|y| along.iter().map(move |taps| (y, taps)))
            .map(|(y, taps)| taps.iter().map(|(x, weight)| weight * self.darkness[y * width + x]).sum())
            .collect();
        let texels = across.iter().flat_map(|taps| (0..size_px[0]).map(move |x| (x, taps)));
        texels.map(|(x, taps)| taps.iter().map(|(y, weight)| weight * rows[y * size_px[0] + x]).sum()).collect()
    }
}

/// Returns, for each of `to` texels, the pixels of a row of `from` that it covers, and their weights, whose sum is 1.
fn taps(from: usize, to: usize, repeats: bool) -> Vec<Vec<(usize, f32)>> {
    let step = from as f32 / to as f32;
    // A tent that is at least two pixels wide.
    let radius = step.max(1.0);
    (0..to)
        .map(|texel| {
            let middle = (texel as f32 + 0.5) * step - 0.5;
            let [first, last] = [(middle - radius).ceil() as i64, (middle + radius).floor() as i64];
            let weight = |at: i64| (1.0 - (at as f32 - middle).abs() / radius).max(0.0);
            let sum: f32 = (first..=last).map(weight).sum();
            let place = |at: i64| match repeats {
                true => at.rem_euclid(from as i64) as usize,
                false => at.clamp(0, from as i64 - 1) as usize,
            };
            (first..=last).map(|at| (place(at), weight(at) / sum)).collect()
        })
        .collect()
}

/// Reads a picture of a stroke.
///
/// # Errors
/// [`StyleError::Image`] if the picture is missing, cannot be decoded, is too small or too large, or shows no ink.
pub(super) fn read(path: &Path) -> Result<StrokePicture, StyleError> {
    let wrong = |cause| StyleError::Image { path: path.display().to_string(), cause };
    read_darkness(path).map_err(wrong)
}

fn read_darkness(path: &Path) -> Result<StrokePicture, String> {
    let picture = images::read(path, "picture of a stroke", |[width, height]| {
        let [[narrow, wide], [low, high]] = SIDES_PX;
        if (narrow..=wide).contains(&width) && (low..=high).contains(&height) {
            return Ok(());
        }
        Err(format!(
            "it is {width} × {height} px; a picture of a stroke must be {narrow} to {wide} px long and {low} to {high} \
             px high"
        ))
    })?;
    let [width, height] = [picture.width, picture.height].map(|side| side as usize);
    let mut darkness: Vec<f32> = images::darkness(&picture).collect();
    let darkest = darkness.iter().copied().fold(0.0_f32, f32::max);
    if darkest < LEAST_DARKNESS {
        return Err("it shows no stroke: draw dark ink on white or transparent paper".to_owned());
    }
    let paper = paper(&darkness, darkest);
    if paper > 0.0 {
        // The noise of scanned paper is paper, too.
        let white = paper + PAPER_NOISE;
        darkness.iter_mut().for_each(|value| *value = ((*value - white) / (1.0 - white)).max(0.0));
    }
    // The stroke's width is that of its ink.
    let rows: Vec<f32> = darkness.chunks_exact(width).map(|row| row.iter().sum::<f32>() / width as f32).collect();
    let most = rows.iter().copied().fold(0.0_f32, f32::max);
    let is_ink = |y: &usize| rows[*y] > PAPER_ROW * most;
    let first = (0..height).find(is_ink).unwrap_or(0);
    let last = (0..height).rev().find(is_ink).unwrap_or(height - 1);
    let own_rows = last + 1 - first;
    let middle = &rows[first + own_rows / 3..=first + 2 * own_rows / 3];
    let middle = middle.iter().sum::<f32>() / middle.len() as f32;
    if rows[first].min(rows[last]) > 2.0 * middle {
        return Err("its border is darker than its middle: draw dark ink on white or transparent paper".to_owned());
    }
    if own_rows > width {
        return Err(format!(
            "its ink is {own_rows} px high and {width} px long: the stroke must lie from left to right"
        ));
    }
    let darkness = darkness[first * width..(last + 1) * width].to_vec();
    let crc32 = crc32fast::hash(bytemuck::cast_slice(&darkness));
    Ok(StrokePicture { size_px: [width, own_rows], darkness, crc32 })
}

/// Returns the darkness of the paper: the median of pale pixels; 0 if there is none.
fn paper(darkness: &[f32], darkest: f32) -> f32 {
    let mut pale: Vec<f32> = darkness.iter().copied().filter(|value| *value < PALE * darkest).collect();
    if (pale.len() as f32) < LEAST_PAPER * darkness.len() as f32 {
        return 0.0;
    }
    pale.sort_by(f32::total_cmp);
    let median = pale[pale.len() / 2];
    if median > DARKEST_PAPER { 0.0 } else { median }
}
