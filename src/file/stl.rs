//! STL: triangles for 3D printers, in its binary form. Numbers have no unit; hachure writes metres, x east, y north, z
//! up.

use std::io::Write;
use std::path::Path;

use glam::DVec3;

use super::FileError;
use super::atomic::AtomicFile;

/// Bytes of the header, which must not begin with `solid`.
const HEADER_BYTES: usize = 80;

/// Writes a mesh, completely or not at all.
///
/// # Errors
/// Fails if the mesh is empty, the folder does not exist or is not writable, or the disk is full.
pub(crate) fn write_stl(path: &Path, positions: &[DVec3], triangles: &[[u32; 3]]) -> Result<(), FileError> {
    let count = u32::try_from(triangles.len()).ok().filter(|count| *count > 0);
    let count = count.ok_or_else(|| FileError::write(path, "the mesh has no triangles, or too many"))?;
    let failed = |error| FileError::write(path, error);
    let mut file = AtomicFile::create(path).map_err(failed)?;
    write(file.writer(), positions, triangles, count).map_err(failed)?;
    file.commit().map_err(failed)
}

fn write(out: &mut impl Write, positions: &[DVec3], triangles: &[[u32; 3]], count: u32) -> std::io::Result<()> {
    let mut header = [b' '; HEADER_BYTES];
    let words = concat!("hachure ", env!("CARGO_PKG_VERSION"), ", metres, z up");
    header[..words.len()].copy_from_slice(words.as_bytes());
    out.write_all(&header)?;
    out.write_all(&count.to_le_bytes())?;
    for corners in triangles {
        let corners = corners.map(|corner| positions[corner as usize]);
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
        for vector in [normal, corners[0], corners[1], corners[2]] {
            // Corners of several triangles are rounded alike, so that the solid stays closed.
            vector.to_array().into_iter().try_for_each(|number| out.write_all(&(number as f32).to_le_bytes()))?;
        }
        out.write_all(&[0; 2])?;
    }
    Ok(())
}
