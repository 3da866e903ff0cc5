//! Lines of map features, prepared for drawing at all scales.
//!
//! Every line is cut into blocks of at most [`BLOCK_POINTS`] points. The leaves hold the vertices as they were given. A
//! parent stands for two neighbouring blocks, or for a single one, with fewer points and a known error. [`LineTree`]
//! chooses, for a view, the coarsest blocks whose error is not visible. The roots of all lines are in a hierarchy of
//! boxes, so that lines that are out of view cost nothing, and so that a group of lines that is smaller than a pixel is
//! drawn as one line.
//!
//! Positions are rounded to a grid whose spacing is a power of two, so that `f32` holds them exactly relative to the
//! origin of their block. Two blocks that share an end point, of whatever sizes, have the same `f64` for it: `origin_m`
//! plus `at_m` is bit-identical in both. The spacing of the grid is 2^-16 m, or 2^-23 of half the width of the block
//! (at an end point: of the widest block that ends there), whichever is larger. A vertex is therefore moved by less
//! than 1 mm in each axis in blocks up to 16 km wide, and by 2.5 m in a block that spans 40 000 km.

use std::ops::Range;

use glam::DVec2;

#[cfg(test)]
mod tests;

/// Largest number of points of a block.
pub(crate) const BLOCK_POINTS: usize = 64;

/// Largest absolute value of a coordinate, in metres. A vertex beyond it splits its line, as one that is NaN does.
pub(crate) const LARGEST_M: f64 = 1e9;

/// Finest spacing of the grid of positions, in metres.
const FINEST_M: f64 = 1.0 / 65536.0;

/// Largest number of roots of a node of the hierarchy of boxes that is not divided.
const LEAF_ROOTS: usize = 8;

/// Largest factor by which the allowed error is raised to choose fewer blocks.
const LARGEST_RAISE: f64 = 64.0;

/// Smallest and largest error of a line in pixels that a view can request.
const ERROR_PX: [f64; 2] = [1.0 / 1024.0, 1e6];

/// Stands for a child that does not exist.
const NO_CHILD: u32 = u32::MAX;

/// A point of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BlockPoint {
    /// East and north of the block's origin, in metres.
    pub at_m: [f32; 2],
    /// Length of the whole line up to here, as it was given, in metres. Gaps at invalid vertices have no length.
    pub along_m: f32,
}

/// A part of a line, simplified.
///
/// It has two points or more. Two consecutive points differ, unless the whole block is a dot of two equal points.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Block {
    /// Point that `BlockPoint::at_m` is relative to, near the middle of the box, in metres of the world. It is rounded
    /// to whole metres (in blocks wider than 16 000 km, to the grid of their positions).
    pub origin_m: DVec2,
    /// South-west corner of the bounding box of all vertices that the block stands for, in metres of the world.
    pub low_m: DVec2,
    /// North-east corner of that bounding box, in metres of the world.
    pub high_m: DVec2,
    /// Number of the feature, as `LineTree::new` was given it.
    pub feature: u32,
    /// Upper bound of the distance from every point of the original part of the line to the simplified one, in metres.
    /// It includes the rounding of positions, except in leaves, where it is 0. It is at least that of each child.
    pub error_m: f32,
    /// Index of the first point.
    first: u32,
    /// Numbers of the blocks that this block stands for, in the order of the line; `NO_CHILD` if there are fewer.
    children: [u32; 2],
    /// Number of points, 2 to `BLOCK_POINTS`.
    count: u8,
}

/// A rectangle of the world, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rect {
    low_m: DVec2,
    high_m: DVec2,
}

/// A line of the hierarchy of boxes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Root {
    /// Index of its coarsest block.
    block: u32,
    feature: u32,
}

/// A group of lines. Nodes are stored before the nodes that they consist of.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    /// Bounding box of its lines.
    rect: Rect,
    /// Index of the first root.
    first: u32,
    /// Index after the last root.
    end: u32,
    /// Index of the first node that is not part of this one. A node that is not divided is followed by it.
    after: u32,
}

/// The blocks of many lines, and a hierarchy of boxes over them.
#[derive(Debug, PartialEq)]
pub(crate) struct LineTree {
    /// All blocks; children come before their parents.
    blocks: Vec<Block>,
    points: Vec<BlockPoint>,
    /// The coarsest block of each line, along a Morton curve.
    roots: Vec<Root>,
    /// Groups of consecutive roots, each of which is divided where the Morton code changes most.
    nodes: Vec<Node>,
}

