//! Coverage of pixels by pen strokes, one row of pixels at a time, so that a picture need not be in memory.

use glam::DVec2;

/// A stroke of a round pen.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PenStroke {
    /// Points on its centre line, in pixels; y goes down.
    pub points: Vec<DVec2>,
    /// Width of the pen, in pixels.
    pub width_px: f64,
}

impl PenStroke {
    /// Returns a straight stroke.
    pub(crate) fn line(from: DVec2, to: DVec2, width_px: f64) -> Self {
        Self { points: vec![from, to], width_px }
    }

    fn high_px(&self) -> [f64; 2] {
        let reach = 0.5 * self.width_px + 1.0;
        let fold = |pick: fn(f64, f64) -> f64, from| self.points.iter().map(|point| point.y).fold(from, pick);
        [fold(f64::min, f64::MAX) - reach, fold(f64::max, f64::MIN) + reach]
    }
}

/// Adds the coverage of strokes to the pixels of row `row`, which begins at column `first`: 0 to 1, the largest of any
/// stroke. Lines narrower than a pixel cover it in proportion to their width.
pub(crate) fn cover(strokes: &[PenStroke], first: f64, row: f64, covered: &mut [f32]) {
    let y = row + 0.5;
    for stroke in strokes {
        let [top, bottom] = stroke.high_px();
        if y < top || y > bottom {
            continue;
        }
        let radius = 0.5 * stroke.width_px.max(1.0);
        let faint = stroke.width_px.clamp(0.0, 1.0);
        let dot = [stroke.points.first().copied().unwrap_or_default(); 2];
        let segments = stroke.points.windows(2).map(|pair| [pair[0], pair[1]]);
        for [a, b] in segments.chain((stroke.points.len() == 1).then_some(dot)) {
            let reach = radius + 1.0;
            if y < a.y.min(b.y) - reach || y > a.y.max(b.y) + reach {
                continue;
            }
            let from = (a.x.min(b.x) - reach - first).floor().max(0.0) as usize;
            let to = ((a.x.max(b.x) + reach - first).ceil().max(0.0) as usize).min(covered.len());
            let along = b - a;
            for (i, covered) in covered.iter_mut().enumerate().take(to).skip(from) {
                let at = DVec2::new(first + i as f64 + 0.5, y) - a;
                let part = (at.dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
                let off = (at - along * part).length();
                let cover = (faint * (radius + 0.5 - off).clamp(0.0, 1.0)) as f32;
                *covered = covered.max(cover);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Total ink of a stroke, in pixels.
    fn ink(stroke: &PenStroke) -> f64 {
        let mut sum = 0.0;
        for row in 0..40 {
            let mut covered = vec![0.0; 60];
            cover(std::slice::from_ref(stroke), 0.0, f64::from(row), &mut covered);
            sum += covered.iter().map(|part| f64::from(*part)).sum::<f64>();
        }
        sum
    }

    #[test]
    fn strokes_have_their_ink() {
        for width_px in [0.4, 1.0, 2.0, 5.0] {
            for end in [DVec2::new(50.0, 20.0), DVec2::new(10.3, 35.2), DVec2::new(45.0, 33.0)] {
                let from = DVec2::new(10.3, 12.7);
                let stroke = PenStroke::line(from, end, width_px);
                let round = 0.25 * std::f64::consts::PI * width_px * width_px;
                let expected = from.distance(end) * width_px + round;
                let found = ink(&stroke);
                assert!((found / expected - 1.0).abs() < 0.06, "{width_px} px to {end}: {found} and not {expected}");
                // Planted: half of the width.
                assert!((ink(&PenStroke { width_px: 0.5 * width_px, ..stroke }) / expected - 1.0).abs() > 0.3);
            }
        }
        let dot = PenStroke { points: vec![DVec2::new(20.0, 20.0)], width_px: 6.0 };
        assert!((ink(&dot) / (9.0 * std::f64::consts::PI) - 1.0).abs() < 0.03, "{}", ink(&dot));
    }
}
