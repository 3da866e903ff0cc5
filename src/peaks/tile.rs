//! One tile: its summits, and how they are connected within the tile.
//!
//! Each sample climbs to its highest neighbour, and so to a summit. From a sample one reaches its summit without
//! descending, so summits are connected exactly as the samples that climb to them are. Where one may have to descend on
//! the way from one summit to another, all higher neighbours of the lowest sample aren't connected with each other
//! around it. Only such samples, the possible saddles, are sorted: a few per cent of natural land.

use super::forest::{Edge, Forest, Found, Node, Reduced, Threshold, reduce};
use super::sample::{NO_DATA, Sample, ordered};

/// Steps to the eight neighbours, in columns and rows, around the sample. Those with even indices share an edge with
/// it.
const AROUND: [[isize; 2]; 8] = [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]];
/// For each set of neighbours, one of each group whose members are neighbours of each other.
const ONE_PER_GROUP: [u8; 256] = {
    let mut table = [0; 256];
    let mut set = 0;
    while set < 256 {
        table[set] = one_per_group(set as u8);
        set += 1;
    }
    table
};
/// Marks a summit in [`Climbs`]; the other bits are the number of its node.
const SUMMIT: u32 = 1 << 31;

/// The position of a tile on the DEM. Neighbouring tiles share the samples on their common border, so each two samples
/// that are neighbours are in a tile together.
#[derive(Clone, Copy, Debug)]
pub(super) struct TileArea {
    /// First column and row.
    pub first: [usize; 2],
    /// Number of columns and rows. The last column of a DEM that wraps is followed by column 0.
    pub size: [usize; 2],
    /// Number of columns and rows of the DEM.
    pub dem: [usize; 2],
    /// Whether the tile shares its upper, lower, left and right border with another tile (see [`Side`]).
    pub is_shared: [bool; 4],
}

/// A border of a tile, as an index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Top,
    Bottom,
    Left,
    Right,
}

impl Side {
    pub(super) const ALL: [Self; 4] = [Self::Top, Self::Bottom, Self::Left, Self::Right];
}

/// How a sample on the border of a tile is connected with the tile.
#[derive(Clone, Copy, Debug)]
pub(super) struct Label {
    /// The ordered height.
    pub height: u32,
    /// The node to which one can climb, or which is as good; unused for [`NO_DATA`].
    pub node: u32,
}

/// What the rest of the DEM needs to know about a tile.
pub(super) struct TileForest {
    pub forest: Forest,
    /// The samples of each [`Side`]; empty for those that aren't shared.
    pub sides: [Vec<Label>; 4],
    /// The summits that have ended in the tile.
    pub found: Vec<Found>,
}

/// Computes the forest of a tile from its heights in metres, row by row. With `has_open_gaps`, land may continue in
/// samples without data. The samples on the shared sides are the front of the tile: they are its only ways out.
pub(super) fn tile_forest(area: TileArea, heights_m: &[f32], has_open_gaps: bool, threshold: Threshold) -> TileForest {
    let (mut forest, mut sides) = whole_forest(area, heights_m, has_open_gaps);
    mark_front(&mut forest, &sides, area);
    let Reduced { forest, renumbered, found } = reduce(forest, threshold);
    for label in sides.iter_mut().flatten().filter(|label| label.height != NO_DATA) {
        label.node = renumbered[label.node as usize];
    }
    TileForest { forest, sides, found }
}

/// Computes the forest of all summits and possible saddles of a tile, and the labels of its shared sides.
pub(super) fn whole_forest(area: TileArea, heights_m: &[f32], has_open_gaps: bool) -> (Forest, [Vec<Label>; 4]) {
    let grid = Grid::new(area, heights_m);
    let Landforms { mut climbs, summits, hollows, saddles } = grid.landforms();
    let mut nodes: Vec<Node> = summits.iter().map(|at| grid.node(*at)).collect();
    for at in hollows {
        let lowest = &mut nodes[climbs.node(at) as usize].lowest;
        *lowest = (*lowest).min(grid.height(at));
    }
    for at in grid.open_samples(has_open_gaps) {
        let open = &mut nodes[climbs.node(at) as usize].open;
        *open = (*open).max(grid.sample(at));
    }
    let mut edges = Vec::new();
    for (at, ways) in saddles {
        let mut way_to = (0..8).filter(|way| ways >> way & 1 == 1).map(|way| climbs.node(grid.neighbour(at, way)));
        let Some(one) = way_to.next() else { continue };
        let saddle = grid.sample(at);
        edges.extend(way_to.filter(|other| *other != one).map(|other| Edge { saddle, nodes: [one, other] }));
    }
    let mut labels = |side: Side| -> Vec<Label> {
        let samples = if area.is_shared[side as usize] { grid.side(side) } else { Vec::new() };
        let label = |at: u32| match grid.height(at) {
            NO_DATA => Label { height: NO_DATA, node: 0 },
            height => Label { height, node: climbs.node(at) },
        };
        samples.into_iter().map(label).collect()
    };
    (Forest { nodes, edges }, Side::ALL.map(&mut labels))
}

