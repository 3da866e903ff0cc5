//! Tests `render --map`: points of a map are where its world file, its GeoTIFF and its GeoJSON place them, whatever
//! their height.

#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "the helpers of tests may panic")]

#[path = "../src/tests/common/program.rs"]
mod program;

use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;
use std::process::Output;

use hachure::file::png::{Picture, read_rgba8};
use hachure::source;
use program::full;
use serde_json::Value;

/// Columns and rows of the land with pillars, and the metres between samples.
const SAMPLES: [usize; 2] = [200, 150];
const SPACING_M: f64 = 10.0;
/// South-western outer corner of the land, in metres.
const CORNER_M: [f64; 2] = [500_000.0, 4_000_000.0];
/// Column, row, and height above the land in metres.
const PILLARS: [(usize, usize, f64); 5] =
    [(25, 20, 100.0), (170, 20, 1500.0), (30, 120, 2500.0), (175, 125, 600.0), (100, 75, 1200.0)];

const WGS84: &str = r#"GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433],AUTHORITY["EPSG","4326"]]"#;
const UTM: &str = r#"PROJCS["WGS 84 / UTM zone 10N",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],UNIT["metre",1],AUTHORITY["EPSG","32610"]]"#;

/// Western and southern border of the geographic land, and its spacing, in degrees, and its columns and rows.
const WEST: f64 = 6.0;
const SOUTH: f64 = 60.0;
const STEP: f64 = 0.04;
const DEGREES: [usize; 2] = [101, 51];

/// A folder with DEMs.
struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes `NAME.asc` and, with a reference system, `NAME.prj`.
    fn land(
        &self,
        name: &str,
        head: &str,
        [columns, rows]: [usize; 2],
        prj: Option<&str>,
        height_m: impl Fn(usize, usize) -> f64,
    ) {
        let mut text = format!("ncols {columns}\nnrows {rows}\n{head}\n");
        for row in 0..rows {
            for column in 0..columns {
                write!(text, "{} ", height_m(column, row)).unwrap();
            }
            text.push('\n');
        }
        fs::write(self.path(&format!("{name}.asc")), text).unwrap();
        if let Some(prj) = prj {
            fs::write(self.path(&format!("{name}.prj")), prj).unwrap();
        }
    }

    /// Returns a folder with level land and pillars of five by five samples.
    fn pillars() -> Self {
        let place = Self::new();
        let head = format!("xllcorner {}\nyllcorner {}\ncellsize {SPACING_M}", CORNER_M[0], CORNER_M[1]);
        place.land("pillars", &head, SAMPLES, Some(UTM), |column, row| {
            let on = PILLARS.iter().find(|(x, y, _)| x.abs_diff(column) <= 2 && y.abs_diff(row) <= 2);
            500.0 + on.map_or(0.0, |(.., height_m)| *height_m)
        });
        place
    }

    /// Returns a folder with a slope of four by two degrees.
    fn degrees() -> Self {
        let place = Self::new();
        let head = format!("xllcenter {WEST}\nyllcenter {SOUTH}\ncellsize {STEP}");
        place.land("degrees", &head, DEGREES, Some(WGS84), |column, row| (300 + 3 * column + 2 * row) as f64);
        place
    }

    fn run(&self, arguments: &str) -> Output {
        program::run(self.0.path(), arguments)
    }

    fn draw(&self, arguments: &str) {
        program::draw(self.0.path(), arguments);
    }

    /// Returns the last line of the error with which the program fails.
    fn refused(&self, arguments: &str) -> String {
        let output = self.run(arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(!output.status.success(), "{arguments}");
        said.trim_end().lines().last().unwrap().to_owned()
    }

    fn read(&self, name: &str) -> Picture {
        read_rgba8(&self.path(name)).unwrap()
    }

    /// Returns the six numbers of a world file.
    fn world_file(&self, name: &str) -> [f64; 6] {
        let text = fs::read_to_string(self.path(name)).unwrap();
        let numbers: Vec<f64> = text.lines().map(|line| line.parse().unwrap()).collect();
        numbers.try_into().unwrap()
    }

    /// Returns the reference system in the `.aux.xml` of a picture, as GDAL reads it.
    fn srs(&self, picture: &str) -> String {
        let text = fs::read_to_string(self.path(&format!("{picture}.aux.xml"))).unwrap();
        let document = roxmltree::Document::parse(&text).unwrap();
        assert_eq!(document.root_element().tag_name().name(), "PAMDataset");
        let srs = document.root_element().children().find(|node| node.has_tag_name("SRS")).unwrap();
        srs.text().unwrap().to_owned()
    }

    fn features(&self, name: &str) -> (Value, Vec<Value>) {
        let all: Value = serde_json::from_slice(&fs::read(self.path(name)).unwrap()).unwrap();
        let features = all["features"].as_array().unwrap().clone();
        (all, features)
    }
}

