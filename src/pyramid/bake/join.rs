//! Joining the parts of all rounds into one pyramid: the tiles in the order of a COG, and the sidecar. A pyramid in
//! memory takes only the statistics.

use std::io::Write;
use std::path::Path;

use super::chunk::Job;
use super::deferred::{Deferred, FinishedLevels};
use super::part::Part;
use super::plan::{Chunk, Round};
use super::vertices::for_children;
use crate::file::atomic::AtomicFile;
use crate::pyramid::error::PyramidError;
use crate::pyramid::format::cog::CogWriter;
use crate::pyramid::format::fingerprint::Fingerprint;
use crate::pyramid::format::pair;
use crate::pyramid::format::record::{PAGE_BYTES, record_bytes};
use crate::pyramid::format::sidecar::{LevelSummary, Sidecar, sidecar_path};
use crate::pyramid::format::stored::StoredLevels;
use crate::pyramid::surface::fill::HeightLevels;
use crate::pyramid::surface::levels::{LevelSize, Region};
use crate::pyramid::surface::statistics::{PatchStatistics, TileStatistics};
use crate::source::Progress;
use crate::source::georeference::Georeference;

/// A finished round.
pub(super) struct Done {
    /// The round that made the parts.
    pub round: Round,
    /// The round's parts, row by row.
    pub parts: Vec<Part>,
}

impl Done {
    /// Returns the lowest and highest height of the first round; NaN if there is none.
    pub(super) fn range_m(&self) -> [f32; 2] {
        self.parts.iter().map(|part| part.contents.range_m).fold([f32::NAN; 2], |range, part| {
            // f32::min and max ignore NaN.
            [range[0].min(part[0]), range[1].max(part[1])]
        })
    }
}

/// The joined pyramid.
pub(super) struct Joined {
    /// The header of the sidecar, as written.
    pub sidecar: Sidecar,
    /// Length of the GeoTIFF in bytes.
    pub tif_bytes: u64,
}

/// A row of tiles of a level in one part: the part, the column of the first tile, its index among the part's tiles, and
/// the number of tiles.
struct Run<'a> {
    part: &'a Part,
    x: u32,
    first: usize,
    count: usize,
}

/// Returns the runs that make up row `y` of the tiles of a level.
fn runs<'a>(job: &Job<'_>, done: &'a Done, level: usize, y: u32) -> impl Iterator<Item = Run<'a>> {
    let (plan, round) = (&job.plan, done.round);
    let (count_x, _) = plan.chunk_counts(round);
    let chunk_y = plan.chunk_of(round, level, 0, y).y;
    (0..count_x).map(move |chunk_x| {
        let chunk = Chunk { x: chunk_x, y: chunk_y };
        let finer: usize = (round.first_made()..level).map(|finer| plan.own_tiles(round, chunk, finer).samples()).sum();
        let own = plan.own_tiles(round, chunk, level);
        let first = finer + ((y - own.y) * own.width) as usize;
        Run { part: &done.parts[(chunk_y * count_x + chunk_x) as usize], x: own.x, first, count: own.width as usize }
    })
}

/// Returns the round that made a level.
fn made_by(done: &[Done], level: usize) -> &Done {
    done.iter().find(|done| level <= done.round.top).expect("the last round makes the top")
}

/// Returns the lowest and highest height of level 0 in metres.
pub(super) fn range_m(job: &Job<'_>, done: &[Done]) -> Result<[f32; 2], PyramidError> {
    let range_m = done[0].range_m();
    if range_m[0].is_nan() {
        return Err(PyramidError::NoHeights { path: job.out.to_owned() });
    }
    Ok(range_m)
}

/// Returns the number of no-data samples of level 0.
pub(super) fn void_samples(done: &[Done]) -> u64 {
    done[0].parts.iter().map(|part| part.contents.void_samples).sum()
}

