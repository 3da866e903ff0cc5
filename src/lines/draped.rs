//! Draws points, lines and areas of features on the land. See `shaders/lines/draped/`.
//!
//! Why: `docs/decisions/features.md`.

use glam::{DVec2, DVec3};

use crate::draped::{BLOCK_POINTS, ResidentFill, ResidentLayer};
use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::pipelines::{Draw, greatest};
use crate::gpu::recorder::{Attachments, Clears, Drawing, Recorder};
use crate::gpu::target::{Group, Target, TargetKind};
use crate::gpu::wgsl::lines::draped::fill::{FINEST, FillRules};
use crate::gpu::wgsl::lines::draped::pieces::{DrapedBlock, SEGMENT_BITS};
use crate::gpu::wgsl::shared::draped::DrapedRules;
use crate::style::Features;

/// 16 bits because it is blended, which not every GPU supports for 32-bit floats.
const INK_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R16Float;

/// Amount of ink: 0 none, 1 full.
pub(crate) const FEATURE_INK: TargetKind =
    TargetKind::attachment("feature ink", INK_FORMAT, Group::Ink.shows("Ink of points, lines and areas of files"));

const STRIPS: Draw =
    Draw { colors: [greatest(INK_FORMAT), None, None, None, None], ..Draw::triangles("lines/draped/draw") };
/// Draws one triangle over the whole picture.
const FILL: Draw =
    Draw { colors: [greatest(INK_FORMAT), None, None, None, None], ..Draw::triangles("lines/draped/fill") };
/// Least distance of the lines that hatch areas, in pixels.
const LEAST_HATCH_PX: f32 = 3.0;
const CUT: &str = "lines/draped/pieces";

/// Blocks of lines in view.
const BLOCKS: BufferKind = BufferKind::storage("draped blocks");
/// The segments of blocks, each with its block.
const SEGMENTS: BufferKind = BufferKind::storage("draped segments");
/// Pieces of lines on the picture.
const PIECES: BufferKind = BufferKind::storage("draped pieces");
/// Arguments of the draw.
const DRAWN: BufferKind = BufferKind::indirect("draped draw");
// A thread knows a segment by the number of its block and, in these bits, that of the segment in it.
const _: () = assert!(BLOCK_POINTS == 1 << SEGMENT_BITS);
/// Threads of a workgroup of the pass.
const GROUP_THREADS: u32 = 64;
/// Bytes of a piece.
const PIECE_BYTES: u64 = 32;
/// Number of pieces for which there is room: for each block, and the limits for all of them. The upper one is 2.6
/// million pixels of lines, 32 MB.
const PIECES_OF_BLOCK: u32 = 1 << 12;
const LEAST_PIECES: u32 = 1 << 16;
const MOST_PIECES: u32 = 1 << 20;

/// Inputs and output of the passes.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// The terrain with its heights.
    pub terrain: &'a [Named],
    pub style: &'a Features,
    /// `None` if nothing is in view.
    pub layer: Option<ResidentLayer<'a>>,
    /// The rig's origin in the world.
    pub origin_m: DVec3,
    pub distance: &'a Target,
    pub normal: &'a Target,
    /// [`FEATURE_INK`].
    pub ink: &'a Target,
}

/// Draws the features on a cleared target: areas, and lines and points on them.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let mut on = Attachments { colors: &[inputs.ink], depth: None, clears: Clears::All };
    let fill = inputs.layer.as_ref().and_then(|layer| layer.fill.as_ref());
    if fill.is_some() || recorder.prewarms() {
        let drawing = filling(recorder, inputs, fill);
        recorder.render(FILL.name, &[&drawing], on, |pass| {
            drawing.set(pass);
            pass.draw(0..3, 0..1);
        });
        on.clears = Clears::Nothing;
    }
    let has_blocks = inputs.layer.as_ref().is_some_and(|layer| !layer.blocks.is_empty());
    if has_blocks || recorder.prewarms() {
        let (drawing, arguments) = cut(recorder, inputs);
        recorder.render(STRIPS.name, &[&drawing], on, |pass| {
            drawing.set(pass);
            pass.draw_indirect(&arguments.raw, 0);
        });
    } else if fill.is_none() {
        recorder.render(STRIPS.name, &[], on, |_| {});
    }
}

