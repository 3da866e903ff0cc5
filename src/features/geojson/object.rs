//! Reads the objects of a GeoJSON text: collections and features.

use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};

use super::super::bounded::Gauge;
use super::super::error::Cause;
use super::super::model::Attributes;
use super::super::model::Value;
use super::super::shapes::Shapes;
use super::super::sink::Sink;
use super::super::summary::{Crs, Reason};
use super::coordinates::{Coordinates, Nested};
use super::geometry::{Geometries, Geometry};
use super::value::{Brief, Name, Properties, Scalar};
use crate::file::message::quoted;

/// The state of the reader within one GeoJSON text.
pub(super) struct State<'s, 'e> {
    pub(super) sink: &'s mut Sink<'e>,
    pub(super) gauge: Gauge,
    /// The member `crs`, if there is one; `None` within means that it is said to be unknown.
    pub(super) crs: Option<Option<Crs>>,
    /// The member `name` of the collection.
    pub(super) name: Option<String>,
    /// The first error in the content rather than in the syntax; reading ends with it.
    pub(super) failure: Option<Cause>,
    /// Number of features so far.
    records: u64,
}

impl<'s, 'e> State<'s, 'e> {
    pub(super) fn new(sink: &'s mut Sink<'e>, gauge: Gauge) -> Self {
        Self { sink, gauge, crs: None, name: None, failure: None, records: 0 }
    }

    /// Ends reading with an error.
    pub(super) fn fail<E: Error>(&mut self, cause: Cause) -> E {
        self.failure.get_or_insert(cause);
        E::custom("")
    }

    pub(super) fn fail_here<E: Error>(&mut self, cause: &str) -> E {
        let records = self.records;
        let place = if records == 0 { String::new() } else { format!(" (after feature {records})") };
        self.fail(Cause::content(format!("is not valid GeoJSON: {cause}{place}")))
    }

    fn set_crs<E: Error>(&mut self, name: Option<&str>) -> Result<(), E> {
        let crs = match name.map(super::crs_of).transpose() {
            Ok(crs) => crs.flatten(),
            Err(cause) => return Err(self.fail(cause)),
        };
        match &self.crs {
            Some(own) if *own != crs => {
                Err(self.fail(Cause::content("contains several reference systems; split it into files of one each")))
            }
            _ => {
                self.crs = Some(crs);
                Ok(())
            }
        }
    }

    fn take<E: Error>(&mut self, shapes: Shapes, attributes: Attributes) -> Result<(), E> {
        self.records += 1;
        self.gauge.reset();
        match self.sink.take(0, self.records, shapes, attributes).is_break() {
            true => Err(E::custom("")),
            false => Ok(()),
        }
    }
}

/// The members of an object that matter.
#[derive(Clone, Copy, PartialEq, Eq, serde::Deserialize)]
#[serde(field_identifier, rename_all = "lowercase")]
pub(super) enum Member {
    Type,
    Crs,
    Name,
    Id,
    Features,
    Geometries,
    Geometry,
    Coordinates,
    Properties,
    #[serde(other)]
    Other,
}

/// The content of an object, as far as it has been read.
#[derive(Default)]
pub(super) struct Content {
    kind: Option<String>,
    /// The member that holds the geometry or the features.
    member: Option<Member>,
    coordinates: Nested,
    shapes: Shapes,
    properties: Attributes,
    id: Option<Value>,
}

/// Reads a member that every kind of object may have.
pub(super) fn read_member<'de, M: MapAccess<'de>>(
    state: &mut State<'_, '_>,
    content: &mut Content,
    member: Member,
    depth: usize,
    members: &mut M,
) -> Result<(), M::Error> {
    match member {
        Member::Type => content.kind = members.next_value::<Brief>()?.0,
        Member::Properties => content.properties = members.next_value_seed(Properties(&mut *state.sink))?,
        Member::Id => content.id = Some(members.next_value_seed(Scalar)?),
        Member::Coordinates | Member::Geometry | Member::Geometries if content.member.is_some() => {
            return Err(state.fail_here("an object has the members of two types"));
        }
        Member::Coordinates => {
            content.member = Some(member);
            content.coordinates = members.next_value_seed(Coordinates(state))?;
        }
        Member::Geometry => {
            content.member = Some(member);
            content.shapes = members.next_value_seed(Geometry { state, depth: depth + 1 })?;
        }
        Member::Geometries => {
            content.member = Some(member);
            content.shapes = members.next_value_seed(Geometries { state, depth: depth + 1 })?;
        }
        Member::Crs | Member::Name | Member::Features | Member::Other => drop(members.next_value::<IgnoredAny>()?),
    }
    Ok(())
}