/// The view for which blocks are chosen.
pub(crate) struct Sight<'a> {
    /// Returns whether anything in a rectangle of the world (low and high corner, in metres) may be in view.
    pub is_seen: &'a dyn Fn(DVec2, DVec2) -> bool,
    /// Returns the width of the smallest pixel on the ground in a rectangle, in metres: 0 if the camera is in it.
    pub pixel_m: &'a dyn Fn(DVec2, DVec2) -> f64,
    /// Returns whether a feature is drawn.
    pub is_drawn: &'a dyn Fn(u32) -> bool,
    /// Largest error of a line, in pixels; values below 1/1024, and NaN, count as 1/1024.
    pub error_px: f64,
}

/// The loss of detail by which the number of blocks stays within its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Chosen {
    /// Factor by which the allowed error was raised, a power of two from 1 (it was not) to 64.
    pub raised: f64,
    /// Number of blocks, the farthest ones, that were left out because even the largest error did not suffice.
    pub left_out: usize,
}

impl Rect {
    /// A rectangle that holds nothing.
    const EMPTY: Self = Self { low_m: DVec2::INFINITY, high_m: DVec2::NEG_INFINITY };

    /// Returns the smallest rectangle that holds both.
    fn union(self, other: Self) -> Self {
        Self { low_m: self.low_m.min(other.low_m), high_m: self.high_m.max(other.high_m) }
    }

    /// Returns the bounding box of points.
    fn around(points_m: &[DVec2]) -> Self {
        points_m.iter().fold(Self::EMPTY, |rect, &at_m| rect.union(Self { low_m: at_m, high_m: at_m }))
    }

    /// Returns the middle, in metres.
    fn middle_m(self) -> DVec2 {
        0.5 * (self.low_m + self.high_m)
    }

    /// Returns the spacing of the grid, in metres, for the positions of a block with this bounding box, none of which
    /// is rounded by more than `spare_m`.
    fn spacing_m(self, spare_m: f64) -> f64 {
        let reach_m = 0.5 * (self.high_m - self.low_m).max_element() * 1.001 + 1.0 + spare_m;
        // 24 bits of mantissa.
        (reach_m.log2().ceil() - 24.0).exp2().max(FINEST_M)
    }
}

impl LineTree {
    /// Builds the trees of lines: (number of the feature, vertices in metres of the world, east and north).
    ///
    /// A closed ring repeats its first vertex at its end. Equal consecutive vertices are merged. A vertex that is NaN,
    /// infinite or beyond [`LARGEST_M`] splits its line. A line, or a piece of one, with a single vertex becomes a dot.
    /// Lines that would need more than 2^32 points altogether are left out.
    pub(crate) fn new(lines: impl IntoIterator<Item = (u32, Vec<DVec2>)>) -> Self {
        let mut builder = Builder::default();
        for (feature, vertices_m) in lines {
            builder.add_line(feature, &vertices_m);
        }
        let Builder { mut blocks, mut points, roots, .. } = builder;
        blocks.shrink_to_fit();
        points.shrink_to_fit();
        let mut tree = Self { blocks, points, roots: Vec::new(), nodes: Vec::new() };
        tree.group(&roots);
        tree
    }

    /// Returns all blocks. `choose` returns indices into them.
    pub(crate) fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// Returns the points of a block of this tree, 2 to `BLOCK_POINTS`.
    pub(crate) fn points(&self, block: &Block) -> &[BlockPoint] {
        let first = block.first as usize;
        self.points.get(first..first + usize::from(block.count)).unwrap_or_default()
    }

    /// Returns the memory that the tree occupies, in bytes.
    #[cfg(test)]
    pub(crate) fn bytes(&self) -> u64 {
        let bytes = self.blocks.capacity() * size_of::<Block>()
            + self.points.capacity() * size_of::<BlockPoint>()
            + self.roots.capacity() * size_of::<Root>()
            + self.nodes.capacity() * size_of::<Node>();
        bytes as u64
    }

