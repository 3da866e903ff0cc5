//! Inputs that are read completely into memory: styles, scenes, recipes, camera paths, models.
//!
//! Only regular files are opened, because opening a named pipe may block forever and a device may never end. A pipe
//! that the shell has already opened for the program (`/dev/stdin`, or `/dev/fd/63` from `--path <(…)`) is read as
//! well, because it ends when its writer does. Every kind of input has a size limit at which reading stops.

use std::fs::{File, FileType, Metadata};
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

/// Size limit in bytes of a style, or a recipe of marks or strokes: the presets have 2 KiB.
pub(crate) const LARGEST_STYLE_BYTES: u64 = 1 << 20;
/// Size limit in bytes of a scene: 65,536 meshes of about 150 bytes each.
pub(crate) const LARGEST_SCENE_BYTES: u64 = 16 << 20;
/// Size limit in bytes of a camera path: about two hours with a row for every frame. Parsed rows take about 10 times as
/// much memory.
pub(crate) const LARGEST_PATH_BYTES: u64 = 16 << 20;

/// Largest compression ratio of DEFLATE, and a number of bytes that are allowed in addition, for headers.
const DEFLATE_RATIO: u64 = 1032;
const HEADER_BYTES: u64 = 1 << 16;

/// Returns the largest number of bytes that a file of `file_bytes` can hold if it is compressed with DEFLATE.
pub(crate) fn most_deflated_bytes(file_bytes: u64) -> u64 {
    HEADER_BYTES.saturating_add(file_bytes.saturating_mul(DEFLATE_RATIO))
}

/// Returns an error of the system; if it is that a file does not exist, with a cause in plain words.
pub(crate) fn plain(error: Error) -> Error {
    match error.kind() {
        ErrorKind::NotFound => Error::new(ErrorKind::NotFound, "there is no such file"),
        _ => error,
    }
}

/// Opens a regular file for reading.
///
/// # Errors
/// Passes on the system's errors; rejects a folder, named pipe, device or socket and names its kind.
pub(crate) fn open_regular(path: &Path) -> Result<File> {
    // This check comes before opening, which blocks on a named pipe until another process writes to it.
    let metadata = std::fs::metadata(path).map_err(plain)?;
    if !metadata.is_file() {
        return Err(Error::new(ErrorKind::InvalidInput, format!("it is {}, not a file", kind(metadata.file_type()))));
    }
    File::open(path)
}

/// A file that returns an error when more bytes are read than its limit.
pub(crate) struct Bounded {
    file: File,
    bytes: u64,
    read_bytes: u64,
    max_bytes: u64,
}

impl Bounded {
    /// Opens a regular file, or a pipe that the shell has opened.
    ///
    /// # Errors
    /// The same as [`open_regular`]; also fails if the file is larger than `max_bytes`.
    pub(crate) fn open(path: &Path, max_bytes: u64) -> Result<Self> {
        let metadata = std::fs::metadata(path).map_err(plain)?;
        let file = if is_open_pipe(path, &metadata) { File::open(path)? } else { open_regular(path)? };
        if metadata.len() > max_bytes {
            let cause =
                format!("it has {}, but at most {} can be read", size_text(metadata.len()), size_text(max_bytes));
            return Err(Error::new(ErrorKind::FileTooLarge, cause));
        }
        Ok(Self { file, bytes: metadata.len(), read_bytes: 0, max_bytes })
    }

    /// Returns the length in bytes that the system reports: 0 for a pipe, and for some virtual files.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes
    }
}

impl Read for Bounded {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let read = self.file.read(buffer)?;
        self.read_bytes += read as u64;
        // The file may grow while it is read, and some virtual files report no length.
        if self.read_bytes > self.max_bytes {
            let cause = format!("it has more than the limit of {}", size_text(self.max_bytes));
            return Err(Error::new(ErrorKind::FileTooLarge, cause));
        }
        Ok(read)
    }
}

/// Returns the bytes of a regular file, or of a pipe that the shell has opened, if there are at most `max_bytes`.
///
/// # Errors
/// The same as [`Bounded`].
pub(crate) fn read_bytes(path: &Path, max_bytes: u64) -> Result<Vec<u8>> {
    let mut file = Bounded::open(path, max_bytes)?;
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(file.bytes as usize).map_err(|_| Error::from(ErrorKind::OutOfMemory))?;
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Reads a file as [`read_bytes`] does, and returns it as text.
///
/// # Errors
/// The same as [`read_bytes`]; also fails if the bytes are not UTF-8.
pub(crate) fn read_text(path: &Path, max_bytes: u64) -> Result<String> {
    String::from_utf8(read_bytes(path, max_bytes)?).map_err(|error| {
        let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = 1 + valid.iter().filter(|&&byte| byte == b'\n').count();
        Error::new(ErrorKind::InvalidData, format!("it is not UTF-8 text (line {line})"))
    })
}

/// Returns the kind of a path that is not a regular file, with its article.
pub(crate) fn kind(file_type: FileType) -> &'static str {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if file_type.is_fifo() {
            return "a named pipe";
        }
        if file_type.is_socket() {
            return "a socket";
        }
        if file_type.is_char_device() || file_type.is_block_device() {
            return "a device";
        }
    }
    if file_type.is_dir() { "a folder" } else { "something else" }
}

/// Returns whether a path is one of the program's own open files, and a pipe.
#[cfg(unix)]
fn is_open_pipe(path: &Path, metadata: &Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    let is_own = path == Path::new("/dev/stdin") || path.starts_with("/dev/fd") || path.starts_with("/proc/self/fd");
    is_own && metadata.file_type().is_fifo()
}

#[cfg(not(unix))]
fn is_open_pipe(_: &Path, _: &Metadata) -> bool {
    false
}

/// Formats a size for messages.
fn size_text(bytes: u64) -> String {
    match bytes {
        0..1024 => format!("{bytes} bytes"),
        1024..1_048_576 => format!("{} KiB", bytes.div_ceil(1 << 10)),
        _ => format!("{} MiB", bytes.div_ceil(1 << 20)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_texts_are_looked_at() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.toml");
        super::super::atomic::write(&path, b"a = 1\nb = \"\xff\"\n").unwrap();
        assert_eq!(read_bytes(&path, 14).unwrap().len(), 14);
        assert_eq!(read_text(&path, 14).unwrap_err().to_string(), "it is not UTF-8 text (line 2)");
        let error = read_bytes(&path, 13).unwrap_err();
        assert_eq!(error.to_string(), "it has 14 bytes, but at most 13 bytes can be read");
        let error = read_bytes(folder.path(), 13).unwrap_err();
        assert_eq!(error.to_string(), "it is a folder, not a file");
        let error = read_text(&folder.path().join("y"), 1).unwrap_err();
        assert_eq!((error.kind(), error.to_string().as_str()), (ErrorKind::NotFound, "there is no such file"));
        assert_eq!([size_text(3), size_text(1 << 14), size_text((16 << 20) + 1)], ["3 bytes", "16 KiB", "17 MiB"]);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn files_without_a_length_end_at_the_limit() {
        // Virtual files of the kernel report a length of 0 bytes.
        let path = Path::new("/proc/self/maps");
        let error = read_bytes(path, 100).unwrap_err();
        assert_eq!(error.to_string(), "it has more than the limit of 100 bytes");
        assert!(read_bytes(path, 1 << 24).unwrap().len() > 100);
    }
}
