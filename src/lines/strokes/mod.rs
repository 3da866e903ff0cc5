//! Strokes: contour edges of the surface become pen lines, on the GPU (Pietrok 2021, sections 4.2 and 4.3, without its
//! list on the CPU).
//!
//! Edges of the surface as drawn ([`contour_edges`]) → the ID reference image ([`id_image`]) → visible pieces
//! ([`extract`]) → chains ([`chain`], specified by [`twin`]) → points ([`points`]) → samples ([`samples`]), which take
//! over from the frame before ([`carry`], when [`history`] says so) → ink ([`stroke`]), solid or through a [`texture`].
//! What a step counted, the next one dispatches or draws indirectly: nothing is read back within a frame. [`polylines`]
//! reads the strokes of a frame back afterwards, for files; [`left_out`] what found no room.
//!
//! Why: `docs/decisions/stroke-pipeline.md`.

pub mod carry;
pub mod chain;
pub mod contour_edges;
pub mod extract;
pub mod history;
pub mod id_image;
pub mod left_out;
pub mod mesh_edges;
pub mod mesh_sides;
pub mod points;
pub mod polylines;
mod records;
pub mod samples;
pub mod scan;
pub mod stroke;
pub mod texture;
pub mod twin;

use bytemuck::{Pod, Zeroable};

pub use self::left_out::{LeftOut, NumbersLater, StrokeNumbers};
pub use self::records::{Chain, ChainRules, Piece, Place, StrokeCounts, UNITS_PER_PX};
pub(crate) use self::records::{ChainPlan, ChainRulesUniform};
use self::samples::CarryUniform;
use self::stroke::Which;
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::pass::Named;
use crate::gpu::target::Target;
use crate::gpu::timer::Recorder;
use crate::gpu::{Gpu, GpuError};
use crate::style;
use crate::surface::mesh_vertices::MeshVerticesPass;
use crate::surface::view::View;

/// The passes in the order in which they first run.
pub const PASSES: &[&str] = &[
    "lines/strokes/contour_edges",
    "lines/strokes/scan_begin",
    "lines/strokes/scan",
    "lines/strokes/mesh_sides",
    "lines/strokes/mesh_edges",
    "lines/strokes/id_image",
    "lines/strokes/extract",
    "lines/strokes/chain_begin",
    "lines/strokes/chain_clear",
    "lines/strokes/chain_bin",
    "lines/strokes/chain_choose",
    "lines/strokes/chain_link",
    "lines/strokes/chain_rank_begin",
    "lines/strokes/chain_rank",
    "lines/strokes/chain_heads",
    "lines/strokes/chain_order",
    "lines/strokes/arguments",
    "lines/strokes/points",
    "lines/strokes/lengths",
    "lines/strokes/budget",
    "lines/strokes/budget_choose",
    "lines/strokes/sizes",
    "lines/strokes/samples",
    "lines/strokes/vote",
    "lines/strokes/carry",
    "lines/strokes/stroke",
    "lines/strokes/fading",
    "lines/strokes/keep",
    "lines/strokes/advance",
];

/// Of these, so many find edges.
pub const FINDING: usize = 5;
/// Of those, so many find them on the land, the others on the meshes of a scene that has some.
pub const FINDING_ON_LAND: usize = 3;

/// Edges in a frame, at most.
pub const MOST_EDGES: u32 = 1 << 20;
/// Pieces in a frame, at most.
pub const MOST_PIECES: u32 = 1 << 19;

