//! Which strokes lie where, from what the stroke passes left on the GPU.

use glam::Vec2;

use super::StrokePictures;
use crate::frame::Frame;
use crate::gpu::readback::{self, read_buffer};
use crate::gpu::{Gpu, GpuError};
use crate::lines::strokes::points::Point;
use crate::lines::strokes::{Chain, StrokeCounts, StrokePasses, UNITS_PER_PX};
use crate::style::{self, Style};

/// A strip reaches this far from its line at most: pixels farther off are not its own.
const WIDEST_PX: f32 = 8.0;

/// The polylines that strokes are drawn along.
struct Polylines {
    chains: Vec<Chain>,
    points: Vec<Point>,
    /// Arc length at each point since the first point of all, in 1/16 px.
    along_units: Vec<u32>,
}

impl Polylines {
    fn read(gpu: &Gpu, passes: &StrokePasses) -> Result<Self, GpuError> {
        let counts: Vec<StrokeCounts> = read_buffer(gpu, passes.lists().counts.buffer(), 1)?;
        let counts = counts.first().copied().unwrap_or_default();
        Ok(Self {
            chains: read_buffer(gpu, passes.chains().chains(), counts.chains as usize)?,
            points: read_buffer(gpu, passes.points().list().buffer(), counts.points as usize)?,
            along_units: read_buffer(gpu, passes.points().along().buffer(), counts.points as usize)?,
        })
    }

    /// The first and the last point of a chain: one of n pieces has n + 1 points.
    fn ends(&self, number: usize) -> [usize; 2] {
        let first = self.chains[number].first as usize + number;
        [first, first + self.chains[number].count as usize]
    }

    fn along_px(&self, first: usize, point: usize) -> f32 {
        self.along_units[point].wrapping_sub(self.along_units[first]) as f32 / UNITS_PER_PX
    }

    /// The chains that are long enough to be drawn.
    fn drawn(&self, strokes: &style::Strokes) -> impl Iterator<Item = usize> {
        (0..self.chains.len()).filter(|number| {
            let [first, last] = self.ends(*number);
            last < self.points.len() && self.along_px(first, last) >= strokes.shortest_px
        })
    }
}

/// How many strokes the last frame drew; none where the style has none.
///
/// # Errors
/// [`GpuError::Readback`].
pub fn count_strokes(gpu: &Gpu, frame: &Frame, style: &Style) -> Result<Option<u64>, GpuError> {
    let (Some(strokes), Some(passes)) = (&style.strokes, frame.strokes()) else { return Ok(None) };
    Ok(Some(Polylines::read(gpu, passes)?.drawn(strokes).count() as u64))
}

/// Which strokes lie where in the last frame; none where the style has none. A stroke is a chain, whose number is new
/// in every frame, and its parameter the arc length from its beginning.
///
/// # Errors
/// [`GpuError::Readback`].
pub fn read_stroke_pictures(gpu: &Gpu, frame: &Frame, style: &Style) -> Result<Option<StrokePictures>, GpuError> {
    let targets = frame.targets();
    let (Some(strokes), Some(passes), Some(drawn)) = (&style.strokes, frame.strokes(), &targets.strokes) else {
        return Ok(None);
    };
    let size_px = targets.size_px();
    let id: Vec<u32> = readback::read_as(gpu, &drawn.ink.ids, [0, 0], size_px)?;
    let lines = Polylines::read(gpu, passes)?;
    let mut along_px = vec![f32::NAN; id.len()];
    let mut nearest_px = vec![f32::INFINITY; id.len()];
    let [width, height] = size_px.map(|side| side as usize);
    let span = |a: f32, b: f32, side: usize| {
        // Casts from floats saturate: what lies outside has no pixels.
        (a.min(b) - WIDEST_PX).max(0.0) as usize..((a.max(b) + WIDEST_PX).max(0.0) as usize).min(side)
    };
    for number in lines.drawn(strokes) {
        let [first, last] = lines.ends(number);
        for point in first..last {
            let (a, b) = (Vec2::from(lines.points[point].px), Vec2::from(lines.points[point + 1].px));
            let (way, begin_px) = (b - a, lines.along_px(first, point));
            let length_px = lines.along_px(first, point + 1) - begin_px;
            for y in span(a.y, b.y, height) {
                for pixel in span(a.x, b.x, width).map(|x| y * width + x).filter(|at| id[*at] == number as u32 + 1) {
                    let from_a = Vec2::new((pixel % width) as f32 + 0.5, y as f32 + 0.5) - a;
                    let part = (from_a.dot(way) / way.length_squared().max(1e-12)).clamp(0.0, 1.0);
                    let off_px = from_a.distance(way * part);
                    if off_px < nearest_px[pixel] {
                        nearest_px[pixel] = off_px;
                        along_px[pixel] = begin_px + part * length_px;
                    }
                }
            }
        }
    }
    Ok(Some(StrokePictures { id, along_px, identities_last: false }))
}
