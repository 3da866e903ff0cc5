//! Reads a file at given offsets from several threads at once, without a shared position.

use std::fs::File;
use std::io;
use std::path::Path;

use super::input::open_regular;

/// An open file that is read at given offsets.
#[derive(Debug)]
pub(crate) struct RandomAccess {
    #[cfg(unix)]
    file: File,
    #[cfg(not(unix))]
    file: std::sync::Mutex<File>,
}

impl RandomAccess {
    /// Opens a file for reading.
    ///
    /// # Errors
    /// Passes on the system's errors; also fails for a pipe, device or folder.
    pub(crate) fn open(path: &Path) -> io::Result<Self> {
        open_regular(path).map(Self::new)
    }

    #[cfg(unix)]
    fn new(file: File) -> Self {
        Self { file }
    }

    #[cfg(not(unix))]
    fn new(file: File) -> Self {
        Self { file: std::sync::Mutex::new(file) }
    }

    /// Fills `buffer` with the bytes from `offset` on.
    ///
    /// # Errors
    /// Passes on the system's errors; returns [`io::ErrorKind::UnexpectedEof`] if the file is shorter.
    #[cfg(unix)]
    pub(crate) fn read_exact_at(&self, buffer: &mut [u8], offset: u64) -> io::Result<()> {
        std::os::unix::fs::FileExt::read_exact_at(&self.file, buffer, offset)
    }

    /// Fills `buffer` with the bytes from `offset` on.
    ///
    /// # Errors
    /// Passes on the system's errors; returns [`io::ErrorKind::UnexpectedEof`] if the file is shorter.
    #[cfg(not(unix))]
    pub(crate) fn read_exact_at(&self, buffer: &mut [u8], offset: u64) -> io::Result<()> {
        use std::io::{Read, Seek, SeekFrom};
        // The position is set before each read, so that a panic in another thread does no harm.
        let mut file = self.file.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        file.seek(SeekFrom::Start(offset))?;
        file.read_exact(buffer)
    }

    /// Returns `count` bytes from `offset` on.
    ///
    /// # Errors
    /// The same as [`RandomAccess::read_exact_at`].
    pub(crate) fn read(&self, offset: u64, count: usize) -> io::Result<Vec<u8>> {
        let mut bytes = vec![0; count];
        self.read_exact_at(&mut bytes, offset)?;
        Ok(bytes)
    }

    /// Returns the current length of the file in bytes.
    ///
    /// # Errors
    /// Passes on the system's errors.
    #[cfg(unix)]
    pub(crate) fn len(&self) -> io::Result<u64> {
        Ok(self.file.metadata()?.len())
    }

    /// Returns the current length of the file in bytes.
    ///
    /// # Errors
    /// Passes on the system's errors.
    #[cfg(not(unix))]
    pub(crate) fn len(&self) -> io::Result<u64> {
        Ok(self.file.lock().unwrap_or_else(std::sync::PoisonError::into_inner).metadata()?.len())
    }
}
