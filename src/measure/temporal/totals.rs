//! Sums over pairs of frames, for a report.

use super::{LineChange, LineMeasures, PairMeasures, Share, StrokeMeasures};
use crate::measure::report::Metrics;
use crate::measure::statistics::Percentiles;

/// Sums over the pairs of a run.
#[derive(Clone, Debug, Default)]
pub struct TemporalTotals {
    pairs: u64,
    line_pairs: u64,
    lines: LineMeasures,
    stroke_pairs: u64,
    strokes: StrokeMeasures,
    /// Lone line pixels and changed identities, for frames that move strokes and for those that rebuild them.
    kinds: [[Share; 2]; 2],
    e_warp: Share,
}

impl TemporalTotals {
    pub fn add(&mut self, pair: PairMeasures) {
        self.pairs += 1;
        self.e_warp += pair.e_warp;
        if let (Some(lines), Some(strokes)) = (&pair.lines, &pair.strokes) {
            let [lone, changed] = &mut self.kinds[usize::from(strokes.rebuilt)];
            *lone += lines.births.lone;
            *lone += lines.deaths.lone;
            *changed += strokes.identity_change.unwrap_or_default();
        }
        if let Some(lines) = pair.lines {
            self.line_pairs += 1;
            self.lines.coverage += lines.coverage;
            add_change(&mut self.lines.births, lines.births);
            add_change(&mut self.lines.deaths, lines.deaths);
        }
        if let Some(strokes) = pair.strokes {
            self.stroke_pairs += 1;
            self.strokes.born += strokes.born;
            self.strokes.died += strokes.died;
            if let Some(change) = strokes.identity_change {
                *self.strokes.identity_change.get_or_insert_default() += change;
            }
            self.strokes.slips_px.extend(strokes.slips_px);
        }
    }

    /// Returns the numbers for a report; `None` before the first pair. Values that could not be measured are null:
    ///
    /// | name | |
    /// | --- | --- |
    /// | `pairs` | number of pairs of frames |
    /// | `line_coverage` | line pixels, of all pixels |
    /// | `line_masked` | line pixels not visible in both frames, of all line pixels: they count for nothing else |
    /// | `flicker_births`, `flicker_deaths`, `flicker` | line pixels without a line in the previous frame, in the next frame, and the mean of both |
    /// | `flicker_ink_births`, `flicker_ink_deaths`, `flicker_ink` | the same, weighted by ink |
    /// | `strokes_per_frame` | strokes that can be followed |
    /// | `births_per_frame`, `deaths_per_frame` | born and died strokes |
    /// | `identity_change` | line pixels that continue only as other strokes, of those that continue |
    /// | `slip_px_p50`, `slip_px_p95` | over all line pixels that continue as the same stroke, pixels per frame |
    /// | `flicker_updates`, `flicker_between` | flicker of frames that rebuild strokes, and of those that move them |
    /// | `identity_updates`, `identity_between` | change of identity in the same two kinds of frames |
    /// | `e_warp` | mean squared difference of luma, 0 to 1 |
    pub fn metrics(&self) -> Option<Metrics> {
        if self.pairs == 0 {
            return None;
        }
        let (births, deaths) = (self.lines.births, self.lines.deaths);
        let mut masked = births.masked;
        masked += deaths.masked;
        let mean = |a: Share, b: Share| Some(0.5 * (a.value()? + b.value()?));
        let per_frame = |count: f64| (self.stroke_pairs > 0).then(|| count / self.stroke_pairs as f64);
        let [between, updates] = self.kinds.map(|kind| kind.map(Share::value));
        let slip = Percentiles::of(self.strokes.slips_px.iter().map(|slip_px| f64::from(*slip_px)));
        let metrics = [
            ("pairs", Some(self.pairs as f64)),
            ("line_coverage", self.lines.coverage.value()),
            ("line_masked", masked.value()),
            ("flicker_births", births.lone.value()),
            ("flicker_deaths", deaths.lone.value()),
            ("flicker", mean(births.lone, deaths.lone)),
            ("flicker_ink_births", births.lone_ink.value()),
            ("flicker_ink_deaths", deaths.lone_ink.value()),
            ("flicker_ink", mean(births.lone_ink, deaths.lone_ink)),
            ("strokes_per_frame", per_frame(self.strokes.born.whole)),
            ("births_per_frame", per_frame(self.strokes.born.part)),
            ("deaths_per_frame", per_frame(self.strokes.died.part)),
            ("identity_change", self.strokes.identity_change.and_then(Share::value)),
            ("slip_px_p50", slip.map(|slip| slip.p50)),
            ("slip_px_p95", slip.map(|slip| slip.p95)),
            ("flicker_updates", updates[0]),
            ("flicker_between", between[0]),
            ("identity_updates", updates[1]),
            ("identity_between", between[1]),
            ("e_warp", self.e_warp.value()),
        ];
        Some(metrics.into_iter().map(|(name, value)| (name.to_owned(), value)).collect())
    }
}

fn add_change(sum: &mut LineChange, change: LineChange) {
    sum.masked += change.masked;
    sum.lone += change.lone;
    sum.lone_ink += change.lone_ink;
}