    /// Chooses the blocks of a view, at most `most`, and replaces the content of `chosen` with their indices.
    ///
    /// The chosen blocks cover every part of every line that is drawn and in view exactly once, in the order of the
    /// line, with an error of at most `sight.error_px` pixels. Of a group of lines whose box has a diagonal of at most
    /// `sight.error_px` pixels, only the first that is drawn is chosen. If more than `most` blocks were needed, both
    /// limits are doubled, up to six times. If that does not suffice, the `most` nearest of the blocks at 64 times the
    /// limits are chosen: those with the smallest pixels, nearest first. Equal trees and views give equal choices.
    pub(crate) fn choose(&self, sight: &Sight<'_>, most: usize, chosen: &mut Vec<u32>) -> Chosen {
        let mut raised = 1.0;
        while raised <= LARGEST_RAISE {
            if self.collect(sight, raised, most, chosen) {
                return Chosen { raised, left_out: 0 };
            }
            raised *= 2.0;
        }
        let raised = LARGEST_RAISE;
        self.collect(sight, raised, usize::MAX, chosen);
        let left_out = chosen.len().saturating_sub(most);
        if left_out > 0 {
            let mut by_distance: Vec<(f64, u32)> = chosen
                .iter()
                .filter_map(|&index| Some((index, self.blocks.get(index as usize)?)))
                .map(|(index, block)| ((sight.pixel_m)(block.low_m, block.high_m), index))
                .collect();
            by_distance.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            chosen.clear();
            chosen.extend(by_distance.iter().take(most).map(|&(_, index)| index));
        }
        Chosen { raised, left_out }
    }

    /// Chooses the blocks of a view for an allowed error that is `raised` times that of the view. Returns false, with
    /// an incomplete choice, if these are more than `most`.
    fn collect(&self, sight: &Sight<'_>, raised: f64, most: usize, chosen: &mut Vec<u32>) -> bool {
        let [least_px, largest_px] = ERROR_PX;
        let asked_px = if sight.error_px.is_nan() { least_px } else { sight.error_px.clamp(least_px, largest_px) };
        let error_px = asked_px * raised;
        chosen.clear();
        let mut stack: Vec<u32> = Vec::new();
        let mut next = 0;
        while let Some(node) = self.nodes.get(next) {
            let Rect { low_m, high_m } = node.rect;
            let is_divided = node.after as usize > next + 1;
            let after = node.after as usize;
            next += 1;
            if !(sight.is_seen)(low_m, high_m) {
                next = after;
                continue;
            }
            let roots = self.roots.get(node.first as usize..node.end as usize).unwrap_or_default();
            let mut drawn = roots.iter().filter(|root| (sight.is_drawn)(root.feature));
            if low_m.distance(high_m) <= error_px * (sight.pixel_m)(low_m, high_m) {
                next = after;
                if let Some(root) = drawn.next() {
                    if chosen.len() >= most {
                        return false;
                    }
                    chosen.push(root.block);
                }
                continue;
            }
            if is_divided {
                continue;
            }
            stack.extend(drawn.rev().map(|root| root.block));
            while let Some(index) = stack.pop() {
                let Some(block) = self.blocks.get(index as usize) else { continue };
                if !(sight.is_seen)(block.low_m, block.high_m) {
                    continue;
                }
                let is_fine = || f64::from(block.error_m) <= error_px * (sight.pixel_m)(block.low_m, block.high_m);
                if block.children == [NO_CHILD; 2] || is_fine() {
                    if chosen.len() >= most {
                        return false;
                    }
                    chosen.push(index);
                } else {
                    stack.extend(block.children.iter().rev().filter(|&&child| child != NO_CHILD));
                }
            }
        }
        true
    }

    /// Sorts the roots along a Morton curve and builds the hierarchy of boxes over them.
    fn group(&mut self, roots: &[u32]) {
        let all = roots.iter().filter_map(|&root| self.blocks.get(root as usize));
        let world = all.clone().fold(Rect::EMPTY, |rect, block| rect.union(block.rect()));
        let scale = f64::from(u32::MAX) / (world.high_m - world.low_m).max_element().max(1.0);
        let mut sorted: Vec<(u64, Root)> = roots
            .iter()
            .zip(all)
            .map(|(&root, block)| {
                let at = (block.rect().middle_m() - world.low_m) * scale;
                let code = spread_bits(at.x as u32) | spread_bits(at.y as u32) << 1;
                (code, Root { block: root, feature: block.feature })
            })
            .collect();
        sorted.sort_unstable_by_key(|&(code, root)| (code, root.block));
        self.roots = sorted.iter().map(|&(_, root)| root).collect();
        if !sorted.is_empty() {
            self.add_node(&sorted, 0);
        }
        self.nodes.shrink_to_fit();
    }

