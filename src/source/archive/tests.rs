//! Tests of archives: names, limits, sidecar files, messages.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::io::{self, ErrorKind, Write};

use super::content::{CopyError, copy};
use super::*;
use crate::file::atomic;
use crate::file::unpacked::by_archive;
use crate::tests::common::log::with_warnings;

fn dem(names: &[&str]) -> Result<String, String> {
    let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
    the_dem(Path::new("a.zip"), &names).map_err(|error| error.to_string())
}

#[test]
fn names_show_the_dem() {
    assert_eq!(dem(&["a/readme.txt", "a/dem.TIF", "a/dem.prj"]).unwrap(), "a/dem.TIF");
    assert_eq!(dem(&["points.txt"]).unwrap(), "points.txt");
    assert!(dem(&["grass.jpg"]).unwrap_err().contains("without a height file"));
    let several = dem(&["a.tif", "b/b.asc", "c.hgt", "d.dem"]).unwrap_err();
    assert!(several.contains("holds 4 height files (a.tif, b.asc, c.hgt, …)"), "{several}");
}

/// Returns a tar archive of files.
fn tar(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = tar::Builder::new(Vec::new());
    for (name, bytes) in files {
        let mut header = tar::Header::new_gnu();
        header.set_size(bytes.len() as u64);
        header.set_mode(0o644);
        archive.append_data(&mut header, name, *bytes).unwrap();
    }
    archive.into_inner().unwrap()
}

/// Writes a file, compressed if its name says so.
fn write(path: &Path, bytes: &[u8]) {
    if place::ending(path) == "tar" {
        return atomic::write(path, bytes).unwrap();
    }
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(bytes).unwrap();
    atomic::write(path, &encoder.finish().unwrap()).unwrap();
}

const ASC: &[u8] = b"ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 30\n1 2 3 4\n";

#[test]
fn containers_beyond_the_limits_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let zeros = vec![b'0'; 1 << 20];
    write(&at("a.asc.gz"), &zeros);
    write(&at("b.tgz"), &tar(&[("z.jpg", &zeros), ("dem.asc", ASC)]));
    let wanted = HashSet::from(["a.asc", "dem.asc"]);
    let error = |name: &str, limits: &Limits| {
        let unpacked = unpack(&at(name), Container::Gzip, limits, &wanted, folder.path());
        unpacked.err().map(|error| error.to_string()).unwrap_or_default()
    };
    for name in ["a.asc.gz", "b.tgz"] {
        let text = error(name, &Limits { bytes: 1 << 19, ..LIMITS });
        assert!(text.contains(&format!("{name}: unpacks to more than")) && !text.contains('\n'), "{text}");
        assert_eq!(error(name, &LIMITS), "");
    }
    assert_eq!(error("a.asc.gz", &Limits { bytes: 1 << 20, ..LIMITS }), "", "the limit itself");
    // Too many entries are an error, wherever the DEM is.
    let text = error("b.tgz", &Limits { entries: 1, ..LIMITS });
    assert!(text.contains("more than 1 entries"), "{text}");
    // A folder's archive is not searched to its end, and is left out with a warning.
    let holds = |name: &str, bytes: u64| {
        let limits = Limits { bytes, ..LISTING };
        with_warnings(|| holds_heights_within(&at(name), Container::Gzip, &limits))
    };
    assert_eq!(holds("b.tgz", 2 << 20), (true, String::new()));
    let (is_member, warnings) = holds("b.tgz", 1 << 19);
    assert!(!is_member && warnings.contains("b.tgz: left out"), "{warnings}");
    write(&at("c.tgz"), &tar(&[("dem.asc", ASC), ("z.jpg", &zeros)]));
    assert_eq!(holds("c.tgz", 1 << 19), (true, String::new()), "the DEM comes first");
}

