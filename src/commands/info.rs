//! `hachure info`: recognises a file by its content and describes it: a DEM, pyramid, scene, style or camera path.

mod scene;

use std::io::Read;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;
use serde::Serialize;

use self::scene::SceneInfo;
use super::describe::{Heights, Levels};
use super::height_args::HeightArgs;
use super::progress::Bar;
use super::{arguments, print, print_json, styles};
use crate::file::input::{LARGEST_SCENE_BYTES, read_text};
use crate::file::message::{named, printable, shown};
use crate::file::toml_text;
use crate::pyramid::Pyramid;
use crate::pyramid::format::sidecar_path;
use crate::scene::camera::Camera;
use crate::scene::embedded;
use crate::scene::path::CameraPath;
use crate::scene::reach::Reach;
use crate::source::{self, Kind, OpenOptions};
use crate::style::Style;

/// Arguments of `info`.
#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// DEM, baked pyramid, scene file, style file or camera path; or the name of a built-in scene or path
    pub file: PathBuf,
    /// How to read height files.
    #[command(flatten)]
    pub heights: HeightArgs,
    /// Allow a scene file to name URLs and files outside its folder
    #[arg(long)]
    pub trust_scene: bool,
    /// Print the description as JSON
    #[arg(long)]
    pub json: bool,
}

/// Bytes at the start of a file that suffice to recognise it.
const HEAD_BYTES: u64 = 64 * 1024;
/// Largest number of frames over which the length of a camera path is measured: over an hour at 30 per second.
const LENGTH_FRAMES: usize = 1 << 17;

#[derive(Serialize)]
struct Answer {
    file: PathBuf,
    #[serde(flatten)]
    info: Info,
}

#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
enum Info {
    Dem {
        #[serde(flatten)]
        heights: Heights,
        file_bytes: u64,
        /// Why an existing tile sidecar does not make the file a pyramid.
        stale: Option<String>,
    },
    Pyramid {
        #[serde(flatten)]
        heights: Heights,
        #[serde(flatten)]
        levels: Levels,
    },
    Scene(SceneInfo),
    Style(StyleInfo),
    CameraPath(PathInfo),
}

#[derive(Serialize)]
struct StyleInfo {
    name: String,
    description: String,
    /// Names of the parts that the style draws, in drawing order.
    draws: Vec<String>,
}

#[derive(Serialize)]
struct PathInfo {
    rows: usize,
    start_s: f64,
    duration_s: f64,
    /// Length over the ground in metres, summed over the frames at 30 per second.
    ground_length_m: f64,
    frames_at_30_fps: usize,
}

/// Runs the command.
///
/// # Errors
/// Fails if the file is none of these, or is invalid.
pub(crate) fn run(args: &InfoArgs) -> anyhow::Result<()> {
    arguments::check_local(&args.file, "info")?;
    let reach = Reach::trusting(args.trust_scene);
    let answer = Answer { info: look_at(&args.file, &args.heights.options(), reach)?, file: args.file.clone() };
    if let Info::Dem { heights, .. } | Info::Pyramid { heights, .. } = &answer.info
        && let Some(doubt) = heights.doubt()
    {
        tracing::warn!("{}: {doubt}", named(&args.file));
    }
    if args.json {
        return print_json(&answer);
    }
    print(&answer.text())
}

fn look_at(file: &Path, options: &OpenOptions, reach: Reach) -> anyhow::Result<Info> {
    if let Some(inside) = embedded::scene(&file.to_string_lossy()) {
        return Ok(Info::Scene(SceneInfo::of(inside.read()?)?));
    }
    if embedded::path(file).is_some() {
        return camera_path(file);
    }
    // Anything but a regular file must not be opened here: a pipe would wait forever. The height reader reports what it
    // is.
    let Ok(metadata) = std::fs::metadata(file) else { return dem(file, options, None) };
    if metadata.is_dir() && source::kind_of(file) == Kind::Folder {
        bail!("{}: is a folder; hachure info describes one file of it", named(file));
    }
    if !metadata.is_file() || metadata.len() == 0 {
        return dem(file, options, None);
    }
    let cannot_read = || format!("{}: cannot be read", named(file));
    let mut head = Vec::new();
    std::fs::File::open(file)
        .and_then(|opened| opened.take(HEAD_BYTES).read_to_end(&mut head))
        .with_context(cannot_read)?;
    if head.starts_with(b"HACHTILE") {
        bail!(
            "{}: holds the tile statistics of a pyramid; give the name of the pyramid itself, without .tiles",
            named(file)
        );
    }
    if is_camera_path(&String::from_utf8_lossy(&head)) {
        return camera_path(file);
    }
    let claims_toml = file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"));
    match read_text(file, LARGEST_SCENE_BYTES) {
        Ok(text) => {
            if let Some(info) = scene_or_style(file, &text, reach)? {
                return Ok(info);
            }
        }
        Err(cause) if claims_toml => bail!("{}: invalid TOML: {cause}", named(file)),
        Err(_) => {}
    }
    // The pyramid's heights are averages, so an additional no-data value no longer applies to them.
    if !sidecar_path(file).exists() || options.changes_heights() {
        return dem(file, options, None);
    }
    match Pyramid::open(file) {
        Ok(pyramid) => {
            let of = || named(file);
            let heights = Heights::of_pyramid(&pyramid).with_context(of)?;
            Ok(Info::Pyramid { heights, levels: Levels::of(&pyramid).with_context(of)? })
        }
        Err(error) if error.wants_bake() => dem(file, options, Some(error.to_string())),
        Err(error) => Err(error.into()),
    }
}

