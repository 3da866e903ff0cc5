//! DEMs as they are downloaded: compressed (`.gz`), or in an archive (`.zip`, `.tar`, `.tar.gz`) that holds one of them.
//!
//! What the DEM needs is unpacked into a temporary folder, which is removed with the reader. The names in the archive
//! decide what is unpacked: the only DEM, and the files with the same stem beside it.

use std::fs::File;
use std::io::{BufReader, Read, Write};
use std::path::{Path, PathBuf};

use flate2::bufread::MultiGzDecoder;
use tempfile::TempDir;

use super::georeference::Georeference;
use super::hgt;
use super::place::{self, cannot_open, inconsistent, unclear};
use super::reader::{HeightReader, Window};
use super::{OpenOptions, SourceError, VoidMode, open_as_it_is};
use crate::file::message::printable;

/// The kinds of container.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Container {
    Zip,
    Tar,
    /// A single file, or a tar archive, compressed with DEFLATE.
    Gzip,
}

/// Extensions of DEMs, and those of files that may be DEMs: they count where there is none of the first.
const DEM_ENDINGS: [&str; 15] =
    ["hgt", "tif", "tiff", "asc", "dem", "bil", "bip", "bsq", "flt", "dt0", "dt1", "dt2", "xyz", "nc", "pmtiles"];
const OTHER_ENDINGS: [&str; 12] = ["txt", "csv", "grd", "png", "webp", "exr", "r16", "raw", "bin", "img", "dat", "adf"];
/// Largest size of unpacked files, and DEFLATE's largest ratio with some bytes for small files.
const MAX_BYTES: u64 = 8 << 30;
const MAX_RATIO: u64 = 1032;
const FREE_BYTES: u64 = 1 << 16;
/// Largest number of entries of an archive.
const MAX_ENTRIES: usize = 1 << 16;
/// Largest number of files that an error lists.
const LISTED: usize = 3;
/// A tar archive's header is a block of this size, with a word at this offset.
const TAR_BLOCK: usize = 512;
const TAR_WORD: usize = 257;

/// Returns the kind of container that begins with these bytes; `gzip` is so short that it is no proof.
pub(super) fn proved(head: &[u8]) -> Option<Container> {
    match head {
        _ if head.starts_with(b"PK\x03\x04") => Some(Container::Zip),
        _ if head.get(TAR_WORD..TAR_WORD + 5) == Some(b"ustar") => Some(Container::Tar),
        _ => None,
    }
}

/// Returns whether these first bytes are those of a gzip file.
pub(super) fn is_gzip(head: &[u8]) -> bool {
    head.starts_with(b"\x1f\x8b\x08")
}

/// Returns whether a container holds height files, by the names in it. A damaged one counts, so that opening it reports
/// the damage.
pub(super) fn holds_heights(path: &Path, container: Container) -> bool {
    names(path, container).map_or(true, |names| names.iter().any(|name| has_ending(name, &DEM_ENDINGS)))
}

/// Opens the only DEM in a container.
pub(super) fn open(
    path: &Path,
    container: Container,
    options: &OpenOptions,
) -> Result<Box<dyn HeightReader>, SourceError> {
    let names = names(path, container)?;
    let name = the_dem(path, &names)?;
    if container == Container::Zip && has_ending(&name, &["hgt"]) {
        return Ok(Box::new(hgt::open_zip(path)?));
    }
    let folder = tempfile::Builder::new().prefix("hachure-").tempdir().map_err(cannot_open(&std::env::temp_dir()))?;
    let wanted: Vec<&String> = names.iter().filter(|other| **other == name || is_beside(other, &name)).collect();
    unpack(path, container, &wanted, folder.path())?;
    let inside = |error: SourceError| in_container(path, folder.path(), &error);
    let inner = open_as_it_is(&folder.path().join(file_name(&name)), options).map_err(inside)?;
    let given = OpenOptions { voids: VoidMode::default(), ..*options };
    let identity = place::identity(&[path], &format!("{name}\n{given:?}"));
    Ok(Box::new(Unpacked { inner, path: path.into(), identity, folder }))
}

