//! What rendering pictures did: counts and times over all their parts.

use crate::frame::Renderer;
use crate::gpu::timer::PassTime;
use crate::tiles::terrain::Prepared;

/// What rendering a picture did, over all its parts.
#[derive(Clone, Debug, Default)]
pub struct PictureReport {
    /// GPU time by pass; `frame` is the sum.
    pub passes: Vec<PassTime>,
    /// From the start of the first part to the end of the last readback.
    pub wall_ms: f64,
    /// Triangles drawn.
    pub triangles: u64,
    /// Patches drawn.
    pub patches: u64,
    /// Parts rendered.
    pub parts: u64,
    /// Tiles read for it.
    pub tiles_loaded: u64,
    /// Tiles that a coarser one stood in for, since there was no room.
    pub tiles_missing: u64,
    /// Tiles that could not be read.
    pub tiles_failed: u64,
    /// Tiles that are on their way.
    pub tiles_pending: u64,
    /// Whether some of the terrain is coarser than its error allows.
    pub late: bool,
    /// The largest height error that the mesh was allowed, in pixels.
    pub error_px: f64,
    /// Pictures whose mesh was allowed more than was asked for, for want of patches.
    pub over_budget: u64,
    /// What the frame thread spent on tiles and patches.
    pub prepare_ms: f64,
    /// Bytes of targets on the GPU.
    pub target_bytes: u64,
}

impl PictureReport {
    /// Adds another picture's: times and counts are sums.
    pub fn append(&mut self, other: Self) {
        for time in other.passes {
            self.add_time(time);
        }
        self.wall_ms += other.wall_ms;
        self.triangles += other.triangles;
        self.patches += other.patches;
        self.parts += other.parts;
        self.tiles_loaded += other.tiles_loaded;
        self.tiles_missing += other.tiles_missing;
        self.tiles_failed += other.tiles_failed;
        self.tiles_pending += other.tiles_pending;
        self.late |= other.late;
        self.error_px = self.error_px.max(other.error_px);
        self.over_budget += other.over_budget;
        self.prepare_ms += other.prepare_ms;
        self.target_bytes = self.target_bytes.max(other.target_bytes);
    }

    fn add_time(&mut self, time: PassTime) {
        match self.passes.iter_mut().find(|known| known.name == time.name) {
            Some(known) => known.gpu_ms += time.gpu_ms,
            None => self.passes.push(time),
        }
    }

    /// Adds a part that was drawn.
    pub(super) fn add(&mut self, prepared: &Prepared, renderer: &mut Renderer) {
        while let Some(times) = renderer.take_times() {
            times.into_iter().for_each(|time| self.add_time(time));
        }
        self.parts += 1;
        self.triangles += prepared.selection.triangles();
        self.patches += prepared.selection.leaves.len() as u64;
        self.tiles_loaded += prepared.tiles.loaded;
        self.tiles_missing += prepared.tiles.without_room;
        self.tiles_failed += prepared.tiles.failed;
        self.tiles_pending += prepared.tiles.pending;
        self.late |= prepared.tiles.late;
        self.error_px = self.error_px.max(prepared.detail.error_px);
        self.over_budget = self.over_budget.max(u64::from(prepared.detail.is_over_budget));
        self.prepare_ms += prepared.prepare_ms;
        self.target_bytes = self.target_bytes.max(renderer.target_bytes());
    }
}
