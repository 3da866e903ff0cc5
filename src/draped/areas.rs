//! Areas of map features, prepared for finding which of them a place is in.
//!
//! A square around the land is divided into four by four cells, and these again, until a cell has few edges. The edges of a
//! cell that is not divided are relative to a reference point in it, which is far from all edges, so that `f32` suffices.
//! For this point it is known how often each area winds around it; any other place in the cell is in the same areas, except
//! where the straight line to it crosses edges. A cell lists the areas that cover all of it; the cells in it do not list them
//! again.
//!
//! Positions are whole numbers of units, a power of two of a metre, from the south-west corner of the square.

use std::collections::VecDeque;

use glam::{DVec2, IVec2, UVec2};
use rustc_hash::FxHashMap;

use crate::gpu::wgsl::lines::draped::fill::{AreaCell, CELL_BITS, DIVIDED, EdgeOwner};

#[cfg(test)]
mod tests;

/// Largest number of edges of all areas.
pub(crate) const MOST_EDGES: usize = 1 << 21;
/// Largest number of cells, and of edges of all cells: no buffer has more than 128 MiB, which every GPU can bind.
const MOST_CELLS: usize = (1 << 22) - (1 << (2 * CELL_BITS));
const MOST_CELL_EDGES: usize = 1 << 22;
/// Number of edges of all cells for which there is always room.
const LEAST_ROOM: usize = 1 << 16;
/// Largest number of edges of a cell that is drawn: a pixel reads them all.
pub(crate) const MOST_OF_CELL: usize = 1 << 12;
/// For how many sizes of cells in a row edges may fail to separate.
const MOST_STUCK: u32 = 3;
/// Number of edges of a cell up to which it is not divided.
const FEW_EDGES: usize = 12;
/// Width of a cell with edges up to which it is not divided: `f32` then holds them to a few millimetres.
const WIDEST_M: f64 = 32_000.0;
/// Finest unit, in metres.
const FINEST_M: f64 = 1.0 / 1024.0;
/// Largest binary logarithm of the width of the square, in units, and smallest of a cell that is divided. Both are
/// multiples of [`CELL_BITS`].
const MOST_BITS: u32 = 30;
const LEAST_BITS: u32 = 6;
/// An edge belongs to a cell if it is within this part of the cell's width: places are rounded to units.
const OVERLAP: f64 = 1e-3;
/// Edges of a cell are cut off at this part of its width around it.
const KEPT: f64 = 0.25;
/// Places in a cell that may become its reference point, as parts of its width. They are on no simple grid.
const REFERENCES: [DVec2; 9] = [
    DVec2::new(0.5131, 0.4877),
    DVec2::new(0.2317, 0.2713),
    DVec2::new(0.7489, 0.2241),
    DVec2::new(0.2663, 0.7547),
    DVec2::new(0.7229, 0.7817),
    DVec2::new(0.5059, 0.1187),
    DVec2::new(0.1103, 0.5209),
    DVec2::new(0.8893, 0.4931),
    DVec2::new(0.4793, 0.9011),
];

/// The rings of an area, in metres of the world, east and north: outer rings counter-clockwise, holes clockwise. The last
/// place of a ring is not the first one again.
pub(super) struct AreaRings {
    /// Number of the area.
    pub area: u32,
    pub rings: Vec<Vec<DVec2>>,
}

/// The edges of areas in cells, as the GPU reads them (`shaders/lines/draped/fill.wgsl`).
pub(super) struct AreaTree {
    /// South-west corner of the square, in metres of the world.
    corner_m: DVec2,
    unit_m: f64,
    /// Binary logarithm of the width of the square, in units.
    pub root_bits: u32,
    /// The square first.
    pub cells: Vec<AreaCell>,
    pub edges: Vec<[f32; 4]>,
    /// The area of each edge, and how often it winds around the reference point of the cell.
    pub owners: Vec<EdgeOwner>,
    pub covers: Vec<u32>,
    /// Largest number of edges of a cell.
    pub most_edges: usize,
}

/// A piece of the border of an area, which is on its left; in metres of the world.
#[derive(Clone, Copy)]
struct Edge {
    begin_m: DVec2,
    end_m: DVec2,
    area: u32,
}

/// For each area, how often it winds around a place, if it does.
type Windings = Vec<(u32, i32)>;

/// A cell that is being built.
struct Square {
    corner: UVec2,
    bits: u32,
    /// A place in the cell or at its border, in metres of the world, and the windings around it of the areas of `edges`,
    /// and of areas that the cell, but not the one around it, is in.
    known_m: DVec2,
    windings: Windings,
    edges: Vec<Edge>,
    /// For how many sizes of cells in a row, up to this one, no part has had fewer edges than the whole.
    stuck: u32,
}

