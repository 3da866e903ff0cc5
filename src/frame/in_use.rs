//! The part of its lists and atlases that a frame used, for the sizes in its trace.
//!
//! Lists are allocated for the most that a frame may put into them, and atlases for all tiles that memory can hold. No
//! frame reads or writes more of a list than it has filled, or other tiles than those that the view needs and, where it
//! computes maps, their neighbours. So a trace gives a list the size that the frame filled, by the list's own counter,
//! and an atlas the layers of those tiles. All else has its whole size. Counters that eyes share are those of the eye
//! that was drawn last.

use super::Renderer;
use crate::gpu::buffer::BufferKind;
use crate::gpu::trace::{ATLASES, PassTrace, Traced};
use crate::gpu::wgsl::shared::rows::MAX_CANDIDATES;
use crate::gpu::{Gpu, GpuError, readback};
use crate::lines::strokes::samples::{MAX_SAMPLES, SampleCounts};
use crate::lines::strokes::{MAX_FRAME_SEGMENTS, StrokeCounts};
use crate::surface::edges::{EDGE_DRAW, MAX_EDGES};
use crate::surface::{lakes, rows};
use crate::world::Surfaces;

/// Beginnings of the names of the passes that compute maps.
const MAP_PASSES: [&str; 2] = ["surface/lakes/", "surface/land/horizons"];
/// The passes that make candidates in the blocks of rows that a frame builds.
const BLOCK_PASSES: [&str; 2] = ["surface/rows/seeds", "surface/rows/trace"];
/// Lists whose capacity grows with that for segments.
const PER_SEGMENT: [&str; 12] = [
    "chain buckets",
    "chain slots",
    "chain choices",
    "chain links",
    "chain ranks",
    "chain heads",
    "places",
    "chains",
    "stroke points",
    "stroke lengths",
    "stroke starts",
    "heritages",
];
/// Lists whose capacity grows with that for samples.
const PER_SAMPLE: [&str; 4] = ["stroke samples", "stroke matches", "gone samples", "kept places"];

/// The number of entries that a frame has filled in its lists.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct InUse {
    /// Number of tiles that the view needs, and of those that only its maps depend on.
    tiles: [u64; 2],
    edges: u64,
    segments: u64,
    /// Number of samples in the longer one of the lists of this frame and the previous frame.
    samples: u64,
    /// Number of proposed marks of rows, and of those that are drawn.
    proposals: u64,
    marks: u64,
    /// The pass of water whose number of workgroups is 0, because a view has either water or none.
    skipped: Option<&'static str>,
    /// Number of candidates for marks in the blocks that the frame built, and in those that it may draw.
    built_candidates: u64,
    seen_candidates: u64,
}

impl InUse {
    /// Returns the number of bytes that a pass of a frame used of a resource.
    fn bytes_of(&self, pass: &str, used: &Traced) -> u64 {
        let part = |filled: u64, room: u64| (used.bytes * filled.min(room)).div_ceil(room.max(1));
        match used.name {
            _ if self.skipped == Some(pass) => 0,
            name if ATLASES.contains(&name) => {
                let layers = used.texture.as_ref().map_or(1, wgpu::Texture::depth_or_array_layers);
                let [needed, around] = self.tiles;
                let tiles = if MAP_PASSES.iter().any(|name| pass.starts_with(name)) { needed + around } else { needed };
                part(tiles, layers.into())
            }
            "edges" => part(self.edges, MAX_EDGES.into()),
            "segments" => used.bytes.min(self.segments * size_of::<crate::lines::strokes::Segment>() as u64),
            name if PER_SEGMENT.contains(&name) => part(self.segments, MAX_FRAME_SEGMENTS.into()),
            name if PER_SAMPLE.contains(&name) => part(self.samples, MAX_SAMPLES.into()),
            "row proposals" => used.bytes.min(self.proposals * rows::proposals::BYTES),
            "row marks" => used.bytes.min(self.marks * rows::marks::BYTES),
            // All pools together, which have one name and size and so count once.
            "row candidates" => {
                let builds = BLOCK_PASSES.contains(&pass);
                let candidates = if builds { self.built_candidates } else { self.seen_candidates };
                candidates * rows::blocks::CANDIDATE_BYTES
            }
            _ => used.bytes,
        }
    }

    /// Sets the sizes in a trace to those that the frame used.
    fn apply(&self, trace: &mut [PassTrace]) {
        for pass in trace {
            for used in pass.reads.iter_mut().chain(&mut pass.writes) {
                used.bytes = self.bytes_of(pass.name, used);
            }
        }
    }
}

impl Renderer {
    /// Sets the sizes in the trace of the last frame, if it was traced, to those that the frame used. Waits for the GPU.
    ///
    /// # Errors
    /// [`GpuError::Readback`] if the device is lost or out of memory.
    pub(super) fn measure_trace(&mut self, gpu: &Gpu, world: &Surfaces) -> Result<(), GpuError> {
        let Some(mut trace) = self.trace.take() else { return Ok(()) };
        let in_use = self.in_use(gpu, world)?;
        in_use.apply(&mut trace);
        self.trace = Some(trace);
        Ok(())
    }

