//! The input of a chunk: a window of the heights, or the grids of the round before.

use super::part::{Grids, Part};
use super::plan::{Chunk, Plan, Round, Steps, own_vertices};
use crate::pyramid::error::PyramidError;
use crate::pyramid::surface::field::Field;
use crate::pyramid::surface::levels::{LevelSize, Region};
use crate::pyramid::surface::statistics::{PatchPage, PatchStatistics, TileStatistics};
use crate::pyramid::tile::TILE_SAMPLES;
use crate::source::HeightReader;

/// The input of a round.
#[derive(Clone, Copy)]
pub(super) enum Below<'a> {
    /// The heights that are baked, in the first round.
    Heights(&'a dyn HeightReader),
    /// The round before and its parts, row by row, in a later round.
    Parts(Round, &'a [Part]),
}

/// The data of a later round's base level, besides its heights.
pub(super) struct Ground {
    /// The heights of the base level as stored; `None` if they equal the averaged heights.
    pub stored: Option<Field>,
    /// The statistics of the base level's tiles in `tiles_region`, row-major.
    pub tiles: Vec<TileStatistics>,
    /// The region of `tiles`, in tiles, not samples.
    pub tiles_region: Region,
    /// The vertices of the patches that have the base level's stride.
    pub vertices: Field,
    /// The patches of the base level's stride over the chunk, row-major.
    pub patches: Vec<PatchStatistics>,
}

/// Reads heights. Infinite heights become no-data.
pub(super) fn read_heights(reader: &dyn HeightReader, region: Region) -> Result<Field, PyramidError> {
    let mut heights_m = reader.read(region).map_err(|error| PyramidError::Load(Box::new(error)))?;
    if heights_m.len() != region.samples() {
        let cause = format!("{} heights for {} × {} samples", heights_m.len(), region.width, region.height);
        return Err(PyramidError::BadGrid { path: "the source".into(), cause });
    }
    for height in heights_m.iter_mut().filter(|height| height.is_infinite()) {
        *height = f32::NAN;
    }
    Ok(Field { region, heights_m })
}

fn meet(a: Region, b: Region) -> Option<Region> {
    let (x, y) = (a.x.max(b.x), a.y.max(b.y));
    let right = (a.x + a.width).min(b.x + b.width);
    let bottom = (a.y + a.height).min(b.y + b.height);
    (x < right && y < bottom).then(|| Region { x, y, width: right - x, height: bottom - y })
}

/// A field that is assembled from the fields of parts.
struct Mosaic(Field);

impl Mosaic {
    fn new(region: Region) -> Self {
        Self(Field { region, heights_m: vec![f32::NAN; region.samples()] })
    }

    fn add(&mut self, region: Region, heights_m: Vec<f32>) {
        if heights_m.len() != region.samples() {
            return;
        }
        if let Some(common) = meet(region, self.0.region) {
            self.0.paste(common, &Field { region, heights_m }.cut(common));
        }
    }
}

/// Reads the base level of a later round over a chunk. Returns its averaged heights in `raw`, and the other data.
pub(super) fn read_parts(
    plan: &Plan,
    round: Round,
    chunk: Chunk,
    (before, parts): (Round, &[Part]),
    raw: Region,
) -> Result<(Field, Ground), PyramidError> {
    let size = plan.sizes[round.base];
    let finest = plan.sizes[0];
    let own = plan.own_tiles(round, chunk, round.base);
    let counts = plan.chunk_counts(before);
    let tiles_region = own.grown(1, LevelSize { width: size.tiles_x(), height: size.tiles_y() });
    let reach = 1 << plan.chunk_levels;
    let vertices = {
        let count = |samples| Steps { samples, step: 1 << round.base }.count();
        let counts = LevelSize { width: count(finest.width), height: count(finest.height) };
        let side = TILE_SAMPLES;
        let span = |first: u32, tiles: u32, count: u32| {
            let start = (first * side).min(count - 1);
            (start, ((first + tiles) * side + 1).min(count) - start)
        };
        let ((x, width), (y, height)) = (span(own.x, own.width, counts.width), span(own.y, own.height, counts.height));
        Region { x, y, width, height }.grown(reach + 1, counts)
    };
    let patches_region = plan.own_patches(round, chunk, round.base);
    let mut mosaics = [Mosaic::new(raw), Mosaic::new(raw), Mosaic::new(vertices)];
    let mut patches = vec![PatchPage::NOTHING; patches_region.samples()];
    let mut tiles = Vec::new();
    let mut is_lossy = false;
    for y in tiles_region.y..tiles_region.y + tiles_region.height {
        for x in tiles_region.x..tiles_region.x + tiles_region.width {
            let part = &parts[(y * counts.0 + x) as usize];
            tiles.extend(part.contents.tiles.last().map(|tile| tile.statistics));
            let chunk = Chunk { x, y };
            let Grids { raw_m, stored_m, vertices_m, patches: page } = part.grids()?;
            let samples = plan.own_samples(before, chunk, before.top);
            is_lossy |= !stored_m.is_empty();
            mosaics[0].add(samples, raw_m);
            mosaics[1].add(samples, stored_m);
            mosaics[2].add(own_vertices(plan, before, chunk), vertices_m);
            let theirs = plan.own_patches(before, chunk, before.top);
            if let Some(common) = meet(theirs, patches_region) {
                for (row, column) in (common.y..common.y + common.height)
                    .flat_map(|row| (common.x..common.x + common.width).map(move |column| (row, column)))
                {
                    let from = (row - theirs.y) * theirs.width + column - theirs.x;
                    let to = (row - patches_region.y) * patches_region.width + column - patches_region.x;
                    if let Some(patch) = page.get(from as usize) {
                        patches[to as usize] = *patch;
                    }
                }
            }
        }
    }
    let [raw, stored, vertices] = mosaics.map(|mosaic| mosaic.0);
    let stored = is_lossy.then_some(stored);
    Ok((raw, Ground { stored, tiles, tiles_region, vertices, patches }))
}
