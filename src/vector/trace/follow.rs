//! Follows lines one pixel wide from end to end, straight on through crossings.

use rustc_hash::FxHashMap;

use super::thin::Mask;

/// Number of pixels over which the direction of a line at a crossing is measured.
const AHEAD: usize = 8;
/// Cosines of the largest turn at which two lines are joined at a crossing: 60 degrees, or a right angle if only these
/// two lines meet there.
const STRAIGHT: f32 = 0.5;
const BENT: f32 = 0.0;
/// A side branch is removed as an artefact of thinning if it is shorter than the depth of its crossing times
/// [`TWIG_PART`], plus [`TWIG_PX`] pixels.
const TWIG_PART: f32 = 1.2;
const TWIG_PX: f32 = 2.5;

/// Two crossings are united if the line between them is shorter than their greater depth times [`BRIDGE_PART`], plus
/// [`BRIDGE_PX`] pixels.
const BRIDGE_PART: f32 = 2.0;
const BRIDGE_PX: f32 = 1.0;

/// A line of connected pixels.
pub(super) struct Chain {
    /// Indices into a [`Mask`].
    pub places: Vec<usize>,
    /// Whether the last pixel is next to the first.
    pub is_closed: bool,
}

/// A line between crossings. A crossing is identified by one of its pixels; a free end has none.
struct Piece {
    places: Vec<usize>,
    crossings: [Option<usize>; 2],
}

/// An end of a piece: the index of the piece, and whether it is the piece's last pixel.
type End = (usize, bool);

/// Returns all lines of a thinned mask. `depth` is the distance of each pixel of the mask before thinning from one
/// without ink.
pub(super) fn chains(mask: &Mask, depth: &[f32]) -> Vec<Chain> {
    let (mut pieces, mut closed) = pieces(mask, &Crossings::of(mask));
    unite(&mut pieces, depth);
    let is_twig = |piece: &Piece| {
        let crossing = match piece.crossings {
            [Some(crossing), None] | [None, Some(crossing)] => crossing,
            [Some(one), Some(other)] if one == other => one,
            _ => return false,
        };
        (piece.places.len() as f32) < TWIG_PART * depth[crossing] + TWIG_PX
    };
    pieces.retain(|piece| !is_twig(piece));
    closed.extend(joined(mask.stride, &pieces));
    closed
}

/// Pixels with more than two neighbours, in connected groups.
struct Crossings {
    /// For each such pixel, the pixel that identifies its group.
    of: FxHashMap<usize, usize>,
}

impl Crossings {
    fn of(mask: &Mask) -> Self {
        let is_crossing = |at: usize| mask.on[at] == 1 && neighbours(mask, at).count() > 2;
        let mut of = FxHashMap::default();
        for at in (0..mask.on.len()).filter(|at| is_crossing(*at)) {
            if of.contains_key(&at) {
                continue;
            }
            let mut open = vec![at];
            of.insert(at, at);
            while let Some(next) = open.pop() {
                for other in neighbours(mask, next).filter(|other| is_crossing(*other)) {
                    if of.insert(other, at).is_none() {
                        open.push(other);
                    }
                }
            }
        }
        Self { of }
    }

    fn at(&self, place: usize) -> Option<usize> {
        self.of.get(&place).copied()
    }
}

/// Unites crossings: where two wide lines cross, thinning leaves two crossings with a short bridge between them.
fn unite(pieces: &mut Vec<Piece>, depth: &[f32]) {
    let mut now: FxHashMap<usize, usize> = FxHashMap::default();
    let of = |now: &FxHashMap<usize, usize>, mut crossing: usize| {
        while let Some(next) = now.get(&crossing) {
            crossing = *next;
        }
        crossing
    };
    pieces.retain(|piece| {
        let [Some(one), Some(other)] = piece.crossings else { return true };
        let is_bridge = (piece.places.len() as f32) < BRIDGE_PART * depth[one].max(depth[other]) + BRIDGE_PX;
        let [one, other] = [one, other].map(|crossing| of(&now, crossing));
        if is_bridge && one != other {
            now.insert(one, other);
            return false;
        }
        true
    });
    for crossing in pieces.iter_mut().flat_map(|piece| &mut piece.crossings) {
        *crossing = crossing.map(|crossing| of(&now, crossing));
    }
}

fn neighbours(mask: &Mask, at: usize) -> impl Iterator<Item = usize> {
    mask.around(at).into_iter().filter(|other| mask.on[*other] == 1)
}

