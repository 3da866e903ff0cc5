//! The budget of mesh patches of a frame, and the factor that makes a frame coarser when it would exceed it.
//!
//! Land of ordinary relief needs a number of patches that follows the picture. But relief may be extraordinary: a
//! checkerboard of heights, an allowed error of a billionth of a pixel, spikes everywhere. So a frame has a budget. If
//! it is exceeded, the allowed error of the whole frame is multiplied by the smallest factor with which the selection
//! fits. Patches morph with the allowed error, so a factor that changes continuously moves the surface continuously.
//!
//! For a frame that waits for its tiles, the factor is found by bisection: the same picture has the same factor,
//! whatever was drawn before. In a flight the factor continues from the frame before and changes at a bounded rate,
//! upward when a selection is over the budget, downward when a finer one would be well under it. A selection may be
//! over by a quarter while the factor is changing; beyond that, the factor jumps.

/// Pixels of the picture per patch of 512 triangles, at an allowed error of one pixel. The Alps, seen from a summit,
/// need a quarter of these patches.
const PX_PER_PATCH: f64 = 32.0;
/// Samples of the land per patch, likewise: patches of the finest data have 256. A small land seen from nearby needs
/// finer ones, and this number suffices for all but a few views of it.
const SAMPLES_PER_PATCH: f64 = 16.0;
/// The smallest budget, for a small picture or a small land.
const MIN_PATCHES: f64 = 1024.0;
/// A smaller allowed error raises the budget by its inverse, up to this factor.
const MAX_FACTOR: f64 = 4.0;
/// Bytes per patch: its vertices, and the data of its selection.
const PATCH_BYTES: u64 = 8192;
/// Speed of the factor, in octaves (powers of 2) per second.
const OCTAVES_PER_S: f64 = 2.0;
/// The smallest and largest change of the factor in a frame, in octaves.
const STEP_OCTAVES: [f64; 2] = [1.0 / 64.0, 0.25];
/// A finer selection is taken when it needs at most this fraction of the budget; less than 1, so that the factor comes
/// to rest.
const WELL_UNDER: f64 = 0.9;
/// The exponent of 2 from which on a factor is infinite, so that no patch is split: not even one whose error is infinite
/// because its tile is missing. Only then may the number of patches be unlimited.
const INFINITE_OCTAVES: f64 = 1024.0;
/// The fraction of the budget that a selection may use while the factor is changing.
const ON_THE_WAY: f64 = 1.25;
/// Precision of the factor of a frame that waits for its tiles, in octaves.
const EXACT_OCTAVES: f64 = 1.0 / 64.0;

/// Returns the budget of patches for a picture of `pixels` pixels of a land of `samples` samples, with an allowed error
/// of `error_px` pixels and `tile_memory_bytes` bytes of memory for tiles.
pub fn max_patches(pixels: f64, samples: f64, error_px: f64, tile_memory_bytes: u64) -> usize {
    let ordinary = (pixels / PX_PER_PATCH).min(samples / SAMPLES_PER_PATCH).max(MIN_PATCHES);
    let room = (tile_memory_bytes / PATCH_BYTES) as f64;
    (ordinary * (1.0 / error_px).clamp(1.0, MAX_FACTOR)).min(room.max(MIN_PATCHES)) as usize
}

/// The method by which the factor is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Search {
    /// Finds any factor within an octave of the smallest that fits.
    Roughly,
    /// Finds the smallest factor that fits, to a 64th of an octave.
    Exactly,
    /// Continues from the factor of the frame before.
    GoOn {
        /// Time between the two frames, in seconds.
        step_s: f64,
    },
}

/// The limits of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Budget {
    /// The largest number of patches.
    most: usize,
    /// The smallest factor.
    least: f64,
}

impl Budget {
    /// Creates a budget of `most` patches, with a factor of at least `least`.
    pub(crate) fn new(most: usize, least: f64) -> Self {
        Self { most, least: least.max(1.0) }
    }

