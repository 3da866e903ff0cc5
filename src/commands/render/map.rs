//! `render --map`: draws the land from straight above and georeferences the picture: a PNG or JPEG gets a world file
//! and an `.aux.xml`, a GeoTIFF its tags, a GeoJSON its coordinates ([`super::features`]).

use std::path::{Path, PathBuf};

use anyhow::bail;
use glam::DVec2;

use super::{Job, RenderArgs};
use crate::commands::misuse::Misuse;
use crate::commands::place_args::no_crs;
use crate::file::FileError;
use crate::file::atomic::AtomicFile;
use crate::file::geotiff::GeoTiffWriter;
use crate::file::imprint::escaped;
use crate::file::message::{named, shown};
use crate::file::pattern::{OutputKind, PictureFormat};
use crate::file::unnamed::{self, SideFile, aux_path, world_file_path};
use crate::picture::{self, PictureReport, map_frame};
use crate::pyramid::TileStore;
use crate::pyramid::format::geotags;
use crate::scene::map::{Map, MapArea};
use crate::scene::ranges;
use crate::scene::stereo::Eyes;
use crate::scene::view::Pose;
use crate::source::WorldMapping;
use crate::source::georeference::{Crs, Georeference};
use crate::source::lon_lat::ToWgs84;
use crate::tiles::grid_projection::GridProjection;
use crate::world::OpenWorld;
use crate::world::map::Edges;

/// Checks whether the output can be a map, and whether a format that needs a map gets one.
pub(super) fn check(args: &RenderArgs, kind: &OutputKind) -> Result<(), Misuse> {
    let output = named(&args.output);
    let Some(format) = kind.picture_format() else {
        if args.wgs84 {
            return Err(Misuse(format!("--wgs84: applies only to a .geojson, and {output} is a film")));
        }
        if args.frame {
            return Err(Misuse(format!("--map-frame: frames a map, and {output} is a film")));
        }
        return match args.map {
            Some(_) => Err(Misuse(format!("--map: draws one picture, and {output} is a film"))),
            None => Ok(()),
        };
    };
    if args.wgs84 && format != PictureFormat::GeoJson {
        return Err(Misuse(format!("--wgs84: applies only to a .geojson, and the output is {output}")));
    }
    match args.map {
        None if args.map_scale.is_some() => {
            return Err(Misuse("--map-scale: is the scale of a map; add --map".to_owned()));
        }
        Some(area @ MapArea::At { .. }) if args.map_scale.is_none() => {
            let misuse = match format {
                PictureFormat::GeoJson => {
                    format!("--map={area}: the width in metres is missing; write --map={area},WIDTH")
                }
                _ => format!(
                    "--map={area}: a width in metres is missing, or the scale; write --map={area},WIDTH or add --map-scale"
                ),
            };
            return Err(Misuse(misuse));
        }
        _ => {}
    }
    if args.map.is_none() {
        if args.frame {
            return Err(Misuse("--map-frame: frames a map; add --map".to_owned()));
        }
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
    if args.frame && format == PictureFormat::GeoJson {
        return Err(Misuse(format!("--map-frame: a .geojson has no frame, and the output is {output}")));
    }
    let eyes = args.stereo.eyes();
    if eyes != Eyes::Mono {
        return Err(Misuse(format!("--eyes {eyes}: a map requires --eyes mono")));
    }
    Ok(())
}

/// Checks that the coordinate reference system of a GeoJSON has an EPSG code, or can be converted to WGS 84.
pub(super) fn check_place(args: &RenderArgs, kind: &OutputKind, world: &Georeference) -> anyhow::Result<()> {
    if !matches!(kind, OutputKind::Picture(PictureFormat::GeoJson)) {
        return Ok(());
    }
    let output = named(&args.output);
    if args.wgs84 {
        return match ToWgs84::new(world) {
            Ok(to_wgs84) => {
                if to_wgs84.has_unknown_datum() {
                    tracing::warn!(
                        "{output}: the datum of the world's reference system is unknown and taken as WGS 84; \
                         positions may be off by 100 m or more"
                    );
                }
                Ok(())
            }
            Err(_) if world.crs == Crs::Local => bail!("cannot write {output}: {}", no_crs(args.world.name())),
            Err(cause) => bail!("cannot write {output} in WGS 84: {cause}"),
        };
    }
    if world.epsg().is_some() {
        return Ok(());
    }
    match &world.crs {
        Crs::Local => bail!("cannot write {output}: {}", no_crs(args.world.name())),
        Crs::Projected { .. } | Crs::Geographic { .. } => {
            let wgs84 = if ToWgs84::new(world).is_ok() { "add --wgs84, or " } else { "" };
            bail!("cannot write {output}: its reference system has no EPSG code; {wgs84}write a .tif")
        }
    }
}

/// Checks that a map with a scale has no width on the command line, from which another scale would follow. `given` are
/// the arguments without those of the picture of `--like`.
pub(super) fn check_scale(given: &RenderArgs) -> Result<(), Misuse> {
    if given.map_scale.is_none() {
        return Ok(());
    }
    if let Some(MapArea::Around { centre_m, width_m }) = given.map {
        return Err(Misuse(format!(
            "--map-scale: the width of the map follows from its scale, and --map has a width of {width_m} m; write \
             --map={},{}",
            centre_m.x, centre_m.y
        )));
    }
    match given.map_place.map_width {
        Some(_) => {
            Err(Misuse("--map-scale: the width of the map follows from its scale; leave out --map-width".into()))
        }
        None => Ok(()),
    }
}

/// Checks that a map with a scale has a size on paper.
pub(super) fn check_paper(args: &RenderArgs, mm_per_px: Option<f64>) -> Result<(), Misuse> {
    if args.map_scale.is_some() && mm_per_px.is_none() { Err(unmeasured(args)) } else { Ok(()) }
}

fn unmeasured(args: &RenderArgs) -> Misuse {
    let output = named(&args.output);
    if args.output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("geojson")) {
        return Misuse(format!(
            "--map-scale: {output} has lines on the earth, without paper; use --map=EAST,NORTH,WIDTH"
        ));
    }
    Misuse(format!("--map-scale: {output} has no size in millimetres; add --paper or --dpi"))
}