/// Returns the position of a sample of the land with pillars, in metres.
fn sample_m(column: usize, row: usize) -> [f64; 2] {
    let east_m = CORNER_M[0] + (column as f64 + 0.5) * SPACING_M;
    [east_m, CORNER_M[1] + ((SAMPLES[1] - row) as f64 - 0.5) * SPACING_M]
}

/// Returns the pixel position of a point by a world file; (0, 0) is the upper left corner.
fn px_of([dx, _, _, dy, x0, y0]: [f64; 6], [x, y]: [f64; 2]) -> [f64; 2] {
    [(x - x0) / dx + 0.5, (y - y0) / dy + 0.5]
}

/// Returns the largest distance between the middle of a pillar in a picture and its position by the world file, in
/// pixels.
fn farthest_px(picture: &Picture, world_file: [f64; 6]) -> f64 {
    let (width, height) = (picture.width as usize, picture.height as usize);
    let tone = |x: usize, y: usize| f64::from(picture.rgba[4 * (y * width + x) + 1]);
    let level = tone(width / 2, height / 4);
    let mut max_px = 0.0_f64;
    for (column, row, _) in PILLARS {
        let [x, y] = px_of(world_file, sample_m(column, row));
        let mut sums = [0.0; 3];
        let around = |at: f64, side: usize| (at as usize).saturating_sub(22)..(at as usize + 22).min(side);
        for py in around(y, height) {
            for px in around(x, width) {
                let seen = (tone(px, py) - level).abs();
                let seen = if seen > 4.0 { seen } else { 0.0 };
                sums = [sums[0] + seen, sums[1] + seen * (px as f64 + 0.5), sums[2] + seen * (py as f64 + 0.5)];
            }
        }
        assert!(sums[0] > 1000.0, "no pillar near {x}, {y}");
        max_px = max_px.max((sums[1] / sums[0] - x).hypot(sums[2] / sums[0] - y));
    }
    max_px
}

#[test]
fn places_are_where_the_world_file_says_whatever_their_height() {
    let place = Place::pillars();
    place.draw("pillars.asc --map --style plain --sun 0,90 --size 400x300 -o map.png");
    let world_file = place.world_file("map.pgw");
    let picture = place.read("map.png");
    let found_px = farthest_px(&picture, world_file);
    println!("a whole world: {found_px:.3} px");
    assert!(found_px < 0.5, "{found_px}");
    // Planted: a world file that refers to corners instead of centres of pixels.
    let [dx, r, s, dy, x0, y0] = world_file;
    let of_corner = farthest_px(&picture, [dx, r, s, dy, x0 + 0.5 * dx, y0 + 0.5 * dy]);
    assert!(of_corner > 0.5, "{of_corner}");
    // Planted: a camera that is not far up, so that relief displaces what it sees.
    let fov_deg = 2.0 * (0.5 * 300.0 * dx / 20_000.0).atan().to_degrees();
    fs::write(place.path("near.toml"), "[world]\ndem = \"pillars.asc\"\n[haze]\ndistance_m = 1e9\n").unwrap();
    let near = format!("near.toml --camera 0,0,20500,0,-90,{fov_deg} --style plain --sun 0,90 --size 400x300");
    place.draw(&format!("{near} -o near.png"));
    let near_px = farthest_px(&place.read("near.png"), world_file);
    assert!(near_px > 1.0, "{near_px}");
    // A map around a point has the requested width.
    place.draw("pillars.asc --map=100,-50,1800 --style plain --sun 0,90 --size 600x450 -o part.png");
    let part = place.world_file("part.pgw");
    let found_px = farthest_px(&place.read("part.png"), part);
    println!("a part of it: {found_px:.3} px");
    assert!(part[0] == 3.0 && part[3] == -3.0 && found_px < 0.5, "{part:?}, {found_px}");
    assert!(place.srs("part.png").contains("\"EPSG\",\"32610\""));
}

