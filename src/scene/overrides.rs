//! Values that replace those of a scene: `--sea-level`, `--trees` and `--seed`, and the same controls of a window.

use std::fmt::{Display, Formatter};
use std::str::FromStr;

use super::{Forest, MeshPositions, Scene, World, ranges};

/// Values that replace those of a scene; `None` keeps the scene's.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Overrides {
    pub sea_level: Option<SeaLevel>,
    pub trees: Option<Trees>,
    /// The seed of the land.
    pub seed: Option<u32>,
}

impl Overrides {
    /// Returns the scene with these values.
    ///
    /// # Errors
    /// [`SeedError`], if the land of the scene can have no other seed.
    pub(crate) fn apply_to(self, scene: Scene) -> Result<Scene, SeedError> {
        let mut scene = match self.seed {
            Some(seed) => scene.with_seed(seed)?,
            None => scene,
        };
        if let Some(sea) = self.sea_level {
            scene.sea_level_m = sea.level_m();
        }
        if let Some(trees) = self.trees {
            scene.forest = trees.apply_to(scene.forest.take());
        }
        Ok(scene)
    }
}

/// The reason why the land of a scene cannot have another seed, as the end of a sentence about the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum SeedError {
    /// The land comes from files.
    #[error("its land has no seed; only the built-in world, the continent and scenes of them are grown from one")]
    NotGrown,
    /// Something has its place on the land of one seed.
    #[error("its {what} are made for the land of seed {own}, and would not fit another one")]
    Placed {
        /// The kind of thing that has a place, in the plural.
        what: &'static str,
        /// The seed of the scene.
        own: u32,
    },
}

impl World {
    /// Returns the seed from which the land is grown; `None` if it comes from files or from memory, or is flat.
    pub(crate) fn seed(&self) -> Option<u32> {
        match self {
            Self::Procedural { seed } | Self::Continent { seed, .. } => Some(*seed),
            Self::File(_) | Self::Files(_) | Self::Url(_) | Self::Model(_) | Self::Memory => None,
        }
    }
}

impl Scene {
    /// Checks that the land can have another seed: nothing in the scene may be placed on the land of the scene's own
    /// seed. Models and trees that rules place get new places.
    ///
    /// # Errors
    /// [`SeedError`].
    pub(crate) fn check_other_seed(&self) -> Result<(), SeedError> {
        let own = self.world.seed().ok_or(SeedError::NotGrown)?;
        let is_placed = |mesh: &super::MeshPlacement| !matches!(mesh.positions, MeshPositions::Scattered(_));
        let has_cover = self.forest.as_ref().is_some_and(|forest| forest.cover.files().next().is_some());
        let placed = [
            (self.meshes.iter().any(is_placed), "models"),
            (has_cover, "rasters of the forest"),
            (self.water.files().next().is_some(), "water files"),
        ];
        placed
            .into_iter()
            .find(|(is_there, _)| *is_there)
            .map_or(Ok(()), |(_, what)| Err(SeedError::Placed { what, own }))
    }

    /// Returns the scene with another seed of its land. The start of the camera and the focus are left out, since they
    /// are made for the land of the scene's own seed.
    ///
    /// # Errors
    /// The errors of [`Scene::check_other_seed`].
    fn with_seed(mut self, other: u32) -> Result<Self, SeedError> {
        if self.world.seed() == Some(other) {
            return Ok(self);
        }
        self.check_other_seed()?;
        if let World::Procedural { seed } | World::Continent { seed, .. } = &mut self.world {
            *seed = other;
        }
        (self.start, self.focus) = (None, None);
        Ok(self)
    }
}

/// The sea that replaces a scene's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SeaLevel {
    /// No land is sea.
    None,
    /// Land at or below this true height, in metres, is sea.
    At(f64),
}

