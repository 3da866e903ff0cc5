//! Wavefront OBJ files.
//!
//! `tobj` reads the text: faces of any number of corners (as fans), negative indices, groups. It gets only the lines that
//! it shall read, vertices, normals, faces and groups: so materials, comments in any encoding and what else there is
//! cannot go wrong, and lines that go on in the next one are whole. What it makes of numbers that are none, and of
//! indices that lead nowhere, is checked here or by it; a panic of it is one more kind of damage. Vertices are read in
//! f64, because models may lie far from their origin.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use glam::DVec3;

use super::build::Soup;
use super::wrong_line::wrong_line;
use super::{Mesh, MeshError};
use crate::file::input::read_bytes;
use crate::file::one_line;

/// A longer file is none that could be drawn.
const LARGEST_BYTES: u64 = 512 << 20;

/// Reads a file.
///
/// # Errors
/// [`MeshError::Read`].
pub fn read(path: &Path) -> Result<Mesh, MeshError> {
    let wrong = |cause: String| MeshError::Read { path: path.to_owned(), cause: one_line(&cause) };
    let text = read_bytes(path, LARGEST_BYTES).map_err(|error| wrong(error.to_string()))?;
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    parse(name, &text).map_err(wrong)
}

/// As [`read`], from a text.
///
/// # Errors
/// A cause in words, with the line where that is known.
pub fn parse(name: String, text: &[u8]) -> Result<Mesh, String> {
    read_text(name, text).map_err(|cause| {
        let mut numbers = Vec::new();
        let lines = lines_that_count(text, |number| numbers.push(number));
        let lines = String::from_utf8_lossy(&lines);
        let wrong = wrong_line(numbers.iter().copied().zip(lines.lines()));
        wrong.map_or(cause, |(number, cause)| format!("line {number}: {cause}"))
    })
}

fn read_text(name: String, text: &[u8]) -> Result<Mesh, String> {
    let options = tobj::LoadOptions { triangulate: true, single_index: true, ignore_points: true, ignore_lines: true };
    let no_materials = |_: &Path| Err(tobj::LoadError::OpenFileFailed);
    let text = lines_that_count(text, |_| ());
    let loaded = catch_unwind(AssertUnwindSafe(|| tobj::load_obj_buf(&mut text.as_slice(), &options, no_materials)));
    drop(text);
    let (models, _) = match loaded {
        Ok(Ok(loaded)) => loaded,
        Ok(Err(error)) => return Err(error.to_string()),
        Err(_) => return Err("its reader gave up".to_owned()),
    };
    let mut soup = Soup::default();
    for tobj::Model { mesh, .. } in models {
        let first = u32::try_from(soup.places_m.len()).map_err(|_| "it has too many vertices".to_owned())?;
        let vectors = |numbers: &[f64]| -> Vec<DVec3> { numbers.chunks_exact(3).map(DVec3::from_slice).collect() };
        soup.places_m.extend(vectors(&mesh.positions));
        // Where only some corners have normals the reader has lost which.
        if mesh.normals.len() == mesh.positions.len() {
            soup.normals.resize(first as usize, DVec3::ZERO);
            soup.normals.extend(vectors(&mesh.normals));
        }
        let corner = |index: u32| first.checked_add(index).ok_or_else(|| "it has too many vertices".to_owned());
        for triangle in mesh.indices.chunks_exact(3) {
            soup.triangles.push([corner(triangle[0])?, corner(triangle[1])?, corner(triangle[2])?]);
        }
    }
    soup.into_mesh(name)
}

/// Of a text the lines that say something about triangles, as ASCII. A backslash at its end makes a line go on. `each`
/// is told the number of each of these lines, counted from 1.
fn lines_that_count(text: &[u8], mut each: impl FnMut(usize)) -> Vec<u8> {
    let mut kept = Vec::with_capacity(text.len());
    let mut goes_on = false;
    let mut is_kept = false;
    for (number, line) in text.split(|&byte| byte == b'\n').enumerate() {
        let line = line.trim_ascii();
        if !goes_on {
            let word = line.split(u8::is_ascii_whitespace).next().unwrap_or_default();
            is_kept = [b"v".as_slice(), b"vn", b"f", b"o", b"g"].contains(&word);
            if is_kept {
                each(number + 1);
            }
        }
        let part = line.strip_suffix(b"\\");
        goes_on = part.is_some();
        if is_kept {
            kept.extend(part.unwrap_or(line).iter().map(|byte| if byte.is_ascii() { *byte } else { b'?' }));
            kept.push(if goes_on { b' ' } else { b'\n' });
        }
    }
    kept
}
