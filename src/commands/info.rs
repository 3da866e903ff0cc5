//! `hachure info`: recognises a file by its content and describes it: a DEM, a folder of DEMs, an address, a pyramid,
//! scene, style or camera path, a picture that hachure drew, water polygons, a model.

mod layers;
mod picture;
mod scene;
mod summits;
mod things;

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, bail};
use clap::Args;
use serde::Serialize;

use self::layers::LayersInfo;
use self::picture::PictureInfo;
use self::scene::SceneInfo;
use self::summits::PeaksArgs;
use self::things::{GeoJsonInfo, ModelInfo, PolygonInfo};
use super::describe::{Heights, Levels};
use super::height_args::HeightArgs;
use super::progress::Bar;
use super::{print, print_json, styles};
use crate::file::geojson::Summary;
use crate::file::imprint as stored;
use crate::file::input::{LARGEST_SCENE_BYTES, read_text};
use crate::file::message::{named, printable, shown};
use crate::file::toml_text;
use crate::peaks::Summit;
use crate::pyramid::Pyramid;
use crate::pyramid::format::sidecar_path;
use crate::remote;
use crate::scene::camera::Camera;
use crate::scene::embedded;
use crate::scene::path::CameraPath;
use crate::scene::reach::Reach;
use crate::scene::{Scene, World};
use crate::source::mosaic::Choice;
use crate::source::{self, Encoding, Kind, OpenOptions};
use crate::style::{Style, preset_text};
use crate::world;

/// Arguments of `info`.
#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// DEM, folder of DEMs or tiles, baked pyramid, URL, scene file, style file, camera path, picture that hachure
    /// drew, OBJ file, or features: GeoJSON, GPX, CSV, GeoPackage or FlatGeobuf; or the name of a built-in scene or
    /// path
    pub file: PathBuf,
    /// How to read height files.
    #[command(flatten)]
    pub heights: HeightArgs,
    /// Allow a scene file to name URLs and files outside its folder
    #[arg(long)]
    pub trust_scene: bool,
    #[command(flatten)]
    pub summits: PeaksArgs,
    /// Print the description as JSON
    #[arg(long)]
    pub json: bool,
}

/// Bytes at the start of a file that suffice to recognise it.
const HEAD_BYTES: u64 = 64 * 1024;
/// Largest number of files of a folder that are listed.
const MAX_NAMES: usize = 20;
/// Largest number of frames over which the length of a camera path is measured: over an hour at 30 per second.
const LENGTH_FRAMES: usize = 1 << 17;

#[derive(Serialize)]
struct Answer {
    file: PathBuf,
    #[serde(flatten)]
    info: Info,
    /// The most prominent summits, if they are listed.
    #[serde(skip_serializing_if = "Option::is_none")]
    peaks: Option<Vec<Summit>>,
}

#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
enum Info {
    Dem {
        /// Format of the file, such as "a GeoTIFF".
        format: &'static str,
        /// Encoding by which the colours of a picture are heights.
        encoding: Option<&'static str>,
        #[serde(flatten)]
        heights: Heights,
        /// Size of the file; `None` for a folder of tiles.
        file_bytes: Option<u64>,
        /// Why an existing tile sidecar does not make the file a pyramid.
        stale: Option<String>,
    },
    Pyramid {
        #[serde(flatten)]
        heights: Heights,
        #[serde(flatten)]
        levels: Levels,
    },
    /// A folder of height files.
    Folder {
        #[serde(flatten)]
        heights: Heights,
        members: Vec<PathBuf>,
        left_out: Vec<LeftOut>,
    },
    /// A DEM or pyramid on a server.
    Address {
        #[serde(flatten)]
        heights: Heights,
        levels: usize,
        /// Whether the errors of its tiles were measured, as in a baked pyramid.
        is_measured: bool,
    },
    Picture(Box<PictureInfo>),
    Polygons(PolygonInfo),
    /// Lines and points in a GeoJSON file, such as one that hachure wrote.
    Features(Summary),
    /// Points, lines and areas with attributes in a file of another format.
    Layers(LayersInfo),
    Model(ModelInfo),
    /// A list of positions of models.
    Positions {
        positions: usize,
    },
    Scene(SceneInfo),
    Style(StyleInfo),
    CameraPath(PathInfo),
}

