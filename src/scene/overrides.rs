//! Values that replace those of a scene: `--sea-level` and `--trees`, and the same controls of a window.

use std::fmt::{Display, Formatter};
use std::str::FromStr;

use super::{Forest, ranges};

/// The sea that replaces a scene's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SeaLevel {
    /// There is no sea.
    None,
    /// Land at or below this true height, in metres, is sea.
    At(f64),
}

impl SeaLevel {
    /// Returns the value for a level; `None` is no sea.
    #[cfg(feature = "window")]
    pub(crate) fn of(level_m: Option<f64>) -> Self {
        level_m.map_or(Self::None, Self::At)
    }

    /// Returns the level in metres, if there is a sea.
    pub(crate) fn level_m(self) -> Option<f64> {
        match self {
            Self::None => None,
            Self::At(level_m) => Some(level_m),
        }
    }
}

impl Display for SeaLevel {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::None => f.write_str("none"),
            Self::At(level_m) => write!(f, "{level_m}"),
        }
    }
}

impl FromStr for SeaLevel {
    type Err = String;

    /// Parses a height in metres, or `none`.
    fn from_str(text: &str) -> Result<Self, String> {
        match text.trim() {
            "none" => Ok(Self::None),
            text => ranges::SEA_LEVEL_M
                .parse(text)
                .map(Self::At)
                .map_err(|_| "it must be none, or a number of metres between -12000 and 9000".to_owned()),
        }
    }
}

/// The forest that replaces a scene's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Trees {
    /// There are no trees.
    Off,
    /// The scene's forest, or the default one if the scene has none.
    On,
    /// The same with another seed.
    Seed(u32),
}

impl Trees {
    /// Returns the forest that replaces a scene's `own`.
    pub(crate) fn over(self, own: Option<Forest>) -> Option<Forest> {
        match self {
            Self::Off => None,
            Self::On => Some(own.unwrap_or_default()),
            Self::Seed(seed) => Some(Forest { seed, ..own.unwrap_or_default() }),
        }
    }

    /// Returns the value that replaces a scene's `own` forest by one with a seed, or by none; `None` if nothing needs to
    /// be replaced.
    #[cfg(feature = "window")]
    pub(crate) fn between(own: Option<&Forest>, seed: Option<u32>) -> Option<Self> {
        match (own, seed) {
            (None, None) => None,
            (Some(_), None) => Some(Self::Off),
            (Some(own), Some(seed)) => (own.seed != seed).then_some(Self::Seed(seed)),
            (None, Some(Forest::DEFAULT_SEED)) => Some(Self::On),
            (None, Some(seed)) => Some(Self::Seed(seed)),
        }
    }
}

impl Display for Trees {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Off => f.write_str("off"),
            Self::On => f.write_str("on"),
            Self::Seed(seed) => write!(f, "{seed}"),
        }
    }
}

impl FromStr for Trees {
    type Err = String;

    /// Parses `on`, `off`, or a seed.
    fn from_str(text: &str) -> Result<Self, String> {
        match text.trim() {
            "off" => Ok(Self::Off),
            "on" => Ok(Self::On),
            text => ranges::SEED
                .parse_whole(text)
                .map(Self::Seed)
                .map_err(|_| "it must be on, off, or a seed: a whole number from 0 to 4294967295".to_owned()),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use std::path::Path;

    use super::*;
    use crate::scene::Scene;

    #[test]
    fn texts_are_read_as_they_are_written() {
        for (text, sea) in [("none", SeaLevel::None), ("12.5", SeaLevel::At(12.5)), ("-400", SeaLevel::At(-400.0))] {
            assert_eq!((text.parse(), sea.to_string()), (Ok(sea), text.to_owned()));
        }
        for (text, trees) in [("on", Trees::On), ("off", Trees::Off), ("4294967295", Trees::Seed(u32::MAX))] {
            assert_eq!((text.parse(), trees.to_string()), (Ok(trees), text.to_owned()));
        }
        for wrong in ["", "off", "nan", "inf", "9000.5", "-12001", "1 m"] {
            let error = wrong.parse::<SeaLevel>().unwrap_err();
            assert!(error.contains("between -12000 and 9000") && error.contains("none"), "{wrong}: {error}");
        }
        for wrong in ["", "none", "-1", "1.5", "4294967296", "On"] {
            let error = wrong.parse::<Trees>().unwrap_err();
            assert!(error.contains("4294967295") && error.contains("on, off"), "{wrong}: {error}");
        }
    }

    #[test]
    fn an_empty_table_is_the_default_forest() {
        let forest = |text: &str| {
            let text = format!("[world]\nprocedural = {{ seed = 1 }}\n{text}");
            Scene::parse(Path::new("scene.toml"), &text).unwrap().forest
        };
        let own = forest("[forest]\ntrees_per_ha = 12\nseed = 9");
        assert_eq!(Trees::On.over(None), forest("[forest]"));
        assert_eq!(Trees::Seed(7).over(None), forest("[forest]\nseed = 7"));
        assert_eq!(Trees::On.over(own.clone()), own);
        assert_eq!(Trees::Seed(7).over(own.clone()), forest("[forest]\ntrees_per_ha = 12\nseed = 7"));
        assert_eq!(Trees::Off.over(own.clone()), None);
        // Planted: other seeds and densities are other forests.
        assert_ne!(Trees::Seed(8).over(None), forest("[forest]\nseed = 7"));
        assert_ne!(Trees::On.over(None), forest("[forest]\ntrees_per_ha = 301"));
    }

    #[cfg(feature = "window")]
    #[test]
    fn what_replaces_a_forest_leads_to_it() {
        let own = Some(Forest { seed: 9, ..Forest::default() });
        for own in [None, own] {
            for seed in [None, Some(Forest::DEFAULT_SEED), Some(9), Some(3)] {
                let replaced = match Trees::between(own.as_ref(), seed) {
                    Some(trees) => trees.over(own.clone()),
                    None => own.clone(),
                };
                assert_eq!(replaced.map(|forest| forest.seed), seed, "{own:?}");
            }
            assert_eq!(Trees::between(own.as_ref(), own.as_ref().map(|own| own.seed)), None);
        }
    }
}
