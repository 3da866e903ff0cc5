//! Parameters of styles and of their recipes. Each parameter is defined once.
//!
//! A section of a style file is a struct that the macro `parameters!` generates from a list. A line of the list defines
//! a parameter, and everything else is generated from it: the field and its doc comment, parsing, the range check,
//! writing, scaling for paper, the row of `hachure styles show NAME --all`, and the row of `docs/style-parameters.md`.
//!
//! ```text
//! /// One sentence of help, which is also the doc comment.
//! field as "key" in "unit" called "Label": Type = default => range, soft end, zero "word";
//! ```
//!
//! - `as "key"` sets the key, if it differs from the field's name.
//! - `in "unit"` sets the unit, if the name does not end with one: `width_px` is in pixels without it.
//! - `called "Label"` sets the name in the inspector, where the key in words would not say what the parameter is.
//! - Without a default, a number, text, colour or choice is required; an `Option` defaults to `None`, and a section to
//!   what it is when none of its keys are given.
//! - The range is a [`Range`]; without one, every value of the type is allowed. `soft` is the upper end of a slider, if
//!   useful values are far below the largest allowed one, or if there is none. `zero` is the word that is shown for the
//!   value 0, where 0 means that there is none of something, or that it is chosen automatically.
//!
//! After the name of a struct, `listed` names a check for lists of such sections, and `whole` a check that compares
//! several parameters. Fields in `loaded` are not parameters; the code that loads a style fills them in.

mod definition;
mod document;
mod range;
mod setting;
mod text;

use serde::de::DeserializeOwned;

pub(crate) use definition::unit;
pub(crate) use definition::{Choice, Definition, Parameter, ValueKind, parameters_of};
#[cfg(any(feature = "window", feature = "headset"))]
pub(crate) use definition::{capitalised, uncapitalised};
pub use document::document;
pub(crate) use range::Range;
pub(crate) use setting::{Setting, absent, first, shortest};
#[cfg(any(feature = "window", feature = "headset"))]
pub(crate) use text::restore;
pub(crate) use text::{Tree, find, set, set_all, text};

use super::{extends, layers};
use crate::file::toml_text::{self, TomlError, Wrong};

