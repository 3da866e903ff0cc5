//! A height file in `info` and `bake`.

use std::path::PathBuf;

use geotiff_writer::GeoTiffBuilder;
use hachure::file::atomic;
use ndarray::Array2;
use serde_json::Value;

use crate::Place;

/// Columns and rows of the synthetic DEM: more than one tile, and odd.
pub(crate) const SIZE: [u32; 2] = [301, 261];
pub(crate) const SPACING_M: f64 = 10.0;
const VOIDS: u64 = 20 * 10;
/// The column and row of the no-data area, on the border between two tiles.
const VOID_CORNER: [usize; 2] = [250, 100];

/// Returns the height of hills of several sizes with sharp ridges; -9999 in the no-data area.
fn height_m(column: usize, row: usize) -> f32 {
    let (x, y) = (column as f32, row as f32);
    if (VOID_CORNER[0]..VOID_CORNER[0] + 20).contains(&column) && (VOID_CORNER[1]..VOID_CORNER[1] + 10).contains(&row) {
        return -9999.0;
    }
    let ridge = |x: f32, y: f32| 1.0 - (0.7 * x + y).sin().abs().max((x - 0.6 * y).cos().abs());
    900.0 + 400.0 * ridge(x / 60.0, y / 60.0) + 90.0 * ridge(x / 13.0, y / 11.0) + 12.0 * ridge(x / 2.3, y / 2.9)
}

/// Writes the synthetic DEM and returns its path.
pub(crate) fn dem(place: &Place) -> PathBuf {
    every_sample(place, 1)
}

/// Writes every `step`th sample of the synthetic DEM along both axes, and returns its path.
pub(crate) fn every_sample(place: &Place, step: u32) -> PathBuf {
    let path = place.path("dem.tif");
    let [width, height] = SIZE.map(|side| side.div_ceil(step));
    let at = |(row, column): (usize, usize)| height_m(column * step as usize, row * step as usize);
    let heights = Array2::from_shape_fn((height as usize, width as usize), at);
    let spacing_m = SPACING_M * f64::from(step);
    GeoTiffBuilder::new(width, height)
        .epsg(32632)
        .pixel_scale(spacing_m, spacing_m)
        .origin(500_000.0, 5_200_000.0)
        .nodata("-9999")
        .write_2d(&path, heights.view())
        .unwrap();
    path
}

/// Writes `count` strips of 40 × 12 samples side by side, as BIL in the reference system of UTM zone 32.
#[cfg(unix)]
fn strips(place: &Place, folder: &str, count: usize) {
    std::fs::create_dir(place.path(folder)).unwrap();
    for number in 0..count {
        let path = place.path(&format!("{folder}/{number:03}.bil"));
        let height = |i: usize| (300 + 7 * (number * 12 + i % 12) + 5 * (i / 12)) as i16;
        let bytes: Vec<u8> = (0..12 * 40).flat_map(|i| height(i).to_le_bytes()).collect();
        atomic::write(&path, &bytes).unwrap();
        let west = 500_000 + number * 12 * 10;
        let header =
            format!("ncols 12\nnrows 40\nnbits 16\nbyteorder I\nulxmap {west}\nulymap 5200000\nxdim 10\nydim 10\n");
        atomic::write(&path.with_extension("hdr"), header.as_bytes()).unwrap();
        let system = b"PROJCS[\"a\",UNIT[\"metre\",1],AUTHORITY[\"EPSG\",\"32632\"]]";
        atomic::write(&path.with_extension("prj"), system).unwrap();
    }
}

#[cfg(unix)]
#[test]
fn a_folder_may_hold_more_files_than_may_be_open() {
    let place = Place::empty();
    strips(&place, "many", 100);
    // The soft limit is raised; a hard limit is not, and the error says what is wrong.
    let run = |limits: &str| {
        let script = format!("ulimit {limits} 64 && exec \"$0\" info many --json");
        let mut shell = std::process::Command::new("sh");
        shell.args(["-c", &script, env!("CARGO_BIN_EXE_hachure")]).current_dir(place.path(""));
        shell.env("HACHURE_CACHE", place.path("cache")).env_remove("RUST_LOG").output().unwrap()
    };
    let output = run("-S -n");
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{error}");
    let info: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(info["width"], 1200, "{info}");
    let output = run("-n");
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success() && error.to_lowercase().contains("too many open files"), "{error}");
}

