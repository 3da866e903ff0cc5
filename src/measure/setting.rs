//! The changes that a point of a front, or a setting of a sweep, makes; and the fronts that are built in.
//!
//! - A *setting* is a set of changes to a style and to the options it is drawn with.
//! - A *variant* is a style with a setting, as a benchmark draws it; a *run* has the measurements of one variant.
//! - A *point* is a setting with its measured cost and errors, and a *front* has the points of a style that are worth
//!   drawing with.
//! - A *level* is the name of a point: draft, balanced or exact.
//! - A *step* is the number of the setting that a governor has chosen, from the cheapest to the most expensive.

use super::trade::SCALE;
use crate::file::message::did_you_mean;
use crate::frame::Antialias;
use crate::scene::ranges::{self, NumberRange};
use crate::style::set::SetValue;

/// Allowed render scales.
const SCALES: NumberRange = NumberRange::Within(0.25, 2.0);
/// Allowed details of trees.
const TREE_DETAILS: NumberRange = NumberRange::Within(0.01, 100.0);
/// Allowed errors of heights in tiles, in metres.
const TILE_ERRORS_M: NumberRange = NumberRange::Within(0.0, 100.0);

/// The measured fronts of presets, by name.
pub(crate) const FRONTS: &[(&str, &str)] = &[
    ("crosshatch", include_str!("../../benches/fronts/crosshatch.toml")),
    ("ink", include_str!("../../benches/fronts/ink.toml")),
    ("lsa", include_str!("../../benches/fronts/lsa.toml")),
    ("strokes", include_str!("../../benches/fronts/strokes.toml")),
];

/// The key of the rounding of heights, which is measured and never drawn with: it saves a frame nothing.
pub(crate) const TILE_ERROR: &str = "tile-error";
/// The keys of settings besides the parameters of a style.
pub(crate) const OWN_KEYS: [&str; 5] = ["lod-error", "antialias", SCALE, "tree-detail", TILE_ERROR];

/// The changes that a point of a front, or a setting of a sweep, makes.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Setting {
    pub lod_error_px: Option<f64>,
    /// Factor on both sides of the picture.
    pub scale: Option<f64>,
    pub antialias: Option<Antialias>,
    /// Factor on the sizes in pixels down to which trees are drawn in detail ([`crate::world::Surfaces::tree_detail`]).
    pub tree_detail: Option<f64>,
    /// Largest error of a height that rounding causes, in metres.
    pub tile_error_m: Option<f64>,
    /// Parameters of the style.
    pub values: Vec<SetValue>,
}

impl Setting {
    /// Parses the values of a setting, by their keys.
    ///
    /// # Errors
    /// The key and the value, and the rule that the value breaks. Parameters of the style are not checked.
    pub(crate) fn of<'a>(pairs: impl IntoIterator<Item = (&'a str, &'a str)>) -> Result<Self, String> {
        let mut setting = Self::default();
        for (key, text) in pairs {
            let wrong = |rule: String| format!("{key}={text}: {rule}");
            match key {
                "lod-error" => setting.lod_error_px = Some(ranges::LOD_ERROR_PX.parse(text).map_err(wrong)?),
                "antialias" => setting.antialias = Some(text.parse().map_err(wrong)?),
                "tree-detail" => setting.tree_detail = Some(TREE_DETAILS.parse(text).map_err(wrong)?),
                TILE_ERROR => setting.tile_error_m = Some(TILE_ERRORS_M.parse(text).map_err(wrong)?),
                SCALE => setting.scale = Some(SCALES.parse(text).map_err(wrong)?),
                _ if OWN_KEYS.contains(&key.replace('_', "-").as_str()) => {
                    return Err(format!("{key}: there is no such key{}", did_you_mean(key, OWN_KEYS)));
                }
                _ => setting.values.push(SetValue { key: key.to_owned(), text: text.to_owned() }),
            }
        }
        Ok(setting)
    }

    /// Returns whether temporal strokes restart where another setting becomes this one: another value of strokes does it,
    /// and another resolution does not.
    pub(crate) fn restarts_strokes_of(&self, other: &Self) -> bool {
        let of_strokes = |setting: &Self| -> Vec<SetValue> {
            setting.values.iter().filter(|value| value.key.starts_with("strokes.")).cloned().collect()
        };
        of_strokes(self) != of_strokes(other)
    }
}