/// Returns the name of the only DEM among the names in a container.
fn the_dem(path: &Path, names: &[String]) -> Result<String, SourceError> {
    let of = |endings: &[&str]| names.iter().filter(|name| has_ending(name, endings)).collect::<Vec<_>>();
    let mut dems = of(&DEM_ENDINGS);
    if dems.is_empty() {
        dems = of(&OTHER_ENDINGS);
    }
    match dems[..] {
        [] => Err(SourceError::UnknownFormat { path: path.into(), looks_like: "is an archive without a height file" }),
        [dem] => Ok(dem.clone()),
        _ => {
            let mut listed: Vec<&str> = dems.iter().take(LISTED).map(|name| file_name(name)).collect();
            if dems.len() > LISTED {
                listed.push("…");
            }
            let listed = printable(&listed.join(", "), 80);
            let why = format!("holds {} height files ({listed}); unpack it, and name one or the folder", dems.len());
            Err(SourceError::Unclear { path: path.into(), why })
        }
    }
}

fn file_name(name: &str) -> &str {
    name.rsplit(['/', '\\']).next().unwrap_or_default()
}

fn has_ending(name: &str, endings: &[&str]) -> bool {
    let ending = file_name(name).rsplit_once('.').map_or("", |(_, ending)| ending).to_ascii_lowercase();
    endings.contains(&&*ending)
}

/// Returns whether a file belongs to a DEM in the same folder: `dem.prj` and `dem.tif.aux.xml` to `dem.tif`.
fn is_beside(other: &str, dem: &str) -> bool {
    let folder = |name: &str| name.len() - file_name(name).len();
    let stem = file_name(dem).rsplit_once('.').map_or(file_name(dem), |(stem, _)| stem);
    other[..folder(other)] == dem[..folder(dem)]
        && file_name(other).strip_prefix(stem).is_some_and(|rest| rest.starts_with('.'))
        && !has_ending(other, &DEM_ENDINGS)
}

/// Returns whether a name in an archive may be unpacked: a visible file that is not one of macOS' own.
fn is_usable(name: &str) -> bool {
    let own = file_name(name);
    !own.is_empty() && !own.starts_with('.') && !name.starts_with("__MACOSX") && !own.contains(':')
}

/// Lists the files in a container.
fn names(path: &Path, container: Container) -> Result<Vec<String>, SourceError> {
    let mut found = Vec::new();
    visit(path, container, &mut |name, _| {
        found.push(name.to_owned());
        Ok(())
    })?;
    Ok(found)
}

/// Writes the wanted files into a folder, without the folders of their names.
fn unpack(path: &Path, container: Container, wanted: &[&String], folder: &Path) -> Result<(), SourceError> {
    let packed_bytes = std::fs::metadata(path).map_err(cannot_open(path))?.len();
    let mut left = MAX_BYTES.min(FREE_BYTES + packed_bytes.saturating_mul(MAX_RATIO));
    visit(path, container, &mut |name, content| {
        if !wanted.iter().any(|it| *it == name) {
            return Ok(());
        }
        let target = folder.join(file_name(name));
        let mut file = File::create_new(&target).map_err(cannot_open(&target))?;
        let copied =
            std::io::copy(&mut content.take(left + 1), &mut file).and_then(|bytes| file.flush().map(|()| bytes));
        let bytes = copied.map_err(|error| inconsistent(path, format!("{}: {}", file_name(name), one_line(&error))))?;
        if bytes > left {
            return Err(unclear(path, "unpacks to far more than an archive of its size can hold, or more than 8 GiB"));
        }
        left -= bytes;
        Ok(())
    })
}

/// Calls `work` with the name and the content of each file in a container.
fn visit(
    path: &Path,
    container: Container,
    work: &mut dyn FnMut(&str, &mut dyn Read) -> Result<(), SourceError>,
) -> Result<(), SourceError> {
    let file = BufReader::new(File::open(path).map_err(cannot_open(path))?);
    match container {
        Container::Zip => visit_zip(path, file, work),
        Container::Tar => visit_tar(path, file, work),
        Container::Gzip => {
            let mut beginning = Vec::new();
            let mut decoder = MultiGzDecoder::new(file);
            let damaged = |error: std::io::Error| inconsistent(path, one_line(&error));
            decoder.by_ref().take(TAR_BLOCK as u64).read_to_end(&mut beginning).map_err(damaged)?;
            let is_tar = proved(&beginning) == Some(Container::Tar);
            let mut content = std::io::Cursor::new(beginning).chain(decoder);
            if is_tar { visit_tar(path, content, work) } else { work(&unpacked_name(path), &mut content) }
        }
    }
}

