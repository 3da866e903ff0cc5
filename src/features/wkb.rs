//! Parses geometries in Well-Known Binary: ISO SQL/MM, the extended form of PostGIS, and the blobs of GeoPackage.

use super::MAX_POSITIONS;
use super::model::Position;
use super::shapes::Shapes;
use super::summary::Reason;

/// Deepest nesting of collections.
const DEEPEST: usize = 8;
const SHORT: Reason = Reason::Damaged("its data end too early");

/// Flags of the extended form.
const HAS_Z: u32 = 1 << 31;
const HAS_M: u32 = 1 << 30;
const HAS_SRID: u32 = 1 << 29;

/// Parses a blob of a GeoPackage: a header (OGC 12-128r18, 2.1.3), then Well-Known Binary.
pub(super) fn parse_geopackage(blob: &[u8]) -> Result<Shapes, Reason> {
    let Some(([b'G', b'P', _, flags, ..], rest)) = blob.split_at_checked(8) else {
        return Err(Reason::Damaged("it does not begin with GP"));
    };
    if flags & 0x20 != 0 {
        return Err(Reason::Damaged("its encoding is an extension of GeoPackage"));
    }
    if flags & 0x10 != 0 {
        return Err(Reason::Empty);
    }
    let envelope_bytes = match (flags >> 1) & 7 {
        0 => 0,
        1 => 32,
        2 | 3 => 48,
        4 => 64,
        _ => return Err(Reason::Damaged("its envelope is of an unknown kind")),
    };
    parse(rest.get(envelope_bytes..).ok_or(SHORT)?)
}

/// Parses Well-Known Binary.
pub(super) fn parse(bytes: &[u8]) -> Result<Shapes, Reason> {
    let mut shapes = Shapes::default();
    let mut cursor = Cursor { rest: bytes, positions: 0, is_little: true };
    cursor.geometry(&mut shapes, None, 0)?;
    Ok(shapes)
}

struct Cursor<'a> {
    rest: &'a [u8],
    positions: usize,
    is_little: bool,
}

/// The type of a geometry.
#[derive(Clone, Copy)]
struct Kind {
    code: u32,
    has_z: bool,
    has_m: bool,
}

impl Kind {
    fn position_bytes(self) -> usize {
        8 * (2 + usize::from(self.has_z) + usize::from(self.has_m))
    }
}

