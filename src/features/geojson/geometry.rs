//! Reads the geometries of a GeoJSON text.

use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};

use super::super::shapes::Shapes;
use super::super::summary::Reason;
use super::object::{self, Content, Member, State};

/// Deepest nesting of geometry collections.
const DEEPEST: usize = 8;

/// Reads the geometry of a feature, or a geometry in a collection.
pub(super) struct Geometry<'a, 's, 'e> {
    pub(super) state: &'a mut State<'s, 'e>,
    /// Number of geometries around this one, counted from 1.
    pub(super) depth: usize,
}

impl<'de> DeserializeSeed<'de> for Geometry<'_, '_, '_> {
    type Value = Shapes;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Shapes, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Geometry<'_, '_, '_> {
    type Value = Shapes;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a geometry")
    }

    fn visit_unit<E: Error>(self) -> Result<Shapes, E> {
        Ok(Shapes::faulty(Reason::NoGeometry))
    }

    fn visit_map<M: MapAccess<'de>>(self, mut members: M) -> Result<Shapes, M::Error> {
        let Self { state, depth } = self;
        if depth > DEEPEST {
            return Err(state.fail_here(&format!("its collections are nested more than {DEEPEST} deep")));
        }
        let mut content = Content::default();
        while let Some(member) = members.next_key::<Member>()? {
            match member {
                Member::Properties | Member::Id => drop(members.next_value::<IgnoredAny>()?),
                _ => object::read_member(state, &mut content, member, depth, &mut members)?,
            }
        }
        object::geometry(state, &mut content)
    }
}

/// Reads the list of geometries of a collection.
pub(super) struct Geometries<'a, 's, 'e> {
    pub(super) state: &'a mut State<'s, 'e>,
    pub(super) depth: usize,
}

impl<'de> DeserializeSeed<'de> for Geometries<'_, '_, '_> {
    type Value = Shapes;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Shapes, D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for Geometries<'_, '_, '_> {
    type Value = Shapes;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a list of geometries")
    }

    fn visit_seq<S: SeqAccess<'de>>(self, mut list: S) -> Result<Shapes, S::Error> {
        let mut shapes = Shapes::default();
        let Self { state, depth } = self;
        while let Some(part) = list.next_element_seed(Geometry { state: &mut *state, depth })? {
            shapes.append(part);
        }
        Ok(shapes)
    }
}
