//! The models of a forest's species, read from their files.

use std::path::Path;
use std::sync::Arc;

use crate::file::message::shown;
use crate::forest::model::{MANY_TRIANGLES, TreeModel};
use crate::mesh::{Mesh, MeshError};
use crate::scene::Scene;
use crate::source::Progress;

/// Reads the models of a scene's forest, each file once.
///
/// # Errors
/// The first file that cannot be read, or is not a tree.
pub(super) fn read(scene: &Scene, progress: &dyn Progress) -> Result<Vec<Arc<TreeModel>>, MeshError> {
    let mut models = Vec::new();
    let mut known: Vec<(&Path, Mesh)> = Vec::new();
    for model in scene.forest.iter().flat_map(|forest| &forest.models) {
        let found = known.iter().position(|(file, _)| *file == model.file);
        let number = match found {
            Some(number) => number,
            None => {
                // Long files: keep only one mesh at a time.
                known.clear();
                known.push((&model.file, scene.read_mesh_with(&model.file, progress)?));
                0
            }
        };
        let mesh = &known[number].1;
        let report_done = |done: f32| {
            // Smaller ones are finished before a bar could be noticed.
            if mesh.triangles.len() > MANY_TRIANGLES {
                progress.report(&format!("simplifying {}", shown(&mesh.name)), done);
            }
        };
        report_done(0.0);
        let wrong = |cause| MeshError::Read { path: model.file.clone(), cause };
        models.push(Arc::new(TreeModel::new(mesh, model.z_up).map_err(wrong)?));
        report_done(1.0);
    }
    Ok(models)
}

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "a test writes into its own scratch folder")]
mod tests {
    use super::*;
    use crate::source::Silent;
    use crate::world::WorldError;

    const TREE: &str = "v 0 0 0\nv 1 0 0\nv 0 3 0\nf 1 2 3\n";

    fn scene(folder: &Path, species: &[&str]) -> Scene {
        let species = species.iter().map(|keys| format!("[[forest.species]]\n{keys}\n")).collect::<String>();
        let text = format!("[world]\nprocedural = {{ seed = 1 }}\n{species}");
        Scene::parse(&folder.join("s.toml"), &text).unwrap()
    }

    #[test]
    fn each_model_is_read_once() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.obj"), TREE).unwrap();
        let species =
            ["file = \"a.obj\"", "form = \"birch\"", "file = \"a.obj\"\nup = \"z\"", "file = \"a.obj\"\nup = \"y\""];
        let error = read(&scene(folder.path(), &species), &Silent).unwrap_err();
        // The model has no height along z.
        assert!(error.to_string().ends_with("a.obj: it has no height"), "{error}");
        std::fs::write(folder.path().join("a.obj"), TREE.replace("v 0 3 0", "v 0 3 1")).unwrap();
        let models = read(&scene(folder.path(), &species), &Silent).unwrap();
        assert!(models.len() == 2 && models[0] != models[1]);
        assert!(read(&Scene::default(), &Silent).unwrap().is_empty());
    }

    #[test]
    fn errors_are_one_line_with_key_and_file() {
        let folder = tempfile::tempdir().unwrap();
        let error_of = |name: &str, text: Option<&str>| {
            if let Some(text) = text {
                std::fs::write(folder.path().join(name), text).unwrap();
            }
            let scene = scene(folder.path(), &["form = \"snag\"", &format!("file = \"{name}\"")]);
            let error = WorldError::TreeModel(read(&scene, &Silent).err()?).to_string();
            assert!(error.starts_with("forest.species.file: cannot read the mesh ") && error.contains(name), "{error}");
            assert_eq!(error.lines().count(), 1, "{error}");
            Some(error)
        };
        for (name, text, cause) in [
            ("missing.obj", None, "o such file"),
            ("empty.obj", Some(""), "it has no faces"),
            ("flat.obj", Some("v 0 0 0\nv 1 0 0\nv 0 0 3\nf 1 2 3\n"), "it has no height"),
            ("line.obj", Some("v 0 0 0\nv 0 1 0\nv 0 0 0\nf 1 2 3\n"), "all of its triangles are without area"),
            ("nan.obj", Some("v 0 0 0\nv nan 0 0\nv 0 3 0\nf 1 2 3\n"), "line 2: "),
            ("broken.obj", Some("v 0 0 0\nv 1 0 0\nf 1 2 3\n"), "line 3: "),
        ] {
            let error_of = error_of(name, text).unwrap();
            assert!(error_of.contains(cause), "{error_of}");
        }
        // Planted error: a valid model.
        assert_eq!(error_of("tree.obj", Some(TREE)), None);
    }
}