    /// Adds the node of some roots, sorted by their Morton codes, and the nodes that it consists of. `first` is the
    /// index of the first root. Returns the bounding box. The depth of the recursion is at most 64 + 32.
    fn add_node(&mut self, roots: &[(u64, Root)], first: usize) -> Rect {
        let index = self.nodes.len();
        let end = (first + roots.len()) as u32;
        self.nodes.push(Node { rect: Rect::EMPTY, first: first as u32, end, after: 0 });
        let rect = if roots.len() <= LEAF_ROOTS {
            let blocks = roots.iter().filter_map(|(_, root)| self.blocks.get(root.block as usize));
            blocks.fold(Rect::EMPTY, |rect, block| rect.union(block.rect()))
        } else {
            let codes = [roots.first(), roots.last()].map(|root| root.map_or(0, |&(code, _)| code));
            let different = codes[0] ^ codes[1];
            let middle = match different.checked_ilog2() {
                Some(bit) => roots.partition_point(|&(code, _)| code >> bit & 1 == 0),
                None => roots.len() / 2,
            };
            let (left, right) = roots.split_at(middle);
            self.add_node(left, first).union(self.add_node(right, first + middle))
        };
        let after = self.nodes.len() as u32;
        if let Some(node) = self.nodes.get_mut(index) {
            (node.rect, node.after) = (rect, after);
        }
        rect
    }
}

impl Block {
    /// Returns the bounding box of the vertices.
    fn rect(&self) -> Rect {
        Rect { low_m: self.low_m, high_m: self.high_m }
    }
}

/// Returns the bits of a number at the even places of the result.
fn spread_bits(number: u32) -> u64 {
    let mut bits = u64::from(number);
    for (shift, mask) in [
        (16, 0x0000_ffff_0000_ffff_u64),
        (8, 0x00ff_00ff_00ff_00ff),
        (4, 0x0f0f_0f0f_0f0f_0f0f),
        (2, 0x3333_3333_3333_3333),
        (1, 0x5555_5555_5555_5555),
    ] {
        bits = (bits | bits << shift) & mask;
    }
    bits
}

/// Returns the squared distance of a point from a segment that starts at `start` and extends by `along`, in the square
/// of their unit. `scale` is 1 over the squared length of the segment, or 0 if it has no length.
fn squared_distance(point: DVec2, start: DVec2, along: DVec2, scale: f64) -> f64 {
    let offset = point - start;
    let nearest = (offset.dot(along) * scale).clamp(0.0, 1.0);
    (offset - along * nearest).length_squared()
}

/// Returns 1 over the squared length of a vector, or 0 if that is not finite.
fn inverse_square(along: DVec2) -> f64 {
    let scale = along.length_squared().recip();
    if scale.is_finite() { scale } else { 0.0 }
}

/// Blocks of a line from one cut to another.
#[derive(Clone, Copy)]
struct Piece {
    /// Cut at which it starts.
    first: usize,
    /// Cut at which it ends.
    last: usize,
    /// Bounding box of its vertices.
    rect: Rect,
}

impl Piece {
    /// Returns the piece that consists of this one and the next.
    fn join(self, next: Self) -> Self {
        Self { first: self.first, last: next.last, rect: self.rect.union(next.rect) }
    }
}

/// A stretch of a line that is simplified to a segment.
#[derive(Clone, Copy)]
struct Stretch {
    /// Index of the first candidate.
    first: usize,
    /// Index of the last candidate.
    last: usize,
    /// Index of the candidate that is farthest from the segment between these two.
    farthest: usize,
    /// The square of its distance, in square metres.
    squared_m2: f64,
}