#[test]
fn a_geotiff_has_the_place_of_the_world_file() {
    let place = Place::pillars();
    let options = "pillars.asc --map --style plain --size 400x300 --dpi 96";
    place.draw(&format!("{options} -o map.png"));
    place.draw(&format!("{options} -o map.tif"));
    // hachure does not accept a picture as heights, so the file is changed to a band of numbers, whose georeference is
    // read like that of any DEM.
    let mut bytes = fs::read(place.path("map.tif")).unwrap();
    let photometric = [0x06, 0x01, 3, 0, 1, 0, 0, 0, 2, 0];
    let at = bytes.windows(photometric.len()).position(|window| window == photometric).unwrap();
    bytes[at + 8] = 1;
    fs::write(place.path("numbers.tif"), bytes).unwrap();
    let reader = source::open_reader(&place.path("numbers.tif")).unwrap();
    let georeference = reader.georeference();
    let [dx, column_y, row_x, dy, x0, y0] = place.world_file("map.pgw");
    let [found_x0, found_dx, found_row_x, found_y0, found_column_y, found_dy] = georeference.crs_from_grid;
    let of_tags = [found_dx, found_column_y, found_row_x, found_dy, found_x0, found_y0];
    let far = |wanted: [f64; 6]| wanted.iter().zip(&of_tags).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let wanted = [dx, column_y, row_x, dy, x0, y0];
    assert!(far(wanted) < 1e-6, "{wanted:?}, {of_tags:?}");
    assert!(far([dx, column_y, row_x, dy, x0 + 0.5 * dx, y0]) > 1.0, "half a pixel off was not detected");
    assert_eq!(georeference.epsg(), Some(32610));
    // The TIFF has the same pixels as the PNG.
    let tiff = tiff_reader::TiffFile::from_bytes(fs::read(place.path("map.tif")).unwrap()).unwrap();
    let of_tiff: Vec<u8> = tiff.read_image::<u8>(0).unwrap().iter().copied().collect();
    let rgb = |rgba: &[u8]| rgba.chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect::<Vec<u8>>();
    let mut of_png = rgb(&place.read("map.png").rgba);
    assert!(of_tiff == of_png, "the TIFF has other pixels");
    of_png[7] ^= 1;
    assert!(of_tiff != of_png);
}

/// Returns the points of border lines.
fn border_points(features: &[Value]) -> Vec<[f64; 2]> {
    let borders = features.iter().filter(|feature| feature["properties"]["kind"] == "border");
    let number = |value: &Value| value.as_f64().unwrap();
    let points = borders.flat_map(|border| border["geometry"]["coordinates"].as_array().unwrap());
    points.map(|point| [number(&point[0]), number(&point[1])]).collect()
}

/// Returns the largest distance between points and the sides of a rectangle, in units of `unit`.
fn off_sides(points: &[[f64; 2]], [low, high]: [[f64; 2]; 2], unit: [f64; 2]) -> f64 {
    let off = |point: &[f64; 2]| {
        let sides = [0, 1].map(|i| (point[i] - low[i]).abs().min((point[i] - high[i]).abs()) / unit[i]);
        sides[0].min(sides[1])
    };
    points.iter().map(off).fold(0.0, f64::max)
}

