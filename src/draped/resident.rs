//! The blocks of features in view on the GPU: a buffer of slots, of which the least recently used one is reused.

use std::sync::Arc;

use glam::DVec2;
use rustc_hash::FxHashMap;

use super::areas::{AreaPosition, AreaTree};
use super::tree::BLOCK_POINTS;
use super::{Draped, DrawnBlock, KEPT_RULES, PartKind, Rule};
use crate::gpu::Gpu;
use crate::gpu::bind::Named;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::wgsl::lines::draped::pieces::DrapedPoint;
use crate::scene::view::Rig;
use crate::style::Features;
use crate::tiles::earth_curvature::EarthCurvature;

/// Points of blocks.
const POINTS: BufferKind = BufferKind::storage("draped points");
/// Areas, and a bit for each of them.
const AREA_CELLS: BufferKind = BufferKind::storage("cells of areas");
const AREA_EDGES: BufferKind = BufferKind::storage("edges of areas");
const AREA_OWNERS: BufferKind = BufferKind::storage("areas of edges");
const AREA_COVERS: BufferKind = BufferKind::storage("areas of cells");
const AREAS_FILLED: BufferKind = BufferKind::storage("filled areas");
/// Largest number of blocks of all layers in a view: 32 MB of points. Each point of a file is a block.
const MOST_BLOCKS: usize = 1 << 15;
/// Least number of slots.
const LEAST_SLOTS: usize = 64;
/// Bytes of a slot.
const SLOT_BYTES: u64 = (BLOCK_POINTS * size_of::<DrapedPoint>()) as u64;

/// The features of a world, with the blocks that are on the GPU.
pub(crate) struct Resident {
    draped: Arc<Draped>,
    points: Option<Buffer>,
    /// Slot of each block that is on the GPU.
    slot_of: FxHashMap<u32, u32>,
    slots: Vec<Slot>,
    /// Number of views that have been followed.
    views: u64,
    /// Whether a view with too many blocks has been reported.
    has_warned: bool,
    /// The blocks that each layer of the last view's style draws.
    layers: Vec<LayerInView>,
    /// The areas, once a layer has filled any.
    areas: Option<AreaBuffers>,
    /// The areas that layers fill; `None` for a layer that fills none.
    filled: Vec<(Rule, Option<Buffer>)>,
}

/// The blocks and areas that a layer of the last view's style draws.
struct LayerInView {
    blocks: Vec<BlockInView>,
    filled: Option<Buffer>,
}

/// The land of a view.
pub(crate) struct LandInView<'a> {
    /// Lowest and highest height, in metres.
    pub range_m: [f64; 2],
    /// Returns the curvature of the earth for a camera at a height.
    pub earth_curvature: &'a dyn Fn(f64) -> EarthCurvature,
}

/// A place for a block.
#[derive(Clone, Copy)]
struct Slot {
    block: Option<u32>,
    /// The last view that drew the block.
    used_in: u64,
}

/// A block in view, with its place on the GPU.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BlockInView {
    /// East and north of the block's origin in the world, in metres.
    pub origin_m: DVec2,
    /// Index of its first point.
    pub first: u32,
    /// Number of its points.
    pub count: u32,
}

/// The lines, points and filled areas that a layer draws.
pub(crate) struct ResidentLayer<'a> {
    pub blocks: &'a [BlockInView],
    /// The points of the blocks; `None` if no layer has any.
    pub points: Option<&'a Buffer>,
    pub fill: Option<ResidentFill<'a>>,
}

/// The areas of a world, and which of them a layer fills.
pub(crate) struct ResidentFill<'a> {
    areas: &'a AreaTree,
    buffers: &'a AreaBuffers,
    filled: &'a Buffer,
}

/// The areas of a world on the GPU.
struct AreaBuffers {
    cells: Buffer,
    edges: Buffer,
    owners: Buffer,
    covers: Buffer,
}