impl Stretch {
    /// Finds the farthest candidate between two.
    fn new(candidates_m: &[DVec2], first: usize, last: usize) -> Self {
        let mut stretch = Self { first, last, farthest: first, squared_m2: 0.0 };
        let (Some(&start_m), Some(&end_m)) = (candidates_m.get(first), candidates_m.get(last)) else { return stretch };
        let along_m = end_m - start_m;
        let scale = inverse_square(along_m);
        let between = candidates_m.iter().enumerate().take(last).skip(first + 1);
        for (index, &at_m) in between {
            let squared_m2 = squared_distance(at_m, start_m, along_m, scale);
            if squared_m2 > stretch.squared_m2 {
                (stretch.farthest, stretch.squared_m2) = (index, squared_m2);
            }
        }
        stretch
    }
}

/// One continuous part of a line, while its blocks are built.
#[derive(Default)]
struct Part {
    feature: u32,
    /// Vertices in metres of the world; consecutive ones differ, except the two of a dot.
    vertices_m: Vec<DVec2>,
    /// Length of the line up to each vertex, in metres.
    along_m: Vec<f32>,
    /// Positions of the cuts, rounded, in metres of the world.
    cuts_m: Vec<DVec2>,
    /// Spacing of the grid of the whole part, in metres: the coarsest of all its blocks.
    spare_m: f64,
}

/// The blocks that have been built, and buffers.
#[derive(Default)]
struct Builder {
    blocks: Vec<Block>,
    points: Vec<BlockPoint>,
    roots: Vec<u32>,
    part: Part,
    /// Indices of the vertices of the points of the current part, which start at `base`.
    kept: Vec<u32>,
    /// Number of points before the current part.
    base: usize,
    /// Candidates of a simplification: indices of vertices.
    candidates: Vec<u32>,
    /// Their positions, in metres.
    candidates_m: Vec<DVec2>,
    stretches: Vec<Stretch>,
}

impl Builder {
    /// Adds the blocks of a line.
    fn add_line(&mut self, feature: u32, vertices_m: &[DVec2]) {
        let mut length_m = 0.0;
        self.part.feature = feature;
        for &at_m in vertices_m {
            // False for NaN.
            let is_valid = at_m.abs().cmple(DVec2::splat(LARGEST_M)).all();
            if !is_valid {
                self.add_part();
                continue;
            }
            if let Some(&before_m) = self.part.vertices_m.last() {
                if before_m == at_m {
                    continue;
                }
                length_m += before_m.distance(at_m);
            }
            self.part.vertices_m.push(at_m);
            self.part.along_m.push(length_m as f32);
        }
        self.add_part();
    }

    /// Adds the blocks of the current part, and empties it.
    fn add_part(&mut self) {
        let mut part = std::mem::take(&mut self.part);
        // More than all blocks of the part can have.
        let most_points = 3 * part.vertices_m.len() + 4 * BLOCK_POINTS;
        if !part.vertices_m.is_empty() && self.points.len() + most_points < NO_CHILD as usize {
            if let ([only_m], [along_m]) = (part.vertices_m.as_slice(), part.along_m.as_slice()) {
                let (only_m, along_m) = (*only_m, *along_m);
                part.vertices_m.push(only_m);
                part.along_m.push(along_m);
            }
            self.base = self.points.len();
            self.kept.clear();
            let root = self.add_tree(&mut part);
            self.roots.extend(root);
        }
        part.vertices_m.clear();
        part.along_m.clear();
        self.part = part;
    }

    /// Adds the blocks of a part with two vertices or more. Returns the coarsest.
    fn add_tree(&mut self, part: &mut Part) -> Option<u32> {
        let segments = part.vertices_m.len() - 1;
        let leaves = segments.div_ceil(BLOCK_POINTS - 1);
        let cuts: Vec<usize> = (0..=leaves).map(|cut| cut * segments / leaves).collect();
        let pieces: Vec<Piece> = cuts
            .windows(2)
            .enumerate()
            .map(|(index, ends)| {
                let vertices_m = part.vertices_m.get(range_of(ends)).unwrap_or_default();
                Piece { first: index, last: index + 1, rect: Rect::around(vertices_m) }
            })
            .collect();
        part.round_cuts(&cuts, &pieces);

        let mut level: Vec<(u32, Piece)> = Vec::with_capacity(leaves);
        for (&piece, ends) in pieces.iter().zip(cuts.windows(2)) {
            self.candidates.clear();
            self.candidates.extend(range_of(ends).map(|vertex| vertex as u32));
            level.push((self.add_block(part, piece, [NO_CHILD; 2]), piece));
        }
        while level.len() > 1 {
            let mut above = Vec::with_capacity(level.len().div_ceil(2));
            for pair in level.chunks(2) {
                match *pair {
                    [(left, left_piece), (right, right_piece)] => {
                        let piece = left_piece.join(right_piece);
                        above.push((self.add_parent(part, piece, [left, right], BLOCK_POINTS), piece));
                    }
                    [single] => above.push(single),
                    _ => {}
                }
            }
            level = above;
        }
        let &(mut root, piece) = level.first()?;
        loop {
            let segments = self.blocks.get(root as usize).map_or(0, |block| usize::from(block.count) - 1);
            let fewer = match segments {
                0..=3 => return Some(root),
                4..=7 => 1,
                _ => segments / 2,
            };
            root = self.add_parent(part, piece, [root, NO_CHILD], fewer + 1);
        }
    }

