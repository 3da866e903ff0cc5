//! Reads the objects of a GeoJSON text one after the other, and stores the polygons among them.

use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Unexpected, Visitor};

use super::Polygons;

/// Largest nesting depth of collections.
const DEEPEST: usize = 8;

/// The rings that have been read so far.
pub(super) struct Found {
    pub(super) polygons: Polygons,
    pub(super) most_places: usize,
    /// The name of the reference system; empty for a `crs` without one.
    pub(super) crs: Option<String>,
    /// The first error in the content rather than in the JSON syntax; reading ends with it.
    pub(super) failure: Option<String>,
}

impl Found {
    fn fail<E: Error>(&mut self, cause: String) -> E {
        self.failure = Some(cause);
        E::custom("")
    }

    /// Returns how many positions, rings and polygons there are.
    fn counts(&self) -> [usize; 3] {
        let Polygons { places, ring_ends, polygon_ends, .. } = &self.polygons;
        [places.len(), ring_ends.len(), polygon_ends.len()]
    }

    /// Keeps the coordinates that were read after `before` if they have the depth of polygons, else drops them.
    fn take<E: Error>(&mut self, before: [usize; 3], read: Shape, depth: Option<u8>) -> Result<(), E> {
        let Some(depth) = depth else {
            self.polygons.places.truncate(before[0]);
            self.polygons.ring_ends.truncate(before[1]);
            self.polygons.polygon_ends.truncate(before[2]);
            return Ok(());
        };
        let wrong = match read {
            Shape { wrong: Some(wrong), .. } => Some(wrong),
            Shape { depth: Some(found), .. } if found == depth || found == EMPTY => None,
            _ => Some((before[2] + 1, "it has no list of rings")),
        };
        wrong.map_or(Ok(()), |(number, cause)| Err(self.fail(format!("polygon {number}: {cause}"))))
    }
}

/// Depth of an empty list, which may have any.
const EMPTY: u8 = 0;

/// The nesting of the coordinates of a geometry.
#[derive(Clone, Copy, Debug, Default)]
struct Shape {
    /// Depth of their lists: 1 for a position, 2 for a list of them, 3 for one of rings, 4 for one of polygons.
    depth: Option<u8>,
    /// The first mistake of a polygon, with the polygon's number.
    wrong: Option<(usize, &'static str)>,
}

/// A JSON value among coordinates.
enum Value {
    Number(f64),
    List(u8),
    Other,
}

/// Reads a value among coordinates, and adds what it contains to the vertices, rings and polygons.
struct Coordinates<'a> {
    found: &'a mut Found,
    shape: &'a mut Shape,
}

impl Coordinates<'_> {
    fn wrong(&mut self, cause: &'static str) {
        let number = self.found.polygons.polygon_ends.len() + 1;
        self.shape.wrong.get_or_insert((number, cause));
    }

    /// Ends a list, whose entries have the depth `inner`.
    fn end<E: Error>(&mut self, inner: u8) -> Result<(), E> {
        // The text after a mistake is skipped.
        if self.shape.wrong.is_some() {
            return Ok(());
        }
        let Polygons { places, ring_ends, polygon_ends, .. } = &mut self.found.polygons;
        match inner {
            1 => {
                let begin = ring_ends.last().map_or(0, |end| *end as usize);
                if places.len() > begin + 1 && places.get(begin) == places.last() {
                    places.pop();
                }
                if places.len() < begin + 3 {
                    self.wrong("a ring has fewer than three positions");
                } else {
                    ring_ends.push(places.len() as u32);
                }
            }
            2 => polygon_ends.push(ring_ends.len() as u32),
            3 => {}
            EMPTY => self.wrong("a ring has fewer than three positions"),
            _ => self.wrong("its lists are nested too deep"),
        }
        Ok(())
    }

    fn place<E: Error>(&mut self, place: [f64; 2]) -> Result<(), E> {
        if self.shape.wrong.is_some() {
            return Ok(());
        }
        if self.found.polygons.places.len() >= self.found.most_places {
            let most = self.found.most_places;
            return Err(self.found.fail(format!("it has more than {most} positions; simplify its outlines")));
        }
        self.found.polygons.places.push(place);
        Ok(())
    }
}

