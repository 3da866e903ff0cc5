//! Arguments of all commands that draw: the world, and options that replace parts of its scene.

use std::path::Path;

use clap::Args;

use super::arguments;
use super::height_args::HeightArgs;
use super::land_args::LandArgs;
use super::layer_args::LayerArgs;
use super::light_args::LightArgs;
use super::misuse::Misuse;
use super::water_args::WaterArgs;
use crate::file::unnamed;
use crate::scene::reach::Reach;
use crate::scene::{Forest, Scene, World, ranges};
use crate::source::OpenOptions;
use crate::world::{self, WorldError};

/// The world that is drawn.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct WorldArgs {
    /// Scene file, DEM, folder, baked pyramid, model (OBJ), URL, or built-in scene (continent, continent_small, forest,
    /// hut) [default: the built-in world, procedural mountains]
    #[arg(id = "world", value_name = "WORLD")]
    pub name: Option<String>,
    /// How to read height files.
    #[command(flatten)]
    pub heights: HeightArgs,
    /// How light falls.
    #[command(flatten)]
    pub light: LightArgs,
    /// Where additional water is.
    #[command(flatten)]
    pub water: WaterArgs,
    /// Which features are drawn on the land.
    #[command(flatten)]
    pub layers: LayerArgs,
    /// The sea, the trees and the seed of the land.
    #[command(flatten)]
    pub land: LandArgs,
    /// Factor on all heights, about sea level (0 m), so that gentle land shows its form; contour lines of height keep
    /// their true heights [default: the scene's, or 1]
    #[arg(long, value_name = "FACTOR", value_parser = arguments::within(ranges::EXAGGERATION), allow_hyphen_values = true)]
    pub exaggeration: Option<f64>,
    /// Allow a scene file to name URLs and files outside its folder
    #[arg(long)]
    pub trust_scene: bool,
}

impl WorldArgs {
    /// Returns the name of the world; `None` is the built-in world.
    #[must_use]
    pub(crate) fn name(&self) -> Option<&str> {
        self.name.as_deref()
    }

    /// Checks that the world exists, if it is a file (see [`arguments::check_world`]), and the files of `--water` and
    /// `--layer`.
    ///
    /// # Errors
    /// The errors of [`arguments::check_world`], [`WaterArgs::check`] and [`LayerArgs::check`].
    pub(crate) fn check(&self) -> anyhow::Result<()> {
        self.light.check()?;
        arguments::check_world(self.name())?;
        self.water.check()?;
        self.layers.check()
    }

    /// Checks the options of heights in memory, and returns their scene.
    ///
    /// # Errors
    /// An option that only heights from files have, and the errors of [`LightArgs::check`] and [`WaterArgs::check`].
    pub(crate) fn scene_in_memory(&self) -> anyhow::Result<Scene> {
        self.light.check()?;
        self.water.check()?;
        self.layers.check()?;
        let scene = self.applied_to(Scene::of_world(World::Memory))?;
        // Holes of an array may be filled, as those of a file.
        match scene.heights == (OpenOptions { voids: scene.heights.voids, ..OpenOptions::default() }) {
            true => Ok(scene),
            false => {
                let options = "--nodata, --height-unit and the other options of height files";
                Err(Misuse(format!("{options}: do not apply to heights in memory; change the array")).into())
            }
        }
    }

    /// Reads the scene of the world; the options replace its values.
    ///
    /// # Errors
    /// Fails if the scene file cannot be read or is invalid.
    pub(crate) fn scene(&self) -> anyhow::Result<Scene> {
        self.scene_and_forest().map(|(scene, _)| scene)
    }

    /// Reads the scene like [`WorldArgs::scene`], and returns it with the forest that it has without `--trees`.
    ///
    /// # Errors
    /// The errors of [`WorldArgs::scene`].
    pub(crate) fn scene_and_forest(&self) -> anyhow::Result<(Scene, Option<Forest>)> {
        let scene = world::scene_of(self.name(), Reach::trusting(self.trust_scene))?;
        let own_forest = scene.forest.clone();
        Ok((self.applied_to(scene)?, own_forest))
    }

    /// Returns a scene with the values of the options.
    fn applied_to(&self, scene: Scene) -> anyhow::Result<Scene> {
        // First, because another seed removes the scene's own focus, but not that of the command line.
        let scene = self.land.apply_to(self.name(), scene)?;
        let mut scene = self.layers.apply_to(self.water.apply_to(self.light.apply_to(self.heights.apply_to(scene))));
        scene.vertical_exaggeration = self.exaggeration.unwrap_or(scene.vertical_exaggeration);
        Ok(scene)
    }

    /// Converts the error of a world that cannot be opened: it may be a picture that hachure drew.
    pub(crate) fn or_drawing(&self, error: WorldError) -> anyhow::Error {
        let picture = self.name().map(Path::new).filter(|name| unnamed::is_drawing(name));
        picture.map_or_else(|| error.into(), |picture| anyhow::anyhow!(unnamed::is_no_world(picture)))
    }
}
