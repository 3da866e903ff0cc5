//! Keeps a command from overwriting its inputs: its inputs are collected before it writes anything.
//!
//! Two names denote one file if they resolve to the same path, links included, or to the same device and inode (hard
//! links, names that differ only in case where the file system ignores case). On systems without inodes only the path
//! counts. Folders that are read as a whole are inputs too, because the next run would read a new file in them.

use std::collections::HashMap;
use std::fs::Metadata;
use std::path::{Path, PathBuf};

use super::FileError;

/// Returns whether a path is read.
pub(crate) type IsRead = fn(&Path) -> bool;

/// All files that a command reads.
#[derive(Debug, Default)]
pub(crate) struct Inputs {
    files: HashMap<Identity, Vec<Input>>,
    folders: Vec<Folder>,
}

/// An identity of a file. A file may have both kinds.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Identity {
    /// Path without links and dots.
    Place(PathBuf),
    /// Device and inode.
    #[cfg(unix)]
    Inode(u64, u64),
}

#[derive(Clone, Debug)]
struct Input {
    path: PathBuf,
    is_read: IsRead,
}

impl Input {
    fn is_read(&self) -> bool {
        (self.is_read)(&self.path)
    }
}

#[derive(Debug)]
struct Folder {
    path: PathBuf,
    place: PathBuf,
    would_be_read: IsRead,
}

impl Inputs {
    /// Adds a file. A missing file cannot be overwritten, and opening it fails soon enough.
    pub(crate) fn add(&mut self, path: &Path) {
        self.add_if(path, |_| true);
    }

    /// Adds a file that is read if `is_read` returns true, which is only called if an output has this path.
    pub(crate) fn add_if(&mut self, path: &Path, is_read: IsRead) {
        for identity in identities(path) {
            self.files.entry(identity).or_default().push(Input { path: path.to_owned(), is_read });
        }
    }

    /// Adds a folder that is read as a whole. `would_be_read` takes a path relative to the folder and returns whether
    /// the next run would read a file there.
    pub(crate) fn add_folder(&mut self, folder: &Path, would_be_read: IsRead) {
        if let Ok(place) = folder.canonicalize() {
            self.folders.push(Folder { path: folder.to_owned(), place, would_be_read });
        }
    }

    /// Checks that a file may be written.
    ///
    /// # Errors
    /// Returns [`FileError::IsInput`] or [`FileError::WouldBeInput`].
    pub(crate) fn check(&self, output: &Path) -> Result<(), FileError> {
        let mut found = identities(output).filter_map(|identity| self.files.get(&identity)).flatten();
        if let Some(input) = found.find(|input| input.is_read()) {
            return Err(FileError::IsInput { path: output.to_owned(), input: input.path.clone() });
        }
        if self.folders.is_empty() {
            return Ok(());
        }
        let place = place(output);
        let is_in = |folder: &&Folder| place.strip_prefix(&folder.place).is_ok_and(folder.would_be_read);
        match self.folders.iter().find(is_in) {
            Some(folder) => Err(FileError::WouldBeInput { path: output.to_owned(), folder: folder.path.clone() }),
            None => Ok(()),
        }
    }

    /// Checks that a folder may be emptied and removed, because no input is inside.
    ///
    /// # Errors
    /// Returns [`FileError::IsInput`] if an input is inside the folder.
    pub(crate) fn check_folder(&self, folder: &Path) -> Result<(), FileError> {
        let Ok(inside) = folder.canonicalize() else { return Ok(()) };
        let is_inside = |identity: &Identity| matches!(identity, Identity::Place(place) if place.starts_with(&inside));
        let mut inputs = self.files.iter().filter(|(identity, _)| is_inside(identity)).flat_map(|(_, inputs)| inputs);
        match inputs.find(|input| input.is_read()) {
            Some(input) => Err(FileError::IsInput { path: folder.to_owned(), input: input.path.clone() }),
            None => Ok(()),
        }
    }
}

/// Returns an identity of a file that does not depend on its name, if the file exists.
pub(crate) fn identity(path: &Path) -> Option<Identity> {
    identities(path).next()
}

/// Returns all identities of the file at `path`; none if there is no file.
fn identities(path: &Path) -> impl Iterator<Item = Identity> {
    let metadata = std::fs::metadata(path).ok();
    let place = metadata.as_ref().and_then(|_| path.canonicalize().ok());
    metadata.and_then(|metadata| inode(&metadata)).into_iter().chain(place.map(Identity::Place))
}

#[cfg(unix)]
fn inode(metadata: &Metadata) -> Option<Identity> {
    use std::os::unix::fs::MetadataExt;
    Some(Identity::Inode(metadata.dev(), metadata.ino()))
}

#[cfg(not(unix))]
fn inode(_: &Metadata) -> Option<Identity> {
    None
}

/// Returns the path of an existing or future file, without links and dots in the part that exists.
fn place(path: &Path) -> PathBuf {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let mut rest = Vec::new();
    let mut there = absolute.as_path();
    loop {
        if let Ok(place) = there.canonicalize() {
            return rest.iter().rev().fold(place, |place, name| place.join(name));
        }
        match (there.parent(), there.file_name()) {
            (Some(parent), Some(name)) => {
                rest.push(name);
                there = parent;
            }
            _ => return absolute,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::atomic;

    #[test]
    fn a_file_is_itself_under_every_name() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        atomic::write(&at("a.tif"), b"heights").unwrap();
        atomic::write(&at("b.tif"), b"heights").unwrap();
        std::fs::create_dir(at("sub")).unwrap();
        let mut inputs = Inputs::default();
        // The same file can be added by two readers, of which one does not read it.
        inputs.add_if(&at("a.tif"), |_| false);
        assert_eq!(inputs.check(&at("a.tif")), Ok(()));
        inputs.add(&at("a.tif"));
        inputs.add(&at("nowhere.tif"));
        let mut same = vec![at("a.tif"), at("sub/../a.tif"), at("./a.tif")];
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(at("a.tif"), at("link.tif")).unwrap();
            std::os::unix::fs::symlink(folder.path(), at("sub/up")).unwrap();
            std::fs::hard_link(at("a.tif"), at("hard.tif")).unwrap();
            same.extend([at("link.tif"), at("sub/up/a.tif"), at("hard.tif")]);
        }
        for path in same {
            assert!(matches!(inputs.check(&path), Err(FileError::IsInput { .. })), "{}", path.display());
        }
        for name in ["b.tif", "c.tif", "nowhere.tif", "no/folder/a.tif"] {
            assert_eq!(inputs.check(&at(name)), Ok(()), "{name}");
        }
        assert!(inputs.check_folder(folder.path()).is_err());
        assert_eq!(inputs.check_folder(&at("sub")), Ok(()));
        assert_eq!(inputs.check_folder(&at("nowhere")), Ok(()));
    }

    #[test]
    fn a_folder_with_an_input_inside_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("tiles")).unwrap();
        let mut inputs = Inputs::default();
        inputs.add_folder(&at("tiles"), |path| path.extension().is_some_and(|ending| ending == "tif"));
        atomic::write(&at("tiles/a.tif"), b"").unwrap();
        for name in ["tiles/new.tif", "tiles/new/x.tif", "tiles/../tiles/a.tif"] {
            assert!(matches!(inputs.check(&at(name)), Err(FileError::WouldBeInput { .. })), "{name}");
        }
        for name in ["new.tif", "tiles/new.png", "tiles.tif", "tiles/../new.tif"] {
            assert_eq!(inputs.check(&at(name)), Ok(()), "{name}");
        }
    }
}
