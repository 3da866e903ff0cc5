//! Wavefront OBJ files.
//!
//! `tobj` reads the text: faces with any number of corners (as fans), negative indices, groups. It gets only the
//! statements that it needs, vertices, normals, faces and groups (`obj_text`), with continued lines joined, so
//! materials, comments in any encoding and other content cannot cause errors. Invalid numbers and indices out of range
//! are detected by it or here; a panic in it is treated as a damaged file. Vertices are read in f64, because models may
//! be far from their origin.
//!
//! A file is read in one pass and never held in memory as a whole. Only if it is damaged it is read again, to find the
//! line with the error.

use std::io::{BufRead, BufReader};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::build::Soup;
use super::obj_text::{GeometryStream, MaterialStatements, numbered_geometry};
use super::paint::{self, Paint, Place};
use super::wrong_line::wrong_line;
use super::{Mesh, MeshError};
use crate::file::input::{Bounded, plain, read_bytes};
use crate::file::message::shown;
use crate::file::one_line;
use crate::source::{Progress, Silent};

/// Largest size of a file, in bytes: a longer one could not be drawn.
const LARGEST_BYTES: u64 = 512 << 20;
/// Size from which progress is reported: shorter files are read before a bar could be noticed.
const LONG_BYTES: u64 = 16 << 20;
/// Bytes at the beginning of a file in which material libraries are searched.
const BEGINNING_BYTES: u64 = 1 << 20;

/// Reads a file. Problems with its materials are logged as warnings.
///
/// # Errors
/// [`MeshError::Read`] if the file cannot be read.
pub fn read(path: &Path) -> Result<Mesh, MeshError> {
    read_with(path, &Silent, &mut |warning| tracing::warn!("{warning}"))
}

/// Reads a file like [`read`], with progress for long files. `warn` is called with a line for each problem with the
/// materials.
///
/// # Errors
/// The errors of [`read`].
pub fn read_with(path: &Path, progress: &dyn Progress, warn: &mut dyn FnMut(String)) -> Result<Mesh, MeshError> {
    let wrong = |cause: String| MeshError::Read { path: path.to_owned(), cause: one_line(&cause) };
    let unread = |error: std::io::Error| wrong(error.to_string());
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let place = Some(Place { path, warn });
    // A pipe can be read only once.
    if !std::fs::metadata(path).map_err(|error| unread(plain(error)))?.is_file() {
        let text = read_bytes(path, LARGEST_BYTES).map_err(unread)?;
        let read = read_text(name, text.as_slice(), place, &|_| (), &|_| ()).map_err(Cause::into_message);
        return read.map_err(|cause| wrong(blamed(cause, &text)));
    }
    let file = Bounded::open(path, LARGEST_BYTES).map_err(unread)?;
    let bytes = file.bytes();
    let is_long = bytes >= LONG_BYTES;
    let what = |doing: &str| format!("{doing} {}", shown(&name));
    let (reading, joining) = (what("reading"), what("joining"));
    let report_done = |what: &str, done: f64| {
        if is_long {
            progress.report(what, done as f32);
        }
    };
    let from = BufReader::with_capacity(1 << 20, file);
    let read = |done: u64| report_done(&reading, done as f64 / bytes as f64);
    read_text(name.clone(), from, place, &read, &|done| report_done(&joining, done)).map_err(|cause| match cause {
        Cause::File(cause) => wrong(cause),
        Cause::Text(cause) => wrong(match read_bytes(path, LARGEST_BYTES) {
            Ok(text) => blamed(cause, &text),
            Err(_) => cause,
        }),
    })
}

/// Parses a text like [`read`]. Materials have their names, and the plain colour.
///
/// # Errors
/// Returns a message, with the number of the line where that is known.
pub fn parse(name: String, text: &[u8]) -> Result<Mesh, String> {
    read_text(name, text, None, &|_| (), &|_| ()).map_err(|cause| blamed(cause.into_message(), text))
}

/// Returns the existing files that are read with a model: the libraries and textures that the beginning of the file
/// names.
pub fn sidecar_files(path: &Path) -> Vec<PathBuf> {
    use std::io::Read;
    let mut beginning = Vec::new();
    let read =
        crate::file::input::open_regular(path).map(|file| file.take(BEGINNING_BYTES).read_to_end(&mut beginning));
    if read.is_ok() { paint::files_of(path, &beginning) } else { Vec::new() }
}

/// The reason why there is no mesh.
enum Cause {
    /// The file could not be read.
    File(String),
    /// The content is damaged.
    Text(String),
}

impl Cause {
    fn into_message(self) -> String {
        let (Self::File(cause) | Self::Text(cause)) = self;
        cause
    }
}

/// Returns the cause, with the number of the line that contains the error.
fn blamed(cause: String, text: &[u8]) -> String {
    let (numbers, lines) = numbered_geometry(text);
    let wrong = wrong_line(numbers.iter().copied().zip(lines.lines()));
    wrong.map_or(cause, |(number, cause)| format!("line {number}: {cause}"))
}

/// Reads a mesh. `read` is called with the number of bytes read, `joined` with the finished fraction of the rest.
fn read_text(
    name: String,
    from: impl BufRead,
    place: Option<Place<'_>>,
    read: &dyn Fn(u64),
    joined: &dyn Fn(f64),
) -> Result<Mesh, Cause> {
    let (soup, statements) = soup_of(from, read)?;
    let paint = Paint::of(&statements, soup.triangles.len(), place);
    drop(statements);
    soup.join(name, paint, joined).map_err(Cause::Text)
}

fn soup_of(from: impl BufRead, read: &dyn Fn(u64)) -> Result<(Soup, MaterialStatements), Cause> {
    let options = tobj::LoadOptions { triangulate: true, single_index: true, ignore_points: true, ignore_lines: true };
    let no_materials = |_: &Path| Err(tobj::LoadError::OpenFileFailed);
    let mut stream = GeometryStream::new(from, read);
    let loaded = catch_unwind(AssertUnwindSafe(|| tobj::load_obj_buf(&mut stream, &options, no_materials)));
    let statements = stream.into_material_statements().map_err(|error| Cause::File(error.to_string()))?;
    let (models, _) = match loaded {
        Ok(Ok(loaded)) => loaded,
        Ok(Err(error)) => return Err(Cause::Text(error.to_string())),
        Err(_) => return Err(Cause::Text("its content made the OBJ reader fail".to_owned())),
    };
    let too_many = || Cause::Text("it has too many vertices".to_owned());
    let mut soup = Soup::default();
    soup.places_m.reserve_exact(models.iter().map(|model| model.mesh.positions.len() / 3).sum());
    soup.triangles.reserve_exact(models.iter().map(|model| model.mesh.indices.len() / 3).sum());
    for tobj::Model { mesh, .. } in models {
        let first = u32::try_from(soup.places_m.len()).map_err(|_| too_many())?;
        let vectors = |numbers: &[f64]| -> Vec<DVec3> { numbers.chunks_exact(3).map(DVec3::from_slice).collect() };
        soup.places_m.extend(vectors(&mesh.positions));
        // If only some corners have normals, the reader does not preserve which.
        if mesh.normals.len() == mesh.positions.len() {
            soup.normals.resize(first as usize, DVec3::ZERO);
            soup.normals.extend(vectors(&mesh.normals));
        }
        let corner = |index: u32| first.checked_add(index).ok_or_else(too_many);
        for triangle in mesh.indices.chunks_exact(3) {
            soup.triangles.push([corner(triangle[0])?, corner(triangle[1])?, corner(triangle[2])?]);
        }
    }
    Ok((soup, statements))
}
