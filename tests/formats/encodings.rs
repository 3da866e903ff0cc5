//! The encodings of heights in colours, each as PNG, as lossless WebP and as a folder of tiles: with no-data, with
//! another base and interval, and without anything that says which it is.

use std::path::{Path, PathBuf};

use hachure::source::{self, Encoding, HeightGrid, OpenOptions, Silent, SourceError, TileRows};

use crate::write::{self, Colours};

/// A code of 24 bits for heights.
#[derive(Clone, Copy, Debug)]
struct Code {
    encoding: Encoding,
    interval_m: f64,
    base_m: f64,
    /// The colour of no-data.
    void: [u8; 3],
}

const MAPBOX: Code = Code { encoding: Encoding::Mapbox, interval_m: 0.1, base_m: -10_000.0, void: [0, 0, 0] };
const TERRARIUM: Code =
    Code { encoding: Encoding::Terrarium, interval_m: 1.0 / 256.0, base_m: -32_768.0, void: [0, 0, 0] };
const GSI: Code = Code { encoding: Encoding::Gsi, interval_m: 0.01, base_m: 0.0, void: [128, 0, 0] };

impl Code {
    fn of(self, interval_m: f64, base_m: f64) -> Self {
        Self { interval_m, base_m, ..self }
    }

    fn pixel(self, height_m: f64) -> [u8; 3] {
        if height_m.is_nan() {
            return self.void;
        }
        let steps = ((height_m - self.base_m) / self.interval_m).round() as i64;
        let [.., red, green, blue] = steps.to_be_bytes();
        [red, green, blue]
    }

    fn options(self) -> OpenOptions {
        let own = [MAPBOX, TERRARIUM, GSI].into_iter().find(|own| own.encoding == self.encoding).unwrap();
        OpenOptions {
            encoding: Some(self.encoding),
            height_scale_m: Some(self.interval_m).filter(|it| *it != own.interval_m),
            height_offset_m: Some(self.base_m).filter(|it| *it != own.base_m),
            ..OpenOptions::default()
        }
    }
}

/// How the pictures are stored.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stored {
    Png,
    WebP,
    PngTiles,
    WebPTiles,
}

const STORED: [Stored; 4] = [Stored::Png, Stored::WebP, Stored::PngTiles, Stored::WebPTiles];

/// Heights of `side` × `side` samples.
struct Land {
    side: usize,
    heights_m: Vec<f64>,
}

impl Land {
    /// Returns hills around `level_m` that rise by about `rise_m` from sample to sample; the first sample of some rows
    /// has no data if `has_voids`.
    fn new(side: usize, level_m: f64, rise_m: f64, has_voids: bool) -> Self {
        let height_m = |column: usize, row: usize| {
            let (x, y) = (column as f64, row as f64);
            level_m + rise_m * 12.0 * ((x * 0.13).sin() + (y * 0.07 + x * 0.05).cos() + 0.3 * (x * 0.4 + y * 0.3).sin())
        };
        let is_void = |column: usize, row: usize| has_voids && column == 0 && row % 5 == 2;
        let at = |column, row| if is_void(column, row) { f64::NAN } else { height_m(column, row) };
        let heights_m = (0..side * side).map(|index| at(index % side, index / side)).collect();
        Self { side, heights_m }
    }

    /// Writes the land in a folder and returns the path to open. A folder of tiles has 2 × 2 of them at level 14 from
    /// `first` on, in rows from the north or the south.
    fn write(&self, folder: &Path, code: Code, stored: Stored, first: [u32; 2], rows: TileRows) -> PathBuf {
        let pixels: Vec<[u8; 3]> = self.heights_m.iter().map(|height_m| code.pixel(*height_m)).collect();
        let (name, colours) = match stored {
            Stored::Png => ("a.png", Colours::Png),
            Stored::WebP => ("a.webp", Colours::WebP),
            Stored::PngTiles => ("png", Colours::Png),
            Stored::WebPTiles => ("webp", Colours::WebP),
        };
        let path = folder.join(name);
        if matches!(stored, Stored::Png | Stored::WebP) {
            write::colours(&path, [self.side, self.side], &pixels, colours);
            return path;
        }
        let half = self.side / 2;
        for (column, row) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let at = |index: usize| pixels[(row * half + index / half) * self.side + column * half + index % half];
            let tile: Vec<[u8; 3]> = (0..half * half).map(at).collect();
            let y = first[1] + row as u32;
            let y = if rows == TileRows::Tms { 16_383 - y } else { y };
            let column_folder = path.join(format!("14/{}", first[0] + column as u32));
            std::fs::create_dir_all(&column_folder).unwrap();
            let ending = if colours == Colours::WebP { "webp" } else { "png" };
            write::colours(&column_folder.join(format!("{y}.{ending}")), [half, half], &tile, colours);
        }
        path
    }

    /// Returns whether heights are these, as exactly as a code has them.
    fn is(&self, grid: &HeightGrid, interval_m: f64) -> bool {
        let agrees = |(read, height_m): (&f32, &f64)| {
            (read.is_nan() && height_m.is_nan()) || (f64::from(*read) - height_m).abs() <= 0.51 * interval_m + 1e-3
        };
        grid.heights_m.len() == self.heights_m.len() && grid.heights_m.iter().zip(&self.heights_m).all(agrees)
    }
}

