//! The ink at which each texel is reached: the least over all marks.
//!
//! A mark begins in its middle and grows from there along itself and to its sides: the tone darkens by a stroke that is
//! drawn, not by one that pops up. The middle line, which is one pixel wide, appears as a whole, because a line thinner
//! than a pixel would break into dots wherever it passes between two pixels.

use super::growth::Growth;

/// Half a pixel: the part of a mark that exists as soon as the mark does.
const CORE_PX: f32 = 0.5;
/// The ink over which a mark grows to its width: this fraction of the ink at its beginning, plus `MIN_GROWING`.
const GROWING: f32 = 0.3;
const MIN_GROWING: f32 = 0.01;
/// The value of texels that no mark has reached.
const UNREACHED: f32 = 1e9;

/// The ink at which each texel is reached. The tile repeats.
pub(super) struct InkMap {
    pub(super) side_px: usize,
    pub(super) ink: Vec<f32>,
}

/// A place on a mark, with everything that its growth depends on.
#[derive(Clone, Copy)]
pub(super) struct MarkPoint {
    /// Ink at which the mark begins.
    pub(super) begin: f32,
    /// Distance from the middle line.
    pub(super) away_px: f32,
    /// Half the mark's width here, at mid tone.
    pub(super) half_px: f32,
    /// Position along the mark: 0 in its middle, 1 at its ends.
    pub(super) along: f32,
}

impl MarkPoint {
    /// Returns the ink at which the place is reached.
    pub(super) fn reached_at(self, growth: &Growth) -> f32 {
        let half_px = self.half_px.max(CORE_PX);
        let rim_px = (half_px * growth.width_at(self.begin) - CORE_PX).max(0.25);
        let across = ((self.away_px - CORE_PX).max(0.0) / rim_px).min(1.0);
        let growing = (GROWING * self.begin + MIN_GROWING) * (0.5 * across * across + 0.5 * self.along * self.along);
        let widened = if self.away_px <= CORE_PX { 0.0 } else { growth.widened(self.away_px / half_px) };
        (self.begin + growing).max(widened)
    }
}

impl InkMap {
    pub(super) fn new(side_px: usize) -> Self {
        Self { side_px, ink: vec![UNREACHED; side_px * side_px] }
    }

    /// Lowers the ink of a texel to `ink`.
    pub(super) fn reach(&mut self, x: usize, y: usize, ink: f32) {
        let texel = &mut self.ink[y * self.side_px + x];
        *texel = texel.min(ink);
    }

    /// Draws a piece of a mark, from one point to another, each with half its width and its position along the mark, up
    /// to `reach_px` beyond its border.
    pub(super) fn piece(&mut self, growth: &Growth, begin: f32, ends: [End; 2], reach_px: f32) {
        let [a, b] = ends;
        let wide = a.half_px.max(b.half_px) + reach_px;
        let low = [0, 1].map(|axis| (a.at[axis].min(b.at[axis]) - wide).floor() as i64);
        let high = [0, 1].map(|axis| (a.at[axis].max(b.at[axis]) + wide).ceil() as i64);
        let way = [b.at[0] - a.at[0], b.at[1] - a.at[1]];
        let square = (way[0] * way[0] + way[1] * way[1]).max(1e-6);
        for y in low[1]..=high[1] {
            for x in low[0]..=high[0] {
                let from = [x as f32 + 0.5 - a.at[0], y as f32 + 0.5 - a.at[1]];
                let part = ((from[0] * way[0] + from[1] * way[1]) / square).clamp(0.0, 1.0);
                let off = [from[0] - part * way[0], from[1] - part * way[1]];
                let away_px = (off[0] * off[0] + off[1] * off[1]).sqrt();
                if away_px > wide {
                    continue;
                }
                let mix = |a: f32, b: f32| a + (b - a) * part;
                let place =
                    MarkPoint { begin, away_px, half_px: mix(a.half_px, b.half_px), along: mix(a.along, b.along) };
                let side = self.side_px as i64;
                self.reach(x.rem_euclid(side) as usize, y.rem_euclid(side) as usize, place.reached_at(growth));
            }
        }
    }

    /// Fills the texels that no mark has reached by distance from those that one has.
    pub(super) fn close_up(&mut self) {
        let side = self.side_px;
        let open: Vec<usize> = (0..side * side).filter(|place| self.ink[*place] >= UNREACHED).collect();
        // All borders get the same height, so that the remaining texels close by distance alone.
        let most = self.ink.iter().copied().filter(|ink| *ink < UNREACHED).fold(0.0, f32::max);
        // Sweeps forward and backward, as for a chamfer distance (Borgefors 1986), until nothing changes: the tile
        // repeats, so two sweeps need not be enough.
        let mut is_changed = !open.is_empty();
        while is_changed {
            is_changed = false;
            for i in (0..open.len()).chain((0..open.len()).rev()) {
                let place = open[i];
                let least = self.neighbours(place).map(|(ink, step)| ink.max(most) + step).fold(f32::MAX, f32::min);
                if least < self.ink[place] {
                    self.ink[place] = least;
                    is_changed = true;
                }
            }
        }
    }

    /// Returns the ink of the eight neighbours of a texel, with their distances.
    fn neighbours(&self, place: usize) -> impl Iterator<Item = (f32, f32)> + '_ {
        const DIAGONAL: f32 = std::f32::consts::SQRT_2;
        let side = self.side_px;
        let (x, y) = (place % side, place / side);
        let steps = [(0, 1, 1.0), (1, 0, 1.0), (1, 2, 1.0), (2, 1, 1.0)].into_iter().chain([
            (0, 0, DIAGONAL),
            (2, 0, DIAGONAL),
            (0, 2, DIAGONAL),
            (2, 2, DIAGONAL),
        ]);
        // One is added before one is subtracted, so that no index is negative.
        steps.map(move |(right, down, step)| {
            (self.ink[(y + side + down - 1) % side * side + (x + side + right - 1) % side], step)
        })
    }
}

/// An end of a piece of a mark.
#[derive(Clone, Copy)]
pub(super) struct End {
    pub(super) at: [f32; 2],
    pub(super) half_px: f32,
    pub(super) along: f32,
}