/// A file of a folder that holds no heights of it.
#[derive(Serialize)]
struct LeftOut {
    file: PathBuf,
    why: String,
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
    let reach = Reach::trusting(args.trust_scene);
    let address = args.file.to_str().filter(|name| name.contains("://") && !args.file.exists());
    let (file, info) = match address {
        // A URL may contain a password or a key.
        Some(url) => (remote::name_of(url).into(), address_info(url, args)?),
        None => (args.file.clone(), look_at(&args.file, &args.heights.options(), reach)?),
    };
    let peaks = summits::found(args, &info)?;
    let answer = Answer { file, info, peaks };
    if let Info::Dem { heights, .. } | Info::Pyramid { heights, .. } = &answer.info
        && let Some(doubt) = heights.doubt()
    {
        tracing::warn!("{}: {doubt}", named(&answer.file));
    }
    if args.json {
        return print_json(&answer);
    }
    let least_m = args.summits.prominence.unwrap_or(0.0);
    let listed = answer.peaks.as_ref().map(|peaks| summits::text(peaks, least_m)).unwrap_or_default();
    print(&(answer.text() + &listed))
}

fn look_at(file: &Path, options: &OpenOptions, reach: Reach) -> anyhow::Result<Info> {
    if let Some(inside) = embedded::scene(&file.to_string_lossy()) {
        return Ok(Info::Scene(SceneInfo::of(inside.read()?)?));
    }
    if embedded::path(file).is_some() {
        return camera_path(file);
    }
    // Anything but a regular file must not be opened here: a pipe would wait forever. The height reader reports the
    // kind of file.
    let Ok(metadata) = std::fs::metadata(file) else {
        if let Some(preset) = file.to_str().filter(|name| preset_text(name).is_some()) {
            bail!("{preset}: a preset; see hachure styles show {preset}");
        }
        return dem(file, options, None);
    };
    if metadata.is_dir() && source::kind_of(file) == Kind::Folder {
        return folder(file, options);
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
    let text = String::from_utf8_lossy(&head);
    if is_camera_path(&text) {
        return camera_path(file);
    }
    if stored::may_have(&head)
        && let Some(picture) = picture::read(file)?
    {
        return Ok(Info::Picture(Box::new(picture)));
    }
    if layers::is_likely(&head) || layers::of_ending(file) {
        return layers::read(file).map(Info::Layers);
    }
    if is_geojson(file, &text) {
        return match things::geojson(file) {
            Ok(GeoJsonInfo::Polygons(polygons)) => Ok(Info::Polygons(polygons)),
            Ok(GeoJsonInfo::Features(found)) => Ok(Info::Features(found)),
            // One object per line.
            Err(error) => layers::read(file).map(Info::Layers).map_err(|_| error),
        };
    }
    let has_ending = |wanted: &str| file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(wanted));
    if has_ending("obj") {
        return things::model(file).map(Info::Model);
    }
    // Points of a complete grid are a DEM, as for `render`; a list of positions hardly ever is one.
    let is_grid = || source::format_name(file, options).is_ok_and(|format| format == "XYZ points");
    if has_ending("csv")
        && is_grid()
        && let Ok(info) = dem(file, options, None)
    {
        return Ok(info);
    }
    if has_ending("csv") {
        match (things::positions(file, &text), layers::read(file)) {
            (Ok(Some(positions)), _) => return Ok(Info::Positions { positions }),
            (_, Ok(found)) => return Ok(Info::Layers(found)),
            (Err(error), _) => return Err(error),
            (Ok(None), Err(_)) => {}
        }
    }
    if has_ending("tsv")
        && let Ok(found) = layers::read(file)
    {
        return Ok(Info::Layers(found));
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
            let pyramid = Arc::new(pyramid);
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
    if let (true, Some(no_data)) = (reader.has_unmatched_no_data(), options.no_data) {
        tracing::warn!("{}: no sample is {no_data}, so --nodata {no_data} changes nothing", named(file));
    }
    let of = || named(file);
    let metadata = std::fs::metadata(file).with_context(of)?;
    let file_bytes = metadata.is_file().then_some(metadata.len());
    let format = source::format_name(file, options)?;
    let encoding = reader.encoding().map(Encoding::name);
    Ok(Info::Dem {
        format,
        encoding,
        heights: Heights::of_reader(&*reader, statistics).with_context(of)?,
        file_bytes,
        stale,
    })
}

/// Describes the height files of a folder as one world.
fn folder(folder: &Path, options: &OpenOptions) -> anyhow::Result<Info> {
    let choice = Choice::of(&[folder.to_owned()], options)?;
    let reader = choice.open(options)?;
    let statistics = source::statistics(&*reader, folder, &Bar::default())?;
    let heights = Heights::of_reader(&*reader, statistics).with_context(|| named(folder))?;
    let pictures = source::folder::pictures(folder).into_iter().map(|(file, what)| (file, what.to_owned()));
    let left_out = choice.left_out.into_iter().chain(pictures).map(|(file, why)| LeftOut { file, why }).collect();
    Ok(Info::Folder { heights, members: choice.files, left_out })
}

/// Describes a DEM on a server, from a few of its tiles.
fn address_info(url: &str, args: &InfoArgs) -> anyhow::Result<Info> {
    let scene = args.heights.apply_to(Scene::of_world(World::Url(url.to_owned())));
    let store = world::open_store(&scene, &Bar::default())?;
    let heights = Heights::of_store(&store).with_context(|| named(remote::name_of(url)))?;
    Ok(Info::Address { heights, levels: store.levels().len(), is_measured: store.is_measured() })
}

/// Returns whether a file is GeoJSON: an object with a type of GeoJSON near its beginning.
fn is_geojson(file: &Path, head: &str) -> bool {
    let head = head.trim_start_matches('\u{feff}').trim_start();
    let is_named = file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("geojson"));
    let types = ["\"FeatureCollection\"", "\"Feature\"", "Polygon\"", "LineString\"", "\"GeometryCollection\""];
    head.starts_with('{') && (is_named || types.iter().any(|kind| head.contains(kind)))
}

