//! The sweep over the tiles of a DEM, one row of tiles after the other.
//!
//! Between two rows of tiles, the forest of everything above is in memory, with the label of each sample of the border
//! between them. Each sample that two tiles share connects the two nodes to which it belongs, at its own height.

use super::blocks::Blocks;
use super::forest::{Edge, Forest, NO_NODE, Reduced, reduce};
use super::ranking::Ranking;
use super::sample::{NO_DATA, Sample};
use super::tile::{Label, Side, TileArea, tile_forest};
use super::{Heights, Rules, read_land};

/// Largest number of samples along a tile, without the border that it shares.
const MOST_TILE_SIDE: usize = 8192;

/// How a DEM is divided into tiles.
struct Tiling {
    /// Number of columns and rows of the DEM.
    dem: [usize; 2],
    /// Distance of tiles, in samples.
    side: usize,
    wraps: bool,
    /// Number of columns and rows of tiles.
    count: [usize; 2],
}

impl Tiling {
    fn new(dem: [usize; 2], side: usize, wraps: bool) -> Self {
        let side = side.clamp(1, MOST_TILE_SIDE);
        // From the first sample to the last one; around the DEM, that is the first one again.
        let steps = [dem[0] - usize::from(!wraps), dem[1] - 1];
        Self { dem, side, wraps, count: steps.map(|steps| steps.div_ceil(side).max(1)) }
    }

    fn area(&self, tile: [usize; 2]) -> TileArea {
        let first = tile.map(|tile| tile * self.side);
        let ends = [self.dem[0] + usize::from(self.wraps), self.dem[1]];
        let size = [0, 1].map(|axis| (self.side + 1).min(ends[axis] - first[axis]));
        let is_last = [0, 1].map(|axis| tile[axis] + 1 == self.count[axis]);
        let is_shared = [tile[1] > 0, !is_last[1], self.wraps || tile[0] > 0, self.wraps || !is_last[0]];
        TileArea { first, size, dem: self.dem, is_shared }
    }
}

/// What is in memory while a row of tiles is added.
struct Strip {
    /// The forest of everything above, and then of the tiles of the row.
    forest: Forest,
    /// The samples of the border above, from the first column to the last one.
    above: Vec<Label>,
    /// The samples of the border below; empty after the last row.
    below: Vec<Label>,
    /// The right border of the tile that was added last, and the left one of the first tile.
    right: Vec<Label>,
    first_left: Vec<Label>,
}