impl<'de> DeserializeSeed<'de> for Coordinates<'_> {
    type Value = Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Coordinates<'_> {
    type Value = Value;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("coordinates")
    }

    fn visit_f64<E>(self, number: f64) -> Result<Value, E> {
        Ok(Value::Number(number))
    }

    fn visit_i64<E>(self, number: i64) -> Result<Value, E> {
        Ok(Value::Number(number as f64))
    }

    fn visit_u64<E>(self, number: u64) -> Result<Value, E> {
        Ok(Value::Number(number as f64))
    }

    fn visit_bool<E>(self, _: bool) -> Result<Value, E> {
        Ok(Value::Other)
    }

    fn visit_str<E>(self, _: &str) -> Result<Value, E> {
        Ok(Value::Other)
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Other)
    }

    fn visit_map<M: MapAccess<'de>>(self, members: M) -> Result<Value, M::Error> {
        IgnoredAny.visit_map(members).map(|_| Value::Other)
    }

    fn visit_seq<S: SeqAccess<'de>>(mut self, mut list: S) -> Result<Value, S::Error> {
        let mut place = [0.0; 2];
        let (mut count, mut inner) = (0, None);
        while let Some(value) =
            list.next_element_seed(Coordinates { found: &mut *self.found, shape: &mut *self.shape })?
        {
            let is_mixed = count > 0 && matches!(value, Value::List(_)) != inner.is_some();
            match value {
                // Only the first two numbers of a position count; a third is a height.
                Value::Number(number) if count < 2 && !is_mixed => place[count] = number,
                Value::Other if count < 2 && !is_mixed => self.wrong("a position is not a pair of finite numbers"),
                Value::List(depth) if inner.is_none_or(|inner| inner == depth) && !is_mixed => inner = Some(depth),
                Value::Number(_) | Value::Other if !is_mixed => {}
                _ => self.wrong("a ring is not a list of positions"),
            }
            count += 1;
        }
        match (inner, count) {
            (Some(inner), _) => {
                self.end(inner)?;
                Ok(Value::List(inner.saturating_add(1)))
            }
            (None, 0) => Ok(Value::List(EMPTY)),
            (None, 1) => {
                self.wrong("a position is not a pair of finite numbers");
                Ok(Value::List(1))
            }
            (None, _) => {
                self.place(place)?;
                Ok(Value::List(1))
            }
        }
    }
}

/// The members of an object that matter.
#[derive(Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[serde(field_identifier, rename_all = "lowercase")]
enum Member {
    Type,
    Crs,
    Features,
    Geometries,
    Geometry,
    Coordinates,
    #[serde(other)]
    Other,
}

/// Reads a GeoJSON object: its polygons are added to those found.
pub(super) struct Object<'a> {
    pub(super) found: &'a mut Found,
    /// Number of objects around this one.
    pub(super) depth: usize,
}

