//! Baking: from heights to a pyramid on disk, in memory that does not grow with the number of heights. `measure` is
//! the part of it that a pyramid in memory needs: the measured errors, without files and without encoded tiles.
//!
//! `plan` divides the work into rounds and chunks, `chunk` bakes one, `part` is its result, `folder` stores the parts
//! of a long bake, `join` assembles the pyramid from them. The result does not depend on threads, on the order of
//! chunks, on which machine baked them, or on how often the bake was interrupted.
//!
//! Why: `docs/decisions/bake-in-chunks.md`.

mod plan;
mod codec;
mod surface_rows;
mod deferred;
mod tile_error;
mod mesh_error;
mod vertices;
mod part;
mod folder;
mod lock;
mod below;
mod chunk;
mod join;
mod rounds;

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

pub(crate) use folder::{parts_path, remove_parts};
pub(crate) use lock::BakeLock;

use crate::file::atomic::Readers;
use crate::pyramid::error::PyramidError;
use crate::pyramid::format::bytes::fnv;
use crate::pyramid::format::encode::Codec;
use crate::pyramid::format::{pair, sidecar};
use crate::pyramid::surface::fill::HeightLevels;
use crate::pyramid::surface::levels::{LevelSize, level_sizes};
use crate::pyramid::surface::statistics::{PatchStatistics, TileStatistics};
use crate::source::georeference::Georeference;
use crate::source::reader::GridReader;
use crate::source::{HeightGrid, HeightReader, Progress};
use chunk::Job;
use folder::Folder;
use plan::Plan;

/// The options that change the bytes of a pyramid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BakeOptions {
    /// Largest allowed difference between a stored height and the original, in metres; 0 (the default here and in the
    /// cache) is lossless. The default of the command `bake` is 0.01 m.
    pub max_error_m: f64,
}

/// How the work of a bake is organised. None of it changes the pyramid except `chunk_levels`, which slightly affects
/// the error bounds of coarse levels.
#[derive(Clone, Copy, Debug)]
pub struct BakeWork<'a> {
    /// The exponent k of the side of a chunk, 2^k × 2^k tiles: 4 means 4096 × 4096 samples. Range 1 to 6; values other
    /// than 4 are for tests.
    pub chunk_levels: u32,
    /// Whether parts are stored in a work folder next to the pyramid; otherwise in memory. A bake of one chunk needs no
    /// parts.
    pub in_folder: bool,
    /// Whether to resume with existing parts.
    pub resume: bool,
    /// (I, N): bake only the chunks c of the first round with c mod N = I − 1, into the work folder.
    pub shard: Option<(u32, u32)>,
    /// Whether only the user may read the files.
    pub is_private: bool,
    /// Set from another thread, it stops the bake with [`PyramidError::Stopped`].
    pub stop: &'a AtomicBool,
}

static NEVER: AtomicBool = AtomicBool::new(false);

impl BakeWork<'static> {
    /// The default: a new bake in memory.
    pub(crate) const NEW: Self =
        Self { chunk_levels: 4, in_folder: false, resume: false, shard: None, is_private: false, stop: &NEVER };
}

impl Default for BakeWork<'_> {
    fn default() -> Self {
        BakeWork::NEW
    }
}

impl BakeWork<'_> {
    fn readers(&self) -> Readers {
        if self.is_private { Readers::Owner } else { Readers::Usual }
    }
}

/// A summary of a finished bake.
#[derive(Clone, Debug)]
pub struct BakeReport {
    /// Path of the GeoTIFF; the sidecar is in the same folder.
    pub path: PathBuf,
    /// Sizes of the levels, finest first.
    pub levels: Vec<LevelSize>,
    /// Length of the GeoTIFF in bytes.
    pub tif_bytes: u64,
    /// Length of the sidecar in bytes.
    pub sidecar_bytes: u64,
    /// Lowest height of level 0 in metres, as stored.
    pub min_m: f32,
    /// Highest height of level 0 in metres, as stored.
    pub max_m: f32,
    /// Number of no-data samples of level 0.
    pub void_samples: u64,
    /// Number of chunks that were found finished in the work folder.
    pub resumed_chunks: u64,
    /// The duration of the bake.
    pub duration: Duration,
}