/// Marks the samples of the shared sides as the front.
fn mark_front(forest: &mut Forest, sides: &[Vec<Label>; 4], area: TileArea) {
    for (side, labels) in Side::ALL.into_iter().zip(sides) {
        for (along, label) in labels.iter().enumerate().filter(|(_, label)| label.height != NO_DATA) {
            let front = &mut forest.nodes[label.node as usize].front;
            *front = (*front).max(area.side_sample(side, along, label.height));
        }
    }
}

impl TileArea {
    /// Returns the sample with an ordered height at a column and a row of the tile.
    fn sample(&self, at: [usize; 2], height: u32) -> Sample {
        let [columns, _] = self.dem;
        let column = (self.first[0] + at[0]) % columns;
        Sample::new(height, (self.first[1] + at[1]) as u64 * columns as u64 + column as u64)
    }

    /// Returns the sample with an ordered height at a position along a side.
    pub(super) fn side_sample(&self, side: Side, along: usize, height: u32) -> Sample {
        let [right, bottom] = self.size.map(|side| side - 1);
        let at = match side {
            Side::Top => [along, 0],
            Side::Bottom => [along, bottom],
            Side::Left => [0, along],
            Side::Right => [right, along],
        };
        self.sample(at, height)
    }
}

/// The samples of a tile with a margin of one sample without data. Samples have the index of the grid with its margin.
struct Grid {
    area: TileArea,
    /// Columns with the margin.
    stride: usize,
    /// The ordered height in the upper half, the complement of the place in row order in the lower half; 0 for no data.
    keys: Vec<u64>,
    has_gaps: bool,
}

/// The samples of a tile that matter, and how the others climb.
struct Landforms {
    climbs: Climbs,
    summits: Vec<u32>,
    /// The samples without lower neighbours.
    hollows: Vec<u32>,
    /// Possible saddles, and one neighbour in each of the groups of their higher neighbours.
    saddles: Vec<(u32, u8)>,
}

/// The highest neighbour of each sample, or a later sample on the way to its summit; for a summit, [`SUMMIT`] and its
/// number.
struct Climbs(Vec<u32>);

impl Grid {
    fn new(area: TileArea, heights_m: &[f32]) -> Self {
        let [columns, rows] = area.size;
        let stride = columns + 2;
        let mut keys = vec![0; stride * (rows + 2)];
        let mut has_gaps = false;
        // Column 0 of a DEM that wraps can be the last column of a tile, but is the first one in row order.
        let rotation = usize::from(area.first[0] + columns > area.dem[0]);
        let mut order = u32::MAX;
        for (row, heights_m) in heights_m.chunks_exact(columns).enumerate() {
            let start = (row + 1) * stride + 1;
            for (place, height_m) in heights_m.iter().enumerate() {
                let height = ordered(*height_m);
                let turn = if place + rotation == columns { 0 } else { place + rotation };
                let key = u64::from(height) << 32 | u64::from(order - turn as u32);
                keys[start + place] = if height == NO_DATA { 0 } else { key };
                has_gaps |= height == NO_DATA;
            }
            order -= columns as u32;
        }
        Self { area, stride, keys, has_gaps }
    }

    fn height(&self, at: u32) -> u32 {
        (self.keys[at as usize] >> 32) as u32
    }

    fn sample(&self, at: u32) -> Sample {
        let [column, row] = [at as usize % self.stride, at as usize / self.stride];
        self.area.sample([column - 1, row - 1], self.height(at))
    }

    /// Returns the index of a neighbour.
    fn neighbour(&self, at: u32, way: usize) -> u32 {
        let [x, y] = AROUND[way];
        (at as usize).wrapping_add_signed(y * self.stride as isize + x) as u32
    }

    fn node(&self, summit: u32) -> Node {
        Node { peak: self.sample(summit), front: Sample::NONE, open: Sample::NONE, lowest: u32::MAX }
    }