/// `Edge` in `shaders/shared/strokes.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable, PartialEq)]
pub struct Edge {
    /// Camera-relative metres.
    pub a_m: [f32; 3],
    /// Lasts across frames while its patch is drawn.
    pub key: u32,
    /// Camera-relative metres.
    pub b_m: [f32; 3],
    /// 0 a contour, 1 the border of the land or of a mesh, 2 a crease.
    pub kind: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct StrokesUniform {
    crease_cosine: f32,
    borders: u32,
    resolution: f32,
    edge_capacity: u32,
    image_px: [u32; 2],
    piece_capacity: u32,
    half_width_px: f32,
    taper_px: f32,
    haze_m: f32,
    faintest: f32,
    depth_width: f32,
    shortest_px: f32,
    curve_width: f32,
    wobble_px: f32,
    padding: f32,
}

crate::gpu::shared::describe!(StrokesUniform as "Strokes" in "lines/strokes/extract": crease_cosine, borders, resolution, edge_capacity, image_px, piece_capacity, half_width_px, taper_px, haze_m, faintest, depth_width, shortest_px, curve_width, wobble_px, padding);
crate::gpu::shared::describe!(Edge as "Edge" in "lines/strokes/extract": a_m, key, b_m, kind);

/// The camera's place is told in blocks of this and a rest.
const BLOCK_M: f64 = 4096.0;

/// An indirect draw of lines, before an edge is found: two vertices will come for each, one instance.
const NO_EDGES: [u32; 4] = [0, 1, 0, 0];

/// The size of the ID reference image of a picture.
pub fn image_px(size_px: [u32; 2], resolution: f32) -> [u32; 2] {
    size_px.map(|side| ((side as f32 * resolution).ceil() as u32).max(1))
}

/// The lists that the passes hand to each other.
pub struct Lists {
    /// `Strokes` in `shaders/shared/stroke_edges.wgsl`.
    pub uniform: GrowingBuffer,
    /// [`StrokeCounts`].
    pub counts: GrowingBuffer,
    /// An indirect draw of the edges as lines.
    pub edge_draw: GrowingBuffer,
    /// [`Edge`]s.
    pub edges: GrowingBuffer,
    /// [`Piece`]s.
    pub pieces: GrowingBuffer,
}

impl Lists {
    /// Empty.
    pub fn new(gpu: &Gpu) -> Self {
        use wgpu::BufferUsages as Usage;
        let read = Usage::STORAGE | Usage::COPY_SRC;
        Self {
            uniform: GrowingBuffer::new(gpu, "strokes", Usage::UNIFORM | Usage::COPY_SRC),
            counts: GrowingBuffer::new(gpu, "stroke counts", read),
            edge_draw: GrowingBuffer::new(gpu, "edge draw", read | Usage::INDIRECT),
            edges: GrowingBuffer::new(gpu, "edges", read),
            pieces: GrowingBuffer::new(gpu, "pieces", read),
        }
    }

    fn strokes(&self) -> Named<'_> {
        ("strokes", self.uniform.binding())
    }

    fn counts(&self) -> Named<'_> {
        ("counts", self.counts.binding())
    }

    /// Makes room for a picture, and counts from zero.
    pub fn begin(&mut self, gpu: &Gpu, strokes: &style::Strokes, size_px: [u32; 2], haze_m: f64) {
        self.fit(gpu, strokes, size_px, haze_m);
        self.counts.write(gpu, &[StrokeCounts::default()]);
        self.edge_draw.write(gpu, &NO_EDGES);
    }

    /// Makes room for a picture whose strokes are those of the last one, with their counts.
    fn fit(&mut self, gpu: &Gpu, strokes: &style::Strokes, size_px: [u32; 2], haze_m: f64) {
        let image_px = image_px(size_px, strokes.resolution);
        let piece_capacity = (image_px[0].saturating_mul(image_px[1])).min(MOST_PIECES);
        self.uniform.write(
            gpu,
            &[StrokesUniform {
                crease_cosine: strokes.crease_deg.map_or(-2.0, |degrees| degrees.to_radians().cos()),
                borders: u32::from(strokes.borders),
                resolution: strokes.resolution,
                edge_capacity: MOST_EDGES,
                image_px,
                piece_capacity,
                half_width_px: strokes.width_px * 0.5,
                taper_px: strokes.taper_px,
                haze_m: haze_m as f32 * strokes.reach,
                faintest: strokes.faintest,
                depth_width: strokes.depth_width,
                shortest_px: strokes.shortest_px,
                curve_width: strokes.curve_width,
                wobble_px: strokes.wobble_px,
                padding: 0.0,
            }],
        );
        self.edges.reserve_exactly(gpu, u64::from(MOST_EDGES) * size_of::<Edge>() as u64);
        self.pieces.reserve_exactly(gpu, u64::from(piece_capacity) * size_of::<Piece>() as u64);
    }
}

