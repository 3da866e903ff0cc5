//! The world of a model that is opened by itself: its ground, its scale, and the box that cameras and maps frame.
//!
//! Why: `docs/decisions/lone-models.md`.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::Surfaces;
use super::open::WorldError;
use crate::file::message::named;
use crate::mesh::Mesh;
use crate::mesh::placed::{Placed, Standing};
use crate::pyramid::TileStore;
use crate::pyramid::store::MemoryStore;
use crate::scene::lone_model::LoneModel;
use crate::scene::{Scene, World};
use crate::source::georeference::Georeference;
use crate::source::{HeightGrid, Progress};

/// The longest sides, in metres, that a model may have to be drawn at its true scale. Cameras are written to the
/// millimetre, which would be more than a pixel of smaller ones, and a hundred times larger ones have no room.
const TRUE_SIDES_M: [f64; 2] = [0.5, 1e5];
/// Samples of the ground along each side.
const SAMPLES: u32 = 1025;
/// Length of the ground's sides, in longest sides of the model.
const GROUND_SIDES: f64 = 200.0;
/// Distance at which haze has taken 63 % of the contrast, in longest sides of the model: none of the model, and all of
/// the ground's border.
const HAZE_SIDES: f64 = 20.0;
/// Height of a model's lowest vertex above the ground, in longest sides: faces that lie on the ground hide it.
const LIFT: f64 = 1e-4;
/// Free space around a model on a map, as a part of its longer side.
const MAP_MARGIN: f64 = 0.2;

/// Returns the box of a mesh whose y axis points up, in the file's units: half its size to the east, north and above.
fn half_size(mesh: &Mesh) -> DVec3 {
    let places = mesh.vertices_m.iter().map(|vertex| DVec3::from_array(vertex.map(f64::from)).abs());
    let [x, y, z] = places.fold(DVec3::ZERO, DVec3::max).to_array();
    DVec3::new(x, z, y)
}

/// Returns the longest side in the file's units, which are metres; 1 for a mesh without any size.
fn side_m(mesh: &Mesh) -> f64 {
    let side_m = 2.0 * half_size(mesh).max_element();
    if side_m.is_finite() && side_m > 0.0 { side_m } else { 1.0 }
}

/// Returns the scale at which a model is drawn: 1, or a power of ten for one that is too small or too large.
fn scale(mesh: &Mesh) -> f64 {
    let side_m = side_m(mesh);
    let [smallest_m, largest_m] = TRUE_SIDES_M;
    let power = if side_m < smallest_m {
        (smallest_m / side_m).log10().ceil()
    } else if side_m > largest_m {
        (largest_m / side_m).log10().floor()
    } else {
        0.0
    };
    10.0_f64.powi(power as i32)
}

/// Returns the scale of a model and the position of its origin, with which the middle of its box is at the world's
/// origin and its lowest vertex on the ground, which is `ground_m` high.
pub(super) fn stance(mesh: &Mesh, ground_m: f64) -> (f64, DVec3) {
    let scale = scale(mesh);
    let DVec3 { x, y, z } = mesh.middle_m;
    let middle_m = DVec3::new(0.0, 0.0, scale * (half_size(mesh).z + LIFT * side_m(mesh)) + ground_m);
    (scale, middle_m - scale * DVec3::new(x, -z, y))
}

/// Returns the flat ground of a model, at height 0.
///
/// # Errors
/// If the model cannot be read.
pub(super) fn ground(model: &LoneModel, progress: &dyn Progress) -> Result<Arc<dyn TileStore>, WorldError> {
    let mesh = model.mesh(progress)?;
    let (side_m, scale) = (side_m(&mesh), scale(&mesh));
    if scale != 1.0 {
        let what = if scale > 1.0 { "small" } else { "large" };
        tracing::warn!(
            "{}: is {side_m:.3} m wide or high, too {what} for a world in metres; it is drawn at {scale} times its size",
            named(model.file())
        );
    }
    let spacing_m = GROUND_SIDES * side_m * scale / f64::from(SAMPLES - 1);
    let grid = HeightGrid {
        width: SAMPLES,
        height: SAMPLES,
        heights_m: vec![0.0; SAMPLES as usize * SAMPLES as usize],
        georeference: Georeference::local(SAMPLES, SAMPLES, spacing_m),
    };
    Ok(Arc::new(MemoryStore::new(grid, &model.file().to_string_lossy(), progress)?))
}