/// Returns the lines between crossings and ends, and the closed lines.
fn pieces(mask: &Mask, crossings: &Crossings) -> (Vec<Piece>, Vec<Chain>) {
    let mut is_done = vec![false; mask.on.len()];
    let mut pieces = Vec::new();
    let walk = |first: usize, begin: Option<usize>, is_done: &mut Vec<bool>| {
        let mut places = vec![first];
        is_done[first] = true;
        let mut at = first;
        loop {
            let next = neighbours(mask, at).find(|other| !is_done[*other] && crossings.at(*other).is_none());
            let Some(next) = next else { break };
            is_done[next] = true;
            places.push(next);
            at = next;
        }
        // A single pixel between two groups has an end at each of them.
        let is_alone = places.len() == 1 && begin.is_some();
        let mut near = neighbours(mask, at).filter_map(|other| crossings.at(other));
        let end = near.find(|other| !is_alone || Some(*other) != begin);
        Piece { places, crossings: [begin, end] }
    };
    let ends = (0..mask.on.len()).filter(|at| mask.on[*at] == 1 && crossings.at(*at).is_none());
    let ends: Vec<usize> = ends.collect();
    for &at in ends.iter().filter(|at| neighbours(mask, **at).count() < 2) {
        if !is_done[at] {
            // A pixel whose only neighbour is a crossing begins there.
            let piece = walk(at, None, &mut is_done);
            pieces.push(piece);
        }
    }
    let mut groups: Vec<(usize, usize)> = crossings.of.iter().map(|(at, group)| (*at, *group)).collect();
    groups.sort_unstable();
    for (at, group) in groups {
        for first in neighbours(mask, at) {
            if !is_done[first] && crossings.at(first).is_none() {
                let piece = walk(first, Some(group), &mut is_done);
                pieces.push(piece);
            }
        }
    }
    let mut closed = Vec::new();
    for &at in &ends {
        if !is_done[at] {
            closed.push(Chain { places: walk(at, None, &mut is_done).places, is_closed: true });
        }
    }
    (pieces, closed)
}

/// Joins pieces that continue each other to chains.
fn joined(stride: usize, pieces: &[Piece]) -> Vec<Chain> {
    let partners = partners(stride, pieces);
    let mut is_done = vec![false; pieces.len()];
    let mut chains = Vec::new();
    let go = |first: usize, begins_last: bool, is_done: &mut Vec<bool>| {
        let mut places: Vec<usize> = Vec::new();
        let (mut piece, mut enters_last) = (first, begins_last);
        loop {
            is_done[piece] = true;
            let own = &pieces[piece];
            if enters_last {
                places.extend(own.places.iter().rev());
            } else {
                places.extend(&own.places);
            }
            let leaves = (piece, !enters_last);
            let Some(&(next, next_last)) = partners.get(&leaves) else { return Chain { places, is_closed: false } };
            // The chain runs straight over the crossing; the ink there goes to the first line.
            let goes_on = &pieces[next].places;
            let end = goes_on[if next_last { goes_on.len() - 1 } else { 0 }];
            let begin = places[places.len() - 1];
            places.extend(between(stride, begin, end));
            if is_done[next] {
                return Chain { places, is_closed: next == first };
            }
            (piece, enters_last) = (next, next_last);
        }
    };
    for piece in 0..pieces.len() {
        for is_last in [false, true] {
            if !is_done[piece] && !partners.contains_key(&(piece, is_last)) {
                chains.push(go(piece, is_last, &mut is_done));
            }
        }
    }
    // The remaining pieces form closed lines.
    for piece in 0..pieces.len() {
        if !is_done[piece] {
            chains.push(go(piece, false, &mut is_done));
        }
    }
    chains
}

/// Returns the pixels on the straight line between two pixels, without these two.
fn between(stride: usize, a: usize, b: usize) -> impl Iterator<Item = usize> {
    let at = move |place: usize| [(place % stride) as i64, (place / stride) as i64];
    let [[ax, ay], [bx, by]] = [at(a), at(b)];
    let steps = (bx - ax).abs().max((by - ay).abs()).max(1);
    let part = move |from: i64, to: i64, i: i64| from + ((to - from) * i + (to - from).signum() * steps / 2) / steps;
    (1..steps).map(move |i| part(ay, by, i) as usize * stride + part(ax, bx, i) as usize)
}

/// Pairs the ends at each crossing that continue each other.
fn partners(stride: usize, pieces: &[Piece]) -> FxHashMap<End, End> {
    let mut at_crossing: FxHashMap<usize, Vec<End>> = FxHashMap::default();
    for (number, piece) in pieces.iter().enumerate() {
        for (crossing, is_last) in piece.crossings.iter().zip([false, true]) {
            if let Some(crossing) = crossing {
                at_crossing.entry(*crossing).or_default().push((number, is_last));
            }
        }
    }
    let mut partners = FxHashMap::default();
    for (crossing, ends) in &at_crossing {
        let ways: Vec<[f32; 2]> = ends.iter().map(|end| way(stride, pieces, *crossing, *end)).collect();
        let pairs = (0..ends.len()).flat_map(|i| (i + 1..ends.len()).map(move |j| (i, j)));
        let mut pairs: Vec<(f32, usize, usize)> =
            pairs.map(|(i, j)| (-(ways[i][0] * ways[j][0] + ways[i][1] * ways[j][1]), i, j)).collect();
        pairs.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let least = if ends.len() == 2 { BENT } else { STRAIGHT };
        for (straight, i, j) in pairs {
            let is_free = !partners.contains_key(&ends[i]) && !partners.contains_key(&ends[j]);
            if straight > least && is_free {
                partners.insert(ends[i], ends[j]);
                partners.insert(ends[j], ends[i]);
            }
        }
    }
    partners
}

/// Returns the unit direction in which a piece leaves a crossing.
fn way(stride: usize, pieces: &[Piece], crossing: usize, (piece, is_last): End) -> [f32; 2] {
    let places = &pieces[piece].places;
    let ahead = AHEAD.min(places.len() - 1);
    let far = if is_last { places.len() - 1 - ahead } else { ahead };
    let at = |place: usize| [(place % stride) as f32, (place / stride) as f32];
    let [a, b] = [at(crossing), at(places[far])];
    let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    let length = dx.hypot(dy).max(1e-6);
    [dx / length, dy / length]
}
