//! hachure's own folder within a folder for caches. The folder for caches may be anybody's: it is named by
//! `HACHURE_CACHE`, and may hold files of the user or be shared by several users.
//!
//! The own folder has the user's number in its name, is readable by this user alone, and is marked by `CACHEDIR.TAG`,
//! which also makes backup programs skip it. A folder that is not marked, belongs to another user, or can be written by
//! others is not used, because its content may be somebody's files, or forged.
//!
//! Why: `docs/decisions/cache-heals.md`.

use std::fs::{self, Metadata};
use std::io::{self, Error, ErrorKind};
use std::path::{Path, PathBuf};

use super::atomic::{self, Readers};
use super::input::read_bytes;
use super::unnamed::head;

/// The name of the marker, from the Cache Directory Tagging Specification.
const TAG: &str = "CACHEDIR.TAG";
/// The content of the marker. Its first line is prescribed.
const TAG_TEXT: &str = "Signature: 8a477f597d28d172789f06886806bc55\n\
    # This folder is a cache of hachure. Everything in it can be deleted.\n\
    # Cache directory tags: https://bford.info/cachedir/\n";

/// Returns the folder that holds hachure's own: `HACHURE_CACHE`, otherwise the system's cache folder for hachure.
pub(crate) fn root() -> Option<PathBuf> {
    if let Some(folder) = std::env::var_os("HACHURE_CACHE").filter(|folder| !folder.is_empty()) {
        return Some(folder.into());
    }
    Some(directories::ProjectDirs::from("", "", "hachure")?.cache_dir().to_owned())
}

/// Opens hachure's own folder in `root`, and creates both if they do not exist.
///
/// # Errors
/// Passes on the system's errors. Refuses a folder of another user, one that other users may write to, and one without
/// the marker.
pub fn open(root: &Path) -> io::Result<PathBuf> {
    let folder = root.join(name());
    match folder.symlink_metadata() {
        Ok(found) => check(root, &folder, &found)?,
        Err(error) if error.kind() == ErrorKind::NotFound => create(root, &folder)?,
        Err(error) => return Err(error),
    }
    Ok(folder)
}

/// Returns the name of the own folder, which has the user's number.
#[cfg(unix)]
fn name() -> String {
    format!("hachure-{}", rustix::process::geteuid().as_raw())
}

/// Returns the name of the own folder.
#[cfg(not(unix))]
fn name() -> String {
    "hachure-cache".to_owned()
}

fn create(root: &Path, folder: &Path) -> io::Result<()> {
    fs::create_dir_all(root)?;
    let made = atomic::private_folder(".hachure-".as_ref(), root)?;
    atomic::write_for(&made.path().join(TAG), TAG_TEXT.as_bytes(), Readers::Owner)?;
    // The folder appears with its marker. Another process may have been faster; a rename replaces no folder with files.
    match fs::rename(made.path(), folder) {
        Ok(()) => Ok(()),
        Err(error) => check(root, folder, &folder.symlink_metadata().map_err(|_| error)?),
    }
}

/// Checks that a folder that exists is hachure's own.
fn check(root: &Path, folder: &Path, found: &Metadata) -> io::Result<()> {
    let refused = |cause: &str| {
        let name = folder.file_name().unwrap_or_default().to_string_lossy();
        Err(Error::new(ErrorKind::PermissionDenied, format!("{name} in it {cause}")))
    };
    if !found.is_dir() {
        return refused("is not a folder");
    }
    if !is_private(root, found) {
        return refused("belongs to another user, or others may write to it");
    }
    let tag = folder.join(TAG);
    let signature = TAG_TEXT.lines().next().unwrap_or_default().as_bytes();
    if head(&tag, signature.len()) == signature {
        return Ok(());
    }
    // A folder without files has nothing to protect.
    if fs::read_dir(folder)?.next().is_none() {
        return atomic::write_for(&tag, TAG_TEXT.as_bytes(), Readers::Owner);
    }
    refused("was not made by hachure: it has no CACHEDIR.TAG")
}

