//! Estimated statistics of a tile without measured errors: of a COG without a sidecar, of computed land, or of several
//! DEMs as one.
//!
//! A tile does not show the detail that it has lost, but it shows the detail that its parent would lose. Average its
//! samples two by two, and interpolate the averages by the bicubic surface: the largest distance r of the samples from
//! that surface is the loss of the next step. Land is self-affine over many scales (Mandelbrot 1982; Huang and
//! Turcotte, "Fractal mapping of digitized images", J. Geophys. Res. 94, 1989): from level to level losses shrink by
//! 2^−H, and with the H = ½ of rough land their squares halve. The largest losses of several steps rarely coincide, so
//! squares add, from level L down to level 0:
//!
//! ```text
//! error = K · r · √(½ + ¼ + … + 2^−L) = K · r · √(1 − 2^−L)
//! ```
//!
//! K is above 1, because the largest of 4^L times as many samples is wanted. It is fitted to what a bake measures of
//! four one-degree SRTM tiles with no-data areas, a 25 m DEM and the procedural world (78 tiles, 13,000 patches above
//! level 0): the estimate is not below the measured error for 96 % of tiles (the worst has 0.7 of it) and 98 % of
//! patches; at the median it is 1.9 times the error of a tile and 1.9 times that of a patch. `src/tests/derive.rs`
//! asserts this. Most underestimates are next to no-data; the largest overestimates (3.5 times) are in the procedural
//! world, whose finest level is smooth.
//!
//! A mesh patch of stride 2^L is compared with the bicubic surface of its own tile, as `bake::mesh_error` does for
//! stride 1, and gets its share of the tile's estimate by its own r. At level 0, where nothing is lost, everything
//! equals what a bake measures.
//!
//! Why: `docs/decisions/estimated-errors.md`.

use crate::pyramid::surface::cell_errors::{ROW_CELLS, ROW_SAMPLES, Steps, row_errors_m};
use crate::pyramid::surface::field::{Field, Fields};
use crate::pyramid::surface::fill::read_filled;
use crate::pyramid::surface::levels::{LevelSize, coordinate};
use crate::pyramid::surface::loaded_tile::LoadedTile;
use crate::pyramid::surface::statistics::{
    PAGE_PATCHES, PatchPage, PatchStatistics, Range, TileStatistics, patch_counts, patch_levels,
};
use crate::pyramid::tile::{PATCH_QUADS, TILE_BORDER, TILE_SAMPLES, TILE_STRIDE, Tile, TileAddress, is_void};

/// The factor K for tiles.
const TILE_FACTOR: f64 = 2.4;

/// K of mesh patches: they are smaller than a tile, but their vertices are single heights and not averages.
const PATCH_FACTOR: f64 = 1.8;

/// The smallest loss of a patch, as a fraction of the tile's largest step loss.
const PATCH_FLOOR: f64 = 0.1;

/// Returns the tile with statistics estimated from its samples.
///
/// `levels` are the sizes of the whole pyramid, finest first. Errors are estimates in metres, 0 at level 0; the ranges
/// of coarser levels are wider than the samples by the estimated error, because children exceed them. The estimate of a
/// parent may be smaller than those of its children.
///
/// # Panics
/// If the tile does not exist, or does not have 260 × 260 samples.
pub fn derive(levels: &[LevelSize], address: TileAddress, tile: Tile) -> LoadedTile {
    let size = levels[address.level as usize];
    assert_eq!(tile.samples.len(), (TILE_STRIDE * TILE_STRIDE) as usize);
    let losses = if address.level == 0 { StepLosses::NONE } else { StepLosses::of(&tile, size, address) };
    let error_m = (losses.tile_m * factor(TILE_FACTOR, address.level)) as f32;
    let first = |index: u32| if index == 0 { TILE_BORDER } else { TILE_BORDER - 1 };
    let end = |index: u32, count: u32| TILE_BORDER + (count - index * TILE_SAMPLES).min(TILE_SAMPLES + 1);
    let area = Area {
        left: first(address.x),
        top: first(address.y),
        right: end(address.x, size.width),
        bottom: end(address.y, size.height),
    };
    let range = area.range(&tile);
    let statistics = TileStatistics {
        min_m: range.min_m - error_m,
        max_m: range.max_m + error_m,
        error_m,
        corner_errors_m: [error_m; 4],
        voids: range.voids(),
    };
    let patches = page(levels, address, &tile, &losses);
    LoadedTile::new(tile, statistics, patches)
}