/// The passes from edges to ink.
pub struct StrokePasses {
    lists: Lists,
    contour_edges: contour_edges::ContourEdgesPass,
    mesh_edges: Option<mesh_edges::MeshEdgesPass>,
    id_image: id_image::IdImagePass,
    extract: extract::ExtractPass,
    chain: chain::ChainPass,
    points: points::PointsPass,
    samples: samples::SamplesPass,
    carry: carry::CarryPass,
    stroke: stroke::StrokePass,
    scan: scan::ScanPass,
    history: history::History,
    plan: history::Plan,
}

impl StrokePasses {
    /// Builds the pipelines.
    ///
    /// # Errors
    /// [`GpuError::Limit`] when the lists are larger than the device can bind.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        Ok(Self {
            lists: Lists::new(gpu),
            contour_edges: contour_edges::ContourEdgesPass::new(gpu),
            mesh_edges: None,
            id_image: id_image::IdImagePass::new(gpu),
            extract: extract::ExtractPass::new(gpu),
            chain: chain::ChainPass::new(gpu, MOST_PIECES, ChainRules::default())?,
            points: points::PointsPass::new(gpu),
            samples: samples::SamplesPass::new(gpu),
            carry: carry::CarryPass::new(gpu),
            stroke: stroke::StrokePass::new(gpu),
            scan: scan::ScanPass::new(gpu),
            history: history::History::default(),
            plan: history::Plan {
                is_update: true,
                takes_over: false,
                step_m: glam::DVec3::ZERO,
                rests: false,
                frame: 0,
            },
        })
    }

    /// The lists of the last frame, for measurements.
    pub fn lists(&self) -> &Lists {
        &self.lists
    }

    /// The points of the last frame, for measurements.
    pub fn points(&self) -> &points::PointsPass {
        &self.points
    }

    /// The chains of the last frame, for measurements.
    pub fn chains(&self) -> &chain::ChainPass {
        &self.chain
    }

    /// The stroke texture of the last frame, for measurements.
    pub fn texture(&self) -> Option<&texture::StrokeTexture> {
        self.stroke.texture()
    }

    /// The samples of the last frame.
    pub fn samples(&self) -> &samples::SampleList {
        self.samples.now()
    }

    /// Whether strokes are still coming or going.
    pub fn is_settling(&self) -> bool {
        self.history.is_settling()
    }

    /// The next frame takes nothing over: its pictures are not those of the last one.
    pub fn forget(&mut self) {
        self.history.forget();
    }

    /// Begins a frame, a step after the last one: makes room for a picture. Says whether strokes are made
    /// anew: then edges are to be found and counted from zero, and [`StrokePasses::update`] draws; else
    /// [`StrokePasses::advance`] does.
    pub fn begin(
        &mut self,
        gpu: &Gpu,
        strokes: &style::Strokes,
        view: &View,
        haze_m: f64,
        step: history::Step,
    ) -> bool {
        self.plan = self.history.plan(strokes, view, step);
        let history::Plan { is_update, takes_over, step_m, rests, frame } = self.plan;
        let camera_m = view.pose.position_m;
        // By how much of the whole strokes come or go in this frame.
        let progress = step.step_s / f64::from(strokes.fade_s.max(1e-6));
        self.samples.begin(
            gpu,
            CarryUniform {
                step_m: step_m.as_vec3().to_array(),
                has_history: u32::from(takes_over || !is_update),
                pressure_step: progress.min(1.0) as f32,
                growth_px: (progress * samples::GROWTH_PX).min(8.0) as f32,
                hold: strokes.hold,
                capacity: (strokes.budget_px / samples::SPACING_PX) as u32,
                // A picture that stands for itself is always the same.
                seed: if takes_over { frame } else { 0 },
                rests: u32::from(rests),
                camera_blocks: (camera_m / BLOCK_M).floor().as_ivec3().to_array(),
                camera_rest_m: (camera_m - (camera_m / BLOCK_M).floor() * BLOCK_M).as_vec3().to_array(),
                ..CarryUniform::default()
            },
        );
        self.stroke.set_texture(gpu, strokes.texture.as_ref());
        if !is_update {
            self.lists.fit(gpu, strokes, view.part.size_px, haze_m);
            return false;
        }
        self.lists.begin(gpu, strokes, view.part.size_px, haze_m);
        self.chain.set_rules(gpu, ChainRules::new(strokes.join_px, strokes.join_deg.to_radians()));
        self.points.reserve(gpu, MOST_PIECES);
        true
    }

    /// Finds the edges of a batch of patches.
    pub fn find(&mut self, gpu: &Gpu, recorder: &mut Recorder<'_>, inputs: &contour_edges::Inputs<'_>) {
        self.contour_edges.run(gpu, recorder, inputs, &self.lists, &self.scan);
    }

    /// Makes what finds edges on meshes, or drops it.
    pub fn set_meshes(&mut self, gpu: &Gpu, has_meshes: bool) {
        if has_meshes != self.mesh_edges.is_some() {
            self.mesh_edges = has_meshes.then(|| mesh_edges::MeshEdgesPass::new(gpu));
        }
    }

    /// Finds the edges of the meshes.
    pub fn find_on_meshes(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        view: wgpu::BindingResource<'_>,
        meshes: &MeshVerticesPass,
    ) {
        if let Some(pass) = &mut self.mesh_edges {
            pass.run(gpu, recorder, view, meshes, &self.lists, &self.scan);
        }
    }

    /// Draws the reference image, makes the list of visible pieces, chains them, lets them take over from the frame
    /// before, and draws the strokes.
    pub fn update(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        view: wgpu::BindingResource<'_>,
        depth: &Target,
        drawn: &StrokeTargets,
    ) {
        self.id_image.run(gpu, recorder, view.clone(), depth, &drawn.id_image, &self.lists);
        self.extract.run(gpu, recorder, view.clone(), &drawn.id_image.ids, &self.lists, &self.scan);
        self.chain.run(gpu, recorder, self.lists.pieces.buffer(), self.lists.counts.buffer());
        let (lists, chain, points, samples) = (&self.lists, &self.chain, &self.points, &self.samples);
        points.run(gpu, recorder, lists, chain, &self.scan);
        samples.run(gpu, recorder, view.clone(), lists, chain, points, &self.scan, &drawn.ink.ids);
        self.carry.take_over(gpu, recorder, view.clone(), lists, chain, points, samples);
        self.stroke.run(gpu, recorder, view.clone(), lists, samples, &drawn.ink, Which::Fresh);
        if self.plan.takes_over {
            self.carry.keep(gpu, recorder, view.clone(), samples, &self.scan, &drawn.ink.ids, depth);
            self.stroke.run(gpu, recorder, view, lists, samples, &drawn.ink, Which::Fading);
        }
    }

    /// Moves the strokes of the frame before with the world, and draws them.
    pub fn advance(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        view: wgpu::BindingResource<'_>,
        drawn: &StrokeTargets,
    ) {
        self.carry.advance(gpu, recorder, view.clone(), &self.samples);
        self.stroke.run(gpu, recorder, view, &self.lists, &self.samples, &drawn.ink, Which::Fresh);
    }
}

/// The pictures of strokes.
pub struct StrokeTargets {
    /// Edges, by number.
    pub id_image: id_image::IdTargets,
    /// What is drawn.
    pub ink: stroke::InkTargets,
}
