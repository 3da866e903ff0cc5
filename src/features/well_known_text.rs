//! Parses geometries in Well-Known Text (OGC 06-103r4 section 7), also with `SRID=n;` before them, as PostGIS writes it.

use super::MAX_POSITIONS;
use super::model::Position;
use super::shapes::Shapes;
use super::summary::Reason;

/// Deepest nesting of collections.
const DEEPEST: usize = 8;

/// Parses a text; returns its geometry and its code of a reference system.
pub(super) fn parse(text: &str) -> Result<(Shapes, Option<u32>), Reason> {
    let mut parser = Parser { rest: text.trim(), positions: 0 };
    let srid = parser.srid()?;
    let mut shapes = Shapes::default();
    parser.geometry(&mut shapes, 0)?;
    if !parser.rest.trim_start().is_empty() {
        return Err(Reason::Damaged("its text does not end where its geometry ends"));
    }
    Ok((shapes, srid))
}

struct Parser<'a> {
    rest: &'a str,
    positions: usize,
}

const BRACKET: Reason = Reason::Damaged("a bracket or comma is missing in its text");

impl<'a> Parser<'a> {
    fn srid(&mut self) -> Result<Option<u32>, Reason> {
        let Some(begin) = self.rest.get(..5).filter(|begin| begin.eq_ignore_ascii_case("SRID=")) else {
            return Ok(None);
        };
        let after = self.rest.strip_prefix(begin).and_then(|rest| rest.split_once(';'));
        let (code, rest) = after.ok_or(Reason::Damaged("its SRID has no end"))?;
        self.rest = rest;
        code.trim().parse().map(Some).map_err(|_| Reason::Damaged("its SRID is not a number"))
    }

    /// Returns the next word in upper case, if there is one.
    fn word(&mut self) -> Option<String> {
        self.rest = self.rest.trim_start();
        let end = self.rest.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at_checked(end)?;
        self.rest = rest;
        (!word.is_empty()).then(|| word.to_ascii_uppercase())
    }

    /// Moves past a character if it is next.
    fn is_next(&mut self, character: char) -> bool {
        self.rest = self.rest.trim_start();
        match self.rest.strip_prefix(character) {
            Some(rest) => {
                self.rest = rest;
                true
            }
            None => false,
        }
    }

    fn expect(&mut self, character: char) -> Result<(), Reason> {
        if self.is_next(character) { Ok(()) } else { Err(BRACKET) }
    }

    /// Parses entries in brackets.
    fn list(&mut self, mut entry: impl FnMut(&mut Self) -> Result<(), Reason>) -> Result<(), Reason> {
        self.expect('(')?;
        loop {
            entry(self)?;
            if !self.is_next(',') {
                return self.expect(')');
            }
        }
    }

    fn geometry(&mut self, shapes: &mut Shapes, depth: usize) -> Result<(), Reason> {
        if depth > DEEPEST {
            return Err(Reason::Damaged("its collections are nested too deep"));
        }
        let word = self.word().ok_or(Reason::UnknownType)?;
        let (kind, mut dimensions) = kind(&word)?;
        let before = self.rest;
        match self.word().as_deref() {
            Some(word @ ("Z" | "M" | "ZM")) => {
                dimensions = Some(word == "M");
                let after = self.rest;
                if self.word().as_deref() == Some("EMPTY") {
                    shapes.fault(Reason::Empty);
                    return Ok(());
                }
                self.rest = after;
            }
            Some("EMPTY") => {
                shapes.fault(Reason::Empty);
                return Ok(());
            }
            _ => self.rest = before,
        }
        self.body(kind, dimensions == Some(true), shapes, depth)
    }

    fn body(&mut self, kind: Kind, third_is_m: bool, shapes: &mut Shapes, depth: usize) -> Result<(), Reason> {
        match kind {
            Kind::Point | Kind::MultiPoint => self.list(|parser| {
                // Both MULTIPOINT (1 2, 3 4) and MULTIPOINT ((1 2), (3 4)) occur.
                let has_brackets = parser.is_next('(');
                if has_brackets || !parser.is_empty_word() {
                    shapes.point(parser.position(third_is_m)?);
                } else {
                    shapes.fault(Reason::Empty);
                }
                if has_brackets { parser.expect(')') } else { Ok(()) }
            }),
            Kind::Line => {
                let line = self.positions(third_is_m)?;
                shapes.line(line);
                Ok(())
            }
            Kind::Area => {
                let rings = self.rings(third_is_m)?;
                shapes.area(rings);
                Ok(())
            }
            Kind::MultiLine => {
                self.rings(third_is_m)?.into_iter().for_each(|line| shapes.line(line));
                Ok(())
            }
            Kind::MultiArea => self.list(|parser| {
                if parser.is_empty_word() {
                    shapes.fault(Reason::Empty);
                    return Ok(());
                }
                let rings = parser.rings(third_is_m)?;
                shapes.area(rings);
                Ok(())
            }),
            Kind::Collection => self.list(|parser| parser.geometry(shapes, depth + 1)),
        }
    }

    /// Moves past the word EMPTY if it is next.
    fn is_empty_word(&mut self) -> bool {
        let before = self.rest;
        let is_empty = self.word().as_deref() == Some("EMPTY");
        if !is_empty {
            self.rest = before;
        }
        is_empty
    }

    fn rings(&mut self, third_is_m: bool) -> Result<Vec<Vec<Position>>, Reason> {
        let mut rings = Vec::new();
        self.list(|parser| {
            rings.push(if parser.is_empty_word() { Vec::new() } else { parser.positions(third_is_m)? });
            Ok(())
        })?;
        Ok(rings)
    }