/// Returns the name of a file without its compression: `dem.asc.gz` holds `dem.asc`.
fn unpacked_name(path: &Path) -> String {
    let is_compressed = place::ending(path) == "gz";
    let name = if is_compressed { path.file_stem() } else { path.file_name() };
    name.unwrap_or_default().to_string_lossy().into_owned()
}

fn visit_zip(
    path: &Path,
    file: BufReader<File>,
    work: &mut dyn FnMut(&str, &mut dyn Read) -> Result<(), SourceError>,
) -> Result<(), SourceError> {
    let damaged = |error: zip::result::ZipError| inconsistent(path, one_line(&error));
    let mut archive = zip::ZipArchive::new(file).map_err(damaged)?;
    for index in 0..archive.len().min(MAX_ENTRIES) {
        let mut member = archive.by_index(index).map_err(damaged)?;
        let name = member.name().map_err(damaged)?.into_owned();
        if member.is_file() && is_usable(&name) {
            work(&name, &mut member)?;
        }
    }
    Ok(())
}

fn visit_tar(
    path: &Path,
    content: impl Read,
    work: &mut dyn FnMut(&str, &mut dyn Read) -> Result<(), SourceError>,
) -> Result<(), SourceError> {
    let damaged = |error: std::io::Error| inconsistent(path, one_line(&error));
    let mut archive = tar::Archive::new(content);
    for member in archive.entries().map_err(damaged)?.take(MAX_ENTRIES) {
        let mut member = member.map_err(damaged)?;
        let name = String::from_utf8_lossy(&member.path_bytes()).into_owned();
        if member.header().entry_type().is_file() && is_usable(&name) {
            work(&name, &mut member)?;
        }
    }
    Ok(())
}

/// Returns a library's message without line breaks.
fn one_line(error: &dyn std::fmt::Display) -> String {
    error.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Returns the error of an unpacked file with the name of its container instead of the temporary folder.
fn in_container(path: &Path, folder: &Path, error: &SourceError) -> SourceError {
    let text = error.to_string();
    let folder = format!("{}{}", folder.display(), std::path::MAIN_SEPARATOR);
    SourceError::InArchive { path: path.into(), cause: text.replace(&folder, "") }
}

/// An unpacked DEM with the folder that holds it.
struct Unpacked {
    // The reader closes its files before the folder is removed.
    inner: Box<dyn HeightReader>,
    path: PathBuf,
    identity: String,
    folder: TempDir,
}

impl HeightReader for Unpacked {
    fn size(&self) -> [u32; 2] {
        self.inner.size()
    }

    fn georeference(&self) -> &Georeference {
        self.inner.georeference()
    }

    fn read(&self, window: Window) -> Result<Vec<f32>, SourceError> {
        self.inner.read(window).map_err(|error| in_container(&self.path, self.folder.path(), &error))
    }

    fn block(&self) -> [u32; 2] {
        self.inner.block()
    }

    fn known_m(&self, window: Window) -> Option<f32> {
        self.inner.known_m(window)
    }

    fn is_serial(&self) -> bool {
        self.inner.is_serial()
    }

    fn declared_unit_m(&self) -> Option<f64> {
        self.inner.declared_unit_m()
    }

    fn identity(&self) -> String {
        self.identity.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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

    #[test]
    fn files_beside_the_dem_have_its_stem() {
        assert!(is_beside("a/dem.prj", "a/dem.tif") && is_beside("a/dem.tif.aux.xml", "a/dem.tif"));
        assert!(!is_beside("a/demo.prj", "a/dem.tif") && !is_beside("b/dem.prj", "a/dem.tif"));
    }
}
