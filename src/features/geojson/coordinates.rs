//! Reads the coordinates of a geometry before its type is known, because `type` may follow them.

use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};

use super::super::MAX_POSITIONS;
use super::super::model::Position;
use super::super::shapes::{Shapes, too_many_positions};
use super::super::summary::Reason;
use super::object::State;

/// Depth of the deepest lists: 1 is a position, 2 a list of positions, 3 a list of rings, 4 a list of polygons.
const DEEPEST: u8 = 4;

/// Nested lists of positions, without the lists.
#[derive(Debug, Default)]
pub(super) struct Nested {
    positions: Vec<Position>,
    /// The end of each list of positions, among the positions.
    line_ends: Vec<usize>,
    /// The end of each list of such lists, among them.
    area_ends: Vec<usize>,
    /// Depth of the outermost list; `None` without any position.
    depth: Option<u8>,
    /// Number of empty lists among lists of positions.
    empties: u64,
    /// The first mistake.
    wrong: Option<Reason>,
}

impl Nested {
    /// Returns the geometry of a type; `None` for an unknown type.
    pub(super) fn shapes(mut self, kind: &str) -> Option<Shapes> {
        let depth = match kind {
            "Point" => 1,
            "MultiPoint" | "LineString" => 2,
            "MultiLineString" | "Polygon" => 3,
            "MultiPolygon" => 4,
            _ => return None,
        };
        if let Some(reason) = self.wrong {
            return Some(Shapes::faulty(reason));
        }
        match self.depth {
            None => return Some(Shapes::faulty(Reason::Empty)),
            Some(own) if own != depth => {
                return Some(Shapes::faulty(Reason::Damaged("its lists are not nested as its type requires")));
            }
            Some(_) => {}
        }
        let mut shapes = Shapes::default();
        (0..self.empties).for_each(|_| shapes.fault(Reason::Empty));
        match kind {
            "Point" | "MultiPoint" => self.positions.iter().for_each(|point| shapes.point(*point)),
            "LineString" => shapes.line(self.positions),
            "MultiLineString" => self.lines().into_iter().for_each(|line| shapes.line(line)),
            "Polygon" => shapes.area(self.lines()),
            _ => {
                let ends = std::mem::take(&mut self.area_ends);
                let mut rings = self.lines().into_iter();
                let mut begin = 0;
                for end in ends {
                    shapes.area(rings.by_ref().take(end.saturating_sub(begin)));
                    begin = end;
                }
            }
        }
        Some(shapes)
    }

    /// Returns the lists of positions.
    fn lines(&self) -> Vec<Vec<Position>> {
        let mut begin = 0;
        let slice = |&end: &usize| {
            let line = self.positions.get(begin..end).unwrap_or_default().to_vec();
            begin = end;
            line
        };
        self.line_ends.iter().map(slice).collect()
    }

    fn wrong(&mut self, reason: Reason) {
        self.wrong.get_or_insert(reason);
    }

    /// Ends a list whose entries have the depth `inner`.
    fn end(&mut self, inner: u8) {
        match inner {
            1 => self.line_ends.push(self.positions.len()),
            2 => self.area_ends.push(self.line_ends.len()),
            3 => {}
            _ => self.wrong(Reason::Damaged("its lists are nested too deep")),
        }
    }
}

/// Reads the coordinates of a geometry.
pub(super) struct Coordinates<'a, 's, 'e>(pub(super) &'a mut State<'s, 'e>);

impl<'de> DeserializeSeed<'de> for Coordinates<'_, '_, '_> {
    type Value = Nested;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Nested, D::Error> {
        let mut nested = Nested::default();
        let entry = Entry { state: self.0, nested: &mut nested }.deserialize(deserializer)?;
        match entry {
            Read::List(depth) => nested.depth = Some(depth),
            Read::Empty | Read::Other { is_null: true } => {}
            Read::Number(_) | Read::Other { .. } => nested.wrong(Reason::Damaged("its coordinates are not a list")),
        }
        Ok(nested)
    }
}

/// A JSON value among coordinates.
enum Read {
    Number(f64),
    /// A list of this depth.
    List(u8),
    Empty,
    Other {
        is_null: bool,
    },
}

/// Reads a value among coordinates, and adds what it contains.
struct Entry<'a, 's, 'e> {
    state: &'a mut State<'s, 'e>,
    nested: &'a mut Nested,
}

impl<'de> DeserializeSeed<'de> for Entry<'_, '_, '_> {
    type Value = Read;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Read, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Entry<'_, '_, '_> {
    type Value = Read;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("coordinates")
    }

    fn visit_f64<E>(self, number: f64) -> Result<Read, E> {
        Ok(Read::Number(number))
    }

    fn visit_i64<E>(self, number: i64) -> Result<Read, E> {
        Ok(Read::Number(number as f64))
    }

    fn visit_u64<E>(self, number: u64) -> Result<Read, E> {
        Ok(Read::Number(number as f64))
    }

    fn visit_bool<E>(self, _: bool) -> Result<Read, E> {
        Ok(Read::Other { is_null: false })
    }

    fn visit_str<E>(self, _: &str) -> Result<Read, E> {
        Ok(Read::Other { is_null: false })
    }

    fn visit_unit<E>(self) -> Result<Read, E> {
        Ok(Read::Other { is_null: true })
    }

    fn visit_map<M: MapAccess<'de>>(self, members: M) -> Result<Read, M::Error> {
        IgnoredAny.visit_map(members).map(|_| Read::Other { is_null: false })
    }

    fn visit_seq<S: SeqAccess<'de>>(self, mut list: S) -> Result<Read, S::Error> {
        let Self { state, nested } = self;
        let mut position = [f64::NAN; 3];
        let (mut numbers, mut inner, mut has_other, mut empties) = (0, None, false, 0);
        while let Some(entry) = list.next_element_seed(Entry { state: &mut *state, nested: &mut *nested })? {
            match entry {
                // A fourth number has no meaning in the standard; some programs write M.
                Read::Number(number) => {
                    if let Some(slot) = position.get_mut(numbers) {
                        *slot = number;
                    }
                    numbers += 1;
                }
                // A height of null is no height.
                Read::Other { is_null: true } if numbers >= 2 => numbers += 1,
                Read::Other { .. } => {
                    has_other = true;
                    nested.wrong(Reason::NotFinite);
                }
                Read::List(depth) if inner.is_none_or(|inner| inner == depth) => inner = Some(depth),
                Read::List(_) => nested.wrong(Reason::Damaged("its lists are not nested evenly")),
                // Without its first ring a polygon would have a hole as its outline.
                Read::Empty if inner.is_none() => nested.wrong(Reason::Empty),
                Read::Empty => empties += 1,
            }
        }
        match inner {
            Some(1) if empties > 0 => nested.wrong(Reason::NotFinite),
            _ => nested.empties += empties,
        }
        match (inner, numbers) {
            (Some(_), 1..) => nested.wrong(Reason::Damaged("a list contains both numbers and lists")),
            (Some(inner), 0) => nested.end(inner),
            (None, 0) => return Ok(if has_other { Read::List(1) } else { Read::Empty }),
            (None, 1) => nested.wrong(Reason::NotFinite),
            (None, _) if nested.positions.len() >= MAX_POSITIONS => return Err(state.fail(too_many_positions())),
            (None, _) => nested.positions.push(position),
        }
        Ok(Read::List(inner.map_or(1, |inner| inner.saturating_add(1).min(DEEPEST + 1))))
    }
}
