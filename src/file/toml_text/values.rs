//! Passes the values of a TOML text to serde and keeps their positions for errors.

use serde::Deserializer;
use serde::de::value::StrDeserializer;
use serde::de::{DeserializeSeed, EnumAccess, IntoDeserializer, MapAccess, SeqAccess, VariantAccess, Visitor};
use serde::forward_to_deserialize_any;
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

use super::mistake::{Kind, Mistake, described};

type Key<'a> = Spanned<std::borrow::Cow<'a, str>>;

/// The deserializer of a whole text.
pub(super) struct Root<'a>(pub &'a Spanned<DeTable<'a>>);

impl<'de> Deserializer<'de> for Root<'_> {
    type Error = Mistake;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Mistake> {
        visitor.visit_map(Entries::of(self.0.get_ref()))
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit unit_struct
        newtype_struct seq tuple tuple_struct map struct enum identifier ignored_any
    }
}

/// The deserializer of a value.
#[derive(Clone, Copy)]
struct Value<'a>(&'a Spanned<DeValue<'a>>);

impl<'a> Value<'a> {
    /// Returns the mistake of a value where something else was expected.
    fn not(self, wanted: &str) -> Mistake {
        Mistake::wanted(wanted, described(self.0.get_ref()))
    }

    fn text(self) -> Result<&'a str, Mistake> {
        self.0.get_ref().as_str().ok_or_else(|| self.not("text"))
    }

    fn number(self) -> Result<f64, Mistake> {
        let number = match self.0.get_ref() {
            DeValue::Float(number) => number.as_str().parse().ok(),
            DeValue::Integer(_) => self.integer().map(|number| number as f64),
            _ => None,
        };
        number.ok_or_else(|| self.not("a number"))
    }

    fn integer(self) -> Option<i64> {
        let DeValue::Integer(number) = self.0.get_ref() else { return None };
        i64::from_str_radix(number.as_str(), number.radix()).ok()
    }

    /// Returns the value as an integer of a type with the range `least` to `most`.
    fn whole<T: TryFrom<i64> + Into<i128>>(self, least: T, most: T) -> Result<T, Mistake> {
        self.integer().and_then(|number| T::try_from(number).ok()).ok_or_else(|| {
            let wanted = format!("a whole number from {} to {}", least.into(), most.into());
            let found = match self.0.get_ref() {
                DeValue::Integer(number) => format!("it is {}", super::super::message::shown(&number.to_string())),
                DeValue::Float(number) => format!("it is {}", super::super::message::shown(number.as_str())),
                other => described(other),
            };
            Mistake::wanted(wanted, found)
        })
    }

    fn list(self) -> Result<&'a DeArray<'a>, Mistake> {
        self.0.get_ref().as_array().ok_or_else(|| self.not("a list"))
    }

    fn table(self) -> Result<&'a DeTable<'a>, Mistake> {
        self.0.get_ref().as_table().ok_or_else(|| self.not("a table"))
    }
}

/// Defines the methods for integers of each type.
macro_rules! whole_numbers {
    ($($method:ident $visit:ident $number:ident,)*) => {$(
        fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Mistake> {
            visitor.$visit(self.whole($number::MIN, $number::MAX)?)
        }
    )*};
}