impl SeaLevel {
    /// Returns the value for a level in metres; `None` means that no land is sea.
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
            text => ranges::SEA_LEVEL_M.parse(text).map(Self::At).map_err(|rule| format!("{rule}, in metres, or none")),
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
    pub(crate) fn apply_to(self, own: Option<Forest>) -> Option<Forest> {
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
                .map_err(|_: String| "it must be on, off, or a seed (a whole number from 0 to 4294967295)".to_owned()),
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
        assert_eq!(Trees::On.apply_to(None), forest("[forest]"));
        assert_eq!(Trees::Seed(7).apply_to(None), forest("[forest]\nseed = 7"));
        assert_eq!(Trees::On.apply_to(own.clone()), own);
        assert_eq!(Trees::Seed(7).apply_to(own.clone()), forest("[forest]\ntrees_per_ha = 12\nseed = 7"));
        assert_eq!(Trees::Off.apply_to(own.clone()), None);
        // Planted: other seeds and densities are other forests.
        assert_ne!(Trees::Seed(8).apply_to(None), forest("[forest]\nseed = 7"));
        assert_ne!(Trees::On.apply_to(None), forest("[forest]\ntrees_per_ha = 301"));
    }

    #[test]
    fn another_seed_is_the_key_of_the_scene_file() {
        let scene = |text: &str| Scene::parse(Path::new("scene.toml"), text).unwrap();
        let seeded = |text: &str, seed| Overrides { seed: Some(seed), ..Overrides::default() }.apply_to(scene(text));
        let forest = "[forest]\nseed = 3\n[water]\nsea_level_m = 5\n[sun]\nazimuth_deg = 10";
        for world in ["procedural = { seed = 1 }", "continent = { seed = 1, size_samples = 2048 }"] {
            let text = format!("[world]\n{world}\n{forest}");
            let other = scene(&text.replacen("seed = 1", "seed = 2", 1));
            assert_eq!(seeded(&text, 2), Ok(other.clone()));
            // Planted: without the option, the scene is another one.
            assert_ne!(scene(&text), other);
            // A view of the land of seed 1 is not one of another land.
            let places =
                format!("{text}\n[camera]\nstart = \"0,0,+300,0,-10,50\"\n[focus]\nplace = [0, 0]\nradius_m = 9");
            assert_eq!(seeded(&places, 2), Ok(other));
            assert_eq!(seeded(&places, 1), Ok(scene(&places)), "its own seed changes nothing");
        }
    }

    #[test]
    fn what_has_its_place_refuses_another_seed() {
        let refused = |text: &str| {
            let scene = Scene::parse(Path::new("scene.toml"), text).unwrap();
            Overrides { seed: Some(2), ..Overrides::default() }.apply_to(scene).err().map(|error| error.to_string())
        };
        let grown = "[world]\nprocedural = { seed = 7 }\n";
        assert!(refused("[world]\ndem = \"a.tif\"").unwrap().contains("has no seed"));
        assert!(refused("[world]\ndem = [\"a.tif\", \"b.tif\"]").unwrap().contains("has no seed"));
        let hut = "[[meshes]]\nfile = \"hut.obj\"\n";
        for (text, what) in [
            (format!("{hut}at = [1, 2, \"+0\"]"), "models"),
            (format!("{hut}instances = \"list.csv\""), "models"),
            ("[forest]\nmask = \"a.tif\"".to_owned(), "rasters of the forest"),
            ("[water]\npolygons = \"a.geojson\"".to_owned(), "water files"),
        ] {
            let error = refused(&format!("{grown}{text}")).unwrap();
            assert!(error.contains(&format!("its {what} are made for the land of seed 7")), "{error}");
        }
        assert_eq!(refused(&format!("{grown}[forest]")), None);
        assert_eq!(
            refused(&format!("{grown}{hut}scatter = {{ count = 3, within = [0, 0, 90, 90] }}")),
            None,
            "a rule finds new places"
        );
    }

    #[cfg(feature = "window")]
    #[test]
    fn what_replaces_a_forest_leads_to_it() {
        let own = Some(Forest { seed: 9, ..Forest::default() });
        for own in [None, own] {
            for seed in [None, Some(Forest::DEFAULT_SEED), Some(9), Some(3)] {
                let replaced = match Trees::between(own.as_ref(), seed) {
                    Some(trees) => trees.apply_to(own.clone()),
                    None => own.clone(),
                };
                assert_eq!(replaced.map(|forest| forest.seed), seed, "{own:?}");
            }
            assert_eq!(Trees::between(own.as_ref(), own.as_ref().map(|own| own.seed)), None);
        }
    }
}
