//! `render --like FILE`: draws a picture again by the description in its file; options on the command line take
//! precedence.
//!
//! An imprint may come from a stranger. Its numbers have the ranges of the command line ([`Imprint::parse`]), its texts
//! are parsed by the options' own parsers, and the errors of files that it names do not quote them ([`Names`]).

use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::{Context, anyhow, bail};
use clap::{Parser, ValueEnum};

use super::RenderArgs;
use crate::commands::misuse::Misuse;
use crate::commands::program::{Cli, Command};
use crate::file::message::named;
use crate::file::pattern::{OutputKind, PictureFormat};
use crate::frame::Antialias;
use crate::picture::imprint::Imprint;
use crate::scene::camera::Camera;
use crate::scene::ranges;
use crate::scene::view::Clock;
use crate::source::{Encoding, HeightUnit, TileRows, VoidMode};
use crate::style::Style;
use crate::style::scale::REFERENCE_DPI;

/// Returns the arguments, completed with values from the picture.
///
/// # Errors
/// Fails if the picture's world is a URL without `--trust-scene`, or if a value is not valid for its option.
pub(super) fn over(args: &RenderArgs, kind: &OutputKind, imprint: &Imprint) -> anyhow::Result<RenderArgs> {
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
    all.world.water.water = all.world.water.water.or_else(|| more.water.as_ref().map(PathBuf::from));
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
    }
    all.samples = all.samples.or(more.samples);
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
    if kind.is_drawing() || format == Some(PictureFormat::GeoJson) {
        all.tolerance_px = all.tolerance_px.or(more.tolerance_px);
        all.pens = all.pens.or(more.pens);
    }
    Ok(all)
}