impl<'de> Deserializer<'de> for Value<'_> {
    type Error = Mistake;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Mistake> {
        match self.0.get_ref() {
            DeValue::String(text) => visitor.visit_str(text),
            DeValue::Integer(_) => visitor.visit_i64(self.whole(i64::MIN, i64::MAX)?),
            DeValue::Float(_) => visitor.visit_f64(self.number()?),
            DeValue::Boolean(value) => visitor.visit_bool(*value),
            DeValue::Datetime(time) => visitor.visit_string(time.to_string()),
            DeValue::Array(list) => visitor.visit_seq(List(list.iter().enumerate())),
            DeValue::Table(table) => visitor.visit_map(Entries::of(table)),
        }
    }

    whole_numbers! {
        deserialize_u8 visit_u8 u8,
        deserialize_u16 visit_u16 u16,
        deserialize_u32 visit_u32 u32,
        deserialize_i8 visit_i8 i8,
        deserialize_i16 visit_i16 i16,
        deserialize_i32 visit_i32 i32,
        deserialize_i64 visit_i64 i64,
        deserialize_u64 visit_u64 u64,
    }

    fn deserialize_f32<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Mistake> {
        visitor.visit_f64(self.number()?)
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Mistake> {
        visitor.visit_f64(self.number()?)
    }

    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Mistake> {
        match self.0.get_ref() {
            DeValue::Boolean(value) => visitor.visit_bool(*value),
            _ => Err(self.not("true or false")),
        }
    }

    fn deserialize_str<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Mistake> {
        visitor.visit_str(self.text()?)
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Mistake> {
        visitor.visit_str(self.text()?)
    }

    fn deserialize_identifier<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Mistake> {
        visitor.visit_str(self.text()?)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Mistake> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, Mistake> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Mistake> {
        visitor.visit_seq(List(self.list()?.iter().enumerate()))
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, Mistake> {
        let list = self.0.get_ref().as_array().ok_or_else(|| self.not(&format!("a list of {length}")))?;
        if list.len() != length {
            return Err(Mistake::wanted(format!("a list of {length}"), format!("it has {}", list.len())));
        }
        visitor.visit_seq(List(list.iter().enumerate()))
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Mistake> {
        visitor.visit_map(Entries::of(self.table()?))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Mistake> {
        visitor.visit_map(Entries::of(self.table()?))
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        names: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Mistake> {
        // A variant with contents is a table with one key.
        if let DeValue::Table(table) = self.0.get_ref()
            && let (1, Some((key, value))) = (table.len(), table.iter().next())
        {
            return visitor.visit_enum(Variant { key, value });
        }
        let text = self.0.get_ref().as_str().ok_or_else(|| self.not(&format!("one of {}", names.join(", "))))?;
        visitor.visit_enum(Name(text))
    }

    forward_to_deserialize_any! { i128 u128 char bytes byte_buf unit unit_struct tuple_struct ignored_any }
}

/// The name of an enum variant without contents.
struct Name<'a>(&'a str);

impl<'de> EnumAccess<'de> for Name<'_> {
    type Error = Mistake;
    type Variant = Bare;

    fn variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, Bare), Mistake> {
        let text: StrDeserializer<'_, Mistake> = self.0.into_deserializer();
        Ok((seed.deserialize(text)?, Bare))
    }
}

/// The absent contents of such a variant.
struct Bare;

impl<'de> VariantAccess<'de> for Bare {
    type Error = Mistake;

    fn unit_variant(self) -> Result<(), Mistake> {
        Ok(())
    }

    fn newtype_variant_seed<S: DeserializeSeed<'de>>(self, _: S) -> Result<S::Value, Mistake> {
        Err(Mistake::wanted("a table", "it is text"))
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, _: V) -> Result<V::Value, Mistake> {
        Err(Mistake::wanted("a list", "it is text"))
    }

    fn struct_variant<V: Visitor<'de>>(self, _: &'static [&'static str], _: V) -> Result<V::Value, Mistake> {
        Err(Mistake::wanted("a table", "it is text"))
    }
}

/// The name of an enum variant with its contents.
struct Variant<'a> {
    key: &'a Key<'a>,
    value: &'a Spanned<DeValue<'a>>,
}

impl<'de> EnumAccess<'de> for Variant<'_> {
    type Error = Mistake;
    type Variant = Self;

    fn variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, Self), Mistake> {
        let text: StrDeserializer<'_, Mistake> = self.key.get_ref().as_ref().into_deserializer();
        let name = seed.deserialize(text);
        let name =
            name.map_err(|mistake| Mistake { at: Some(self.key.span()), path: vec!["kind".to_owned()], ..mistake });
        Ok((name?, self))
    }
}

impl<'de> VariantAccess<'de> for Variant<'_> {
    type Error = Mistake;

    fn unit_variant(self) -> Result<(), Mistake> {
        Err(Mistake::wanted("text", "it is a table"))
    }

    fn newtype_variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<S::Value, Mistake> {
        let Self { key, value } = self;
        seed.deserialize(Value(value)).map_err(|mistake| mistake.within(key.get_ref(), value.get_ref(), value.span()))
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, _: V) -> Result<V::Value, Mistake> {
        Err(Mistake::wanted("a list", "it is a table"))
    }

    fn struct_variant<V: Visitor<'de>>(self, _: &'static [&'static str], visitor: V) -> Result<V::Value, Mistake> {
        visitor.visit_map(Entries::of(Value(self.value).table()?))
    }
}

/// The entries of a list.
struct List<'a>(std::iter::Enumerate<std::slice::Iter<'a, Spanned<DeValue<'a>>>>);

impl<'de> SeqAccess<'de> for List<'_> {
    type Error = Mistake;

    fn next_element_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Mistake> {
        let Some((index, entry)) = self.0.next() else { return Ok(None) };
        seed.deserialize(Value(entry)).map(Some).map_err(|mut mistake| {
            mistake.path.insert(0, format!("[{index}]"));
            Mistake { at: mistake.at.or(Some(entry.span())), ..mistake }
        })
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.0.len())
    }
}

/// The entries of a table in the order of the text, so that the first mistake is reported.
struct Entries<'a> {
    entries: std::vec::IntoIter<(&'a Key<'a>, &'a Spanned<DeValue<'a>>)>,
    current: Option<(&'a Key<'a>, &'a Spanned<DeValue<'a>>)>,
}

impl<'a> Entries<'a> {
    fn of(table: &'a DeTable<'a>) -> Self {
        let mut entries: Vec<_> = table.iter().collect();
        entries.sort_by_key(|(key, _)| key.span().start);
        Self { entries: entries.into_iter(), current: None }
    }
}

impl<'de> MapAccess<'de> for Entries<'_> {
    type Error = Mistake;

    fn next_key_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, Mistake> {
        self.current = self.entries.next();
        let Some((key, _)) = self.current else { return Ok(None) };
        let text: StrDeserializer<'_, Mistake> = key.get_ref().as_ref().into_deserializer();
        let key_read = seed.deserialize(text);
        key_read.map(Some).map_err(|mistake| Mistake { at: Some(key.span()), ..mistake })
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value, Mistake> {
        let Some((key, value)) = self.current.take() else {
            return Err(Kind::Other("a value was requested before its key".to_owned()).into());
        };
        seed.deserialize(Value(value)).map_err(|mistake| mistake.within(key.get_ref(), value.get_ref(), value.span()))
    }
}
