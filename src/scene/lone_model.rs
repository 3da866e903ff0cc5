//! A model that is opened by itself: an OBJ file in place of a scene. It is placed in the middle of flat ground.
//!
//! Why: `docs/decisions/lone-models.md`.

use std::fmt::{Debug, Formatter};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use super::{MeshPlacement, MeshPositions, Scene, Sun, WaterFiles, World};
use crate::mesh::{Mesh, MeshError, obj};
use crate::source::Progress;

/// The sun over a model: to the left of the start view, behind the camera and high, so that front, side and top differ.
const SUN: Sun = Sun { azimuth_deg: 250.0, elevation_deg: 45.0 };

/// The OBJ file of a model that is opened by itself. It is read once, when its ground is made, and shared by clones.
#[derive(Clone)]
pub struct LoneModel {
    file: PathBuf,
    mesh: Arc<OnceLock<Arc<Mesh>>>,
}

impl LoneModel {
    /// Returns the path of the file.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Returns the mesh, and reads it the first time. Problems with its materials are logged as warnings.
    ///
    /// # Errors
    /// [`MeshError::Read`].
    pub(crate) fn mesh(&self, progress: &dyn Progress) -> Result<Arc<Mesh>, MeshError> {
        if let Some(mesh) = self.mesh.get() {
            return Ok(Arc::clone(mesh));
        }
        let mesh = Arc::new(obj::read_with(&self.file, progress, &mut |warning| tracing::warn!("{warning}"))?);
        Ok(Arc::clone(self.mesh.get_or_init(|| mesh)))
    }
}

impl PartialEq for LoneModel {
    /// Compares the paths.
    fn eq(&self, other: &Self) -> bool {
        self.file == other.file
    }
}

impl Debug for LoneModel {
    fn fmt(&self, formatter: &mut Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("LoneModel").field("file", &self.file).finish_non_exhaustive()
    }
}

impl Scene {
    /// Returns the scene of a model that is opened by itself.
    pub(crate) fn of_model(file: &Path) -> Self {
        let model = LoneModel { file: file.to_owned(), mesh: Arc::default() };
        let placement = MeshPlacement {
            file: file.to_owned(),
            positions: MeshPositions::Middle,
            yaw_deg: 0.0,
            scale: 1.0,
            z_up: false,
        };
        Self {
            sun: SUN,
            meshes: vec![placement],
            // Its level ground is not a lake.
            water: WaterFiles { only_given: true, ..WaterFiles::default() },
            ..Self::of_world(World::Model(model))
        }
    }
}
