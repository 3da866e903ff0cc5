//! Atomic file writes: data goes to a temporary file in the same folder, which is then renamed to its final name.
//!
//! Temporary files have random names and are created with `O_EXCL`, so that nothing that somebody planted is opened: no
//! file, no link, no pipe. The reasons are in `docs/decisions/errors-and-outputs.md`.

use std::ffi::{OsStr, OsString};
use std::fs;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use tempfile::{NamedTempFile, TempDir, TempPath};

use super::input::kind;
use super::interrupt::Unfinished;

/// Number of random letters and digits in the name of a temporary file.
const RANDOM_LETTERS: usize = 12;
/// Ending of the name of a temporary file.
const ENDING: &str = ".part";
/// Longest name that is part of the name of its temporary file, in bytes; most file systems allow 255.
const LONGEST_NAME_BYTES: usize = 200;

/// The users who may read a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Readers {
    /// All whom the user's `umask` allows.
    #[default]
    Usual,
    /// Only the user: files of the cache.
    Owner,
}

/// A file that is being written. [`AtomicFile::commit`] gives it its final name; dropping it before removes it.
pub struct AtomicFile {
    final_path: PathBuf,
    partial: TempPath,
    writer: Option<BufWriter<fs::File>>,
    /// Held until the file has its final name.
    _unfinished: Unfinished,
}

impl AtomicFile {
    /// Opens a temporary file in the folder of `path`.
    pub fn create(path: &Path) -> io::Result<Self> {
        Self::create_for(path, Readers::Usual)
    }

    /// Does the same as [`AtomicFile::create`], for the given readers.
    pub(crate) fn create_for(path: &Path, readers: Readers) -> io::Result<Self> {
        if readers == Readers::Usual {
            check_replaceable(path)?;
        }
        let (prefix, folder) = prefix_and_folder(path);
        let mut builder = tempfile::Builder::new();
        builder.prefix(&prefix).suffix(ENDING).rand_bytes(RANDOM_LETTERS);
        let create = || builder.make_in(folder, |path| create_new(path, readers));
        let (created, unfinished) = Unfinished::create(create, NamedTempFile::path)?;
        let (file, partial) = created.into_parts();
        let writer = Some(BufWriter::new(file));
        Ok(Self { final_path: path.to_owned(), partial, writer, _unfinished: unfinished })
    }

    /// Returns the path of the temporary file, for libraries that open a path themselves.
    pub(crate) fn partial_path(&self) -> &Path {
        &self.partial
    }

    /// Returns the writer of the temporary file.
    pub fn writer(&mut self) -> &mut BufWriter<fs::File> {
        self.writer.as_mut().expect("the writer is there until commit, which takes self")
    }

    /// Flushes the bytes to the disk under the temporary name, for groups of files that are renamed together.
    pub fn sync(&mut self) -> io::Result<()> {
        self.writer().flush()?;
        self.writer().get_ref().sync_all()
    }

    /// Flushes the bytes to the disk and gives the file its final name.
    pub fn commit(mut self) -> io::Result<()> {
        self.sync()?;
        self.commit_unsynced()
    }

    /// Gives the file its final name. Until the system writes its bytes, a crash of the machine may lose some.
    pub(crate) fn commit_unsynced(mut self) -> io::Result<()> {
        let writer = self.writer.take().expect("the writer is there until commit, which takes self");
        drop(writer.into_inner().map_err(|error| error.into_error())?);
        self.partial.persist(&self.final_path).map_err(|error| error.error)
    }
}

/// Creates a temporary folder that only the user can enter in the folder of `path`, for a program that writes `path`.
pub(super) fn temporary_folder(path: &Path) -> io::Result<TempDir> {
    check_replaceable(path)?;
    let (prefix, folder) = prefix_and_folder(path);
    private_folder(&prefix, folder)
}

/// Creates a folder with a random name after `prefix` that only the user can enter.
pub(super) fn private_folder(prefix: &OsStr, within: &Path) -> io::Result<TempDir> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(prefix).suffix(ENDING).rand_bytes(RANDOM_LETTERS);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o700));
    // Messages name the file already, so the path that `tempfile` adds is removed.
    builder.tempdir_in(within).map_err(|error| {
        let source = error.get_ref().and_then(std::error::Error::source);
        let code = source.and_then(|source| source.downcast_ref::<io::Error>()).and_then(io::Error::raw_os_error);
        code.map_or(error, io::Error::from_raw_os_error)
    })
}

/// Checks that a rename to `path` replaces a file, a link or nothing, never a pipe, device or socket. Cache files skip
/// this check.
fn check_replaceable(path: &Path) -> io::Result<()> {
    match path.symlink_metadata() {
        Ok(found) if !found.is_file() && !found.is_symlink() && !found.is_dir() => {
            let cause = format!("it is {}, not a file", kind(found.file_type()));
            Err(io::Error::new(io::ErrorKind::InvalidInput, cause))
        }
        // A folder is reported when the file gets its name, a path that cannot be looked at when it is created.
        _ => Ok(()),
    }
}