/// Returns the combined loss of the steps from `level` to level 0, for a loss of 1 in the step above.
fn factor(k: f64, level: u32) -> f64 {
    k * (1.0 - (-f64::from(level)).exp2()).sqrt()
}

/// A rectangle of a tile's samples, counted from the first border sample; the ends are exclusive.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Area {
    left: u32,
    top: u32,
    right: u32,
    bottom: u32,
}

impl Area {
    fn range(self, tile: &Tile) -> Range {
        let mut range = Range::EMPTY;
        for row in self.top..self.bottom {
            range.add(
                &tile.samples[(row * TILE_STRIDE + self.left) as usize..(row * TILE_STRIDE + self.right) as usize],
            );
        }
        range
    }
}

/// The loss of the step to the next coarser level, in metres.
struct StepLosses {
    tile_m: f64,
    /// The loss in blocks of 16 × 16 of the tile's own samples, row-major.
    blocks_m: Vec<f32>,
}

/// Number of averages in a row of a tile with its borders.
const HALF: usize = TILE_STRIDE as usize / 2;

impl StepLosses {
    const NONE: Self = Self { tile_m: 0.0, blocks_m: Vec::new() };

    fn of(tile: &Tile, size: LevelSize, address: TileAddress) -> Self {
        let stride = TILE_STRIDE as usize;
        let origin = tile.samples[0];
        let averages = averages(tile, origin);
        let mut wide = vec![0.0_f32; HALF * stride];
        for (wide, averages) in wide.chunks_exact_mut(stride).zip(averages.chunks_exact(HALF)) {
            for (column, wide) in wide.iter_mut().enumerate() {
                let (four, weights) = phase(column);
                *wide = four.iter().zip(weights).map(|(&c, weight)| averages[c] * weight).sum();
            }
        }
        let own = |index: u32, count: u32| (count - index * TILE_SAMPLES).min(TILE_SAMPLES) as usize;
        let (columns, rows) = (own(address.x, size.width), own(address.y, size.height));
        let mut blocks_m = vec![0.0_f32; (PAGE_PATCHES * PAGE_PATCHES) as usize];
        let border = TILE_BORDER as usize;
        for row in 0..rows {
            let (four, weights) = phase(row + border);
            let [a, b, c, d] = four.map(|r| &wide[r * stride + border..r * stride + border + columns]);
            let start = (row + border) * stride + border;
            let samples = &tile.samples[start..start + columns];
            let blocks = &mut blocks_m[row / PATCH_QUADS as usize * PAGE_PATCHES as usize..];
            for column in 0..columns {
                let surface =
                    weights[0] * a[column] + weights[1] * b[column] + weights[2] * c[column] + weights[3] * d[column];
                let loss_m = (samples[column] - origin - surface).abs();
                let worst = &mut blocks[column / PATCH_QUADS as usize];
                if loss_m > *worst && !is_void(samples[column]) {
                    *worst = loss_m;
                }
            }
        }
        let tile_m = blocks_m.iter().copied().fold(0.0, f32::max).into();
        Self { tile_m, blocks_m }
    }

    /// Returns the loss in the patch at (`x`, `y`).
    fn patch_m(&self, x: u32, y: u32) -> f64 {
        if self.blocks_m.is_empty() {
            return 0.0;
        }
        f64::from(self.blocks_m[(y * PAGE_PATCHES + x) as usize]).max(PATCH_FLOOR * self.tile_m)
    }
}

