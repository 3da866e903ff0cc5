//! File outputs: pictures, channels, lines, films. Every output is written to a temporary file and then renamed, so
//! that an interrupted run leaves the old file or none; [`guard`] keeps outputs from replacing inputs, [`unnamed`] keeps
//! them from replacing files of the user. [`input`] reads files that are small enough to be held in memory.

pub mod atomic;
pub(crate) mod cache_folder;
pub mod exr;
pub mod frame_rate;
pub(crate) mod geojson;
pub(crate) mod geojson_polygons;
pub(crate) mod geotiff;
pub mod gif;
pub(crate) mod glb;
pub(crate) mod guard;
pub(crate) mod hdr;
pub mod imprint;
pub(crate) mod input;
pub(crate) mod interrupt;
pub(crate) mod jpg;
pub(crate) mod message;
pub(crate) mod mp4;
pub(crate) mod open_files;
pub(crate) mod pattern;
pub(crate) mod pdf;
pub mod png;
mod process;
pub(crate) mod progress_lines;
pub(crate) mod random_access;
pub(crate) mod standard;
pub(crate) mod stl;
pub(crate) mod svg;
pub(crate) mod toml_text;
pub(crate) mod unnamed;
pub(crate) mod unpacked;
pub mod video;

use std::path::{Path, PathBuf};

use message::named;
pub(crate) use message::one_line;

/// The reason why an output was not written, or a picture not read. One line that names the file and the cause.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FileError {
    /// An output was not written; an existing file was left unchanged.
    #[error("cannot write {}: {cause}", named(path))]
    Write {
        path: PathBuf,
        /// The message of the system or the encoder.
        cause: String,
    },
    /// A picture was not read.
    #[error("cannot read {}: {cause}", named(path))]
    Read {
        path: PathBuf,
        /// The message of the system or the decoder.
        cause: String,
    },
    /// The name of an output has no format that hachure writes.
    #[error("{}: {cause}", named(path))]
    Name {
        /// The name as given.
        path: PathBuf,
        /// The mistake in the name, and the valid names.
        cause: String,
    },
    /// The output is also an input of the same command.
    #[error("{}: is the input {}; hachure does not overwrite its inputs", path.display(), input.display())]
    IsInput {
        /// The output as given.
        path: PathBuf,
        /// The input, which may have another name.
        input: PathBuf,
    },
    /// The same command would read the output as one of its inputs in the next run.
    #[error(
        "{}: is in the input folder {} and would be an input of the next run; choose a path outside that folder",
        path.display(), folder.display()
    )]
    WouldBeInput {
        /// The output as given.
        path: PathBuf,
        /// The folder whose files are read.
        folder: PathBuf,
    },
    /// A file that the user did not name would be replaced, and hachure did not write it.
    #[error(
        "{}: this file exists, and hachure did not write it; move it away, choose another output, or replace it with \
         --overwrite",
        named(path)
    )]
    NotOwn { path: PathBuf },
    /// A sidecar file of a picture would be replaced, and the existing picture does not record it.
    #[error(
        "{}: this file exists, and {} does not record it as hachure's; move it away, or replace it with --overwrite",
        named(path),
        named(picture)
    )]
    NotRecorded {
        path: PathBuf,
        /// The picture, which may not exist.
        picture: PathBuf,
    },
    /// ffmpeg is not installed.
    #[error(
        "cannot write {}: hachure writes .mp4 through ffmpeg, which is not installed; \
         frames can be written as PNG with a pattern like dir/%05d.png",
        named(path)
    )]
    NoFfmpeg { path: PathBuf },
}

impl FileError {
    pub(crate) fn write(path: &Path, cause: impl ToString) -> Self {
        Self::Write { path: path.to_owned(), cause: one_line(&cause.to_string()) }
    }

    fn read(path: &Path, cause: impl ToString) -> Self {
        Self::Read { path: path.to_owned(), cause: one_line(&cause.to_string()) }
    }

    fn name(path: &Path, cause: impl ToString) -> Self {
        Self::Name { path: path.to_owned(), cause: cause.to_string() }
    }
}

/// Returns the number of samples of a picture; fails if it is empty or too large to count.
fn sample_count(path: &Path, width: u32, height: u32) -> Result<usize, FileError> {
    // Both formats store sizes as signed 32-bit numbers.
    let fits = |size: u32| (1..=i32::MAX as u32).contains(&size);
    if !fits(width) || !fits(height) {
        return Err(FileError::write(path, format!("a picture of {width}x{height} pixels cannot be written")));
    }
    (width as usize)
        .checked_mul(height as usize)
        .ok_or_else(|| FileError::write(path, format!("a picture of {width}x{height} pixels is too large")))
}
