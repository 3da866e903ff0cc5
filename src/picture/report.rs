//! Statistics of rendered pictures: counts and times, summed over all parts.

use crate::frame::Renderer;
use crate::gpu::timer::PassTime;
use crate::lines::strokes::LeftOut;
use crate::tiles::terrain::Prepared;

/// Statistics of a rendered picture, over all its parts.
#[derive(Clone, Debug, Default)]
pub struct PictureReport {
    /// GPU time of each pass; `frame` is the sum.
    pub passes: Vec<PassTime>,
    /// Wall-clock time from the start of the first part to the end of the last readback.
    pub wall_ms: f64,
    /// Number of triangles drawn.
    pub triangles: u64,
    /// Number of mesh patches drawn.
    pub patches: u64,
    /// Number of parts rendered.
    pub parts: u64,
    /// Number of tiles read.
    pub tiles_loaded: u64,
    /// Number of tiles replaced by a coarser one for lack of memory.
    pub tiles_missing: u64,
    /// Number of tiles that could not be read.
    pub tiles_failed: u64,
    /// Number of tiles that are still loading.
    pub tiles_pending: u64,
    /// Whether some of the terrain is coarser than the allowed error.
    pub late: bool,
    /// Largest height error that was allowed for the mesh, in pixels.
    pub error_px: f64,
    /// Largest factor by which the surface is coarser than requested, because its tiles did not fit into memory.
    pub memory_factor: f64,
    /// Number of pictures whose allowed error was raised above the requested one, because the patches did not suffice.
    pub over_budget: u64,
    /// Time that the frame thread spent on tiles and patches.
    pub prepare_ms: f64,
    /// Number of pictures.
    pub pictures: u64,
    /// Number of pictures that show only sky or no-data.
    pub empty: u64,
    /// Number of pictures that show a surface, but nearly nothing drawn on it.
    pub pale: u64,
    /// Largest numbers of edges, segments and strokes that a part left out.
    pub(crate) left_out: LeftOut,
    /// Largest number of models that a part left out.
    pub(crate) models_left_out: u32,
    /// Largest size of the render targets on the GPU, in bytes.
    pub target_bytes: u64,
}

impl PictureReport {
    /// Adds the report of another picture: times and counts are summed.
    pub(crate) fn append(&mut self, other: Self) {
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
        self.memory_factor = self.memory_factor.max(other.memory_factor);
        self.over_budget += other.over_budget;
        self.prepare_ms += other.prepare_ms;
        self.pictures += other.pictures;
        self.empty += other.empty;
        self.pale += other.pale;
        self.left_out = self.left_out.most(other.left_out);
        self.models_left_out = self.models_left_out.max(other.models_left_out);
        self.target_bytes = self.target_bytes.max(other.target_bytes);
    }

    /// Counts a picture that shows a surface or not, and on which nearly nothing is drawn or not.
    pub(super) fn count(&mut self, shows_surface: bool, is_pale: bool) {
        self.pictures += 1;
        self.empty += u64::from(!shows_surface);
        self.pale += u64::from(shows_surface && is_pale);
    }

    fn add_time(&mut self, time: PassTime) {
        match self.passes.iter_mut().find(|known| known.name == time.name) {
            Some(known) => known.gpu_ms += time.gpu_ms,
            None => self.passes.push(time),
        }
    }

    /// Adds the statistics of a drawn part.
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
        self.memory_factor = self.memory_factor.max(prepared.detail.memory_factor);
        self.over_budget = self.over_budget.max(u64::from(prepared.detail.is_over_budget));
        self.prepare_ms += prepared.prepare_ms;
        self.target_bytes = self.target_bytes.max(renderer.target_bytes());
    }
}
