//! `render --like FILE`: draws a picture again by the description in its file; options on the command line take
//! precedence.

use std::path::PathBuf;

use anyhow::{Context, bail};

use super::RenderArgs;
use crate::file::message::named;
use crate::file::pattern::{OutputKind, PictureFormat};
use crate::picture::imprint::Imprint;
use crate::scene::camera::Camera;
use crate::scene::view::Clock;
use crate::source::Encoding;
use crate::style::Style;
use crate::style::scale::REFERENCE_DPI;

/// Returns the arguments, completed with values from the picture.
///
/// # Errors
/// Fails if the picture's world is a URL without `--trust-scene`, or if a value is not valid for its option.
pub(super) fn over(args: &RenderArgs, kind: &OutputKind, imprint: &Imprint) -> anyhow::Result<RenderArgs> {
    let mut all = args.clone();
    let Imprint { world, camera, sun, size_px, dpi, more, .. } = imprint;
    if all.world.name.is_none() {
        if world.as_ref().is_some_and(|world| world.contains("://")) && !args.world.trust_scene {
            bail!("its world is a URL; --trust-scene allows it");
        }
        all.world.name.clone_from(world);
    }
    let is_picture = matches!(kind, OutputKind::Picture(_));
    if is_picture && all.path.is_none() {
        if all.camera.is_none() && all.map.is_none() {
            let map = more.map.as_ref().map(|map| map.parse().map_err(anyhow::Error::msg).context("map"));
            all.map = map.transpose()?;
        }
        if all.map.is_none() {
            all.camera = all.camera.or(Some(*camera));
        }
        all.time_s = all.time_s.or(more.time_s);
    }
    if !is_picture && all.path.is_none() {
        all.path = more.path.as_ref().map(PathBuf::from);
        all.fps = all.fps.or(more.fps);
    }
    if all.world.light.date.is_none() && all.world.light.side_light.is_none() {
        all.world.light.sun = all.world.light.sun.or(Some(*sun));
    }
    all.world.water.water = all.world.water.water.or_else(|| more.water.as_ref().map(PathBuf::from));
    if let (None, Some(text)) = (all.world.light.focus, &more.focus) {
        all.world.light.focus = Some(text.parse().map_err(anyhow::Error::msg).context("focus")?);
    }
    if all.size.is_none() {
        // A higher resolution means more pixels: the size of the print stays the same.
        let finer = all.dpi.map_or(1.0, |asked| asked / dpi.unwrap_or(REFERENCE_DPI));
        all.size = Some(size_px.map(|side| ((f64::from(side) * finer).round() as u32).clamp(1, 1 << 20)));
    }
    all.dpi = all.dpi.or(*dpi);
    if !matches!(kind, OutputKind::Picture(PictureFormat::GeoJson)) {
        all.title = all.title.or_else(|| more.title.clone());
    }
    all.samples = all.samples.or(more.samples);
    all.lod_error = all.lod_error.or(more.lod_error);
    all.world.heights.nodata = all.world.heights.nodata.or(more.nodata);
    if let (None, Some(name)) = (all.world.heights.encoding, &more.encoding) {
        let known = Encoding::ALL.into_iter().find(|encoding| encoding.name() == name);
        all.world.heights.encoding = Some(known.context("its height encoding is unknown")?);
    }
    if let (None, None, Some(eyes)) = (all.stereo.eyes, all.map, &more.eyes) {
        all.stereo.eyes = Some(eyes.parse().map_err(anyhow::Error::msg).context("eyes")?);
        let ipd = more.ipd.as_ref().map(|ipd| ipd.parse().map_err(anyhow::Error::msg).context("ipd"));
        all.stereo.ipd = all.stereo.ipd.or(ipd.transpose()?);
        all.stereo.convergence = all.stereo.convergence.or(more.convergence);
    }
    match kind {
        OutputKind::Picture(PictureFormat::Png | PictureFormat::Exr) if all.aov.is_empty() => {
            all.show = all.show.or_else(|| more.show.clone());
        }
        OutputKind::Picture(PictureFormat::Svg) | OutputKind::Frames(_, PictureFormat::Svg) => {
            all.paper = all.paper.or_else(|| more.paper.clone());
            all.margin = all.margin.or(more.margin);
            all.tolerance_px = all.tolerance_px.or(more.tolerance_px);
            all.pens = all.pens.or(more.pens);
        }
        _ => {}
    }
    Ok(all)
}

/// Returns the description of the picture that these arguments draw; camera and time are set later.
pub(super) fn imprint(args: &RenderArgs, kind: &OutputKind, style: &Style, camera: &Camera) -> Imprint {
    let is_svg = matches!(kind, OutputKind::Picture(PictureFormat::Svg) | OutputKind::Frames(_, PictureFormat::Svg));
    let is_film = matches!(kind, OutputKind::Mp4);
    let mut imprint = Imprint {
        world: args.world.name.clone(),
        camera: *camera,
        sun: args.world.light.sun.unwrap_or_default(),
        style: style.clone(),
        size_px: args.size(),
        dpi: args.dpi,
        more: Default::default(),
    };
    let more = &mut imprint.more;
    more.samples = args.samples.filter(|samples| *samples != 1);
    more.lod_error = args.lod_error.filter(|error| *error != 1.0);
    more.nodata = args.world.heights.nodata;
    more.encoding = args.world.heights.encoding.map(|encoding| encoding.name().to_owned());
    more.eyes = args.stereo.eyes.map(|eyes| eyes.to_string()).filter(|eyes| eyes != "mono");
    more.ipd = args.stereo.ipd.map(|ipd| ipd.to_string());
    more.convergence = args.stereo.convergence;
    more.show.clone_from(&args.show);
    more.title.clone_from(&args.title);
    more.focus = args.world.light.focus.map(|focus| focus.to_string());
    more.water = args.world.water.water.as_ref().map(|path| path.to_string_lossy().into_owned());
    more.map = args.map.map(|map| map.to_string());
    if is_svg {
        more.paper.clone_from(&args.paper);
        (more.margin, more.tolerance_px, more.pens) = (args.margin, args.tolerance_px, args.pens);
    }
    if is_film {
        more.path = args.path.as_ref().map(|path| path.to_string_lossy().into_owned());
        more.fps = Some(args.fps());
    }
    imprint
}

/// Returns the text of the description, with the camera and time of one picture of several.
pub(super) fn text_at(imprint: &Imprint, camera: &Camera, clock: Clock) -> String {
    let mut imprint = Imprint { camera: *camera, ..imprint.clone() };
    imprint.more.time_s = Some(clock.now_s).filter(|now_s| *now_s != 0.0);
    imprint.text()
}

/// Returns the arguments, and the style if it comes from the picture of `--like`.
///
/// # Errors
/// Returns one line that names the picture and the cause.
pub(super) fn resolved(args: &RenderArgs, kind: &OutputKind) -> anyhow::Result<(RenderArgs, Option<Style>)> {
    let Some(like) = &args.like else { return Ok((args.clone(), None)) };
    let imprint = Imprint::read(like)?;
    let all = over(args, kind, &imprint).with_context(|| named(like))?;
    if let (None, Some(world)) = (args.world.name(), all.world.name()) {
        super::arguments::check_world(Some(world)).with_context(|| format!("{}: its world", named(like)))?;
    }
    Ok((all, args.style.is_none().then_some(imprint.style)))
}