fn open(path: &Path, options: &OpenOptions) -> Result<HeightGrid, SourceError> {
    source::read_all(&*source::open_reader_with(path, options)?, path, &Silent)
}

/// The place of tiles in the Alps.
const ALPS: [u32; 2] = [8552, 5788];

#[test]
fn every_encoding_is_read_from_png_webp_and_tiles() {
    let codes = [
        MAPBOX,
        MAPBOX.of(0.1, 0.0),
        MAPBOX.of(0.01, -500.0),
        MAPBOX.of(1.0, -10_000.0),
        TERRARIUM,
        GSI,
        GSI.of(0.1, 0.0),
    ];
    for code in codes {
        // Another base makes black a height.
        let has_voids = code.base_m == MAPBOX.base_m || code.encoding != Encoding::Mapbox;
        let level_m = if code.encoding == Encoding::Gsi { 20.0 } else { 900.0 };
        let land = Land::new(32, level_m, 4.0, has_voids);
        assert!(code.encoding != Encoding::Gsi || land.heights_m.iter().any(|it| *it < 0.0), "two's complement");
        for stored in STORED {
            let folder = tempfile::tempdir().unwrap();
            let path = land.write(folder.path(), code, stored, ALPS, TileRows::Xyz);
            let grid = open(&path, &code.options()).unwrap();
            assert!(land.is(&grid, code.interval_m), "{code:?} {stored:?}");
            // Planted error: a base that is one interval off.
            let mut wrong = code.options();
            if code.encoding != Encoding::Terrarium {
                wrong.height_offset_m = Some(code.base_m + 2.0 * code.interval_m);
                assert!(!land.is(&open(&path, &wrong).unwrap(), code.interval_m), "{code:?} {stored:?}");
            }
        }
    }
}

#[test]
fn a_sidecar_file_gives_base_interval_and_no_data() {
    let folder = tempfile::tempdir().unwrap();
    let code = Code { void: [255, 255, 255], ..MAPBOX.of(0.25, 100.0) };
    let land = Land::new(32, 900.0, 4.0, true);
    let path = land.write(folder.path(), code, Stored::Png, ALPS, TileRows::Xyz);
    let side = folder.path().join("a.png.toml");
    std::fs::write(&side, "encoding = \"mapbox\"\ninterval_m = 0.25\nbase_m = 100\nno_data = 16777215\n").unwrap();
    assert!(land.is(&open(&path, &OpenOptions::default()).unwrap(), 0.25));
    // Options take precedence, one by one.
    let options = OpenOptions { height_offset_m: Some(0.0), ..OpenOptions::default() };
    let shifted = open(&path, &options).unwrap();
    assert!((f64::from(shifted.heights_m[1]) - (land.heights_m[1] - 100.0)).abs() < 0.2);
    // Terrarium has one scale only, so another one is refused rather than ignored.
    let options = OpenOptions { encoding: Some(Encoding::Terrarium), ..options };
    let error = open(&path, &options).unwrap_err().to_string();
    assert!(error.contains("fixes the height scale"), "{error}");
}

/// A generator of numbers that look random (Marsaglia's xorshift).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn among<T: Copy>(&mut self, of: &[T]) -> T {
        of[(self.next() >> 33) as usize % of.len()]
    }
}