    fn positions(&mut self, third_is_m: bool) -> Result<Vec<Position>, Reason> {
        let mut positions = Vec::new();
        self.list(|parser| {
            positions.push(parser.position(third_is_m)?);
            Ok(())
        })?;
        Ok(positions)
    }

    fn position(&mut self, third_is_m: bool) -> Result<Position, Reason> {
        self.positions += 1;
        if self.positions > MAX_POSITIONS {
            return Err(Reason::Damaged("it has too many points"));
        }
        let (x, y) = (self.number(), self.number());
        let (Some(x), Some(y)) = (x?, y?) else { return Err(Reason::NotFinite) };
        let third = self.number()?;
        let _fourth = self.number()?;
        Ok([x, y, third.filter(|_| !third_is_m).unwrap_or(f64::NAN)])
    }

    /// Returns the next number; `None` if a comma or bracket is next.
    fn number(&mut self) -> Result<Option<f64>, Reason> {
        self.rest = self.rest.trim_start();
        let end = self.rest.find(|c: char| c.is_whitespace() || "(),".contains(c)).unwrap_or(self.rest.len());
        let Some((word, rest)) = self.rest.split_at_checked(end).filter(|(word, _)| !word.is_empty()) else {
            return Ok(None);
        };
        self.rest = rest;
        word.parse().map(Some).map_err(|_| Reason::Damaged("a coordinate in its text is not a number"))
    }
}

#[derive(Clone, Copy)]
enum Kind {
    Point,
    MultiPoint,
    Line,
    Area,
    MultiLine,
    MultiArea,
    Collection,
}

/// Returns the kind of a keyword, and whether its third coordinate is M if the keyword says what it is.
fn kind(word: &str) -> Result<(Kind, Option<bool>), Reason> {
    let kind = |word: &str| {
        Ok(match word {
            "POINT" => Kind::Point,
            "MULTIPOINT" => Kind::MultiPoint,
            "LINESTRING" | "LINEARRING" => Kind::Line,
            "POLYGON" | "TRIANGLE" => Kind::Area,
            "MULTILINESTRING" => Kind::MultiLine,
            "MULTIPOLYGON" | "POLYHEDRALSURFACE" | "TIN" => Kind::MultiArea,
            "GEOMETRYCOLLECTION" => Kind::Collection,
            "CIRCULARSTRING" => return Err(Reason::Curve("CircularString")),
            "COMPOUNDCURVE" => return Err(Reason::Curve("CompoundCurve")),
            "CURVEPOLYGON" => return Err(Reason::Curve("CurvePolygon")),
            "MULTICURVE" => return Err(Reason::Curve("MultiCurve")),
            "MULTISURFACE" => return Err(Reason::Curve("MultiSurface")),
            _ => return Err(Reason::UnknownType),
        })
    };
    // PostGIS also writes POINTM and, rarely, POINTZ in one word.
    for (ending, third_is_m) in [("ZM", false), ("Z", false), ("M", true)] {
        if let Some(stem) = word.strip_suffix(ending)
            && let Ok(kind) = kind(stem)
        {
            return Ok((kind, Some(third_is_m)));
        }
    }
    Ok((kind(word)?, None))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_as_programs_write_them() {
        let parse_one = |text| parse(text).unwrap().0;
        assert_eq!(parse_one("POINT(1 2)").points.len(), 1);
        assert_eq!(parse_one("point z (1 2 3)").points, [[1.0, 2.0, 3.0]]);
        assert!(parse_one("POINTM(1 2 3)").points[0][2].is_nan());
        assert_eq!(parse_one("POINT ZM (1 2 3 4)").points, [[1.0, 2.0, 3.0]]);
        assert_eq!(parse_one("MULTIPOINT (1 2, 3 4)").points.len(), 2);
        assert_eq!(parse_one("MULTIPOINT ((1 2), (3 4))").points.len(), 2);
        let area = parse_one("MULTIPOLYGON (((0 0, 4 0, 4 4, 0 0), (1 1, 2 1, 2 2, 1 1)))").areas;
        assert_eq!((area[0].outer.len(), area[0].holes.len()), (3, 1));
        let mixed = parse_one("GEOMETRYCOLLECTION (POINT (1 1), LINESTRING (0 0, 1e3 -1.5), POLYGON EMPTY)");
        assert_eq!((mixed.points.len(), mixed.lines.len(), mixed.faults.as_slice()), (1, 1, &[(Reason::Empty, 1)][..]));
        assert_eq!(parse("SRID=25832;POINT(1 2)").unwrap().1, Some(25832));
        assert!(parse_one("POLYGON EMPTY").is_empty() && parse_one("POINT Z EMPTY").is_empty());
    }

    #[test]
    fn mistakes_have_reasons() {
        for (text, reason) in [
            ("CIRCULARSTRING(0 0, 1 1, 2 0)", Reason::Curve("CircularString")),
            ("CIRCLE(0 0)", Reason::UnknownType),
            ("POINT(1)", Reason::NotFinite),
            ("POINT(1 x)", Reason::Damaged("a coordinate in its text is not a number")),
            ("LINESTRING(0 0, 1 1", BRACKET),
            ("POINT(1 2) x", Reason::Damaged("its text does not end where its geometry ends")),
        ] {
            assert_eq!(parse(text).unwrap_err(), reason, "{text}");
        }
        let deep = "GEOMETRYCOLLECTION(".repeat(100_000);
        assert_eq!(parse(&deep).unwrap_err(), Reason::Damaged("its collections are nested too deep"));
        let (shapes, _) = parse("POINT(nan 2)").unwrap();
        assert_eq!(shapes.faults, [(Reason::NotFinite, 1)]);
    }
}
