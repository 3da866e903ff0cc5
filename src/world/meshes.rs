//! The models of a scene: each file is read once, and placed at one place, at those of a list, or where a rule finds
//! room ([`super::scattered`]).
//!
//! This happens when the scene is opened, because ground heights may have to be read. Frames only know positions.

use std::sync::Arc;

use glam::DVec2;
use rustc_hash::FxHashMap;

use super::lone_model;
use super::open::{OpenWorld, WorldError};
use super::scattered::scattered;
use crate::file::guard::{Identity, identity};
use crate::file::message::{named, shown};
use crate::forest::points::Points;
use crate::mesh::levels::{Level, MANY_TRIANGLES, coarser};
use crate::mesh::placed::{MAX_INSTANCES, Placed, Stance};
use crate::mesh::{Mesh, MeshError};
use crate::scene::{Density, MeshPlace, MeshPlacement, MeshPositions, World, mesh_list};
use crate::source::Progress;

/// Places the meshes of a world's scene on its land.
///
/// # Errors
/// If a file cannot be read, or there are too many places.
pub(super) fn place(world: &OpenWorld, progress: &dyn Progress) -> Result<Placed, WorldError> {
    let mut placed = Placed::default();
    // By identity: a file may be called by many names.
    let mut known: FxHashMap<Identity, Arc<Mesh>> = FxHashMap::default();
    let mut points = None;
    for placement in &world.scene.meshes {
        let own = identity(&placement.file);
        let mesh = match own.as_ref().and_then(|own| known.get(own)) {
            Some(mesh) => Arc::clone(mesh),
            None => {
                let mesh = match &world.scene.world {
                    World::Model(model) => model.mesh(progress)?,
                    _ => Arc::new(world.scene.read_mesh_with(&placement.file, progress)?),
                };
                known.extend(own.map(|own| (own, Arc::clone(&mesh))));
                placed.add_levels(&mesh, levels_of(&mesh, progress))?;
                mesh
            }
        };
        let stances = stances(world, placement, &mesh, &mut points)?;
        let found = (placed.standing.len() + stances.len()) as u64;
        if found > MAX_INSTANCES {
            return Err(MeshError::TooMany { what: "places", found, most: MAX_INSTANCES }.into());
        }
        for stance in stances {
            placed.add(&mesh, &stance)?;
        }
    }
    Ok(placed)
}

/// Computes the coarser levels of a mesh. For a large one this takes some seconds.
fn levels_of(mesh: &Mesh, progress: &dyn Progress) -> Vec<Level> {
    let report_done = |done: f32| {
        if mesh.triangles.len() > MANY_TRIANGLES {
            progress.report(&format!("simplifying {}", shown(&mesh.name)), done);
        }
    };
    report_done(0.0);
    let levels = coarser(mesh);
    report_done(1.0);
    levels
}

/// Returns the placements of a model, whose mesh is `mesh`.
fn stances(
    world: &OpenWorld,
    placement: &MeshPlacement,
    mesh: &Mesh,
    points: &mut Option<Points>,
) -> Result<Vec<Stance>, WorldError> {
    let &MeshPlacement { yaw_deg, scale, z_up, .. } = placement;
    let on_ground = |place: &MeshPlace| {
        let mut origin_m = place.at_m;
        if place.height_above_ground {
            origin_m.z += world.ground_m(origin_m.x, origin_m.y);
        }
        origin_m
    };
    match &placement.positions {
        MeshPositions::At(place) => Ok(vec![Stance { origin_m: on_ground(place), yaw_deg, scale, z_up }]),
        MeshPositions::Middle => {
            let (fitting, origin_m) = lone_model::stance(mesh, world.ground_m(0.0, 0.0));
            Ok(vec![Stance { origin_m, yaw_deg, scale: scale * fitting, z_up }])
        }
        MeshPositions::Listed(list) => {
            let stance = |row: mesh_list::MeshRow| Stance {
                origin_m: on_ground(&row.place),
                yaw_deg: yaw_deg + row.yaw_deg,
                scale: scale * row.scale,
                z_up,
            };
            Ok(mesh_list::read(list)?.into_iter().map(stance).collect())
        }
        MeshPositions::Scattered(scatter) => {
            let terrain = &world.surfaces.terrain;
            let name = placement.file.file_name().unwrap_or_default().to_string_lossy();
            let ground_m = |at_m: DVec2| terrain.height_m(at_m);
            let points = points.get_or_insert_with(Points::new);
            let scatter = &scatter.exaggerated(world.scene.vertical_exaggeration);
            let found = scattered(scatter, &name, points, terrain.grid_projection().spacing_m(), &ground_m);
            if let Density::Count(count) = scatter.density
                && found.len() < count as usize
            {
                let found = found.len();
                tracing::warn!(
                    "{}: placed {found} of {count}; the rule leaves no room for more",
                    named(&placement.file)
                );
            }
            let stance = |spot: &super::scattered::Spot| Stance {
                origin_m: spot.at_m,
                yaw_deg: yaw_deg + spot.turn_deg,
                scale: scale * spot.scale,
                z_up,
            };
            Ok(found.iter().map(stance).collect())
        }
    }
}
