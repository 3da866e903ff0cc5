//! The CPU twin of chaining, and so the specification of [`chain`](super::chain), one step after the other.
//!
//! Pietrok (2021), section 4.2.3, joins an edge with a partner that is nearer than D, at less than the angle A, and not
//! overlapping: the first one that qualifies, in the order of the list. Here each end chooses its best partner, ends
//! that chose each other are joined, and this is done three times; so the order of segments only decides ties, and each
//! end is joined at most once. All numbers are integers.

use rustc_hash::FxHashMap;

use super::records::{Chain, ChainPosition, ChainRules, Segment};

/// The result of chaining.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Chained {
    /// For each position in the order: the number of a segment, times two, plus 1 if it runs from b to a.
    pub ordered: Vec<u32>,
    /// The chains, in the order of their first segments.
    pub chains: Vec<Chain>,
    /// For each position in the order: its chain, and the arc length at which its segment begins.
    pub places: Vec<ChainPosition>,
}

const LIMIT_UNITS: i32 = crate::gpu::wgsl::shared::strokes::LIMIT_UNITS;
/// Fixed-point 1 of scores and of cos².
const ONE: u32 = 4096;

/// Chains the segments. End 2p is a of segment p, end 2p + 1 is b.
pub(crate) fn chain(segments: &[Segment], rules: &ChainRules) -> Chained {
    let rules = rules.in_range();
    let links = join(segments, &rules);
    let mut heads = heads(segments, &links);
    heads.sort_by_key(|head| head / 2);
    let mut chained = Chained::default();
    for head in heads {
        append(&mut chained, segments, &links, head);
    }
    chained
}

/// Returns for each end the end that it is joined to.
pub(crate) fn join(segments: &[Segment], rules: &ChainRules) -> Vec<Option<u32>> {
    let count = 2 * segments.len() as u32;
    let ends: Vec<End> = (0..count).map(|end| End::new(segments, end)).collect();
    let reach = rules.reach_units as i32;
    let cell = |position: [i32; 2]| position.map(|units| units.div_euclid(reach));
    let mut cells: FxHashMap<[i32; 2], Vec<u32>> = FxHashMap::default();
    for end in 0..count {
        cells.entry(cell(ends[end as usize].position)).or_default().push(end);
    }

    let mut links = vec![None; count as usize];
    for _ in 0..ChainRules::ROUNDS {
        let choose = |end: u32| {
            let [x, y] = cell(ends[end as usize].position);
            let near = (y - 1..=y + 1).flat_map(|y| (x - 1..=x + 1).map(move |x| [x, y]));
            near.filter_map(|cell| cells.get(&cell))
                .flatten()
                .filter(|&&other| other / 2 != end / 2 && links[other as usize].is_none())
                .filter_map(|&other| {
                    let score = score(&ends[end as usize], &ends[other as usize], rules)?;
                    Some((score, segments[other as usize / 2].key, other))
                })
                .min()
                .map(|(_, _, other)| other)
        };
        let choices: Vec<Option<u32>> =
            (0..count).map(|end| if links[end as usize].is_none() { choose(end) } else { None }).collect();
        for end in 0..count {
            if let Some(other) = choices[end as usize]
                && choices[other as usize] == Some(end)
            {
                links[end as usize] = Some(other);
            }
        }
    }
    links
}

/// An end of a segment: its position, and the direction in which the segment leaves through it.
struct End {
    position: [i32; 2],
    outward: [i32; 2],
}

impl End {
    fn new(segments: &[Segment], end: u32) -> Self {
        let (position, other) = (position(segments, end), position(segments, end ^ 1));
        Self { position, outward: direction([position[0] - other[0], position[1] - other[1]]) }
    }

    fn has_direction(&self) -> bool {
        self.outward != [0, 0]
    }
}

/// Returns how badly two ends fit, 0 to 2 × [`ONE`]; `None` if they may not be joined.
fn score(from: &End, to: &End, rules: &ChainRules) -> Option<u32> {
    let delta = [to.position[0] - from.position[0], to.position[1] - from.position[1]];
    let reach_squared = rules.reach_units * rules.reach_units;
    // The ends are in neighbouring cells: the distance is less than 2D in each direction, so its square fits.
    let distance_squared = dot(delta, delta) as u32;
    if distance_squared > reach_squared {
        return None;
    }
    let onward = to.outward.map(|component| -component);
    let cosine = if from.has_direction() && to.has_direction() {
        cos_squared(from.outward, onward).filter(|cosine| *cosine >= rules.min_cos_squared)?
    } else {
        rules.min_cos_squared
    };
    if is_behind(delta, from.outward) || is_behind(delta.map(|component| -component), to.outward) {
        return None;
    }
    Some(ONE * distance_squared / reach_squared + ONE - cosine)
}

