//! `render --like FILE`: draws a picture again by the description in its file; options on the command line take
//! precedence.
//!
//! An imprint may come from a stranger. Its numbers have the ranges of the command line ([`Imprint::parse`]), its texts
//! are parsed by the options' own parsers, and the errors of files that it names do not quote them ([`Names`]).

mod names;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::{Context, anyhow, bail};
use clap::{Parser, ValueEnum};

pub(super) use names::Names;

use super::RenderArgs;
use super::names::NamesArgs;
use crate::commands::misuse::Misuse;
use crate::commands::program::{Cli, Command};
use crate::commands::world_args::WorldArgs;
use crate::file::message::named;
use crate::file::pattern::{OutputKind, PictureFormat};
use crate::frame::Antialias;
use crate::picture::imprint::{Imprint, More};
use crate::scene::camera::Camera;
use crate::scene::map::MapArea;
use crate::scene::ranges;
use crate::scene::view::Clock;
use crate::source::{Encoding, HeightUnit, TileRows, VoidMode};
use crate::style::Style;
use crate::style::scale::REFERENCE_DPI;

/// Returns the arguments, completed with values from the picture.
///
/// # Errors
/// Fails if the picture's world is a URL without `--trust-scene`, or if a value is not valid for its option.
pub(super) fn with_imprint(args: &RenderArgs, kind: &OutputKind, imprint: &Imprint) -> anyhow::Result<RenderArgs> {
    let mut all = args.clone();
    let Imprint { world, sun, size_px, dpi, more, .. } = imprint;
    if all.world.name.is_none() {
        if world.as_ref().is_some_and(|world| world.contains("://")) && !args.world.trust_scene {
            bail!("its world is a URL; --trust-scene allows it");
        }
        all.world.name.clone_from(world);
    }
    view_over(&mut all, kind, imprint)?;
    // --side-light turns the sun about, and leaves its elevation.
    if all.world.light.date.is_none() {
        all.world.light.sun = all.world.light.sun.or(Some(*sun));
    }
    all.world.exaggeration = all.world.exaggeration.or(more.exaggeration);
    all.world.light.haze = all.world.light.haze.or(more.haze);
    all.world.water.water = all.world.water.water.or_else(|| more.water.as_ref().map(PathBuf::from));
    if all.world.layers.layer.is_empty() {
        all.world.layers.layer = more.layers.iter().flatten().map(PathBuf::from).collect();
    }
    if all.world.layers.drape.is_empty() {
        all.world.layers.drape = more.drape.iter().flatten().map(PathBuf::from).collect();
    }
    let graticule = &mut all.world.layers.graticule;
    *graticule = parsed_or(*graticule, more.graticule.as_deref(), "graticule")?;
    let land = &mut all.world.land;
    // A seed is that of the picture's world.
    if args.world.name.is_none() {
        land.seed = land.seed.or(more.seed);
    }
    land.sea_level = parsed_or(land.sea_level, more.sea_level.as_deref(), "sea_level")?;
    land.trees = parsed_or(land.trees, more.trees.as_deref(), "trees")?;
    all.world.light.focus = parsed_or(all.world.light.focus, more.focus.as_deref(), "focus")?;
    if all.size.is_none() {
        // A higher resolution means more pixels: the size of the print stays the same.
        let finer = all.dpi.map_or(1.0, |asked| asked / dpi.unwrap_or(REFERENCE_DPI));
        let side_px = |side: u32| (f64::from(side) * finer).round().max(1.0);
        if let Some(side) = size_px.iter().find(|side| !ranges::SIDE_PX.holds(side_px(**side))) {
            return Err(Misuse(format!("--dpi: a side of {:.0} pixels is too long", side_px(*side))).into());
        }
        all.size = Some(size_px.map(|side| side_px(side) as u32));
    }
    all.dpi = all.dpi.or(*dpi);
    if !matches!(kind, OutputKind::Picture(PictureFormat::GeoJson)) {
        all.title = all.title.or_else(|| more.title.clone());
        all.legend |= all.title.is_some() && more.legend.unwrap_or(false);
        all.credits = all.credits.or_else(|| more.credits.clone());
        all.frame |= all.map.is_some() && more.frame.unwrap_or(false);
    }
    all.samples = all.samples.or(more.samples);
    let curve = more.tone_curve.as_deref().filter(|_| keeps_tones(args));
    all.tone_curve = parsed_or(all.tone_curve, curve, "tone_curve")?;
    all.lod_error = all.lod_error.or(more.lod_error);
    all.tile_memory = all.tile_memory.or(more.tile_memory);
    let heights = &mut all.world.heights;
    heights.nodata = heights.nodata.or(more.nodata);
    if let (None, Some(name)) = (heights.encoding, &more.encoding) {
        let known = Encoding::ALL.into_iter().find(|encoding| encoding.name() == name);
        heights.encoding = Some(known.context("its height encoding is unknown")?);
    }
    if let (None, Some(name)) = (heights.voids, &more.voids) {
        heights.voids = Some(VoidMode::from_str(name, false).map_err(anyhow::Error::msg).context("voids")?);
    }
    heights.height_scale = heights.height_scale.or(more.height_scale);
    heights.height_offset = heights.height_offset.or(more.height_offset);
    if let (None, Some(name)) = (heights.height_unit, &more.height_unit) {
        let known = HeightUnit::ALL.into_iter().find(|unit| unit.name() == name);
        heights.height_unit = Some(known.context("its unit of heights is unknown")?);
    }
    if let (None, Some(name)) = (heights.tile_rows, &more.tile_rows) {
        let known = TileRows::ALL.into_iter().find(|rows| rows.name() == name);
        heights.tile_rows = Some(known.context("its rows of tiles are unknown")?);
    }
    if let (None, None, Some(eyes)) = (all.stereo.eyes, all.map, &more.eyes) {
        all.stereo.eyes = Some(eyes.parse().map_err(anyhow::Error::msg).context("eyes")?);
        all.stereo.ipd = parsed_or(all.stereo.ipd, more.ipd.as_deref(), "ipd")?;
        all.stereo.convergence = all.stereo.convergence.or(more.convergence);
    }
    let format = kind.picture_format();
    match format {
        Some(PictureFormat::Png | PictureFormat::Exr) if all.aov.is_empty() && all.path.is_none() => {
            all.show = all.show.or_else(|| more.show.clone());
        }
        _ if kind.is_drawing() => {
            all.paper = all.paper.or_else(|| more.paper.clone());
            all.margin = all.margin.or(more.margin);
        }
        _ => {}
    }
    if super::names::without_labels(&all, kind).is_none() {
        all.labels = all.labels.or(more);
        all.saddles = all.saddles.or(more.saddles.filter(|_| all.map.is_some()));
        all.lakes = all.lakes.or(more.lakes.filter(|_| all.map.is_some()));
    }
    if kind.is_drawing() || format == Some(PictureFormat::GeoJson) {
        all.tolerance_px = all.tolerance_px.or(more.tolerance_px);
        all.pens = all.pens.or(more.pens);
    }
    Ok(all)
}

