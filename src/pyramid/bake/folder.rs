//! The work folder `OUT.tif.parts`: one file for each finished chunk, so that an interrupted bake can be resumed, and
//! several machines can bake one pyramid.
//!
//! `bake.txt` identifies the bake that the parts belong to, and so does every part. Names are unique by chunk and files
//! appear by renaming, so no locks are needed.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::part::{Part, PartName};
use super::plan::Chunk;
use crate::file::atomic::{self, Readers};
use crate::file::cache_folder;
use crate::file::input::read_text;
use crate::file::unnamed::head;
use crate::pyramid::error::PyramidError;

const ABOUT: &str = "bake.txt";
/// Upper bound of the length of [`ABOUT`], in bytes: it names every input.
const LARGEST_ABOUT_BYTES: u64 = 64 << 20;
const FIRST_LINE: &str = "hachure: parts of a bake; removed when it is done";

/// An existing work folder of this bake.
pub(super) struct Folder {
    path: PathBuf,
    readers: Readers,
}

/// Returns `OUT.tif.parts` for `OUT.tif`.
pub(crate) fn parts_path(out: &Path) -> PathBuf {
    let mut path = out.as_os_str().to_owned();
    path.push(".parts");
    path.into()
}

/// Removes the work folder of `out` with the parts of any bake. Files that no bake put there remain.
pub(crate) fn remove_parts(out: &Path) {
    Folder { path: parts_path(out), readers: Readers::Owner }.remove();
}

impl Folder {
    /// Creates the folder or opens an existing one. With `keep`, existing parts are kept and must belong to this bake;
    /// otherwise they are removed.
    ///
    /// # Errors
    /// If the folder is not a work folder of hachure, holds the parts of another output, or, with `keep`, the parts of
    /// another bake.
    pub(super) fn open(
        out: &Path,
        bake: u64,
        identity: &str,
        keep: bool,
        readers: Readers,
    ) -> Result<Self, PyramidError> {
        let folder = Self { path: parts_path(out), readers };
        let refused = |cause: &str| PyramidError::Parts { path: folder.path.clone(), cause: cause.into() };
        let name = out.file_name().unwrap_or_default().to_string_lossy();
        let text = format!("{FIRST_LINE}\n{bake:016x}\n{name}\n{identity}\n");
        if folder.path.symlink_metadata().is_ok() {
            let about = folder.path.join(ABOUT);
            let is_begun = || {
                fs::read_dir(&folder.path)
                    .is_ok_and(|mut entries| entries.all(|entry| entry.is_ok_and(|entry| is_own(&entry))))
            };
            let found = match read_text(&about, LARGEST_ABOUT_BYTES) {
                Ok(found) => found,
                // Another process may be about to write `bake.txt`, and may have done so between the two reads.
                Err(_) if is_begun() => return folder.describe(&text),
                Err(_) => {
                    read_text(&about, LARGEST_ABOUT_BYTES).map_err(|_| refused("is not a work folder; move it away"))?
                }
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
        let created = match self.readers {
            Readers::Usual => fs::create_dir_all(&self.path),
            Readers::Owner => cache_folder::create_within(&self.path),
        };
        created.map_err(PyramidError::io(&self.path, "creating"))?;
        let about = self.path.join(ABOUT);
        match atomic::write_for(&about, text.as_bytes(), self.readers) {
            // Another machine may have written it first.
            Err(_) if read_text(&about, LARGEST_ABOUT_BYTES).is_ok_and(|found| found == text) => Ok(self),
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
        Part::write(bytes, &self.file(name.round, name.chunk), self.readers)
    }

    /// Removes all files that a bake puts there, complete or partial. Other files remain.
    fn empty(&self) -> Result<(), PyramidError> {
        let entries = fs::read_dir(&self.path).map_err(PyramidError::io(&self.path, "emptying"))?;
        for entry in entries.flatten().filter(is_own) {
            match fs::remove_file(entry.path()) {
                // Another process of the same bake removed it.
                Err(error) if error.kind() == ErrorKind::NotFound => {}
                removed => removed.map_err(PyramidError::io(&self.path, "emptying"))?,
            }
        }
        Ok(())
    }

    /// Removes the folder with all parts. Other files in it remain, and then the folder does too.
    pub(super) fn remove(self) {
        let removed = self.empty().and_then(|()| match fs::remove_dir(&self.path) {
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
            removed => removed.map_err(PyramidError::io(&self.path, "removing")),
        });
        if let Err(error) = removed {
            tracing::warn!("cannot remove the work folder: {}", error.message());
        }
    }
}

/// Returns whether a bake put a file into the work folder: its description, a part, or a temporary file of hachure.
fn is_own(entry: &fs::DirEntry) -> bool {
    let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
    if !entry.file_type().is_ok_and(|kind| kind.is_file()) {
        return false;
    }
    if name == ABOUT {
        return head(&path, FIRST_LINE.len()) == FIRST_LINE.as_bytes();
    }
    let is_part = |name: &str| name.starts_with("round") && name.ends_with(".part");
    let is_other = |of: &str| ["joined.tif", "joined.tif.tiles", ABOUT].contains(&of);
    is_part(&name) && Part::is_part(&path)
        || atomic::named_in_temporary(&name).is_some_and(|of| is_part(of) || is_other(of))
}
