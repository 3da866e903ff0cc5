//! Options of all commands that draw, for the land of a scene: its sea, its trees and its seed.

use std::str::FromStr;

use clap::Args;

use super::arguments;
use super::misuse::Misuse;
use crate::file::message::named;
use crate::scene::overrides::{Overrides, SeaLevel, Trees};
use crate::scene::{Scene, ranges};
use crate::style::Style;
use crate::world::OpenWorld;

/// The sea, the trees and the seed of the land.
#[derive(Clone, Copy, Debug, Default, PartialEq, Args)]
pub(crate) struct LandArgs {
    /// Land at or below this true height is sea, in metres, where the style draws water; `none` removes the scene's sea
    /// [default: the scene's, or none]
    #[arg(long, value_name = "METRES|none", value_parser = SeaLevel::from_str, allow_hyphen_values = true)]
    pub sea_level: Option<SeaLevel>,
    /// Trees: `on` plants the scene's forest, or a mixed forest if it has none; a number does so with this seed; `off`
    /// leaves the scene's forest out [default: the scene's, or off]
    #[arg(long, value_name = "on|off|SEED", value_parser = Trees::from_str, allow_hyphen_values = true)]
    pub trees: Option<Trees>,
    /// Seed of the land, for the built-in world, the continent and scenes of them: each seed is another land, without
    /// the scene's camera and focus [default: the scene's, or 1]
    #[arg(long, value_parser = arguments::whole_within::<u32>(ranges::SEED), allow_hyphen_values = true)]
    pub seed: Option<u32>,
}

impl LandArgs {
    /// Returns the scene of a world with this land; options that are not given keep the scene's.
    ///
    /// # Errors
    /// [`Misuse`], if the land of the world can have no other seed.
    pub(crate) fn apply_to(self, world: Option<&str>, scene: Scene) -> Result<Scene, Misuse> {
        let Self { sea_level, trees, seed } = self;
        Overrides { sea_level, trees, seed }.apply_to(scene).map_err(|error| {
            let world = world.map_or_else(|| "the built-in world".to_owned(), named);
            Misuse(format!("--seed {}: {world}: {error}", seed.unwrap_or_default()))
        })
    }
}

impl LandArgs {
    /// Warns of a sea that changes nothing in the picture, or that leaves no land.
    pub(crate) fn warn(&self, world: &OpenWorld, style: &Style) {
        let Some(SeaLevel::At(level_m)) = self.sea_level else { return };
        if style.water().is_none() {
            tracing::warn!("--sea-level {level_m}: style {} draws no water: it has no layer \"water\"", style.name);
        }
        let surfaces = &world.surfaces;
        let [low_m, high_m] = surfaces.terrain.range_m().map(|height_m| f64::from(height_m) / surfaces.exaggeration());
        if level_m < low_m || level_m >= high_m {
            let what = if level_m < low_m { "all land is above it" } else { "no land is above it" };
            tracing::warn!("--sea-level {level_m}: {what}: its heights are from {low_m:.1} to {high_m:.1} m");
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use std::path::Path;

    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        land: LandArgs,
    }

    /// Returns a scene file with this text.
    fn scene(text: &str) -> Scene {
        Scene::parse(Path::new("a.toml"), &format!("[world]\ndem = \"a.tif\"\n{text}")).unwrap()
    }

    #[test]
    fn an_option_is_the_key_of_the_scene_file() {
        let given = |words: &str, text: &str| {
            let words = ["hachure"].into_iter().chain(words.split_whitespace());
            Line::try_parse_from(words).unwrap().land.apply_to(None, scene(text)).unwrap()
        };
        for (words, before, after) in [
            ("", "[water]\nsea_level_m = 3\n[forest]", "[water]\nsea_level_m = 3\n[forest]"),
            ("--sea-level 12.5", "", "[water]\nsea_level_m = 12.5"),
            ("--sea-level -3", "[water]\nsea_level_m = 12.5", "[water]\nsea_level_m = -3"),
            ("--sea-level none", "[water]\nsea_level_m = 12.5", ""),
            ("--trees on", "", "[forest]"),
            ("--trees on", "[forest]\nseed = 4\nheight_m = 9", "[forest]\nseed = 4\nheight_m = 9"),
            ("--trees 7", "[forest]\nseed = 4\nheight_m = 9", "[forest]\nseed = 7\nheight_m = 9"),
            ("--trees off --sea-level 5", "[forest]\nseed = 4", "[water]\nsea_level_m = 5"),
        ] {
            assert_eq!(given(words, before), scene(after), "{words}");
            // Planted: without the option, the scene is another one.
            assert!(words.is_empty() || before == after || given("", before) != scene(after), "{words}");
        }
        for wrong in [
            "--sea-level",
            "--sea-level deep",
            "--sea-level 9001",
            "--trees",
            "--trees x",
            "--trees -1",
            "--seed x",
            "--seed -1",
        ] {
            assert!(Line::try_parse_from(["hachure"].into_iter().chain(wrong.split(' '))).is_err(), "{wrong}");
        }
    }
}
