//! Contents of exported files: each function says what is wrong with the files in a folder.
//!
//! `planted` is added to what is expected: with 1 instead of 0, each function must fail.

use std::path::Path;

use exr::prelude::MetaData;
use geotiff_reader::GeoTiffFile;
use hachure::file::imprint;
use hachure::file::png::read_rgba8;

/// The size of the pictures in pixels.
pub(crate) const SIZE_PX: [u32; 2] = [160, 100];
/// Number of frames of the film: four per second for a second, both ends included.
const FRAMES: u32 = 5;
/// The middle of the DEM, in its reference system.
const MIDDLE_M: [f64; 2] = [502_100.0, 4_998_200.0];
/// The same as longitude and latitude.
const MIDDLE_DEG: [f64; 2] = [-122.9733, 45.1374];

/// A function that says what is wrong.
pub(crate) type Check = fn(&Path, u32) -> Result<(), String>;

fn equal<T: PartialEq + std::fmt::Debug>(what: &str, found: &T, wanted: &T) -> Result<(), String> {
    if found == wanted { Ok(()) } else { Err(format!("{what}: {found:?}, not {wanted:?}")) }
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        folder.read_dir().unwrap().map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Reads a PNG and says whether it has a size, and a drawing on it.
fn png(path: &Path, size_px: [u32; 2]) -> Result<(), String> {
    let picture = read_rgba8(path).map_err(|error| error.to_string())?;
    equal("size", &[picture.width, picture.height], &size_px)?;
    let first = &picture.rgba[..4];
    let others = picture.rgba.chunks_exact(4).filter(|pixel| *pixel != first).count();
    if others > 200 { Ok(()) } else { Err(format!("{}: {others} pixels are not {first:?}", path.display())) }
}

pub(crate) fn picture(folder: &Path, planted: u32) -> Result<(), String> {
    equal("files", &names(folder), &vec!["a.png".to_owned()])?;
    png(&folder.join("a.png"), [SIZE_PX[0] + planted, SIZE_PX[1]])
}

/// 60 × 60 mm at 100 dots per inch, with a title.
pub(crate) fn titled_jpg(folder: &Path, planted: u32) -> Result<(), String> {
    let path = folder.join("a.jpg");
    let mut decoder = jpeg_decoder::Decoder::new(std::fs::File::open(&path).map_err(|error| error.to_string())?);
    let pixels = decoder.decode().map_err(|error| error.to_string())?;
    let info = decoder.info().unwrap();
    equal("size", &[info.width, info.height], &[236 + planted as u16, 236])?;
    equal("bytes", &pixels.len(), &(236 * 236 * 3))?;
    let imprint = imprint::read(&path).map_err(|error| error.to_string())?;
    equal("title", &imprint.contains("title = \"My hill\""), &true)
}

/// 120 × 90 mm at 40 dots per inch, on sheets of 80 × 80 mm that overlap by 10 mm: without two margins of 6 mm and as much
/// for crop marks, a sheet shows 56 mm.
pub(crate) fn sheets(folder: &Path, planted: u32) -> Result<(), String> {
    let wanted = ["a-A1.png", "a-A2.png", "a-A3.png", "a-B1.png", "a-B2.png", "a-B3.png", "a.png"];
    equal("files", &names(folder), &wanted.map(str::to_owned).to_vec())?;
    png(&folder.join("a.png"), [189 + planted, 142])?;
    let sheet = read_rgba8(&folder.join("a-B3.png")).map_err(|error| error.to_string())?;
    equal("sheet", &[sheet.width, sheet.height], &[126, 126])
}

/// An SVG for two pens.
pub(crate) fn svg(folder: &Path, planted: u32) -> Result<(), String> {
    let text = std::fs::read_to_string(folder.join("a.svg")).map_err(|error| error.to_string())?;
    let document = roxmltree::Document::parse(&text).map_err(|error| error.to_string())?;
    let wanted = format!("0 0 {} {}", SIZE_PX[0] + planted, SIZE_PX[1]);
    equal("view box", &document.root_element().attribute("viewBox"), &Some(&*wanted))?;
    let groups: Vec<_> = document.descendants().filter(|node| node.has_tag_name("g")).collect();
    let is_of_pen = |group: &roxmltree::Node<'_, '_>| {
        group.attribute("id").is_some_and(|id| id.ends_with("-pen-1") || id.ends_with("-pen-2"))
    };
    equal("layers of pens", &groups.iter().all(is_of_pen), &true)?;
    let paths = groups.iter().flat_map(|group| group.children()).filter(|node| node.has_tag_name("path")).count();
    if groups.is_empty() || paths < 4 { Err(format!("{} layers with {paths} paths", groups.len())) } else { Ok(()) }
}

/// A page of A6.
pub(crate) fn pdf(folder: &Path, planted: u32) -> Result<(), String> {
    let bytes = std::fs::read(folder.join("a.pdf")).map_err(|error| error.to_string())?;
    equal("beginning", &bytes.starts_with(b"%PDF-"), &true)?;
    let text = String::from_utf8_lossy(&bytes);
    let sides = text.split_once("/MediaBox [").and_then(|(_, rest)| rest.split_once(']')).ok_or("no MediaBox")?.0;
    let sides: Vec<f64> = sides.split_whitespace().filter_map(|side| side.parse().ok()).collect();
    let points = |mm: f64| mm / 25.4 * 72.0;
    let wanted = [0.0, 0.0, points(148.0 + f64::from(planted)), points(105.0)];
    let is_near = sides.len() == 4 && sides.iter().zip(wanted).all(|(side, wanted)| (side - wanted).abs() < 0.01);
    equal(&format!("sides {sides:?}"), &is_near, &true)
}

/// An EXR with depth, position and normal.
pub(crate) fn exr(folder: &Path, planted: u32) -> Result<(), String> {
    let found = MetaData::read_from_file(folder.join("a.exr"), false).map_err(|error| error.to_string())?;
    let header = &found.headers[0];
    let size = [header.layer_size.0, header.layer_size.1];
    equal("size", &size, &[SIZE_PX[0] as usize + planted as usize, SIZE_PX[1] as usize])?;
    let mut names: Vec<String> = header.channels.list.iter().map(|channel| channel.name.to_string()).collect();
    names.sort();
    let wanted =
        ["A", "B", "G", "R", "depth.V", "normal.X", "normal.Y", "normal.Z", "position.X", "position.Y", "position.Z"];
    equal("channels", &names, &wanted.map(str::to_owned).to_vec())
}

/// Says whether the middle of a map is that of the DEM, within a pixel, and whether the map has all of the DEM.
fn placed([x0, dx, y0, dy]: [f64; 4], planted: u32) -> Result<(), String> {
    let middle = [x0 + dx * 0.5 * f64::from(SIZE_PX[0]), y0 + dy * 0.5 * f64::from(SIZE_PX[1])];
    let wanted = [MIDDLE_M[0] + 100.0 * f64::from(planted), MIDDLE_M[1]];
    let is_near = middle.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < dx);
    equal(&format!("middle {middle:?}"), &is_near, &true)?;
    equal(&format!("pixels of {dx} and {dy} m"), &((35.9..38.0).contains(&dx) && (dx + dy).abs() < 1e-6), &true)
}

