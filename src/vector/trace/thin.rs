//! Thins marks to lines one pixel wide.

use rayon::prelude::*;

use super::InkPicture;
use super::follow::Chain;

/// Ink above which a pixel belongs to a mark whatever its neighbours are, and ink below which it never does.
const FULL: f32 = 0.3;
const FAINT: f32 = 0.03;
/// Least second difference across a mark, divided by its ink. For a bell as wide as the thinnest marks it is 0.7 in the
/// middle.
const BENT: f32 = 0.12;
/// Binomial filter of five pixels with variance 1. A narrower filter would leave second differences of the staircase.
const BELL: [f32; 5] = [0.0625, 0.25, 0.375, 0.25, 0.0625];

/// Returns the image blurred with a standard deviation of one pixel.
fn smoothed(picture: &InkPicture) -> Vec<f32> {
    let [width, height] = picture.size_px.map(|side| side as usize);
    let near = |i: usize, k: usize, count: usize| (i + k).saturating_sub(2).min(count - 1);
    let mut across = vec![0.0; picture.ink.len()];
    across.par_chunks_exact_mut(width.max(1)).zip(picture.ink.par_chunks_exact(width.max(1))).for_each(|(row, ink)| {
        for (x, value) in row.iter_mut().enumerate() {
            *value = BELL.iter().enumerate().map(|(k, weight)| weight * ink[near(x, k, width)]).sum();
        }
    });
    let mut smooth = vec![0.0; picture.ink.len()];
    smooth.par_chunks_exact_mut(width.max(1)).enumerate().for_each(|(y, row)| {
        for (x, value) in row.iter_mut().enumerate() {
            *value = BELL.iter().enumerate().map(|(k, weight)| weight * across[near(y, k, height) * width + x]).sum();
        }
    });
    smooth
}

/// A mask of inked pixels, with a border of one empty pixel.
#[derive(Clone)]
pub(super) struct Mask {
    /// Number of pixels in a row, border included.
    pub stride: usize,
    /// 1 where there is ink, otherwise 0.
    pub on: Vec<u8>,
}

impl Mask {
    /// Builds the mask of an image's marks: pixels that are full of ink or darker than both sides, however faint, but
    /// not those lighter than both sides.
    pub(super) fn of(picture: &InkPicture) -> Self {
        let [width, height] = picture.size_px.map(|side| side as usize);
        let stride = width + 2;
        let mut on = vec![0; stride * (height + 2)];
        let smooth = &smoothed(picture);
        let at = |x: usize, y: usize| smooth[y.min(height - 1) * width + x.min(width - 1)];
        on.par_chunks_exact_mut(stride).enumerate().skip(1).take(height).for_each(|(row, on)| {
            let (y, north, south) = (row - 1, row.saturating_sub(2), row);
            for x in 0..width {
                let (west, east, own) = (x.saturating_sub(1), x + 1, at(x, y));
                let xx = at(west, y) + at(east, y) - 2.0 * own;
                let yy = at(x, north) + at(x, south) - 2.0 * own;
                let xy = 0.25 * (at(east, south) + at(west, north) - at(west, south) - at(east, north));
                // The eigenvalues of the second differences: how much darker, and how much lighter, the pixel is than
                // both sides.
                let (mean, away) = (0.5 * (xx + yy), (0.25 * (xx - yy) * (xx - yy) + xy * xy).sqrt());
                let is_ridge = away - mean > BENT * own;
                let is_valley = away + mean > BENT * own;
                let is_full = picture.ink[y * width + x] > FULL && !is_valley;
                on[x + 1] = u8::from(own > FAINT && (is_ridge || is_full));
            }
        });
        Self { stride, on }
    }

    /// Builds the mask of pixels with more than `least` ink.
    pub(super) fn darker(picture: &InkPicture, least: f32) -> Self {
        let [width, height] = picture.size_px.map(|side| side as usize);
        let stride = width + 2;
        let mut on = vec![0; stride * (height + 2)];
        for (row, ink) in on.chunks_exact_mut(stride).skip(1).zip(picture.ink.chunks_exact(width.max(1))) {
            row[1..].iter_mut().zip(ink).for_each(|(on, ink)| *on = u8::from(*ink > least));
        }
        Self { stride, on }
    }

