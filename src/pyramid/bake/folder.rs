//! The work folder `OUT.tif.parts`: one file for each finished chunk, so that an interrupted bake can be resumed, and
//! several machines can bake one pyramid.
//!
//! `bake.txt` identifies the bake that the parts belong to, and so does every part. Names are unique by chunk and files
//! appear by renaming, so no locks are needed.

use std::fs;
use std::path::{Path, PathBuf};

use super::part::{Part, PartName};
use super::plan::Chunk;
use crate::file::atomic;
use crate::pyramid::error::PyramidError;

const ABOUT: &str = "bake.txt";
const FIRST_LINE: &str = "hachure: parts of a bake; removed when it is done";

/// An existing work folder of this bake.
pub(super) struct Folder {
    path: PathBuf,
}

/// Returns `OUT.tif.parts` for `OUT.tif`.
pub(crate) fn parts_path(out: &Path) -> PathBuf {
    let mut path = out.as_os_str().to_owned();
    path.push(".parts");
    path.into()
}

impl Folder {
    /// Creates the folder or opens an existing one. With `keep`, existing parts are kept and must belong to this bake;
    /// otherwise they are removed.
    ///
    /// # Errors
    /// If the folder is not a work folder of hachure, holds the parts of another output, or, with `keep`, the parts of
    /// another bake.
    pub(super) fn open(out: &Path, bake: u64, identity: &str, keep: bool) -> Result<Self, PyramidError> {
        let folder = Self { path: parts_path(out) };
        let refused = |cause: &str| PyramidError::Parts { path: folder.path.clone(), cause: cause.into() };
        let name = out.file_name().unwrap_or_default().to_string_lossy();
        let text = format!("{FIRST_LINE}\n{bake:016x}\n{name}\n{identity}\n");
        if folder.path.symlink_metadata().is_ok() {
            let about = folder.path.join(ABOUT);
            let begun = |entry: fs::DirEntry| entry.file_name().to_string_lossy().ends_with(".part");
            let is_begun =
                || fs::read_dir(&folder.path).is_ok_and(|mut entries| entries.all(|entry| entry.is_ok_and(begun)));
            let found = match fs::read_to_string(&about) {
                Ok(found) => found,
                // Another process may be about to write `bake.txt`, and may have done so between the two reads.
                Err(_) if is_begun() => return folder.describe(&text),
                Err(_) => fs::read_to_string(&about).map_err(|_| refused("is not a work folder; move it away"))?,
            };
            let lines: Vec<&str> = found.lines().collect();
            if lines.first() != Some(&FIRST_LINE) || lines.get(2) != Some(&&*name) {
                return Err(refused("holds the parts of another pyramid; move it away"));
            }
            let same = lines.get(1) == Some(&&*format!("{bake:016x}"));
            match (keep, same) {
                (true, true) => return Ok(folder),
                (true, false) => {
                    return Err(refused(
                        "holds the parts of another bake (of other inputs or options, or by another version)",
                    ));
                }
                (false, _) => folder.empty()?,
            }
        }
        folder.describe(&text)
    }

    fn describe(self, text: &str) -> Result<Self, PyramidError> {
        fs::create_dir_all(&self.path).map_err(PyramidError::io(&self.path, "creating"))?;
        let about = self.path.join(ABOUT);
        match atomic::write(&about, text.as_bytes()) {
            // Another machine may have written it first.
            Err(_) if fs::read_to_string(&about).is_ok_and(|found| found == text) => Ok(self),
            written => written.map(|()| self).map_err(PyramidError::io(&about, "writing")),
        }
    }

    /// Returns the path of the folder.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    fn file(&self, round: u32, Chunk { x, y }: Chunk) -> PathBuf {
        self.path.join(format!("round{}-y{y:04}-x{x:04}.part", round + 1))
    }

    /// Opens a part, if it exists and is undamaged.
    pub(super) fn part(&self, name: PartName) -> Option<Part> {
        let path = self.file(name.round, name.chunk);
        let part = Part::open(&path, name);
        if part.is_none() && path.exists() {
            tracing::warn!("{}: the part is damaged and is baked again", path.display());
        }
        part
    }

    /// Writes a part to its file in the folder, atomically.
    pub(super) fn write(&self, name: PartName, bytes: &[u8]) -> Result<Part, PyramidError> {
        Part::write(bytes, &self.file(name.round, name.chunk))
    }

    /// Removes all files that a bake puts there, complete or partial.
    fn empty(&self) -> Result<(), PyramidError> {
        let entries = fs::read_dir(&self.path).map_err(PyramidError::io(&self.path, "emptying"))?;
        for entry in entries.flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            if name.ends_with(".part") || name == ABOUT {
                fs::remove_file(entry.path()).map_err(PyramidError::io(&self.path, "emptying"))?;
            }
        }
        Ok(())
    }

    /// Removes the folder with all parts. Other files in it remain.
    pub(super) fn remove(self) {
        if self
            .empty()
            .and_then(|()| fs::remove_dir(&self.path).map_err(PyramidError::io(&self.path, "removing")))
            .is_err()
        {
            tracing::warn!("{}: cannot remove the work folder", self.path.display());
        }
    }
}