#[test]
fn lines_lie_on_the_land_that_they_follow() {
    let place = Place::pillars();
    place.draw("pillars.asc --map --style strokes --size 400x300 -o map.geojson");
    let (all, features) = place.features("map.geojson");
    assert_eq!(all["crs"]["properties"]["name"], "urn:ogc:def:crs:EPSG::32610");
    let points = border_points(&features);
    let sides = [sample_m(0, SAMPLES[1] - 1), sample_m(SAMPLES[0] - 1, 0)];
    let pixel_m = 1990.0 / (400.0 * 0.98);
    let found_px = off_sides(&points, sides, [pixel_m; 2]);
    println!("{} points of borders, {found_px:.3} px from the sides", points.len());
    assert!(points.len() >= 8 && found_px < 0.75, "{found_px}");
    let moved: Vec<_> = points.iter().map(|[x, y]| [x + pixel_m, y + pixel_m]).collect();
    assert!(off_sides(&moved, sides, [pixel_m; 2]) > 0.75, "a pixel off was not detected");
    let border = features.iter().find(|feature| feature["properties"]["kind"] == "border").unwrap();
    let properties = &border["properties"];
    assert_eq!((properties["layer"].as_str(), properties["pen"].is_null()), (Some("borders"), true));
    assert!(properties["width_m"].as_f64().unwrap() > pixel_m && properties["ink"].as_str().unwrap().starts_with('#'));
    let size = if full() { "400x300" } else { "100x75" };
    place.draw(&format!("pillars.asc --map --style strokes --size {size} --pens 1 -o pens.geojson"));
    assert!(place.features("pens.geojson").1.iter().all(|feature| feature["properties"]["pen"] == 1));
}

#[test]
fn lines_over_degrees_have_longitudes_and_latitudes() {
    let place = Place::degrees();
    place.draw("degrees.asc --map --style strokes --size 800x600 -o map.geojson");
    let (all, features) = place.features("map.geojson");
    assert!(all["crs"].is_null(), "there must be no crs: WGS 84 is the default");
    let points = border_points(&features);
    let (east, north) = (WEST + STEP * (DEGREES[0] - 1) as f64, SOUTH + STEP * (DEGREES[1] - 1) as f64);
    // The map has about 300 m per pixel; a degree of latitude is 111 km, and one of longitude half of that.
    place.draw("degrees.asc --map --style plain --size 800x600 -o map.png");
    let pixel_m = place.world_file("map.pgw")[0];
    let unit = [pixel_m / 111_320.0 / north.to_radians().cos(), pixel_m / 111_320.0];
    let found_px = off_sides(&points, [[WEST, SOUTH], [east, north]], unit);
    println!("{} points of borders, {found_px:.3} px from the sides, of {pixel_m:.0} m", points.len());
    assert!(points.len() >= 8 && found_px < 0.75, "{found_px}");
    // Parallels are curved on the map, so treating them as straight lines would be off by some pixels.
    let middle = 0.5 * (WEST + east);
    let bend = |[x, y]: &[f64; 2]| {
        let way = (x - middle).to_radians();
        [*x, y + (0.5 * way * way * y.to_radians().sin() * y.to_radians().cos()).to_degrees()]
    };
    let straight: Vec<_> = points.iter().map(bend).collect();
    let straight_px = off_sides(&straight, [[WEST, SOUTH], [east, north]], unit);
    assert!(straight_px > 1.0, "{straight_px}");
    let srs = place.srs("map.png");
    assert!(srs.contains("Transverse_Mercator") && srs.contains("PARAMETER[\"central_meridian\",8]"), "{srs}");
    assert!(srs.is_ascii());
}

/// Returns the lines of a kind.
fn of_kind<'a>(features: &'a [Value], kind: &str) -> Vec<&'a Value> {
    features.iter().filter(|feature| feature["properties"]["kind"] == kind).collect()
}