#[test]
fn warnings_name_the_archive() {
    let place = Place::empty();
    let text = "ncols 4\nnrows 3\nxllcorner 5000\nyllcorner 5000\ncellsize 30\n1 2 3 4 5 6 7 8 9 10 11 12\n";
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    std::io::Write::write_all(&mut encoder, text.as_bytes()).unwrap();
    atomic::write(&place.path("a.asc.gz"), &encoder.finish().unwrap()).unwrap();
    let output = place.hachure(&["info", "a.asc.gz"]);
    let warnings = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{warnings}");
    assert!(warnings.contains("a.asc.gz/a.asc: has no coordinate reference system"), "{warnings}");
    assert!(!warnings.contains("unpacked") && warnings.matches("reference system").count() == 1, "{warnings}");
    // Nothing stays in the cache.
    let own = std::fs::read_dir(place.path("cache")).unwrap().next().unwrap().unwrap().path();
    let left: Vec<_> = std::fs::read_dir(own).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left, ["CACHEDIR.TAG"]);
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is not a number"))
}

fn range_m() -> [f32; 2] {
    let heights = (0..SIZE[1] as usize).flat_map(|row| (0..SIZE[0] as usize).map(move |column| height_m(column, row)));
    heights.filter(|height| *height > 0.0).fold([f32::MAX, f32::MIN], |[low, high], it| [low.min(it), high.max(it)])
}

fn check_heights(info: &Value, within_m: f64) {
    assert_eq!((&info["width"], &info["height"]), (&SIZE[0].into(), &SIZE[1].into()));
    let extent_m = [f64::from(SIZE[0] - 1) * SPACING_M, f64::from(SIZE[1] - 1) * SPACING_M];
    for axis in 0..2 {
        assert!((number(&info["spacing_m"][axis]) - SPACING_M).abs() < 1e-6, "{info}");
        assert!((number(&info["extent_m"][axis]) - extent_m[axis]).abs() < 1e-6, "{info}");
    }
    assert!(info["crs"].as_str().unwrap().contains("EPSG:32632"), "{info}");
    for (key, expected) in ["min_m", "max_m"].into_iter().zip(range_m()) {
        assert!((number(&info[key]) - f64::from(expected)).abs() <= within_m + 1e-3, "{key}: {info}");
    }
    assert_eq!(info["void_samples"], VOIDS);
    assert!((number(&info["void_share"]) - VOIDS as f64 / f64::from(SIZE[0] * SIZE[1])).abs() < 1e-12);
}

#[test]
fn info_describes_a_dem() {
    let place = Place::empty();
    dem(&place);
    let info = place.json(&["info", "dem.tif", "--json"]);
    assert_eq!(info["kind"], "dem");
    check_heights(&info, 0.0);
    let text = place.text(&["info", "dem.tif"]);
    assert!(text.starts_with("dem.tif: a GeoTIFF, ") && text.contains("301 × 261"), "{text}");
    // The first sample is on the central meridian of zone 32, at 9°.
    let [west, south, east, north] = [0, 1, 2, 3].map(|at| number(&info["bounds_deg"][at]));
    assert!((west - 9.0).abs() < 1e-3 && east - west > 0.03 && east - west < 0.05, "{info}");
    assert!(north > 46.9 && north < 47.0 && north - south > 0.02 && north - south < 0.03, "{info}");
    assert!((number(&info["origin_crs"][0]) - 501_500.0).abs() <= 10.0, "{info}");
    assert!(text.contains("\nbounds    longitude 9.0001 to 9.03"), "{text}");
    let warned = |no_data: &str| {
        let output = place.hachure(&["info", "dem.tif", "--nodata", no_data]);
        String::from_utf8(output.stderr).unwrap()
    };
    assert!(warned("-32000").contains("dem.tif: no sample is -32000, so --nodata -32000 changes nothing"));
    let lowest = number(&info["min_m"]).to_string();
    assert!(!warned(&lowest).contains("changes nothing"), "{}", warned(&lowest));
}