#[test]
fn no_guess_is_wrong_in_mixed_files() {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let codes = [
        MAPBOX,
        TERRARIUM,
        GSI,
        MAPBOX.of(0.1, 0.0),
        MAPBOX.of(0.1, -500.0),
        MAPBOX.of(1.0, -10_000.0),
        MAPBOX.of(0.01, -1000.0),
    ];
    // Tiles in the Alps, and in Japan.
    let places = [ALPS, [14_544, 6448]];
    let (mut right, mut refused) = (vec![0; codes.len()], 0);
    for number in 0..220 {
        let which = number % codes.len();
        let level_m = random.among(&[30.0, 300.0, 900.0, 1100.0, 1250.0, 1600.0, 2500.0, 3600.0]);
        let rise_m = random.among(&[0.3, 1.0, 3.0, 8.0, 20.0]);
        let has_voids = which != 3 && random.among(&[true, false]);
        let land = Land::new(64, level_m, rise_m, has_voids && codes[which].base_m != -500.0);
        let folder = tempfile::tempdir().unwrap();
        let stored = random.among(&STORED);
        let path = land.write(folder.path(), codes[which], stored, random.among(&places), TileRows::Xyz);
        match open(&path, &OpenOptions::default()) {
            Ok(grid) => {
                let voids_are_heights =
                    codes[which].base_m != MAPBOX.base_m && codes[which].encoding == Encoding::Mapbox;
                let is_right = land.is(&grid, codes[which].interval_m) || voids_are_heights && has_voids;
                assert!(is_right, "{:?} {stored:?} at {level_m} m, {rise_m} m per sample", codes[which]);
                right[which] += 1;
            }
            Err(error) => {
                let text = error.to_string();
                assert!(text.contains("--encoding") && !text.contains('\n') && text.len() < 400, "{text}");
                refused += 1;
            }
        }
    }
    // The refusals are not all there is: what can be told apart is read.
    assert!(right[0] > 0 && right[1] > 10 && right[2] > 5, "{right:?}, {refused} refused");
    // Planted error: the heights of another encoding are not those of this land.
    let land = Land::new(64, 1250.0, 3.0, false);
    let folder = tempfile::tempdir().unwrap();
    let path = land.write(folder.path(), GSI, Stored::Png, ALPS, TileRows::Xyz);
    assert!(!land.is(&open(&path, &MAPBOX.options()).unwrap(), 0.1));
}

#[test]
fn stray_colours_do_not_make_another_encoding() {
    // Voids in white, and a watermark that reads as a small negative number in GSI's code.
    for void in [[255, 255, 255], [255, 90, 10]] {
        let code = Code { void, ..MAPBOX };
        let land = Land::new(64, 300.0, 2.0, true);
        for stored in STORED {
            let folder = tempfile::tempdir().unwrap();
            let path = land.write(folder.path(), code, stored, ALPS, TileRows::Xyz);
            if stored == Stored::Png || stored == Stored::WebP {
                let side = folder.path().join(format!("{}.toml", path.file_name().unwrap().to_str().unwrap()));
                std::fs::write(side, "spacing_m = 30").unwrap();
            }
            match open(&path, &OpenOptions::default()) {
                Ok(grid) => assert!(land.is(&grid, code.interval_m), "{void:?} {stored:?}"),
                // Where a picture may be in Japan, the watermark leaves a choice.
                Err(error) => {
                    let text = error.to_string();
                    assert!(text.contains("mapbox (") && text.contains("gsi ("), "{text}");
                    assert!(void[1] == 90 && matches!(stored, Stored::Png | Stored::WebP), "{void:?} {stored:?}");
                }
            }
        }
    }
}