/// Tests attributes of lines on a cone, whose contour lines are circles, and whose slope is the same everywhere.
#[test]
fn lines_say_what_they_show() {
    const SLOPE: f64 = 0.5;
    let place = Place::new();
    let head = format!("xllcorner {}\nyllcorner {}\ncellsize {SPACING_M}", CORNER_M[0], CORNER_M[1]);
    let from_top_m = |column: usize, row: usize| {
        let [x, y] = [(column as f64 - 60.0) * SPACING_M, (row as f64 - 60.0) * SPACING_M];
        x.hypot(y)
    };
    place.land("cone", &head, [121, 121], Some(UTM), |column, row| 900.0 - SLOPE * from_top_m(column, row));
    let style = if full() { "pen" } else { "strokes" };
    place.draw(&format!("cone.asc --map=0,0,1100 --style {style} --size 220x220 -o cone.geojson"));
    place.draw(&format!("cone.asc --map=0,0,1100 --style {style} --size 220x220 --wgs84 -o wgs84.geojson"));
    let (_, features) = place.features("cone.geojson");
    let number = |value: &Value| value.as_f64().unwrap();
    let top = [CORNER_M[0] + 60.5 * SPACING_M, CORNER_M[1] + 60.5 * SPACING_M];
    let contours = of_kind(&features, "contour line");
    assert!(contours.len() >= 8, "{}", contours.len());
    // The height that the cone has at a line's first point, and the height that the line states.
    let heights = |feature: &Value| {
        let first = &feature["geometry"]["coordinates"][0];
        let away_m = (number(&first[0]) - top[0]).hypot(number(&first[1]) - top[1]);
        [900.0 - SLOPE * away_m, number(&feature["properties"]["height_m"])]
    };
    let off_m = |moved_m: f64| {
        let off_m = contours.iter().map(|feature| heights(feature)).map(|[land, own]| (land - own - moved_m).abs());
        off_m.fold(0.0, f64::max)
    };
    assert!(off_m(0.0) < 4.0, "{}", off_m(0.0));
    assert!(off_m(20.0) > 15.0, "planted error, the height of the next line");
    for contour in contours.iter().filter(|contour| number(&contour["properties"]["length_m"]) > 500.0) {
        let length_m = number(&contour["properties"]["length_m"]);
        let circle_m = std::f64::consts::TAU * (900.0 - number(&contour["properties"]["height_m"])) / SLOPE;
        assert!(length_m < 1.1 * circle_m, "{length_m} m of a circle of {circle_m} m");
    }
    // Depth contours state their heights, which count from the sea, in true metres.
    fs::write(
        place.path("deep.toml"),
        "extends = \"strokes\"\n[[layers]]\nkind = \"height_lines\"\nof = \"sea\"\ninterval_m = 20\n",
    )
    .unwrap();
    let deep = "cone.asc --map=0,0,1100 --style deep.toml --sea-level 777 --exaggeration 2 --size 220x220";
    place.draw(&format!("{deep} -o deep.geojson"));
    let (_, drawn) = place.features("deep.geojson");
    let depths = of_kind(&drawn, "contour line");
    let intervals = |feature: &Value, sea_m: f64| (sea_m - number(&feature["properties"]["height_m"])) / 20.0;
    let is_depth = |feature: &&&Value, sea_m: f64| {
        let count = intervals(feature, sea_m);
        (count - count.round()).abs() < 1e-3 && count > 0.9
    };
    assert!(depths.len() >= 4 && depths.iter().all(|feature| is_depth(&feature, 777.0)), "{} lines", depths.len());
    assert!(depths.iter().map(|feature| heights(feature)).all(|[land, own]| (land - own).abs() < 4.0));
    assert!(!depths.iter().any(|feature| is_depth(&feature, 780.0)), "planted: another sea");
    // RFC 7946: longitudes and latitudes, and no other reference system.
    let (all, degrees) = place.features("wgs84.geojson");
    assert!(all["crs"].is_null() && degrees.len() == features.len());
    let [longitude, latitude] = [0, 1].map(|axis| number(&degrees[0]["geometry"]["coordinates"][0][axis]));
    // 500 km east of the central meridian's false easting is 123° W, and 4,000 km north is 36.1° N.
    assert!((longitude + 123.0).abs() < 0.02 && (latitude - 36.14).abs() < 0.02, "{longitude} {latitude}");
    assert_eq!(degrees[0]["properties"], features[0]["properties"]);

    place.draw("cone.asc --map=0,0,1100 --style hachures --size 220x220 -o hachures.geojson");
    let (_, features) = place.features("hachures.geojson");
    let marks = of_kind(&features, "mark");
    let slopes: Vec<f64> = marks.iter().filter_map(|mark| mark["properties"]["slope_deg"].as_f64()).collect();
    let wanted_deg = SLOPE.atan().to_degrees();
    let near = slopes.iter().filter(|slope| (*slope - wanted_deg).abs() < 1.0).count();
    assert!(slopes.len() > 50 && near * 10 > slopes.len() * 9, "{near} of {} near {wanted_deg}°", slopes.len());
}

