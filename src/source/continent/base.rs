//! The base of the continent, at a spacing of 2.56 km: where ranges rise, and the rivers that cut them.
//!
//! The only length scale of the stream power law is that of its hillslopes ([`erosion`]), so the continent is grown as
//! a model 16 times smaller, with a sample spacing of 160 m, and its heights are scaled afterwards. Uplift follows the
//! crests of a warped, ridged noise, thinned by a second one: chains that branch and end, with plains between them.

use noise::{Fbm, MultiFractal, NoiseFn, Perlin};

use super::super::Progress;
use super::super::erosion;
use super::super::raster::{Raster, is_border};
use super::super::relief::hash;

/// Distance between the samples of the model, in the model's own metres.
const MODEL_SPACING_M: f64 = 160.0;

/// Steps of river incision on each grid, coarsest first. Each grid has twice the resolution of the one before.
const STEPS: [usize; 3] = [70, 24, 9];

/// Uplift at strength 1, in metres per duration of 1.
const UPLIFT_M: f32 = 520.0;

/// Height of the highest ground of the base in metres, before valleys are deepened and the relief of the pieces is
/// added.
const HIGHEST_M: f32 = 3_900.0;

/// Height of the lowest ground of the base in metres.
const LOWEST_M: f32 = 40.0;

struct Relief {
    warp: [Fbm<Perlin>; 2],
    chains: Perlin,
    share: Fbm<Perlin>,
    massifs: Fbm<Perlin>,
    hills: Fbm<Perlin>,
    rock: Fbm<Perlin>,
    rough: Perlin,
}

impl Relief {
    fn new(seed: u32) -> Self {
        let stream = |n: u32| hash(seed.wrapping_mul(0x9E37_79B9) ^ hash(100 + n));
        Self {
            warp: [Fbm::new(stream(1)).set_octaves(5), Fbm::new(stream(2)).set_octaves(5)],
            chains: Perlin::new(stream(3)),
            share: Fbm::new(stream(4)).set_octaves(3),
            massifs: Fbm::new(stream(5)).set_octaves(4),
            hills: Fbm::new(stream(6)).set_octaves(4),
            rock: Fbm::new(stream(7)).set_octaves(4),
            rough: Perlin::new(stream(8)),
        }
    }

    /// Returns how fast the land rises, 0 to about 1; `x` and `y` run from −1 to 1 over the continent.
    fn uplift(&self, x: f64, y: f64) -> f32 {
        let at = [1.6 * x, 1.6 * y];
        let (u, v) = (x + 0.3 * self.warp[0].get(at), y + 0.3 * self.warp[1].get(at));
        // A chain is where the noise crosses zero; one passes through the middle.
        let middle = self.chains.get([0.31, 0.17]);
        let crossing = self.chains.get([1.5 * u + 0.31, 1.5 * v + 0.17]) - middle;
        let second = self.chains.get([2.6 * u + 7.9, 2.6 * v - 3.1]);
        let massifs = (0.62 + 0.9 * self.massifs.get([11.0 * u, 11.0 * v])).max(0.1);
        let share = (0.62 + 1.5 * self.share.get([1.7 * x, 1.7 * y])).clamp(0.0, 1.0);
        let share = share.max((-(x * x + y * y) * 12.0).exp());
        let chain = (-(crossing / 0.15).powi(2)).exp() * massifs * share;
        let low = 0.55 * (-(second / 0.12).powi(2)).exp() * massifs * (1.0 - 0.8 * share);
        let hills = 0.035 * (0.5 + 1.6 * self.hills.get([5.0 * x, 5.0 * y])).max(0.1);
        (chain.max(low) + hills) as f32
    }

    fn hardness(&self, x: f64, y: f64) -> f32 {
        (0.5 * self.rock.get([14.0 * x, 14.0 * y])).exp() as f32
    }
}

/// Returns `size`² heights in metres.
pub(super) fn grow(seed: u32, size: usize, progress: &dyn Progress) -> Vec<f32> {
    let relief = Relief::new(seed);
    let total: usize = STEPS.iter().enumerate().map(|(k, steps)| steps << (2 * k)).sum();
    let mut done = 0;
    let mut land: Option<Raster> = None;
    for (k, steps) in STEPS.into_iter().enumerate() {
        let halvings = STEPS.len() - 1 - k;
        let (level_size, spacing_m) = (size >> halvings, MODEL_SPACING_M * f64::from(1u32 << halvings));
        let half_m = 0.5 * size as f64 * MODEL_SPACING_M;
        let unit = |x_m: f64, y_m: f64| (x_m / half_m, y_m / half_m);
        let field = |of: &(dyn Fn(f64, f64) -> f32 + Sync)| {
            Raster::from_fn(level_size, spacing_m, |x_m, y_m| {
                let (x, y) = unit(x_m, y_m);
                of(x, y)
            })
        };
        let uplift = field(&|x, y| relief.uplift(x, y));
        let uplift_m: Vec<f32> = uplift.values.iter().map(|strength| strength * UPLIFT_M).collect();
        let hardness = field(&|x, y| relief.hardness(x, y)).values;
        let mut heights = match &land {
            None => {
                field(&|x, y| 80.0 + 300.0 * relief.uplift(x, y) + 45.0 * relief.hills.get([25.0 * x, 25.0 * y]) as f32)
            }
            Some(coarse) => Raster::from_fn(level_size, spacing_m, |x_m, y_m| {
                let shift = |stream: f64| {
                    let at = [x_m / (5.3 * spacing_m) + stream, y_m / (5.3 * spacing_m) - stream];
                    1.3 * spacing_m * relief.rough.get(at)
                };
                let rough = relief.rough.get([x_m / (2.3 * spacing_m) + 50.5, y_m / (2.3 * spacing_m)]) as f32;
                coarse.sample_cubic(x_m + shift(3.7), y_m + shift(13.1), 0.5) + 0.1 * spacing_m as f32 * rough
            }),
        };
        for (index, height_m) in heights.values.iter_mut().enumerate() {
            if is_border(index, level_size) {
                *height_m = 0.0;
            }
        }
        for _ in 0..steps {
            let flow = erosion::route(&mut heights);
            let areas_m2 = erosion::upstream_areas(&heights, &flow, None);
            erosion::incise(&mut heights, &flow, &areas_m2, &uplift_m, &hardness, 0.14);
            done += 1 << (2 * k);
            progress.report("rivers of the continent", done as f32 / total as f32);
        }
        land = Some(heights);
    }
    let Some(mut land) = land else { return vec![LOWEST_M; size * size] };
    erosion::flood(&mut land);
    let highest = land.values.iter().copied().fold(1.0, f32::max);
    land.values.iter().map(|height| LOWEST_M + height * (HIGHEST_M - LOWEST_M) / highest).collect()
}