impl<'de> DeserializeSeed<'de> for Object<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Object<'_> {
    type Value = ();

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("an object of a known type")
    }

    /// A feature without a geometry has null in its place.
    fn visit_unit<E: Error>(self) -> Result<(), E> {
        if self.depth == 0 { Err(E::invalid_type(Unexpected::Unit, &self)) } else { Ok(()) }
    }

    fn visit_map<M: MapAccess<'de>>(self, mut members: M) -> Result<(), M::Error> {
        let Self { found, depth } = self;
        if depth > DEEPEST {
            return Err(found.fail(format!("its collections are nested more than {DEEPEST} deep")));
        }
        let mut kind: Option<String> = None;
        // The member that holds the object's content; of other members nothing is stored.
        let mut content: Option<Member> = None;
        let (before, mut shape) = (found.counts(), Shape::default());
        while let Some(member) = members.next_key::<Member>()? {
            match member {
                Member::Type => kind = members.next_value::<Text>()?.0,
                Member::Crs if depth == 0 => found.crs = members.next_value::<Crs>()?.name(),
                Member::Crs | Member::Other => drop(members.next_value::<IgnoredAny>()?),
                _ if content.is_some() => {
                    return Err(found.fail("it is not GeoJSON: an object has the members of two types".to_owned()));
                }
                Member::Coordinates => {
                    content = Some(member);
                    let seed = Coordinates { found: &mut *found, shape: &mut shape };
                    if let Value::List(depth) = members.next_value_seed(seed)? {
                        shape.depth = Some(depth);
                    }
                }
                Member::Geometry => {
                    content = Some(member);
                    members.next_value_seed(Object { found: &mut *found, depth: depth + 1 })?;
                }
                Member::Features | Member::Geometries => {
                    content = Some(member);
                    members.next_value_seed(Objects { found: &mut *found, depth: depth + 1 })?;
                }
            }
        }
        let cause = match (kind.as_deref(), content) {
            (Some("FeatureCollection"), Some(Member::Features))
            | (Some("GeometryCollection"), Some(Member::Geometries))
            | (Some("Feature"), Some(Member::Geometry) | None) => return Ok(()),
            // Lines and points have no interior.
            (Some("Point" | "MultiPoint" | "LineString" | "MultiLineString"), Some(Member::Coordinates) | None) => {
                return found.take(before, shape, None);
            }
            (Some("Polygon"), Some(Member::Coordinates) | None) => return found.take(before, shape, Some(3)),
            (Some("MultiPolygon"), Some(Member::Coordinates)) => return found.take(before, shape, Some(4)),
            (Some("FeatureCollection"), None) => "its collection has no features",
            (Some("GeometryCollection"), None) => "its collection has no geometries",
            (Some("MultiPolygon"), None) => "a MultiPolygon has no coordinates",
            _ => "it is not GeoJSON: an object has no known type",
        };
        Err(found.fail(cause.to_owned()))
    }
}

/// Reads a list of objects.
struct Objects<'a> {
    found: &'a mut Found,
    depth: usize,
}

impl<'de> DeserializeSeed<'de> for Objects<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for Objects<'_> {
    type Value = ();

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a list of objects")
    }

    fn visit_seq<S: SeqAccess<'de>>(self, mut list: S) -> Result<(), S::Error> {
        while list.next_element_seed(Object { found: &mut *self.found, depth: self.depth })?.is_some() {}
        Ok(())
    }
}

/// A value that should be text; `None` for any other value, which is not stored.
struct Text(Option<String>);

impl<'de> serde::Deserialize<'de> for Text {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(TextVisitor)
    }
}

struct TextVisitor;

impl<'de> Visitor<'de> for TextVisitor {
    type Value = Text;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("text")
    }

    fn visit_str<E>(self, text: &str) -> Result<Text, E> {
        Ok(Text(Some(text.to_owned())))
    }

    fn visit_bool<E>(self, _: bool) -> Result<Text, E> {
        Ok(Text(None))
    }

    fn visit_i64<E>(self, _: i64) -> Result<Text, E> {
        Ok(Text(None))
    }

    fn visit_u64<E>(self, _: u64) -> Result<Text, E> {
        Ok(Text(None))
    }

    fn visit_f64<E>(self, _: f64) -> Result<Text, E> {
        Ok(Text(None))
    }

    fn visit_unit<E>(self) -> Result<Text, E> {
        Ok(Text(None))
    }

    fn visit_seq<S: SeqAccess<'de>>(self, list: S) -> Result<Text, S::Error> {
        IgnoredAny.visit_seq(list).map(|_| Text(None))
    }

    fn visit_map<M: MapAccess<'de>>(self, members: M) -> Result<Text, M::Error> {
        IgnoredAny.visit_map(members).map(|_| Text(None))
    }
}

/// The member `crs`, which may be null.
#[derive(serde::Deserialize)]
#[serde(transparent)]
struct Crs(Option<CrsObject>);

#[derive(serde::Deserialize)]
struct CrsObject {
    properties: Option<CrsProperties>,
}

#[derive(serde::Deserialize)]
struct CrsProperties {
    name: Option<String>,
}

impl Crs {
    /// Returns the name of the system, empty if the object has none; `None` for null.
    fn name(self) -> Option<String> {
        Some(self.0?.properties.and_then(|properties| properties.name).unwrap_or_default())
    }
}
