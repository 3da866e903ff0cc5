//! `render -o NAME.glb` and `-o NAME.stl`: writes the land as triangles within `--mesh-error`.

use anyhow::Context;
use glam::DVec2;
use serde::Serialize;
use serde_json::json;

use super::RenderArgs;
use crate::commands::misuse::Misuse;
use crate::commands::progress::Bar;
use crate::commands::{inputs, print, print_json};
use crate::file::glb::{GlbMesh, write_glb};
use crate::file::message::named;
use crate::file::pattern::{MeshFormat, OutputKind};
use crate::file::stl::write_stl;
use crate::land_mesh::LandMesh;
use crate::land_mesh::lattice::{Extent, Lattice};
use crate::scene::Scene;
use crate::scene::map::{Map, MapArea};
use crate::source::WorldMapping;
use crate::tiles::grid_projection::GridProjection;
use crate::world;

/// The error without `--mesh-error`, as a part of the longer side.
const ERROR_PART: f64 = 0.001;
/// Height of a solid's base below the lowest land, as a part of the longer side.
const BASE_PART: f64 = 0.02;

/// Report on a mesh, as JSON.
#[derive(Serialize)]
struct MeshReport {
    output: std::path::PathBuf,
    triangles: usize,
    vertices: usize,
    /// Largest measured error along the vertical.
    error_m: f64,
    /// Distance of the points at which the error was measured.
    measured_every_m: f64,
    /// Width (east), depth (north) and height of the land.
    size_m: [f64; 3],
    /// Lowest and highest land, as in the heights of the world.
    heights_m: [f64; 2],
    /// Thickness of a solid below the lowest land, where its z is 0.
    base_m: Option<f64>,
}

/// Checks that a mesh gets no option of a picture, and a picture none of a mesh.
///
/// # Errors
/// Returns the misuse, in one line.
pub(super) fn check(args: &RenderArgs, kind: &OutputKind) -> Result<(), Misuse> {
    let output = named(&args.output);
    if !matches!(kind, OutputKind::Mesh(_)) {
        return match args.mesh_error {
            Some(_) => Err(Misuse(format!("--mesh-error: applies only to a .glb or .stl, and the output is {output}"))),
            None => Ok(()),
        };
    }
    let given = [
        ("--antialias", args.antialias.is_some()),
        ("--aov", !args.aov.is_empty()),
        ("--camera", args.camera.is_some()),
        ("--dpi", args.dpi.is_some()),
        ("--drape", !args.world.layers.drape.is_empty()),
        ("--credits", args.credits.is_some()),
        ("--eyes", args.stereo.eyes.is_some()),
        ("--fps", args.fps.is_some()),
        ("--frames", args.frames.is_some()),
        ("--map-frame", args.frame),
        ("--map-scale", args.map_scale.is_some()),
        ("--landscape", args.landscape),
        ("--legend", args.legend),
        ("--like", args.like.is_some()),
        ("--names", args.labels.names.is_some()),
        ("--peaks", args.labels.peaks.is_some()),
        ("--saddles", args.saddles.is_some()),
        ("--lakes", args.lakes.is_some()),
        ("--look-at", args.look.look_at.is_some()),
        ("--lod-error", args.lod_error.is_some()),
        ("--margin", args.margin.is_some()),
        ("--paper", args.paper.is_some()),
        ("--path", args.path.is_some()),
        ("--pens", args.pens.is_some()),
        ("--portrait", args.portrait),
        ("--quality", args.quality.quality.is_some()),
        ("--samples", args.samples.is_some()),
        ("--sheets", args.sheets.sheets.is_some()),
        ("--show", args.show.is_some()),
        ("--style", args.style.is_some()),
        ("--set", !args.set.is_empty()),
        ("--title", args.title.is_some()),
        ("--tolerance-px", args.tolerance_px.is_some()),
        ("--wgs84", args.wgs84),
    ];
    match given.into_iter().find(|(_, is_given)| *is_given) {
        Some((option, _)) => Err(Misuse(format!(
            "{option}: does not apply to a mesh, and the output is {output}; --map sets the extent of a mesh, \
             --mesh-error its accuracy"
        ))),
        None if matches!(args.map, Some(MapArea::At { .. })) => {
            Err(Misuse("--map: a mesh needs the width of its map; add --map=EAST,NORTH,WIDTH".to_owned()))
        }
        None if args.size.is_some()
            && args.map_place.at.is_none()
            && !matches!(args.map, Some(MapArea::Around { .. })) =>
        {
            Err(Misuse("--size: sets the shape of --map for a mesh; add --map=EAST,NORTH,WIDTH".to_owned()))
        }
        None => Ok(()),
    }
}

