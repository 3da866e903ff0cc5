//! Files that the user did not name: the world file of a map, the sheets of a poster, the frames of a pattern, the
//! statistics of a pyramid, the files of a report. They are created, and replaced only if hachure wrote them.
//!
//! How hachure recognises its own files:
//!
//! - A picture has an imprint ([`super::imprint`]), and an older PNG at least the text `Software`. The imprint of a
//!   sheet ends with the name of the sheet. A GeoJSON begins with the name of the program ([`super::geojson::is_own`]).
//! - Sidecar files of a picture ([`SideFile`]) have formats without room for a mark. The last line of the picture's
//!   imprint records the checksum and length of each, as a comment, which readers of imprints skip.
//! - Files of hachure's own formats begin with their magic bytes.
//!
//! Why: `docs/decisions/unnamed-files.md`.

use std::io::Read;
use std::path::{Path, PathBuf};

use super::input::open_regular;
use super::message::named;
use super::{FileError, geojson, imprint, png};

/// Begins the last line of the imprint of a picture with sidecar files.
const RECORD: &str = "# files beside this picture (CRC-32 and bytes):";
/// Begins the last line of the imprint of a sheet.
const SHEET: &str = "# sheet ";
/// Largest sidecar file that is compared, in bytes; they have about a thousand.
const LARGEST_SIDE_FILE_BYTES: usize = 1 << 20;

/// Checks that a file that the user did not name may be written: it does not exist, `is_own` recognises it, or the user
/// allowed it with `--overwrite`. A link is never hachure's own.
///
/// # Errors
/// Returns [`FileError::NotOwn`].
pub(crate) fn check(path: &Path, overwrite: bool, is_own: impl FnOnce(&Path) -> bool) -> Result<(), FileError> {
    // A path that cannot be looked at cannot be written either, and writing reports the cause.
    let Ok(found) = path.symlink_metadata() else { return Ok(()) };
    match found.is_file() && is_own(path) || overwrite && !found.is_dir() {
        true => Ok(()),
        false => Err(FileError::NotOwn { path: path.to_owned() }),
    }
}

/// Returns the first `bytes` bytes of a regular file, fewer if it is shorter, and none if it cannot be read.
pub(crate) fn head(path: &Path, bytes: usize) -> Vec<u8> {
    let mut head = Vec::new();
    if let Ok(file) = open_regular(path) {
        // Bytes that were read before an error are compared all the same, and do not match.
        let _ = file.take(bytes as u64).read_to_end(&mut head);
    }
    head
}

/// Returns whether hachure drew the picture at `path`, in any format that has an imprint.
pub(crate) fn is_drawing(path: &Path) -> bool {
    png::is_drawing(path) || imprint::read(path).is_ok()
}

/// Returns whether hachure drew the file at `path`: a picture, or a GeoJSON, which has no imprint.
pub(crate) fn is_export(path: &Path) -> bool {
    is_drawing(path) || geojson::is_own(path)
}

/// Returns the message about a picture that hachure drew where a world is expected.
pub(crate) fn is_no_world(picture: &Path) -> String {
    format!("{0}: a picture that hachure drew, not land; draw it again with hachure render --like {0}", named(picture))
}

/// Returns the imprint of a sheet: the poster's with the name of the sheet.
pub(crate) fn imprint_of_sheet(poster: &str, sheet: &str) -> String {
    format!("{}\n{SHEET}{sheet}\n", poster.trim_end_matches('\n'))
}

/// Returns whether the file at `path` is the sheet of this name of a poster that hachure drew.
pub(crate) fn is_sheet(path: &Path, sheet: &str) -> bool {
    last_line(path).is_some_and(|line| line.strip_prefix(SHEET) == Some(sheet))
}

/// Returns the last line of a picture's imprint.
fn last_line(picture: &Path) -> Option<String> {
    Some(imprint::read(picture).ok()?.lines().next_back()?.to_owned())
}

/// Returns the path of a picture's world file: `.pgw` of a `.png`, `.jgw` of a `.jpg`.
pub(crate) fn world_file_path(picture: &Path) -> PathBuf {
    let is_png = picture.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png"));
    picture.with_extension(if is_png { "pgw" } else { "jgw" })
}

/// Returns the path of the file that holds a picture's reference system, which GDAL reads: `NAME.png.aux.xml`.
pub(crate) fn aux_path(picture: &Path) -> PathBuf {
    let mut name = picture.as_os_str().to_owned();
    name.push(".aux.xml");
    name.into()
}

/// A sidecar file of a picture, such as a world file: its path and its content.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct SideFile {
    pub(crate) path: PathBuf,
    pub(crate) text: String,
}

fn digest(bytes: &[u8]) -> String {
    format!("{:08x}-{}", crc32fast::hash(bytes), bytes.len())
}

