//! Reads the attributes of a feature, and small values.

use std::fmt::{self, Write};

use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};

use super::super::model::{Attributes, Value};
use super::super::sink::Sink;

/// Longest text of a nested value in bytes; the rest is cut off. No rule of a style compares such a text.
const LONGEST_NESTED: usize = 1 << 20;

/// Largest number of attributes of a feature.
const MOST_VALUES: usize = 1 << 16;

/// Reads the member `properties`, which may be null.
pub(super) struct Properties<'a, 'e>(pub(super) &'a mut Sink<'e>);

impl<'de> DeserializeSeed<'de> for Properties<'_, '_> {
    type Value = Attributes;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Attributes, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Properties<'_, '_> {
    type Value = Attributes;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("an object of properties")
    }

    fn visit_unit<E: Error>(self) -> Result<Attributes, E> {
        Ok(Attributes::default())
    }

    fn visit_map<M: MapAccess<'de>>(self, mut members: M) -> Result<Attributes, M::Error> {
        let mut attributes = Attributes::default();
        let mut count = 0;
        while let Some(name) = members.next_key::<String>()? {
            count += 1;
            if count > MOST_VALUES {
                return Err(M::Error::custom(format!("a feature has more than {MOST_VALUES} properties")));
            }
            let value = members.next_value_seed(Scalar)?;
            let name = self.0.name(&name);
            self.0.add(&mut attributes, &name, value);
        }
        Ok(attributes)
    }
}

/// Reads the value of an attribute. A list or an object becomes its JSON text.
pub(super) struct Scalar;

impl<'de> DeserializeSeed<'de> for Scalar {
    type Value = Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Scalar {
    type Value = Value;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a value")
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::None)
    }

    fn visit_bool<E>(self, value: bool) -> Result<Value, E> {
        Ok(Value::Bool(value))
    }

    fn visit_i64<E>(self, number: i64) -> Result<Value, E> {
        Ok(Value::integer(number))
    }

    fn visit_u64<E>(self, number: u64) -> Result<Value, E> {
        Ok(Value::integer(number))
    }

    fn visit_f64<E>(self, number: f64) -> Result<Value, E> {
        Ok(Value::number(number))
    }

    fn visit_str<E>(self, text: &str) -> Result<Value, E> {
        Ok(Value::text(text))
    }

    fn visit_string<E>(self, text: String) -> Result<Value, E> {
        Ok(if text.is_empty() { Value::None } else { Value::Text(text) })
    }

    fn visit_seq<S: SeqAccess<'de>>(self, list: S) -> Result<Value, S::Error> {
        let mut text = String::new();
        Json(&mut text).visit_seq(list)?;
        Ok(Value::Text(text))
    }

    fn visit_map<M: MapAccess<'de>>(self, members: M) -> Result<Value, M::Error> {
        let mut text = String::new();
        Json(&mut text).visit_map(members)?;
        Ok(Value::Text(text))
    }
}

/// Reads a value, and writes it as JSON text.
struct Json<'a>(&'a mut String);

impl Json<'_> {
    fn push(&mut self, text: impl fmt::Display) {
        if self.0.len() < LONGEST_NESTED {
            // Writing to a string does not fail.
            let _ = write!(self.0, "{text}");
        }
    }

    fn push_text(&mut self, text: &str) {
        let mut end = text.len().min(LONGEST_NESTED);
        while !text.is_char_boundary(end) {
            end -= 1;
        }
        let quoted = serde_json::to_string(text.get(..end).unwrap_or_default());
        self.push(quoted.unwrap_or_default());
    }
}

impl<'de> DeserializeSeed<'de> for Json<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Json<'_> {
    type Value = ();

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a value")
    }

    fn visit_unit<E>(mut self) -> Result<(), E> {
        self.push("null");
        Ok(())
    }

    fn visit_bool<E>(mut self, value: bool) -> Result<(), E> {
        self.push(value);
        Ok(())
    }

    fn visit_i64<E>(mut self, number: i64) -> Result<(), E> {
        self.push(number);
        Ok(())
    }

    fn visit_u64<E>(mut self, number: u64) -> Result<(), E> {
        self.push(number);
        Ok(())
    }

    fn visit_f64<E>(mut self, number: f64) -> Result<(), E> {
        self.push(number);
        Ok(())
    }

    fn visit_str<E>(mut self, text: &str) -> Result<(), E> {
        self.push_text(text);
        Ok(())
    }

    fn visit_seq<S: SeqAccess<'de>>(mut self, mut list: S) -> Result<(), S::Error> {
        self.push('[');
        let mut is_first = true;
        loop {
            let length = self.0.len();
            if !is_first {
                self.push(',');
            }
            if list.next_element_seed(Json(&mut *self.0))?.is_none() {
                self.0.truncate(length);
                break;
            }
            is_first = false;
        }
        self.push(']');
        Ok(())
    }

    fn visit_map<M: MapAccess<'de>>(mut self, mut members: M) -> Result<(), M::Error> {
        self.push('{');
        let mut is_first = true;
        while let Some(name) = members.next_key::<String>()? {
            if !std::mem::take(&mut is_first) {
                self.push(',');
            }
            self.push_text(&name);
            self.push(':');
            members.next_value_seed(Json(&mut *self.0))?;
        }
        self.push('}');
        Ok(())
    }
}

/// A value that should be a short text; `None` for any other value, which is not stored.
#[derive(Default)]
pub(super) struct Brief(pub(super) Option<String>);

impl<'de> serde::Deserialize<'de> for Brief {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(match Scalar.deserialize(deserializer)? {
            Value::Text(text) => Self(Some(text)),
            _ => Self(None),
        })
    }
}

/// The name in the member `crs`: empty for an object without a name, `None` for null.
pub(super) struct Name(pub(super) Option<String>);

impl<'de> serde::Deserialize<'de> for Name {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(NameVisitor)
    }
}

struct NameVisitor;

impl<'de> Visitor<'de> for NameVisitor {
    type Value = Name;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a reference system")
    }

    fn visit_unit<E>(self) -> Result<Name, E> {
        Ok(Name(None))
    }

    /// Some programs write the name itself.
    fn visit_str<E>(self, text: &str) -> Result<Name, E> {
        Ok(Name(Some(text.to_owned())))
    }

    fn visit_map<M: MapAccess<'de>>(self, mut members: M) -> Result<Name, M::Error> {
        let mut name = String::new();
        while let Some(member) = members.next_key::<String>()? {
            match member.as_str() {
                "properties" => name = members.next_value::<NameProperties>()?.name.unwrap_or_default(),
                _ => drop(members.next_value::<IgnoredAny>()?),
            }
        }
        Ok(Name(Some(name)))
    }
}

#[derive(serde::Deserialize)]
struct NameProperties {
    name: Option<String>,
}