/// Returns the statistics of all tiles, by level, row-major. `levels` are the finished levels, as they are stored, and
/// `min_m` is the lowest height of level 0.
pub(super) fn statistics(
    job: &Job<'_>,
    done: &[Done],
    levels: &dyn HeightLevels,
    min_m: f32,
) -> Result<Vec<Vec<TileStatistics>>, PyramidError> {
    let mut statistics = gather(job, done);
    let deferred: Vec<Deferred> =
        done.iter().flat_map(|done| &done.parts).flat_map(|part| part.contents.deferred.iter().copied()).collect();
    if !deferred.is_empty() {
        raise(&FinishedLevels { levels, fallback_m: min_m }, job, &deferred, &mut statistics)?;
    }
    set_corners(&mut statistics, &job.plan.sizes);
    Ok(statistics)
}

/// Returns the encoded pages of all tiles, by level, row-major: [`PAGE_BYTES`] for each tile.
pub(super) fn pages(job: &Job<'_>, done: &[Done]) -> Result<Vec<u8>, PyramidError> {
    let mut pages = Vec::new();
    for (level, size) in job.plan.sizes.iter().enumerate() {
        for y in 0..size.tiles_y() {
            for run in runs(job, made_by(done, level), level, y) {
                pages.extend(run.part.pages(run.first, run.count)?);
            }
        }
    }
    Ok(pages)
}

/// Returns the patches of the strides above that of the coarsest level; see `TileStore::coarse_patches`.
pub(super) fn coarse_patches(done: &[Done]) -> &[Vec<PatchStatistics>] {
    &done[done.len() - 1].parts[0].contents.coarse_patches
}

/// Writes the pyramid to temporary files in the folder of `target`, then renames both to the pyramid's path.
pub(super) fn join(
    job: &Job<'_>,
    done: &[Done],
    georeference: &Georeference,
    max_error_m: f64,
    target: &Path,
    progress: &dyn Progress,
) -> Result<Joined, PyramidError> {
    let sizes = &job.plan.sizes;
    let [min_m, max_m] = range_m(job, done)?;
    let mut tif = AtomicFile::create_for(target, job.readers).map_err(PyramidError::io(target, "creating"))?;
    let mut writer = CogWriter::begin(tif.writer(), job.out, sizes, georeference, job.codec)?;
    let mut levels = vec![LevelSummary { bytes: 0, largest_error_m: 0.0 }; sizes.len()];
    let tiles: u64 = sizes.iter().map(|size| size.tiles()).sum();
    let mut written = 0_u64;
    for (level, size) in sizes.iter().enumerate().rev() {
        for y in 0..size.tiles_y() {
            job.go_on()?;
            progress.report("writing", written as f32 / tiles as f32);
            for run in runs(job, made_by(done, level), level, y) {
                for (i, bytes) in run.part.tiles(run.first, run.count)?.iter().enumerate() {
                    writer.put(level, y as usize * size.tiles_x() as usize + run.x as usize + i, bytes)?;
                    levels[level].bytes += bytes.len() as u64;
                }
            }
            written += u64::from(size.tiles_x());
        }
    }
    writer.finish()?;
    tif.sync().map_err(PyramidError::io(target, "writing"))?;

    progress.report("statistics", 0.0);
    let stored = StoredLevels::open(tif.partial_path(), job.out, sizes.clone())?;
    let statistics = statistics(job, done, &stored, min_m)?;
    drop(stored);
    for (summary, tiles) in levels.iter_mut().zip(&statistics) {
        summary.largest_error_m = tiles.iter().map(|tile| tile.error_m).fold(0.0, f32::max);
    }

    let mut sidecar = Sidecar {
        fingerprint: Fingerprint::of(tif.partial_path()).map_err(PyramidError::io(job.out, "reading back"))?,
        sizes: sizes.clone(),
        max_error_m,
        min_m,
        max_m,
        void_samples: void_samples(done),
        georeference: georeference.clone(),
        levels,
        coarse_patches: coarse_patches(done).to_vec(),
        header_bytes: 0,
    };
    let header = sidecar.header_to_bytes().map_err(PyramidError::encode(job.out))?;
    sidecar.header_bytes = header.len() as u64;
    let sidecar_file = sidecar_path(target);
    let mut records =
        AtomicFile::create_for(&sidecar_file, job.readers).map_err(PyramidError::io(&sidecar_file, "creating"))?;
    records.writer().write_all(&header).map_err(PyramidError::io(&sidecar_file, "writing"))?;
    let mut number = 0;
    for (level, size) in sizes.iter().enumerate() {
        for y in 0..size.tiles_y() {
            job.go_on()?;
            progress.report("statistics", number as f32 / tiles as f32);
            for run in runs(job, made_by(done, level), level, y) {
                let pages = run.part.pages(run.first, run.count)?;
                for (i, page) in pages.chunks_exact(PAGE_BYTES).enumerate() {
                    let tile = &statistics[level][(y * size.tiles_x() + run.x) as usize + i];
                    let checksum = run.part.contents.tiles[run.first + i].checksum;
                    let record = record_bytes(number, tile, checksum, page);
                    records.writer().write_all(&record).map_err(PyramidError::io(&sidecar_file, "writing"))?;
                    number += 1;
                }
            }
        }
    }
    records.sync().map_err(PyramidError::io(&sidecar_file, "writing"))?;
    let tif_bytes = sidecar.fingerprint.tif_bytes;
    job.go_on()?;
    pair::commit(tif.partial_path(), records.partial_path(), job.out)?;
    Ok(Joined { sidecar, tif_bytes })
}

