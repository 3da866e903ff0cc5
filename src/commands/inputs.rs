//! The input files of `render` and `bench`, which no output may overwrite.

use std::path::Path;

use crate::file::guard::Inputs;
use crate::scene::Scene;
use crate::style::Style;
use crate::world;

/// Collects the input files: the world and its scene, the styles with their mark recipes and pictures, and the camera
/// path.
pub(super) fn of(world: Option<&str>, scene: &Scene, styles: &[Style], camera_path: Option<&Path>) -> Inputs {
    let mut inputs = world::inputs_of(world, scene);
    styles.iter().flat_map(|style| &style.files).for_each(|file| inputs.add(file));
    camera_path.into_iter().for_each(|path| inputs.add(path));
    inputs
}