#[test]
fn rewritten_descriptions_change_the_identity() {
    let folder = tempfile::tempdir().unwrap();
    let land = Land::new(32, 900.0, 4.0, false);
    let path = land.write(folder.path(), MAPBOX, Stored::PngTiles, ALPS, TileRows::Xyz);
    let identity = |text: &str| {
        std::fs::write(path.join("tiles.json"), text).unwrap();
        source::open_reader(&path).unwrap().identity()
    };
    let custom = |blue: f64, shift: f64| {
        let (red, green) = (65_536.0 * blue, 256.0 * blue);
        format!(
            r#"{{"encoding": "custom", "redFactor": {red}, "greenFactor": {green}, "blueFactor": {blue}, "baseShift": {shift}}}"#
        )
    };
    let texts = [r#"{"encoding": "mapbox"}"#.to_owned(), r#"{"encoding": "gsi"}"#.to_owned()];
    let texts = texts.into_iter().chain([custom(0.2, 10_000.0), custom(0.2, 20_000.0), custom(0.1, 10_000.0)]);
    let texts: Vec<String> = texts.collect();
    let all: Vec<String> = texts.iter().map(|text| identity(text)).collect();
    let different: std::collections::HashSet<&String> = all.iter().collect();
    // Custom factors that are those of Mapbox are the same encoding.
    assert_eq!(different.len(), 4, "{all:?}");
    assert_eq!((&all[0], &all[0]), (&all[4], &identity(&texts[0])));
}

#[test]
fn the_row_option_decides_where_tiles_are() {
    // The rows of Australia, counted from the south, are those of Japan, where tiles may be GSI's.
    let australia = [14_544, 16_383 - 6448];
    let folder = tempfile::tempdir().unwrap();
    let land = Land::new(64, 300.0, 2.0, false);
    let tiles = land.write(folder.path(), MAPBOX, Stored::PngTiles, australia, TileRows::Xyz);
    assert!(open(&tiles, &OpenOptions::default()).is_err(), "may be Japan");
    let path = folder.path().join("a.pmtiles");
    write::pmtiles(&path, &tiles, 14, 2, "{}");
    assert!(land.is(&open(&path, &OpenOptions::default()).unwrap(), MAPBOX.interval_m));
    // A description that says TMS gives way to the option.
    std::fs::write(tiles.join("tiles.json"), r#"{"scheme": "tms"}"#).unwrap();
    assert!(open(&tiles, &OpenOptions::default()).is_err(), "Japan");
    let options = OpenOptions { tile_rows: Some(TileRows::Xyz), ..OpenOptions::default() };
    assert!(land.is(&open(&tiles, &options).unwrap(), MAPBOX.interval_m));
}

#[test]
fn a_refusal_names_the_candidates_with_their_heights() {
    let folder = tempfile::tempdir().unwrap();
    let land = Land::new(64, 1100.0, 0.3, false);
    let path = land.write(folder.path(), GSI, Stored::Png, ALPS, TileRows::Xyz);
    let error = open(&path, &OpenOptions::default()).unwrap_err().to_string();
    assert!(error.contains("its colours may be mapbox (") && error.contains("or gsi (10"), "{error}");
    // The files of a folder are not passed over for that.
    let members = hachure::internals::members(folder.path()).unwrap();
    assert_eq!(members, [path]);
}

#[test]
fn lossy_pictures_hold_no_heights() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.webp");
    // A lossy WebP of 16 × 16 grey pixels.
    std::fs::write(&path, write::LOSSY_WEBP).unwrap();
    for encoding in [None, Some(Encoding::Mapbox)] {
        let error = open(&path, &OpenOptions { encoding, ..OpenOptions::default() }).unwrap_err().to_string();
        assert!(error.contains("lossy WebP"), "{error}");
    }
    let tiles = folder.path().join("12/2138");
    std::fs::create_dir_all(&tiles).unwrap();
    std::fs::copy(&path, tiles.join("1447.webp")).unwrap();
    std::fs::remove_file(&path).unwrap();
    let error = open(folder.path(), &OpenOptions::default()).unwrap_err().to_string();
    assert!(error.contains("1447.webp: is a lossy WebP"), "{error}");
}

#[test]
fn rows_of_tiles_are_found_by_their_edges() {
    let land = Land::new(64, 900.0, 4.0, false);
    let options = |tile_rows| OpenOptions { tile_rows, ..TERRARIUM.options() };
    for rows in [TileRows::Xyz, TileRows::Tms] {
        let folder = tempfile::tempdir().unwrap();
        let path = land.write(folder.path(), TERRARIUM, Stored::PngTiles, ALPS, rows);
        let grid = open(&path, &options(None)).unwrap();
        assert!(land.is(&grid, TERRARIUM.interval_m), "{rows:?}");
        let y_m = grid.georeference.crs_from_grid[3];
        assert!((5_870_000.0..5_910_000.0).contains(&y_m), "{rows:?}: {y_m}");
        // An option is not questioned: the other one gives another land.
        let other = if rows == TileRows::Xyz { TileRows::Tms } else { TileRows::Xyz };
        assert!(!land.is(&open(&path, &options(Some(other))).unwrap(), TERRARIUM.interval_m));
        assert!(land.is(&open(&path, &options(Some(rows))).unwrap(), TERRARIUM.interval_m));
    }
}

#[test]
fn files_beside_tiles_say_what_they_are() {
    // One row of tiles: edges do not show the direction.
    let folder = tempfile::tempdir().unwrap();
    let land = Land::new(64, 900.0, 4.0, false);
    let path = land.write(folder.path(), GSI, Stored::PngTiles, ALPS, TileRows::Tms);
    for column in [8552, 8553] {
        std::fs::remove_file(path.join(format!("14/{column}/{}.png", 16_383 - 5789))).unwrap();
    }
    assert!(open(&path, &OpenOptions::default()).is_err(), "nothing gives the encoding");
    let y_m = |path: &Path| open(path, &OpenOptions::default()).unwrap().georeference.crs_from_grid[3];
    std::fs::write(path.join("tiles.json"), r#"{"encoding": "gsi"}"#).unwrap();
    assert!(y_m(&path) < 0.0);
    for srs in ["EPSG:3857", "OSGEO:41001"] {
        std::fs::write(path.join("tilemapresource.xml"), format!("<TileMap><SRS>{srs}</SRS></TileMap>")).unwrap();
        assert!((5_870_000.0..5_910_000.0).contains(&y_m(&path)), "{srs}");
    }
    std::fs::remove_file(path.join("tilemapresource.xml")).unwrap();
    std::fs::write(path.join("tiles.json"), r#"{"encoding": "gsi", "scheme": "tms"}"#).unwrap();
    assert!(y_m(&path) > 0.0);
    // TileJSON is a world itself.
    let json = folder.path().join("world.json");
    let text = r#"{"tilejson": "3.0.0", "encoding": "gsi", "tiles": ["./png/{z}/{x}/{-y}.png"]}"#;
    std::fs::write(&json, text).unwrap();
    assert!(y_m(&json) > 0.0);
    // A sidecar file is used, and does not make the file a raw one.
    std::fs::write(folder.path().join("world.json.toml"), "tile_rows = \"xyz\"").unwrap();
    assert!(y_m(&json) < 0.0);
    std::fs::remove_file(folder.path().join("world.json.toml")).unwrap();
    std::fs::write(&json, text.replace("./png", "https://example.org")).unwrap();
    let error = open(&json, &OpenOptions::default()).unwrap_err().to_string();
    assert!(error.contains("on a server"), "{error}");
    std::fs::write(path.join("tilemapresource.xml"), "<TileMap><SRS>EPSG:4326</SRS></TileMap>").unwrap();
    let error = open(&path, &OpenOptions::default()).unwrap_err().to_string();
    assert!(error.contains("EPSG:4326 is not supported"), "{error}");
}

#[test]
fn archives_of_tiles_are_one_grid() {
    let folder = tempfile::tempdir().unwrap();
    let land = Land::new(64, 900.0, 4.0, true);
    for (stored, kind) in [(Stored::PngTiles, 2), (Stored::WebPTiles, 4)] {
        let tiles = land.write(folder.path(), GSI, stored, ALPS, TileRows::Xyz);
        let path = folder.path().join("a.pmtiles");
        write::pmtiles(&path, &tiles, 14, kind, r#"{"encoding": "gsi"}"#);
        let grid = open(&path, &OpenOptions::default()).unwrap();
        assert!(land.is(&grid, GSI.interval_m), "{stored:?}");
        assert_eq!(grid.georeference, open(&tiles, &GSI.options()).unwrap().georeference);
        write::pmtiles(&path, &tiles, 14, 1, "{}");
        let error = open(&path, &OpenOptions::default()).unwrap_err().to_string();
        assert!(error.contains("vector tiles"), "{error}");
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, &bytes[..140]).unwrap();
        let error = open(&path, &OpenOptions::default()).unwrap_err().to_string();
        assert!(error.contains("a.pmtiles: is damaged"), "{error}");
    }
    std::fs::write(folder.path().join("a.mbtiles"), b"SQLite format 3\0 and so on").unwrap();
    let error = open(&folder.path().join("a.mbtiles"), &OpenOptions::default()).unwrap_err().to_string();
    assert!(error.contains("pmtiles convert"), "{error}");
}
