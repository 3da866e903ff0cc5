//! Baking the chunks of all rounds, several at a time.
//!
//! A chunk uses all cores by itself while it computes; while one reads or writes, another computes. So a few are in
//! progress at once, and their number, not that of the cores, bounds the memory: about 0.4 GB for each.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use super::below::Below;
use super::chunk::{Job, bake_chunk};
use super::folder::Folder;
use super::join::Done;
use super::part::{Part, PartName};
use super::plan::{Chunk, Round};
use crate::pyramid::error::PyramidError;
use crate::source::{HeightReader, Progress};

/// Number of threads per chunk in progress, on machines with many.
const THREADS_PER_CHUNK: usize = 4;

/// Bakes all rounds. Returns them with the number of chunks that existed already.
pub(super) fn bake_rounds(
    job: &Job<'_>,
    reader: &dyn HeightReader,
    folder: Option<&Folder>,
    progress: &dyn Progress,
) -> Result<(Vec<Done>, u64), PyramidError> {
    let mut all: Vec<Done> = Vec::new();
    let mut resumed = 0;
    for round in job.plan.rounds() {
        let chunks = job.plan.chunks(round);
        let below = match all.last() {
            None => Below::Heights(reader),
            Some(done) => Below::Parts(done.round, &done.parts),
        };
        let lowest_m = all.first().map_or(f32::NAN, |done| done.range_m()[0]);
        let (parts, there) = bake_chunks(job, round, &chunks, below, lowest_m, folder, progress)?;
        resumed += there;
        all.push(Done { round, parts });
    }
    Ok((all, resumed))
}

/// Bakes the chunks of a shard (I, N) into the folder. Returns their number, and how many existed already.
pub(super) fn bake_shard(
    job: &Job<'_>,
    round: Round,
    reader: &dyn HeightReader,
    folder: Option<&Folder>,
    (shard, shards): (u32, u32),
    progress: &dyn Progress,
) -> Result<(u64, u64), PyramidError> {
    let chunks = job.plan.chunks(round).into_iter().skip(shard as usize - 1).step_by(shards as usize);
    let chunks: Vec<Chunk> = chunks.collect();
    let below = Below::Heights(reader);
    let (parts, there) = bake_chunks(job, round, &chunks, below, f32::NAN, folder, progress)?;
    Ok((parts.len() as u64, there))
}

fn bake_chunks(
    job: &Job<'_>,
    round: Round,
    chunks: &[Chunk],
    below: Below<'_>,
    lowest_m: f32,
    folder: Option<&Folder>,
    progress: &dyn Progress,
) -> Result<(Vec<Part>, u64), PyramidError> {
    let what = if round.number == 0 { "baking" } else { "coarse levels" };
    let (next, finished, resumed) = (AtomicUsize::new(0), AtomicUsize::new(0), AtomicUsize::new(0));
    let parts: Mutex<Vec<Option<Part>>> = Mutex::new(chunks.iter().map(|_| None).collect());
    let failed: Mutex<Option<PyramidError>> = Mutex::new(None);
    let one = |chunk: Chunk| -> Result<Part, PyramidError> {
        job.go_on()?;
        let name = PartName { bake: job.bake, round: round.number, chunk };
        if let Some(part) = folder.and_then(|folder| folder.part(name)) {
            resumed.fetch_add(1, Ordering::Relaxed);
            return Ok(part);
        }
        let bytes = bake_chunk(job, round, chunk, below, lowest_m)?;
        job.go_on()?;
        match folder {
            Some(folder) => folder.write(name, &bytes),
            None => Part::in_memory(bytes).ok_or_else(|| PyramidError::Mismatch {
                path: job.out.to_owned(),
                cause: "a part of the bake reads back damaged".into(),
            }),
        }
    };
    let work = || {
        loop {
            let i = next.fetch_add(1, Ordering::Relaxed);
            // The locked values are consistent between statements, so a poisoned lock is harmless.
            if i >= chunks.len() || failed.lock().unwrap_or_else(PoisonError::into_inner).is_some() {
                return;
            }
            match one(chunks[i]) {
                Ok(part) => {
                    parts.lock().unwrap_or_else(PoisonError::into_inner)[i] = Some(part);
                    let done = finished.fetch_add(1, Ordering::Relaxed) + 1;
                    progress.report(what, done as f32 / chunks.len() as f32);
                }
                Err(error) => {
                    failed.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
                }
            }
        }
    };
    let at_once = rayon::current_num_threads().div_ceil(THREADS_PER_CHUNK).max(2).min(chunks.len());
    progress.report(what, 0.0);
    if at_once <= 1 {
        work();
    } else {
        // Separate threads: a waiting rayon worker takes up other work, and would begin chunk after chunk.
        std::thread::scope(|scope| {
            for _ in 0..at_once {
                scope.spawn(work);
            }
        });
    }
    if let Some(error) = failed.into_inner().unwrap_or_else(PoisonError::into_inner) {
        return Err(error);
    }
    let parts = parts.into_inner().unwrap_or_else(PoisonError::into_inner).into_iter().flatten().collect();
    Ok((parts, resumed.into_inner() as u64))
}
