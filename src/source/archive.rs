//! DEMs as they are downloaded: compressed (`.gz`), or in an archive (`.zip`, `.tar`, `.tar.gz`) that holds one of them.
//!
//! What the DEM needs is unpacked into a folder of the cache ([`UnpackedFolder`]), which is removed with the reader. The
//! names in the archive decide what is unpacked: the only DEM, and its sidecar files, which have the same stem.

use std::collections::HashSet;
use std::fs::File;
use std::io::{self, BufReader, ErrorKind, Read, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use flate2::bufread::MultiGzDecoder;

use super::georeference::Georeference;
use super::hgt;
use super::place::{self, cannot_open, foreign_message, inconsistent, unclear};
use super::reader::{HeightReader, Window};
use super::sidecar::sidecar_path;
use super::{OpenOptions, SourceError, VoidMode, open_as_it_is};
use crate::file::input::most_deflated_bytes;
use crate::file::message::printable;
use crate::file::unpacked::UnpackedFolder;

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
/// What is read of a container at most.
#[derive(Clone, Copy, Debug)]
struct Limits {
    /// Size of unpacked files in bytes, and of a compressed tar archive as a whole.
    bytes: u64,
    /// Number of entries.
    entries: usize,
}

const LIMITS: Limits = Limits { bytes: 8 << 30, entries: 1 << 16 };
/// The limits while the files of a folder are listed, which must be fast.
const LISTING: Limits = Limits { bytes: 256 << 20, ..LIMITS };

/// Largest number of files that an error lists.
const LISTED: usize = 3;
/// A tar archive's header is a block of this size, with a word at this offset.
const TAR_BLOCK: usize = 512;
const TAR_WORD: usize = 257;

/// Returns the kind of container that begins with these bytes; gzip's signature of three bytes is checked separately
/// ([`is_gzip`]).
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
    holds_heights_within(path, container, &LISTING)
}

