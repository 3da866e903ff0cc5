//! Types of parameters.

use std::path::PathBuf;

use toml_edit::{Array, ArrayOfTables, Item, value};

use super::{Range, ValueKind};
use crate::file::toml_text::Wrong;
use crate::style::Color;

/// The type of a parameter: a value, a list of values, or a section with parameters of its own.
pub(crate) trait Setting: Sized {
    /// Returns the kind of value.
    fn kind() -> ValueKind;

    /// Returns the value for a key that neither the file nor the definition gives; `None` if the key is required.
    fn default_value() -> Option<Self> {
        None
    }

    /// Checks that the value is in its range. `key` is the full key, in the form of [`Wrong`].
    ///
    /// # Errors
    /// The key and what is wrong with its value.
    fn check(&self, _key: &str, _range: &Range) -> Result<(), Wrong> {
        Ok(())
    }

    /// Checks a list as a whole, in addition to [`Setting::check`] on each entry.
    ///
    /// # Errors
    /// The errors of [`Setting::check`].
    fn check_list(_list: &[Self], _key: &str) -> Result<(), Wrong> {
        Ok(())
    }

    /// Multiplies lengths on the picture, which are those with the unit `px`, by `factor`, and clamps them to `range`.
    fn scale_lengths(&mut self, _factor: f32, _unit: Option<&str>, _range: &Range) {}

    /// Returns the value as TOML; `None` for an absent optional value.
    fn item(&self) -> Option<Item>;
}

/// Returns the value of a parameter that the file does not give: its default, if it has one.
pub(crate) fn absent<T: Setting, const N: usize>(default: [T; N]) -> Option<T> {
    default.into_iter().next().or_else(T::default_value)
}

/// Returns the first entry. The macros pass an optional given value followed by a fallback.
pub(crate) fn first<T: Copy, const N: usize>(all: &[T; N]) -> T {
    const { assert!(N > 0, "the array must have at least one entry") };
    all[0]
}

/// Returns the shortest decimal that reads back as the same 32-bit number: 0.1, not 0.10000000149011612.
pub(crate) fn shortest(number: f32) -> f64 {
    let exact = f64::from(number);
    let short = number.to_string().parse().unwrap_or(exact);
    if (short as f32).to_bits() == number.to_bits() { short } else { exact }
}

fn need(holds: bool, key: &str, words: impl FnOnce() -> String) -> Result<(), Wrong> {
    if holds { Ok(()) } else { Err(Wrong::new(key, words())) }
}

impl Setting for f32 {
    fn kind() -> ValueKind {
        ValueKind::Number
    }

    fn check(&self, key: &str, range: &Range) -> Result<(), Wrong> {
        match *range {
            Range::Within(low, high) => {
                need((low..=high).contains(self), key, || format!(" is {self}, not between {low} and {high}"))
            }
            Range::AtLeast(low) => {
                need(*self >= low && self.is_finite(), key, || format!(" is {self}, not {low} or more"))
            }
            Range::Above(low) => need(*self > low && self.is_finite(), key, || format!(" is {self}, not above {low}")),
            _ => Ok(()),
        }
    }

    fn scale_lengths(&mut self, factor: f32, unit: Option<&str>, range: &Range) {
        if unit == Some("px") {
            let [low, high] = range.ends();
            *self = (*self * factor).clamp(low.unwrap_or(f32::MIN), high.unwrap_or(f32::MAX));
        }
    }

    fn item(&self) -> Option<Item> {
        Some(value(shortest(*self)))
    }
}

impl Setting for u32 {
    fn kind() -> ValueKind {
        ValueKind::Whole
    }

