//! `render --map`: draws the land from straight above and georeferences the picture: a PNG gets a world file and a
//! `.prj`, a GeoTIFF its tags, a GeoJSON its coordinates.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use glam::DVec2;
use kurbo::PathEl;

use super::{Job, RenderArgs};
use crate::commands::misuse::Misuse;
use crate::file::FileError;
use crate::file::atomic::AtomicFile;
use crate::file::geojson::{Collection, Feature, write_geojson};
use crate::file::geotiff::GeoTiffWriter;
use crate::file::message::named;
use crate::file::pattern::{OutputKind, PictureFormat};
use crate::file::svg::Layer;
use crate::file::unnamed::{self, SideFile};
use crate::picture::{self, PictureReport};
use crate::pyramid::format::geotags;
use crate::scene::map::Map;
use crate::scene::stereo::Eyes;
use crate::scene::view::Pose;
use crate::source::georeference::{Crs, Georeference};
use crate::world::OpenWorld;

/// Coordinates are rounded to this fraction of a pixel.
const ROUNDED_PX: f64 = 0.01;
/// Lines shorter than this become dots, in pixels.
const DOT_PX: f64 = 1e-3;

/// Checks whether the output can be a map, and whether a format that needs a map gets one.
pub(super) fn check(args: &RenderArgs, kind: &OutputKind) -> Result<(), Misuse> {
    let output = named(&args.output);
    let (OutputKind::Picture(format) | OutputKind::Frames(_, format)) = kind else {
        return match args.map {
            Some(_) => Err(Misuse(format!("--map: draws one picture, and {output} is a film"))),
            None => Ok(()),
        };
    };
    if args.map.is_none() {
        return match format {
            PictureFormat::GeoTiff | PictureFormat::GeoJson => {
                Err(Misuse(format!("{output}: only a map can be georeferenced; add --map")))
            }
            _ => Ok(()),
        };
    }
    if matches!(kind, OutputKind::Frames(..)) {
        return Err(Misuse(format!("--map: draws one picture, and {output} is a pattern of frames")));
    }
    let eyes = args.stereo.eyes();
    if eyes != Eyes::Mono {
        return Err(Misuse(format!("--eyes {eyes}: a map requires --eyes mono")));
    }
    Ok(())
}

/// Checks that the coordinate reference system of a GeoJSON has an EPSG code.
pub(super) fn check_place(args: &RenderArgs, kind: &OutputKind, world: &Georeference) -> anyhow::Result<()> {
    if !matches!(kind, OutputKind::Picture(PictureFormat::GeoJson)) || world.epsg().is_some() {
        return Ok(());
    }
    let output = named(&args.output);
    match &world.crs {
        Crs::Local => bail!("cannot write {output}: the world is not georeferenced"),
        Crs::Projected { name, .. } | Crs::Geographic { name, .. } => bail!(
            "cannot write {output}: a .geojson needs an EPSG code, and no code describes {} completely; write a .tif \
             instead",
            named(name.as_str())
        ),
    }
}

/// A map of the open world.
#[derive(Clone, Debug)]
pub(super) struct PlacedMap {
    pub(super) map: Map,
    pub(super) pose: Pose,
    /// Georeference of the picture's pixels.
    pub(super) georeference: Georeference,
    /// The files beside the picture that place it on the earth.
    pub(super) side_files: Vec<SideFile>,
}

impl PlacedMap {
    /// Returns `None` if no map is to be drawn.
    ///
    /// # Errors
    /// Fails if a file beside the picture would replace one that hachure did not write.
    pub(super) fn new(
        args: &RenderArgs,
        kind: &OutputKind,
        world: &OpenWorld,
        foot_px: f32,
    ) -> Result<Option<Self>, FileError> {
        let Some(area) = args.map else { return Ok(None) };
        let (map, pose) = world.map_above(area, args.size(), foot_px as u32);
        let terrain = &world.surfaces.terrain;
        let first_m = map.world_from_px(DVec2::splat(0.5));
        let georeference = terrain.mapping().picture_georeference(terrain.store().georeference(), first_m, map.pixel_m);
        let side_files = match kind {
            OutputKind::Picture(PictureFormat::Png) => side_files(&args.output, &georeference),
            _ => Vec::new(),
        };
        unnamed::check_beside(&args.output, &side_files, args.overwrite)?;
        Ok(Some(Self { map, pose, georeference, side_files }))
    }
}

/// Returns the paths of the files beside a picture that are never inputs: those of [`side_files`].
pub(super) fn side_paths(args: &RenderArgs, kind: &OutputKind) -> Vec<PathBuf> {
    let is_placed = args.map.is_some() && matches!(kind, OutputKind::Picture(PictureFormat::Png));
    if is_placed { ["pgw", "prj"].map(|ending| args.output.with_extension(ending)).to_vec() } else { Vec::new() }
}

