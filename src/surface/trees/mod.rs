//! Trees of a forest: those that an eye may see are found on the GPU in each frame, and drawn as instances.
//!
//! The CPU lists the cells that the eye's frustum may see ([`crate::forest::cells`]); each of their points is asked on
//! the GPU whether a tree stands there ([`place`]), and nothing is read back: the draw is indirect.

pub mod place;
pub mod raster;
pub mod resolve;

use std::convert::Infallible;
use std::sync::Arc;

pub use self::place::{MOST_TREES, TreeInstance};
use self::place::{TreePoint, TreeVertex};
use crate::forest::points::Points;
use crate::forest::{CELL_M, CELLS, TILE_M, conifer};
use crate::gpu::Gpu;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Cx;

/// [`TreePoint`]s of a tile.
const POINTS: BufferKind = BufferKind::storage("tree points");
/// [`TreeVertex`]s of a species.
const VERTICES: BufferKind = BufferKind::storage("tree vertices");
/// [`TreeInstance`]s of an eye.
pub const INSTANCES: BufferKind = BufferKind::storage("tree instances");
/// Arguments of the draw: vertices of a tree, trees in view, and the first of each.
pub const DRAW: BufferKind = BufferKind::indirect("tree draw");

/// What all forests share.
struct Shared {
    starts: Vec<u32>,
    points: Buffer,
    vertices: Buffer,
    vertex_count: u32,
}

impl Shared {
    fn new(gpu: &Gpu) -> Self {
        let Points { points, starts } = Points::new();
        // In its cell.
        let in_cell_m = |along: f64| ((along * TILE_M) % CELL_M) as f32;
        let packed: Vec<TreePoint> = points
            .iter()
            .map(|point| TreePoint { at_m: point.at.map(in_cell_m), rank: point.rank as f32, ..TreePoint::default() })
            .collect();
        let vertices: Vec<TreeVertex> = conifer::grow()
            .into_iter()
            .map(|corner| TreeVertex {
                at: corner.at.as_vec3().extend(1.0).to_array(),
                normal: corner.normal.as_vec3().extend(0.0).to_array(),
            })
            .collect();
        debug_assert_eq!(starts.len(), (CELLS * CELLS + 1) as usize);
        Self {
            starts,
            points: Buffer::with(gpu, &POINTS, &packed),
            vertices: Buffer::with(gpu, &VERTICES, &vertices),
            vertex_count: vertices.len() as u32,
        }
    }
}

/// The trees of a frame.
pub struct DrawnTrees {
    shared: Arc<Shared>,
    instances: Buffer,
    draw: Buffer,
}

impl DrawnTrees {
    /// None are found yet.
    pub fn of(cx: &mut Cx<'_>) -> Self {
        let shared = cx.kept(|_: &Shared| true, |gpu| Ok::<_, Infallible>(Shared::new(gpu)));
        let Ok(shared) = shared;
        let bytes = u64::from(MOST_TREES) * size_of::<TreeInstance>() as u64;
        Self { shared, instances: cx.buffer(&INSTANCES, bytes), draw: cx.buffer(&DRAW, 16) }
    }
}
