//! The lock `.OUT.tif.lock` of a bake: one bake of an output at a time. Shards of one bake share it.
//!
//! The file is removed when the bake is done. A killed bake leaves it, without its lock: the next bake takes it over.
//! On Linux the file has its text before it has its name. An empty file of this name is therefore not hachure's, however
//! early a bake was killed. Where a file system has no locks, bakes run without one.

use std::fs::{self, File, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::file::unnamed::head;
use crate::pyramid::error::PyramidError;

/// The content of the file, by which hachure recognises it as its own.
const TEXT: &str = "hachure: lock of a bake; removed when it is done\n";
/// Number of attempts, if other processes create and remove the file meanwhile.
const ATTEMPTS: usize = 100;

/// The lock of a bake, held until it is dropped.
pub(crate) struct BakeLock {
    path: PathBuf,
    file: File,
}

impl BakeLock {
    /// Takes the lock of an output; shards take it together. Returns `None` where there are no locks.
    ///
    /// # Errors
    /// Fails if another process bakes this output.
    pub(crate) fn take(out: &Path, is_shard: bool) -> Result<Option<Self>, PyramidError> {
        let path = path(out);
        for _ in 0..ATTEMPTS {
            let file = match open(&path) {
                Ok(file) => file,
                // A folder that cannot be written is reported by the bake itself.
                Err(error) => {
                    tracing::debug!("{}: {error}", path.display());
                    return Ok(None);
                }
            };
            match if is_shard { file.try_lock_shared() } else { file.try_lock() } {
                Ok(()) if is_at(&file, &path) => return Ok(Some(Self { path, file })),
                // The bake that held it removed the file before it was locked here.
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    let cause = "another process is baking it; wait until it has ended, or choose another output";
                    return Err(PyramidError::Parts { path: out.to_owned(), cause: cause.to_owned() });
                }
                Err(TryLockError::Error(error)) => {
                    tracing::debug!("{}: {error}", path.display());
                    remove(&path);
                    return Ok(None);
                }
            }
        }
        Ok(None)
    }
}

impl Drop for BakeLock {
    fn drop(&mut self) {
        // The last one that holds the lock removes the file; another shard may still hold it.
        if self.file.try_lock().is_ok() && is_at(&self.file, &self.path) {
            remove(&self.path);
        }
    }
}

fn path(out: &Path) -> PathBuf {
    let mut name = std::ffi::OsString::from(".");
    name.push(out.file_name().unwrap_or_default());
    name.push(".lock");
    out.with_file_name(name)
}

/// Opens the file, or creates it. A file of the user is opened as well, and not changed; a link or pipe is not opened.
fn open(path: &Path) -> io::Result<File> {
    match path.symlink_metadata() {
        Ok(found) if found.is_file() => File::options().read(true).write(true).open(path),
        Ok(_) => Err(io::Error::new(io::ErrorKind::InvalidInput, "it is not a file")),
        Err(_) => create(path),
    }
}

/// Creates the file with its text. It must not exist yet.
fn create(path: &Path) -> io::Result<File> {
    #[cfg(target_os = "linux")]
    match create_with_text(path) {
        // The file system has no files without a name, or `/proc` is missing.
        Err(error) if error.kind() != io::ErrorKind::AlreadyExists => tracing::debug!("{}: {error}", path.display()),
        created => return created,
    }
    let mut file = File::options().read(true).write(true).create_new(true).open(path)?;
    file.write_all(TEXT.as_bytes())?;
    Ok(file)
}

/// Writes the text to a file without a name, and then names it, so that nobody sees the file without the text.
#[cfg(target_os = "linux")]
fn create_with_text(path: &Path) -> io::Result<File> {
    use rustix::fs::{AtFlags, CWD, Mode, OFlags};
    use std::os::fd::AsRawFd;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let flags = OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC;
    let mut file = File::from(rustix::fs::open(folder, flags, Mode::from_raw_mode(0o666))?);
    file.write_all(TEXT.as_bytes())?;
    let unnamed = format!("/proc/self/fd/{}", file.as_raw_fd());
    rustix::fs::linkat(CWD, unnamed, CWD, path, AtFlags::SYMLINK_FOLLOW)?;
    Ok(file)
}

/// Removes the file, if hachure wrote it.
fn remove(path: &Path) {
    if head(path, TEXT.len() + 1) == TEXT.as_bytes() {
        let _ = fs::remove_file(path);
    }
}

/// Returns whether an open file still has this path.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let place = |metadata: fs::Metadata| (metadata.dev(), metadata.ino());
    let (open, there) = (file.metadata().map(place), path.symlink_metadata().map(place));
    matches!((open, there), (Ok(open), Ok(there)) if open == there)
}

#[cfg(not(unix))]
fn is_at(_: &File, path: &Path) -> bool {
    path.exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_bake_at_a_time() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("a.tif");
        let take = |is_shard: bool| BakeLock::take(&out, is_shard).map_err(|error| error.to_string());
        let alone = take(false).unwrap();
        assert!(alone.is_some() && path(&out).exists());
        for is_shard in [false, true] {
            assert!(take(is_shard).err().unwrap().contains("another process is baking it"));
        }
        drop(alone);
        assert!(!path(&out).exists());
        let shards = [take(true).unwrap(), take(true).unwrap()];
        assert!(take(false).is_err());
        let [first, second] = shards;
        drop(first);
        assert!(path(&out).exists() && take(false).is_err(), "a shard still holds it");
        drop(second);
        assert!(!path(&out).exists());
        // A file of the user under that name stays as it is.
        crate::file::atomic::write(&path(&out), b"mine").unwrap();
        drop(take(false).unwrap());
        assert_eq!(fs::read(path(&out)).unwrap(), b"mine");
    }

    /// A bake that is killed between the creation of the file and its text would leave a file that no bake removes.
    #[cfg(target_os = "linux")]
    #[test]
    fn nobody_sees_the_lock_without_its_text() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("a.tif");
        let seen = || fs::read(path(&out)).ok();
        let is_done = std::sync::atomic::AtomicBool::new(false);
        std::thread::scope(|scope| {
            let watch = scope.spawn(|| {
                let mut whole = 0;
                while !is_done.load(std::sync::atomic::Ordering::Relaxed) {
                    if let Some(text) = seen() {
                        assert_eq!(text, TEXT.as_bytes(), "a file without its text");
                        whole += 1;
                    }
                }
                whole
            });
            for _ in 0..5000 {
                drop(BakeLock::take(&out, false).unwrap());
            }
            is_done.store(true, std::sync::atomic::Ordering::Relaxed);
            assert!(watch.join().unwrap() > 0, "the file was never seen");
        });
    }
}
