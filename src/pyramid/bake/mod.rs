//! Heights → a pyramid on disk, in memory that does not grow with the heights.
//!
//! `plan` cuts the work into rounds and chunks, `chunk` makes one, `part` is what it leaves, `folder` keeps the parts of
//! a long bake, `join` makes the pyramid of them. What comes out does not depend on threads, on the order of chunks, on
//! who baked them, or on how often the bake was stopped.
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
mod below;
mod chunk;
mod join;
mod rounds;

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

pub use folder::parts_path;

use crate::pyramid::error::PyramidError;
use crate::pyramid::format::bytes::fnv;
use crate::pyramid::format::encode::Codec;
use crate::pyramid::format::{pair, sidecar};
use crate::pyramid::surface::levels::{LevelSize, level_sizes};
use crate::source::reader::GridReader;
use crate::source::{HeightGrid, HeightReader, Progress};
use chunk::Job;
use folder::Folder;
use plan::Plan;

/// What changes the bytes of a pyramid besides its heights.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BakeOptions {
    /// How far a stored height may be from the original one, in metres; 0 (the default here and of the cache) stores
    /// every bit. The command `bake` asks for 0.01 m unless told otherwise.
    pub max_error_m: f64,
}

/// How the work of a bake is done. None of it changes the pyramid, but for `chunk_levels`, on which the bounds of the
/// errors of coarse levels depend a little.
#[derive(Clone, Copy, Debug)]
pub struct BakeWork<'a> {
    /// A chunk is 2^k × 2^k tiles: 4 means 4096 × 4096 samples. 1 to 6; other than 4 is for tests.
    pub chunk_levels: u32,
    /// Whether parts are kept in a work folder beside the pyramid; else in memory. A bake of one chunk needs no parts.
    pub in_folder: bool,
    /// Go on with the parts that are there.
    pub resume: bool,
    /// Bake the chunks c of the first round with c mod N = I − 1 into the work folder and no more: (I, N).
    pub shard: Option<(u32, u32)>,
    /// Set from another thread, it stops the bake with [`PyramidError::Stopped`].
    pub stop: &'a AtomicBool,
}

static NEVER: AtomicBool = AtomicBool::new(false);

impl Default for BakeWork<'_> {
    fn default() -> Self {
        Self { chunk_levels: 4, in_folder: false, resume: false, shard: None, stop: &NEVER }
    }
}

/// What was baked.
#[derive(Clone, Debug)]
pub struct BakeReport {
    /// Where the GeoTIFF lies; the sidecar lies beside it.
    pub path: PathBuf,
    /// The sizes of the levels, finest first.
    pub levels: Vec<LevelSize>,
    /// Length of the GeoTIFF in bytes.
    pub tif_bytes: u64,
    /// Length of the sidecar in bytes.
    pub sidecar_bytes: u64,
    /// Lowest height of level 0 in metres, as stored.
    pub min_m: f32,
    /// Highest height of level 0 in metres, as stored.
    pub max_m: f32,
    /// Samples of level 0 without a height.
    pub void_samples: u64,
    /// Chunks that a bake before this one had left in the work folder.
    pub resumed_chunks: u64,
    /// How long it took.
    pub duration: Duration,
}

/// What a call of [`bake_reader`] came to.
#[derive(Clone, Debug)]
pub enum Baked {
    /// The pyramid is whole.
    Pyramid(BakeReport),
    /// The chunks of a shard: how many they are, and how many of them were there already.
    Shard {
        /// All chunks of the shard.
        chunks: u64,
        /// Those of them that were in the work folder already.
        resumed_chunks: u64,
    },
}

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
    if grid.heights_m.len() as u64 != u64::from(grid.width) * u64::from(grid.height) {
        let cause = format!("{} heights for {} × {} samples", grid.heights_m.len(), grid.width, grid.height);
        return Err(PyramidError::BadGrid { path: out.to_owned(), cause });
    }
    let reader = GridReader::new(grid, "heights in memory".into());
    match bake_reader(&reader, out, options, &BakeWork::default(), progress)? {
        Baked::Pyramid(report) => Ok(report),
        Baked::Shard { .. } => unreachable!("no shard was asked for"),
    }
}

/// The same from heights of any size, which are read by windows, each about once.
///
/// # Errors
/// As [`bake()`], if the heights cannot be read, and [`PyramidError::Parts`] if the work folder is another's.
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
        true => Some(Folder::open(out, bake, &identity, keep)?),
        false => None,
    };
    let job = Job {
        plan,
        codec: if options.max_error_m > 0.0 { Codec::WithinMetres(options.max_error_m) } else { Codec::Lossless },
        out,
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
        // What shards of a small grid left.
        if let Ok(folder) = Folder::open(out, bake, &identity, true) {
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

/// All that the bytes of the pyramid depend on.
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
    let bad = |cause: String| Err(PyramidError::BadGrid { path: out.to_owned(), cause });
    let [width, height] = reader.size();
    if width < 2 || height < 2 {
        return bad(format!("{width} × {height} samples are not a surface"));
    }
    if reader.georeference().crs_from_grid.iter().any(|number| !number.is_finite()) {
        return bad("its georeference is not finite".into());
    }
    if !(options.max_error_m.is_finite() && options.max_error_m >= 0.0) {
        return bad(format!("an error bound of {} metres", options.max_error_m));
    }
    Ok(())
}
