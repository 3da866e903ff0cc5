//! Baking a chunk: from the heights of its base level to encoded tiles with measured errors.
//!
//! The levels are averaged, encoded, and decoded again, so that the measured errors are those of the heights that
//! readers will get, after all losses of the codec.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::below::{Below, Ground, read_heights, read_parts};
use super::deferred::Deferred;
use super::part::{self, Contents, Grids, PartName, TileEntry};
use super::plan::{Chunk, Plan, Regions, Round, own_vertices};
use super::tile_error::{Base, LevelView, against_base, against_heights, tile_statistics};
use super::vertices::{Vertices, for_children};
use super::{codec, mesh_error};
use crate::file::atomic::Readers;
use crate::pyramid::error::PyramidError;
use crate::pyramid::format::encode::{Codec, padded_tile};
use crate::pyramid::format::record::{self, page_bytes};
use crate::pyramid::surface::field::{Field, Fields};
use crate::pyramid::surface::fill::read_filled;
use crate::pyramid::surface::levels::{LevelSize, Region};
use crate::pyramid::surface::overview;
use crate::pyramid::surface::statistics::{PAGE_PATCHES, PatchStatistics, Range, TileStatistics, patch_levels};

/// Number of rows whose no-data is filled together.
const STRIP: u32 = 64;

/// The parameters that all chunks of a bake share.
pub(super) struct Job<'a> {
    /// The division of the bake into rounds and chunks.
    pub plan: Plan,
    /// The compression of heights.
    pub codec: Codec,
    /// Whether tiles are encoded. Otherwise the parts have only statistics, and heights are taken to be stored as they
    /// are; the codec is then lossless.
    pub encodes: bool,
    /// The path of the pyramid, for messages.
    pub out: &'a Path,
    /// The users who may read the files.
    pub readers: Readers,
    /// The identity of the bake: a hash of the heights, options and version.
    pub bake: u64,
    /// Set from another thread to stop the bake; checked between the steps of a chunk.
    pub stop: &'a AtomicBool,
    /// Called with the name of each stage of a chunk.
    pub stage: &'a (dyn Fn(&str) + Sync),
}

impl Job<'_> {
    /// Returns an error once the bake has been asked to stop.
    pub(super) fn go_on(&self) -> Result<(), PyramidError> {
        if self.stop.load(Ordering::Relaxed) { Err(PyramidError::Stopped) } else { Ok(()) }
    }

    fn is_whole(&self, round: Round) -> bool {
        round.number == 0 && round.last && self.plan.chunk_counts(round) == (1, 1)
    }
}

/// A chunk that is being baked, with the regions of each level that it needs.
struct Work<'a> {
    job: &'a Job<'a>,
    round: Round,
    chunk: Chunk,
    regions: Vec<Regions>,
}

/// Bakes a chunk and returns the bytes of its part. `lowest_m` is the lowest stored height of level 0, if it is known.
pub(super) fn bake_chunk(
    job: &Job<'_>,
    round: Round,
    chunk: Chunk,
    below: Below<'_>,
    lowest_m: f32,
) -> Result<Vec<u8>, PyramidError> {
    job.go_on()?;
    let regions = job.plan.regions(round, chunk);
    let work = Work { job, round, chunk, regions };
    let (base, ground) = match below {
        Below::Heights(reader) => (read_heights(reader, work.regions[0].raw)?, None),
        Below::Parts(before, parts) => {
            let (base, ground) = read_parts(&job.plan, round, chunk, (before, parts), work.regions[0].raw)?;
            (base, Some(ground))
        }
    };
    work.bake(base, ground, lowest_m)
}

