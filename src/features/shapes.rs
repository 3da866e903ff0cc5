//! Collects the parts of one geometry while it is read, and checks them.

use super::MAX_POSITIONS;
use super::error::Cause;
use super::model::{Area, Position};
use super::summary::Reason;

/// The valid parts of a geometry, and the reasons why others were left out.
#[derive(Debug, Default)]
pub(super) struct Shapes {
    pub(super) points: Vec<Position>,
    pub(super) lines: Vec<Vec<Position>>,
    pub(super) areas: Vec<Area>,
    /// Reasons, and how many parts were left out for each.
    pub(super) faults: Vec<(Reason, u64)>,
}

impl Shapes {
    /// Creates a geometry of which nothing can be used.
    pub(super) fn faulty(reason: Reason) -> Self {
        let mut shapes = Self::default();
        shapes.fault(reason);
        shapes
    }

    /// Counts a part that is left out.
    pub(super) fn fault(&mut self, reason: Reason) {
        match self.faults.iter_mut().find(|(own, _)| *own == reason) {
            Some((_, count)) => *count += 1,
            None => self.faults.push((reason, 1)),
        }
    }

    /// Returns whether the geometry lacks any valid part.
    pub(super) fn is_empty(&self) -> bool {
        self.points.is_empty() && self.lines.is_empty() && self.areas.is_empty()
    }

    /// Adds a point.
    pub(super) fn point(&mut self, point: Position) {
        match is_finite(&point) {
            true => self.points.push(clean(point)),
            false => self.fault(Reason::NotFinite),
        }
    }

    /// Adds a line.
    pub(super) fn line(&mut self, line: Vec<Position>) {
        match checked(line) {
            Err(reason) => self.fault(reason),
            Ok(line) if line.len() < 2 => self.fault(Reason::ShortLine),
            Ok(line) => self.lines.push(line),
        }
    }

    /// Adds a polygon; the first ring is the outer one. If that is not valid, the whole polygon is left out.
    pub(super) fn area(&mut self, rings: impl IntoIterator<Item = Vec<Position>>) {
        let mut area: Option<Area> = None;
        for ring in rings {
            match (self::ring(ring), &mut area) {
                (Ok(outer), None) => area = Some(Area { outer, holes: Vec::new() }),
                (Ok(hole), Some(area)) => area.holes.push(hole),
                (Err(reason), None) => return self.fault(reason),
                (Err(reason), Some(_)) => self.fault(reason),
            }
        }
        match area {
            Some(area) => self.areas.push(area),
            None => self.fault(Reason::Empty),
        }
    }

    /// Adds the parts of another geometry.
    pub(super) fn append(&mut self, mut other: Self) {
        self.points.append(&mut other.points);
        self.lines.append(&mut other.lines);
        self.areas.append(&mut other.areas);
        for (reason, count) in other.faults {
            match self.faults.iter_mut().find(|(own, _)| *own == reason) {
                Some((_, own)) => *own += count,
                None => self.faults.push((reason, count)),
            }
        }
    }
}

/// Returns the error for a feature with too many positions.
pub(super) fn too_many_positions() -> Cause {
    Cause::content(format!("has a feature of more than {MAX_POSITIONS} points; split or simplify it"))
}

fn is_finite(position: &Position) -> bool {
    let [x, y, _] = position;
    x.is_finite() && y.is_finite()
}

/// Returns a position with NaN for a height that is not finite.
fn clean([x, y, z]: Position) -> Position {
    [x, y, if z.is_finite() { z } else { f64::NAN }]
}

fn checked(mut line: Vec<Position>) -> Result<Vec<Position>, Reason> {
    if line.is_empty() {
        return Err(Reason::Empty);
    }
    if !line.iter().all(is_finite) {
        return Err(Reason::NotFinite);
    }
    line.iter_mut().for_each(|position| *position = clean(*position));
    Ok(line)
}

/// Returns a ring without the last position if that repeats the first.
fn ring(ring: Vec<Position>) -> Result<Vec<Position>, Reason> {
    let mut ring = checked(ring)?;
    if let ([x0, y0, _], Some([x1, y1, _])) = (ring.first().copied().unwrap_or_default(), ring.last().copied())
        && ring.len() > 1
        && x0 == x1
        && y0 == y1
    {
        ring.pop();
    }
    if ring.len() < 3 { Err(Reason::ShortRing) } else { Ok(ring) }
}