/// The result of [`bake_reader`].
#[derive(Clone, Debug)]
pub enum Baked {
    /// The pyramid is complete.
    Pyramid(BakeReport),
    /// The chunks of a shard are complete.
    Shard {
        /// Number of chunks in the shard.
        chunks: u64,
        /// Number of these that were already in the work folder.
        resumed_chunks: u64,
    },
}

/// Bakes a grid into the COG `out` (Float32, overviews, NaN for no-data) and its sidecar `out.tiles`. Heights that are
/// not finite are no-data. Both files appear complete or not at all; the sidecar comes last. Work is spread over the
/// threads of rayon. Only one bake of the same `out` may run at a time.
///
/// # Errors
/// If the grid is inconsistent or has no heights at all, or if the files cannot be written.
pub fn bake(
    grid: &HeightGrid,
    out: &Path,
    options: &BakeOptions,
    progress: &dyn Progress,
) -> Result<BakeReport, PyramidError> {
    bake_with(grid, out, options, &BakeWork::NEW, progress)
}

/// Does the same as [`bake()`], with other `work`, but no shard.
///
/// # Errors
/// The errors of [`bake()`].
pub(crate) fn bake_with(
    grid: &HeightGrid,
    out: &Path,
    options: &BakeOptions,
    work: &BakeWork<'_>,
    progress: &dyn Progress,
) -> Result<BakeReport, PyramidError> {
    if grid.heights_m.len() as u64 != u64::from(grid.width) * u64::from(grid.height) {
        let cause = format!("{} heights for {} × {} samples", grid.heights_m.len(), grid.width, grid.height);
        return Err(PyramidError::BadGrid { path: out.to_owned(), cause });
    }
    let reader = GridReader::new(grid, "heights in memory".into());
    match bake_reader(&reader, out, options, work, progress)? {
        Baked::Pyramid(report) => Ok(report),
        Baked::Shard { .. } => unreachable!("no shard was asked for"),
    }
}

/// Bakes heights of any size like [`bake()`]; they are read in windows, each about once.
///
/// # Errors
/// The errors of [`bake()`] and of reading the heights, and [`PyramidError::Parts`] if the work folder belongs to
/// another bake.
pub fn bake_reader(
    reader: &dyn HeightReader,
    out: &Path,
    options: &BakeOptions,
    work: &BakeWork<'_>,
    progress: &dyn Progress,
) -> Result<Baked, PyramidError> {
    let start = Instant::now();
    check(reader, out, options)?;
    let [width, height] = reader.size();
    let plan = Plan { sizes: level_sizes(width, height), chunk_levels: work.chunk_levels.clamp(1, 6) };
    let identity = identity(reader, &plan, options);
    let bake = fnv(identity.as_bytes());
    let rounds = plan.rounds();
    let one_chunk = plan.chunk_counts(rounds[0]) == (1, 1);
    let keep = work.resume || work.shard.is_some();
    let folder = match work.shard.is_some() || work.in_folder && !one_chunk {
        true => Some(Folder::open(out, bake, &identity, keep, work.readers())?),
        false => None,
    };
    let job = Job {
        plan,
        codec: if options.max_error_m > 0.0 { Codec::WithinMetres(options.max_error_m) } else { Codec::Lossless },
        encodes: true,
        out,
        readers: work.readers(),
        bake,
        stop: work.stop,
        stage: &|what| {
            if one_chunk {
                progress.report(what, 0.0);
            }
        },
    };
    if let Some(shard) = work.shard {
        let (chunks, resumed_chunks) = rounds::bake_shard(&job, rounds[0], reader, folder.as_ref(), shard, progress)?;
        return Ok(Baked::Shard { chunks, resumed_chunks });
    }
    let (done, resumed_chunks) = rounds::bake_rounds(&job, reader, folder.as_ref(), progress)?;
    let target = folder.as_ref().map_or_else(|| out.to_owned(), |folder| folder.path().join("joined.tif"));
    let joined = join::join(&job, &done, reader.georeference(), options.max_error_m, &target, progress)?;
    pair::tidy(out);
    if let Some(folder) = folder {
        folder.remove();
    } else if one_chunk && work.in_folder && keep {
        // The parts that shards of a small grid left behind.
        if let Ok(folder) = Folder::open(out, bake, &identity, true, work.readers()) {
            folder.remove();
        }
    }
    progress.report("done", 1.0);
    Ok(Baked::Pyramid(BakeReport {
        path: out.to_owned(),
        levels: joined.sidecar.sizes.clone(),
        tif_bytes: joined.tif_bytes,
        sidecar_bytes: joined.sidecar.file_bytes(),
        min_m: joined.sidecar.min_m,
        max_m: joined.sidecar.max_m,
        void_samples: joined.sidecar.void_samples,
        resumed_chunks,
        duration: start.elapsed(),
    }))
}