/// Averages the tile's samples two by two, in metres relative to `origin_m`, as the next level would serve them:
/// no-data carries no weight, and an average is no-data where most of its samples are.
fn averages(tile: &Tile, origin_m: f32) -> Vec<f32> {
    let stride = TILE_STRIDE as usize;
    let mut averages_m = Vec::with_capacity(HALF * HALF);
    let mut voids = false;
    for rows in tile.samples.chunks_exact(2 * stride) {
        let (upper, lower) = rows.split_at(stride);
        for (upper, lower) in upper.chunks_exact(2).zip(lower.chunks_exact(2)) {
            // Differences from one sample, so that f32 is precise enough.
            let four = [upper[0], upper[1], lower[0], lower[1]];
            if four.iter().any(|&sample| is_void(sample)) {
                voids = true;
                let (mut sum_m, mut count) = (0.0, 0.0);
                for sample in four.into_iter().filter(|&sample| !is_void(sample)) {
                    sum_m += sample - origin_m;
                    count += 1.0;
                }
                averages_m.push(if count >= 2.0 { sum_m / count } else { f32::NAN });
            } else {
                averages_m.push(0.25 * four.iter().map(|sample| sample - origin_m).sum::<f32>());
            }
        }
    }
    if !voids {
        return averages_m;
    }
    let sizes = [LevelSize { width: HALF as u32, height: HALF as u32 }];
    let lowest_m = averages_m.iter().copied().fold(f32::NAN, f32::min);
    let field = Field { region: sizes[0].region(), heights_m: averages_m };
    let levels = Fields { sizes: &sizes, fields: &[&field] };
    // Reading levels in memory never fails.
    read_filled(&levels, 0, sizes[0].region(), lowest_m).unwrap_or_default()
}

/// Returns the averages on which a sample of the tile depends along an axis, and their weights: the sample is a quarter
/// of an average's width before or after its own average.
fn phase(sample: usize) -> ([usize; 4], [f32; 4]) {
    const BEFORE: [f32; 4] = [-0.023_437_5, 0.226_562_5, 0.867_187_5, -0.070_312_5];
    let own = sample / 2;
    let at = |offset: usize| (own + offset).saturating_sub(2).min(HALF - 1);
    match sample % 2 {
        0 => ([at(0), at(1), at(2), at(3)], BEFORE),
        _ => ([at(1), at(2), at(3), at(4)], [BEFORE[3], BEFORE[2], BEFORE[1], BEFORE[0]]),
    }
}

/// Returns the patches of stride 2^level over the tile.
fn page(levels: &[LevelSize], address: TileAddress, tile: &Tile, losses: &StepLosses) -> PatchPage {
    let (finest, size) = (levels[0], levels[address.level as usize]);
    let (count_x, count_y) = patch_counts(finest, address.level);
    let columns = spans(address.level, address.x, count_x, finest.width, size.width);
    let rows = spans(address.level, address.y, count_y, finest.height, size.height);
    let cells = cell_errors_m(tile, size, address);
    let share = factor(PATCH_FACTOR, address.level);
    let mut patches = Vec::with_capacity((PAGE_PATCHES * PAGE_PATCHES) as usize);
    for (y, row) in rows.iter().enumerate() {
        for (x, column) in columns.iter().enumerate() {
            let (Some((left, right)), Some((top, bottom))) = (*column, *row) else {
                patches.push(PatchPage::NOTHING);
                continue;
            };
            let range = Area { left, top, right: right + 1, bottom: bottom + 1 }.range(tile);
            let mut mesh_m = 0.0_f32;
            for row in top..bottom {
                let cells = &cells[(row * TILE_STRIDE + left) as usize..(row * TILE_STRIDE + right) as usize];
                mesh_m = cells.iter().copied().fold(mesh_m, f32::max);
            }
            let lost_m = (losses.patch_m(x as u32, y as u32) * share) as f32;
            patches.push(PatchStatistics {
                min_m: range.min_m - lost_m,
                max_m: range.max_m + lost_m,
                mesh_error_m: mesh_m + lost_m,
                voids: range.voids(),
            });
        }
    }
    PatchPage::new(patches)
}