impl AreaBuffers {
    fn new(gpu: &Gpu, areas: &AreaTree) -> Self {
        Self {
            cells: Buffer::with(gpu, &AREA_CELLS, &areas.cells),
            edges: Buffer::with(gpu, &AREA_EDGES, &areas.edges),
            owners: Buffer::with(gpu, &AREA_OWNERS, &areas.owners),
            covers: Buffer::with(gpu, &AREA_COVERS, &areas.covers),
        }
    }
}

impl ResidentFill<'_> {
    /// Returns the position of a place of the world.
    pub(crate) fn position(&self, at_m: DVec2) -> AreaPosition {
        self.areas.position(at_m)
    }

    /// Returns the length of a unit in metres, and the binary logarithm of the width of the largest cell in units.
    pub(crate) fn unit(&self) -> (f64, u32) {
        (self.areas.unit_m(), self.areas.root_bits)
    }

    /// Returns the buffers by the names of the shader.
    pub(crate) fn resources(&self) -> [Named; 5] {
        let AreaBuffers { cells, edges, owners, covers } = self.buffers;
        [
            ("cells", cells.binding()),
            ("edges", edges.binding()),
            ("owners", owners.binding()),
            ("covers", covers.binding()),
            ("filled", self.filled.binding()),
        ]
    }
}

impl Resident {
    pub(crate) fn new(draped: Arc<Draped>) -> Self {
        Self {
            draped,
            points: None,
            slot_of: FxHashMap::default(),
            slots: Vec::new(),
            views: 0,
            has_warned: false,
            layers: Vec::new(),
            areas: None,
            filled: Vec::new(),
        }
    }

    /// Returns whether there are features of files, and whether there is a graticule.
    pub(crate) fn has_features_and_graticule(&self) -> [bool; 2] {
        self.draped.has_features_and_graticule()
    }

    /// Returns whether a layer of a style has areas to fill.
    pub(crate) fn fills_any(&self, layer: &Features) -> bool {
        self.draped.fills_any(layer)
    }

    /// Returns what is wrong with the layers of a style, each as a clause.
    pub(crate) fn doubts(&self, layers: &[&Features]) -> Vec<String> {
        self.draped.doubts(layers)
    }

    /// Sends the blocks to the GPU that layers of a style draw in a view of land.
    pub(crate) fn follow(&mut self, gpu: &Gpu, layers: &[&Features], rig: &Rig, land: &LandInView<'_>) {
        self.views += 1;
        let mut chosen: Vec<Vec<DrawnBlock>> = Vec::new();
        let (mut room, mut left_out) = (MOST_BLOCKS, 0);
        for (index, layer) in layers.iter().enumerate() {
            // Later layers may use the room that a layer does not need.
            let in_view = self.draped.blocks_in_view(layer, rig, land, room / (layers.len() - index));
            room -= in_view.blocks.len();
            left_out += in_view.left_out;
            chosen.push(in_view.blocks);
        }
        if left_out > 0 && !std::mem::replace(&mut self.has_warned, true) {
            tracing::warn!(
                "features: {left_out} lines and points in view are not drawn, because more than {MOST_BLOCKS} are in view; \
                 choose fewer with features.when"
            );
        }
        let needed: usize = chosen.iter().map(Vec::len).sum();
        if needed > self.slots.len() {
            let count = needed.next_power_of_two().clamp(LEAST_SLOTS, MOST_BLOCKS);
            self.points = Some(Buffer::new(gpu, &POINTS, count as u64 * SLOT_BYTES));
            self.slots = vec![Slot { block: None, used_in: 0 }; count];
            self.slot_of.clear();
        }
        let mut missing: Vec<u32> = Vec::new();
        for block in chosen.iter().flatten() {
            match self.slot_of.get(&block.index).and_then(|slot| self.slots.get_mut(*slot as usize)) {
                Some(slot) => slot.used_in = self.views,
                None => missing.push(block.index),
            }
        }
        missing.sort_unstable();
        missing.dedup();
        self.send(gpu, &missing);
        let (tree, slot_of) = (&self.draped.tree, &self.slot_of);
        let placed = |block: &DrawnBlock| {
            let slot = *slot_of.get(&block.index)?;
            let count = tree.points(tree.blocks().get(block.index as usize)?).len() as u32;
            Some(BlockInView { origin_m: block.origin_m, first: slot * BLOCK_POINTS as u32, count })
        };
        let blocks: Vec<Vec<BlockInView>> =
            chosen.iter().map(|blocks| blocks.iter().filter_map(placed).collect()).collect();
        let mut in_view = Vec::with_capacity(layers.len());
        for (blocks, layer) in blocks.into_iter().zip(layers) {
            in_view.push(LayerInView { blocks, filled: self.filled_by(gpu, layer) });
        }
        self.layers = in_view;
    }

