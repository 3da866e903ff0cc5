//! Options of all commands that draw: how light falls, in place of what the scene says.

use std::str::FromStr;

use clap::Args;

use crate::scene::{Scene, Sun};

/// How light falls.
#[derive(Clone, Copy, Debug, Default, Args)]
pub struct LightArgs {
    /// Where the sun stands, in degrees clockwise from north and above the horizon [default: the scene's, or 315,40]
    #[arg(long, value_name = "AZIMUTH,ELEVATION", value_parser = Sun::from_str, allow_hyphen_values = true)]
    pub sun: Option<Sun>,
}

impl LightArgs {
    /// The scene with what the command line says of its light; where that says nothing, what the scene says stays.
    #[must_use]
    pub fn over(&self, mut scene: Scene) -> Scene {
        scene.sun = self.sun.unwrap_or(scene.sun);
        scene
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;

    #[test]
    fn the_command_line_comes_before_the_scene() {
        let scene = Scene::default();
        assert_eq!(LightArgs::default().over(scene.clone()).sun, scene.sun);
        let low = LightArgs { sun: Some("-90, 5.5".parse().unwrap()) };
        assert_eq!(low.over(scene).sun, Sun { azimuth_deg: -90.0, elevation_deg: 5.5 });
        for wrong in ["", "315", "315,", "north,40", "400,40", "315,91", "315,40,1", "nan,40"] {
            assert!(wrong.parse::<Sun>().is_err(), "{wrong}");
        }
    }
}
