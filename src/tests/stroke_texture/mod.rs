//! Tests of stroke textures: they have no seam, are the same on every machine, and take as much ink as pressure
//! requests on all levels; and the shader's rule equals its CPU twin.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod drawn;
mod ink;
mod of_picture;
mod recipes;
mod shader;
mod tile;

use std::path::Path;

use hachure::style::texture::{Recipe, names};

/// A recipe that never changes, so that the bits of its texture are known.
const RECIPE: &str = r#"
description = "for tests"
[tile]
along_px = 128
across_px = 32
seed = 7
[touch]
nominal_width_px = 8.0
spread = 0.5
softness = 0.1
response = 1.0
fill = 1.0
border_px = 2.0
border_part = 0.5
border_pressure = 0.2
[pigment]
density = 0.8
variation = 0.2
along_px = 20.5
across_px = 2.0
[[marks]]
along_px = 12.3
across_px = 1.0
weight = 1.0
wander_px = 2.0
[[marks]]
along_px = 2.0
across_px = 2.5
weight = 0.5
"#;

fn recipe(name: &str) -> Recipe {
    Recipe::load(name, Path::new("")).unwrap()
}

fn recipes() -> Vec<(&'static str, Recipe)> {
    names().into_iter().map(|name| (name, recipe(name))).collect()
}