/// Returns the imprint of a picture with a record of its sidecar files.
pub(crate) fn imprint_with(imprint: &str, files: &[SideFile]) -> String {
    let digests: Vec<String> = files.iter().map(|file| digest(file.text.as_bytes())).collect();
    match digests.is_empty() {
        true => imprint.to_owned(),
        false => format!("{}\n{RECORD} {}\n", imprint.trim_end_matches('\n'), digests.join(" ")),
    }
}

/// Returns the digests of the sidecar files of a picture that its imprint records.
fn recorded(picture: &Path) -> Vec<String> {
    let line = last_line(picture).unwrap_or_default();
    line.strip_prefix(RECORD).unwrap_or_default().split_whitespace().map(str::to_owned).collect()
}

/// Checks that the sidecar files of `picture` may be written: each does not exist, has this content already, or is
/// recorded in the imprint of the existing picture.
///
/// # Errors
/// Returns [`FileError::NotRecorded`].
pub(crate) fn check_beside(picture: &Path, files: &[SideFile], overwrite: bool) -> Result<(), FileError> {
    let recorded = recorded(picture);
    let is_own = |file: &SideFile, path: &Path| {
        let there = head(path, LARGEST_SIDE_FILE_BYTES);
        there == file.text.as_bytes() || recorded.contains(&digest(&there))
    };
    let not_recorded = |error| match error {
        FileError::NotOwn { path } => FileError::NotRecorded { path, picture: picture.to_owned() },
        other => other,
    };
    files.iter().try_for_each(|file| check(&file.path, overwrite, |path| is_own(file, path)).map_err(not_recorded))
}

/// Returns those of `files` that hachure wrote for the existing picture: its imprint records their content. Links are
/// not among them.
pub(crate) fn own_beside(picture: &Path, files: impl IntoIterator<Item = PathBuf>) -> Vec<PathBuf> {
    let files = files.into_iter().filter(|path| path.symlink_metadata().is_ok_and(|found| found.is_file()));
    let files: Vec<PathBuf> = files.collect();
    if files.is_empty() {
        return files;
    }
    let recorded = recorded(picture);
    let is_own = |path: &PathBuf| recorded.contains(&digest(&head(path, LARGEST_SIDE_FILE_BYTES)));
    files.into_iter().filter(is_own).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::atomic;
    use crate::file::imprint::Notes;
    use crate::file::png::{PngPixels, PngWriter};

    fn picture(path: &Path, imprint: &str) {
        let notes = Notes { imprint: Some(imprint), ..Notes::default() };
        let mut writer = PngWriter::create_noted(path, 1, 1, PngPixels::Rgb8, &notes).unwrap();
        writer.write_rows(&[0; 3]).unwrap();
        writer.finish().unwrap();
    }

    #[test]
    fn own_files_are_told_from_others() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let file = |text: &str| [SideFile { path: at("a.prj"), text: text.to_owned() }];
        let allowed = |text: &str, overwrite: bool| check_beside(&at("a.png"), &file(text), overwrite).is_ok();
        assert!(allowed("mine", false), "nothing is there");
        atomic::write(&at("a.prj"), b"theirs").unwrap();
        assert!(!allowed("mine", false) && allowed("theirs", false) && allowed("mine", true));
        // The picture records another file than the existing one.
        picture(&at("a.png"), &imprint_with("version = 1\n", &file("mine")));
        assert!(!allowed("new", false));
        let own = || own_beside(&at("a.png"), [at("a.prj"), at("a.png"), at("nothing.prj")]);
        assert!(own().is_empty());
        atomic::write(&at("a.prj"), b"mine").unwrap();
        assert!(allowed("new", false));
        assert_eq!(own(), [at("a.prj")]);
        // A style within an imprint may contain such a line, but not as the last one.
        let fake = imprint_with("", &file("theirs")) + "\nversion = 1\n";
        picture(&at("a.png"), &fake);
        atomic::write(&at("a.prj"), b"theirs").unwrap();
        assert!(!allowed("new", false));
        picture(&at("a-A1.png"), &imprint_of_sheet("version = 1\n", "A1"));
        let sheets = ["A1", "A2"].map(|name| is_sheet(&at("a-A1.png"), name));
        assert_eq!((sheets, is_sheet(&at("a.png"), "A1")), ([true, false], false));
        #[cfg(unix)]
        {
            // A link is not hachure's own, whatever it leads to.
            std::os::unix::fs::symlink(at("a.png"), at("link.png")).unwrap();
            assert!(is_drawing(&at("link.png")) && check(&at("link.png"), false, is_drawing).is_err());
            assert!(check(&at("a.png"), false, is_drawing).is_ok());
        }
        assert!(check(folder.path(), true, |_| true).is_err(), "a folder is never replaced");
    }
}