/// Returns the world file and the `.prj` of a PNG. [`unnamed::check_beside`] decides whether they may be written.
fn side_files(output: &Path, georeference: &Georeference) -> Vec<SideFile> {
    let [x0, x_column, x_row, y0, y_column, y_row] = georeference.crs_from_grid;
    // In ESRI's order; the position is that of the first pixel's centre.
    let world_file = [x_column, y_column, x_row, y_row, x0, y0].map(|number| format!("{number}\n")).concat();
    let file = |ending: &str, text: String| SideFile { path: output.with_extension(ending), text };
    let mut files = vec![file("pgw", world_file)];
    let prj = output.with_extension("prj");
    match georeference.wkt() {
        Some(wkt) => files.push(file("prj", wkt + "\n")),
        None if prj.exists() => {
            tracing::warn!(
                "{}: belongs to another map; this map's reference system has no WKT form, so none is written",
                named(&prj)
            );
        }
        None if georeference.crs == Crs::Local => {}
        None => tracing::warn!("{}: not written; the reference system has no WKT form", named(&prj)),
    }
    files
}

/// Files beside a picture, complete but not yet renamed to their final names.
pub(super) struct Sidecars<'a> {
    picture: &'a Path,
    files: Vec<(SideFile, AtomicFile)>,
    overwrite: bool,
}

impl<'a> Sidecars<'a> {
    pub(super) fn create(picture: &'a Path, files: &[SideFile], overwrite: bool) -> Result<Self, FileError> {
        let create = |file: &SideFile| {
            let write = || {
                let mut written = AtomicFile::create(&file.path)?;
                std::io::Write::write_all(written.writer(), file.text.as_bytes())?;
                written.sync()?;
                Ok(written)
            };
            let written = write().map_err(|error: std::io::Error| FileError::write(&file.path, error))?;
            Ok((file.clone(), written))
        };
        Ok(Self { picture, files: files.iter().map(create).collect::<Result<_, _>>()?, overwrite })
    }

    /// Renames the files to their final names, unless the user put files there meanwhile.
    pub(super) fn commit(self) -> Result<(), FileError> {
        let (files, written): (Vec<_>, Vec<_>) = self.files.into_iter().unzip();
        unnamed::check_beside(self.picture, &files, self.overwrite)?;
        let name = |(file, written): (&SideFile, AtomicFile)| {
            written.commit().map_err(|error| FileError::write(&file.path, error))
        };
        files.iter().zip(written).try_for_each(name)
    }
}

impl Job<'_> {
    /// Writes the map's pixels to `path`.
    pub(super) fn geotiff(&mut self, path: &Path, pose: Pose) -> anyhow::Result<PictureReport> {
        let Some(placed) = &self.map else { unreachable!("checked: a map is drawn") };
        let tags = geotags::place_tags(&placed.georeference).map_err(|cause| FileError::write(path, cause))?;
        let [width, height] = self.args.size();
        let imprint = self.imprint_text();
        let mut writer = GeoTiffWriter::create(path, width, height, tags, self.args.dpi, Some(&imprint))?;
        let take = |bands: Vec<picture::Band>| {
            bands.iter().try_for_each(|band| writer.write_rows(&picture::srgb8(&band.picture)))
        };
        let report = self.render(pose, pose, take)?;
        writer.finish()?;
        Ok(report)
    }

    /// Writes the map's strokes and marks to `path`, in the reference system of the world's file.
    pub(super) fn features(&mut self, path: &Path, pose: Pose) -> anyhow::Result<PictureReport> {
        let (layers, drawn, report) = self.layers(path, pose, true)?;
        let (Some(placed), Some(svg)) = (&self.map, &self.svg) else {
            unreachable!("checked: a map with lines is drawn")
        };
        let terrain = &self.world.surfaces.terrain;
        let world = terrain.store().georeference();
        let Some(epsg) = world.epsg() else { unreachable!("checked: the reference system has a code") };
        let turn = match &world.crs {
            Crs::Geographic { radians_per_unit, .. } => Some(std::f64::consts::TAU / radians_per_unit),
            Crs::Projected { .. } | Crs::Local => None,
        };
        let place = |px: kurbo::Point| {
            let world_m = placed.map.world_from_px(DVec2::new(px.x, px.y));
            terrain.mapping().crs_from_world(world_m)
        };
        let middle = 0.5 * placed.map.size();
        let middle = kurbo::Point::new(middle.x, middle.y);
        let unit_per_px = (place(middle + (1.0, 0.0)) - place(middle)).length();
        if !(unit_per_px.is_finite() && unit_per_px > 0.0) {
            bail!("cannot write {}: the centre of the map has no coordinates in EPSG:{epsg}", named(path));
        }
        let tolerance_px = svg.flattening_px();
        let features = |layer: &Layer| {
            let ink = layer.ink.clone().unwrap_or_else(|| svg.ink());
            let feature = |stroke: &crate::file::svg::Stroke| {
                let places = flattened(&stroke.path, tolerance_px).into_iter().map(place);
                Feature {
                    kind: layer.kind,
                    layer: layer.id.clone(),
                    width_m: stroke.width * placed.map.pixel_m,
                    ink: stroke.ink.clone().unwrap_or_else(|| ink.clone()),
                    opacity: stroke.opacity,
                    pen: layer.pen,
                    parts: cut_at_date_line(places.collect(), turn),
                }
            };
            layer.strokes.iter().map(feature).collect::<Vec<_>>()
        };
        let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        let digits = (-(ROUNDED_PX * unit_per_px).log10()).ceil().clamp(0.0, 12.0) as usize;
        let features = layers.iter().flat_map(features).collect();
        write_geojson(path, &Collection { name, epsg, digits, features })
            .with_context(|| format!("some lines of the map have no coordinates in EPSG:{epsg}"))?;
        self.drawn.append(&drawn);
        Ok(report)
    }
}