/// For the page's patches along an axis, returns the tile's samples (counted from the first border sample) at or
/// outside their two ends; `None` for patches beyond the grid.
fn spans(level: u32, tile: u32, patches: u32, finest: u32, samples: u32) -> Vec<Option<(u32, u32)>> {
    let begins = u64::from(tile) * u64::from(TILE_SAMPLES);
    (0..PAGE_PATCHES)
        .map(|patch| {
            let patch = tile * PAGE_PATCHES + patch;
            if patch >= patches {
                return None;
            }
            // The position of a vertex among the level's samples, counted from the tile's first border sample.
            let place = |patch: u32| {
                let vertex = ((u64::from(patch) * u64::from(PATCH_QUADS)) << level).min(u64::from(finest) - 1);
                coordinate(vertex as f64, finest, samples) - begins as f64 + f64::from(TILE_BORDER)
            };
            let last = (u64::from(samples) - 1 - begins) as f64 + f64::from(TILE_BORDER);
            let last = last.min(f64::from(TILE_STRIDE - 2));
            let first = place(patch).floor().clamp(1.0, last - 1.0);
            let end = place(patch + 1).ceil().clamp(first + 1.0, last.max(first + 1.0));
            Some((first as u32, end as u32))
        })
        .collect()
}

/// Returns, for every cell of the tile, at the index of its first sample, the distance of its two triangles from the
/// surface.
fn cell_errors_m(tile: &Tile, size: LevelSize, address: TileAddress) -> Vec<f32> {
    let steps = if address.level == 0 { Steps::new() } else { Steps::few() };
    let stride = TILE_STRIDE as usize;
    let end = |index: u32, count: u32| (count - index * TILE_SAMPLES + TILE_BORDER).min(TILE_STRIDE - 1);
    let (right, bottom) = (end(address.x, size.width) as usize, end(address.y, size.height) as usize);
    let mut errors_m = vec![0.0; stride * stride];
    // In runs aligned with the patches of level 0; the first run covers the samples before them.
    let firsts = [1].into_iter().chain((TILE_BORDER as usize..stride - ROW_CELLS - 1).step_by(ROW_CELLS));
    for first in firsts.filter(|first| *first < right) {
        for row in 1..bottom.min(stride - 2) {
            let four = [row - 1, row, row + 1, row + 2].map(|row| {
                let samples = &tile.samples[row * stride + first - 1..][..ROW_SAMPLES];
                <&[f32; ROW_SAMPLES]>::try_from(samples).expect("it was cut to that length")
            });
            let errors = &mut errors_m[row * stride + first..][..ROW_CELLS];
            errors.copy_from_slice(&row_errors_m(four, &steps));
            for (i, error_m) in errors.iter_mut().enumerate() {
                let corners = [four[1][i + 1], four[1][i + 2], four[2][i + 1], four[2][i + 2]];
                if first + i >= right || corners.into_iter().any(is_void) {
                    *error_m = 0.0;
                }
            }
        }
    }
    errors_m
}