/// A part of a cell.
struct Part {
    corner: UVec2,
    /// A place in its middle, in metres of the world.
    middle_m: DVec2,
    edges: Vec<Edge>,
}

/// The cells that are left to do: their indices, and what is in them.
struct Squares {
    waiting: VecDeque<(usize, Square)>,
    room: Room,
}

/// How many edges cells may have altogether. An edge is in each cell that it touches.
struct Room {
    edges: usize,
    /// Number of edges of all cells so far, divided ones not counted.
    held: usize,
}

/// The position of a place of the world in an [`AreaTree`], or of the origin of a view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AreaPosition {
    /// Whole units from the corner of the square, modulo 2^32.
    pub units: IVec2,
    /// The rest, in metres.
    pub rest_m: DVec2,
}

impl AreaTree {
    /// Builds the cells of areas on land between two corners, in metres of the world. Returns `None` if no area has an edge.
    pub(super) fn new(areas: &[AreaRings], [low_m, high_m]: [DVec2; 2]) -> Option<Self> {
        let mut edges = Vec::new();
        for AreaRings { area, rings } in areas {
            for ring in rings {
                let places = || ring.iter().filter(|at_m| at_m.is_finite());
                let ends = places().cycle().skip(1);
                let of_ring = places().zip(ends).filter(|(begin, end)| begin != end);
                edges.extend(of_ring.map(|(&begin_m, &end_m)| Edge { begin_m, end_m, area: *area }));
            }
        }
        let around = |edge: &Edge| [edge.begin_m.min(edge.end_m), edge.begin_m.max(edge.end_m)];
        let [low_m, high_m] = edges
            .iter()
            .map(around)
            .fold([low_m, high_m], |[low_m, high_m], [low, high]| [low_m.min(low), high_m.max(high)]);
        if edges.is_empty() || !(low_m.is_finite() && high_m.is_finite()) {
            return None;
        }
        // Around all edges is a rim without any, so that the corner of the square is in no area.
        let width_m = (high_m - low_m).max_element().max(1.0) * 1.02;
        let mut unit_m = FINEST_M;
        while width_m > unit_m * f64::from(1_u32 << MOST_BITS) {
            unit_m *= 2.0;
        }
        let bits = (width_m / unit_m).log2().ceil() as u32;
        let root_bits = bits.next_multiple_of(CELL_BITS).clamp(CELL_BITS, MOST_BITS);
        let spare_m = 0.5 * (unit_m * f64::from(1_u32 << root_bits) - (high_m - low_m));
        let corner_m = ((low_m - spare_m) / unit_m).floor() * unit_m;
        let cells = vec![AreaCell::default()];
        let mut tree = Self {
            corner_m,
            unit_m,
            root_bits,
            cells,
            edges: Vec::new(),
            owners: Vec::new(),
            covers: Vec::new(),
            most_edges: 0,
        };
        let room = Room { edges: (16 * edges.len()).clamp(LEAST_ROOM, MOST_CELL_EDGES), held: edges.len() };
        let root = Square {
            corner: UVec2::ZERO,
            bits: root_bits,
            known_m: corner_m,
            windings: Windings::new(),
            edges,
            stuck: 0,
        };
        // Cells of one size after those of the next larger one, so that all of the land has equally small ones where there
        // is no room for more.
        let mut squares = Squares { waiting: VecDeque::from([(0_usize, root)]), room };
        while let Some((index, square)) = squares.waiting.pop_front() {
            tree.add(index, square, &mut squares);
        }
        tree.edges.shrink_to_fit();
        tree.owners.shrink_to_fit();
        Some(tree)
    }

    /// Returns the position of a place of the world.
    pub(super) fn position(&self, at_m: DVec2) -> AreaPosition {
        let from_m = at_m - self.corner_m;
        let whole = (from_m / self.unit_m).round();
        // The shader computes modulo 2^32.
        let units = IVec2::new(whole.x as i64 as i32, whole.y as i64 as i32);
        AreaPosition { units, rest_m: from_m - whole * self.unit_m }
    }

    /// Returns the length of a unit in metres.
    pub(super) fn unit_m(&self) -> f64 {
        self.unit_m
    }