/// Writes the mesh.
///
/// # Errors
/// Fails if an input is invalid, the mesh would be too large, or the output cannot be written.
pub(super) fn run(args: &RenderArgs, format: MeshFormat, scene: &Scene) -> anyhow::Result<()> {
    let output = &args.output;
    inputs::of(args.world.name(), scene, &[], None).check(output)?;
    let store = world::open_store(scene, &Bar::default())?;
    let around = super::map::around_place(args, &*store)?;
    let args = around.as_ref().unwrap_or(args);
    let size = store.levels()[0];
    let mapping = WorldMapping::new(store.georeference(), size.width, size.height)?;
    let projection = GridProjection::fit(&mapping, size.width, size.height);
    let extent = extent(args, &projection);
    let size_m = extent.corners_m[1] - extent.corners_m[0];
    let max_error_m = args.mesh_error.unwrap_or(ERROR_PART * size_m.max_element());
    let cannot = || format!("cannot write {}", named(output));
    let lattice = Lattice::read(&store, &projection, &extent).with_context(cannot)?;
    let mesh = LandMesh::new(&lattice, max_error_m).with_context(cannot)?;
    let [low_m, high_m] = mesh.bounds_m();
    let solid_base_m = BASE_PART * size_m.max_element();
    let base_m = (format == MeshFormat::Stl).then_some(solid_base_m);
    let triangles = match format {
        MeshFormat::Glb => {
            let name = args.world.name().unwrap_or("hachure");
            let extras = json!({
                "world": name,
                "crs": store.georeference().epsg().map(|code| format!("EPSG:{code}")),
                "origin_crs": mapping.crs_from_world(mesh.middle_m).to_array(),
                "origin_world_m": mesh.middle_m.to_array(),
                "error_m": mesh.error_m,
                "measured_every_m": mesh.measured_every_m,
            });
            let LandMesh { positions, normals, triangles, .. } = &mesh;
            write_glb(output, &GlbMesh { name: "land", positions, normals, triangles, extras })?;
            triangles.len()
        }
        MeshFormat::Stl => {
            // A print stands on its base: the lowest point of the solid is at 0.
            let base_m = solid_base_m;
            let (positions, triangles) = mesh.solid(low_m.z - base_m);
            let up = glam::DVec3::new(0.0, 0.0, base_m - low_m.z);
            let positions: Vec<_> = positions.into_iter().map(|at| at + up).collect();
            write_stl(output, &positions, &triangles)?;
            triangles.len()
        }
    };
    if args.json {
        return print_json(&MeshReport {
            output: output.clone(),
            triangles,
            vertices: mesh.positions.len(),
            error_m: mesh.error_m,
            measured_every_m: mesh.measured_every_m,
            size_m: (high_m - low_m).to_array(),
            heights_m: [low_m.z, high_m.z],
            base_m,
        });
    }
    let [width_m, depth_m, height_m] = (high_m - low_m).to_array();
    let base = base_m.map(|base_m| format!(", on a base of {base_m:.0} m")).unwrap_or_default();
    print(&format!(
        "{triangles} triangles; land {width_m:.0} × {depth_m:.0} m, {height_m:.0} m from lowest to highest{base}; largest \
         error {:.3} m (checked every {:.2} m)",
        mesh.error_m, mesh.measured_every_m
    ))
}

/// Returns the extent of the mesh: the map's, or all of the land.
fn extent(args: &RenderArgs, projection: &GridProjection) -> Extent {
    let land_m = projection.extent_m();
    let corners_m = match args.map {
        Some(area @ MapArea::Around { .. }) => {
            let [low_m, high_m] = Map::new(area, land_m, args.size()).corners_m();
            // Nothing is beyond the land.
            let inside = [low_m.max(land_m[0]), high_m.min(land_m[1])];
            if inside[0].cmplt(inside[1]).all() { inside } else { [low_m, high_m] }
        }
        Some(MapArea::Whole | MapArea::At { .. }) | None => land_m,
    };
    // The finest distance of samples in the middle of the extent.
    let middle = projection.grid_from_world(0.5 * (corners_m[0] + corners_m[1]));
    let at = |grid: DVec2| projection.world_from_grid(grid);
    let steps = [DVec2::X, DVec2::Y].map(|step| at(middle + step).distance(at(middle)));
    Extent { corners_m, sample_m: steps[0].min(steps[1]).max(1e-6) }
}