/// Measures the patches whose stride is larger than that of the coarsest level against its only tile; see
/// [`TileStore::coarse_patches`]. The distance of their triangles from the tile's samples is added to the estimated
/// loss of these samples.
///
/// [`TileStore::coarse_patches`]: super::TileStore::coarse_patches
pub(crate) fn coarse_patches(levels: &[LevelSize], top: &LoadedTile) -> Vec<Vec<PatchStatistics>> {
    let (Some(&finest), Some(&size)) = (levels.first(), levels.last()) else { return Vec::new() };
    let first = levels.len() as u32;
    let (below_x, below_y) = patch_counts(finest, first - 1);
    let mut children: Vec<PatchStatistics> =
        (0..below_x * below_y).map(|i| *top.patches.get(i % below_x, i / below_x)).collect();
    let mut child_count = (below_x, below_y);
    let lost_m = children.iter().map(|patch| patch.mesh_error_m).fold(top.statistics.error_m, f32::max);
    let mut all = Vec::new();
    for j in first..patch_levels(finest) {
        let count = patch_counts(finest, j);
        let mut errors_m = vec![0.0; (count.0 * count.1) as usize];
        for (i, error_m) in errors_m.iter_mut().enumerate() {
            let place = (i as u32 % count.0, i as u32 / count.0);
            *error_m = wide_error_m(&top.tile, finest, size, j, place) + lost_m;
        }
        let child_errors_m: Vec<f32> = children.iter().map(|child| child.mesh_error_m).collect();
        for (i, child_m) in (0..).zip(child_errors_m) {
            let (x, y) = (i % child_count.0 / 2, i / child_count.0 / 2);
            let parent_m = &mut errors_m[(y * count.0 + x) as usize];
            *parent_m = parent_m.max(child_m);
        }
        let mut patches: Vec<PatchStatistics> = Vec::with_capacity(errors_m.len());
        for (i, mesh_error_m) in errors_m.into_iter().enumerate() {
            let (x, y) = (i as u32 % count.0, i as u32 / count.0);
            let under = (0..4).map(|k| (2 * x + k % 2, 2 * y + k / 2));
            let under = under.filter(|&(x, y)| x < child_count.0 && y < child_count.1);
            let union = under.map(|(x, y)| children[(y * child_count.0 + x) as usize]).reduce(|a, b| PatchStatistics {
                min_m: a.min_m.min(b.min_m),
                max_m: a.max_m.max(b.max_m),
                voids: a.voids.union(b.voids),
                mesh_error_m,
            });
            patches.push(PatchStatistics { mesh_error_m, ..union.unwrap_or(PatchPage::NOTHING) });
        }
        all.push(patches.clone());
        (children, child_count) = (patches, count);
    }
    all
}

/// Returns the largest distance in metres of the coarsest level's samples from the triangles of a patch of stride
/// 2^`j`.
fn wide_error_m(top: &Tile, finest: LevelSize, size: LevelSize, j: u32, (x, y): (u32, u32)) -> f32 {
    let at = |column: u32, row: u32| {
        let place = (row.min(size.height - 1) + TILE_BORDER) * TILE_STRIDE + column.min(size.width - 1) + TILE_BORDER;
        top.samples[place as usize]
    };
    let vertex = |quad: u64, finest: u32, samples: u32| {
        coordinate((quad << j).min(u64::from(finest) - 1) as f64, finest, samples).max(0.0)
    };
    let height_m = |x: f64, y: f64| {
        let (column, row, u, v) = (x as u32, y as u32, x.fract(), y.fract());
        let across = |row: u32| f64::from(at(column, row)) * (1.0 - u) + f64::from(at(column + 1, row)) * u;
        across(row) * (1.0 - v) + across(row + 1) * v
    };
    let quads = u64::from(PATCH_QUADS);
    let mut worst = 0.0_f64;
    for quad in 0..quads * quads {
        let (quad_x, quad_y) = (u64::from(x) * quads + quad % quads, u64::from(y) * quads + quad / quads);
        let [left, right] = [quad_x, quad_x + 1].map(|quad| vertex(quad, finest.width, size.width));
        let [above, below] = [quad_y, quad_y + 1].map(|quad| vertex(quad, finest.height, size.height));
        if right <= left || below <= above {
            continue;
        }
        let (first, opposite) = (height_m(left, above), height_m(right, below));
        let (right_above, down) = (height_m(right, above), height_m(left, below));
        for row in above.ceil() as u32..=below as u32 {
            for column in left.ceil() as u32..=right as u32 {
                let (u, v) = ((f64::from(column) - left) / (right - left), (f64::from(row) - above) / (below - above));
                let flat = if u >= v {
                    first + u * (right_above - first) + v * (opposite - right_above)
                } else {
                    first + v * (down - first) + u * (opposite - down)
                };
                if !is_void(at(column, row)) {
                    worst = worst.max((f64::from(at(column, row)) - flat).abs());
                }
            }
        }
    }
    worst as f32
}