/// Completes what a picture shows from where: its camera, map and time, or the camera path of several.
fn view_over(all: &mut RenderArgs, kind: &OutputKind, imprint: &Imprint) -> anyhow::Result<()> {
    let more = &imprint.more;
    let antialias = parsed_or(None, more.antialias.as_deref(), "antialias")?;
    if !matches!(kind, OutputKind::Picture(_)) {
        if let (None, Some(path)) = (&all.path, &more.path) {
            let given =
                [("--camera", all.camera.is_some()), ("--map", all.map.is_some()), ("--time-s", all.time_s.is_some())];
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
    if all.camera.is_none() {
        all.map = parsed_or(all.map, more.map.as_deref(), "map")?;
    }
    if all.map.is_none() {
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
        more: Default::default(),
    };
    let more = &mut imprint.more;
    more.samples = args.samples.filter(|samples| *samples != 1);
    more.lod_error = args.lod_error.filter(|error| *error != 1.0);
    more.tile_memory = args.tile_memory.filter(|mib| *mib != super::TILE_MEMORY_MIB);
    more.nodata = args.world.heights.nodata;
    let voids = args.world.heights.voids.and_then(|voids| voids.to_possible_value());
    more.voids = voids.map(|voids| voids.get_name().to_owned());
    more.encoding = args.world.heights.encoding.map(|encoding| encoding.name().to_owned());
    more.height_scale = args.world.heights.height_scale;
    more.height_offset = args.world.heights.height_offset;
    more.height_unit = args.world.heights.height_unit.map(|unit| unit.name().to_owned());
    more.tile_rows = args.world.heights.tile_rows.map(|rows| rows.name().to_owned());
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

/// What comes from the picture of `--like`.
#[derive(Clone, Debug, Default)]
pub(super) struct Liked {
    /// The style, unless `--style` is given.
    pub(super) style: Option<Style>,
    /// The files that only the imprint names.
    pub(super) names: Names,
}

/// Files that an imprint names and the command line does not. Whoever made the picture may not be allowed to read them,
/// and hachure may run for somebody else who is. So an error never quotes them: it says only that the file is not
/// what it should be.
#[derive(Clone, Debug, Default)]
pub(super) struct Names {
    like: PathBuf,
    world: Option<PathBuf>,
    water: Option<PathBuf>,
    path: Option<PathBuf>,
}

impl Names {
    /// Replaces the error of a world that the imprint names, or of its water.
    pub(super) fn world<T, E: Into<anyhow::Error>>(&self, result: Result<T, E>) -> anyhow::Result<T> {
        let named = |(what, file): (&str, &Option<PathBuf>)| Some(format!("its {what} {}", named(file.as_ref()?)));
        let files: Vec<String> =
            [("world", &self.world), ("water", &self.water)].into_iter().filter_map(named).collect();
        self.hidden(result, &files.join(" or "), "as WORLD or by --water")
    }

    /// Replaces the error of a camera path that the imprint names.
    pub(super) fn path<T, E: Into<anyhow::Error>>(&self, result: Result<T, E>) -> anyhow::Result<T> {
        let file = self.path.as_ref().map(|file| format!("its path {}", named(file)));
        self.hidden(result, &file.unwrap_or_default(), "by --path")
    }

    fn hidden<T, E: Into<anyhow::Error>>(&self, result: Result<T, E>, files: &str, how: &str) -> anyhow::Result<T> {
        match files {
            "" => result.map_err(Into::into),
            _ => result.map_err(|_| {
                anyhow!("{}: {files} cannot be used; name it {how} on the command line to read why", named(&self.like))
            }),
        }
    }
}

/// Returns the arguments, completed by the picture of `--like`, and what else comes from there.
///
/// # Errors
/// Returns one line that names the picture and the cause.
pub(super) fn resolved(args: &RenderArgs, kind: &OutputKind) -> anyhow::Result<(RenderArgs, Liked)> {
    let Some(like) = &args.like else { return Ok((args.clone(), Liked::default())) };
    let imprint = Imprint::read(like)?;
    let all = over(args, kind, &imprint).map_err(|error| match error.downcast::<Misuse>() {
        Ok(Misuse(cause)) => Misuse(format!("{}: {cause}", named(like))).into(),
        Err(error) => error.context(named(like)),
    })?;
    if let (None, Some(world)) = (args.world.name(), all.world.name()) {
        super::arguments::check_world(Some(world)).with_context(|| format!("{}: its world", named(like)))?;
    }
    let water = all.world.water.water.as_ref().filter(|_| args.world.water.water.is_none());
    let world = all.world.name().map(PathBuf::from).filter(|_| args.world.name.is_none());
    let names = Names {
        like: like.clone(),
        world,
        water: water.cloned(),
        path: all.path.clone().filter(|_| args.path.is_none()),
    };
    Ok((all, Liked { style: args.style.is_none().then_some(imprint.style), names }))
}

/// Reads the imprint of a picture for each kind of output, and checks the arguments up to where the world is opened.
///
/// # Errors
/// Those of the imprint, which name the picture. What does not suit an output is not one.
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
        let _ = (super::map::check(&args, &kind), super::show::check(&args, &kind), args.stereo.check());
        liked.names.world(args.world.scene())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by it")]

    use std::collections::BTreeSet;

    use clap::CommandFactory;

    use super::*;
    use crate::commands::arguments;
    use crate::commands::render::paper;
    use crate::commands::world_args::WorldArgs;

    /// What `--like` does with an option.
    enum Fate {
        /// The imprint contains it: the arguments of a picture with it.
        Kept(&'static str),
        /// It becomes another option, which the imprint contains.
        Becomes(&'static str),
        /// The picture does not depend on it; `tests/imprint.rs` draws with it and without.
        Unneeded,
    }

    use Fate::{Becomes, Kept, Unneeded};

    /// Every option of `render` by its id. A new one has to be added here: it is kept, or does not change the picture.
    const OPTIONS: &[(&str, Fate)] = &[
        ("world", Kept("other.tif -o a.png")),
        ("encoding", Kept("--encoding mapbox -o a.png")),
        ("height_scale", Kept("--height-scale 0.5 -o a.png")),
        ("height_offset", Kept("--height-offset=-3 -o a.png")),
        ("height_unit", Kept("--height-unit us-ft -o a.png")),
        ("tile_rows", Kept("--tile-rows tms -o a.png")),
        ("nodata", Kept("--nodata=-7.5 -o a.png")),
        ("voids", Kept("--voids holes -o a.png")),
        ("sun", Kept("--sun 100,20 -o a.png")),
        ("side_light", Becomes("sun")),
        ("date", Becomes("sun")),
        ("place", Becomes("sun")),
        ("focus", Kept("--focus 1,2,300,0.5 -o a.png")),
        ("water", Kept("--water lake.geojson -o a.png")),
        ("trust_scene", Unneeded),
        ("output", Unneeded),
        ("like", Unneeded),
        ("style", Kept("--style wash -o a.png")),
        ("size", Kept("--size 64x36 -o a.png")),
        ("dpi", Kept("--dpi 150 -o a.png")),
        ("camera", Kept("--camera=5,6,+7,8,9,50 -o a.png")),
        ("map", Kept("--map 10,20,3000 -o a.png")),
        ("path", Kept("--path p.csv -o a.mp4")),
        ("fps", Kept("--path p.csv --fps 12.5 -o a%d.png")),
        ("frames", Kept("--path p.csv --frames 3..7 -o a%d.png")),
        ("warm_up", Kept("--path p.csv --frames 3..7 --warm-up 5 -o a%d.png")),
        ("time_s", Kept("--time-s 2.5 -o a.png")),
        ("eyes", Kept("--eyes anaglyph -o a.png")),
        ("ipd", Kept("--eyes left --ipd auto -o a.png")),
        ("convergence", Kept("--eyes left --convergence 70 -o a.png")),
        ("samples", Kept("--samples 4 -o a.exr")),
        ("antialias", Kept("--path p.csv --antialias temporal -o a%d.png")),
        ("lod_error", Kept("--lod-error 0.5 -o a.png")),
        ("aov", Unneeded),
        ("aov_names", Unneeded),
        ("show", Kept("--show lsa -o a.png")),
        ("title", Kept("--title T -o a.svg")),
        ("tile_memory", Kept("--tile-memory 3 -o a.png")),
        ("tolerance_px", Kept("--tolerance-px 0.5 -o a.svg")),
        ("paper", Kept("--paper a5 -o a.svg")),
        ("landscape", Becomes("size")),
        ("portrait", Becomes("size")),
        ("margin", Kept("--paper a5 --margin 3 -o a.svg")),
        ("sheets", Unneeded),
        ("sheets_overlap", Unneeded),
        ("sheets_margin", Unneeded),
        ("pens", Kept("--pens 2 -o a.svg")),
        // A GeoJSON and a mesh have no imprint.
        ("wgs84", Unneeded),
        ("mesh_error", Unneeded),
        ("overwrite", Unneeded),
        ("json", Unneeded),
        // Of all commands. Another adapter rounds otherwise.
        ("adapter", Unneeded),
        ("verbose", Unneeded),
    ];

    fn parsed(line: &str) -> RenderArgs {
        let words = ["hachure", "render"].into_iter().chain(line.split(' '));
        match Cli::try_parse_from(words).unwrap().command {
            Some(Command::Render(args)) => *args,
            _ => panic!("{line}"),
        }
    }

    /// Returns what the arguments draw, as text. Without `..`, so that a new option is not forgotten.
    fn drawn(args: &RenderArgs) -> String {
        let RenderArgs {
            world: WorldArgs { name, heights, light, water, trust_scene: _ },
            output: _,
            like: _,
            style: _,
            size: _,
            dpi,
            camera,
            map,
            path,
            fps: _,
            frames,
            warm_up,
            wgs84: _,
            time_s,
            stereo,
            samples: _,
            antialias: _,
            lod_error: _,
            aov: _,
            aov_names: _,
            show,
            title,
            mesh_error: _,
            tile_memory: _,
            tolerance_px,
            paper,
            landscape: _,
            portrait: _,
            margin,
            sheets: _,
            pens,
            overwrite: _,
            json: _,
        } = args;
        let world = format!("{name:?} {heights:?} {:?} {:?} {water:?}", light.sun.unwrap_or_default(), light.focus);
        // The camera of frames is that of their path, and the similar one of a map is not used.
        let camera = camera.filter(|_| path.is_none() && map.is_none());
        let time_s = time_s.unwrap_or(0.0);
        let view = format!("{camera:?} {map:?} {path:?} {} {time_s} {stereo:?} {frames:?} {warm_up:?}", args.fps());
        let quality = format!("{} {:?} {} {}", args.samples(), args.antialias(), args.lod_error(), args.tile_memory());
        let page =
            format!("{:?} {dpi:?} {show:?} {title:?} {tolerance_px:?} {paper:?} {margin:?} {pens:?}", args.size());
        format!("{world}\n{view}\n{quality}\n{page}")
    }

    /// Returns what a line draws, and what `--like` draws with its imprint; both with the style.
    fn twice(line: &str) -> [String; 2] {
        let base = "w.tif --camera=0,0,+300,0,-5,50 ";
        let own = ["--camera", "--map", "--path"].iter().any(|option| line.contains(option));
        let base = if own { "w.tif " } else { base };
        let base = if line.starts_with("other.tif") { &base[6..] } else { base };
        let args = parsed(&format!("{base}{line}"));
        let kind = OutputKind::of(&args.output).unwrap();
        let args = paper::measured(&args, &kind).unwrap();
        let style = arguments::style(args.style.as_deref().unwrap_or("ink")).unwrap();
        let camera = args.camera.unwrap_or_else(|| "0,0,+300,0,-5,50".parse().unwrap());
        let text = text_at(&imprint(&args, &kind, &style, &camera), &camera, Clock::still(args.time_s.unwrap_or(0.0)));
        let read = Imprint::parse("a.png", &text).unwrap();
        let output = args.output.display();
        let all = over(&parsed(&format!("--like a.png -o {output}")), &kind, &read).unwrap();
        [drawn(&args) + &style.text(), drawn(&all) + &read.style.text()]
    }

    #[test]
    fn every_option_is_in_the_imprint_or_does_not_change_the_picture() {
        let program = Cli::command();
        let of_program = program.get_arguments().filter(|argument| argument.is_global_set());
        let of_render = program.find_subcommand("render").unwrap().get_arguments().chain(of_program);
        let found: BTreeSet<&str> = of_render.map(|argument| argument.get_id().as_str()).collect();
        let known: BTreeSet<&str> = OPTIONS.iter().map(|(id, _)| *id).collect();
        assert_eq!(found, known, "an option of render is not in the list of this test");
        for (id, fate) in OPTIONS {
            match fate {
                Kept(line) => {
                    let [args, again] = twice(line);
                    assert_eq!(args, again, "{id}: --like draws something else");
                    // Planted: the imprint of a picture without the option gives other arguments.
                    let words: Vec<&str> = line.split(' ').collect();
                    let output = words[words.len() - 1];
                    let without = match *id {
                        "fps" | "antialias" | "frames" | "warm_up" => format!("--path p.csv -o {output}"),
                        "ipd" | "convergence" => format!("--eyes left -o {output}"),
                        "margin" => format!("--paper a5 -o {output}"),
                        "path" => "--path q.csv -o a.mp4".to_owned(),
                        _ => format!("-o {output}"),
                    };
                    assert_ne!(twice(&without)[1], args, "{id}: the option must matter");
                }
                Becomes(other) => assert!(known.contains(other), "{id}"),
                Unneeded => {}
            }
        }
        let portrait = "--paper a5 --dpi 50 --portrait -o a.svg";
        assert!(
            twice(portrait)[0] == twice(portrait)[1]
                && twice(portrait)[1] != twice(&portrait.replace("--portrait ", ""))[1]
        );
    }

    #[test]
    fn numbers_of_an_imprint_have_the_ranges_of_the_command_line() {
        let args = parsed("w.tif --camera=0,0,+300,0,-5,50 -o a.png");
        let kind = OutputKind::of(&args.output).unwrap();
        let text = imprint(&args, &kind, &Style::load("plain").unwrap(), &args.camera.unwrap()).text();
        let with = |key: &str, value: &str| match key {
            "size" | "dpi" | "sun" | "camera" => {
                // Only the imprint's own key: the style has some of the same name.
                let own = text.lines().position(|line| line.starts_with(&format!("{key} = ")));
                let lines = text.lines().enumerate().filter(|(number, _)| Some(*number) != own);
                let lines: Vec<&str> = lines.map(|(_, line)| line).collect();
                Imprint::parse("a.png", &format!("{key} = {value}\n{}", lines.join("\n")))
            }
            _ => Imprint::parse("a.png", &format!("{text}\n[more]\n{key} = {value}\n")),
        };
        for (key, right, wrong) in [
            ("size", "[64, 36]", &["[0, 36]", "[64, 1048577]", "[64, -1]"][..]),
            ("dpi", "300.0", &["0.5", "nan", "inf", "10001.0"]),
            ("sun", "\"10,20\"", &["\"nan,20\"", "\"10,91\"", "\"10,inf\""]),
            ("camera", "\"0,0,10,0,0,50\"", &["\"0,0,nan,0,0,50\"", "\"0,0,10,0,0,0\"", "\"0,0,1e30,0,0,50\""]),
            ("time_s", "2.0", &["nan", "inf", "1e9"]),
            ("samples", "1024", &["0", "1025", "4294967295", "-1"]),
            ("lod_error", "0.5", &["0.0", "-1.0", "nan", "inf"]),
            ("nodata", "-9999.0", &["nan", "-inf"]),
            ("tile_memory", "1", &["0", "-1", "1048577"]),
            ("convergence", "5.0", &["0.0", "-1e300", "nan"]),
            ("margin", "0.0", &["-0.1", "nan", "1e6"]),
            ("tolerance_px", "0.5", &["0.0", "-1.0", "nan", "1e300"]),
            ("pens", "3", &["0", "4", "1000000000"]),
            ("fps", "1000.0", &["0.0", "inf", "1e300", "nan"]),
        ] {
            assert!(with(key, right).is_ok(), "{key} = {right}: {:?}", with(key, right));
            for value in wrong {
                let error = with(key, value).unwrap_err().to_string();
                assert!(error.contains(key) && !error.contains('\n'), "{key} = {value}: {error}");
            }
        }
        // Texts are parsed by the parsers of their options.
        for (key, wrong) in [
            ("voids", "deep"),
            ("focus", "1,2,nan"),
            ("map", "0,0,nan"),
            ("encoding", "x"),
            ("eyes", "three"),
            ("antialias", "much"),
        ] {
            let read = with(key, &format!("\"{wrong}\"")).unwrap();
            let error = over(&parsed("--like a.png -o b.png"), &kind, &read).unwrap_err();
            let error = crate::file::message::chain(error.as_ref());
            assert!(error.contains(key) || key == "encoding", "{key}: {error}");
        }
        let read = with("ipd", "\"-1\"\neyes = \"left\"").unwrap();
        assert!(over(&parsed("--like a.png -o b.png"), &kind, &read).is_err());
    }
}
