//! DEMs as they are downloaded: compressed (`.gz`), or in an archive (`.zip`, `.tar`, `.tar.gz`) that holds one of them.
//!
//! The files that the DEM needs are unpacked into a folder of the cache ([`UnpackedFolder`]), which is removed with the
//! reader. The names in the archive decide what is unpacked: the only DEM, and its sidecar files, which have the same
//! stem.

mod content;

use std::collections::HashSet;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

pub(super) use content::proved;
use content::{LIMITS, LISTING, Limits, file_name, names, unpack, visit};

use super::georeference::Georeference;
use super::reader::{HeightReader, Window};
use super::sidecar::sidecar_path;
use super::{OpenOptions, SourceError, VoidMode, hgt, open_as_it_is, place};
use crate::file::message::printable;
use crate::file::unpacked::UnpackedFolder;

/// The kinds of container.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Container {
    Zip,
    Tar,
    /// A single file, or a tar archive, compressed with DEFLATE.
    Gzip,
}

/// Extensions of DEMs, and those of files that may be DEMs: they count where there is none of the first.
const DEM_ENDINGS: [&str; 15] =
    ["hgt", "tif", "tiff", "asc", "dem", "bil", "bip", "bsq", "flt", "dt0", "dt1", "dt2", "xyz", "nc", "pmtiles"];
const OTHER_ENDINGS: [&str; 12] = ["txt", "csv", "grd", "png", "webp", "exr", "r16", "raw", "bin", "img", "dat", "adf"];
/// Largest number of files that an error lists.
const LISTED: usize = 3;

/// Returns whether these first bytes are those of a gzip file.
pub(super) fn is_gzip(head: &[u8]) -> bool {
    head.starts_with(b"\x1f\x8b\x08")
}

/// Returns whether a container holds height files, by the names in it. A damaged one counts, so that opening it reports
/// the damage.
pub(super) fn holds_heights(path: &Path, container: Container) -> bool {
    holds_heights_within(path, container, &LISTING)
}