/// Returns whether the arguments leave the view, the light and the style of the picture as they are, so that the curve of
/// its tones still fits.
fn keeps_tones(args: &RenderArgs) -> bool {
    let RenderArgs { world, camera, look, map, map_place, path, .. } = args;
    let WorldArgs { name, light, land, exaggeration, water, .. } = world;
    let is_placed = look.look_at.is_none() && map.is_none() && map_place.at.is_none();
    let is_seen = camera.is_none() && is_placed && path.is_none();
    let is_lit = light.sun.is_none() && light.side_light.is_none() && light.date.is_none() && light.focus.is_none();
    let is_grown = land.sea_level.is_none() && land.trees.is_none() && land.seed.is_none() && water.water.is_none();
    let is_there = name.is_none() && exaggeration.is_none() && is_grown;
    is_seen && is_lit && is_there && light.haze.is_none() && args.style.is_none() && args.set.is_empty()
}

/// Completes the options of a picture's view: its camera, map and time, or the camera path of several pictures.
fn view_over(all: &mut RenderArgs, kind: &OutputKind, imprint: &Imprint) -> anyhow::Result<()> {
    let more = &imprint.more;
    let antialias = parsed_or(None, more.antialias.as_deref(), "antialias")?;
    if !matches!(kind, OutputKind::Picture(_)) {
        if let (None, Some(path)) = (&all.path, &more.path) {
            let given = [
                ("--camera", all.camera.is_some()),
                ("--look-at", all.look.look_at.is_some()),
                ("--map", all.map.is_some()),
                ("--time-s", all.time_s.is_some()),
            ];
            if let Some((option, _)) = given.into_iter().find(|(_, is_given)| *is_given) {
                return Err(Misuse(format!("{option}: its path has cameras and times of its own")).into());
            }
            all.path = Some(PathBuf::from(path));
            all.fps = all.fps.or(more.fps);
            if all.frames.is_none() {
                all.frames = parsed_or(None, more.frames.as_deref(), "frames")?;
                all.warm_up = all.warm_up.or(more.warm_up);
            }
        }
        all.antialias = all.antialias.or(antialias);
        return Ok(());
    }
    if all.path.is_some() {
        return Ok(());
    }
    if antialias.is_some_and(|antialias| antialias != Antialias::None) && all.antialias.is_none() {
        tracing::warn!("--like: the edges of its frames are smoothed by --antialias; a single picture's are not");
    }
    if all.camera.is_none() && all.look.look_at.is_none() {
        // A map of the command line may have a width. Lines on the earth and pictures without a size on paper have no
        // scale; they show the area of the imprint.
        let has_paper = all.paper.is_some() || all.dpi.is_some();
        // A centre alone (--map=EAST,NORTH) takes the scale of the imprint, or its width.
        if matches!(all.map, None | Some(MapArea::At { .. })) {
            let recorded: Option<MapArea> = parsed_or(None, more.map.as_deref(), "map")?;
            let has_width = matches!(recorded, Some(MapArea::Around { .. }));
            if (has_paper || !has_width) && !matches!(kind, OutputKind::Picture(PictureFormat::GeoJson)) {
                all.map_scale = all.map_scale.or(more.map_scale);
            }
            all.map = match (all.map, recorded) {
                (Some(MapArea::At { centre_m }), Some(MapArea::Around { width_m, .. })) if all.map_scale.is_none() => {
                    Some(MapArea::Around { centre_m, width_m })
                }
                (given, recorded) => given.or(recorded),
            };
        }
    }
    if all.map.is_none() && all.look.look_at.is_none() {
        all.camera = all.camera.or(Some(imprint.camera));
    }
    all.time_s = all.time_s.or(more.time_s);
    Ok(())
}

