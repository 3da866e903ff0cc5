//! Folders for files that are unpacked from an archive. They are in hachure's own cache folder, so that a later run
//! finds and removes what a killed one left, and are locked while they are used.
//!
//! Messages about unpacked files name the archive: [`by_archive`].

use std::ffi::OsStr;
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use tempfile::TempDir;

use super::{atomic, cache_folder};

/// The name of the folders, before random letters.
const NAME: &str = "unpacked";
/// The file that is locked while its folder is used.
const LOCK: &str = ".lock";
/// The age from which a folder that is not locked counts as abandoned.
const ABANDONED_AFTER: Duration = Duration::from_secs(24 * 60 * 60);

/// The folders that are in use, each with the archive from which its files are.
static FOLDERS: Mutex<Vec<(PathBuf, PathBuf)>> = Mutex::new(Vec::new());

/// A folder for the files of an archive, which is removed with this value.
pub(crate) struct UnpackedFolder {
    // The lock is released before the folder is removed.
    _lock: Option<File>,
    folder: TempDir,
}

impl UnpackedFolder {
    /// Creates a folder for files of `archive`: in hachure's cache folder, or in the system's folder for temporary files
    /// if the cache cannot be written. Removes abandoned ones.
    ///
    /// # Errors
    /// Fails with the folder's parent if neither can be written.
    pub(crate) fn create(archive: &Path) -> Result<Self, (PathBuf, io::Error)> {
        let own = cache_folder::root().and_then(|root| cache_folder::open(&root).ok());
        let within_cache = own.and_then(|own| {
            remove_abandoned(&own);
            new_folder(&own).ok()
        });
        let folder = match within_cache {
            Some(folder) => folder,
            None => {
                let temporary = std::env::temp_dir();
                new_folder(&temporary).map_err(|error| (temporary, error))?
            }
        };
        // Without a lock, the folder is in use for a day.
        let lock = File::create_new(folder.path().join(LOCK)).ok();
        let lock = lock.filter(|lock| lock.try_lock().is_ok());
        let mut folders = FOLDERS.lock().unwrap_or_else(PoisonError::into_inner);
        folders.push((folder.path().to_owned(), archive.to_owned()));
        drop(folders);
        Ok(Self { _lock: lock, folder })
    }

    /// Returns the path of the folder.
    pub(crate) fn path(&self) -> &Path {
        self.folder.path()
    }
}

impl Drop for UnpackedFolder {
    fn drop(&mut self) {
        FOLDERS.lock().unwrap_or_else(PoisonError::into_inner).retain(|(folder, _)| folder != self.folder.path());
    }
}

fn new_folder(within: &Path) -> io::Result<TempDir> {
    atomic::private_folder(OsStr::new(&format!(".{NAME}.")), within)
}

/// Removes the folders of unpacked files in `within` that processes left when they were killed: they are not locked,
/// and are older than a day.
pub(crate) fn remove_abandoned(within: &Path) {
    let Ok(entries) = fs::read_dir(within) else { return };
    for entry in entries.flatten() {
        let is_own = atomic::named_in_temporary(&entry.file_name().to_string_lossy()) == Some(NAME);
        // The metadata is that of the link itself, which is not a folder.
        let Some(found) = entry.metadata().ok().filter(|found| is_own && found.is_dir()) else { continue };
        let is_old = found.modified().is_ok_and(|time| time.elapsed().is_ok_and(|age| age > ABANDONED_AFTER));
        if is_old && !is_locked(&entry.path().join(LOCK)) {
            let _ = fs::remove_dir_all(entry.path());
        }
    }
}

fn is_locked(path: &Path) -> bool {
    cache_folder::is_file(path)
        && File::open(path).is_ok_and(|file| matches!(file.try_lock(), Err(TryLockError::WouldBlock)))
}

/// Returns a message in which unpacked files are named by their archive: `a.zip/dem.tif`.
pub(crate) fn by_archive(message: String) -> String {
    let folders = FOLDERS.lock().unwrap_or_else(PoisonError::into_inner);
    folders.iter().fold(message, |message, (folder, archive)| {
        let folder = folder.display().to_string();
        if message.contains(&folder) { message.replace(&folder, &archive.display().to_string()) } else { message }
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use std::time::SystemTime;

    use super::*;

    #[test]
    fn messages_name_the_archive_while_its_files_are_used() {
        let folder = UnpackedFolder::create(Path::new("d/a.zip")).unwrap();
        let path = folder.path().to_owned();
        let message = || format!("{}: has no place; see {}", path.join("dem.tif").display(), path.display());
        let archive = Path::new("d/a.zip");
        let expected = format!("{}: has no place; see {}", archive.join("dem.tif").display(), archive.display());
        assert_eq!(by_archive(message()), expected);
        drop(folder);
        assert_eq!(by_archive(message()), message());
        assert!(!path.exists());
    }

    #[test]
    fn only_abandoned_folders_are_removed() {
        let root = tempfile::tempdir().unwrap();
        let make = |name: &str| {
            let path = root.path().join(name);
            fs::create_dir(&path).unwrap();
            File::create_new(path.join(LOCK)).unwrap();
            path
        };
        let age = |path: &Path, hours: u64| {
            let time = SystemTime::now() - Duration::from_secs(hours * 60 * 60);
            File::open(path).unwrap().set_modified(time).unwrap();
        };
        let names = [".unpacked.abcdef012345.part", ".unpacked.bbbbbb012345.part", ".unpacked.c.part", "unpacked.part"];
        let [old, locked, young, other] = names.map(make);
        let lock = File::open(locked.join(LOCK)).unwrap();
        lock.try_lock().unwrap();
        [&old, &locked, &other].iter().for_each(|path| age(path, 25));
        age(&young, 23);
        remove_abandoned(root.path());
        assert_eq!([&old, &locked, &young, &other].map(|path| path.exists()), [false, true, true, true]);
        drop(lock);
        remove_abandoned(root.path());
        assert_eq!([&locked, &young].map(|path| path.exists()), [false, true]);
    }
}