/// The statistics of a pyramid whose heights stay in memory.
pub(in crate::pyramid) struct Measured {
    /// The statistics of the tiles of each level, finest first, row-major.
    pub tiles: Vec<Vec<TileStatistics>>,
    /// The encoded pages of the same tiles, one after the other.
    pub pages: Vec<u8>,
    /// The patches of the strides above that of the coarsest level; see `TileStore::coarse_patches`.
    pub coarse_patches: Vec<Vec<PatchStatistics>>,
    /// The lowest and highest height of level 0 in metres, as served.
    pub range_m: [f32; 2],
    /// Number of no-data samples of level 0.
    pub void_samples: u64,
}

/// Measures the tiles and patches of `levels` exactly as [`bake_reader`] does for a lossless pyramid, but encodes no
/// tile and writes no file. `reader` reads level 0, whose grid [`check_grid`] has checked, and `name` stands for the
/// heights in messages.
pub(in crate::pyramid) fn measure(
    levels: &dyn HeightLevels,
    reader: &dyn HeightReader,
    name: &Path,
    progress: &dyn Progress,
) -> Result<Measured, PyramidError> {
    let BakeWork { chunk_levels, stop, .. } = BakeWork::default();
    let job = Job {
        plan: Plan { sizes: levels.sizes().to_vec(), chunk_levels },
        codec: Codec::Lossless,
        encodes: false,
        out: name,
        readers: Readers::Usual,
        bake: 0,
        stop,
        stage: &|_| (),
    };
    let (done, _) = rounds::bake_rounds(&job, reader, None, progress)?;
    let range_m = join::range_m(&job, &done)?;
    Ok(Measured {
        tiles: join::statistics(&job, &done, levels, range_m[0])?,
        pages: join::pages(&job, &done)?,
        coarse_patches: join::coarse_patches(&done).to_vec(),
        range_m,
        void_samples: join::void_samples(&done),
    })
}

/// Returns a text of everything that the bytes of the pyramid depend on.
fn identity(reader: &dyn HeightReader, plan: &Plan, options: &BakeOptions) -> String {
    let [width, height] = reader.size();
    format!(
        "hachure {}, sidecar {}, chunks of 2^{} tiles, within {} m, {width} × {height}\n{}",
        env!("CARGO_PKG_VERSION"),
        sidecar::VERSION,
        plan.chunk_levels,
        options.max_error_m,
        reader.identity()
    )
}

fn check(reader: &dyn HeightReader, out: &Path, options: &BakeOptions) -> Result<(), PyramidError> {
    check_grid(reader.size(), reader.georeference(), out)?;
    if !(options.max_error_m.is_finite() && options.max_error_m >= 0.0) {
        let cause = format!("the error bound {} m is not a finite number from 0 up", options.max_error_m);
        return Err(PyramidError::BadGrid { path: out.to_owned(), cause });
    }
    Ok(())
}

/// Checks that a grid of this size and georeference has a surface; `name` stands for it in messages.
pub(in crate::pyramid) fn check_grid(
    [width, height]: [u32; 2],
    georeference: &Georeference,
    name: &Path,
) -> Result<(), PyramidError> {
    let bad = |cause: String| Err(PyramidError::BadGrid { path: name.to_owned(), cause });
    if width < 2 || height < 2 {
        return bad(format!("{width} × {height} samples do not make a surface; at least 2 × 2 are needed"));
    }
    if georeference.crs_from_grid.iter().any(|number| !number.is_finite()) {
        return bad("its georeference has numbers that are not finite".into());
    }
    Ok(())
}