    /// Adds a block that stands for its children with at most `most` points. Returns its index.
    fn add_parent(&mut self, part: &Part, piece: Piece, children: [u32; 2], most: usize) -> u32 {
        self.candidates.clear();
        let mut error_m: f32 = 0.0;
        for child in children {
            let Some(block) = self.blocks.get(child as usize) else { continue };
            error_m = error_m.max(block.error_m);
            let first = block.first as usize - self.base;
            let kept = self.kept.get(first..first + usize::from(block.count)).unwrap_or_default();
            // The children share a vertex.
            let shared = usize::from(!self.candidates.is_empty());
            self.candidates.extend(kept.iter().skip(shared));
        }
        // A deviation much smaller than the error of the children needs no point.
        let enough_m = (0.25 * f64::from(error_m)).max(piece.rect.spacing_m(part.spare_m));
        self.simplify(part, most, enough_m);
        self.add_block(part, piece, children)
    }

    /// Removes candidates until at most `most` are left. Those that are kept are the ones that Douglas and Peucker's
    /// algorithm splits at, the farthest first, as long as they are farther than `enough_m` from the simplified line.
    fn simplify(&mut self, part: &Part, most: usize, enough_m: f64) {
        let Some(last) = self.candidates.len().checked_sub(1) else { return };
        self.candidates_m.clear();
        let vertices_m = self.candidates.iter().filter_map(|&vertex| part.vertices_m.get(vertex as usize));
        self.candidates_m.extend(vertices_m);
        let candidates_m = self.candidates_m.as_slice();
        self.stretches.clear();
        self.stretches.push(Stretch::new(candidates_m, 0, last));
        while self.stretches.len() + 1 < most {
            let worst = self.stretches.iter_mut().reduce(|a, b| if b.squared_m2 > a.squared_m2 { b } else { a });
            let Some(worst) = worst else { break };
            if worst.squared_m2 <= enough_m * enough_m {
                break;
            }
            let Stretch { first, last, farthest, .. } = *worst;
            *worst = Stretch::new(candidates_m, first, farthest);
            self.stretches.push(Stretch::new(candidates_m, farthest, last));
        }
        self.stretches.sort_unstable_by_key(|stretch| stretch.first);
        // In place: a stretch starts at its own index or a later one.
        for (index, stretch) in self.stretches.iter().enumerate() {
            self.candidates.copy_within(stretch.first..=stretch.first, index);
        }
        self.candidates.copy_within(last..=last, self.stretches.len());
        self.candidates.truncate(self.stretches.len() + 1);
    }