    /// Returns which areas a layer fills, and sends areas to the GPU for the first layer that fills any.
    fn filled_by(&mut self, gpu: &Gpu, layer: &Features) -> Option<Buffer> {
        let rule = Rule::of(layer);
        if let Some((_, filled)) = self.filled.iter().find(|(known, _)| *known == rule) {
            return filled.clone();
        }
        let draped = Arc::clone(&self.draped);
        let filled = draped.filled_by(&rule).map(|(areas, bits)| {
            self.areas.get_or_insert_with(|| AreaBuffers::new(gpu, areas));
            Buffer::with(gpu, &AREAS_FILLED, &bits)
        });
        if self.filled.len() >= KEPT_RULES {
            self.filled.remove(0);
        }
        self.filled.push((rule, filled.clone()));
        filled
    }

    /// Sends blocks into the slots that have not been used for longest.
    fn send(&mut self, gpu: &Gpu, missing: &[u32]) {
        let mut free: Vec<u32> = (0..self.slots.len() as u32).collect();
        free.retain(|slot| self.slots[*slot as usize].used_in < self.views);
        free.sort_by_key(|slot| (self.slots[*slot as usize].used_in, *slot));
        free.truncate(missing.len());
        // Neighbouring slots are written together.
        free.sort_unstable();
        let mut run: Vec<DrapedPoint> = Vec::new();
        let mut first = 0;
        for (block, slot) in missing.iter().zip(free) {
            if !run.is_empty() && first as usize + run.len() / BLOCK_POINTS != slot as usize {
                self.write(gpu, first, &run);
                run.clear();
            }
            if run.is_empty() {
                first = slot;
            }
            run.extend(self.points_of(*block));
            run.resize(run.len().next_multiple_of(BLOCK_POINTS), DrapedPoint::default());
            if let Some(evicted) = self.slots[slot as usize].block.replace(*block) {
                self.slot_of.remove(&evicted);
            }
            self.slots[slot as usize].used_in = self.views;
            self.slot_of.insert(*block, slot);
        }
        self.write(gpu, first, &run);
    }

    fn write(&self, gpu: &Gpu, first: u32, run: &[DrapedPoint]) {
        if let Some(points) = self.points.as_ref().filter(|_| !run.is_empty()) {
            gpu.queue.write_buffer(&points.raw, u64::from(first) * SLOT_BYTES, bytemuck::cast_slice(run));
        }
    }

    fn points_of(&self, block: u32) -> impl Iterator<Item = DrapedPoint> {
        let tree = &self.draped.tree;
        let block = tree.blocks().get(block as usize);
        let part = block.and_then(|block| self.draped.parts.get(block.feature as usize));
        let is_dot = u32::from(part.is_some_and(|part| part.kind == PartKind::Point));
        let points = block.map_or(&[][..], |block| tree.points(block));
        points.iter().map(move |point| DrapedPoint { at_m: point.at_m, along_m: point.along_m, is_dot })
    }

    /// Returns what a layer of the last view's style draws. `number` is that of the layer among those of its kind.
    pub(crate) fn layer(&self, number: usize) -> Option<ResidentLayer<'_>> {
        let LayerInView { blocks, filled } = self.layers.get(number)?;
        let fill = self.draped.areas.as_ref().zip(self.areas.as_ref()).zip(filled.as_ref());
        let fill = fill.map(|((areas, buffers), filled)| ResidentFill { areas, buffers, filled });
        let has_any = !blocks.is_empty() || fill.is_some();
        has_any.then_some(ResidentLayer { blocks, points: self.points.as_ref(), fill })
    }
}