/// Returns the fields of the first line that is not a comment, as CSV.
fn first_fields(head: &str) -> Option<Vec<String>> {
    let head = head.trim_start_matches('\u{feff}');
    let first = head.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#'))?;
    let mut reader = csv::ReaderBuilder::new().has_headers(false).trim(csv::Trim::All).from_reader(first.as_bytes());
    let record = reader.records().next()?.ok()?;
    Some(record.iter().map(str::to_owned).collect())
}

/// Returns whether the first line that is not a comment is the header of a camera path, or an attempt at one.
fn is_camera_path(head: &str) -> bool {
    first_fields(head).is_some_and(|fields| fields.iter().take(3).eq(["t", "x", "y"]))
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
    if ["tone", "lines", "paper", "extends"].into_iter().any(has) {
        let style = styles::read(file)?;
        return Ok(Some(Info::Style(StyleInfo {
            draws: draws(&style),
            name: style.name,
            description: style.description,
        })));
    }
    bail!("{}: this TOML file is neither a scene (no [world]) nor a style (no [tone] and no extends)", named(file));
}

/// Returns the elements of a style, in drawing order: its tones, then its ink layers from the bottom to the top.
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
            Info::Dem { format, encoding, heights, file_bytes, stale } => {
                let encoding = encoding.map(|name| format!(" of {name} colours")).unwrap_or_default();
                let size = file_bytes.map(|bytes| format!(", {:.2} MiB", bytes as f64 / f64::from(1 << 20)));
                let size = size.unwrap_or_default();
                let stale = stale.as_ref().map_or(String::new(), |cause| format!("note      {cause}\n"));
                let next = "it will be baked into the cache when first drawn";
                format!("{file}: {format}{encoding}{size}; {next}\n{}{stale}", heights.lines())
            }
            Info::Pyramid { heights, levels } => {
                format!("{file}: a baked pyramid\n{}{}", heights.lines(), levels.lines())
            }
            Info::Folder { heights, members, left_out } => {
                let names = members.iter().take(MAX_NAMES).map(|member| format!("file      {}\n", named(member)));
                let names: String = names.collect();
                let more = match members.len().saturating_sub(MAX_NAMES) {
                    0 => String::new(),
                    count => format!("file      and {count} more\n"),
                };
                let left_out =
                    left_out.iter().map(|LeftOut { file, why }| format!("left out  {}: {why}\n", named(file)));
                let plural = if members.len() == 1 { "" } else { "s" };
                let left_out: String = left_out.collect();
                let count = members.len();
                format!("{file}: a folder of {count} DEM{plural}\n{}{names}{more}{left_out}", heights.lines())
            }
            Info::Address { heights, levels, is_measured } => {
                let errors = if *is_measured { "measured" } else { "estimated" };
                let levels = format!("pyramid   {levels} levels, {errors} errors\n");
                format!("{file}: a DEM on a server; it is drawn without baking\n{}{levels}", heights.lines())
            }
            Info::Picture(picture) => picture.text(&file),
            Info::Polygons(polygons) => polygons.text(&file),
            Info::Layers(found) => found.text(&file),
            Info::Features(found) => things::features_text(&file, found),
            Info::Model(model) => model.text(&file),
            Info::Positions { positions } => format!("{file}: a list of {positions} positions of models\n"),
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
