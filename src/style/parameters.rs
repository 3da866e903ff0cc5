//! Parameters of styles and of their recipes, each defined once.
//!
//! A section of a style file is a struct that the macro `parameters!` makes from a list. A line of the list is the
//! definition of a parameter, and everything else is made from it: the field and its docstring, parsing, the check of
//! its range, what is written, the row of `hachure styles show NAME --all`, and the row of `docs/style-parameters.md`.
//!
//! ```text
//! /// Help in a line, which is the docstring too.
//! field as "key" in "unit": Type = default => range;
//! ```
//!
//! - `as "key"` is for a key that is not the field's name.
//! - `in "unit"` is for a unit that the name does not end with: `width_px` is in pixels without it.
//! - Without a default a number, text, colour or choice must be given; an `Option` is none, and a section is as it is
//!   when none of its keys are given.
//! - The range is a [`Range`]; without one any value of the type holds.
//!
//! After the name of a struct, `listed` names a rule for lists of such sections and `whole` one that compares several
//! parameters. Fields in `beside` are no parameters: they are filled in by whoever loads a style.

mod definition;
mod document;
mod range;
mod setting;
mod text;

use serde::de::DeserializeOwned;

pub use definition::{Choice, Definition, Parameter, ValueKind, parameters_of};
pub use document::document;
pub use range::Range;
pub use setting::{Setting, absent, first};
pub use text::{Tree, find, set, text};

use crate::file::toml_text::{self, TomlError};

/// Makes a section of a style file from the definitions of its parameters: see the head of this file.
macro_rules! parameters {
    (
        $(#[doc = $about:literal])+
        $(#[derive($($derived:ident),+)])?
        pub struct $name:ident $(, listed $listed:path)? $(, whole $whole:path)? {
            $(
                $(#[doc = $help:literal])+
                $field:ident $(as $key:literal)? $(in $unit:literal)? : $type:ty $(= $default:expr)? $(=> $range:expr)?;
            )+
        }
        $(beside {
            $(
                $(#[doc = $beside_help:literal])+
                $beside:ident: $beside_type:ty;
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
                $(#[doc = $beside_help])+
                pub $beside: $beside_type,
            )+)?
        }

        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                /// What the text has of it.
                #[derive(serde::Deserialize)]
                #[serde(deny_unknown_fields)]
                struct Given {
                    $(
                        $(#[serde(rename = $key)])?
                        $field: Option<$type>,
                    )+
                }
                let given = Given::deserialize(deserializer)?;
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
                    $($($beside: Default::default(),)+)?
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
                ),+])
            }

            fn left_out() -> Option<Self> {
                Some(Self {
                    $($field: $crate::style::parameters::absent::<$type, _>([$($default)?])?,)+
                    $($($beside: Default::default(),)+)?
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

/// Makes a parameter's type from the names that it may have: variants in lower case, each with its help.
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
            /// The name, as a style file has it.
            $visibility fn name(self) -> String {
                match self {
                    $(Self::$variant => stringify!($variant).to_lowercase(),)+
                }
            }
        }
    };
}
pub(crate) use choices;

/// Reads a style or a recipe from its text and checks every parameter; `name` stands for the file in errors.
///
/// # Errors
/// A text that is no TOML; a key that is unknown or missing; a value of another kind, or out of its range.
pub fn read<T: Setting + DeserializeOwned>(name: &str, text: &str) -> Result<T, TomlError> {
    let read: T = toml_text::read(name, text)?;
    read.check("", &Range::Any).map_err(|wrong| wrong.in_text(name, text))?;
    Ok(read)
}