pub(crate) fn geotiff(folder: &Path, planted: u32) -> Result<(), String> {
    let file = GeoTiffFile::open(folder.join("a.tif")).map_err(|error| error.to_string())?;
    equal("size", &[file.width(), file.height()], &SIZE_PX)?;
    equal("EPSG code", &file.epsg(), &Some(32610))?;
    let place = file.transform().ok_or("no georeference")?;
    placed([place.origin_x, place.pixel_width, place.origin_y, place.pixel_height], planted)
}

/// A PNG with a world file, which has the middle of the first pixel, and with an `.aux.xml`.
pub(crate) fn map_png(folder: &Path, planted: u32) -> Result<(), String> {
    png(&folder.join("a.png"), SIZE_PX)?;
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).map_err(|error| format!("{name}: {error}"));
    let numbers: Vec<f64> = read("a.pgw")?.lines().filter_map(|line| line.parse().ok()).collect();
    let [dx, _, _, dy, x, y] = numbers[..] else { return Err(format!("{numbers:?}")) };
    placed([x - 0.5 * dx, dx, y - 0.5 * dy, dy], planted)?;
    equal("reference system", &read("a.png.aux.xml")?.contains("UTM zone 10N"), &true)
}

/// Longitudes and latitudes, for two pens.
pub(crate) fn geojson(folder: &Path, planted: u32) -> Result<(), String> {
    let text = std::fs::read_to_string(folder.join("a.geojson")).map_err(|error| error.to_string())?;
    let found: serde_json::Value = serde_json::from_str(&text).map_err(|error| error.to_string())?;
    equal("reference system", &found.get("crs"), &None)?;
    let features = found["features"].as_array().ok_or("no features")?;
    let pens: Vec<u64> = features.iter().filter_map(|feature| feature["properties"]["pen"].as_u64()).collect();
    let are_pens = pens.len() == features.len() && pens.iter().all(|pen| (1..=2).contains(pen));
    equal(&format!("pens {pens:?}"), &(are_pens && pens.len() > 10), &true)?;
    let lines = features.iter().filter_map(|feature| feature["geometry"]["coordinates"].as_array());
    let places = lines.flatten().filter_map(|place| Some([place[0].as_f64()?, place[1].as_f64()?]));
    let middle = [MIDDLE_DEG[0] + f64::from(planted), MIDDLE_DEG[1]];
    let is_near = |place: [f64; 2]| (0..2).all(|axis| (place[axis] - middle[axis]).abs() < 0.03);
    let (near, far): (Vec<_>, Vec<_>) = places.partition(|place| is_near(*place));
    equal(
        &format!("{} places, and elsewhere {:?}", near.len(), far.first()),
        &(near.len() > 100 && far.is_empty()),
        &true,
    )
}

pub(crate) fn pair(folder: &Path, planted: u32) -> Result<(), String> {
    png(&folder.join("a.png"), [2 * SIZE_PX[0] + planted, SIZE_PX[1]])
}

pub(crate) fn frames(folder: &Path, planted: u32) -> Result<(), String> {
    let wanted: Vec<String> = (0..FRAMES + planted).map(|frame| format!("{frame:05}.png")).collect();
    let inner = folder.join("a");
    equal("frames", &names(&inner), &wanted)?;
    wanted.iter().try_for_each(|name| png(&inner.join(name), SIZE_PX))
}

pub(crate) fn gif(folder: &Path, planted: u32) -> Result<(), String> {
    let file = std::fs::File::open(folder.join("a.gif")).map_err(|error| error.to_string())?;
    let mut decoder = gif::DecodeOptions::new().read_info(file).map_err(|error| error.to_string())?;
    equal("size", &[decoder.width(), decoder.height()].map(u32::from), &SIZE_PX)?;
    let mut count = 0;
    while decoder.read_next_frame().map_err(|error| error.to_string())?.is_some() {
        count += 1;
    }
    equal("frames", &count, &(FRAMES + planted))
}