    /// Finds the factor for a frame after one with the factor `before`. Returns the selection of `choose` with it, and
    /// the factor. `choose` tries a factor with a number of patches, and returns `None` if they do not suffice. If no
    /// factor is large enough, because a view has more patches of the coarsest level, the number is not limited.
    pub(crate) fn find<T>(
        &self,
        search: Search,
        before: f64,
        mut choose: impl FnMut(f64, usize) -> Option<T>,
    ) -> (T, f64) {
        let mut tries = vec![(self.least, self.most)];
        if let Search::GoOn { step_s } = search {
            let octaves = (OCTAVES_PER_S * step_s).clamp(STEP_OCTAVES[0], STEP_OCTAVES[1]).exp2();
            let before = before.max(self.least);
            let part = |of: f64| (self.most as f64 * of) as usize;
            tries = match before / octaves > self.least {
                true => vec![(before / octaves, part(WELL_UNDER)), (before, self.most)],
                false => tries,
            };
            tries.push((before * octaves, part(ON_THE_WAY)));
        }
        let mut from = self.least;
        for (factor, most) in tries {
            if let Some(chosen) = choose(factor, most) {
                return (chosen, factor);
            }
            from = factor;
        }
        let within = if search == Search::Roughly { 1.0 } else { EXACT_OCTAVES };
        // Octaves above `from`: `low` is too few, `high` is enough.
        let (mut low, mut high) = (0.0_f64, 1.0_f64);
        let mut most = self.most;
        let mut chosen = loop {
            if let Some(chosen) = choose(from * high.exp2(), most) {
                break chosen;
            }
            (low, high) = (high, 2.0 * high);
            if high > INFINITE_OCTAVES {
                most = usize::MAX;
            }
        };
        while high - low > within {
            let middle = 0.5 * (low + high);
            match choose(from * middle.exp2(), most) {
                Some(finer) => (chosen, high) = (finer, middle),
                None => low = middle,
            }
        }
        (chosen, from * high.exp2())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a land that needs `patches` patches at a factor of 1, and fewer as the factor grows.
    fn land(patches: f64) -> impl Fn(f64, usize) -> Option<usize> {
        move |factor, most| Some(((patches / factor) as usize).saturating_add(1)).filter(|taken| *taken <= most)
    }

    #[test]
    fn a_picture_gets_the_least_factor_that_fits() {
        let budget = Budget::new(1000, 1.0);
        assert_eq!(budget.find(Search::Exactly, 9.0, land(900.0)), (901, 1.0));
        for patches in [1.1e3, 5e3, 1e6, 1e30] {
            let (taken, factor) = budget.find(Search::Exactly, 9.0, land(patches));
            assert!(taken <= 1000 && taken > 970, "{patches}: {taken}");
            assert!((factor / (patches / 1000.0) - 1.0).abs() < 0.03, "{patches}: {factor}");
            let (taken, _) = budget.find(Search::Roughly, 9.0, land(patches));
            assert!(taken <= 1000 && taken > 480, "{patches}: {taken}");
        }
        assert_eq!(Budget::new(1000, 7.0).find(Search::Exactly, 1.0, land(900.0)).1, 7.0);
    }

    #[test]
    fn a_view_of_more_coarse_patches_than_allowed_is_drawn_with_all_of_them() {
        let never_fewer = |factor: f64, most: usize| land(5e6)(factor.min(1e3), most);
        let (taken, _) = Budget::new(1000, 1.0).find(Search::Exactly, 1.0, never_fewer);
        assert_eq!(taken, 5001);
        // Patches of missing tiles have an infinite error, and are split unless the allowed error is infinite, too. They
        // must never be split without a limit.
        let missing = |factor: f64, most: usize| {
            assert!(most < usize::MAX || factor.is_infinite(), "split without a limit");
            factor.is_infinite().then_some(7)
        };
        for search in [Search::Exactly, Search::Roughly, Search::GoOn { step_s: 0.03 }] {
            assert_eq!(Budget::new(1000, 1.0).find(search, 1.0, missing).0, 7);
        }
    }

    #[test]
    fn in_a_flight_the_factor_glides_and_rests() {
        let budget = Budget::new(1000, 1.0);
        let search = Search::GoOn { step_s: 1.0 / 30.0 };
        let mut factor = 1.0;
        let mut factors = vec![factor];
        // The camera approaches steep land within four seconds, rests, and leaves it.
        for frame in 0..360 {
            let toward = (f64::from(frame) / 120.0).min(1.0) - (f64::from(frame) / 60.0 - 4.0).clamp(0.0, 1.0);
            let (taken, next) = budget.find(search, factor, land(500.0 * 16_f64.powf(toward)));
            assert!(taken <= 1250, "frame {frame}: {taken}");
            factor = next;
            factors.push(factor);
        }
        let steps = factors.windows(2).map(|pair| (pair[1] / pair[0]).log2().abs());
        assert!(steps.fold(0.0, f64::max) <= OCTAVES_PER_S / 30.0 + 1e-9);
        assert!(factors.iter().any(|factor| *factor > 6.0) && factors[360] == 1.0, "{factors:?}");
        // While the camera rests, so does the factor.
        assert!(factors[180..220].windows(2).all(|pair| pair[0] == pair[1]));
        // A jump to steep land is bounded at once.
        let (taken, _) = budget.find(search, 1.0, land(1e9));
        assert!(taken <= 1000);
        // The planted error: without a budget the number of patches is unbounded.
        assert!(Budget::new(usize::MAX, 1.0).find(search, 1.0, land(1e9)).0 > 1000);
    }

    #[test]
    fn the_budget_follows_the_picture_and_the_memory() {
        let (small, large, land, memory) = (64.0 * 36.0, 1280.0 * 720.0, 3601.0 * 3601.0, 512 << 20);
        assert_eq!(max_patches(small, land, 1.0, memory), 1024);
        assert_eq!(max_patches(large, land, 1.0, memory), 28_800);
        assert_eq!(max_patches(large, 300.0 * 300.0, 1.0, memory), 5_625);
        assert_eq!(max_patches(large, 20.0 * 20.0, 4.0, memory), 1024);
        assert_eq!(max_patches(large, land, 1.0, 80 << 20), 10_240);
        assert_eq!(max_patches(large, land, 1.0, 1 << 20), 1024);
        // A smaller allowed error gets more patches, within bounds.
        assert_eq!(max_patches(small, land, 0.5, memory), 2048);
        assert_eq!(max_patches(small, land, 1e-9, memory), 4096);
        assert_eq!(max_patches(f64::INFINITY, f64::INFINITY, 1e-9, memory), 65_536);
    }
}