#[test]
fn a_map_of_the_globe_ends_at_the_poles() {
    let place = Place::new();
    place.land("globe", "xllcorner -180\nyllcorner -90\ncellsize 5", [72, 36], Some(WGS84), |column, row| {
        (10 * column + row) as f64
    });
    place.draw("globe.asc --map --style plain -o globe.png");
    let [dx, _, _, dy, x0, y0] = place.world_file("globe.pgw");
    let picture = place.read("globe.png");
    let [west, east] = [x0 - 0.5 * dx, x0 + (f64::from(picture.width) - 0.5) * dx];
    let [north, south] = [y0 - 0.5 * dy, y0 + (f64::from(picture.height) - 0.5) * dy];
    assert!(north <= 90.0 && south >= -90.0 && north - south > 170.0, "{south} to {north}");
    assert!(east - west <= 360.0 && east - west > 350.0, "{west} to {east}");
    assert!(place.srs("globe.png").starts_with("GEOGCS"));
    // With a given size, a GeoTIFF is refused, and a PNG says that it has no place.
    let said = place.refused("globe.asc --map --style plain --size 64x48 -o globe.tif");
    assert!(said.contains("beyond the poles") && !place.path("globe.tif").exists(), "{said}");
    let drawn = place.run("globe.asc --map --style plain --size 64x48 -o other.png");
    let said = String::from_utf8_lossy(&drawn.stderr).into_owned();
    assert!(drawn.status.success() && said.contains("without a place on the earth"), "{said}");
    assert!(!place.path("other.pgw").exists() && !place.path("other.png.aux.xml").exists());
}

