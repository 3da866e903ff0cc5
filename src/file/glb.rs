//! glTF 2.0 in one binary file (GLB): a mesh of triangles with normals, for Blender, game engines and browsers.
//!
//! A file is a header, a chunk of JSON and a chunk of binary data. y is up, as glTF defines it, x is east and −z is
//! north; lengths are metres.

use std::io::Write;
use std::path::Path;

use glam::DVec3;
use serde_json::{Value, json};

use super::FileError;
use super::atomic::AtomicFile;

const VERSION: u32 = 2;
const JSON_CHUNK: &[u8; 4] = b"JSON";
const BINARY_CHUNK: &[u8; 4] = b"BIN\0";
/// glTF's numbers of data types and of uses.
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34_962;
const ELEMENT_ARRAY_BUFFER: u32 = 34_963;
/// Chunks have multiples of 4 bytes.
const ALIGNED: usize = 4;

/// A mesh to write. Positions are east, north and up in metres.
pub(crate) struct GlbMesh<'a> {
    /// Name of the mesh.
    pub name: &'a str,
    pub positions: &'a [DVec3],
    /// Unit normals, one for each position.
    pub normals: &'a [DVec3],
    /// Triangles, anticlockwise from outside.
    pub triangles: &'a [[u32; 3]],
    /// Further data for programs that read it (`asset.extras`).
    pub extras: Value,
}

/// Writes a mesh, completely or not at all.
///
/// # Errors
/// Fails if the mesh is empty or larger than 4 GiB, the folder does not exist or is not writable, or the disk is full.
pub(crate) fn write_glb(path: &Path, mesh: &GlbMesh<'_>) -> Result<(), FileError> {
    if mesh.triangles.is_empty() {
        return Err(FileError::write(path, "the mesh has no triangles"));
    }
    let [positions, normals] = [mesh.positions, mesh.normals].map(|list| list.len() * 12);
    let indices = mesh.triangles.len() * 12;
    let bytes = positions + normals + indices;
    let mut text = json_of(mesh, [positions, normals, indices]).to_string();
    text += &" ".repeat(text.len().next_multiple_of(ALIGNED) - text.len());
    let length = |bytes: usize| {
        u32::try_from(bytes).map_err(|_| FileError::write(path, "the mesh is larger than the 4 GiB of a .glb"))
    };
    // The header has 12 bytes, and each chunk a header of 8.
    let lengths = [length(12 + 8 + text.len() + 8 + bytes)?, length(text.len())?, length(bytes)?];
    let failed = |error| FileError::write(path, error);
    let mut file = AtomicFile::create(path).map_err(failed)?;
    write(file.writer(), mesh, &text, lengths).map_err(failed)?;
    file.commit().map_err(failed)
}

/// Returns a position as glTF has it: y up.
fn y_up(at: &DVec3) -> [f32; 3] {
    // 0.0 - y has no negative zero.
    [at.x, at.z, 0.0 - at.y].map(|number| number as f32)
}

fn json_of(mesh: &GlbMesh<'_>, [positions, normals, indices]: [usize; 3]) -> Value {
    let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    for at in mesh.positions.iter().map(y_up) {
        for axis in 0..3 {
            bounds[0][axis] = bounds[0][axis].min(at[axis]);
            bounds[1][axis] = bounds[1][axis].max(at[axis]);
        }
    }
    let count = mesh.positions.len();
    json!({
        "asset": {
            "version": "2.0",
            "generator": concat!("hachure ", env!("CARGO_PKG_VERSION")),
            "extras": mesh.extras,
        },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "name": mesh.name }],
        "meshes": [{
            "name": mesh.name,
            "primitives": [{ "attributes": { "POSITION": 0, "NORMAL": 1 }, "indices": 2, "material": 0 }],
        }],
        "materials": [{
            "name": "land",
            "pbrMetallicRoughness": { "baseColorFactor": [0.8, 0.8, 0.8, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0 },
            "doubleSided": true,
        }],
        "accessors": [
            { "bufferView": 0, "componentType": FLOAT, "count": count, "type": "VEC3", "min": bounds[0], "max": bounds[1] },
            { "bufferView": 1, "componentType": FLOAT, "count": count, "type": "VEC3" },
            { "bufferView": 2, "componentType": UNSIGNED_INT, "count": mesh.triangles.len() * 3, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": positions, "target": ARRAY_BUFFER },
            { "buffer": 0, "byteOffset": positions, "byteLength": normals, "target": ARRAY_BUFFER },
            { "buffer": 0, "byteOffset": positions + normals, "byteLength": indices, "target": ELEMENT_ARRAY_BUFFER },
        ],
        "buffers": [{ "byteLength": positions + normals + indices }],
    })
}

fn write(out: &mut impl Write, mesh: &GlbMesh<'_>, text: &str, [all, json, binary]: [u32; 3]) -> std::io::Result<()> {
    out.write_all(b"glTF")?;
    out.write_all(&VERSION.to_le_bytes())?;
    out.write_all(&all.to_le_bytes())?;
    for (length, kind) in [(json, JSON_CHUNK), (binary, BINARY_CHUNK)] {
        out.write_all(&length.to_le_bytes())?;
        out.write_all(kind)?;
        if kind == JSON_CHUNK {
            out.write_all(text.as_bytes())?;
        }
    }
    for list in [mesh.positions, mesh.normals] {
        for at in list {
            y_up(at).into_iter().try_for_each(|number| out.write_all(&number.to_le_bytes()))?;
        }
    }
    mesh.triangles.iter().flatten().try_for_each(|corner| out.write_all(&corner.to_le_bytes()))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;

    #[test]
    fn a_file_has_its_chunks_and_bounds() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.glb");
        let positions = [DVec3::ZERO, DVec3::new(3.0, 0.0, 1.0), DVec3::new(0.0, 2.0, 5.0)];
        let (normals, triangles) = ([DVec3::Z; 3], [[0, 1, 2]]);
        let extras = json!({ "error_m": 0.5 });
        let mesh = GlbMesh { name: "a", positions: &positions, normals: &normals, triangles: &triangles, extras };
        write_glb(&path, &mesh).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let number = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!((&bytes[..4], number(4), number(8)), (b"glTF".as_slice(), 2, bytes.len()));
        let json: Value = serde_json::from_slice(&bytes[20..20 + number(12)]).unwrap();
        assert_eq!(json["accessors"][0]["max"], json!([3.0, 5.0, 0.0]));
        assert_eq!(json["accessors"][0]["min"], json!([0.0, 0.0, -2.0]));
        assert_eq!(json["asset"]["extras"]["error_m"], 0.5);
        let binary = 20 + number(12) + 8;
        assert_eq!((number(binary - 8), bytes.len() - binary), (3 * 12 * 2 + 12, 3 * 12 * 2 + 12));
        let float = |at: usize| f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        // The third position: north is −z, up is y.
        assert_eq!([0, 4, 8].map(|i| float(binary + 24 + i)), [0.0, 5.0, -2.0]);
        assert_eq!(number(bytes.len() - 4), 2);
        let none = GlbMesh { triangles: &[], ..mesh };
        assert!(write_glb(&folder.path().join("b.glb"), &none).is_err());
    }
}
