//! Built-in scenes and camera paths: those of `terrain/`, with the models that they name, compiled into the program so
//! that an installed program has them. A file of the same name takes precedence.

use std::path::Path;

use super::scene_file::SceneError;
use super::{Scene, World};
use crate::mesh::{Mesh, MeshError, obj};
use crate::source::Progress;
use crate::source::continent::SPACING_M;

/// A built-in scene.
#[derive(Debug, PartialEq)]
pub(crate) struct EmbeddedScene {
    /// Its name, as given for WORLD on the command line.
    pub name: &'static str,
    text: &'static str,
    /// Its models, as (file name, OBJ text).
    models: &'static [(&'static str, &'static str)],
}

/// All built-in scenes, sorted by name.
pub(crate) static SCENES: [EmbeddedScene; 4] = [
    EmbeddedScene { name: "continent", text: include_str!("../../terrain/continent.toml"), models: &[] },
    EmbeddedScene { name: "continent_small", text: include_str!("../../terrain/continent_small.toml"), models: &[] },
    EmbeddedScene { name: "forest", text: include_str!("../../terrain/forest.toml"), models: &[] },
    EmbeddedScene {
        name: "hut",
        text: include_str!("../../terrain/hut.toml"),
        models: &[("hut.obj", include_str!("../../terrain/hut.obj"))],
    },
];

/// The built-in camera paths, sorted by name.
pub(crate) const PATHS: [(&str, &str); 4] = [
    ("ascent", include_str!("../../terrain/paths/ascent.csv")),
    ("teleport", include_str!("../../terrain/paths/teleport.csv")),
    ("tour", include_str!("../../terrain/paths/tour.csv")),
    ("valley", include_str!("../../terrain/paths/valley.csv")),
];

/// Returns the scene that WORLD names, unless a file of that name exists.
pub(crate) fn scene(world: &str) -> Option<&'static EmbeddedScene> {
    let found = SCENES.iter().find(|scene| scene.name == world)?;
    is_free(world.as_ref()).then_some(found)
}

/// Returns the text of the camera path of that name, unless a file of that name exists.
pub(crate) fn path(name: &Path) -> Option<&'static str> {
    let (_, text) = PATHS.iter().find(|(known, _)| Path::new(known) == name)?;
    is_free(name).then_some(text)
}

/// The worlds for which a built-in path is made.
pub(crate) struct PathWorld {
    /// The worlds in words, for messages.
    pub words: &'static str,
    is_continent: bool,
}

impl PathWorld {
    /// Returns whether the path is made for a world.
    pub(crate) fn is(&self, world: &World) -> bool {
        match world {
            World::Procedural { seed: 1 } => !self.is_continent,
            World::Continent { seed: 1, spacing_m, .. } => self.is_continent && *spacing_m == SPACING_M,
            _ => false,
        }
    }
}

/// Returns for which world a built-in path is made; `None` if a file has its name, or if there is none of this name.
pub(crate) fn path_world(name: &Path) -> Option<PathWorld> {
    path(name)?;
    let is_continent = ["teleport", "valley"].iter().any(|known| Path::new(known) == name);
    let words = match is_continent {
        true => "the built-in scene continent",
        false => "the built-in world and its scenes forest and hut",
    };
    Some(PathWorld { words, is_continent })
}

fn is_free(name: &Path) -> bool {
    // If this cannot be checked, assume that the file exists.
    !name.try_exists().unwrap_or(true)
}

/// Returns the names of all built-in scenes, for messages.
pub(crate) fn scene_names() -> String {
    SCENES.iter().map(|scene| scene.name).collect::<Vec<_>>().join(", ")
}

/// Returns the names of all built-in camera paths, for messages.
pub(crate) fn path_names() -> String {
    PATHS.map(|(name, _)| name).join(", ")
}

impl EmbeddedScene {
    /// Parses the scene.
    ///
    /// # Errors
    /// None in practice: a test parses every built-in scene.
    pub(crate) fn read(&'static self) -> Result<Scene, SceneError> {
        let scene = Scene::parse(Path::new(self.name), self.text)?;
        Ok(Scene { file: None, embedded: Some(self), ..scene })
    }

    fn model(&self, file: &Path) -> Option<&'static str> {
        self.models.iter().find(|(name, _)| Path::new(name) == file).map(|(_, text)| *text)
    }
}

impl Scene {
    /// Reads a model of the scene: from its file, or from the program if the scene is built in.
    ///
    /// # Errors
    /// [`MeshError::Read`].
    pub(crate) fn read_mesh_with(&self, file: &Path, progress: &dyn Progress) -> Result<Mesh, MeshError> {
        match self.embedded.and_then(|scene| scene.model(file)) {
            Some(text) => obj::parse(file.display().to_string(), text.as_bytes())
                .map_err(|cause| MeshError::Read { path: file.to_owned(), cause }),
            None => obj::read_with(file, progress, &mut |warning| tracing::warn!("{warning}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::path::CameraPath;

    fn names(folder: &str, ending: &str) -> Vec<String> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        let paths = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let mut names: Vec<String> = paths
            .filter(|path| path.extension().is_some_and(|found| found == ending))
            .map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn all_of_terrain_is_inside_and_whole() {
        assert_eq!(names("terrain", "toml").join(", "), scene_names());
        assert_eq!(names("terrain/paths", "csv"), PATHS.map(|(name, _)| name));
        for EmbeddedScene { name, .. } in &SCENES {
            let scene = scene(name).unwrap().read().unwrap();
            for mesh in &scene.meshes {
                // The working directory of tests has no such file: it can only come from the program.
                assert!(!mesh.file.exists(), "{}", mesh.file.display());
                assert!(!scene.read_mesh_with(&mesh.file, &crate::source::Silent).unwrap().triangles.is_empty());
            }
        }
        for (name, text) in PATHS {
            assert_eq!(path(Path::new(name)), Some(text));
            CameraPath::parse_on_ground(Path::new(name), text.as_bytes(), |_, _| 0.0).unwrap();
        }
        assert!(scene("hut.toml").is_none() && scene("src").is_none() && path(Path::new("hut")).is_none());
    }
}