/// Returns the drawing that fills areas; without areas only for its pipeline.
fn filling(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>, fill: Option<&ResidentFill<'_>>) -> Drawing {
    let style = inputs.style;
    let origin_m = inputs.origin_m.truncate();
    // Lines that are closer would not have their ink.
    let hatch_px = if style.hatch_px > 0.0 { style.hatch_px.max(LEAST_HATCH_PX) } else { 0.0 };
    let mut rules = FillRules { fill: style.fill, hatch_px, ..FillRules::default() };
    if let Some(fill) = fill {
        let position = fill.position(origin_m);
        let (unit_m, root_bits) = fill.unit();
        rules.origin = position.units.to_array();
        rules.rest_m = position.rest_m.as_vec2().to_array();
        rules.unit_m = unit_m as f32;
        rules.root_bits = root_bits;
    }
    // Azimuths are clockwise from north.
    let (east, north) = f64::from(style.hatch_deg).to_radians().sin_cos();
    let across = DVec2::new(north, -east);
    rules.across = across.as_vec2().to_array();
    if hatch_px > 0.0 {
        let lines = origin_m.dot(across) / (f64::from(hatch_px) * f64::from(FINEST).exp2());
        // The shader counts modulo 2^32.
        rules.line = lines.floor() as i64 as u32;
        rules.line_rest = (lines - lines.floor()) as f32;
    }
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("rules", recorder.uniform("fill rules", &rules)),
        ("distance_m", inputs.distance.into()),
        ("normal", inputs.normal.into()),
    ];
    if let Some(fill) = fill {
        resources.extend(fill.resources());
    }
    resources.extend_from_slice(inputs.terrain);
    recorder.drawing(&FILL, &resources)
}

/// Cuts lines into pieces, and returns the drawing of these with its arguments.
fn cut(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) -> (Drawing, Buffer) {
    let blocks = blocks(inputs);
    let count = blocks.len() as u32;
    let capacity = count.saturating_mul(PIECES_OF_BLOCK).clamp(LEAST_PIECES, MOST_PIECES);
    let style = inputs.style;
    let segments = segments(&blocks);
    let rules = DrapedRules {
        capacity,
        line_px: style.line_px,
        point_px: style.point_px,
        dash_px: style.dash_px,
        gap_px: style.gap_px,
        segments: segments.len() as u32,
        pad_b: 0.0,
        pad_c: 0.0,
    };
    let rules = recorder.uniform("draped rules", &rules);
    let pieces =
        recorder.buffer(&PIECES, u64::from(capacity) * PIECE_BYTES).slice(0, u64::from(capacity) * PIECE_BYTES);
    let drawn = recorder.buffer(&DRAWN, 16);
    recorder.reset(&drawn, &[6_u32, 0, 0, 0]);
    let groups = (segments.len() as u32).div_ceil(GROUP_THREADS);
    let segments = recorder.upload(&SEGMENTS, &segments);
    let blocks = recorder.upload(&BLOCKS, &blocks);
    let points = inputs.layer.as_ref().and_then(|layer| layer.points).map_or_else(|| blocks.clone(), Buffer::clone);
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("rules", rules.clone()),
        ("blocks", blocks.binding()),
        ("points", points.binding()),
        ("pieces", pieces.binding()),
        ("drawn", drawn.binding()),
        ("segments", segments.binding()),
    ];
    resources.extend_from_slice(inputs.terrain);
    recorder.groups(CUT, [groups, 1], &resources);
    let resources = [
        ("view", inputs.view.clone()),
        ("rules", rules),
        ("pieces", pieces.binding()),
        ("distance_m", inputs.distance.into()),
        ("normal", inputs.normal.into()),
    ];
    (recorder.drawing(&STRIPS, &resources), drawn)
}

/// Returns all segments of blocks, as the threads of the pass read them; at least one.
fn segments(blocks: &[DrapedBlock]) -> Vec<u32> {
    let of_block = |(index, block): (usize, &DrapedBlock)| {
        let first = (index as u32) << SEGMENT_BITS;
        (0..block.count.saturating_sub(1).max(u32::from(index == 0))).map(move |segment| first | segment)
    };
    blocks.iter().enumerate().flat_map(of_block).collect()
}

/// Returns the blocks relative to the rig; one without points if there are none.
fn blocks(inputs: &Inputs<'_>) -> Vec<DrapedBlock> {
    let in_view = inputs.layer.as_ref().map_or(&[][..], |layer| layer.blocks);
    let placed = in_view.iter().map(|block| DrapedBlock {
        origin_m: (block.origin_m - inputs.origin_m.truncate()).as_vec2().to_array(),
        first: block.first,
        count: block.count,
    });
    let placed: Vec<_> = placed.collect();
    if placed.is_empty() { vec![DrapedBlock { origin_m: [0.0; 2], first: 0, count: 0 }] } else { placed }
}
