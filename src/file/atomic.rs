//! Atomic file writes: data goes to a temporary file in the same folder, which is then renamed to its final name.
//!
//! The reasons are in `docs/decisions/errors-and-outputs.md`.

use std::fs;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// A file that is being written. [`AtomicFile::commit`] gives it its final name; dropping it before removes it.
pub struct AtomicFile {
    final_path: PathBuf,
    partial_path: PathBuf,
    writer: Option<BufWriter<fs::File>>,
}

impl AtomicFile {
    /// Opens a temporary file in the folder of `path`.
    pub fn create(path: &Path) -> io::Result<Self> {
        let partial_path = partial_path(path);
        #[expect(clippy::disallowed_methods, reason = "this is the one place that may: the file is renamed when whole")]
        let file = fs::File::create(&partial_path)?;
        Ok(Self { final_path: path.to_owned(), partial_path, writer: Some(BufWriter::new(file)) })
    }

    /// Returns the path of the temporary file, for libraries that open a path themselves.
    pub(crate) fn partial_path(&self) -> &Path {
        &self.partial_path
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
        let writer = self.writer.take().expect("the writer is there until commit, which takes self");
        let file = writer.into_inner().map_err(|error| error.into_error())?;
        file.sync_all()?;
        drop(file);
        fs::rename(&self.partial_path, &self.final_path)
    }
}

impl Drop for AtomicFile {
    fn drop(&mut self) {
        // After a commit the temporary file is gone and this does nothing.
        let _ = fs::remove_file(&self.partial_path);
    }
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
    let mut file = AtomicFile::create(path)?;
    file.writer().write_all(bytes)?;
    file.commit()
}

/// Returns the name of the temporary file. It is in the same folder, so that the rename stays on one file system, and
/// contains the process id.
pub(crate) fn partial_path(path: &Path) -> PathBuf {
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{}.part", std::process::id()));
    path.with_file_name(name)
}
