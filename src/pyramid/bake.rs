//! Heights → a pyramid on disk.
//!
//! The levels are averaged from the grid, written as a COG, and read back: what is measured is what later readers
//! get, with all that the codec did to it. Then the errors of every tile and mesh patch go into the sidecar.

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::encode::Codec;
use super::fill::{HeightLevels, LevelsInMemory, read_filled};
use super::levels::{LevelSize, Region, level_sizes};
use super::sidecar::{Link, Sidecar, sidecar_path};
use super::statistics::{Range, Statistics, TileStatistics, raise_to_children};
use super::stored::StoredLevels;
use super::tile_error::{tile_errors_m, tile_statistics};
use super::{PyramidError, cog, mesh_error, overview};
use crate::file::atomic::AtomicFile;
use crate::source::{HeightGrid, Progress};

/// How to bake.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BakeOptions {
    /// How far a stored height may be from the original one, in metres; 0 (the default here and of the cache) stores
    /// every bit. The command `bake` asks for 0.01 m unless told otherwise.
    pub max_error_m: f64,
}

/// What was baked.
#[derive(Clone, Debug)]
pub struct BakeReport {
    /// The GeoTIFF.
    pub path: PathBuf,
    /// The sizes of the levels, finest first.
    pub levels: Vec<LevelSize>,
    /// Bytes of the GeoTIFF.
    pub tif_bytes: u64,
    /// Bytes of the sidecar.
    pub sidecar_bytes: u64,
    /// Lowest height as stored.
    pub min_m: f32,
    /// Highest height as stored.
    pub max_m: f32,
    /// Samples of level 0 without a height.
    pub void_samples: u64,
    /// How long it took.
    pub duration: Duration,
}

/// The share of the whole work that is done when the levels are there, and when they are written.
const LEVELS_DONE: f32 = 0.03;
const WRITTEN_DONE: f32 = 0.5;

/// Bakes a grid into the COG `out` (Float32, overviews, NaN for voids) and its sidecar `out.tiles`. Heights that are
/// not finite are voids. Both files appear whole or not at all; the sidecar comes last. Work is spread over the
/// threads of rayon. One bake of the same `out` at a time.
///
/// # Errors
/// If the grid is inconsistent or has no height at all, or if the files cannot be written.
pub fn bake(
    grid: &HeightGrid,
    out: &Path,
    options: &BakeOptions,
    progress: &dyn Progress,
) -> Result<BakeReport, PyramidError> {
    let start = Instant::now();
    check(grid, out, options)?;
    let sizes = level_sizes(grid.width, grid.height);
    let finest = sizes[0];

    progress.report("levels", 0.0);
    let mut levels: Vec<Cow<'_, [f32]>> = vec![without_infinities(&grid.heights_m)];
    if levels[0].par_iter().all(|height| height.is_nan()) {
        return Err(PyramidError::NoHeights { path: out.to_owned() });
    }
    for pair in sizes.windows(2) {
        let coarse = overview::next_level(&levels[levels.len() - 1], pair[0], pair[1]);
        levels.push(Cow::Owned(coarse));
    }

    let codec = if options.max_error_m > 0.0 { Codec::WithinMetres(options.max_error_m) } else { Codec::Lossless };
    let mut tif = AtomicFile::create(out).map_err(PyramidError::io(out, "creating"))?;
    cog::write(tif.writer(), out, &sizes, &levels, &grid.georeference, codec, &|share| {
        progress.report("writing", LEVELS_DONE + (WRITTEN_DONE - LEVELS_DONE) * share);
    })?;
    std::io::Write::flush(tif.writer()).map_err(PyramidError::io(out, "writing"))?;

    let original = levels[0].clone();
    progress.report("reading back", WRITTEN_DONE);
    let stored = StoredLevels::open(tif.partial_path(), out, sizes.clone())?;
    let levels = read_back(&stored, levels, codec, out)?;
    drop(stored);

    let (statistics, range) = measure(&original, &sizes, &levels, progress)?;
    let void_samples = original.par_iter().filter(|height| height.is_nan()).count() as u64;

    let link = Link::to(tif.partial_path()).map_err(PyramidError::io(out, "reading back"))?;
    let sidecar = Sidecar {
        link,
        finest,
        max_error_m: options.max_error_m,
        min_m: range.min_m,
        max_m: range.max_m,
        georeference: grid.georeference.clone(),
        statistics,
    };
    let bytes = sidecar.to_bytes().map_err(PyramidError::encode(out))?;
    let tif_bytes = std::fs::metadata(tif.partial_path()).map_err(PyramidError::io(out, "reading back"))?.len();
    commit(tif, &bytes, out)?;
    progress.report("done", 1.0);
    Ok(BakeReport {
        path: out.to_owned(),
        levels: sizes,
        tif_bytes,
        sidecar_bytes: bytes.len() as u64,
        min_m: range.min_m,
        max_m: range.max_m,
        void_samples,
        duration: start.elapsed(),
    })
}