/// Returns the given value, or else that of the imprint's text for the option `name`.
fn parsed_or<T: FromStr<Err = String>>(
    given: Option<T>,
    text: Option<&str>,
    name: &'static str,
) -> anyhow::Result<Option<T>> {
    match (given, text) {
        (None, Some(text)) => Ok(Some(text.parse().map_err(anyhow::Error::msg).context(name)?)),
        (given, _) => Ok(given),
    }
}

/// Returns the part of a description that the options of a world determine.
pub(crate) fn of_world(world: &WorldArgs) -> More {
    let voids = world.heights.voids.and_then(|voids| voids.to_possible_value());
    let names = |files: &[PathBuf]| -> Option<Vec<String>> {
        let names = files.iter().map(|path| path.to_string_lossy().into_owned());
        (!files.is_empty()).then(|| names.collect())
    };
    More {
        nodata: world.heights.nodata,
        voids: voids.map(|voids| voids.get_name().to_owned()),
        encoding: world.heights.encoding.map(|encoding| encoding.name().to_owned()),
        height_scale: world.heights.height_scale,
        height_offset: world.heights.height_offset,
        height_unit: world.heights.height_unit.map(|unit| unit.name().to_owned()),
        tile_rows: world.heights.tile_rows.map(|rows| rows.name().to_owned()),
        focus: world.light.focus.map(|focus| focus.to_string()),
        haze: world.light.haze,
        water: world.water.water.as_ref().map(|path| path.to_string_lossy().into_owned()),
        layers: names(&world.layers.layer),
        drape: names(&world.layers.drape),
        graticule: world.layers.graticule.map(|graticule| graticule.to_string()),
        exaggeration: world.exaggeration,
        sea_level: world.land.sea_level.map(|level| level.to_string()),
        trees: world.land.trees.map(|trees| trees.to_string()),
        seed: world.land.seed,
        ..More::default()
    }
}

/// Returns the description of the picture that these arguments draw; camera and time are set later.
pub(super) fn imprint(args: &RenderArgs, kind: &OutputKind, style: &Style, camera: &Camera) -> Imprint {
    let is_svg = kind.is_drawing();
    let mut imprint = Imprint {
        world: args.world.name.clone(),
        camera: *camera,
        sun: args.world.light.sun.unwrap_or_default(),
        style: style.clone(),
        size_px: args.size(),
        dpi: args.dpi,
        more: of_world(&args.world),
    };
    let more = &mut imprint.more;
    more.samples = args.samples.filter(|samples| *samples != 1);
    more.lod_error = args.lod_error.filter(|error| *error != 1.0);
    more.tile_memory = args.tile_memory.filter(|mib| *mib != super::TILE_MEMORY_MIB);
    more.eyes = args.stereo.eyes.map(|eyes| eyes.to_string()).filter(|eyes| eyes != "mono");
    more.ipd = args.stereo.ipd.map(|ipd| ipd.to_string());
    more.convergence = args.stereo.convergence;
    more.show.clone_from(&args.show);
    more.tone_curve = args.tone_curve.map(|curve| curve.to_string());
    more.title.clone_from(&args.title);
    more.credits.clone_from(&args.credits);
    more.map_scale = args.map_scale;
    (more.saddles, more.lakes) = (args.saddles, args.lakes);
    let NamesArgs { peaks, names, name_layer, name_when, name_field } = args.labels.clone();
    (more.peaks, more.name_layer, more.name_when, more.name_field) = (peaks, name_layer, name_when, name_field);
    more.names = names.map(|file| file.to_string_lossy().into_owned());
    more.legend = args.legend.then_some(true);
    more.frame = args.frame.then_some(true);
    more.map = args.map.map(|map| map.to_string());
    if is_svg {
        more.paper.clone_from(&args.paper);
        (more.margin, more.tolerance_px, more.pens) = (args.margin, args.tolerance_px, args.pens);
    }
    if !matches!(kind, OutputKind::Picture(_)) {
        more.path = args.path.as_ref().map(|path| path.to_string_lossy().into_owned());
        more.fps = Some(args.fps());
        more.antialias =
            Some(args.antialias()).filter(|by| *by != Antialias::None).map(|antialias| antialias.to_string());
        more.frames = args.frames.map(|frames| frames.to_string());
        more.warm_up = args.warm_up;
    }
    imprint
}

