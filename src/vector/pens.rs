//! Draws lines of varying width with pens of one width each.
//!
//! Without pens, a line is split where its width or ink has changed by a factor, and each piece has the mean width and
//! ink. With pens, each piece is drawn by the pen nearest to its width. A pen has no faint ink, so a faint piece counts
//! as thinner. A piece wider than its pen is drawn by several parallel strokes.

use crate::lines::strokes::polylines::{Polyline, PolylinePoint};

/// Factor by which widths or inks differ from one piece to the next.
const STEP: f32 = 1.6;
/// Widths below this fraction of a line's greatest width belong to tapered ends.
const THIN_PART: f32 = 0.3;
/// Least ratio of length to width of a piece.
const SLENDER: f32 = 2.0;
/// Pieces thinner than this fraction of the finest pen are left out.
const FAINT_PART: f32 = 0.35;
/// Overlap of parallel strokes, as a fraction of the pen's width.
const OVERLAP: f32 = 0.1;
const ROUNDS: usize = 24;
/// Largest number of parallel strokes of a piece; a piece that would need more is drawn with gaps.
const MAX_PASSES: usize = 512;

/// The widths of a set of pens, the finest first.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pens {
    /// Widths in pixels, ascending.
    pub widths_px: Vec<f32>,
}

impl Pens {
    /// Chooses `count` pens that match the widths of the lines best, weighted by ink (Lloyd's algorithm in one
    /// dimension). There are fewer pens if the lines have fewer widths.
    pub(crate) fn chosen<'a>(count: usize, lines: impl Iterator<Item = &'a Polyline>) -> Self {
        let mut found: Vec<(f32, f32)> =
            lines.flat_map(segments).map(|(a, b)| (mean_width(a, b), length(a, b))).collect();
        found.retain(|(width, length)| *width > 0.0 && *length > 0.0);
        // Tapered ends are long and have hardly any ink.
        found.iter_mut().for_each(|(width, weight)| *weight *= *width);
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let all: f64 = found.iter().map(|(_, weight)| f64::from(*weight)).sum();
        let at = |part: f64| {
            let mut left = part * all;
            let reached = found.iter().find(|(_, weight)| {
                left -= f64::from(*weight);
                left <= 0.0
            });
            reached.or(found.last()).map(|(width, _)| *width)
        };
        let mut widths_px: Vec<f32> = (0..count).filter_map(|i| at((i as f64 + 0.5) / count as f64)).collect();
        for _ in 0..ROUNDS {
            let mut sums = vec![[0.0_f64; 2]; widths_px.len()];
            for (width, weight) in &found {
                let own = &mut sums[nearest(&widths_px, *width)];
                own[0] += f64::from(*width) * f64::from(*weight);
                own[1] += f64::from(*weight);
            }
            for (pen, [sum, weight]) in widths_px.iter_mut().zip(sums) {
                *pen = if weight > 0.0 { (sum / weight) as f32 } else { *pen };
            }
        }
        widths_px.dedup_by(|a, b| (*a - *b).abs() < 0.02 * *b);
        Self { widths_px }
    }

    /// Returns the strokes that draw a line, each with the index of its pen.
    pub(crate) fn strokes(&self, line: &Polyline) -> Vec<(usize, Polyline)> {
        let Some(finest) = self.widths_px.first() else { return Vec::new() };
        let as_width = |at: &PolylinePoint| PolylinePoint { half_width_px: at.half_width_px * at.ink, ink: 1.0, ..*at };
        let line = Polyline { points: line.points.iter().map(as_width).collect(), ..line.clone() };
        let mut strokes = Vec::new();
        for piece in pieces(&line) {
            let width = mean_of(&piece);
            if width < FAINT_PART * finest {
                continue;
            }
            let pen = nearest(&self.widths_px, width);
            let nib = self.widths_px[pen];
            let passes =
                if width < 1.5 * nib { 1 } else { ((width - nib) / (nib * (1.0 - OVERLAP))).ceil() as usize + 1 };
            let passes = passes.min(MAX_PASSES);
            for i in 0..passes {
                let aside = if passes == 1 { 0.0 } else { (width - nib) * (i as f32 / (passes - 1) as f32 - 0.5) };
                strokes.push((pen, moved(&piece, aside, nib)));
            }
        }
        strokes
    }
}

