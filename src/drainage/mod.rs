//! How the land drains: the streams and ridge lines that are the skeleton of a map.
//!
//! ```text
//! tiles ─▶ region: heights of what is in view ─▶ flow: where water goes ─▶ trace: smooth lines ─▶ GPU
//! ```
//!
//! A picture for a file waits for the lines. In a window they are computed on a thread of their own, and the lines that
//! were computed last are drawn until then. Lines have the area that drains through them, so that one set of lines serves
//! all scales: `shaders/lines/drainage.wgsl` draws those whose area is large enough on the picture.
//!
//! Why: `docs/decisions/drainage.md`.

pub(crate) mod flow;
mod region;
mod trace;

use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

use glam::{DVec2, DVec3};

use self::flow::{Flow, Grid, Sense};
pub(crate) use self::region::{Land, Region};
use crate::gpu::Gpu;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::wgsl::lines::drainage::{DrainagePoint, LAST_OF_LINE};
use crate::pyramid::{PyramidError, TileStore};
use crate::scene::view::Rig;
use crate::style::DrainageLines;

/// The lines, as `DrainagePoint` of `shaders/lines/drainage.wgsl`.
const POINTS: BufferKind = BufferKind::storage("drainage points");
/// Least number of samples that drain through a line.
const LEAST_SAMPLES: f32 = 40.0;
/// Time after an error until the same lines are computed again.
const RETRY: Duration = Duration::from_secs(10);

/// Streams or ridge lines on the GPU.
#[derive(Clone, Debug)]
pub(crate) struct DrawnLines {
    /// To which positions are relative, in the world's metres.
    pub origin_m: DVec3,
    /// Points, line after line.
    pub points: Buffer,
    /// Number of points.
    pub count: u32,
    /// Distance of the samples of which the lines were made, in metres.
    pub sample_m: f32,
}

/// The streams and ridge lines of what is in view.
#[derive(Default)]
pub(crate) struct Drainage {
    /// The land to which the lines belong.
    store: Option<Arc<dyn TileStore>>,
    streams: Lines,
    ridges: Lines,
    /// How often lines have arrived.
    arrivals: u64,
}

/// The lines of one kind.
#[derive(Default)]
struct Lines {
    /// The lines that were computed last, with their region.
    known: Option<(Region, DrawnLines)>,
    /// The region that is being computed.
    under_way: Option<(Region, Receiver<Computed>)>,
    /// When the known lines were found to be missing because of an error.
    failed: Option<Instant>,
}

/// Lines before they are on the GPU.
struct Computed {
    origin_m: DVec3,
    sample_m: f32,
    points: Result<Vec<DrainagePoint>, PyramidError>,
}

impl Drainage {
    /// Returns the lines of a kind that are to be drawn; `None` before any have been computed.
    pub(crate) fn lines(&self, of: DrainageLines) -> Option<&DrawnLines> {
        let lines = match of {
            DrainageLines::Streams => &self.streams,
            DrainageLines::Ridges => &self.ridges,
        };
        lines.known.as_ref().map(|(_, lines)| lines)
    }

    /// Updates the lines for what a rig sees. With `waits`, the lines of this view are there afterwards; otherwise they
    /// may come later.
    pub(crate) fn follow(&mut self, gpu: &Gpu, land: &Land, rig: &Rig, of: DrainageLines, waits: bool) {
        if !self.store.as_ref().is_some_and(|store| Arc::ptr_eq(store, &land.store)) {
            *self = Self { store: Some(Arc::clone(&land.store)), ..Self::default() };
        }
        let (lines, sense) = match of {
            DrainageLines::Streams => (&mut self.streams, Sense::Down),
            DrainageLines::Ridges => (&mut self.ridges, Sense::Up),
        };
        let Some(region) = Region::seen(land, rig) else { return };
        let is_retried = lines.failed.is_some_and(|failed| failed.elapsed() > RETRY);
        if lines.known.as_ref().is_some_and(|(known, _)| *known == region) && !is_retried {
            return;
        }
        if waits {
            lines.take(gpu, region, compute(land, region, sense));
            self.arrivals += 1;
            return;
        }
        if lines.under_way.is_some() {
            return;
        }
        let (sender, result) = channel();
        let land = land.clone();
        let thread = std::thread::Builder::new().name("drainage".to_owned());
        let spawned = thread.spawn(move || {
            // Nobody waits for it any more if the window has been closed.
            let _ = sender.send(compute(&land, region, sense));
        });
        if spawned.is_ok() {
            lines.under_way = Some((region, result));
        }
    }