/// Returns whether a folder belongs to this user, and others cannot write to it.
#[cfg(unix)]
fn is_private(root: &Path, found: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    const WRITABLE_BY_OTHERS: u32 = 0o022;
    let user = rustix::process::geteuid().as_raw();
    if found.uid() == user && found.mode() & WRITABLE_BY_OTHERS == 0 {
        return true;
    }
    // Some file systems have no owners or no permissions (FAT), or replace them (NFS). They do the same to a new file.
    let new = tempfile::Builder::new().prefix(".hachure-").tempfile_in(root).and_then(|file| file.as_file().metadata());
    new.is_ok_and(|new| {
        let is_writable = |mode: u32| mode & WRITABLE_BY_OTHERS & !(new.mode() & WRITABLE_BY_OTHERS) != 0;
        found.uid() == new.uid() && !is_writable(found.mode())
    })
}

#[cfg(not(unix))]
fn is_private(_: &Path, _: &Metadata) -> bool {
    true
}

/// Creates a folder within the own folder, readable by this user alone.
///
/// # Errors
/// Passes on the system's errors.
pub(crate) fn create_within(folder: &Path) -> io::Result<()> {
    let mut builder = fs::DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(folder)
}

/// Writes a file of the cache, readable by this user alone, and creates its folder.
///
/// # Errors
/// Passes on the system's errors.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    if let Some(folder) = path.parent() {
        create_within(folder)?;
    }
    atomic::write_for(path, bytes, Readers::Owner)
}

/// Returns whether a path of the cache is a file, and no link, pipe or device, which would lead elsewhere or wait.
pub(crate) fn is_file(path: &Path) -> bool {
    path.symlink_metadata().is_ok_and(|found| found.is_file())
}

/// Returns the bytes of a file of the cache; `None` if it does not exist, is not a file, or has more than `max_bytes`.
pub(crate) fn read(path: &Path, max_bytes: u64) -> Option<Vec<u8>> {
    is_file(path).then(|| read_bytes(path, max_bytes).ok()).flatten()
}

#[cfg(all(test, unix))]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};

    use super::*;

    fn set_mode(path: &Path, mode: u32) {
        fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
    }

    #[test]
    fn only_an_own_folder_is_used() {
        let root = tempfile::tempdir().unwrap();
        atomic::write(&root.path().join("mine.tif"), b"mine").unwrap();
        let folder = open(&root.path().join("new/cache")).unwrap();
        assert_eq!(fs::metadata(&folder).unwrap().mode() & 0o777, 0o700);
        write(&folder.join("marks/a.tam"), b"x").unwrap();
        let modes = ["marks", "marks/a.tam", TAG].map(|name| fs::metadata(folder.join(name)).unwrap().mode() & 0o777);
        assert_eq!(modes, [0o700, 0o600, 0o600]);
        assert_eq!(open(&root.path().join("new/cache")).unwrap(), folder);
        assert_eq!(fs::read_dir(root.path().join("new/cache")).unwrap().count(), 1, "something else is left");
        // A folder that others may write to, without the marker, or behind a link may hold anything.
        set_mode(&folder, 0o777);
        let open_again = || open(&root.path().join("new/cache")).map_err(|error| error.to_string());
        assert!(open_again().unwrap_err().contains("others may write to it"));
        set_mode(&folder, 0o755);
        assert!(open_again().is_ok());
        fs::remove_file(folder.join(TAG)).unwrap();
        assert!(open_again().unwrap_err().contains("it has no CACHEDIR.TAG"));
        fs::rename(&folder, root.path().join("elsewhere")).unwrap();
        symlink(root.path().join("elsewhere"), &folder).unwrap();
        assert!(open_again().unwrap_err().contains("is not a folder"));
    }

    #[test]
    fn links_and_pipes_are_no_cached_files() {
        let root = tempfile::tempdir().unwrap();
        let at = |name: &str| root.path().join(name);
        write(&at("a"), b"xyz").unwrap();
        symlink(at("a"), at("link")).unwrap();
        assert!(std::process::Command::new("mkfifo").arg(at("pipe")).status().unwrap().success());
        assert_eq!(read(&at("a"), 3), Some(b"xyz".into()));
        assert_eq!(
            [read(&at("a"), 2), read(&at("link"), 9), read(&at("pipe"), 9), read(&at("none"), 9)],
            [None::<Vec<u8>>, None, None, None]
        );
    }
}
