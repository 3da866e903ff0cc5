//! The factor by which the surface is coarser than requested because its tiles would not fit into memory.
//!
//! A view may need more tiles than there are slots. If the most urgent of them were loaded and the rest left out, tiles
//! would take each other's slots from frame to frame. Instead, the surface chooses its level as if a pixel were wider
//! by a factor. Each needed tile knows the factor from which on it is not needed ([`Needed::factor`]), so the factor
//! that makes the tiles fit is an order statistic and needs no search.
//!
//! The tiles of the near future, which are loaded in advance, count like those of this view: otherwise there would be no
//! slots for them when they are needed.
//!
//! The factor grows while more than [`FULL`] of the slots are needed, and shrinks while the next smaller factor would
//! need less than [`SPARE`] of them; in between it rests, so that it does not oscillate (after CesiumJS, whose
//! memory-adjusted screen-space error changes by 2 % a frame). It grows faster than it shrinks, and shrinks only when
//! the tiles for the smaller factor are on the GPU, so that no frame is late because of it. Only if the tiles would
//! exceed all slots does it jump.
//!
//! Why: `docs/decisions/tile-streaming.md`.

#[cfg(doc)]
use super::needed::Needed;

/// The fraction of the slots above which the factor grows.
pub(super) const FULL: f64 = 0.9;
/// The fraction of the slots below which the factor shrinks.
pub(super) const SPARE: f64 = 0.8;
/// Speed at which the factor grows, in octaves (powers of 2) per second.
const UP_OCTAVES_PER_S: f64 = 2.0;
/// Speed at which the factor shrinks, in octaves per second.
const DOWN_OCTAVES_PER_S: f64 = 0.5;
/// The largest change of the factor in a step, in octaves.
const MAX_STEP_OCTAVES: f64 = 0.25;
/// The largest factor.
const MAX_FACTOR: f64 = 1e6;

/// The factor and its law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MemoryFactor {
    value: f64,
}

impl Default for MemoryFactor {
    fn default() -> Self {
        Self { value: 1.0 }
    }
}

fn octaves(per_s: f64, step_s: f64) -> f64 {
    (per_s * step_s).clamp(0.0, MAX_STEP_OCTAVES).exp2()
}

impl MemoryFactor {
    /// Returns a factor that does not follow the law of this module, for a frame that waits for its tiles.
    pub(crate) fn fixed(value: f64) -> Self {
        Self { value }
    }

    /// Returns the factor by which pixels are wider; 1 if everything fits.
    pub(crate) fn value(&self) -> f64 {
        self.value
    }

    /// Returns the smallest factor that [`MemoryFactor::advance`] may choose; it needs all tiles that are needed at this
    /// factor. `step_s` is the time since the last step; `None` starts again.
    pub(crate) fn least(&self, step_s: Option<f64>) -> f64 {
        step_s.map_or(1.0, |step_s| (self.value / octaves(DOWN_OCTAVES_PER_S, step_s)).max(1.0))
    }

    /// Returns the factor to which it may have shrunk in `ahead_s` seconds.
    pub(crate) fn after(&self, ahead_s: f64) -> f64 {
        (self.value / (DOWN_OCTAVES_PER_S * ahead_s).exp2()).max(1.0)
    }