/// Returns the arguments with the area that a map of a given scale (`--map-scale`) shows, around the middle of its area.
///
/// # Errors
/// Fails if the size of a pixel on paper is unknown, or if the map would be too small or too large.
pub(super) fn at_scale(args: &RenderArgs, world: &OpenWorld, page: &Page) -> Result<Option<RenderArgs>, Misuse> {
    let (Some(denominator), Some(area)) = (args.map_scale, args.map) else { return Ok(None) };
    let Some(mm_per_px) = page.mm_per_px else { return Err(unmeasured(args)) };
    let centre_m = match area {
        MapArea::At { centre_m } | MapArea::Around { centre_m, .. } => centre_m,
        MapArea::Whole => world.map_within(area, args.size(), page.edges).0.centre_above_m(page.edges.foot_px),
    };
    let columns = args.size()[0].saturating_sub(2 * page.edges.frame_px).max(1);
    let width_m = denominator * mm_per_px / 1000.0 * f64::from(columns);
    if !ranges::MAP_WIDTH_M.holds(width_m) {
        return Err(Misuse(format!(
            "--map-scale {denominator}: the map would be {width_m:.0} m wide, and a map can be 100000000 m wide"
        )));
    }
    Ok(Some(RenderArgs { map: Some(MapArea::Around { centre_m, width_m }), ..args.clone() }))
}

/// Returns the arguments with the area of a map that is centred on a place (`--at`), if one is.
///
/// # Errors
/// Fails if the heights have no position on the earth, or do not contain the place.
pub(super) fn around_place(args: &RenderArgs, store: &dyn TileStore) -> anyhow::Result<Option<RenderArgs>> {
    if args.map_place.at.is_none() {
        return Ok(None);
    }
    let size = store.levels()[0];
    let mapping = WorldMapping::new(store.georeference(), size.width, size.height)?;
    let [low_m, high_m] = GridProjection::fit(&mapping, size.width, size.height).extent_m();
    let area = args.map_place.area(args.world.name(), store, high_m.x - low_m.x)?;
    Ok(area.map(|area| RenderArgs { map: Some(area), ..args.clone() }))
}

/// The page that carries a map. Its edges and its scale determine where the map is in the picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Page {
    /// The edges that are bare paper.
    pub(super) edges: Edges,
    /// Millimetres on paper per pixel, if the paper has a size.
    pub(super) mm_per_px: Option<f64>,
}