/// Collects the statistics of all tiles, by level, row-major.
fn gather(job: &Job<'_>, done: &[Done]) -> Vec<Vec<TileStatistics>> {
    let levels = job.plan.sizes.iter().enumerate();
    levels
        .map(|(level, size)| {
            let rows = 0..size.tiles_y();
            rows.flat_map(|y| runs(job, made_by(done, level), level, y).collect::<Vec<_>>())
                .flat_map(|run| run.part.contents.tiles[run.first..run.first + run.count].iter())
                .map(|tile| tile.statistics)
                .collect()
        })
        .collect()
}

/// Raises the errors to those at deferred samples, and then the errors of parents to those of their children.
fn raise(
    served: &FinishedLevels<'_>,
    job: &Job<'_>,
    deferred: &[Deferred],
    statistics: &mut [Vec<TileStatistics>],
) -> Result<(), PyramidError> {
    let sizes = &job.plan.sizes;
    let mut errors_m: Vec<Vec<f32>> =
        statistics.iter().map(|tiles| tiles.iter().map(|tile| tile.error_m).collect()).collect();
    served.raise(&job.plan, deferred, &mut errors_m)?;
    for level in 1..sizes.len() {
        let (finer, coarser) = errors_m.split_at_mut(level);
        let (children, size) = (&finer[level - 1], sizes[level - 1]);
        let region = Region { x: 0, y: 0, width: size.tiles_x(), height: size.tiles_y() };
        for (i, error_m) in (0..).zip(&mut coarser[0]) {
            let place = (i % sizes[level].tiles_x(), i / sizes[level].tiles_x());
            for_children(place, region, |child| *error_m = error_m.max(children[child]));
        }
    }
    for (tiles, errors_m) in statistics.iter_mut().zip(errors_m) {
        for (tile, error_m) in tiles.iter_mut().zip(errors_m) {
            tile.error_m = error_m;
        }
    }
    Ok(())
}

/// Sets the error at every tile corner to the largest error of the up to four tiles that meet there.
fn set_corners(statistics: &mut [Vec<TileStatistics>], sizes: &[LevelSize]) {
    for (tiles, size) in statistics.iter_mut().zip(sizes) {
        let (tiles_x, tiles_y) = (size.tiles_x(), size.tiles_y());
        let errors_m: Vec<f32> = tiles.iter().map(|tile| tile.error_m).collect();
        let error_m = |x: u32, y: u32| match x < tiles_x && y < tiles_y {
            true => errors_m[y as usize * tiles_x as usize + x as usize],
            false => 0.0,
        };
        for (i, tile) in tiles.iter_mut().enumerate() {
            let (x, y) = (i as u32 % tiles_x, i as u32 / tiles_x);
            tile.corner_errors_m = std::array::from_fn(|corner| {
                let (x, y) = (x + corner as u32 % 2, y + corner as u32 / 2);
                let (west, north) = (x.wrapping_sub(1), y.wrapping_sub(1));
                error_m(west, north).max(error_m(x, north)).max(error_m(west, y)).max(error_m(x, y))
            });
        }
    }
}