/// Returns the geometry of an object that is not a collection of features.
pub(super) fn geometry<E: Error>(state: &mut State<'_, '_>, content: &mut Content) -> Result<Shapes, E> {
    let kind = content.kind.take();
    let coordinates = std::mem::take(&mut content.coordinates);
    match (kind.as_deref(), content.member) {
        (Some("GeometryCollection"), Some(Member::Geometries)) => Ok(std::mem::take(&mut content.shapes)),
        (Some("GeometryCollection"), None) => Ok(Shapes::faulty(Reason::Empty)),
        (Some(kind), Some(Member::Coordinates) | None) => match coordinates.shapes(kind) {
            Some(shapes) => Ok(shapes),
            None => Err(state.fail_here(&format!("an object has the unknown type {}", quoted(kind)))),
        },
        (Some(kind), Some(_)) => {
            Err(state.fail_here(&format!("an object of type {} has the members of another type", quoted(kind))))
        }
        (None, _) => Err(state.fail_here("an object has no type")),
    }
}

/// Passes a feature on, or a geometry without attributes.
fn take_object<E: Error>(state: &mut State<'_, '_>, mut content: Content) -> Result<(), E> {
    let is_feature = content.kind.as_deref() == Some("Feature");
    if !is_feature {
        let shapes = geometry(state, &mut content)?;
        return state.take(shapes, Attributes::default());
    }
    let shapes = match content.member {
        Some(Member::Geometry) => content.shapes,
        None => Shapes::faulty(Reason::NoGeometry),
        Some(_) => return Err(state.fail_here("a feature has the members of another type")),
    };
    let mut attributes = content.properties;
    if let Some(id) = content.id.filter(|_| *attributes.get("id") == Value::None) {
        let name = state.sink.name("id");
        state.sink.add(&mut attributes, &name, id);
    }
    state.take(shapes, attributes)
}

/// Reads one object that is not inside another.
pub(super) struct Document<'a, 's, 'e>(pub(super) &'a mut State<'s, 'e>);

impl<'de> DeserializeSeed<'de> for Document<'_, '_, '_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for Document<'_, '_, '_> {
    type Value = ();

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a GeoJSON object")
    }

    fn visit_map<M: MapAccess<'de>>(self, mut members: M) -> Result<(), M::Error> {
        let state = self.0;
        let mut content = Content::default();
        let mut has_features = false;
        while let Some(member) = members.next_key::<Member>()? {
            match member {
                Member::Crs => {
                    let name = members.next_value::<Name>()?.0;
                    state.set_crs(name.as_deref())?;
                }
                Member::Name => {
                    if let Some(name) = members.next_value::<Brief>()?.0 {
                        state.name.get_or_insert(name);
                    }
                }
                Member::Features if has_features || content.member.is_some() => {
                    return Err(state.fail_here("an object has the members of two types"));
                }
                Member::Features => {
                    has_features = true;
                    members.next_value_seed(Features(&mut *state))?;
                }
                _ => read_member(state, &mut content, member, 0, &mut members)?,
            }
        }
        match (content.kind.as_deref(), has_features) {
            (Some("FeatureCollection"), true) if content.member.is_none() => Ok(()),
            (Some("FeatureCollection"), false) => Err(state.fail_here("its collection has no features")),
            (_, true) => Err(state.fail_here("an object has features, but not the type FeatureCollection")),
            (_, false) => take_object(state, content),
        }
    }
}

/// Reads the list of features of a collection.
struct Features<'a, 's, 'e>(&'a mut State<'s, 'e>);

impl<'de> DeserializeSeed<'de> for Features<'_, '_, '_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for Features<'_, '_, '_> {
    type Value = ();

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a list of features")
    }

    fn visit_seq<S: SeqAccess<'de>>(self, mut list: S) -> Result<(), S::Error> {
        while list.next_element_seed(Feature(&mut *self.0))?.is_some() {}
        Ok(())
    }
}

/// Reads one feature of a collection.
struct Feature<'a, 's, 'e>(&'a mut State<'s, 'e>);

impl<'de> DeserializeSeed<'de> for Feature<'_, '_, '_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Feature<'_, '_, '_> {
    type Value = ();

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a feature")
    }

    /// Some programs write null for a feature that has been removed.
    fn visit_unit<E: Error>(self) -> Result<(), E> {
        self.0.take(Shapes::faulty(Reason::NoGeometry), Attributes::default())
    }

    fn visit_map<M: MapAccess<'de>>(self, mut members: M) -> Result<(), M::Error> {
        let mut content = Content::default();
        while let Some(member) = members.next_key::<Member>()? {
            read_member(self.0, &mut content, member, 0, &mut members)?;
        }
        take_object(self.0, content)
    }
}