    /// Chooses the factor for a frame with `slots` slots. `factors` has the factors ([`Needed::factor`]) of all tiles that
    /// are needed at [`MemoryFactor::least`], now or in a moment. The factor shrinks only if `may_shrink`. Returns whether
    /// there is room for a smaller one.
    pub(crate) fn advance(
        &mut self,
        mut factors: Vec<f32>,
        slots: usize,
        step_s: Option<f64>,
        may_shrink: impl FnOnce() -> bool,
    ) -> bool {
        let count = |factors: &[f32], above: f64| factors.iter().filter(|factor| f64::from(**factor) > above).count();
        // Returns the smallest factor with which at most `most` tiles are needed.
        let mut fit = |most: usize| match factors.len() {
            all if all <= most => 1.0,
            _ => f64::from(*factors.select_nth_unstable_by(most, |a, b| b.total_cmp(a)).1).clamp(1.0, MAX_FACTOR),
        };
        let of_slots = |fraction: f64| (slots as f64 * fraction) as usize;
        let Some(step_s) = step_s else {
            self.value = fit(of_slots(FULL));
            return false;
        };
        let (fits, must) = (fit(of_slots(FULL)), fit(slots));
        let least = self.least(Some(step_s));
        if count(&factors, self.value) > of_slots(FULL) {
            let grown = self.value * octaves(UP_OCTAVES_PER_S, step_s);
            self.value = grown.min(fits).max(must).max(self.value);
            return false;
        }
        let has_room = self.value > 1.0 && count(&factors, least) <= of_slots(SPARE);
        if has_room && may_shrink() {
            self.value = least;
        }
        has_room
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pyramid::TileAddress;
    use crate::tiles::needed::Needed;

    const STEP_S: f64 = 1.0 / 30.0;

    /// Returns the tiles of a view that needs `tiles` of them at a factor of 1: half as many at twice the factor.
    fn view(tiles: f64, least: f64) -> Vec<Needed> {
        let tile = |i: usize| Needed {
            is_certain: true,
            address: TileAddress { level: 0, x: i as u32, y: 0 },
            urgency: 1.0,
            factor: (tiles / (i as f64 + 1.0)) as f32,
        };
        (0..tiles as usize).map(tile).filter(|tile| f64::from(tile.factor) > least).collect()
    }

    fn step(factor: &mut MemoryFactor, tiles: f64, slots: usize, step_s: Option<f64>) -> usize {
        let factors = view(tiles, factor.least(step_s)).iter().map(|tile| tile.factor).collect();
        factor.advance(factors, slots, step_s, || true);
        view(tiles, factor.value()).len()
    }

    #[test]
    fn a_view_that_fits_has_a_factor_of_1() {
        let mut factor = MemoryFactor::default();
        for step_s in [None, Some(STEP_S)] {
            assert_eq!(step(&mut factor, 890.0, 1000, step_s), 889);
            assert_eq!(factor.value(), 1.0);
        }
    }

    #[test]
    fn after_a_jump_the_factor_fits_at_once() {
        let mut factor = MemoryFactor { value: 50.0 };
        let taken = step(&mut factor, 10_000.0, 1000, None);
        assert!((880..=900).contains(&taken), "{taken}");
    }

    #[test]
    fn needed_tiles_never_exceed_the_slots_and_the_factor_glides() {
        let mut factor = MemoryFactor::default();
        let mut factors = vec![1.0];
        for frame in 0..900 {
            // The view needs eight times as many tiles within two seconds, rests, and needs fewer again.
            let toward = (f64::from(frame) / 60.0).min(1.0) - (f64::from(frame) / 60.0 - 8.0).clamp(0.0, 1.0);
            let taken = step(&mut factor, 600.0 * 8_f64.powf(toward), 1000, Some(STEP_S));
            assert!(taken <= 1000, "frame {frame}: {taken} tiles need 1000 slots");
            factors.push(factor.value());
        }
        let steps = factors.windows(2).map(|pair| (pair[1] / pair[0]).log2());
        assert!(steps.clone().fold(0.0, f64::max) < 0.1 && steps.fold(0.0, f64::min) > -0.02, "{factors:?}");
        assert!(factors[300] > 4.0 && factors[900] == 1.0, "{factors:?}");
        assert!(factors[300..450].windows(2).all(|pair| pair[0] == pair[1]), "at rest the factor rests");
    }

    #[test]
    fn a_law_that_counts_one_slot_too_many_is_noticed() {
        // A quick turn: the view needs eight times as many tiles from one frame to the next.
        let most = |slots: usize| {
            let mut factor = MemoryFactor::default();
            step(&mut factor, 600.0, slots, Some(STEP_S));
            step(&mut factor, 4800.0, slots, Some(STEP_S))
        };
        assert_eq!(most(1000), 1000, "the factor jumps as far as it must, and no further");
        // The planted error.
        assert!(most(1001) > 1000);
    }

    #[test]
    fn a_view_at_the_limit_does_not_oscillate() {
        // The number of tiles trembles by 4 %, around the mark above which the factor grows.
        let mut factor = MemoryFactor::default();
        let factors: Vec<f64> = (0..600)
            .map(|frame| {
                step(&mut factor, 900.0 * (1.0 + 0.04 * f64::from(frame % 2)), 1000, Some(STEP_S));
                factor.value()
            })
            .collect();
        let changes = |factors: &[f64]| factors.windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert!(changes(&factors) <= 2, "{}", changes(&factors));
        // The planted error: without the dead band it changes all the time.
        let mut naive = 1.0_f64;
        let without: Vec<f64> = (0..600)
            .map(|frame| {
                let taken = view(900.0 * (1.0 + 0.04 * f64::from(frame % 2)), naive).len();
                naive = if taken > 900 { naive * 1.02 } else { (naive / 1.02).max(1.0) };
                naive
            })
            .collect();
        assert!(changes(&without) > 100);
    }
}