fn check(grid: &HeightGrid, out: &Path, options: &BakeOptions) -> Result<(), PyramidError> {
    let bad = |cause: String| Err(PyramidError::BadGrid { path: out.to_owned(), cause });
    if grid.width < 2 || grid.height < 2 {
        return bad(format!("{} × {} samples are not a surface", grid.width, grid.height));
    }
    if grid.heights_m.len() as u64 != u64::from(grid.width) * u64::from(grid.height) {
        return bad(format!("{} heights for {} × {} samples", grid.heights_m.len(), grid.width, grid.height));
    }
    if grid.georeference.crs_from_grid.iter().any(|number| !number.is_finite()) {
        return bad("its georeference is not finite".into());
    }
    if !(options.max_error_m.is_finite() && options.max_error_m >= 0.0) {
        return bad(format!("an error bound of {} metres", options.max_error_m));
    }
    Ok(())
}

fn without_infinities(heights_m: &[f32]) -> Cow<'_, [f32]> {
    if heights_m.par_iter().any(|height| height.is_infinite()) {
        heights_m
            .par_iter()
            .map(|&height| if height.is_infinite() { f32::NAN } else { height })
            .collect::<Vec<_>>()
            .into()
    } else {
        heights_m.into()
    }
}

/// The levels as a reader of the file gets them. A lossless file must give back every bit.
fn read_back<'a>(
    stored: &StoredLevels,
    levels: Vec<Cow<'a, [f32]>>,
    codec: Codec,
    out: &Path,
) -> Result<Vec<Cow<'a, [f32]>>, PyramidError> {
    let mut decoded_levels = Vec::with_capacity(levels.len());
    for (level, (heights_m, &size)) in levels.into_iter().zip(stored.sizes()).enumerate() {
        let decoded: Vec<f32> = by_tile_rows(size, |region| stored.read(level, region))?;
        let same = |(a, b): (&f32, &f32)| match codec {
            Codec::Lossless => a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan(),
            Codec::WithinMetres(_) => a.is_nan() == b.is_nan(),
        };
        if !decoded.par_iter().zip(heights_m.par_iter()).all(same) {
            let cause = format!("level {level} reads back other than it was written");
            return Err(PyramidError::Mismatch { path: out.to_owned(), cause });
        }
        decoded_levels.push(if codec == Codec::Lossless { heights_m } else { Cow::Owned(decoded) });
    }
    Ok(decoded_levels)
}

/// Puts a level together from rows of tiles, in parallel.
fn by_tile_rows(
    size: LevelSize,
    read: impl Fn(Region) -> Result<Vec<f32>, PyramidError> + Sync,
) -> Result<Vec<f32>, PyramidError> {
    let rows: Vec<Vec<f32>> = (0..size.tiles_y())
        .into_par_iter()
        .map(|y| {
            let row = size.tile_region(0, y, 0);
            read(Region { width: size.width, ..row })
        })
        .collect::<Result<_, _>>()?;
    Ok(rows.concat())
}

/// All statistics of the decoded `levels` against the `original` heights, and the range of level 0.
fn measure(
    original: &[f32],
    sizes: &[LevelSize],
    levels: &[Cow<'_, [f32]>],
    progress: &dyn Progress,
) -> Result<(Statistics, Range), PyramidError> {
    let source = LevelsInMemory { sizes, heights_m: levels };
    let fallback_m = fallback_m(&levels[0]);
    let mut tiles: Vec<Vec<TileStatistics>> = Vec::new();
    let mut patches = Vec::new();
    let mut range = Range::EMPTY;
    for (level, &size) in sizes.iter().enumerate() {
        let share = level as f32 / sizes.len() as f32;
        progress.report("tile errors", WRITTEN_DONE + (1.0 - WRITTEN_DONE) * share);
        let served = by_tile_rows(size, |region| read_filled(&source, level, region, fallback_m))?;
        let mut errors_m = tile_errors_m(original, sizes[0], &served, size);
        if let Some(children) = tiles.last() {
            let finer = sizes[level - 1];
            let child_errors_m: Vec<f32> = children.iter().map(|child| child.error_m).collect();
            let (count, child_count) = ((size.tiles_x(), size.tiles_y()), (finer.tiles_x(), finer.tiles_y()));
            raise_to_children(&mut errors_m, count, &child_errors_m, child_count);
        }
        tiles.push(tile_statistics(&served, size, &errors_m));
        if level == 0 {
            range.add(&served);
            progress.report("mesh errors", WRITTEN_DONE);
            patches = mesh_error::patch_statistics(original, &served, size);
        }
    }
    Ok((Statistics { tiles, patches }, range))
}

/// The lowest stored height: see [`read_filled`].
pub(super) fn fallback_m(level_0: &[f32]) -> f32 {
    level_0.iter().copied().fold(f32::NAN, f32::min)
}

/// Gives both files their names: first the GeoTIFF, then the sidecar, whose link makes it count.
fn commit(tif: AtomicFile, sidecar: &[u8], out: &Path) -> Result<(), PyramidError> {
    let path = sidecar_path(out);
    let mut beside = AtomicFile::create(&path).map_err(PyramidError::io(&path, "creating"))?;
    std::io::Write::write_all(beside.writer(), sidecar).map_err(PyramidError::io(&path, "writing"))?;
    tif.commit().map_err(PyramidError::io(out, "writing"))?;
    beside.commit().map_err(|source| {
        // Half a pyramid is none.
        let _ = std::fs::remove_file(out);
        PyramidError::Io { path: path.clone(), what: "writing", source }
    })
}