    /// Returns the samples of a side.
    fn side(&self, side: Side) -> Vec<u32> {
        let [columns, rows] = self.area.size;
        let at = |column: usize, row: usize| ((row + 1) * self.stride + column + 1) as u32;
        match side {
            Side::Top => (0..columns).map(|column| at(column, 0)).collect(),
            Side::Bottom => (0..columns).map(|column| at(column, rows - 1)).collect(),
            Side::Left => (0..rows).map(|row| at(0, row)).collect(),
            Side::Right => (0..rows).map(|row| at(columns - 1, row)).collect(),
        }
    }

    /// Returns the samples of the land that are on the border of the DEM and, with `has_open_gaps`, those that have a
    /// neighbour without data in the tile. (Each other neighbour is in another tile together with the sample.)
    fn open_samples(&self, has_open_gaps: bool) -> Vec<u32> {
        let unshared = Side::ALL.into_iter().filter(|side| !self.area.is_shared[*side as usize]);
        let mut open: Vec<u32> = unshared.flat_map(|side| self.side(side)).collect();
        if has_open_gaps && self.has_gaps {
            let [columns, rows] = self.area.size;
            for row in 1..=rows {
                let gaps = (1..=columns).map(|column| (row * self.stride + column) as u32);
                for gap in gaps.filter(|at| self.keys[*at as usize] == 0) {
                    open.extend((0..8).map(|way| self.neighbour(gap, way)));
                }
            }
        }
        open.retain(|at| self.keys[*at as usize] != 0);
        open
    }

    /// Finds for each sample the highest neighbour, and lists summits, hollows and possible saddles.
    fn landforms(&self) -> Landforms {
        let [columns, rows] = self.area.size;
        let mut targets = vec![0; self.keys.len()];
        let (mut summits, mut hollows, mut saddles) = (Vec::new(), Vec::new(), Vec::new());
        let steps = AROUND.map(|[x, y]| y * self.stride as isize + x);
        for row in 1..=rows {
            let line = |row: usize| &self.keys[row * self.stride..][..columns + 2];
            let (above, here, below) = (line(row - 1), line(row), line(row + 1));
            for column in 1..=columns {
                let own = here[column];
                if own == 0 {
                    continue;
                }
                let (left, right) = (column - 1, column + 1);
                let around = [
                    here[right],
                    below[right],
                    below[column],
                    below[left],
                    here[left],
                    above[left],
                    above[column],
                    above[right],
                ];
                let (mut higher, mut not_lower, mut best, mut way) = (0_u8, 0_u8, own, 8);
                for (bit, key) in around.into_iter().enumerate() {
                    higher |= u8::from(key > own) << bit;
                    // A sample without data has key 0, which wraps to the largest number.
                    not_lower |= u8::from(key.wrapping_sub(1) >= own) << bit;
                    (best, way) = if key > best { (key, bit) } else { (best, way) };
                }
                let at = row * self.stride + column;
                if way == 8 {
                    targets[at] = SUMMIT | summits.len() as u32;
                    summits.push(at as u32);
                } else {
                    targets[at] = at.wrapping_add_signed(steps[way]) as u32;
                    let ways = ONE_PER_GROUP[usize::from(higher)];
                    if ways & (ways - 1) != 0 {
                        saddles.push((at as u32, ways));
                    }
                }
                if not_lower == u8::MAX {
                    hollows.push(at as u32);
                }
            }
        }
        Landforms { climbs: Climbs(targets), summits, hollows, saddles }
    }
}

impl Climbs {
    /// Returns the node of the summit to which a sample of the land climbs, and shortens the way (path halving).
    fn node(&mut self, mut at: u32) -> u32 {
        loop {
            let next = self.0[at as usize];
            if next & SUMMIT != 0 {
                return next & !SUMMIT;
            }
            let after = self.0[next as usize];
            if after & SUMMIT != 0 {
                return after & !SUMMIT;
            }
            self.0[at as usize] = after;
            at = after;
        }
    }
}

/// Returns one neighbour of each group of a set of neighbours. Successive neighbours are neighbours of each other, and
/// so are successive ones of those that share an edge with the sample.
const fn one_per_group(set: u8) -> u8 {
    let (mut rest, mut chosen) = (set, 0);
    while rest != 0 {
        let first = rest & rest.wrapping_neg();
        chosen |= first;
        let mut group = first;
        loop {
            let straight = group & 0b0101_0101;
            let reached = group | group.rotate_left(1) | group.rotate_right(1);
            let reached = (reached | straight.rotate_left(2) | straight.rotate_right(2)) & set;
            if reached == group {
                break;
            }
            group = reached;
        }
        rest &= !group;
    }
    chosen
}
