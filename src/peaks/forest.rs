//! Forests that hold how the summits of a part of the DEM are connected, and their reduction to what may still matter.
//!
//! For two samples p and q, let B(p, q) be the highest sample to which one has to descend on the best way from p to q
//! (their bottleneck, in the order of [`Sample`], which has no ties). The key saddle of a summit p is K(p), the maximum
//! of B(p, q) over all samples q that are higher than p, and its prominence is the height of p above K(p) (Kirmse and
//! de Ferranti 2017, "Calculating the prominence and isolation of every mountain in the world").
//!
//! A forest has B for its nodes: it is the lowest saddle on the path between them. Nodes are connected from the highest
//! saddle down with union-find, and of the two parts that a saddle connects, the one with the lower summit ends there
//! (the elder rule of persistent homology).
//!
//! # Why the reduction is exact
//! The front is the set of samples of this part of the DEM through which it is connected with the rest. When a saddle s
//! connects a part A with another part, everything in A is above s.
//!
//! 1. *A has no sample of the front above s.* Every way out of A goes through s or lower. So K of the lower summit
//!    cannot change any more if that summit is in A: it is reported, and A becomes a piece of the other part. Samples
//!    of the front that belong to A are not above s, so for them the other part is as good as A. The ended summit p
//!    isn't needed as a higher sample for others either: whoever reaches p comes through s, and from there reaches the
//!    higher summit of the other part as well.
//! 2. *A has a sample of the front above s.* Then the rest of the DEM may connect it at a higher saddle, and A remains
//!    a node of its own with an edge of saddle s. Its summit p may only be forgotten if p is not prominent enough even
//!    above s: K(p) can become higher, never lower.
//!
//! Forgetting summits whose prominence is less than L changes no prominence of at least L, and makes none of less than
//! L reach L. *Proof.* Let K(p) = B(p, q), with q higher than p but forgotten. The prominence of q is less than L, so a
//! sample q′ higher than q has B(q, q′) above q − L. If p has a prominence of at least L, then B(p, q) is at p − L or
//! lower, and p − L ≤ q − L. So B(p, q′) ≥ min(B(p, q), B(q, q′)) = B(p, q) = K(p), and q′ serves as well as q. If the
//! prominence of p is less than L, both B(p, q) and B(q, q′) are above p − L, and so is B(p, q′): the prominence stays
//! less than L. If q′ is forgotten too, the same holds for the next one; the highest summit of a region is never
//! forgotten. ∎
//!
//! Only the rounded difference of two heights is compared with L. Rounding is monotone, so the proof holds for it as
//! well.

use super::sample::{NO_DATA, Sample};

/// Stands for no node.
pub(super) const NO_NODE: u32 = u32::MAX;

/// A summit, or a set of samples from which one comes to the front.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    /// The summit; [`Sample::NONE`] if it has been forgotten.
    pub peak: Sample,
    /// The highest sample of the front from which one can climb to the node; [`Sample::NONE`] if there is none.
    pub front: Sample,
    /// The highest level at which land that ends at unknown land is connected to the node; [`Sample::NONE`] if none is.
    pub open: Sample,
    /// The ordered height of the lowest sample that belongs to the node, or more; `u32::MAX` if it isn't known.
    pub lowest: u32,
}

/// A connection of two nodes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    /// The sample to which one has to descend between the two nodes.
    pub saddle: Sample,
    pub nodes: [u32; 2],
}

/// How nodes are connected.
#[derive(Clone, Debug, Default)]
pub(super) struct Forest {
    pub nodes: Vec<Node>,
    pub edges: Vec<Edge>,
}

/// A summit whose prominence is final.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub peak: Sample,
    /// The key saddle; [`Sample::NONE`] for the highest summit of a region.
    pub saddle: Sample,
    /// The highest sample to which one has to descend on the way to unknown land; [`Sample::NONE`] if it isn't above
    /// the saddle.
    pub runoff: Sample,
    /// The ordered height of the lowest sample of the region, if this is its highest summit.
    pub lowest: u32,
}

/// The least prominence of interest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Threshold {
    pub least_m: f64,
}

impl Threshold {
    /// Returns whether a prominence is of interest. A prominence of zero never is: plateaus would have several summits.
    pub(super) fn keeps(self, prominence_m: f32) -> bool {
        prominence_m > 0.0 && f64::from(prominence_m) >= self.least_m
    }
}

/// The result of a reduction.
pub(super) struct Reduced {
    pub forest: Forest,
    /// The new number of each old node; [`NO_NODE`] for regions that the front doesn't touch.
    pub renumbered: Vec<u32>,
    /// The summits that have ended.
    pub found: Vec<Found>,
}

/// A set of nodes that are connected above the current saddle.
#[derive(Clone, Copy)]
struct Part {
    /// The highest summit.
    best: Sample,
    /// The node that has the highest summit.
    best_node: u32,
    /// The highest sample to which one has to descend from the highest summit on the way to unknown land.
    runoff: Sample,
    /// As in [`Node`], for the part as a whole.
    open: Sample,
    front: Sample,
    lowest: u32,
    /// A node of the part that hasn't become a piece of another node.
    node: u32,
}

