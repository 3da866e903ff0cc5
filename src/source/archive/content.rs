//! The content of a container: the names and the bytes of its files, within limits.

use std::collections::HashSet;
use std::fs::File;
use std::io::{self, BufReader, ErrorKind, Read, Write};
use std::ops::ControlFlow;
use std::path::Path;

use flate2::bufread::MultiGzDecoder;

use super::Container;
use crate::file::input::most_deflated_bytes;
use crate::file::message::printable;
use crate::source::SourceError;
use crate::source::place::{self, cannot_open, foreign_message, inconsistent, unclear};

/// The limits within which a container is read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Size of unpacked files in bytes, and of a compressed tar archive as a whole.
    pub bytes: u64,
    /// Number of entries.
    pub entries: usize,
}

pub(super) const LIMITS: Limits = Limits { bytes: 8 << 30, entries: 1 << 16 };
/// The limits while the files of a folder are listed, which must be fast.
pub(super) const LISTING: Limits = Limits { bytes: 256 << 20, ..LIMITS };

/// A tar archive's header is a block of this size, with a word at this offset.
const TAR_BLOCK: usize = 512;
const TAR_WORD: usize = 257;

/// Returns the kind of container that begins with these bytes; gzip's signature of three bytes is checked separately
/// ([`super::is_gzip`]).
pub(in crate::source) fn proved(head: &[u8]) -> Option<Container> {
    match head {
        _ if head.starts_with(b"PK\x03\x04") => Some(Container::Zip),
        _ if head.get(TAR_WORD..TAR_WORD + 5) == Some(b"ustar") => Some(Container::Tar),
        _ => None,
    }
}

pub(super) fn file_name(name: &str) -> &str {
    name.rsplit(['/', '\\']).next().unwrap_or_default()
}

/// Returns whether a name in an archive may be unpacked: a visible file that is not one of macOS' own.
fn is_usable(name: &str) -> bool {
    let own = file_name(name);
    !own.is_empty() && !own.starts_with('.') && !name.starts_with("__MACOSX") && !own.contains(':')
}

/// Lists the files in a container, each name once.
pub(super) fn names(path: &Path, container: Container, limits: &Limits) -> Result<Vec<String>, SourceError> {
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
pub(super) enum CopyError {
    Read(io::Error),
    Write(io::Error),
}

/// Copies all bytes, and returns their number; fails beyond `most`.
pub(super) fn copy(content: &mut dyn Read, target: &mut dyn Write, most: u64) -> Result<u64, CopyError> {
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
pub(super) fn unpack(
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
        let mut file = File::options()
            .write(true)
            .create(true)
            .truncate(true)
            .open(folder.join(file_name(name)))
            .map_err(unwritten)?;
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

/// A function that receives the name and the content of a file; its result decides whether others follow.
type Work<'a> = dyn FnMut(&str, &mut dyn Read) -> Result<ControlFlow<()>, SourceError> + 'a;

/// Calls `work` for each file in a container.
pub(super) fn visit(
    path: &Path,
    container: Container,
    limits: &Limits,
    work: &mut Work<'_>,
) -> Result<(), SourceError> {
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