impl Cursor<'_> {
    fn bytes<const N: usize>(&mut self) -> Result<[u8; N], Reason> {
        let (bytes, rest) = self.rest.split_first_chunk::<N>().ok_or(SHORT)?;
        self.rest = rest;
        Ok(*bytes)
    }

    fn u32(&mut self) -> Result<u32, Reason> {
        let bytes = self.bytes()?;
        Ok(if self.is_little { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) })
    }

    fn f64(&mut self) -> Result<f64, Reason> {
        let bytes = self.bytes()?;
        Ok(if self.is_little { f64::from_le_bytes(bytes) } else { f64::from_be_bytes(bytes) })
    }

    /// Returns a count of entries that take at least `entry_bytes` each.
    fn count(&mut self, entry_bytes: usize) -> Result<usize, Reason> {
        let count = self.u32()? as usize;
        if count > self.rest.len() / entry_bytes { Err(SHORT) } else { Ok(count) }
    }

    fn kind(&mut self) -> Result<Kind, Reason> {
        self.is_little = match self.bytes()? {
            [0] => false,
            [1] => true,
            _ => return Err(Reason::Damaged("its byte order is unknown")),
        };
        let code = self.u32()?;
        if code & HAS_SRID != 0 {
            self.u32()?;
        }
        let plain = code & !(HAS_Z | HAS_M | HAS_SRID);
        let (dimensions, plain_code) = (plain / 1000, plain % 1000);
        if dimensions > 3 {
            return Err(Reason::UnknownType);
        }
        Ok(Kind {
            code: plain_code,
            has_z: code & HAS_Z != 0 || dimensions == 1 || dimensions == 3,
            has_m: code & HAS_M != 0 || dimensions >= 2,
        })
    }

    /// Parses a geometry. `only` is the code that an entry of a collection of one type must have.
    fn geometry(&mut self, shapes: &mut Shapes, only: Option<u32>, depth: usize) -> Result<(), Reason> {
        if depth > DEEPEST {
            return Err(Reason::Damaged("its collections are nested too deep"));
        }
        let kind = self.kind()?;
        if only.is_some_and(|only| only != kind.code) {
            return Err(Reason::Damaged("a part has another type than the whole"));
        }
        match kind.code {
            1 => {
                let [x, y, z] = self.position(kind)?;
                // An empty point has the coordinates NaN.
                if x.is_nan() && y.is_nan() {
                    shapes.fault(Reason::Empty);
                } else {
                    shapes.point([x, y, z]);
                }
            }
            2 => shapes.line(self.positions(kind)?),
            3 | 17 => {
                let rings = self.count(4)?;
                let rings: Result<Vec<_>, _> = (0..rings).map(|_| self.positions(kind)).collect();
                shapes.area(rings?);
            }
            4 => self.parts(shapes, Some(1), depth)?,
            5 => self.parts(shapes, Some(2), depth)?,
            6 | 15 => self.parts(shapes, Some(3), depth)?,
            16 => self.parts(shapes, Some(17), depth)?,
            // The parts of a MultiCurve and a MultiSurface may be straight.
            7 | 11 | 12 => self.parts(shapes, None, depth)?,
            8 => return Err(Reason::Curve("CircularString")),
            9 => return Err(Reason::Curve("CompoundCurve")),
            10 => return Err(Reason::Curve("CurvePolygon")),
            _ => return Err(Reason::UnknownType),
        }
        Ok(())
    }

    fn parts(&mut self, shapes: &mut Shapes, only: Option<u32>, depth: usize) -> Result<(), Reason> {
        let count = self.count(5)?;
        if count == 0 {
            shapes.fault(Reason::Empty);
        }
        for _ in 0..count {
            self.geometry(shapes, only, depth + 1)?;
        }
        Ok(())
    }

    fn positions(&mut self, kind: Kind) -> Result<Vec<Position>, Reason> {
        let count = self.count(kind.position_bytes())?;
        self.positions = self.positions.saturating_add(count);
        if self.positions > MAX_POSITIONS {
            return Err(Reason::Damaged("it has too many points"));
        }
        (0..count).map(|_| self.position(kind)).collect()
    }

    fn position(&mut self, kind: Kind) -> Result<Position, Reason> {
        let (x, y) = (self.f64()?, self.f64()?);
        let z = if kind.has_z { self.f64()? } else { f64::NAN };
        if kind.has_m {
            self.f64()?;
        }
        Ok([x, y, z])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(code: u32, numbers: &[f64], count: u32, is_little: bool) -> Vec<u8> {
        let mut bytes = vec![u8::from(is_little)];
        let word = |word: u32| if is_little { word.to_le_bytes() } else { word.to_be_bytes() };
        bytes.extend(word(code));
        bytes.extend(word(count));
        bytes.extend(numbers.iter().flat_map(|it| if is_little { it.to_le_bytes() } else { it.to_be_bytes() }));
        bytes
    }

    #[test]
    fn both_byte_orders_and_all_dimensions() {
        let flat = [0.0, 1.0, 2.0, 3.0];
        let deep = [0.0, 1.0, 9.0, 2.0, 3.0, 8.0];
        for is_little in [false, true] {
            let found = parse(&line(2, &flat, 2, is_little)).unwrap();
            assert!(found.lines[0][1][..2] == [2.0, 3.0] && found.lines[0][1][2].is_nan());
            for code in [1002, 2 | HAS_Z] {
                assert_eq!(parse(&line(code, &deep, 2, is_little)).unwrap().lines[0][1], [2.0, 3.0, 8.0]);
            }
            for code in [2002, 2 | HAS_M] {
                assert!(parse(&line(code, &deep, 2, is_little)).unwrap().lines[0][1][2].is_nan());
            }
        }
    }

    #[test]
    fn hostile_data_have_reasons() {
        assert_eq!(parse(&line(2, &[0.0; 4], u32::MAX, true)).unwrap_err(), SHORT);
        assert_eq!(parse(&line(8, &[0.0; 4], 2, true)).unwrap_err(), Reason::Curve("CircularString"));
        assert_eq!(parse(&line(99, &[0.0; 4], 2, true)).unwrap_err(), Reason::UnknownType);
        let deep: Vec<u8> = std::iter::repeat_n(line(7, &[], 1, true), 1000).flatten().collect();
        assert_eq!(parse(&deep).unwrap_err(), Reason::Damaged("its collections are nested too deep"));
        let infinite = parse(&line(2, &[0.0, f64::INFINITY, 1.0, 1.0], 2, true)).unwrap();
        assert_eq!(infinite.faults, [(Reason::NotFinite, 1)]);
        assert_eq!(parse_geopackage(b"GP\0\x10\0\0\0\0").unwrap_err(), Reason::Empty);
        assert_eq!(parse_geopackage(b"GP\0\x02\0\0\0\0").unwrap_err(), SHORT);
    }
}
