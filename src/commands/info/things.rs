//! `hachure info` for files that a scene or an option adds to a world: water polygons, models, lists of positions.

use std::path::Path;

use serde::Serialize;

use crate::commands::progress::Bar;
use crate::file::geojson::Summary;
use crate::file::geojson_polygons::{NO_POLYGONS, Polygons, PolygonsError};
use crate::file::message::{counted, printable};
use crate::mesh::obj;
use crate::scene::mesh_list;

/// Polygons of a GeoJSON file.
#[derive(Serialize)]
pub(super) struct PolygonInfo {
    polygons: usize,
    points: usize,
    /// Code of the reference system; longitude and latitude if the file names none.
    epsg: Option<u16>,
    /// Lowest x and y, highest x and y, in units of the reference system.
    bounds: [f64; 4],
}

/// A model in an OBJ file.
#[derive(Serialize)]
pub(super) struct ModelInfo {
    triangles: usize,
    vertices: usize,
    /// Size along the file's axes, in metres.
    size_m: [f64; 3],
    /// Number of named materials.
    materials: usize,
}

/// A GeoJSON file, described by its polygons, or by its features if it has none.
pub(super) enum GeoJsonInfo {
    Polygons(PolygonInfo),
    Features(Summary),
}

/// Reads a GeoJSON file.
///
/// # Errors
/// Fails if the file is not GeoJSON.
pub(super) fn geojson(file: &Path) -> anyhow::Result<GeoJsonInfo> {
    let found = match Polygons::read(file) {
        Err(PolygonsError::Content { cause, .. }) if cause == NO_POLYGONS => {
            return Ok(GeoJsonInfo::Features(Summary::read(file)?));
        }
        found => found?,
    };
    let points = || found.vertices().iter();
    let none = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    let bounds = points().fold(none, |[x0, y0, x1, y1], [x, y]| [x0.min(*x), y0.min(*y), x1.max(*x), y1.max(*y)]);
    let info = PolygonInfo { polygons: found.count(), points: points().count(), epsg: found.epsg, bounds };
    Ok(GeoJsonInfo::Polygons(info))
}

/// Reads a model.
///
/// # Errors
/// Fails if the file is not a model.
pub(super) fn model(file: &Path) -> anyhow::Result<ModelInfo> {
    let mesh = obj::read_with(file, &Bar::default(), &mut |warning| tracing::warn!("{warning}"))?;
    let axis = |axis: usize| {
        let all = || mesh.vertices_m.iter().map(|vertex| f64::from(vertex[axis]));
        all().fold(f64::NEG_INFINITY, f64::max) - all().fold(f64::INFINITY, f64::min)
    };
    Ok(ModelInfo {
        triangles: mesh.triangles.len(),
        vertices: mesh.vertices_m.len(),
        size_m: [axis(0), axis(1), axis(2)],
        materials: mesh.materials.len() - 1,
    })
}

/// Returns the number of positions in a list of positions of models; `None` if the file is not such a list.
pub(super) fn positions(file: &Path, head: &str) -> anyhow::Result<Option<usize>> {
    let is_list = super::first_fields(head).is_some_and(|fields| {
        let has = |name: &str| fields.iter().any(|field| field == name);
        has("x") && has("y") && !has("t")
    });
    Ok(if is_list { Some(mesh_list::read(file)?.len()) } else { None })
}

impl PolygonInfo {
    pub(super) fn text(&self, file: &str) -> String {
        let Self { polygons, points, epsg, bounds: [x0, y0, x1, y1] } = self;
        let place = epsg.map_or("longitude and latitude".to_owned(), |epsg| format!("EPSG:{epsg}"));
        format!(
            "{file}: GeoJSON with {} of {}; --water draws them as water\n\
             place     {place}, x {x0} to {x1}, y {y0} to {y1}\n",
            counted(*polygons as u64, "polygon"),
            counted(*points as u64, "point"),
        )
    }
}

impl ModelInfo {
    pub(super) fn text(&self, file: &str) -> String {
        let Self { triangles, vertices, size_m: [x, y, z], materials } = self;
        format!(
            "{file}: a model; a scene places it on the land ([[meshes]])\n\
             triangles {triangles}, with {vertices} vertices and {materials} materials\n\
             size      {x:.3} × {y:.3} × {z:.3} m along x, y and z\n"
        )
    }
}

/// Returns the description of a GeoJSON file without polygons.
pub(super) fn features_text(file: &str, found: &Summary) -> String {
    let Summary { lines, points, others, kinds, epsg } = found;
    let place = epsg.map_or("longitude and latitude".to_owned(), |epsg| format!("EPSG:{epsg}"));
    let all = [(lines, "line"), (points, "point"), (others, "other feature")];
    let of: Vec<String> =
        all.into_iter().filter(|(count, _)| **count > 0).map(|(count, name)| counted(*count, name)).collect();
    let kinds: Vec<String> = kinds.iter().map(|(kind, count)| counted(*count, &printable(kind, 40))).collect();
    let kinds = if kinds.is_empty() { String::new() } else { format!(" ({})", kinds.join(", ")) };
    let of = if of.is_empty() { "without features".to_owned() } else { format!("of {}", of.join(", ")) };
    format!("{file}: GeoJSON {of}{kinds}, {place}\n")
}