    /// Takes lines that have been computed in the meantime, of all kinds: a style may have stopped drawing one.
    pub(crate) fn take_arrived(&mut self, gpu: &Gpu) {
        for lines in [&mut self.streams, &mut self.ridges] {
            let Some((region, result)) = &lines.under_way else { continue };
            let computed = match result.try_recv() {
                Ok(computed) => computed,
                Err(TryRecvError::Empty) => continue,
                // The thread has panicked: there are no lines, and no other attempt.
                Err(TryRecvError::Disconnected) => {
                    Computed { origin_m: DVec3::ZERO, sample_m: 0.0, points: Ok(Vec::new()) }
                }
            };
            let region = *region;
            lines.under_way = None;
            lines.take(gpu, region, computed);
            self.arrivals += 1;
        }
    }

    /// Returns how often lines have arrived.
    pub(crate) fn arrivals(&self) -> u64 {
        self.arrivals
    }

    /// Returns whether lines are being computed.
    pub(crate) fn is_under_way(&self) -> bool {
        self.streams.under_way.is_some() || self.ridges.under_way.is_some()
    }
}

impl Lines {
    /// Puts lines onto the GPU. After an error the land is drawn without them.
    fn take(&mut self, gpu: &Gpu, region: Region, computed: Computed) {
        self.failed = computed.points.is_err().then(Instant::now);
        let points = computed.points.unwrap_or_else(|error| {
            tracing::warn!("streams and ridge lines are missing: {error}");
            Vec::new()
        });
        let count = points.len() as u32;
        // A buffer must not be empty.
        let content = if points.is_empty() { vec![last_point()] } else { points };
        let points = Buffer::with(gpu, &POINTS, &content);
        self.known =
            Some((region, DrawnLines { origin_m: computed.origin_m, points, count, sample_m: computed.sample_m }));
    }
}

fn last_point() -> DrainagePoint {
    DrainagePoint { at_m: [0.0; 3], rank: LAST_OF_LINE, relief: 0.0, pad_a: 0.0, pad_b: 0.0, pad_c: 0.0 }
}

/// Computes the lines of a region.
fn compute(land: &Land, region: Region, sense: Sense) -> Computed {
    let origin_m = region.middle_m(land);
    let mut sample_m = 0.0;
    let points = region.read(land).map(|grid| {
        sample_m = grid.step_m[0].max(grid.step_m[1]) as f32;
        points_of(&grid, sense, |at| region.place_m(land, at), origin_m)
    });
    Computed { origin_m, sample_m, points }
}

/// Returns the points of all lines of a grid, whose columns and rows `place_m` maps to the world.
fn points_of(grid: &Grid, sense: Sense, place_m: impl Fn(DVec2) -> DVec2, origin_m: DVec3) -> Vec<DrainagePoint> {
    let flow = Flow::over(grid, sense);
    let mut points = Vec::new();
    for line in trace::lines(grid, &flow, sense, LEAST_SAMPLES) {
        let first = points.len();
        points.extend(line.iter().map(|point| {
            let at_m = place_m(point.place).extend(f64::from(point.height_m)) - origin_m;
            let rank = point.area_m2.log2();
            DrainagePoint { at_m: at_m.as_vec3().to_array(), rank, relief: point.relief, ..last_point() }
        }));
        if let Some(last) = points[first..].last_mut() {
            last.rank = LAST_OF_LINE;
        }
    }
    points
}