    /// Fills in the cell of a square, or adds the squares in it to those that are left to do.
    fn add(&mut self, index: usize, square: Square, squares: &mut Squares) {
        let width_m = self.unit_m * f64::from(1_u32 << square.bits);
        let low_m = self.place_m(square.corner);
        let reference = self.reference(&square, low_m, width_m);
        let reference_m = self.place_m(reference);
        let windings = windings_at(reference_m, &square.windings, &square.edges, square.known_m);
        let is_fine = square.edges.is_empty() || square.edges.len() <= FEW_EDGES && width_m <= WIDEST_M;
        let parts = if is_fine || square.bits <= LEAST_BITS { None } else { self.parts(&square, &squares.room) };
        let Some((parts, stuck)) = parts else {
            self.fill(index, reference, reference_m, windings, &square, [low_m, low_m + width_m]);
            return;
        };
        // What has no edges here covers all of the cell.
        let mut has_edges: Vec<u32> = square.edges.iter().map(|edge| edge.area).collect();
        has_edges.sort_unstable();
        has_edges.dedup();
        let (inner, covers): (Windings, Windings) =
            windings.into_iter().partition(|(area, _)| has_edges.binary_search(area).is_ok());
        squares.room.held -= square.edges.len();
        let first = self.cells.len();
        self.cells.resize(first + parts.len(), AreaCell::default());
        let cell = self.cell_of(covers.iter().map(|(area, _)| *area), reference, first as u32, DIVIDED);
        self.set(index, cell);
        for (part, Part { corner, middle_m, edges }) in parts.into_iter().enumerate() {
            // The way to the middle of the part is within the cell, and so are all edges that it crosses.
            let windings = windings_at(middle_m, &inner, &square.edges, reference_m);
            squares.room.held += edges.len();
            let bits = square.bits - CELL_BITS;
            let part_of = Square { corner, bits, known_m: middle_m, windings, edges, stuck };
            squares.waiting.push_back((first + part, part_of));
        }
    }

    /// Returns the parts of a cell, in rows from the south-west, and for how many sizes of cells in a row no part has had
    /// fewer edges. `None` if there is no room for the parts, or if their edges do not separate: they coincide, or
    /// end at one place.
    fn parts(&self, square: &Square, room: &Room) -> Option<(Vec<Part>, u32)> {
        let bits = square.bits - CELL_BITS;
        let part_m = self.unit_m * f64::from(1_u32 << bits);
        let rim_m = part_m * OVERLAP + 2.0 * self.unit_m;
        let part = |part: u32| {
            let step = UVec2::new(part & ((1 << CELL_BITS) - 1), part >> CELL_BITS);
            let corner = square.corner + step * (1 << bits);
            let corner_m = self.place_m(corner);
            let [low_m, high_m] = [corner_m - rim_m, corner_m + part_m + rim_m];
            let edges = square.edges.iter().filter(|edge| edge.touches(low_m, high_m)).copied().collect();
            Part { corner, middle_m: corner_m + part_m * REFERENCES[0], edges }
        };
        let parts: Vec<Part> = (0..1_u32 << (2 * CELL_BITS)).map(part).collect();
        let counts = || parts.iter().map(|part| part.edges.len());
        let (sum, most) = (counts().sum::<usize>(), counts().max().unwrap_or(0));
        let own = square.edges.len();
        let stuck = if most == own && sum > own && own > FEW_EDGES { square.stuck + 1 } else { 0 };
        let has_room = room.held - own + sum <= room.edges && self.cells.len() + parts.len() <= MOST_CELLS;
        (has_room && stuck <= MOST_STUCK).then_some((parts, stuck))
    }

    /// Returns a place in a cell that is far from its edges, in units.
    fn reference(&self, square: &Square, low_m: DVec2, width_m: f64) -> UVec2 {
        let width = f64::from(1_u32 << square.bits);
        let rounded = |part: DVec2| square.corner + (part * width).as_uvec2();
        // Among many edges, any place that is on none will do, since they are divided further.
        let enough_m = if square.edges.len() > 8 * FEW_EDGES { 1e-6 * width_m } else { f64::INFINITY };
        let mut best = (rounded(REFERENCES[0]), -1.0);
        for part in REFERENCES {
            let at_m = low_m + part * width_m;
            let nearest_m = square.edges.iter().map(|edge| edge.distance_m(at_m)).fold(f64::INFINITY, f64::min);
            if nearest_m > best.1 {
                best = (rounded(part), nearest_m);
            }
            if best.1 > enough_m {
                break;
            }
        }
        best.0
    }

    fn place_m(&self, units: UVec2) -> DVec2 {
        self.corner_m + units.as_dvec2() * self.unit_m
    }

    /// Writes a cell that is not divided, with its edges.
    fn fill(
        &mut self,
        index: usize,
        reference: UVec2,
        reference_m: DVec2,
        windings: Windings,
        square: &Square,
        [low_m, high_m]: [DVec2; 2],
    ) {
        let mut edges = square.edges.clone();
        edges.sort_by_key(|edge| edge.area);
        let has_edges = |area: u32| edges.binary_search_by_key(&area, |edge| edge.area).is_ok();
        let covers = windings.iter().map(|(area, _)| *area).filter(|area| !has_edges(*area));
        let cell = self.cell_of(covers, reference, self.edges.len() as u32, edges.len() as u32);
        self.set(index, cell);
        self.most_edges = self.most_edges.max(edges.len());
        let windings: FxHashMap<u32, i32> = windings.into_iter().collect();
        let kept_m = (high_m - low_m) * KEPT;
        for edge in &edges {
            let [begin_m, end_m] = edge.clipped(low_m - kept_m, high_m + kept_m).map(|end_m| end_m - reference_m);
            self.edges.push([begin_m.x as f32, begin_m.y as f32, end_m.x as f32, end_m.y as f32]);
            let winding = windings.get(&edge.area).copied().unwrap_or(0);
            self.owners.push(EdgeOwner { area: edge.area, winding });
        }
    }

