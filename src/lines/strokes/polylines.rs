//! The strokes of the last frame, read back as polylines: for files that hold lines, never inside an interactive frame.
//!
//! A stroke is a chain: its points lie one after the other (`shaders/lines/strokes/points.wgsl`), its kind is that of
//! the edges that make up most of its length. What `shaders/lines/strokes/stroke.wgsl` computes for each pixel of a
//! stroke, its width and its ink, `Pen` computes for each point. Long ways between points get more of them, so that
//! a line between two neighbours' widths is near what is drawn.

use super::{Chain, Edge, MOST_EDGES, Piece, StrokeCounts, StrokePasses, StrokesUniform, UNITS_PER_PX};
use crate::gpu::readback::read_buffer;
use crate::gpu::{Gpu, GpuError};
use crate::lines::strokes::points::Point;

/// What a stroke follows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum EdgeKind {
    /// Where the surface turns away from the eye.
    #[default]
    Contour,
    /// Where the land ends.
    Border,
    /// Where the surface is sharply bent.
    Crease,
}

impl EdgeKind {
    /// All of them, in the order in which they are drawn.
    pub const ALL: [Self; 3] = [Self::Contour, Self::Border, Self::Crease];

    /// From `Edge::kind`.
    fn of(number: u32) -> Self {
        match number {
            1 => Self::Border,
            2 => Self::Crease,
            _ => Self::Contour,
        }
    }
}

/// A visible stroke as it is drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Polyline {
    /// At least two. A closed one runs on from the last to the first, which is not repeated.
    pub points: Vec<PolylinePoint>,
    /// What it follows.
    pub kind: EdgeKind,
    /// Its number in the frame: one less than in the picture of stroke numbers.
    pub stroke: u32,
    /// Whether its end runs on into its beginning.
    pub is_closed: bool,
}

/// A point of a [`Polyline`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PolylinePoint {
    /// On the picture, x to the right and y down, from its upper left corner.
    pub px: [f32; 2],
    /// Half of the stroke's width there.
    pub half_width_px: f32,
    /// How much ink there is: 0 none, 1 full.
    pub ink: f32,
}

/// Ways between points are no longer than this.
const STEP_PX: f32 = 4.0;

impl StrokePasses {
    /// Reads the strokes of the last frame, as many as were drawn: those shorter than the style's `shortest_px` were
    /// not. They stand in the order of their numbers. Waits for the GPU.
    ///
    /// # Errors
    /// [`GpuError::Readback`] when the device is lost or out of memory.
    pub fn read_polylines(&self, gpu: &Gpu) -> Result<Vec<Polyline>, GpuError> {
        let lists = &self.lists;
        let counts: Vec<StrokeCounts> = read_buffer(gpu, lists.counts.buffer(), 1)?;
        let uniform: Vec<StrokesUniform> = read_buffer(gpu, lists.uniform.buffer(), 1)?;
        let (Some(counts), Some(uniform)) = (counts.first(), uniform.first()) else { return Ok(Vec::new()) };
        if counts.edges_lost > 0 || counts.pieces_lost > 0 {
            let (edges, pieces) = (counts.edges_lost, counts.pieces_lost);
            tracing::warn!("{edges} edges and {pieces} pieces of strokes found no room: they are missing");
        }
        let edges: Vec<Edge> = read_buffer(gpu, lists.edges.buffer(), counts.edges.min(MOST_EDGES) as usize)?;
        let pieces: Vec<Piece> = read_buffer(gpu, lists.pieces.buffer(), counts.pieces as usize)?;
        let ordered: Vec<u32> = read_buffer(gpu, self.chain.ordered(), counts.pieces as usize)?;
        let chains: Vec<Chain> = read_buffer(gpu, self.chain.chains(), counts.chains as usize)?;
        let points: Vec<Point> = read_buffer(gpu, self.points.list().buffer(), counts.points as usize)?;
        let lists = Read { edges, pieces, ordered, points };
        let pen = Pen::new(uniform);
        Ok((0..).zip(&chains).filter_map(|(number, chain)| lists.polyline(number, chain, &pen)).collect())
    }
}

/// What was read.
struct Read {
    edges: Vec<Edge>,
    pieces: Vec<Piece>,
    ordered: Vec<u32>,
    points: Vec<Point>,
}