fn dem(file: &Path, options: &OpenOptions, stale: Option<String>) -> anyhow::Result<Info> {
    let reader = source::open_reader_with(file, options)?;
    let statistics = source::statistics(&*reader, file, &Bar::default())?;
    let of = || named(file);
    let file_bytes = std::fs::metadata(file).with_context(of)?.len();
    Ok(Info::Dem { heights: Heights::of_reader(&*reader, statistics).with_context(of)?, file_bytes, stale })
}

/// Returns whether the first line that is not a comment is the header of a camera path, or an attempt at one.
fn is_camera_path(head: &str) -> bool {
    let head = head.trim_start_matches('\u{feff}');
    let first = head.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#')).unwrap_or("");
    first.split(',').map(str::trim).take(3).eq(["t", "x", "y"])
}

fn camera_path(file: &Path) -> anyhow::Result<Info> {
    // Without a world the ground is level; nothing reported here depends on it.
    let path = CameraPath::read_on_ground(file, |_, _| 0.0)?;
    let mut ground_length_m = 0.0;
    let mut before = None;
    // Sampling a year of frames would take minutes; a subset suffices for a long path.
    let frames: Box<dyn Iterator<Item = Camera>> = match path.frame_count(30.0) {
        count if count <= LENGTH_FRAMES => Box::new(path.frames(30.0)),
        _ => Box::new(path.spread(LENGTH_FRAMES)),
    };
    for camera in frames {
        let here = camera.position_m.truncate();
        ground_length_m += before.replace(here).map_or(0.0, |before| here.distance(before));
    }
    Ok(Info::CameraPath(PathInfo {
        rows: path.times_s().len(),
        start_s: path.times_s()[0],
        duration_s: path.duration_s(),
        ground_length_m,
        frames_at_30_fps: path.frame_count(30.0),
    }))
}

/// Recognises a scene by its key `world` and a style by its key `tone`. Returns `None` if the text is not TOML and the
/// file's name does not end with .toml.
fn scene_or_style(file: &Path, text: &str, reach: Reach) -> anyhow::Result<Option<Info>> {
    let claims = file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"));
    let keys = match toml_text::keys(&file.to_string_lossy(), text) {
        // Text of only comments is TOML, but hardly meant to be.
        Ok(keys) if keys.is_empty() && !claims => return Ok(None),
        Ok(keys) => keys,
        Err(_) if !claims => return Ok(None),
        Err(error) => return Err(error.into()),
    };
    let has = |key: &str| keys.iter().any(|known| known == key);
    if has("world") {
        return scene::read(file, reach).map(Info::Scene).map(Some);
    }
    if ["tone", "lines", "paper"].into_iter().any(has) {
        let style = styles::read(file)?;
        return Ok(Some(Info::Style(StyleInfo {
            draws: draws(&style),
            name: style.name,
            description: style.description,
        })));
    }
    bail!("{}: this TOML file is neither a scene (no [world]) nor a style (no [tone])", named(file));
}

/// Returns what a style draws, in drawing order: its tones, then its ink layers from the bottom to the top.
fn draws(style: &Style) -> Vec<String> {
    let shadows = style.needs_horizons().then(|| "cast shadows and sky visibility".to_owned());
    let watercolor = style.watercolor.as_ref().map(|_| "watercolour".to_owned());
    let tones = [shadows, Some(format!("{} shading", style.tone.name())), watercolor];
    let layers = style.layers.iter().map(|layer| layer.behaviour().summary());
    tones.into_iter().chain(layers).flatten().collect()
}

impl Answer {
    /// Returns the description as text.
    fn text(&self) -> String {
        let file = named(&self.file);
        match &self.info {
            Info::Dem { heights, file_bytes, stale } => {
                let mebibytes = *file_bytes as f64 / f64::from(1 << 20);
                let stale = stale.as_ref().map_or(String::new(), |cause| format!("note      {cause}\n"));
                let next = "it will be baked into the cache when first drawn";
                format!("{file}: a DEM, {mebibytes:.2} MiB; {next}\n{}{stale}", heights.lines())
            }
            Info::Pyramid { heights, levels } => {
                format!("{file}: a baked pyramid\n{}{}", heights.lines(), levels.lines())
            }
            Info::Scene(scene) => scene.text(&file),
            Info::Style(StyleInfo { name, description, draws }) => {
                let (name, description) = (shown(name), printable(description, 400));
                format!("{file}: the style {name}: {description}\ndraws     {}\n", draws.join(", "))
            }
            Info::CameraPath(path) => format!(
                "{file}: a camera path\nrows      {}\ntime      {} s from t = {} s; {} frames at 30 fps\n\
                 length    {:.3} km over the ground\n",
                path.rows,
                path.duration_s,
                path.start_s,
                path.frames_at_30_fps,
                path.ground_length_m / 1000.0,
            ),
        }
    }
}