/// A map of the open world.
#[derive(Clone, Debug)]
pub(super) struct PlacedMap {
    pub(super) map: Map,
    pub(super) pose: Pose,
    /// Georeference of the picture's pixels.
    pub(super) georeference: Georeference,
    /// The sidecar files that place the picture on the earth.
    pub(super) side_files: Vec<SideFile>,
    /// Whether all of the picture is on the earth, so that its georeference may be written.
    pub(super) has_place: bool,
}

impl PlacedMap {
    /// Returns `None` if no map is to be drawn.
    ///
    /// # Errors
    /// Fails if a sidecar file would replace one that hachure did not write.
    pub(super) fn new(
        args: &RenderArgs,
        kind: &OutputKind,
        world: &OpenWorld,
        page: &Page,
    ) -> Result<Option<Self>, FileError> {
        let Some(area) = args.map else { return Ok(None) };
        let (mut map, mut pose) = world.map_within(area, args.size(), page.edges);
        if let (MapArea::Whole, true, Some(mm_per_px)) = (area, args.frame, page.mm_per_px) {
            let m_per_denominator = mm_per_px / 1000.0;
            let pixel_m = m_per_denominator * map_frame::round_scale(map.pixel_m / m_per_denominator);
            let edges = page.edges;
            let columns = args.size()[0].saturating_sub(2 * edges.frame_px).max(1);
            let centre_m = map.centre_above_m(edges.foot_px);
            let area = MapArea::Around { centre_m, width_m: pixel_m * f64::from(columns) };
            (map, pose) = world.map_within(area, args.size(), edges);
        }
        let terrain = &world.surfaces.terrain;
        let first_m = map.world_from_px(DVec2::splat(0.5));
        let georeference = terrain.mapping().picture_georeference(terrain.store().georeference(), first_m, map.pixel_m);
        let has_place = is_on_earth(&georeference, args.size());
        let side_files = match kind {
            OutputKind::Picture(PictureFormat::Png | PictureFormat::Jpg) if has_place => {
                side_files(&args.output, &georeference)
            }
            _ => Vec::new(),
        };
        unnamed::check_beside(&args.output, &side_files, args.overwrite)?;
        Ok(Some(Self { map, pose, georeference, side_files, has_place }))
    }
}

/// Longitudes and latitudes may exceed a turn and the poles by this many degrees, for rounding.
const SLACK_DEG: f64 = 1e-6;

/// Returns whether every corner of a picture is on the earth: none is beyond a pole, and its longitudes are at most one
/// turn. Only degrees are checked.
fn is_on_earth(georeference: &Georeference, [width, height]: [u32; 2]) -> bool {
    let Crs::Geographic { radians_per_unit, .. } = georeference.crs else { return true };
    let [_, dx, _, y0, _, dy] = georeference.crs_from_grid.map(|number| (number * radians_per_unit).to_degrees());
    let sides = [y0 - 0.5 * dy, y0 + (f64::from(height) - 0.5) * dy];
    let is_beyond = sides.into_iter().any(|latitude| latitude.abs() > 90.0 + SLACK_DEG);
    !is_beyond && f64::from(width) * dx.abs() <= 360.0 + SLACK_DEG
}

/// Returns the arguments of a map of the whole world that ends at the poles and spans at most one turn, if the
/// requested map does not. Without `--size`, the map's height in pixels follows from its width.
///
/// # Errors
/// Fails for a GeoTIFF of a given size: programs refuse latitudes beyond 90°.
pub(super) fn on_the_earth(
    args: &RenderArgs,
    kind: &OutputKind,
    world: &OpenWorld,
    page: &Page,
) -> anyhow::Result<Option<RenderArgs>> {
    let OutputKind::Picture(format @ (PictureFormat::Png | PictureFormat::Jpg | PictureFormat::GeoTiff)) = kind else {
        return Ok(None);
    };
    let placed = PlacedMap::new(args, kind, world, page)?;
    let Some(placed) = placed.filter(|placed| !placed.has_place) else { return Ok(None) };
    let [low_m, high_m] = world.surfaces.terrain.corners_m();
    let [width, _] = args.size();
    let size_m = high_m - low_m;
    let fitting = [width, (f64::from(width) * size_m.y / size_m.x).floor().clamp(1.0, f64::from(1 << 20)) as u32];
    let is_free = args.size.is_none() && args.sheets.sheets.is_none() && args.title.is_none() && !args.frame;
    if is_free && args.map == Some(MapArea::Whole) {
        let centre_m = 0.5 * (low_m + high_m);
        let map = Some(MapArea::Around { centre_m, width_m: size_m.x });
        let fitted = RenderArgs { size: Some(fitting), map, ..args.clone() };
        if PlacedMap::new(&fitted, kind, world, page)?.is_some_and(|placed| placed.has_place) {
            return Ok(Some(fitted));
        }
    }
    let output = named(&args.output);
    let [width, height_px] = placed.map.size_px;
    let leave_out = if args.frame { "--map-frame" } else { "--size" };
    let cause = format!(
        "a map of {width}x{height_px} pixels reaches beyond the poles or once around the earth; leave {leave_out} out, or \
         use --map=EAST,NORTH,WIDTH with less land"
    );
    match format {
        PictureFormat::GeoTiff => bail!("cannot write {output}: {cause}"),
        _ => tracing::warn!("{output}: written without a place on the earth, since {cause}"),
    }
    Ok(None)
}