fn nearest(widths: &[f32], width: f32) -> usize {
    // Compares widths by their ratio.
    let away = |pen: f32| (width.max(1e-6) / pen.max(1e-6)).ln().abs();
    (0..widths.len()).min_by(|a, b| away(widths[*a]).total_cmp(&away(widths[*b]))).unwrap_or(0)
}

/// Splits a line into consecutive pieces in which width and ink change little. A closed line that needs no split stays
/// closed.
pub(crate) fn pieces(line: &Polyline) -> Vec<Polyline> {
    let widest = line.points.iter().map(|at| at.half_width_px).fold(0.0, f32::max);
    let level = |at: &PolylinePoint| [at.half_width_px.max(THIN_PART * widest), at.ink.max(THIN_PART)];
    let mut points = line.points.clone();
    points.extend(line.points.first().filter(|_| line.is_closed));
    let mut cuts = vec![0];
    let (mut low, mut high) = ([f32::INFINITY; 2], [0.0_f32; 2]);
    let mut drawn = 0.0;
    for i in 0..points.len() {
        let own = level(&points[i]);
        if i > 0 {
            drawn += length(&points[i - 1], &points[i]);
        }
        for k in 0..2 {
            (low[k], high[k]) = (low[k].min(own[k]), high[k].max(own[k]));
        }
        let is_other = (0..2).any(|k| high[k] > STEP * low[k]);
        if is_other && drawn > SLENDER * 2.0 * points[i].half_width_px && i > cuts[cuts.len() - 1] {
            cuts.push(i);
            (low, high, drawn) = (own, own, 0.0);
        }
    }
    if cuts.len() == 1 {
        return vec![line.clone()];
    }
    // A short remainder is merged with the piece before it.
    if drawn < SLENDER * widest && cuts.len() > 2 {
        cuts.pop();
    }
    let last = points.len() - 1;
    if cuts[cuts.len() - 1] != last {
        cuts.push(last);
    }
    let piece = |ends: &[usize]| Polyline { points: points[ends[0]..=ends[1]].to_vec(), is_closed: false, ..*line };
    cuts.windows(2).map(piece).collect()
}

/// Returns the line moved `aside_px` to its right, with the width `width_px`.
fn moved(line: &Polyline, aside_px: f32, width_px: f32) -> Polyline {
    let count = line.points.len();
    let at = |i: usize| {
        let (before, after) = if line.is_closed {
            ((i + count - 1) % count, (i + 1) % count)
        } else {
            (i.saturating_sub(1), (i + 1).min(count - 1))
        };
        let [a, b] = [line.points[before].px, line.points[after].px];
        let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
        let length = dx.hypot(dy).max(1e-6);
        let [x, y] = line.points[i].px;
        let px = [x - dy / length * aside_px, y + dx / length * aside_px];
        PolylinePoint { px, half_width_px: 0.5 * width_px, ink: 1.0 }
    };
    Polyline { points: (0..count).map(at).collect(), ..line.clone() }
}

fn segments(line: &Polyline) -> impl Iterator<Item = (&PolylinePoint, &PolylinePoint)> {
    let around = line.is_closed.then_some(()).and(line.points.first());
    line.points.iter().zip(line.points.iter().skip(1).chain(around))
}

fn length(a: &PolylinePoint, b: &PolylinePoint) -> f32 {
    (b.px[0] - a.px[0]).hypot(b.px[1] - a.px[1])
}

fn mean_width(a: &PolylinePoint, b: &PolylinePoint) -> f32 {
    a.half_width_px * a.ink + b.half_width_px * b.ink
}

/// Returns the mean width of a line, weighted by length.
fn mean_of(line: &Polyline) -> f32 {
    let sum = segments(line).fold([0.0; 2], |[width, all], (a, b)| {
        let length = length(a, b);
        [width + length * mean_width(a, b), all + length]
    });
    if sum[1] > 0.0 { sum[0] / sum[1] } else { line.points.first().map_or(0.0, |at| mean_width(at, at)) }
}
