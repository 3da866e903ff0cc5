//! When marks begin, and how they widen while a tone darkens.
//!
//! The scale is *ink*: the total area of all marks as a fraction of the tile, as if none overlapped. With `swell` s the
//! number of marks grows as ink^(1−s) and their width as ink^s, so that both are the recipe's at mid tone: s = 0 adds
//! marks of one width, s = 1 is an engraver's plate, on which all lines exist and swell. No line is thinner than a
//! pixel, so even an engraver's lines appear one by one.
//!
//! Powers are computed from roots and products, which IEEE 754 rounds in one way on every machine; it does not for
//! `powf`.

/// Marks are added up to this ink; from there on they only widen.
const MAX_INK: f64 = 1.3;
/// The least swell, so that marks of one width still close up when nothing else is left to ink.
const MIN_SWELL: f64 = 0.125;
/// Entries of the table of widths, and entries per width.
const TABLE: usize = 4096;
const PER_WIDTH: f32 = 512.0;

/// The ink at which marks begin, and at which they have a width.
pub(super) struct Growth {
    mid_ink: f64,
    swell: f64,
    /// Number of marks at mid tone.
    mid_count: f64,
    /// Ink per mark of one pixel's width.
    thin_ink: f64,
    /// The ink at which marks have each width, in steps of 1 / `PER_WIDTH` of the width at mid tone.
    widths: Vec<f32>,
}

/// Returns `base` to an exponent that is rounded to sixteenths; `base` must not be negative.
fn power(base: f64, exponent: f64) -> f64 {
    let sixteenths = (exponent * 16.0).round() as u32;
    let mut root = base.sqrt().sqrt().sqrt().sqrt();
    let (mut left, mut product) = (sixteenths, 1.0);
    while left > 0 {
        if left & 1 == 1 {
            product *= root;
        }
        root *= root;
        left >>= 1;
    }
    product
}

impl Growth {
    /// Creates the growth of marks. `mid_ink` is the ink at mid tone, `mid_count` the number of marks there, `width_px`
    /// their width.
    pub(super) fn new(mid_ink: f32, mid_count: f32, width_px: f32, swell: f32) -> Self {
        let (mid_ink, mid_count) = (f64::from(mid_ink), f64::from(mid_count).max(1.0));
        let swell = (f64::from(swell) * 16.0).round() / 16.0;
        let widening = 1.0 / swell.max(MIN_SWELL);
        let ink = |entry: usize| (mid_ink * power(entry as f64 / f64::from(PER_WIDTH), widening)).min(1e3) as f32;
        let widths = (0..=TABLE).map(ink).collect();
        Self { mid_ink, swell, mid_count, thin_ink: mid_ink / mid_count / f64::from(width_px.max(1.0)), widths }
    }

    /// Returns the number of marks when no more are added.
    pub(super) fn count(&self) -> usize {
        let more = power((MAX_INK / self.mid_ink).max(1.0), 1.0 - self.swell);
        (self.mid_count * more).round().max(1.0) as usize
    }

    /// Returns the ink at which a mark begins, if `before` marks came before it.
    pub(super) fn begin(&self, before: usize) -> f32 {
        let number = before as f64 + 0.5;
        let part = number / self.mid_count;
        // With a swell of 1 all marks exist from the beginning, as far as the least width of a pixel allows.
        let swelling = if self.swell > 0.9 { 0.0 } else { self.mid_ink * power(part, 1.0 / (1.0 - self.swell)) };
        swelling.max(number * self.thin_ink) as f32
    }

    /// Returns the ink at which a mark is `widths` times as wide as at mid tone.
    pub(super) fn widened(&self, widths: f32) -> f32 {
        let at = widths * PER_WIDTH;
        let entry = at as usize;
        if entry >= TABLE {
            // Beyond the table the ink still rises, so that dark tones close up outward from the marks.
            return self.widths[TABLE] * (at / TABLE as f32);
        }
        let [low, high] = [self.widths[entry], self.widths[entry + 1]];
        low + (high - low) * (at - entry as f32)
    }

    /// Returns how many times as wide as at mid tone marks are at `ink`.
    pub(super) fn width_at(&self, ink: f32) -> f32 {
        // The table rises, so its first entry beyond `ink` is the answer.
        self.widths.partition_point(|at| *at < ink) as f32 / PER_WIDTH
    }
}