/// Returns the paths of the sidecar files that a map writes, for the check that no output replaces an input.
pub(super) fn side_paths(args: &RenderArgs, kind: &OutputKind) -> Vec<PathBuf> {
    match (kind, args.map) {
        (OutputKind::Picture(PictureFormat::Png | PictureFormat::Jpg), Some(_)) => {
            vec![world_file_path(&args.output), aux_path(&args.output)]
        }
        _ => Vec::new(),
    }
}

/// Returns the world file and the `.aux.xml` of a picture. [`unnamed::check_beside`] decides whether they may be
/// written.
fn side_files(output: &Path, georeference: &Georeference) -> Vec<SideFile> {
    let [x0, x_column, x_row, y0, y_column, y_row] = georeference.crs_from_grid;
    // In ESRI's order; the position is that of the first pixel's centre.
    let world_file = [x_column, y_column, x_row, y_row, x0, y0].map(|number| format!("{number}\n")).concat();
    let mut files = vec![SideFile { path: world_file_path(output), text: world_file }];
    let path = aux_path(output);
    match georeference.wkt() {
        Some(wkt) => files.push(SideFile { path, text: aux_text(&wkt) }),
        // One that hachure wrote is removed.
        None if path.exists() && unnamed::own_beside(output, [path.clone()]).is_empty() => {
            tracing::warn!(
                "{}: belongs to another map; the reference system of this map cannot be written as WKT",
                named(&path)
            );
        }
        None if georeference.crs == Crs::Local => tracing::warn!(
            "{}: not written, because the heights have no reference system; the world file counts metres",
            named(&path)
        ),
        None => tracing::warn!(
            "{}: not written, because the reference system {} cannot be written as WKT; the world file counts in \
             its units",
            named(&path),
            shown(match &georeference.crs {
                Crs::Projected { name, .. } | Crs::Geographic { name, .. } => name,
                Crs::Local => "of the DEM",
            })
        ),
    }
    files
}

/// Sidecar files of a picture, complete but not yet renamed to their final names.
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

    /// Renames the files to their final names, unless the user put files there meanwhile, and removes those of the
    /// picture that is replaced.
    pub(super) fn commit(self) -> Result<(), FileError> {
        let (files, written): (Vec<_>, Vec<_>) = self.files.into_iter().unzip();
        unnamed::check_beside(self.picture, &files, self.overwrite)?;
        let name = |(file, written): (&SideFile, AtomicFile)| {
            written.commit().map_err(|error| FileError::write(&file.path, error))
        };
        // The picture that is replaced may have been a map. Its files would place the new picture on the earth.
        let [world_file, aux] = [world_file_path(self.picture), aux_path(self.picture)];
        let is_old = |path: &PathBuf| files.iter().all(|file| file.path != *path);
        let old = unnamed::own_beside(self.picture, [world_file, aux].into_iter().filter(is_old));
        files.iter().zip(written).try_for_each(name)?;
        old.iter().try_for_each(|path| std::fs::remove_file(path).map_err(|error| FileError::write(path, error)))
    }
}

/// Returns the text of an `.aux.xml` (GDAL's PAM). Without `dataAxisToSRSAxisMapping`, east comes before north, as in
/// the world file.
fn aux_text(wkt: &str) -> String {
    let (wkt, version) = (escaped(wkt), env!("CARGO_PKG_VERSION"));
    format!(
        "<PAMDataset>\n  <SRS>{wkt}</SRS>\n  <Metadata>\n    <MDI key=\"Software\">hachure {version}</MDI>\n  \
         </Metadata>\n</PAMDataset>\n"
    )
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
}