#[test]
fn an_impossible_map_gives_an_error_of_one_line() {
    let place = Place::pillars();
    place.land("nowhere", "xllcorner 0\nyllcorner 0\ncellsize 30", [20, 20], None, |x, y| (x * y) as f64);
    for (arguments, words) in [
        ("pillars.asc -o map.tif", ["map.tif", "--map"]),
        ("pillars.asc -o map.geojson --style strokes", ["map.geojson", "--map"]),
        ("pillars.asc -o %d.tif --path tour", ["d.tif", "--map"]),
        ("pillars.asc --map -o film.mp4", ["--map", "film"]),
        ("pillars.asc --map -o %03d.png", ["--map", "pattern"]),
        ("pillars.asc --map --camera 0,0,9,0,0,9 -o map.png", ["--map", "--camera"]),
        ("pillars.asc --map --path tour -o map.png", ["--map", "--path"]),
        ("pillars.asc --map --eyes anaglyph -o map.png", ["--eyes", "--eyes mono"]),
        ("--map pillars.asc -o map.png", ["--map took", "put the DEM before --map"]),
        ("pillars.asc --map 0,0,-5 -o map.png", ["--map", "width"]),
        ("pillars.asc --map --style wash -o map.tiff2", ["map.tiff2", ".geojson"]),
        ("pillars.asc --map --margin 5 --style strokes -o map.geojson", ["--margin", ".svg"]),
        ("nowhere.asc --map --style strokes -o map.geojson", ["map.geojson", "nowhere.asc has no reference system"]),
        ("nowhere.asc --map --style strokes --wgs84 -o map.geojson", ["map.geojson", "nowhere.asc has no reference"]),
        ("pillars.asc --map --wgs84 -o map.png", ["--wgs84", ".geojson"]),
    ] {
        let said = place.refused(arguments);
        assert!(words.iter().all(|word| said.contains(word)), "{arguments}: {said}");
    }
    let left: Vec<_> = fs::read_dir(place.0.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert!(left.iter().all(|name| !name.to_string_lossy().contains("map")), "{left:?}");
}

#[test]
fn all_files_of_a_map_appear_or_none_and_no_input_is_lost() {
    let place = Place::pillars();
    let before = fs::read_to_string(place.path("pillars.prj")).unwrap();
    // A .prj belongs to a DEM or to a shapefile, so a map does not write one.
    let style = if full() { "ink" } else { "plain" };
    place.draw(&format!("pillars.asc --map --size 64x48 --style {style} -o pillars.png"));
    assert_eq!(fs::read_to_string(place.path("pillars.prj")).unwrap(), before);
    fs::create_dir(place.path("map.pgw")).unwrap();
    let said = place.refused("pillars.asc --map --size 64x48 -o map.png");
    assert!(said.contains("map.pgw"), "{said}");
    let left: Vec<String> = fs::read_dir(place.0.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    let of_map: Vec<_> = left.iter().filter(|name| name.contains("map") || name.contains("part")).collect();
    assert_eq!(of_map, ["map.pgw"]);
    fs::remove_dir(place.path("map.pgw")).unwrap();
    place.draw(&format!("pillars.asc --map --size 64x48 --style {style} -o map.png"));
    assert!(["map.png", "map.pgw", "map.png.aux.xml"].iter().all(|name| place.path(name).is_file()));
}

#[test]
fn a_map_is_drawn_again() {
    let place = Place::pillars();
    let style = if full() { "pen" } else { "lsa" };
    place.draw(&format!("pillars.asc --map=100,-50,900 --style {style} --size 96x64 -o map.png"));
    place.draw("--like map.png -o again.png");
    assert_eq!(place.read("map.png"), place.read("again.png"));
    assert_eq!(place.world_file("map.pgw"), place.world_file("again.pgw"));
    // A camera overrides the map of the picture, and draws something else.
    place.draw("--like map.png --camera 0,0,+900,0,-60,50 -o other.png");
    assert!(place.read("map.png") != place.read("other.png") && !place.path("other.pgw").exists());
    // A picture that replaces a map removes the files that place the map on the earth, if hachure wrote them.
    let side_files = || ["map.pgw", "map.png.aux.xml"].map(|name| place.path(name).exists());
    assert_eq!(side_files(), [true, true]);
    fs::write(place.path("map.pgw"), "1\n0\n0\n-1\n0\n0\n").unwrap();
    place.draw("--like other.png -o map.png");
    assert_eq!(side_files(), [true, false], "the world file is no longer hachure's");
    let said = place.refused("pillars.asc --map --size 64x48 -o map.png");
    assert!(said.contains("map.pgw: this file exists, and map.png does not record it as hachure's"), "{said}");
    fs::remove_file(place.path("map.pgw")).unwrap();
    place.draw("pillars.asc --map --size 64x48 -o map.png");
    place.draw("--like other.png --show depth -o map.png");
    assert_eq!(side_files(), [false, false]);
}

#[test]
fn neither_air_nor_the_earths_curvature_are_on_a_map() {
    let place = Place::pillars();
    let scene = "[world]\ndem = \"pillars.asc\"\n[haze]\ndistance_m = 300\n[earth]\ncurvature = true\n";
    fs::write(place.path("bent.toml"), scene).unwrap();
    for (world, name) in [("pillars.asc", "clear.png"), ("bent.toml", "bent.png")] {
        place.draw(&format!("{world} --map --style plain --size 96x72 -o {name}"));
        place.draw(&format!("{world} --camera 0,0,3000,0,-90,50 --style plain --size 96x72 -o near_{name}"));
    }
    assert_eq!(place.read("clear.png"), place.read("bent.png"));
    assert!(place.read("near_clear.png") != place.read("near_bent.png"), "a camera must see haze and curvature");
}