impl Work<'_> {
    fn level_size(&self, i: usize) -> LevelSize {
        self.job.plan.sizes[self.round.base + i]
    }

    fn bake(&self, base: Field, mut ground: Option<Ground>, lowest_m: f32) -> Result<Vec<u8>, PyramidError> {
        let (job, round) = (self.job, self.round);
        (job.stage)("levels");
        let mut raw = vec![base];
        for i in 1..self.regions.len() {
            job.go_on()?;
            let (fine, coarse) = (self.level_size(i - 1), self.level_size(i));
            raw.push(overview::next_level(&raw[i - 1], fine, coarse, self.regions[i].raw));
        }
        (job.stage)("encoding");
        let made = round.first_made() - round.base;
        let mut encoded = Vec::new();
        let mut stored: Vec<Option<Field>> = vec![ground.as_mut().and_then(|ground| ground.stored.take())];
        stored.truncate(made);
        for (i, level) in raw.iter().enumerate().skip(made) {
            if !job.encodes {
                let tiles = job.plan.own_tiles(round, self.chunk, round.base + i).samples();
                encoded.resize(encoded.len() + tiles, Vec::new());
                stored.push(None);
                continue;
            }
            let tiles = self.encode(i, level)?;
            stored.push(self.decode(i, level, &tiles)?);
            encoded.extend(tiles);
        }
        let own = self.regions[0].own;
        let stored_base = stored[0].as_ref().unwrap_or(&raw[0]);
        let void_samples = count_voids(&raw[0], own);
        let fallback_m = match round.last {
            true if round.number == 0 => lowest(stored_base, own),
            true => lowest_m,
            false => f32::NAN,
        };
        let served = {
            let fields: Vec<&Field> =
                stored.iter().zip(&raw).map(|(stored, raw)| stored.as_ref().unwrap_or(raw)).collect();
            (0..raw.len()).map(|i| self.fill(i, &fields, fallback_m)).collect::<Result<Vec<_>, _>>()?
        };
        let top = raw.len() - 1;
        let mut grids = Grids::default();
        if !round.last {
            let own = self.regions[top].own;
            grids.raw_m = raw[top].cut(own);
            grids.stored_m = stored[top].as_ref().map(|stored| stored.cut(own)).unwrap_or_default();
        }
        drop(stored);

        let doubt_m = self.doubt_m(&raw[0]);
        let views: Vec<LevelView<'_>> =
            served.iter().enumerate().map(|(i, served)| self.view(i, served, doubt_m)).collect();
        (job.stage)("tile errors");
        let (tiles, deferred) = self.tiles(&raw[0], &views, ground.as_ref())?;
        (job.stage)("mesh errors");
        job.go_on()?;
        let patches = self.patches(&raw[0], &views[0], ground.as_ref(), &mut grids);
        let pages = self.pages(&tiles, &patches);

        let entries = tiles.iter().flatten().zip(&encoded).map(|(&statistics, bytes)| TileEntry {
            bytes: bytes.len() as u32,
            checksum: record::checksum(bytes),
            statistics,
        });
        let mut range = Range::EMPTY;
        if round.number == 0 {
            for y in own.y..own.y + own.height {
                range.add(served[0].span(own.x, y, own.width));
            }
        }
        let contents = Contents {
            range_m: [range.min_m, range.max_m],
            void_samples,
            tiles: entries.collect(),
            deferred,
            coarse_patches: patches.into_iter().skip(if round.last { top + 1 } else { usize::MAX }).collect(),
        };
        let name = PartName { bake: job.bake, round: round.number, chunk: self.chunk };
        Ok(part::to_bytes(name, &contents, &grids, &pages, &encoded))
    }

    fn view<'a>(&self, i: usize, served: &'a Field, doubt_m: f64) -> LevelView<'a> {
        let level = (self.round.base + i) as u32;
        LevelView { level, size: self.level_size(i), own: self.regions[i].own, served, doubt_m }
    }

    /// Returns the largest possible difference, in metres, between heights outside the chunk and their stored values:
    /// the codec's bound, plus rounding.
    fn doubt_m(&self, base: &Field) -> f64 {
        match self.job.codec {
            Codec::WithinMetres(bound_m) if !self.job.is_whole(self.round) => {
                let largest = base.heights_m.iter().fold(0.0_f32, |largest, height| largest.max(height.abs()));
                bound_m + f64::from(largest) * 4.0 * f64::from(f32::EPSILON)
            }
            _ => 0.0,
        }
    }

    /// Encodes the chunk's own tiles of a level, row-major.
    fn encode(&self, i: usize, level: &Field) -> Result<Vec<Vec<u8>>, PyramidError> {
        let tiles = self.job.plan.own_tiles(self.round, self.chunk, self.round.base + i);
        let size = self.level_size(i);
        (0..tiles.samples())
            .into_par_iter()
            .map(|tile| {
                self.job.go_on()?;
                let (x, y) = (tiles.x + tile as u32 % tiles.width, tiles.y + tile as u32 / tiles.width);
                let heights_m = padded_tile(&level.heights_m, level.region, size.tile_region(x, y, 0));
                self.job.codec.encode(&heights_m, tile).map_err(PyramidError::encode(self.job.out))
            })
            .collect()
    }

    /// Decodes a level as a reader of its tiles would, with the heights around them as they were. Returns `None` if
    /// nothing changed. With a lossless codec, any difference is an error.
    fn decode(&self, i: usize, level: &Field, tiles: &[Vec<u8>]) -> Result<Option<Field>, PyramidError> {
        self.job.go_on()?;
        let own = self.regions[i].own;
        let decoded = codec::decode(self.job.codec, own, tiles, self.job.out)?;
        let mut row_of = 0..own.height;
        let same = |(a, b): (&f32, &f32)| match self.job.codec {
            Codec::Lossless => a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan(),
            Codec::WithinMetres(_) => a.is_nan() == b.is_nan(),
        };
        let rows = decoded.chunks_exact(own.width as usize);
        if !rows.zip(&mut row_of).all(|(row, y)| row.iter().zip(level.span(own.x, own.y + y, own.width)).all(same)) {
            let cause = format!("level {} differs when it is read back", self.round.base + i);
            return Err(PyramidError::Mismatch { path: self.job.out.to_owned(), cause });
        }
        if self.job.codec == Codec::Lossless {
            return Ok(None);
        }
        let mut stored = level.clone();
        stored.paste(own, &decoded);
        Ok(Some(stored))
    }

    /// Returns a level as its tiles serve it, with filled no-data, over the region where it is needed.
    fn fill(&self, i: usize, fields: &[&Field], fallback_m: f32) -> Result<Field, PyramidError> {
        self.job.go_on()?;
        let region = self.regions[i].served;
        let sizes = &self.job.plan.sizes[self.round.base..self.round.top + 1];
        let mut heights_m = vec![0.0; region.samples()];
        let strips = heights_m.par_chunks_mut((STRIP * region.width) as usize).enumerate();
        strips.try_for_each(|(strip, out)| {
            let y = region.y + strip as u32 * STRIP;
            let height = out.len() as u32 / region.width;
            let filled = read_filled(&Fields { sizes, fields }, i, Region { y, height, ..region }, fallback_m)?;
            out.copy_from_slice(&filled);
            Ok::<_, PyramidError>(())
        })?;
        Ok(Field { region, heights_m })
    }

    /// Measures the tiles of each level that the round makes, row-major; errors and ranges include those of a tile's
    /// children.
    fn tiles(
        &self,
        base: &Field,
        views: &[LevelView<'_>],
        ground: Option<&Ground>,
    ) -> Result<(Vec<Vec<TileStatistics>>, Vec<Deferred>), PyramidError> {
        let finest = self.job.plan.sizes[0];
        let mut all = Vec::new();
        let mut put_off = Vec::new();
        let mut below: Option<(Vec<TileStatistics>, Region)> = None;
        let measured = match ground {
            None => {
                let measure = |view| self.job.go_on().map(|()| against_heights(base, finest, view));
                views.iter().map(measure).collect::<Result<Vec<_>, _>>()?
            }
            Some(ground) => {
                below = Some((ground.tiles.clone(), ground.tiles_region));
                let step = 1_u32 << self.round.base;
                let has_data = |x: u32, y: u32| has_data(&ground.vertices, finest, step, x, y);
                let view = LevelView { served: views[0].served, ..views[0] };
                let errors_m = ground.tiles.iter().map(|tile| tile.error_m).collect();
                let base = Base { view, errors_m, error_tiles: ground.tiles_region, data: &has_data, data_step: step };
                against_base(&base, finest, &views[1..])
            }
        };
        let made = views.len() - measured.len();
        for (view, (errors_m, deferred)) in views[made..].iter().zip(measured) {
            let mut tiles = tile_statistics(view, &errors_m);
            put_off.extend(deferred);
            let here = view.tiles();
            if let Some((children, region)) = &below {
                for (i, tile) in tiles.iter_mut().enumerate() {
                    let place = (here.x + i as u32 % here.width, here.y + i as u32 / here.width);
                    for_children(place, *region, |child| {
                        let child = &children[child];
                        tile.error_m = tile.error_m.max(child.error_m);
                        tile.min_m = tile.min_m.min(child.min_m);
                        tile.max_m = tile.max_m.max(child.max_m);
                    });
                }
            }
            below = Some((tiles.clone(), here));
            all.push(tiles);
        }
        Ok((all, put_off))
    }

    /// Measures the patches of each stride that the round makes, by level from the round's base (included), row-major;
    /// in the last round all coarser strides too. Stores the input of the next round in `grids`.
    fn patches(
        &self,
        base: &Field,
        view: &LevelView<'_>,
        ground: Option<&Ground>,
        grids: &mut Grids,
    ) -> Vec<Vec<PatchStatistics>> {
        let (plan, round) = (&self.job.plan, self.round);
        let finest = plan.sizes[0];
        let region = |level| plan.own_patches(round, self.chunk, level);
        let first = match ground {
            None => mesh_error::finest_patches(view, region(0)),
            Some(ground) => ground.patches.clone(),
        };
        let vertices = Vertices {
            finest,
            step: 1 << round.base,
            field: ground.map_or(base, |ground| &ground.vertices),
            served: ground.is_none().then_some(view.served),
            reach: 1 << plan.chunk_levels,
        };
        let mut under_m: Vec<f32> = match ground {
            None => vec![0.0; first.len()],
            Some(_) => first.iter().map(|patch| patch.mesh_error_m).collect(),
        };
        let mut all = vec![first];
        let end = if round.last { patch_levels(finest) as usize } else { round.top + 1 };
        for level in round.base + 1..end {
            let (here, below) = (region(level), region(level - 1));
            under_m = (0..here.samples() as u32)
                .map(|i| {
                    let mut worst_m = 0.0_f32;
                    let place = (here.x + i % here.width, here.y + i / here.width);
                    for_children(place, below, |child| worst_m = worst_m.max(under_m[child]));
                    worst_m
                })
                .collect();
            let d = (level - round.base) as u32;
            let patches = vertices.patches(d, here, (&all[all.len() - 1], below), &under_m);
            all.push(patches);
        }
        if !round.last {
            let levels = (round.top - round.base) as u32;
            grids.vertices_m = vertices.decimated(levels, own_vertices(plan, round, self.chunk)).heights_m;
            grids.patches.clone_from(&all[all.len() - 1]);
        }
        all
    }

    /// Encodes the pages of all tiles that are made, as records contain them.
    fn pages(&self, tiles: &[Vec<TileStatistics>], patches: &[Vec<PatchStatistics>]) -> Vec<Vec<u8>> {
        let (plan, round) = (&self.job.plan, self.round);
        let mut pages = Vec::new();
        for (tiles, level) in tiles.iter().zip(round.first_made()..) {
            let here = plan.own_tiles(round, self.chunk, level);
            let region = plan.own_patches(round, self.chunk, level);
            let patches = patches.get(level - round.base).map_or(&[][..], |patches| &patches[..]);
            for (i, tile) in (0..).zip(tiles) {
                let (x, y) = ((here.x + i % here.width) * PAGE_PATCHES, (here.y + i / here.width) * PAGE_PATCHES);
                let patch = |j: u32| {
                    let (x, y) = (x + j % PAGE_PATCHES, y + j / PAGE_PATCHES);
                    let inside = (region.x..region.x + region.width).contains(&x)
                        && (region.y..region.y + region.height).contains(&y);
                    let index = || ((y - region.y) * region.width + x - region.x) as usize;
                    inside.then(|| patches.get(index()).copied()).flatten()
                };
                let page: Vec<Option<PatchStatistics>> = (0..PAGE_PATCHES * PAGE_PATCHES).map(patch).collect();
                pages.push(page_bytes(&page, [tile.min_m, tile.max_m]));
            }
        }
        pages
    }
}

/// Returns whether a sample of full resolution may have data: all corners of its quad of vertices are known.
fn has_data(vertices: &Field, finest: LevelSize, step: u32, x: u32, y: u32) -> bool {
    let quad = |at: u32, samples: u32| (at / step).min((samples - 1).div_ceil(step).saturating_sub(1));
    let (x, y) = (quad(x, finest.width), quad(y, finest.height));
    [(0, 0), (1, 0), (0, 1), (1, 1)]
        .iter()
        .all(|(i, k)| vertices.has(x + i, y + k) && !vertices.at(x + i, y + k).is_nan())
}

/// Returns the lowest stored height of a region; see [`read_filled`].
fn lowest(field: &Field, region: Region) -> f32 {
    let rows = region.y..region.y + region.height;
    rows.flat_map(|y| field.span(region.x, y, region.width)).copied().fold(f32::NAN, f32::min)
}

fn count_voids(field: &Field, region: Region) -> u64 {
    let rows = region.y..region.y + region.height;
    rows.flat_map(|y| field.span(region.x, y, region.width)).filter(|height| height.is_nan()).count() as u64
}