/// Returns whether a point at `delta` is behind an end by more than the allowed overlap.
fn is_behind(delta: [i32; 2], outward: [i32; 2]) -> bool {
    let along = i64::from(dot(delta, outward));
    let overlap = i64::from(ChainRules::OVERLAP_UNITS);
    along < 0 && along * along > overlap * overlap * i64::from(dot(outward, outward))
}

/// Returns cos² of the angle between two directions, times [`ONE`], rounded down; `None` if they are opposed.
fn cos_squared(u: [i32; 2], v: [i32; 2]) -> Option<u32> {
    let along = u32::try_from(dot(u, v)).ok()?;
    let whole = (dot(u, u) * dot(v, v)) as u32;
    // Only the first 19 bits count: the GPU has no more room for the factor.
    let shift = bit_count(whole).saturating_sub(19);
    Some(((along * along) >> shift) * ONE / (whole >> shift))
}

/// Returns the state that begins each chain, in arbitrary order. State s enters its segment at end s and leaves it at
/// end s ^ 1.
fn heads(segments: &[Segment], links: &[Option<u32>]) -> Vec<u32> {
    let rank = |end: u32| (segments[end as usize / 2].key, end);
    let mut heads = Vec::new();
    let mut seen = vec![false; segments.len()];
    // Open chains begin at the lesser of their two free ends.
    for end in (0..links.len() as u32).filter(|&end| links[end as usize].is_none()) {
        let last = run(links, end).inspect(|&state| seen[state as usize / 2] = true).last().unwrap_or(end);
        if rank(end) < rank(last ^ 1) {
            heads.push(end);
        }
    }
    // The remaining segments are in loops. Each loop begins with its least segment, from a to b.
    for segment in 0..segments.len() as u32 {
        if !seen[segment as usize] {
            let states = run(links, 2 * segment).inspect(|&state| seen[state as usize / 2] = true);
            let least = states.map(|state| state / 2).min_by_key(|&segment| rank(2 * segment)).unwrap_or(segment);
            heads.push(2 * least);
        }
    }
    heads
}

/// Returns the states from `head` on, once around if they are a loop.
fn run(links: &[Option<u32>], head: u32) -> impl Iterator<Item = u32> {
    std::iter::successors(Some(head), move |state| links[(state ^ 1) as usize].filter(|next| *next != head))
}

/// Appends the chain that begins with a state.
fn append(chained: &mut Chained, segments: &[Segment], links: &[Option<u32>], head: u32) {
    let chain = chained.chains.len() as u32;
    let first = chained.ordered.len() as u32;
    let mut length_units = 0_u32;
    for state in run(links, head) {
        if state != head
            && let Some(left) = links[state as usize]
        {
            length_units = length_units.wrapping_add(between_units(segments, left, state));
        }
        chained.ordered.push(state);
        chained.places.push(ChainPosition { chain, begin_units: length_units });
        length_units = length_units.wrapping_add(between_units(segments, state, state ^ 1));
    }
    let closing = links[head as usize];
    if let Some(last) = closing {
        length_units = length_units.wrapping_add(between_units(segments, last, head));
    }
    chained.chains.push(Chain {
        first,
        count: chained.ordered.len() as u32 - first,
        is_closed: u32::from(closing.is_some()),
        key: segments[head as usize / 2].key,
        length_units,
        padding: [0; 3],
    });
}

fn position(segments: &[Segment], end: u32) -> [i32; 2] {
    let segment = &segments[end as usize / 2];
    (if end.is_multiple_of(2) { segment.a } else { segment.b }).map(|units| units.clamp(-LIMIT_UNITS, LIMIT_UNITS))
}

/// Returns a vector's direction, with components below 128, so that products of four of them fit 32 bits.
fn direction(delta: [i32; 2]) -> [i32; 2] {
    let shift = bit_count(largest(delta)).saturating_sub(7);
    delta.map(|component| component.signum() * (component.abs() >> shift))
}

/// Returns the distance between two ends, rounded down. From 2¹⁵ on the last bits are lost.
fn between_units(segments: &[Segment], from: u32, to: u32) -> u32 {
    let (from, to) = (position(segments, from), position(segments, to));
    let delta = [to[0] - from[0], to[1] - from[1]];
    let shift = bit_count(largest(delta)).saturating_sub(15);
    let [x, y] = delta.map(|component| component.unsigned_abs() >> shift);
    (x * x + y * y).isqrt() << shift
}

fn largest(v: [i32; 2]) -> u32 {
    v[0].unsigned_abs().max(v[1].unsigned_abs())
}

fn bit_count(value: u32) -> u32 {
    u32::BITS - value.leading_zeros()
}

fn dot(u: [i32; 2], v: [i32; 2]) -> i32 {
    u[0] * v[0] + u[1] * v[1]
}