/// Reduces a forest to what the rest of the DEM may still change, and finds the summits that have ended.
pub(super) fn reduce(forest: Forest, threshold: Threshold) -> Reduced {
    let Forest { nodes, mut edges } = forest;
    edges.sort_unstable_by_key(|edge| std::cmp::Reverse(edge.saddle));
    let mut reduction = Reduction::new(nodes, threshold);
    for edge in edges {
        reduction.connect(edge);
    }
    reduction.finish()
}

struct Reduction {
    threshold: Threshold,
    nodes: Vec<Node>,
    /// The node of which each node has become a piece; itself if it has not.
    piece_of: Vec<u32>,
    /// Union-find over the nodes: the parent of each, itself for the root of a part.
    parents: Vec<u32>,
    /// The part of each root.
    parts: Vec<Part>,
    edges: Vec<Edge>,
    found: Vec<Found>,
}

impl Reduction {
    fn new(nodes: Vec<Node>, threshold: Threshold) -> Self {
        let part = |(at, node): (u32, &Node)| Part {
            best: node.peak,
            best_node: at,
            runoff: node.open,
            open: node.open,
            front: node.front,
            lowest: node.lowest,
            node: at,
        };
        let parts = (0..).zip(&nodes).map(part).collect();
        let numbers: Vec<u32> = (0..).take(nodes.len()).collect();
        let (edges, found) = (Vec::new(), Vec::new());
        Self { threshold, nodes, piece_of: numbers.clone(), parents: numbers, parts, edges, found }
    }

    /// Connects two parts, unless they are connected already.
    fn connect(&mut self, edge: Edge) {
        let saddle = edge.saddle;
        let roots = edge.nodes.map(|node| root(&mut self.parents, node));
        if roots[0] == roots[1] {
            return;
        }
        let is_in_front = |part: &Part| part.front > saddle;
        // Of two parts without a summit, the one that has a sample of the front remains.
        let rank = |root: u32| (self.parts[root as usize].best, is_in_front(&self.parts[root as usize]));
        let [winner, loser] = if rank(roots[0]) >= rank(roots[1]) { roots } else { [roots[1], roots[0]] };
        let (won, lost) = (self.parts[winner as usize], self.parts[loser as usize]);
        let is_kept = lost.best != Sample::NONE && self.threshold.keeps(lost.best.height_m() - saddle.height_m());
        if is_in_front(&lost) {
            self.edges.push(Edge { saddle, nodes: [lost.node, won.node] });
            if !is_kept {
                self.nodes[lost.best_node as usize].peak = Sample::NONE;
            }
        } else {
            if is_kept {
                let runoff = if lost.runoff > saddle { lost.runoff } else { Sample::NONE };
                self.found.push(Found { peak: lost.best, saddle, runoff, lowest: NO_DATA });
            }
            self.piece_of[lost.node as usize] = won.node;
            let into = &mut self.nodes[won.node as usize];
            into.open = into.open.max(lost.open.min(saddle));
            into.lowest = into.lowest.min(lost.lowest);
        }
        self.parents[loser as usize] = winner;
        self.parts[winner as usize] = Part {
            runoff: won.runoff.max(lost.open.min(saddle)),
            open: won.open.max(lost.open),
            front: won.front.max(lost.front),
            lowest: won.lowest.min(lost.lowest),
            ..won
        };
    }

    /// Reports the summits of the regions that the front doesn't touch, and renumbers what remains.
    fn finish(mut self) -> Reduced {
        for (at, parent) in (0..).zip(&self.parents) {
            let part = self.parts[at as usize];
            if *parent == at && part.front == Sample::NONE {
                let (peak, runoff, lowest) = (part.best, part.runoff, part.lowest);
                self.found.push(Found { peak, saddle: Sample::NONE, runoff, lowest });
                self.piece_of[part.node as usize] = NO_NODE;
            }
        }
        let mut renumbered = vec![NO_NODE; self.nodes.len()];
        let mut nodes = Vec::new();
        for (at, node) in self.nodes.iter().enumerate() {
            if self.piece_of[at] == at as u32 {
                renumbered[at] = nodes.len() as u32;
                // The front moves on before the next reduction.
                nodes.push(Node { front: Sample::NONE, ..*node });
            }
        }
        for at in 0..self.nodes.len() as u32 {
            let whole = root_or_none(&mut self.piece_of, at);
            if whole != NO_NODE {
                renumbered[at as usize] = renumbered[whole as usize];
            }
        }
        for edge in &mut self.edges {
            edge.nodes = edge.nodes.map(|node| renumbered[node as usize]);
        }
        Reduced { forest: Forest { nodes, edges: self.edges }, renumbered, found: self.found }
    }
}

/// Returns the root of an element of a union-find, and shortens the way to it (path halving).
fn root(parents: &mut [u32], mut at: u32) -> u32 {
    while parents[at as usize] != at {
        let next = parents[parents[at as usize] as usize];
        parents[at as usize] = next;
        at = next;
    }
    at
}

/// Returns the root of an element of a union-find in which roots may be marked with [`NO_NODE`].
fn root_or_none(parents: &mut [u32], mut at: u32) -> u32 {
    loop {
        let parent = parents[at as usize];
        if parent == at || parent == NO_NODE {
            return parent;
        }
        let next = parents[parent as usize];
        if next == NO_NODE {
            return NO_NODE;
        }
        parents[at as usize] = next;
        at = next;
    }
}