/// Generates a section of a style file from the definitions of its parameters; see the head of this file.
macro_rules! parameters {
    (
        $(#[doc = $about:literal])+
        $(#[derive($($derived:ident),+)])?
        pub struct $name:ident $(, listed $listed:path)? $(, whole $whole:path)? {
            $(
                $(#[doc = $help:literal])+
                $field:ident $(as $key:literal)? $(in $unit:literal)? $(called $label:literal)? : $type:ty $(= $default:expr)?
                    $(=> $range:expr $(, soft $soft:expr)? $(, zero $zero:literal)?)?;
            )+
        }
        $(loaded {
            $(
                $(#[doc = $loaded_help:literal])+
                $loaded:ident: $loaded_type:ty;
            )+
        })?
    ) => {
        $(#[doc = $about])+
        #[derive(Clone, Debug, PartialEq $($(, $derived)+)?)]
        pub struct $name {
            $(
                $(#[doc = $help])+
                pub $field: $type,
            )+
            $($(
                $(#[doc = $loaded_help])+
                pub $loaded: $loaded_type,
            )+)?
        }

        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                /// The keys that the text has.
                #[derive(serde::Deserialize)]
                #[serde(deny_unknown_fields)]
                struct Given {
                    $(
                        $(#[serde(rename = $key)])?
                        $field: Option<$type>,
                    )+
                }
                let given = Given::deserialize(deserializer)?;
                let missing = [$(
                    (given.$field.is_none() && $crate::style::parameters::absent::<$type, _>([$($default)?]).is_none())
                        .then_some($crate::style::parameters::first(&[$($key,)? stringify!($field)]))
                ),+];
                let missing: Vec<&str> = missing.into_iter().flatten().collect();
                if missing.len() > 1 {
                    return Err(serde::de::Error::custom($crate::style::parameters::keys_are_missing(&missing)));
                }
                Ok(Self {
                    $(
                        $field: match given.$field.or_else(|| $crate::style::parameters::absent::<$type, _>([$($default)?])) {
                            Some(value) => value,
                            None => {
                                let key = $crate::style::parameters::first(&[$($key,)? stringify!($field)]);
                                return Err(serde::de::Error::missing_field(key));
                            }
                        },
                    )+
                    $($($loaded: Default::default(),)+)?
                })
            }
        }

        impl $crate::style::parameters::Setting for $name {
            fn kind() -> $crate::style::parameters::ValueKind {
                $crate::style::parameters::ValueKind::Section(vec![$(
                    $crate::style::parameters::Definition::of::<$type>(
                        $crate::style::parameters::first(&[$($key,)? stringify!($field)]),
                        concat!($($help),+),
                        &[$($unit)?],
                        $crate::style::parameters::first(&[$($range,)? $crate::style::parameters::Range::Any]),
                        $crate::style::parameters::absent([$($default)?]),
                    )
                    .with_soft_end(&[$($($soft)?)?])
                    .with_label(&[$($label)?])
                    .with_zero_word(&[$($($zero)?)?])
                ),+])
            }

            fn default_value() -> Option<Self> {
                Some(Self {
                    $($field: $crate::style::parameters::absent::<$type, _>([$($default)?])?,)+
                    $($($loaded: Default::default(),)+)?
                })
            }

            fn check(
                &self,
                key: &str,
                _: &$crate::style::parameters::Range,
            ) -> Result<(), $crate::file::toml_text::Wrong> {
                let key_of = |name: &str| if key.is_empty() { name.to_owned() } else { format!("{key}.{name}") };
                $(
                    $crate::style::parameters::Setting::check(
                        &self.$field,
                        &key_of($crate::style::parameters::first(&[$($key,)? stringify!($field)])),
                        &$crate::style::parameters::first(&[$($range,)? $crate::style::parameters::Range::Any]),
                    )?;
                )+
                $($whole(self, key)?;)?
                Ok(())
            }

            fn scale_lengths(&mut self, factor: f32, _: Option<&str>, _: &$crate::style::parameters::Range) {
                $(
                    $crate::style::parameters::Setting::scale_lengths(
                        &mut self.$field,
                        factor,
                        $crate::style::parameters::unit(
                            &[$($unit)?],
                            $crate::style::parameters::first(&[$($key,)? stringify!($field)]),
                        ),
                        &$crate::style::parameters::first(&[$($range,)? $crate::style::parameters::Range::Any]),
                    );
                )+
            }

            $(
                fn check_list(list: &[Self], key: &str) -> Result<(), $crate::file::toml_text::Wrong> {
                    $listed(list, key)
                }
            )?

            fn item(&self) -> Option<toml_edit::Item> {
                let mut table = toml_edit::Table::new();
                $(
                    if let Some(item) = $crate::style::parameters::Setting::item(&self.$field) {
                        table.insert($crate::style::parameters::first(&[$($key,)? stringify!($field)]), item);
                    }
                )+
                Some(toml_edit::Item::Table(table))
            }
        }

        impl serde::Serialize for $name {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                let item = $crate::style::parameters::Setting::item(self);
                serde::Serialize::serialize(&$crate::style::parameters::Tree(item.as_ref()), serializer)
            }
        }
    };
}
pub(crate) use parameters;

/// Generates the type of a parameter that is one of several names: the variants in lower case, each with its help.
macro_rules! choices {
    (
        $(#[doc = $about:literal])+
        $visibility:vis enum $name:ident {
            $(
                $(#[doc = $help:literal])+
                $variant:ident,
            )+
        }
    ) => {
        $(#[doc = $about])+
        #[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
        #[serde(rename_all = "lowercase")]
        $visibility enum $name {
            $(
                $(#[doc = $help])+
                $variant,
            )+
        }

        impl $crate::style::parameters::Setting for $name {
            fn kind() -> $crate::style::parameters::ValueKind {
                $crate::style::parameters::ValueKind::Choice(vec![$(
                    $crate::style::parameters::Choice {
                        name: stringify!($variant).to_lowercase(),
                        help: concat!($($help),+).trim_ascii(),
                    }
                ),+])
            }

            fn item(&self) -> Option<toml_edit::Item> {
                Some(toml_edit::value(self.name()))
            }
        }

        impl $name {
            /// Returns the name, as written in a style file.
            $visibility fn name(self) -> String {
                match self {
                    $(Self::$variant => stringify!($variant).to_lowercase(),)+
                }
            }
        }
    };
}
pub(crate) use choices;

/// Parses a style or a recipe and checks every parameter; errors begin with `name`, the name of the file.
///
/// # Errors
/// Invalid TOML; an unknown or missing key; a value of the wrong type or out of its range.
pub(crate) fn read<T: Setting + DeserializeOwned>(name: &str, text: &str) -> Result<T, TomlError> {
    let known: Vec<&'static str> = match T::kind() {
        ValueKind::Section(definitions) => definitions.iter().map(|definition| definition.key).collect(),
        _ => Vec::new(),
    };
    let read: T = toml_text::read_rewritten(name, text, |table| {
        if known.contains(&"layers") {
            extends::merge(table)?;
        }
        layers::with_layers(table, &known)
    })?;
    read.check("", &Range::Any).map_err(|wrong| in_text(wrong, name, text))?;
    Ok(read)
}

/// Returns the message about several required keys that a section lacks.
pub(crate) fn keys_are_missing(keys: &[&str]) -> String {
    let keys: Vec<String> = keys.iter().map(|key| format!("\"{key}\"")).collect();
    format!("the keys {} are missing", keys.join(", "))
}

/// Returns a key without the indices of list entries, as messages have it.
pub(super) fn without_indices(key: &str) -> String {
    key.split('[').map(|part| part.split_once(']').map_or(part, |(_, rest)| rest)).collect()
}

/// Returns a mistake with its position in a style's text, which may have either form.
pub(super) fn in_text(wrong: Wrong, name: &str, text: &str) -> TomlError {
    let Ok(document) = text.parse::<toml_edit::DocumentMut>() else { return wrong.in_text(name, text) };
    let key = layers::key_in_document(document.as_item(), &wrong.key);
    // A layer is called by its kind, with its number from the second of the kind on; a list in a section is called by
    // the name that the text has.
    let (layer, within) = wrong.key.split_at(wrong.key.find('.').unwrap_or(wrong.key.len()));
    let shown = match key.starts_with("layers[") {
        true => format!("{layer}{}", without_indices(within)),
        false => without_indices(&key),
    };
    let words = wrong.message.strip_prefix(&without_indices(&wrong.key));
    let message = words.map_or_else(|| wrong.message.clone(), |words| format!("{shown}{words}"));
    Wrong { message, key }.in_text(name, text)
}