fn holds_heights_within(path: &Path, container: Container, limits: &Limits) -> bool {
    let mut is_found = false;
    let visited = visit(path, container, limits, &mut |name, _| {
        is_found = has_ending(name, &DEM_ENDINGS);
        Ok(if is_found { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
    });
    match visited {
        Ok(()) => is_found,
        Err(SourceError::Unclear { .. }) => {
            tracing::warn!(
                "{}: left out, because its first {} MiB hold no height file; name it to have all of it searched",
                path.display(),
                limits.bytes >> 20
            );
            false
        }
        Err(_) => true,
    }
}

/// Opens the only DEM in a container.
pub(super) fn open(
    path: &Path,
    container: Container,
    options: &OpenOptions,
) -> Result<Box<dyn HeightReader>, SourceError> {
    let names = names(path, container, &LIMITS)?;
    let name = the_dem(path, &names)?;
    if container == Container::Zip && has_ending(&name, &["hgt"]) {
        return Ok(Box::new(hgt::open_zip(path)?));
    }
    let cannot_unpack = |(folder, source)| SourceError::Unpack { path: path.into(), folder, source };
    let folder = UnpackedFolder::create(path).map_err(cannot_unpack)?;
    let wanted: HashSet<&str> =
        names.iter().filter(|other| **other == name || is_beside(other, &name)).map(String::as_str).collect();
    unpack(path, container, &LIMITS, &wanted, folder.path())?;
    // The sidecar file of the container describes what is inside, unless that has its own.
    let (dem, sidecar) = (folder.path().join(file_name(&name)), sidecar_path(path));
    if let (Some(sidecar), None) = (&sidecar, sidecar_path(&dem)) {
        let mut target = dem.as_os_str().to_owned();
        target.push(".toml");
        let copied = std::fs::copy(sidecar, target);
        copied.map_err(|source| cannot_unpack((folder.path().to_owned(), source)))?;
    }
    let inside = |error: SourceError| in_container(path, folder.path(), &error);
    let inner = open_as_it_is(&dem, options).map_err(inside)?;
    let given = OpenOptions { voids: VoidMode::default(), ..*options };
    let files: Vec<&Path> = std::iter::once(path).chain(sidecar.as_deref()).collect();
    let identity = place::identity(&files, &format!("{name}\n{given:?}"));
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

/// Lists the files in a container, each name once.
fn names(path: &Path, container: Container, limits: &Limits) -> Result<Vec<String>, SourceError> {
    let (mut found, mut known) = (Vec::new(), HashSet::new());
    visit(path, container, limits, &mut |name, _| {
        if known.insert(name.to_owned()) {
            found.push(name.to_owned());
        }
        Ok(ControlFlow::Continue(()))
    })?;
    Ok(found)
}

/// The failure of a copy, of which only a failed read is the container's fault.
enum CopyError {
    Read(io::Error),
    Write(io::Error),
}

/// Copies all bytes, and returns their number; fails beyond `most`.
fn copy(content: &mut dyn Read, target: &mut dyn Write, most: u64) -> Result<u64, CopyError> {
    let mut content = Capped { content, left: most };
    let mut buffer = vec![0; 1 << 16];
    let mut copied = 0;
    loop {
        match content.read(&mut buffer) {
            Ok(0) => break,
            Ok(count) => {
                target.write_all(&buffer[..count]).map_err(CopyError::Write)?;
                copied += count as u64;
            }
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(CopyError::Read(error)),
        }
    }
    target.flush().map_err(CopyError::Write)?;
    Ok(copied)
}

/// Writes the wanted files into a folder, without the folders of their names. Of several with one name, the last counts.
fn unpack(
    path: &Path,
    container: Container,
    limits: &Limits,
    wanted: &HashSet<&str>,
    folder: &Path,
) -> Result<(), SourceError> {
    let mut left = most_bytes(path, limits)?;
    visit(path, container, limits, &mut |name, content| {
        if !wanted.contains(name) {
            return Ok(ControlFlow::Continue(()));
        }
        let unwritten = |source| SourceError::Unpack { path: path.into(), folder: folder.into(), source };
        let mut file = File::create(folder.join(file_name(name))).map_err(unwritten)?;
        left -= copy(content, &mut file, left).map_err(|error| match error {
            CopyError::Write(error) => unwritten(error),
            CopyError::Read(error) if error.kind() == ErrorKind::FileTooLarge => failed(path, &error),
            CopyError::Read(error) => {
                inconsistent(path, format!("{}: {}", printable(file_name(name), 80), foreign_message(&error)))
            }
        })?;
        Ok(ControlFlow::Continue(()))
    })
}

/// Returns the largest number of bytes that may be unpacked from a container.
fn most_bytes(path: &Path, limits: &Limits) -> Result<u64, SourceError> {
    let packed = std::fs::metadata(path).map_err(cannot_open(path))?.len();
    Ok(limits.bytes.min(most_deflated_bytes(packed)))
}

/// Content that fails if more of it is read than is left.
struct Capped<R> {
    content: R,
    left: u64,
}

impl<R: Read> Read for Capped<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let within = buffer.len().min(usize::try_from(self.left).unwrap_or(usize::MAX));
        if within == 0 && !buffer.is_empty() {
            // Content that ends here is not too long.
            return match self.content.read(&mut [0])? {
                0 => Ok(0),
                _ => Err(io::Error::from(ErrorKind::FileTooLarge)),
            };
        }
        let read = self.content.read(&mut buffer[..within])?;
        self.left -= read as u64;
        Ok(read)
    }
}

/// Returns the error of a container that cannot be read.
fn failed(path: &Path, error: &io::Error) -> SourceError {
    match error.kind() {
        ErrorKind::FileTooLarge => {
            unclear(path, "unpacks to more than 8 GiB, or to more than an archive of its size can hold")
        }
        _ => inconsistent(path, foreign_message(error)),
    }
}

fn too_many_entries(path: &Path, limits: &Limits) -> SourceError {
    unclear(path, format!("has more than {} entries; unpack it, and name the DEM or the folder", limits.entries))
}

/// What is done with the name and the content of a file, and whether others follow.
type Work<'a> = dyn FnMut(&str, &mut dyn Read) -> Result<ControlFlow<()>, SourceError> + 'a;

/// Calls `work` for each file in a container.
fn visit(path: &Path, container: Container, limits: &Limits, work: &mut Work<'_>) -> Result<(), SourceError> {
    let file = BufReader::new(File::open(path).map_err(cannot_open(path))?);
    match container {
        Container::Zip => visit_zip(path, file, limits, work),
        Container::Tar => visit_tar(path, file, limits, work),
        Container::Gzip => {
            let mut beginning = Vec::new();
            let mut decoder = MultiGzDecoder::new(file);
            let read = decoder.by_ref().take(TAR_BLOCK as u64).read_to_end(&mut beginning);
            read.map_err(|error| failed(path, &error))?;
            let is_tar = proved(&beginning) == Some(Container::Tar);
            let content = io::Cursor::new(beginning).chain(decoder);
            let mut content = Capped { content, left: most_bytes(path, limits)? };
            match is_tar {
                true => visit_tar(path, content, limits, work),
                false => work(&unpacked_name(path), &mut content).map(|_| ()),
            }
        }
    }
}

/// Returns the name of a file without its compression: `dem.asc.gz` holds `dem.asc`.
fn unpacked_name(path: &Path) -> String {
    let is_compressed = place::ending(path) == "gz";
    let name = if is_compressed { path.file_stem() } else { path.file_name() };
    name.unwrap_or_default().to_string_lossy().into_owned()
}

fn visit_zip(path: &Path, file: BufReader<File>, limits: &Limits, work: &mut Work<'_>) -> Result<(), SourceError> {
    let damaged = |error: zip::result::ZipError| inconsistent(path, foreign_message(&error));
    let mut archive = zip::ZipArchive::new(file).map_err(damaged)?;
    if archive.len() > limits.entries {
        return Err(too_many_entries(path, limits));
    }
    for index in 0..archive.len() {
        let mut member = archive.by_index(index).map_err(damaged)?;
        let name = member.name().map_err(damaged)?.into_owned();
        if member.is_file() && is_usable(&name) && work(&name, &mut member)?.is_break() {
            break;
        }
    }
    Ok(())
}

fn visit_tar(path: &Path, content: impl Read, limits: &Limits, work: &mut Work<'_>) -> Result<(), SourceError> {
    let mut archive = tar::Archive::new(content);
    for (index, member) in archive.entries().map_err(|error| failed(path, &error))?.enumerate() {
        if index >= limits.entries {
            return Err(too_many_entries(path, limits));
        }
        let mut member = member.map_err(|error| failed(path, &error))?;
        let name = String::from_utf8_lossy(&member.path_bytes()).into_owned();
        let is_file = member.header().entry_type().is_file();
        if is_file && is_usable(&name) && work(&name, &mut member)?.is_break() {
            break;
        }
    }
    Ok(())
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
    folder: UnpackedFolder,
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

    fn is_coarse(&self) -> bool {
        self.inner.is_coarse()
    }

    fn warnings(&self) -> Vec<String> {
        self.inner.warnings()
    }

    fn identity(&self) -> String {
        self.identity.clone()
    }
}

#[cfg(test)]
mod tests {
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
        let text =
            unpack(&path, Container::Gzip, &LIMITS, &HashSet::from(["a.asc"]), &nowhere).unwrap_err().to_string();
        assert!(text.contains("a.asc.gz: cannot be unpacked into") && text.contains("HACHURE_CACHE"), "{text}");
        assert!(!text.contains("damaged"), "{text}");
    }

    #[test]
    fn of_files_with_one_name_the_last_counts() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.tar");
        let prj = |code: u32| format!("PROJCS[\"a\",UNIT[\"metre\",1],AUTHORITY[\"EPSG\",\"{code}\"]]");
        let (first, last) = (prj(32610), prj(32611));
        let files =
            [("dem.prj", first.as_bytes()), ("dem.asc", b"old"), ("dem.prj", last.as_bytes()), ("dem.asc", ASC)];
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
        let header = b"ncols 2\nnrows 2\nnbits 16\nulxmap 0\nulymap 30\nxdim 30\nydim 30\nbyteorder I\n";
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
}
