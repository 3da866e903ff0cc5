//! What hachure writes: pictures, channels, lines, films. Every output is written beside its name and then renamed, so
//! that a stopped run leaves the old file or none; [`guard`] keeps outputs from replacing inputs. [`input`] reads what
//! is small enough to be held in memory.

pub mod atomic;
pub mod exr;
pub mod geojson;
pub mod geojson_polygons;
pub mod geotiff;
pub mod guard;
pub mod hdr;
pub mod imprint;
pub mod input;
pub mod message;
pub mod pattern;
pub mod png;
pub mod random_access;
pub mod standard;
pub mod svg;
pub mod toml_text;
pub mod video;

use std::path::{Path, PathBuf};

use message::named;

/// Why an output was not written, or a picture not read. One line that names the file and the cause.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FileError {
    /// An output was not written; what stood there before still does.
    #[error("cannot write {}: {cause}", named(path))]
    Write {
        /// The output.
        path: PathBuf,
        /// What the system or the encoder said.
        cause: String,
    },
    /// A picture was not read.
    #[error("cannot read {}: {cause}", named(path))]
    Read {
        /// The picture.
        path: PathBuf,
        /// What the system or the decoder said.
        cause: String,
    },
    /// An output name that hachure does not know how to write.
    #[error("{}: {cause}", named(path))]
    Name {
        /// The name as given.
        path: PathBuf,
        /// What is wrong with it, and what would be right.
        cause: String,
    },
    /// An output that is read by the same command.
    #[error("{}: is the input {}; hachure does not overwrite what it reads", path.display(), input.display())]
    IsInput {
        /// The output as given.
        path: PathBuf,
        /// The input, which may have another name.
        input: PathBuf,
    },
    /// An output that the same command would take for one of its inputs the next time.
    #[error(
        "{}: lies in {}, all of which is read, and would be an input the next time; name a place outside of it",
        path.display(), folder.display()
    )]
    WouldBeInput {
        /// The output as given.
        path: PathBuf,
        /// Whose files are read.
        folder: PathBuf,
    },
    /// There is no ffmpeg on this machine.
    #[error(
        "cannot write {}: hachure writes .mp4 through ffmpeg, which is not installed; \
         frames can be written as PNG with a pattern like dir/%05d.png",
        named(path)
    )]
    NoFfmpeg {
        /// The film.
        path: PathBuf,
    },
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

/// A text without line breaks and rows of spaces: what an error may take of foreign words.
pub fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The number of samples of a picture that is neither empty nor too large to count.
fn sample_count(path: &Path, width: u32, height: u32) -> Result<usize, FileError> {
    // Both formats keep sizes as signed 32-bit numbers.
    let fits = |size: u32| (1..=i32::MAX as u32).contains(&size);
    if !fits(width) || !fits(height) {
        return Err(FileError::write(path, format!("a picture of {width}x{height} pixels cannot be written")));
    }
    (width as usize)
        .checked_mul(height as usize)
        .ok_or_else(|| FileError::write(path, format!("a picture of {width}x{height} pixels is too large")))
}
