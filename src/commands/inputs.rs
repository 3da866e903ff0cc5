//! What `render` and `bench` read, before they write anything.

use std::path::Path;

use crate::file::guard::Inputs;
use crate::scene::Scene;
use crate::style::Style;
use crate::world;

/// The world as it is named with its scene, the styles with their recipes and pictures, and the camera path.
pub(super) fn of(world: Option<&str>, scene: &Scene, styles: &[Style], camera_path: Option<&Path>) -> Inputs {
    let mut inputs = world::inputs_of(world, scene);
    styles.iter().flat_map(|style| &style.files).for_each(|file| inputs.add(file));
    camera_path.into_iter().for_each(|path| inputs.add(path));
    inputs
}