/// Sets the haze of a model's world, unless the scene has its own.
///
/// # Errors
/// If the model cannot be read.
pub(super) fn set_haze(scene: &mut Scene, progress: &dyn Progress) -> Result<(), WorldError> {
    if let World::Model(model) = &scene.world {
        let mesh = model.mesh(progress)?;
        scene.haze.distance_m.get_or_insert(HAZE_SIDES * side_m(&mesh) * scale(&mesh));
    }
    Ok(())
}

/// Returns the positions of the vertices of an instance, in metres.
pub(super) fn vertices_m<'a>(placed: &'a Placed, standing: &'a Standing) -> impl Iterator<Item = DVec3> + 'a {
    let vertices = placed.mesh(standing).vertices_m.iter();
    vertices.map(|vertex| standing.middle_m + standing.world_from_mesh * DVec3::from_array(vertex.map(f64::from)))
}

/// Returns the lowest and the highest corner of the box around the model of a scene, in metres; `None` if the scene is
/// not that of a model that is opened by itself.
pub(crate) fn box_m(scene: &Scene, surfaces: &Surfaces) -> Option<[DVec3; 2]> {
    if !matches!(scene.world, World::Model(_)) {
        return None;
    }
    let placed = surfaces.meshes()?;
    let all = || placed.standing.iter().flat_map(|standing| vertices_m(placed, standing));
    let (low_m, high_m) = (all().fold(DVec3::INFINITY, DVec3::min), all().fold(DVec3::NEG_INFINITY, DVec3::max));
    low_m.cmple(high_m).all().then_some([low_m, high_m])
}

/// Returns the area that a map of a model shows, from the model's box: south-west and north-east corner, in metres.
pub(super) fn map_corners_m([low_m, high_m]: [DVec3; 2]) -> [DVec2; 2] {
    let margin_m = MAP_MARGIN * (high_m - low_m).max_element();
    [low_m.truncate() - margin_m, high_m.truncate() + margin_m]
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;
    use crate::mesh::obj;
    use crate::mesh::placed::Stance;

    /// Returns a wedge of 2 × 3 × 4 units times `size`, far from the origin of its file.
    fn wedge(size: f64) -> Arc<Mesh> {
        let corners = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 4.0]];
        let vertices = corners.map(|at| at.map(|along| size * (along + 70.0)));
        let lines: String = vertices.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
        let text = format!("{lines}f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
        Arc::new(obj::parse("wedge.obj".to_owned(), text.as_bytes()).unwrap())
    }

    #[test]
    fn a_model_is_in_the_middle_on_the_ground_at_its_scale() {
        for (size, wanted) in [(1.0, 1.0), (0.1, 10.0), (0.125, 1.0), (2e-3, 100.0), (3e4, 0.1), (2.5e4, 1.0)] {
            let mesh = wedge(size);
            let (scale, origin_m) = stance(&mesh, 7.0);
            assert!((scale / wanted - 1.0).abs() < 1e-9, "{size}: {scale}");
            let mut placed = Placed::default();
            placed.add(&mesh, &Stance { origin_m, yaw_deg: 0.0, scale, z_up: false }).unwrap();
            let found = || vertices_m(&placed, &placed.standing[0]);
            let low_m = found().fold(DVec3::INFINITY, DVec3::min);
            let high_m = found().fold(DVec3::NEG_INFINITY, DVec3::max);
            let side_m = 4.0 * size * wanted;
            // On the ground, but not in its plane.
            assert!((1e-5..1e-3).contains(&((low_m.z - 7.0) / side_m)), "{size}: {low_m}");
            assert!((low_m + high_m).truncate().length() < 1e-6 * side_m, "{size}: {low_m} {high_m}");
            let size_m = DVec3::new(2.0, 4.0, 3.0) * size * wanted;
            assert!((high_m - low_m - size_m).length() < 1e-5 * side_m, "{size}: {low_m} {high_m}");
            // Planted error: the origin of the file in the middle, as in a scene file.
            assert!((origin_m - DVec3::new(0.0, 0.0, 7.0)).length() > 10.0 * side_m, "{size}: {origin_m}");
        }
    }
}