    fn in_use(&self, gpu: &Gpu, world: &Surfaces) -> Result<InUse, GpuError> {
        let word = |kind: &BufferKind, index: usize| -> Result<u64, GpuError> {
            let Some(buffer) = self.buffer(kind) else { return Ok(0) };
            let words: Vec<u32> = readback::read_buffer(gpu, &buffer.raw, index + 1)?;
            Ok(words.get(index).copied().unwrap_or_default().into())
        };
        let mut in_use = InUse { tiles: world.terrain.tiles_in_use(), ..InUse::default() };
        in_use.edges = word(&EDGE_DRAW, 0)? / 2;
        if let Some(counts) = self.buffer(&crate::lines::strokes::COUNTS) {
            let counts: Vec<StrokeCounts> = readback::read_buffer(gpu, &counts.raw, 1)?;
            in_use.segments = counts.first().map_or(0, |counts| counts.segments.into());
        }
        for memory in self.eyes.iter().filter_map(|eye| eye.strokes.as_ref()) {
            for list in memory.both_lists() {
                let counts: Vec<SampleCounts> = readback::read_buffer(gpu, &list.counts.raw, 1)?;
                in_use.samples = in_use.samples.max(counts.first().map_or(0, |counts| counts.samples.into()));
            }
        }
        in_use.proposals = word(&rows::proposals::PROPOSED, 0)?;
        if self.buffer(&lakes::seen::ARGUMENTS).is_some() {
            let is_dry = word(&lakes::seen::ARGUMENTS, 0)? == 0;
            in_use.skipped = Some(if is_dry { "surface/water" } else { "surface/dry" });
        }
        in_use.marks = word(&rows::marks::DRAWN, 1)?;
        for (pool, counts) in self.rows.counts().enumerate() {
            let counts: Vec<u32> = readback::read_buffer(gpu, &counts.raw, rows::blocks::POOL_SLOTS)?;
            let of = |slots: &[[usize; 2]]| {
                let slots = slots.iter().filter(|[of_pool, _]| *of_pool == pool);
                slots
                    .map(|[_, slot]| u64::from(counts.get(*slot).copied().unwrap_or_default().min(MAX_CANDIDATES)))
                    .sum::<u64>()
            };
            in_use.built_candidates += of(self.rows.built());
            in_use.seen_candidates += of(self.rows.seen());
        }
        Ok(in_use)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_counts_as_far_as_it_is_filled() {
        let used = |name, bytes| Traced { name, content: None, texture: None, buffer: None, bytes };
        let in_use = InUse {
            edges: 10,
            segments: 6,
            samples: 1 << 20,
            proposals: 9,
            marks: 4,
            built_candidates: 3,
            seen_candidates: 7,
            ..InUse::default()
        };
        let edges = u64::from(MAX_EDGES) * 32;
        assert_eq!(in_use.bytes_of("pass", &used("edges", edges)), 320);
        assert_eq!(in_use.bytes_of("pass", &used("segments", 1 << 20)), 6 * 32);
        assert_eq!(in_use.bytes_of("pass", &used("chain ranks", 64 * u64::from(MAX_FRAME_SEGMENTS))), 6 * 64);
        let dry = InUse { skipped: Some("surface/water"), ..in_use };
        assert_eq!(["surface/water", "surface/dry"].map(|pass| dry.bytes_of(pass, &used("water", 100))), [0, 100]);
        // A list that was too short is full, and other resources are whole.
        assert_eq!(
            in_use.bytes_of("pass", &used("stroke samples", 64 * u64::from(MAX_SAMPLES))),
            64 * u64::from(MAX_SAMPLES)
        );
        assert_eq!(in_use.bytes_of("pass", &used("vertices", 100)), 100);
        assert_eq!(in_use.bytes_of("pass", &used("row proposals", 1 << 20)), 9 * rows::proposals::BYTES);
        assert_eq!(in_use.bytes_of("pass", &used("row marks", 1 << 20)), 4 * rows::marks::BYTES);
        // A pass that builds blocks uses their candidates, and one that draws uses those in view.
        let candidates = |pass| in_use.bytes_of(pass, &used("row candidates", 1 << 20)) / rows::blocks::CANDIDATE_BYTES;
        assert_eq!(["surface/rows/seeds", "surface/rows/trace", "surface/rows/proposals"].map(candidates), [3, 3, 7]);
    }

    #[test]
    fn all_lists_and_atlases_are_those_of_drawn_frames() {
        // The table of passes has the resources of drawn frames, by name. A list whose name differs would count whole.
        let table = include_str!("../frame_passes.md");
        let cells = table.lines().filter(|line| line.starts_with("| ")).flat_map(|line| line.split('|'));
        let resources: std::collections::BTreeSet<&str> =
            cells.flat_map(|cell| cell.split(',')).filter_map(|word| word.split('`').next()).map(str::trim).collect();
        let others = ["edges", "segments", "row proposals", "row marks", "row candidates"];
        for name in ATLASES.iter().chain(&PER_SEGMENT).chain(&PER_SAMPLE).chain(&others) {
            assert!(resources.contains(name), "no pass reads or writes a resource called {name}");
        }
        // Planted: a list that was renamed.
        assert!(!resources.contains("chain rank"));
    }
}
