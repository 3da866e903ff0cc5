//! Reading at places of a file from several threads at once, without a position that they would share.

use std::fs::File;
use std::io;
use std::path::Path;

use super::input::open_regular;

/// An open file that is read at given places.
#[derive(Debug)]
pub struct RandomAccess {
    #[cfg(unix)]
    file: File,
    #[cfg(not(unix))]
    file: std::sync::Mutex<File>,
}

impl RandomAccess {
    /// Opens a file for reading.
    ///
    /// # Errors
    /// The system's; a pipe, device or folder.
    pub fn open(path: &Path) -> io::Result<Self> {
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
    /// The system's, and [`io::ErrorKind::UnexpectedEof`] where the file is shorter.
    #[cfg(unix)]
    pub fn read_exact_at(&self, buffer: &mut [u8], offset: u64) -> io::Result<()> {
        std::os::unix::fs::FileExt::read_exact_at(&self.file, buffer, offset)
    }

    /// Fills `buffer` with the bytes from `offset` on.
    ///
    /// # Errors
    /// The system's, and [`io::ErrorKind::UnexpectedEof`] where the file is shorter.
    #[cfg(not(unix))]
    pub fn read_exact_at(&self, buffer: &mut [u8], offset: u64) -> io::Result<()> {
        use std::io::{Read, Seek, SeekFrom};
        // The position is set before each read, so a panic elsewhere does not spoil it.
        let mut file = self.file.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        file.seek(SeekFrom::Start(offset))?;
        file.read_exact(buffer)
    }

    /// The `count` bytes from `offset` on.
    ///
    /// # Errors
    /// As [`RandomAccess::read_exact_at`].
    pub fn read(&self, offset: u64, count: usize) -> io::Result<Vec<u8>> {
        let mut bytes = vec![0; count];
        self.read_exact_at(&mut bytes, offset)?;
        Ok(bytes)
    }

    /// The length of the file in bytes, as it is now.
    ///
    /// # Errors
    /// The system's.
    #[cfg(unix)]
    pub fn len(&self) -> io::Result<u64> {
        Ok(self.file.metadata()?.len())
    }

    /// The length of the file in bytes, as it is now.
    ///
    /// # Errors
    /// The system's.
    #[cfg(not(unix))]
    pub fn len(&self) -> io::Result<u64> {
        Ok(self.file.lock().unwrap_or_else(std::sync::PoisonError::into_inner).metadata()?.len())
    }

    /// Whether the file is empty.
    ///
    /// # Errors
    /// The system's.
    pub fn is_empty(&self) -> io::Result<bool> {
        Ok(self.len()? == 0)
    }
}