    fn check(&self, key: &str, range: &Range) -> Result<(), Wrong> {
        match *range {
            Range::Within(low, high) => {
                let holds = (f64::from(low)..=f64::from(high)).contains(&f64::from(*self));
                need(holds, key, || format!(" is {self}, not between {low} and {high}"))
            }
            Range::PowerOfTwo(low, high) => {
                let holds = self.is_power_of_two() && (low..=high).contains(self);
                need(holds, key, || format!(" is {self}, not a power of two from {low} to {high}"))
            }
            Range::ZeroOr(low, high) => {
                let holds = *self == 0 || (low..=high).contains(self);
                need(holds, key, || format!(" is {self}, neither 0 nor between {low} and {high}"))
            }
            _ => Ok(()),
        }
    }

    fn item(&self) -> Option<Item> {
        Some(value(i64::from(*self)))
    }
}

impl Setting for [f32; 2] {
    fn kind() -> ValueKind {
        ValueKind::Pair
    }

    fn check(&self, key: &str, range: &Range) -> Result<(), Wrong> {
        let [from, to] = self;
        match *range {
            Range::Rising(low) => {
                let holds = *from >= low && to > from && to.is_finite();
                need(holds, key, || format!(" is {self:?}; it must be two increasing numbers, {low} or more"))
            }
            Range::Span(low, high) => {
                to.check(key, &Range::Within(low, high))?;
                from.check(key, &Range::Within(low, *to))
            }
            _ => Ok(()),
        }
    }

    fn item(&self) -> Option<Item> {
        Some(value(self.map(shortest).into_iter().collect::<Array>()))
    }
}

impl Setting for bool {
    fn kind() -> ValueKind {
        ValueKind::Flag
    }

    fn item(&self) -> Option<Item> {
        Some(value(*self))
    }
}

impl Setting for String {
    fn kind() -> ValueKind {
        ValueKind::Text
    }

    fn item(&self) -> Option<Item> {
        Some(value(self.as_str()))
    }
}

impl Setting for PathBuf {
    fn kind() -> ValueKind {
        ValueKind::Text
    }

    fn item(&self) -> Option<Item> {
        Some(value(self.to_string_lossy().as_ref()))
    }
}

impl Setting for Color {
    fn kind() -> ValueKind {
        ValueKind::Color
    }

    fn item(&self) -> Option<Item> {
        Some(value(self.to_string()))
    }
}

impl<T: Setting> Setting for Option<T> {
    fn kind() -> ValueKind {
        T::kind()
    }

    fn default_value() -> Option<Self> {
        Some(None)
    }

    fn check(&self, key: &str, range: &Range) -> Result<(), Wrong> {
        self.as_ref().map_or(Ok(()), |value| value.check(key, range))
    }

    fn scale_lengths(&mut self, factor: f32, unit: Option<&str>, range: &Range) {
        self.iter_mut().for_each(|value| value.scale_lengths(factor, unit, range));
    }

    fn item(&self) -> Option<Item> {
        self.as_ref().and_then(T::item)
    }
}

impl<T: Setting> Setting for Vec<T> {
    fn kind() -> ValueKind {
        ValueKind::List(Box::new(T::kind()))
    }

    fn check(&self, key: &str, range: &Range) -> Result<(), Wrong> {
        if let Range::Entries(low, high) = *range {
            let count = self.len();
            need((low..=high).contains(&count), key, || format!(" has {count} entries, not {low} to {high}"))?;
        }
        T::check_list(self, key)?;
        self.iter().enumerate().try_for_each(|(number, entry)| entry.check(&format!("{key}[{number}]"), &Range::Any))
    }

    fn scale_lengths(&mut self, factor: f32, unit: Option<&str>, _: &Range) {
        self.iter_mut().for_each(|entry| entry.scale_lengths(factor, unit, &Range::Any));
    }

    fn item(&self) -> Option<Item> {
        let items = self.iter().filter_map(T::item);
        if matches!(T::kind(), ValueKind::Section(_)) {
            let tables = items.filter_map(|item| item.into_table().ok());
            return Some(Item::ArrayOfTables(tables.collect::<ArrayOfTables>()));
        }
        Some(value(items.filter_map(|item| item.into_value().ok()).collect::<Array>()))
    }
}