impl Read {
    /// None if it is not drawn.
    fn polyline(&self, number: u32, chain: &Chain, pen: &Pen) -> Option<Polyline> {
        let first = (chain.first + number) as usize;
        let points = self.points.get(first..=first + chain.count as usize)?;
        // In whole 1/16 px, as `lengths.wgsl` has them: what is just long enough there is so here.
        let in_units = |px: f32| (px * UNITS_PER_PX).round() / UNITS_PER_PX;
        let steps_px: Vec<f32> = points.windows(2).map(|pair| in_units(distance_px(pair[0].px, pair[1].px))).collect();
        let length_px = steps_px.iter().sum();
        if pen.leaves_out(length_px) || !points.iter().flat_map(|point| point.px).all(f32::is_finite) {
            return None;
        }
        let mut line = Vec::with_capacity(points.len());
        let mut along_px = 0.0;
        for (pair, step_px) in points.windows(2).zip(&steps_px) {
            let parts = (step_px / STEP_PX).ceil().max(1.0) as usize;
            for part in 0..parts {
                let t = part as f32 / parts as f32;
                line.push(pen.point(mix(&pair[0], &pair[1], t), along_px + t * step_px, length_px));
            }
            along_px += step_px;
        }
        let is_closed = chain.is_closed == 1;
        if let (Some(last), false) = (points.last(), is_closed) {
            line.push(pen.point(*last, along_px, length_px));
        }
        Some(Polyline { points: line, kind: self.kind(chain), stroke: number, is_closed })
    }

    /// The kind of most of its length.
    fn kind(&self, chain: &Chain) -> EdgeKind {
        let mut lengths = EdgeKind::ALL.map(|kind| (0.0, kind));
        for entry in self.ordered.iter().skip(chain.first as usize).take(chain.count as usize) {
            let Some(piece) = self.pieces.get((entry >> 1) as usize) else { continue };
            let Some(edge) = self.edges.get(piece.edge as usize) else { continue };
            let [a, b] = [piece.a, piece.b].map(|end| end.map(|units| units as f32 / UNITS_PER_PX));
            // Pieces of no length count a little.
            lengths[EdgeKind::of(edge.kind) as usize].0 += distance_px(a, b) + 1e-3;
        }
        // Of equals the first.
        lengths.into_iter().rev().max_by(|a, b| f32::total_cmp(&a.0, &b.0)).map_or(EdgeKind::Contour, |(_, kind)| kind)
    }
}

fn distance_px(a: [f32; 2], b: [f32; 2]) -> f32 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

fn mix(a: &Point, b: &Point, t: f32) -> Point {
    let px = [0, 1].map(|i| a.px[i] + (b.px[i] - a.px[i]) * t);
    Point { px, depth_m: a.depth_m + (b.depth_m - a.depth_m) * t, chain: a.chain }
}

/// Width and ink, as in `shaders/lines/strokes/stroke.wgsl`.
struct Pen {
    half_width_px: f32,
    taper_px: f32,
    haze_m: f32,
    faintest: f32,
    depth_width: f32,
    shortest_px: f32,
}

impl Pen {
    fn new(uniform: &StrokesUniform) -> Self {
        let StrokesUniform { half_width_px, taper_px, haze_m, faintest, depth_width, shortest_px, .. } = *uniform;
        Self { half_width_px, taper_px, haze_m, faintest, depth_width, shortest_px }
    }

    fn leaves_out(&self, length_px: f32) -> bool {
        length_px < self.shortest_px
    }

    /// At `along_px` from the beginning of a stroke of `length_px`.
    fn point(&self, at: Point, along_px: f32, length_px: f32) -> PolylinePoint {
        let nearness = (self.haze_m / at.depth_m.max(1.0) * 0.05).clamp(0.3, 1.6);
        let half_width_px = self.half_width_px * (1.0 + (nearness - 1.0) * self.depth_width);
        let taper_px = self.taper_px.min(0.5 * length_px) + 1e-3;
        let pressure = (along_px.min(length_px - along_px) / taper_px).clamp(0.0, 1.0);
        let t = at.depth_m / self.haze_m;
        PolylinePoint {
            px: at.px,
            half_width_px: (half_width_px * (0.35 + 0.65 * pressure.sqrt())).max(0.4),
            ink: self.faintest + (1.0 - self.faintest) * (-t * t).exp(),
        }
    }
}