    /// Returns the 4-connected areas of the mask.
    pub(super) fn areas(mut self) -> Vec<Chain> {
        let mut areas = Vec::new();
        for first in 0..self.on.len() {
            if self.on[first] == 0 {
                continue;
            }
            self.on[first] = 0;
            let (mut places, mut open) = (vec![first], vec![first]);
            while let Some(at) = open.pop() {
                for other in [at - 1, at + 1, at - self.stride, at + self.stride] {
                    if std::mem::take(&mut self.on[other]) == 1 {
                        places.push(other);
                        open.push(other);
                    }
                }
            }
            areas.push(Chain { places, is_closed: false });
        }
        areas
    }

    /// Returns the indices of the eight neighbours of a pixel, clockwise from north.
    pub(super) fn around(&self, at: usize) -> [usize; 8] {
        let stride = self.stride;
        [at - stride, at - stride + 1, at + 1, at + stride + 1, at + stride, at + stride - 1, at - 1, at - stride - 1]
    }

    /// Returns the distance of each pixel from the nearest one without ink, in pixels, by the chamfer distance with
    /// steps of 3 and 4 thirds (Borgefors 1986).
    pub(super) fn depth(&self) -> Vec<f32> {
        let mut thirds: Vec<u16> = self.on.iter().map(|on| if *on == 1 { u16::MAX - 8 } else { 0 }).collect();
        let inner = self.stride + 1..self.on.len().saturating_sub(self.stride + 1);
        let reach = |thirds: &mut Vec<u16>, at: usize, before: [usize; 4]| {
            let near = before.iter().zip([4, 3, 4, 3]).map(|(other, step)| thirds[*other].saturating_add(step)).min();
            thirds[at] = near.map_or(thirds[at], |near| near.min(thirds[at]));
        };
        for at in inner.clone() {
            reach(&mut thirds, at, [at - self.stride - 1, at - self.stride, at - self.stride + 1, at - 1]);
        }
        for at in inner.rev() {
            reach(&mut thirds, at, [at + self.stride + 1, at + self.stride, at + self.stride - 1, at + 1]);
        }
        thirds.into_iter().map(|thirds| f32::from(thirds) / 3.0).collect()
    }

    /// Thins the mask to centre lines one pixel wide.
    pub(super) fn thinned(mut self) -> Self {
        loop {
            let before = self.clear(false);
            let after = self.clear(true);
            if before + after == 0 {
                break;
            }
        }
        self.clear_corners();
        self
    }

    /// Runs one subiteration of Guo and Hall, which removes borders on one side or on the other. Returns how many
    /// pixels were removed.
    fn clear(&mut self, is_second: bool) -> usize {
        let stride = self.stride;
        let rows = self.on.len() / stride;
        let goes: Vec<usize> = (1..rows.saturating_sub(1))
            .into_par_iter()
            .flat_map_iter(|row| {
                let this = &*self;
                (row * stride + 1..(row + 1) * stride - 1)
                    .filter(move |at| this.on[*at] == 1 && this.goes(*at, is_second))
            })
            .collect();
        goes.iter().for_each(|at| self.on[*at] = 0);
        goes.len()
    }

    fn goes(&self, at: usize, is_second: bool) -> bool {
        let [n, ne, e, se, s, sw, w, nw] = self.around(at).map(|other| self.on[other] == 1);
        let count = |pairs: [bool; 4]| pairs.into_iter().filter(|is| *is).count();
        let pairs = count([nw || n, ne || e, se || s, sw || w]).min(count([n || ne, e || se, s || sw, w || nw]));
        let stays = if is_second { (s || sw || !nw) && w } else { (n || ne || !se) && e };
        self.parts_without(at) == 1 && (2..=3).contains(&pairs) && !stays
    }

    /// Returns into how many pieces the neighbours of a pixel would separate without it.
    fn parts_without(&self, at: usize) -> usize {
        let [n, ne, e, se, s, sw, w, nw] = self.around(at).map(|other| self.on[other] == 1);
        [!n && (ne || e), !e && (se || s), !s && (sw || w), !w && (nw || n)].into_iter().filter(|is| *is).count()
    }

    /// Removes the pixel in the corner where a line turns, so that inner pixels of a line have two neighbours.
    fn clear_corners(&mut self) {
        for at in self.stride + 1..self.on.len().saturating_sub(self.stride + 1) {
            let has_two =
                self.on[at] == 1 && self.around(at).into_iter().filter(|other| self.on[*other] == 1).count() > 1;
            if has_two && self.parts_without(at) == 1 {
                self.on[at] = 0;
            }
        }
    }
}