    /// Adds a block with the candidates as its points. Returns its index.
    fn add_block(&mut self, part: &Part, piece: Piece, children: [u32; 2]) -> u32 {
        let spacing_m = piece.rect.spacing_m(part.spare_m);
        let origin_m = round_to(piece.rect.middle_m(), spacing_m.max(1.0));
        let first = self.points.len();
        let last = self.candidates.len().saturating_sub(1);
        for (index, &vertex) in self.candidates.iter().enumerate() {
            let cut = match index {
                0 => part.cuts_m.get(piece.first),
                _ if index == last => part.cuts_m.get(piece.last),
                _ => None,
            };
            let vertex_m = part.vertices_m.get(vertex as usize).copied().unwrap_or_default();
            let at_m = cut.map_or_else(|| round_to(vertex_m, spacing_m), |&cut_m| cut_m) - origin_m;
            let at_m = at_m.as_vec2().to_array();
            let along_m = part.along_m.get(vertex as usize).copied().unwrap_or_default();
            // Vertices that were rounded to the same position are merged; the ends stay.
            if self.points.len() > first && self.points.last().is_some_and(|before| before.at_m == at_m) {
                if index < last {
                    continue;
                }
                if self.points.len() > first + 1 {
                    self.points.pop();
                    self.kept.pop();
                }
            }
            self.points.push(BlockPoint { at_m, along_m });
            self.kept.push(vertex);
        }
        let mut error_m: f32 = 0.0;
        if children != [NO_CHILD; 2] {
            error_m = self.distance_m(part, first, origin_m);
            for child in children.iter().filter_map(|&child| self.blocks.get(child as usize)) {
                error_m = error_m.max(child.error_m);
            }
        }
        self.blocks.push(Block {
            origin_m,
            low_m: piece.rect.low_m,
            high_m: piece.rect.high_m,
            feature: part.feature,
            error_m,
            first: first as u32,
            children,
            count: (self.points.len() - first) as u8,
        });
        (self.blocks.len() - 1) as u32
    }

    /// Returns an upper bound of the distance, in metres, of the original line from the simplified one whose points
    /// start at `first`. The distance from a segment is convex, so its maximum is at a vertex of the original line.
    fn distance_m(&self, part: &Part, first: usize, origin_m: DVec2) -> f32 {
        let points = self.points.get(first..).unwrap_or_default();
        let kept = self.kept.get(first - self.base..).unwrap_or_default();
        let mut squared_m2: f64 = 0.0;
        for (points, ends) in points.windows(2).zip(kept.windows(2)) {
            let ([start, end], &[from, to]) = (points, ends) else { continue };
            let [start_m, end_m] = [start, end].map(|point| DVec2::from(point.at_m.map(f64::from)));
            let along_m = end_m - start_m;
            let scale = inverse_square(along_m);
            let start_m = start_m + origin_m;
            for &vertex_m in part.vertices_m.get(from as usize..=to as usize).unwrap_or_default() {
                let vertex_m2 = squared_distance(vertex_m, start_m, along_m, scale);
                squared_m2 = if vertex_m2 > squared_m2 { vertex_m2 } else { squared_m2 };
            }
        }
        if squared_m2 == 0.0 {
            return 0.0;
        }
        // Rounded up.
        ((squared_m2.sqrt() * (1.0 + 1e-7)) as f32).next_up()
    }
}

impl Part {
    /// Rounds the positions of the cuts, whose indices of vertices are given, to the grid of the widest block that ends
    /// there. `pieces` are the leaves.
    fn round_cuts(&mut self, cuts: &[usize], pieces: &[Piece]) {
        let whole = pieces.iter().copied().reduce(Piece::join);
        self.spare_m = whole.map_or(FINEST_M, |piece| piece.rect.spacing_m(0.0));
        let mut spacings_m = vec![FINEST_M; cuts.len()];
        let mut level = pieces.to_vec();
        loop {
            for piece in &level {
                let spacing_m = piece.rect.spacing_m(self.spare_m);
                for cut in [piece.first, piece.last] {
                    if let Some(widest_m) = spacings_m.get_mut(cut) {
                        *widest_m = spacing_m.max(*widest_m);
                    }
                }
            }
            if level.len() <= 1 {
                break;
            }
            // As the blocks are paired: an odd one is kept for the next level.
            level = level.chunks(2).filter_map(|pair| pair.iter().copied().reduce(Piece::join)).collect();
        }
        self.cuts_m.clear();
        let vertices_m = cuts.iter().filter_map(|&cut| self.vertices_m.get(cut));
        self.cuts_m.extend(vertices_m.zip(&spacings_m).map(|(&at_m, &spacing_m)| round_to(at_m, spacing_m)));
    }
}

/// Returns a position rounded to a multiple of a spacing that is a power of two, without further error.
fn round_to(at_m: DVec2, spacing_m: f64) -> DVec2 {
    (at_m / spacing_m).round() * spacing_m
}

/// Returns the range of the vertices from one cut to another, both included.
fn range_of(ends: &[usize]) -> Range<usize> {
    match *ends {
        [first, last] => first..last + 1,
        _ => 0..0,
    }
}