/// Returns the beginning of the name of a temporary file, and its folder.
fn prefix_and_folder(path: &Path) -> (OsString, &Path) {
    let name = path.file_name().filter(|name| name.len() <= LONGEST_NAME_BYTES).unwrap_or(OsStr::new("hachure"));
    let mut prefix = OsString::from(".");
    prefix.push(name);
    prefix.push(".");
    (prefix, path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new(".")))
}

/// Creates a file that must not exist yet, not even as a link.
fn create_new(path: &Path, readers: Readers) -> io::Result<fs::File> {
    let mut options = fs::File::options();
    options.read(true).write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, if readers == Readers::Owner { 0o600 } else { 0o666 });
    #[cfg(not(unix))]
    let _ = readers;
    options.open(path)
}

/// Returns the name of the file for which a temporary file of this name was created; `None` if hachure does not name
/// temporary files so.
pub(crate) fn named_in_temporary(name: &str) -> Option<&str> {
    let (of, random) = name.strip_prefix('.')?.strip_suffix(ENDING)?.rsplit_once('.')?;
    // Before names were random, they had the number of the process.
    let is_random = (1..=RANDOM_LETTERS).contains(&random.len()) && random.bytes().all(|b| b.is_ascii_alphanumeric());
    (is_random && !of.is_empty()).then_some(of)
}

/// An [`AtomicFile`] for encoders that own their writer: clones share the file, and one of them commits it.
#[derive(Clone)]
pub(super) struct SharedFile(Arc<Mutex<AtomicFile>>);

impl SharedFile {
    pub(super) fn create(path: &Path) -> io::Result<Self> {
        Ok(Self(Arc::new(Mutex::new(AtomicFile::create(path)?))))
    }

    /// Commits as [`AtomicFile::commit`] does, after the encoder has been dropped.
    pub(super) fn commit(self) -> io::Result<()> {
        let file = Arc::into_inner(self.0).ok_or_else(|| io::Error::other("the encoder still holds the file"))?;
        file.into_inner().unwrap_or_else(PoisonError::into_inner).commit()
    }

    fn with<T>(&self, act: impl FnOnce(&mut BufWriter<fs::File>) -> io::Result<T>) -> io::Result<T> {
        // A poisoned lock would mean a panic within a write, after which the file is not committed anyway.
        act(self.0.lock().unwrap_or_else(PoisonError::into_inner).writer())
    }
}

impl Write for SharedFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.with(|writer| writer.write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.with(Write::flush)
    }
}

impl Seek for SharedFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.with(|writer| writer.seek(to))
    }
}

/// Writes `bytes` to `path`, completely or not at all.
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write_for(path, bytes, Readers::Usual)
}

/// Does the same as [`write`], for the given readers.
pub(crate) fn write_for(path: &Path, bytes: &[u8], readers: Readers) -> io::Result<()> {
    let mut file = AtomicFile::create_for(path, readers)?;
    file.writer().write_all(bytes)?;
    file.commit()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn temporary_files_are_recognised_by_their_names() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.png", &"x".repeat(250)] {
            let path = folder.path().join(name);
            let file = AtomicFile::create(&path).unwrap();
            let partial = file.partial_path().file_name().unwrap().to_str().unwrap().to_owned();
            assert_eq!(named_in_temporary(&partial), Some(if name.len() < 9 { name } else { "hachure" }), "{partial}");
            drop(file);
            write(&path, b"x").unwrap();
            assert_eq!(fs::read(&path).unwrap(), b"x");
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
        for name in ["ubuntu.iso.part", ".a.part", ".a..part", ".a.tif.123456789-12.part", ".a.tif.4711.party"] {
            assert_eq!(named_in_temporary(name), None, "{name}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn nothing_planted_is_opened() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        write(&at("victim"), b"mine").unwrap();
        // A link under the name of a temporary file is not followed; under the final name it is replaced.
        symlink(at("victim"), at("planted")).unwrap();
        assert!(create_new(&at("planted"), Readers::Usual).is_err());
        symlink(at("victim"), at("a.png")).unwrap();
        write(&at("a.png"), b"picture").unwrap();
        assert_eq!(
            (fs::read(at("victim")).unwrap(), fs::read(at("a.png")).unwrap()),
            (b"mine".into(), b"picture".into())
        );
        write_for(&at("cached"), b"", Readers::Owner).unwrap();
        assert_eq!(fs::metadata(at("cached")).unwrap().permissions().mode() & 0o777, 0o600);
        let _socket = std::os::unix::net::UnixListener::bind(at("socket")).unwrap();
        let error = write(&at("socket"), b"").unwrap_err().to_string();
        assert_eq!(error, "it is a socket, not a file");
    }
}
