//! Rasters of any size are described in bounded memory, and a lack of memory is an error of one line.
//!
//! Peak memory is measured per process, so each measurement runs this test program again, with a file to read.

use std::io::Write;
use std::path::Path;
use std::process::Command;

use hachure::internals::statistics;
use hachure::source::{self, Silent, Window};

use super::{memory, sparse};

const FILE: &str = "HACHURE_FUZZ_MEASURED_FILE";
const HOW: &str = "HACHURE_FUZZ_MEASURED_HOW";

/// Returns how much memory a new process needs to read `file`, in MB; `how` is passed to [`measured`].
fn megabytes(file: &Path, how: &str) -> Option<u64> {
    let mut child = Command::new(std::env::current_exe().unwrap());
    child.args(["--exact", "bounded::measured", "--ignored", "--nocapture"]).env(FILE, file).env(HOW, how);
    let output = child.output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    let (_, rest) = text.split_once("peak MB: ")?;
    Some(rest.split_whitespace().next().unwrap().parse().unwrap())
}

#[test]
#[ignore = "run as a separate process by the tests below"]
fn measured() {
    let Some(file) = std::env::var_os(FILE) else { return };
    let path = Path::new(&file);
    let before = memory::reset();
    match std::env::var(HOW).as_deref() {
        Ok("whole") => drop(source::open(path, &Silent)),
        Ok("windows") => {
            let reader = source::open_reader(path).unwrap();
            let [width, height] = reader.size();
            for [x, y] in [[width - 300, height - 300], [0, 0], [width / 2, height / 3]] {
                assert_eq!(reader.read(Window { x, y, width: 300, height: 300 }).unwrap().len(), 90_000);
            }
        }
        _ => {
            let reader = source::open_reader(path).unwrap();
            let found = statistics(&*reader, path, &Silent).unwrap();
            println!("{found:?}");
        }
    }
    if let (Some(before), Some(peak)) = (before, memory::peak_bytes()) {
        println!("peak MB: {}", (peak - before) / 1_000_000);
    }
}

/// Compares the memory for several ways of reading a file with bounds, in MB.
fn check(path: &Path, bounds: &[(&str, std::ops::Range<u64>)]) {
    for (how, bound) in bounds {
        match megabytes(path, how) {
            Some(found) => assert!(bound.contains(&found), "{}, {how}: {found} MB, expected {bound:?}", path.display()),
            None => println!("skipped: the system does not report the memory of a process"),
        }
    }
}

#[test]
fn a_sparse_raster_takes_no_more_than_what_it_stores() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sparse.tif");
    let side = 40_448;
    sparse::write(&path, side);
    assert!(std::fs::metadata(&path).unwrap().len() < 2_000_000);
    // The whole raster would be 6.5 GB.
    check(&path, &[("statistics", 0..300), ("windows", 0..300)]);

    let reader = source::open_reader(&path).unwrap();
    let found = statistics(&*reader, &path, &Silent).unwrap();
    assert_eq!(([found.min_m, found.max_m], found.void_samples), sparse::expected(side));
    // Heights that are known without reading equal those that are read.
    let window = Window { x: 5000, y: 512, width: 700, height: 30 };
    assert!(reader.known_m(window).unwrap().is_nan() && reader.read(window).unwrap().iter().all(|it| it.is_nan()));
    assert_eq!(reader.known_m(Window { x: 500, y: 500, ..window }), None);
}

#[test]
fn a_picture_is_decoded_by_rows() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("heights.png");
    let side = 8192;
    let mut encoder = png::Encoder::new(std::fs::File::create(&path).unwrap(), side, side);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    encoder.set_compression(png::Compression::Fastest);
    let mut writer = encoder.write_header().unwrap();
    let mut rows = writer.stream_writer().unwrap();
    for row in 0..side {
        let bytes: Vec<u8> = (0..side).flat_map(|column| ((row ^ column) as u16).to_be_bytes()).collect();
        rows.write_all(&bytes).unwrap();
    }
    rows.finish().unwrap();
    drop(writer);
    // The file has 134 MB uncompressed, and 268 MB as heights, so reading all of it into memory would be noticed.
    check(&path, &[("statistics", 0..60), ("windows", 100..200), ("whole", 250..400)]);

    let reader = source::open_reader(&path).unwrap();
    let found = statistics(&*reader, &path, &Silent).unwrap();
    assert_eq!((found.min_m, found.max_m, found.void_samples), (0.0, 8191.0, 0));
}

#[test]
#[cfg(target_os = "linux")]
fn missing_memory_gives_an_error_of_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("large.asc");
    let header = "ncols 16000\nnrows 16000\nxllcorner 0\nyllcorner 0\ncellsize 1\n".to_owned();
    std::fs::write(&path, header + &"7 ".repeat(2000)).unwrap();
    // A hole in the file, which takes no space on disk.
    std::fs::File::options().append(true).open(&path).unwrap().set_len(600_000_000).unwrap();
    let script = "ulimit -v 900000 && exec \"$0\" info \"$1\"";
    let output = Command::new("sh").args(["-c", script, env!("CARGO_BIN_EXE_hachure")]).arg(&path).output().unwrap();
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{error}");
    // It is preceded by a warning that the grid has no CRS.
    let expected = "large.asc: not enough memory: reading 16000×16000 samples at once needs 1024 MB; convert it to a tiled GeoTIFF\n";
    assert!(error.ends_with(expected) && error.lines().count() == 2, "{error}");
}

#[test]
fn a_picture_that_claims_more_than_its_file_holds_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("claims.png");
    for side in [16_000, 60_000, 0x7fff_ffff] {
        let mut encoder = png::Encoder::new(std::fs::File::create(&path).unwrap(), side, side);
        encoder.set_color(png::ColorType::Rgb);
        let idat = [0x78, 0x9c, 3, 0, 0, 0, 0, 1];
        encoder.write_header().unwrap().write_chunk(png::chunk::IDAT, &idat).unwrap();
        let error = hachure::file::png::read_rgba8(&path).unwrap_err().to_string();
        assert!(error.contains("claims.png") && !error.contains('\n'), "{error}");
    }
}
