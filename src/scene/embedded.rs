//! What lies inside the program: the scenes and camera paths of `terrain/`, with the models that they name. An
//! installed program has them without its sources. A file of the same name comes first.

use std::path::Path;

use super::Scene;
use super::scene_file::SceneError;
use crate::mesh::{Mesh, MeshError, obj};
use crate::source::{Progress, Silent};

/// A scene inside the program.
#[derive(Debug, PartialEq)]
pub struct EmbeddedScene {
    /// As WORLD names it.
    pub name: &'static str,
    text: &'static str,
    /// The models that lie beside it, by their names there.
    models: &'static [(&'static str, &'static str)],
}

/// All of them, by name.
pub static SCENES: [EmbeddedScene; 4] = [
    EmbeddedScene { name: "continent", text: include_str!("../../terrain/continent.toml"), models: &[] },
    EmbeddedScene { name: "continent_small", text: include_str!("../../terrain/continent_small.toml"), models: &[] },
    EmbeddedScene { name: "forest", text: include_str!("../../terrain/forest.toml"), models: &[] },
    EmbeddedScene {
        name: "hut",
        text: include_str!("../../terrain/hut.toml"),
        models: &[("hut.obj", include_str!("../../terrain/hut.obj"))],
    },
];

/// The camera paths inside the program, by name.
pub const PATHS: [(&str, &str); 4] = [
    ("ascent", include_str!("../../terrain/paths/ascent.csv")),
    ("teleport", include_str!("../../terrain/paths/teleport.csv")),
    ("tour", include_str!("../../terrain/paths/tour.csv")),
    ("valley", include_str!("../../terrain/paths/valley.csv")),
];

/// The scene that a WORLD names, where there is no file of that name.
pub fn scene(world: &str) -> Option<&'static EmbeddedScene> {
    let found = SCENES.iter().find(|scene| scene.name == world)?;
    is_free(world.as_ref()).then_some(found)
}

/// The camera path that is meant, where there is no file of that name.
pub fn path(name: &Path) -> Option<&'static str> {
    let (_, text) = PATHS.iter().find(|(known, _)| Path::new(known) == name)?;
    is_free(name).then_some(text)
}

fn is_free(name: &Path) -> bool {
    // What cannot be looked at may be there.
    !name.try_exists().unwrap_or(true)
}

/// For messages: what a name without a file could have been.
pub fn scene_names() -> String {
    SCENES.iter().map(|scene| scene.name).collect::<Vec<_>>().join(", ")
}

impl EmbeddedScene {
    /// What it says.
    ///
    /// # Errors
    /// None that a test would let through.
    pub fn read(&'static self) -> Result<Scene, SceneError> {
        let scene = Scene::parse(Path::new(self.name), self.text)?;
        Ok(Scene { file: None, embedded: Some(self), ..scene })
    }

    fn model(&self, file: &Path) -> Option<&'static str> {
        self.models.iter().find(|(name, _)| Path::new(name) == file).map(|(_, text)| *text)
    }
}

impl Scene {
    /// A model of the scene: from its file, or from the program where the scene is from there.
    ///
    /// # Errors
    /// [`MeshError::Read`].
    pub fn read_mesh(&self, file: &Path) -> Result<Mesh, MeshError> {
        self.read_mesh_with(file, &Silent)
    }

    /// As [`Scene::read_mesh`], with progress for long files.
    ///
    /// # Errors
    /// [`MeshError::Read`].
    pub fn read_mesh_with(&self, file: &Path, progress: &dyn Progress) -> Result<Mesh, MeshError> {
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
                // Beside the tests there is no such file: it can only come from inside.
                assert!(!mesh.file.exists(), "{}", mesh.file.display());
                assert!(!scene.read_mesh(&mesh.file).unwrap().triangles.is_empty());
            }
        }
        for (name, text) in PATHS {
            assert_eq!(path(Path::new(name)), Some(text));
            CameraPath::parse_on_ground(Path::new(name), text.as_bytes(), |_, _| 0.0).unwrap();
        }
        assert!(scene("hut.toml").is_none() && scene("src").is_none() && path(Path::new("hut")).is_none());
    }
}
