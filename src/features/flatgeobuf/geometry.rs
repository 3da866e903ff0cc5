//! Reads geometries of FlatGeobuf.

use super::super::MAX_POSITIONS;
use super::super::flat_tables::{List, Table};
use super::super::model::Position;
use super::super::shapes::Shapes;
use super::super::summary::Reason;

/// Deepest nesting of collections.
const DEEPEST: usize = 8;

/// Numbers of the fields of a geometry.
const ENDS: usize = 0;
const XY: usize = 1;
const Z: usize = 2;
const TYPE: usize = 6;
const PARTS: usize = 7;

pub(super) const DAMAGED: Reason = Reason::Damaged("its lists do not fit together");

/// Reads a geometry. `declared` is the type in the header, 0 if each geometry has its own; `bytes` is the size of the
/// feature.
pub(super) fn shapes(table: &Table<'_>, declared: u8, bytes: usize) -> Result<Shapes, Reason> {
    let mut shapes = Shapes::default();
    // Every position and every part takes bytes of its own, unless hostile data use the same ones again and again.
    let mut walk = Walk { shapes: &mut shapes, positions: (bytes / 16).min(MAX_POSITIONS), parts: 1 + bytes / 4 };
    let kind = if declared == 0 { table.u8(TYPE).unwrap_or(0) } else { declared };
    walk.geometry(table, kind, 0)?;
    Ok(shapes)
}

struct Walk<'a> {
    shapes: &'a mut Shapes,
    /// Number of positions that may follow.
    positions: usize,
    /// Number of parts that may follow.
    parts: usize,
}

impl Walk<'_> {
    fn geometry(&mut self, table: &Table<'_>, kind: u8, depth: usize) -> Result<(), Reason> {
        if depth > DEEPEST {
            return Err(Reason::Damaged("its collections are nested too deep"));
        }
        self.parts = self.parts.checked_sub(1).ok_or(DAMAGED)?;
        match kind {
            1 | 4 => self.positions(table)?.into_iter().for_each(|point| self.shapes.point(point)),
            2 => {
                let line = self.positions(table)?;
                self.shapes.line(line);
            }
            5 => self.lines(table)?.into_iter().for_each(|line| self.shapes.line(line)),
            3 | 17 => {
                let rings = self.lines(table)?;
                self.shapes.area(rings);
            }
            6 | 15 => self.each_part(table, |walk, part| walk.geometry(part, 3, depth + 1))?,
            16 => self.each_part(table, |walk, part| walk.geometry(part, 17, depth + 1))?,
            7 | 11 | 12 => self.each_part(table, |walk, part| {
                let kind = part.u8(TYPE).unwrap_or(0);
                walk.geometry(part, kind, depth + 1)
            })?,
            8 => return Err(Reason::Curve("CircularString")),
            9 => return Err(Reason::Curve("CompoundCurve")),
            10 => return Err(Reason::Curve("CurvePolygon")),
            _ => return Err(Reason::UnknownType),
        }
        Ok(())
    }

    fn each_part(
        &mut self,
        table: &Table<'_>,
        mut each: impl FnMut(&mut Self, &Table<'_>) -> Result<(), Reason>,
    ) -> Result<(), Reason> {
        if !table.has(PARTS) {
            self.shapes.fault(Reason::Empty);
            return Ok(());
        }
        let parts = table.list(PARTS, 4).ok_or(DAMAGED)?;
        (0..parts.len()).try_for_each(|index| each(self, &parts.table(index).ok_or(DAMAGED)?))
    }

    /// Reads all positions of a geometry without parts.
    fn positions(&mut self, table: &Table<'_>) -> Result<Vec<Position>, Reason> {
        if !table.has(XY) {
            return Ok(Vec::new());
        }
        let xy = table.list(XY, 8).filter(|xy| xy.len().is_multiple_of(2)).ok_or(DAMAGED)?;
        let count = xy.len() / 2;
        self.positions = self.positions.checked_sub(count).ok_or(DAMAGED)?;
        let z = match table.has(Z) {
            true => table.list(Z, 8).filter(|z| z.len() == count || z.len() == 0).ok_or(DAMAGED)?.into(),
            false => None::<List<'_>>,
        };
        let position = |index| {
            let z = z.and_then(|z| z.f64(index)).unwrap_or(f64::NAN);
            Ok([xy.f64(2 * index).ok_or(DAMAGED)?, xy.f64(2 * index + 1).ok_or(DAMAGED)?, z])
        };
        (0..count).map(position).collect()
    }

    /// Reads lines or rings. Without a list of ends there is one.
    fn lines(&mut self, table: &Table<'_>) -> Result<Vec<Vec<Position>>, Reason> {
        let positions = self.positions(table)?;
        if !table.has(ENDS) {
            return Ok(vec![positions]);
        }
        let ends = table.list(ENDS, 4).ok_or(DAMAGED)?;
        if ends.len() == 0 {
            return Ok(vec![positions]);
        }
        self.parts = self.parts.checked_sub(ends.len()).ok_or(DAMAGED)?;
        let mut begin = 0;
        let mut lines = Vec::new();
        for index in 0..ends.len() {
            let end = ends.u32(index).ok_or(DAMAGED)?;
            lines.push(positions.get(begin..end).ok_or(DAMAGED)?.to_vec());
            begin = end;
        }
        if begin == positions.len() { Ok(lines) } else { Err(DAMAGED) }
    }
}