    /// Returns a cell that some areas cover.
    fn cell_of(&mut self, covers: impl Iterator<Item = u32>, reference: UVec2, first: u32, count: u32) -> AreaCell {
        let before = self.covers.len();
        self.covers.extend(covers);
        let cover_count = (self.covers.len() - before) as u32;
        let covers = before as u32;
        AreaCell { origin: reference.to_array(), first, count, covers, cover_count, ..AreaCell::default() }
    }

    fn set(&mut self, index: usize, cell: AreaCell) {
        if let Some(place) = self.cells.get_mut(index) {
            *place = cell;
        }
    }
}

impl Edge {
    /// Returns whether the edge may touch a rectangle.
    fn touches(&self, low_m: DVec2, high_m: DVec2) -> bool {
        let is_apart =
            self.begin_m.max(self.end_m).cmplt(low_m).any() || self.begin_m.min(self.end_m).cmpgt(high_m).any();
        if is_apart {
            return false;
        }
        let (middle_m, half_m) = (0.5 * (low_m + high_m), 0.5 * (high_m - low_m));
        let along_m = self.end_m - self.begin_m;
        // The rectangle is not on one side of the line.
        along_m.perp_dot(middle_m - self.begin_m).abs()
            <= (half_m.x * along_m.y.abs() + half_m.y * along_m.x.abs()) * (1.0 + 1e-9)
    }

    fn distance_m(&self, at_m: DVec2) -> f64 {
        let along_m = self.end_m - self.begin_m;
        let part = ((at_m - self.begin_m).dot(along_m) / along_m.length_squared()).clamp(0.0, 1.0);
        at_m.distance(self.begin_m + along_m * part)
    }

    /// Returns the ends of the part of the edge that is in a rectangle, or both ends if none is. An end in the rectangle
    /// stays as it is, bit for bit.
    fn clipped(&self, low_m: DVec2, high_m: DVec2) -> [DVec2; 2] {
        let along_m = self.end_m - self.begin_m;
        let (mut first, mut last) = (0.0_f64, 1.0_f64);
        for (step, from, low, high) in
            [(along_m.x, self.begin_m.x, low_m.x, high_m.x), (along_m.y, self.begin_m.y, low_m.y, high_m.y)]
        {
            if step != 0.0 {
                let (one, other) = ((low - from) / step, (high - from) / step);
                first = first.max(one.min(other));
                last = last.min(one.max(other));
            }
        }
        if first > last {
            return [self.begin_m, self.end_m];
        }
        let begin_m = if first > 0.0 { self.begin_m + along_m * first } else { self.begin_m };
        let end_m = if last < 1.0 { self.begin_m + along_m * last } else { self.end_m };
        [begin_m, end_m]
    }
}

/// Returns the windings around a place, from those around another place and the edges that the straight line from there
/// crosses.
fn windings_at(to_m: DVec2, windings: &Windings, edges: &[Edge], from_m: DVec2) -> Windings {
    let mut changed: FxHashMap<u32, i32> = windings.iter().copied().collect();
    let way_m = to_m - from_m;
    let [low_m, high_m] = [from_m.min(to_m), from_m.max(to_m)];
    for edge in edges {
        if edge.begin_m.max(edge.end_m).cmplt(low_m).any() || edge.begin_m.min(edge.end_m).cmpgt(high_m).any() {
            continue;
        }
        // Two edges that share an end compute the same side for it, so the line crosses exactly one of them there.
        if (way_m.perp_dot(edge.begin_m - from_m) > 0.0) == (way_m.perp_dot(edge.end_m - from_m) > 0.0) {
            continue;
        }
        let along_m = edge.end_m - edge.begin_m;
        let from_left = along_m.perp_dot(from_m - edge.begin_m) > 0.0;
        let to_left = along_m.perp_dot(to_m - edge.begin_m) > 0.0;
        if from_left != to_left {
            *changed.entry(edge.area).or_default() += if to_left { 1 } else { -1 };
        }
    }
    let mut changed: Windings = changed.into_iter().filter(|(_, winding)| *winding != 0).collect();
    changed.sort_unstable();
    changed
}