#[test]
fn info_describes_what_is_baked() {
    let place = Place::empty();
    dem(&place);
    let mut before_bytes = u64::MAX;
    for (arguments, max_error_m) in [(&["--max-error", "0"][..], 0.0), (&[], 0.01), (&["--max-error", "0.5"], 0.5)] {
        // The second and third bake replace the output of the previous one.
        let arguments = [&["bake", "dem.tif", "-o", "baked.tif", "--json", "--voids", "holes"], arguments].concat();
        let baked = place.json(&arguments);
        let info = place.json(&["info", "baked.tif", "--json"]);
        assert_eq!(info["kind"], "pyramid");
        for (key, value) in info.as_object().unwrap() {
            assert!(["file", "kind"].contains(&key.as_str()) || baked[key] == *value, "{key}: {baked}\n{info}");
        }
        check_heights(&info, max_error_m);
        assert_eq!(number(&info["max_error_m"]), max_error_m);
        let levels = info["levels"].as_array().unwrap();
        let sizes: Vec<[u64; 3]> =
            levels.iter().map(|level| ["width", "height", "tiles"].map(|key| level[key].as_u64().unwrap())).collect();
        assert_eq!(sizes, [[301, 261, 4], [151, 131, 1]]);
        assert_eq!((&info["tiles"], info["patches"].as_u64().unwrap() > 90), (&5.into(), true), "{info}");
        // Samples are stored as f32, which adds a rounding error.
        assert!(number(&levels[0]["largest_error_m"]) <= max_error_m + 2e-4, "{info}");
        assert!(number(&levels[1]["largest_error_m"]) > 1.0, "{info}");
        let bytes = std::fs::metadata(place.path("baked.tif")).unwrap().len();
        assert_eq!(info["tif_bytes"], bytes);
        let bits = bytes as f64 * 8.0 / f64::from(SIZE[0] * SIZE[1]);
        assert!((number(&info["bits_per_sample"]) - bits).abs() < 1e-9);
        assert!(bytes < before_bytes, "a larger error gave {bytes} bytes, a smaller one {before_bytes}");
        before_bytes = bytes;
    }
    let text = place.text(&["bake", "dem.tif", "-o", "baked.tif"]);
    assert!(text.contains("within 0.01 m") && text.contains("level 1"), "{text}");
    assert_eq!(place.names(), ["baked.tif", "baked.tif.tiles", "dem.tif"]);
    // By default the hole is filled.
    let found = |file: &str| place.json(&["info", file, "--json"])["void_samples"].clone();
    assert_eq!((found("baked.tif"), found("dem.tif")), (0.into(), VOIDS.into()));
    assert_eq!(place.json(&["info", "dem.tif", "--json"])["filled_samples"], VOIDS);
    assert_eq!(place.json(&["info", "dem.tif", "--json", "--voids", "holes"])["filled_samples"], 0);
}

#[test]
fn a_bake_does_not_touch_its_input_nor_a_failed_one_its_output() {
    let place = Place::empty();
    let dem = dem(&place);
    let bytes = std::fs::read(&dem).unwrap();
    assert!(place.error(&["bake", "dem.tif", "-o", "dem.tif"]).contains("is the input"));
    assert!(place.error(&["bake", "dem.tif", "-o", "../../../../../../../../nowhere/x.tif"]).contains("no folder"));
    let link = place.path("link.tif");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&dem, &link).unwrap();
        assert!(place.error(&["bake", "dem.tif", "-o", "link.tif"]).contains("is the input"));
        std::fs::remove_file(&link).unwrap();
    }
    assert_eq!(std::fs::read(&dem).unwrap(), bytes);
    // A bake of a damaged input does not change an existing output.
    place.text(&["bake", "dem.tif", "-o", "baked.tif"]);
    let baked = std::fs::read(place.path("baked.tif")).unwrap();
    atomic::write(&dem, &bytes[..bytes.len() / 2]).unwrap();
    assert!(place.error(&["bake", "dem.tif", "-o", "baked.tif"]).contains("dem.tif"));
    assert_eq!(std::fs::read(place.path("baked.tif")).unwrap(), baked);
    assert_eq!(place.names(), ["baked.tif", "baked.tif.tiles", "dem.tif"]);
}

#[test]
fn a_pyramid_with_stale_statistics_is_a_dem_with_a_note() {
    let place = Place::empty();
    dem(&place);
    place.text(&["bake", "dem.tif", "-o", "baked.tif"]);
    std::fs::copy(place.path("baked.tif.tiles"), place.path("dem.tif.tiles")).unwrap();
    let info = place.json(&["info", "dem.tif", "--json"]);
    assert_eq!(info["kind"], "dem");
    assert!(info["stale"].as_str().unwrap().contains("outdated"), "{info}");
    assert!(place.error(&["info", "baked.tif.tiles"]).contains("baked.tif.tiles"));
}