/// Sweeps over a DEM, and collects its most prominent summits and the maxima of its blocks. Calls `progress` with the
/// part of the tiles that has been read; returns `false` if that does.
///
/// # Errors
/// The first heights that cannot be read.
pub(super) fn sweep<H: Heights>(
    heights: &mut H,
    rules: &Rules,
    wraps: bool,
    ranking: &mut Ranking,
    blocks: &mut Blocks,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Result<bool, H::Error> {
    let tiling = Tiling::new(heights.size(), rules.tile, wraps);
    let [columns, rows] = tiling.count;
    let (mut forest, mut front) = (Forest::default(), Vec::new());
    let mut heights_m = Vec::new();
    for row in 0..rows {
        let (right, first_left) = (Vec::new(), Vec::new());
        let mut strip = Strip { forest, above: front, below: Vec::new(), right, first_left };
        for column in 0..columns {
            let area = tiling.area([column, row]);
            read_tile(heights, area, &mut heights_m)?;
            for (line, heights_m) in heights_m.chunks_exact(area.size[0]).enumerate() {
                blocks.add_row([area.first[0], area.first[1] + line], heights_m);
            }
            strip.add(area, &heights_m, rules.has_open_gaps, ranking);
            if !progress((row * columns + column + 1) as f64 / (rows * columns) as f64) {
                return Ok(false);
            }
        }
        (forest, front) = strip.finish(&tiling, row, ranking);
    }
    Ok(true)
}

/// Reads the heights of a tile, row by row.
fn read_tile<H: Heights>(heights: &mut H, area: TileArea, into: &mut Vec<f32>) -> Result<(), H::Error> {
    let TileArea { first, size, dem, .. } = area;
    let columns = size[0].min(dem[0] - first[0]);
    read_land(heights, first, [columns, size[1]], into)?;
    if columns < size[0] {
        let mut start = Vec::new();
        read_land(heights, [0, first[1]], [1, size[1]], &mut start)?;
        let rows = into.chunks_exact(columns).zip(&start);
        *into = rows.flat_map(|(row, first)| row.iter().chain([first])).copied().collect();
    }
    Ok(())
}

impl Strip {
    /// Adds the next tile of the row.
    fn add(&mut self, area: TileArea, heights_m: &[f32], has_open_gaps: bool, ranking: &mut Ranking) {
        let mut tile = tile_forest(area, heights_m, has_open_gaps, ranking.threshold());
        tile.found.into_iter().for_each(|found| ranking.add(found));
        let start = self.forest.nodes.len() as u32;
        self.forest.nodes.append(&mut tile.forest.nodes);
        let moved = |edge: Edge| Edge { nodes: edge.nodes.map(|node| node + start), ..edge };
        self.forest.edges.extend(tile.forest.edges.into_iter().map(moved));
        for label in tile.sides.iter_mut().flatten().filter(|label| label.height != NO_DATA) {
            label.node += start;
        }
        let [top, bottom, left, right] = tile.sides;
        if !top.is_empty() {
            let columns = self.above[area.first[0]..].iter().chain(&self.above);
            let pairs = columns.zip(&top).map(|(above, own)| [above.node, own.node]);
            join(&mut self.forest.edges, area, Side::Top, &top, pairs);
        }
        if area.first[0] == 0 {
            self.first_left = left;
        } else {
            let pairs = self.right.iter().zip(&left).map(|(other, own)| [other.node, own.node]);
            join(&mut self.forest.edges, area, Side::Left, &left, pairs);
        }
        if area.first[0] + area.size[0] > area.dem[0] {
            // The last tile of a DEM that wraps.
            let pairs = right.iter().zip(&self.first_left).map(|(own, other)| [own.node, other.node]);
            join(&mut self.forest.edges, area, Side::Right, &right, pairs);
        }
        self.right = right;
        let known = self.below.len() - area.first[0].min(self.below.len());
        self.below.extend(bottom.into_iter().skip(known));
        self.below.truncate(area.dem[0]);
    }

    /// Reduces the forest after the last tile of the row. Returns it with the labels of the border below.
    fn finish(mut self, tiling: &Tiling, row: usize, ranking: &mut Ranking) -> (Forest, Vec<Label>) {
        let [columns, _] = tiling.dem;
        let first = ((row + 1) * tiling.side) as u64 * columns as u64;
        for (label, index) in self.below.iter().zip(first..).filter(|(label, _)| label.height != NO_DATA) {
            let front = &mut self.forest.nodes[label.node as usize].front;
            *front = (*front).max(Sample::new(label.height, index));
        }
        let Reduced { forest, renumbered, found } = reduce(self.forest, ranking.threshold());
        found.into_iter().for_each(|found| ranking.add(found));
        for label in self.below.iter_mut().filter(|label| label.height != NO_DATA) {
            label.node = renumbered[label.node as usize];
        }
        (forest, self.below)
    }
}

/// Connects the pairs of nodes to which the samples of a side belong. Of successive samples with the same pair, only
/// the highest one matters.
fn join(edges: &mut Vec<Edge>, area: TileArea, side: Side, labels: &[Label], pairs: impl Iterator<Item = [u32; 2]>) {
    let mut last = Edge { saddle: Sample::NONE, nodes: [NO_NODE; 2] };
    for ((along, label), nodes) in labels.iter().enumerate().zip(pairs) {
        let saddle = area.side_sample(side, along, label.height);
        if saddle == Sample::NONE {
            continue;
        }
        if nodes != last.nodes {
            edges.extend((last.saddle != Sample::NONE).then_some(last));
            last = Edge { saddle: Sample::NONE, nodes };
        }
        last.saddle = last.saddle.max(saddle);
    }
    edges.extend((last.saddle != Sample::NONE).then_some(last));
}