/// Returns the text of the description, with the camera and time of one picture of several.
pub(super) fn text_at(imprint: &Imprint, camera: &Camera, clock: Clock) -> String {
    let mut imprint = Imprint { camera: *camera, ..imprint.clone() };
    imprint.more.time_s = Some(clock.now_s).filter(|now_s| *now_s != 0.0);
    imprint.text()
}

/// The style and the file names that come from the picture of `--like`.
#[derive(Clone, Debug, Default)]
pub(super) struct Liked {
    /// The style, unless `--style` is given.
    pub(super) style: Option<Style>,
    /// The files that only the imprint names.
    pub(super) names: Names,
}

/// Returns the arguments, completed by the picture of `--like`, and what else comes from there.
///
/// # Errors
/// Returns one line that names the picture and the cause.
pub(super) fn resolved(args: &RenderArgs, kind: &OutputKind) -> anyhow::Result<(RenderArgs, Liked)> {
    let Some(like) = &args.like else { return Ok((args.clone(), Liked::default())) };
    let imprint = Imprint::read(like)?;
    let all = with_imprint(args, kind, &imprint).map_err(|error| match error.downcast::<Misuse>() {
        Ok(Misuse(cause)) => Misuse(format!("{}: {cause}", named(like))).into(),
        Err(error) => error.context(named(like)),
    })?;
    if let (None, Some(world)) = (args.world.name(), all.world.name()) {
        super::arguments::check_world(Some(world)).map_err(|error| {
            anyhow!("{0}: its world {error}; name it: hachure render WORLD --like {0} …", named(like))
        })?;
    }
    let water = all.world.water.water.as_ref().filter(|_| args.world.water.water.is_none());
    let world = all.world.name().map(PathBuf::from).filter(|_| args.world.name.is_none());
    let names = Names {
        like: like.clone(),
        world,
        water: water.cloned(),
        layers: if args.world.layers.layer.is_empty() { all.world.layers.layer.clone() } else { Vec::new() },
        images: if args.world.layers.drape.is_empty() { all.world.layers.drape.clone() } else { Vec::new() },
        path: all.path.clone().filter(|_| args.path.is_none()),
        labels: all.labels.names.clone().filter(|_| args.labels.names.is_none()),
    };
    Ok((all, Liked { style: args.style.is_none().then_some(imprint.style), names }))
}

/// Reads the imprint of a picture for each kind of output, and checks the arguments up to where the world is opened.
///
/// # Errors
/// The errors of the imprint, which name the picture. An option that does not suit an output is not an error.
pub fn check_like(picture: &Path) -> anyhow::Result<()> {
    let like = picture.to_string_lossy();
    for output in ["a.png", "a.svg", "a%d.exr", "a.mp4", "a.geojson"] {
        let cli = Cli::try_parse_from(["hachure", "render", "--like", &like, "-o", output])?;
        let Some(Command::Render(args)) = &cli.command else { continue };
        let kind = OutputKind::of(&args.output).map_err(Misuse::of)?;
        let (args, liked) = resolved(args, &kind)?;
        let Some(style) = liked.style.map(|style| style.scaled(args.px_per_style_px())) else { continue };
        let svg = super::vector::SvgOptions::new(&args, &kind, &style).ok().flatten();
        let _ = super::sheets::plan(&args, &kind, args.size_of_all(), svg.as_ref());
        let _ = super::title::with_foot(style, &args, &kind);
        let _ = (
            super::map::check(&args, &kind),
            super::names::check(&args, &kind),
            super::show::check(&args, &kind),
            args.stereo.check(),
        );
        liked.names.world(args.world.scene())?;
    }
    Ok(())
}
