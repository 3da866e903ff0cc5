//! Contour lines as paths that are measured by arc length.

use glam::DVec2;

/// Points farther from the origin are treated as invalid.
const MAX_PX: f64 = 1e9;

/// All contour lines, without invalid and repeated points. A closed line ends with its first point.
#[derive(Default)]
pub(super) struct Paths {
    points: Vec<DVec2>,
    /// For each point, the arc length from the beginning of its line.
    along_px: Vec<f64>,
    /// For each line, the index of its first point; then the number of all points.
    begins: Vec<usize>,
    is_closed: Vec<bool>,
}

/// A contour line of [`Paths`].
#[derive(Clone, Copy)]
pub(super) struct Path<'a> {
    pub points: &'a [DVec2],
    /// For each point, the arc length from the beginning.
    pub along_px: &'a [f64],
    pub is_closed: bool,
}

impl Paths {
    pub(super) fn new<'a>(lines: impl Iterator<Item = (&'a [DVec2], bool)>) -> Self {
        let mut paths = Self { begins: vec![0], ..Self::default() };
        for (points, is_closed) in lines {
            paths.push(points, is_closed);
        }
        paths
    }

    fn push(&mut self, points: &[DVec2], is_closed: bool) {
        let first = self.points.len();
        let mut along_px = 0.0;
        let mut add = |points: &mut Vec<DVec2>, point: DVec2| {
            let step_px = points.get(first..).and_then(<[DVec2]>::last).map(|last| last.distance(point));
            if step_px.is_none_or(|step_px| step_px > 0.0) {
                along_px += step_px.unwrap_or(0.0);
                points.push(point);
                self.along_px.push(along_px);
            }
        };
        for point in points.iter().filter(|point| point.abs().max_element() < MAX_PX) {
            add(&mut self.points, *point);
        }
        let count = self.points.len() - first;
        let is_repeated = count > 1 && self.points[first] == self.points[first + count - 1];
        // A line of two points encloses nothing.
        let is_closed = is_closed && count - usize::from(is_repeated) > 2;
        if is_closed {
            let begin = self.points[first];
            add(&mut self.points, begin);
        }
        self.begins.push(self.points.len());
        self.is_closed.push(is_closed);
    }

    pub(super) fn len(&self) -> usize {
        self.is_closed.len()
    }

    pub(super) fn path(&self, line: usize) -> Path<'_> {
        let range = self.begins[line]..self.begins[line + 1];
        Path { points: &self.points[range.clone()], along_px: &self.along_px[range], is_closed: self.is_closed[line] }
    }

    /// Returns the segments of all lines, as the index of the first point and the line.
    pub(super) fn segments(&self) -> impl Iterator<Item = (usize, usize)> {
        let of = |line: usize| (self.begins[line]..self.begins[line + 1].max(1) - 1).map(move |point| (point, line));
        (0..self.len()).flat_map(of)
    }

    /// Returns the ends of the segment that begins at a point.
    pub(super) fn segment(&self, point: usize) -> [DVec2; 2] {
        [self.points[point], self.points[point + 1]]
    }

    /// Returns the arc length of a point from the beginning of its line.
    pub(super) fn along_px(&self, point: usize) -> f64 {
        self.along_px[point]
    }
}

impl Path<'_> {
    pub(super) fn length_px(&self) -> f64 {
        self.along_px.last().copied().unwrap_or(0.0)
    }

    /// Returns the arc length within the line: wrapped on a closed line, otherwise limited to its ends.
    fn within(&self, along_px: f64) -> f64 {
        let length_px = self.length_px();
        let along_px = if self.is_closed { along_px.rem_euclid(length_px) } else { along_px };
        along_px.clamp(0.0, length_px)
    }

    /// Returns the distance along the line from an arc length to the nearest point of a part of the line.
    pub(super) fn between_px(&self, from_px: f64, to_px: f64, along_px: f64) -> f64 {
        let away = |along_px: f64| (from_px - along_px).max(along_px - to_px).max(0.0);
        let length_px = self.length_px();
        if !self.is_closed {
            return away(along_px);
        }
        let along_px = along_px.rem_euclid(length_px);
        away(along_px).min(away(along_px - length_px)).min(away(along_px + length_px))
    }

    /// Returns the segment at an arc length within the line.
    fn segment_at(&self, along_px: f64) -> usize {
        let after = self.along_px.partition_point(|own| *own <= along_px);
        after.clamp(1, self.points.len().max(2) - 1) - 1
    }

    fn on(&self, segment: usize, along_px: f64) -> DVec2 {
        let Some(next) = self.points.get(segment + 1) else { return self.points[segment] };
        let [from_px, to_px] = [self.along_px[segment], self.along_px[segment + 1]];
        self.points[segment].lerp(*next, ((along_px - from_px) / (to_px - from_px)).clamp(0.0, 1.0))
    }

    /// Returns the point at an arc length. The line must have a point.
    pub(super) fn at(&self, along_px: f64) -> DVec2 {
        let along_px = self.within(along_px);
        self.on(self.segment_at(along_px), along_px)
    }

    /// Appends `count` points at equal steps of arc length. The line must have a point.
    pub(super) fn sample(&self, from_px: f64, step_px: f64, count: usize, samples: &mut Vec<DVec2>) {
        let mut segment = self.segment_at(self.within(from_px));
        let mut before_px = f64::NEG_INFINITY;
        for i in 0..count {
            let along_px = self.within(from_px + i as f64 * step_px);
            if along_px < before_px {
                segment = 0;
            }
            before_px = along_px;
            while segment + 2 < self.points.len() && self.along_px[segment + 1] < along_px {
                segment += 1;
            }
            samples.push(self.on(segment, along_px));
        }
    }
}