#[test]
fn what_cannot_be_written_is_no_damage() {
    struct Full;
    impl Write for Full {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(ErrorKind::StorageFull.into())
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    let written = copy(&mut &b"x"[..], &mut Full, 9);
    assert!(matches!(written, Err(CopyError::Write(error)) if error.kind() == ErrorKind::StorageFull));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.asc.gz");
    write(&path, ASC);
    let nowhere = folder.path().join("nowhere");
    let text = unpack(&path, Container::Gzip, &LIMITS, &HashSet::from(["a.asc"]), &nowhere).unwrap_err().to_string();
    assert!(text.contains("a.asc.gz: cannot be unpacked into") && text.contains("HACHURE_CACHE"), "{text}");
    assert!(!text.contains("damaged"), "{text}");
}

#[test]
fn of_files_with_one_name_the_last_counts() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.tar");
    let prj = |code: u32| format!("PROJCS[\"a\",UNIT[\"metre\",1],AUTHORITY[\"EPSG\",\"{code}\"]]");
    let (first, last) = (prj(32610), prj(32611));
    let files = [("dem.prj", first.as_bytes()), ("dem.asc", b"old"), ("dem.prj", last.as_bytes()), ("dem.asc", ASC)];
    write(&path, &tar(&files));
    let reader = open(&path, Container::Tar, &OpenOptions::default()).unwrap();
    assert_eq!(reader.georeference().geokeys.epsg, Some(32611));
    assert_eq!(reader.read(Window::whole([2, 2])).unwrap(), [1.0, 2.0, 3.0, 4.0]);
}

#[test]
fn the_reader_inside_is_heard() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.tar");
    let header = b"ncols 2\nnrows 2\nnbits 8\nulxmap 0\nulymap 30\nxdim 30\nydim 30\n";
    write(&path, &tar(&[("dem.bil", &[1, 2, 3, 4]), ("dem.hdr", header)]));
    let (reader, warnings) = with_warnings(|| open(&path, Container::Tar, &OpenOptions::default()).unwrap());
    assert!(reader.is_coarse());
    // Messages name the archive and the file in it.
    let warnings = by_archive(warnings);
    assert!(warnings.contains(&format!("{}: has no coordinate", path.join("dem.bil").display())), "{warnings}");
    let header =
        b"ncols 2\nnrows 2\nnbits 16\npixeltype signedint\nulxmap 0\nulymap 30\nxdim 30\nydim 30\nbyteorder I\n";
    write(&path, &tar(&[("dem.bil", &[0, 128, 1, 0, 1, 0, 1, 0]), ("dem.hdr", header)]));
    let reader = open(&path, Container::Tar, &OpenOptions::default()).unwrap();
    assert!(!reader.is_coarse() && reader.warnings().is_empty());
    reader.read(Window::whole([2, 2])).unwrap();
    assert_eq!(reader.warnings(), ["samples of -32767 or -32768 are treated as no-data"]);
}

#[test]
fn the_sidecar_file_of_a_container_describes_its_content() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.r16.gz");
    write(&path, &[1, 0, 2, 0, 3, 0, 4, 0]);
    let side = folder.path().join("a.r16.gz.toml");
    let read = |scale: &str| {
        let text = format!("spacing_m = 30\nendian = \"little\"\nheight_scale_m = {scale}\n");
        atomic::write(&side, text.as_bytes()).unwrap();
        let reader = open_as_it_is(&path, &OpenOptions::default()).unwrap();
        (reader.read(Window::whole([2, 2])).unwrap(), reader.identity())
    };
    let (first, second) = (read("10"), read("5.0"));
    assert_eq!((first.0, second.0), (vec![10.0, 20.0, 30.0, 40.0], vec![5.0, 10.0, 15.0, 20.0]));
    assert_ne!(first.1, second.1);
}

#[test]
fn files_beside_the_dem_have_its_stem() {
    assert!(is_beside("a/dem.prj", "a/dem.tif") && is_beside("a/dem.tif.aux.xml", "a/dem.tif"));
    assert!(!is_beside("a/demo.prj", "a/dem.tif") && !is_beside("b/dem.prj", "a/dem.tif"));
}