fn holds_heights_within(path: &Path, container: Container, limits: &Limits) -> bool {
    let mut is_found = false;
    let visited = visit(path, container, limits, &mut |name, _| {
        is_found = has_ending(name, &DEM_ENDINGS);
        Ok(if is_found { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
    });
    match visited {
        Ok(()) => is_found,
        Err(SourceError::Unclear { .. }) => {
            tracing::warn!(
                "{}: left out, because its first {} MiB, or {} entries, hold no height file; name it to have all of it \
                 searched",
                path.display(),
                limits.bytes >> 20,
                limits.entries
            );
            false
        }
        Err(_) => true,
    }
}

/// Opens the only DEM in a container.
pub(super) fn open(
    path: &Path,
    container: Container,
    options: &OpenOptions,
) -> Result<Box<dyn HeightReader>, SourceError> {
    let names = names(path, container, &LIMITS)?;
    let name = the_dem(path, &names)?;
    if container == Container::Zip && has_ending(&name, &["hgt"]) {
        return Ok(Box::new(hgt::open_zip(path)?));
    }
    let cannot_unpack = |(folder, source)| SourceError::Unpack { path: path.into(), folder, source };
    let folder = UnpackedFolder::create(path).map_err(cannot_unpack)?;
    let wanted: HashSet<&str> =
        names.iter().filter(|other| **other == name || is_beside(other, &name)).map(String::as_str).collect();
    unpack(path, container, &LIMITS, &wanted, folder.path())?;
    // The sidecar file of the container describes the content, unless that has its own.
    let (dem, sidecar) = (folder.path().join(file_name(&name)), sidecar_path(path));
    if let (Some(sidecar), None) = (&sidecar, sidecar_path(&dem)) {
        let mut target = dem.as_os_str().to_owned();
        target.push(".toml");
        let copied = std::fs::copy(sidecar, target);
        copied.map_err(|source| cannot_unpack((folder.path().to_owned(), source)))?;
    }
    let inside = |error: SourceError| in_container(path, folder.path(), &error);
    let inner = open_as_it_is(&dem, options).map_err(inside)?;
    let given = OpenOptions { voids: VoidMode::default(), ..*options };
    let files: Vec<&Path> = std::iter::once(path).chain(sidecar.as_deref()).collect();
    let identity = place::identity(&files, &format!("{name}\n{given:?}"));
    Ok(Box::new(Unpacked { inner, path: path.into(), identity, folder }))
}

/// Returns the name of the only DEM among the names in a container.
fn the_dem(path: &Path, names: &[String]) -> Result<String, SourceError> {
    let of = |endings: &[&str]| names.iter().filter(|name| has_ending(name, endings)).collect::<Vec<_>>();
    let mut dems = of(&DEM_ENDINGS);
    if dems.is_empty() {
        dems = of(&OTHER_ENDINGS);
    }
    match dems[..] {
        [] => Err(SourceError::UnknownFormat { path: path.into(), looks_like: "is an archive without a height file" }),
        [dem] => Ok(dem.clone()),
        _ => {
            let mut listed: Vec<&str> = dems.iter().take(LISTED).map(|name| file_name(name)).collect();
            if dems.len() > LISTED {
                listed.push("…");
            }
            let listed = printable(&listed.join(", "), 80);
            let why = format!("holds {} height files ({listed}); unpack it, and name one or the folder", dems.len());
            Err(SourceError::Unclear { path: path.into(), why })
        }
    }
}

fn has_ending(name: &str, endings: &[&str]) -> bool {
    let ending = file_name(name).rsplit_once('.').map_or("", |(_, ending)| ending).to_ascii_lowercase();
    endings.contains(&&*ending)
}

/// Returns whether a file belongs to a DEM in the same folder: `dem.prj` and `dem.tif.aux.xml` to `dem.tif`.
fn is_beside(other: &str, dem: &str) -> bool {
    let folder = |name: &str| name.len() - file_name(name).len();
    let stem = file_name(dem).rsplit_once('.').map_or(file_name(dem), |(stem, _)| stem);
    other[..folder(other)] == dem[..folder(dem)]
        && file_name(other).strip_prefix(stem).is_some_and(|rest| rest.starts_with('.'))
        && !has_ending(other, &DEM_ENDINGS)
}

/// Returns the error of an unpacked file with the name of its container instead of the temporary folder.
fn in_container(path: &Path, folder: &Path, error: &SourceError) -> SourceError {
    let text = error.to_string();
    let folder = format!("{}{}", folder.display(), std::path::MAIN_SEPARATOR);
    SourceError::InArchive { path: path.into(), cause: text.replace(&folder, "") }
}

/// An unpacked DEM with the folder that holds it.
struct Unpacked {
    // The reader closes its files before the folder is removed.
    inner: Box<dyn HeightReader>,
    path: PathBuf,
    identity: String,
    folder: UnpackedFolder,
}

impl HeightReader for Unpacked {
    fn size(&self) -> [u32; 2] {
        self.inner.size()
    }

    fn georeference(&self) -> &Georeference {
        self.inner.georeference()
    }

    fn read(&self, window: Window) -> Result<Vec<f32>, SourceError> {
        self.inner.read(window).map_err(|error| in_container(&self.path, self.folder.path(), &error))
    }

    fn block(&self) -> [u32; 2] {
        self.inner.block()
    }

    fn known_m(&self, window: Window) -> Option<f32> {
        self.inner.known_m(window)
    }

    fn is_serial(&self) -> bool {
        self.inner.is_serial()
    }

    fn declared_unit_m(&self) -> Option<f64> {
        self.inner.declared_unit_m()
    }

    fn is_coarse(&self) -> bool {
        self.inner.is_coarse()
    }

    fn warnings(&self) -> Vec<String> {
        self.inner.warnings()
    }

    fn identity(&self) -> String {
        self.identity.clone()
    }
}

#[cfg(test)]
mod tests;