/// Flattens a path into points; a path of hardly any length becomes one point.
fn flattened(path: &kurbo::BezPath, tolerance_px: f64) -> Vec<kurbo::Point> {
    let mut points: Vec<kurbo::Point> = Vec::new();
    kurbo::flatten(path, tolerance_px, |element| match element {
        PathEl::MoveTo(to) | PathEl::LineTo(to) => points.push(to),
        PathEl::ClosePath => points.extend(points.first().copied()),
        PathEl::QuadTo(..) | PathEl::CurveTo(..) => {}
    });
    points.dedup();
    let length_px: f64 = points.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
    if length_px < DOT_PX {
        points.truncate(1);
    }
    points
}

/// Splits a line at the antimeridian, as RFC 7946 requires (section 3.1.9), so that longitudes are from −180° to 180°.
/// `turn` is 360° in the unit of longitudes; `None` for a system without longitudes.
fn cut_at_date_line(places: Vec<DVec2>, turn: Option<f64>) -> Vec<Vec<[f64; 2]>> {
    let Some(turn) = turn else { return vec![places.iter().map(DVec2::to_array).collect()] };
    let half = 0.5 * turn;
    let side = |place: DVec2| ((place.x + half) / turn).floor();
    let mut parts: Vec<Vec<[f64; 2]>> = vec![Vec::new()];
    let mut before: Option<DVec2> = None;
    for place in places {
        if let Some(before) = before.filter(|before| side(*before) != side(place)) {
            let edge = side(before).max(side(place)) * turn - half;
            let part = (edge - before.x) / (place.x - before.x);
            let north = before.y + (place.y - before.y) * part;
            let sign = if place.x > before.x { 1.0 } else { -1.0 };
            parts.last_mut().into_iter().for_each(|part| part.push([sign * half, north]));
            parts.push(vec![[-sign * half, north]]);
        }
        parts.last_mut().into_iter().for_each(|part| part.push([place.x - side(place) * turn, place.y]));
        before = Some(place);
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_cut_at_the_date_line() {
        let line = vec![DVec2::new(179.0, 10.0), DVec2::new(181.0, 12.0), DVec2::new(179.5, 12.0)];
        let cut = cut_at_date_line(line.clone(), Some(360.0));
        let expected = vec![
            vec![[179.0, 10.0], [180.0, 11.0]],
            vec![[-180.0, 11.0], [-179.0, 12.0], [-180.0, 12.0]],
            vec![[180.0, 12.0], [179.5, 12.0]],
        ];
        assert_eq!(cut, expected);
        assert_eq!(cut_at_date_line(line, None), [vec![[179.0, 10.0], [181.0, 12.0], [179.5, 12.0]]]);
    }

    #[test]
    fn curves_become_lines_and_points_dots() {
        let path = kurbo::BezPath::from_svg("M0,0 C0,10 10,10 10,0").unwrap();
        let points = flattened(&path, 0.05);
        assert!(points.len() > 4 && points.first() == Some(&kurbo::Point::ZERO), "{points:?}");
        let highest = points.iter().map(|point| point.y).fold(0.0, f64::max);
        assert!((highest - 7.5).abs() < 0.1, "{highest}");
        let dot = kurbo::BezPath::from_svg("M3,4 L3.0001,4").unwrap();
        assert_eq!(flattened(&dot, 0.05), [kurbo::Point::new(3.0, 4.0)]);
    }
}
