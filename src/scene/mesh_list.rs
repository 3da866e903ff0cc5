//! Lists of model positions: CSV with a header that names its columns, in any order.
//!
//! ```text
//! x,y,z,yaw,scale
//! 120,-40,+0,30,1
//! ```
//!
//! `x` and `y` are metres in the world's frame, like `at` of a scene. The other columns are optional: `z` (default
//! `+0`, on the ground), `yaw` (default 0, degrees clockwise from above) and `scale` (default 1).

use std::path::{Path, PathBuf};

use glam::DVec3;

use super::meshes::{MeshPlace, check_stance, height_of};
use crate::file::input::{LARGEST_PATH_BYTES, read_text};
use crate::file::message::{named, quoted, shown};
use crate::mesh::placed::MAX_INSTANCES;

/// The columns that a list may have.
const COLUMNS: [&str; 5] = ["x", "y", "z", "yaw", "scale"];
/// The number of required columns, the first of [`COLUMNS`].
const NEEDED: usize = 2;

/// A row of a list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshRow {
    /// Position of the model's origin.
    pub place: MeshPlace,
    /// Rotation, clockwise from above, in degrees.
    pub yaw_deg: f64,
    /// Factor on the scale of the scene's entry.
    pub scale: f64,
}

/// Why a file is not a valid list. One line that names the file, the line and the cause.
#[derive(Debug, thiserror::Error)]
pub enum MeshListError {
    /// The file cannot be read.
    #[error("cannot read the list of instances {}: {cause}", named(path))]
    Open {
        /// Path of the file.
        path: PathBuf,
        #[source]
        cause: std::io::Error,
    },
    /// A line is wrong.
    #[error("{}:{line}: {cause}", named(path))]
    Line {
        /// Path of the file.
        path: PathBuf,
        /// Line number, counted from 1 with the header.
        line: usize,
        /// The reason why the line is invalid.
        cause: String,
    },
}

/// Reads the rows of a file, at most [`MAX_INSTANCES`].
///
/// # Errors
/// A file that cannot be read or has no header with `x` and `y`; an invalid row; too many rows.
pub fn read(path: &Path) -> Result<Vec<MeshRow>, MeshListError> {
    let text = read_text(path, LARGEST_PATH_BYTES);
    let text = text.map_err(|cause| MeshListError::Open { path: path.to_owned(), cause })?;
    parse(path, &text)
}

/// Parses a list like [`read`], from text; `name` is the file name for messages.
///
/// # Errors
/// The same as [`read`].
pub(crate) fn parse(name: &Path, text: &str) -> Result<Vec<MeshRow>, MeshListError> {
    let wrong = |line: usize, cause: String| MeshListError::Line { path: name.to_owned(), line, cause };
    let lines = text.trim_start_matches('\u{feff}').lines().map(str::trim).enumerate();
    let mut lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#')).map(|(i, line)| (i + 1, line));
    let Some((head, header)) = lines.next() else {
        return Err(wrong(1, "the header is missing; the first line must name the columns, like `x,y`".to_owned()));
    };
    let names: Vec<&str> = header.split(',').map(str::trim).collect();
    let mut place_of = [None; COLUMNS.len()];
    for (at, name) in names.iter().enumerate() {
        let column = COLUMNS.iter().position(|column| column == name);
        let Some(column) = column else {
            let known = COLUMNS.join(", ");
            return Err(wrong(head, format!("unknown column {} in the header; the columns are {known}", quoted(name))));
        };
        if place_of[column].replace(at).is_some() {
            return Err(wrong(head, format!("the header names {} twice", quoted(name))));
        }
    }
    if place_of[..NEEDED].contains(&None) {
        return Err(wrong(head, format!("the header is `{}`; it must name x and y", shown(header))));
    }
    let mut rows = Vec::new();
    for (line, text) in lines {
        let fields: Vec<&str> = text.split(',').map(str::trim).collect();
        if fields.len() != names.len() {
            return Err(wrong(line, format!("found {} fields, but the header has {}", fields.len(), names.len())));
        }
        if rows.len() as u64 == MAX_INSTANCES {
            return Err(wrong(line, format!("there are more than {MAX_INSTANCES} places")));
        }
        let texts = place_of.map(|at| at.map(|at: usize| fields[at]).filter(|text| !text.is_empty()));
        rows.push(row(texts).map_err(|cause| wrong(line, cause))?);
    }
    Ok(rows)
}

/// Parses a row; the fields are in the order of [`COLUMNS`].
fn row([x, y, z, yaw, scale]: [Option<&str>; COLUMNS.len()]) -> Result<MeshRow, String> {
    let number = |name: &str, text: Option<&str>, usual: Option<f64>| match text {
        Some(text) => text.parse::<f64>().map_err(|_| format!("{name} is {}: not a number", quoted(text))),
        None => usual.ok_or_else(|| format!("{name} is missing")),
    };
    let (x_m, y_m) = (number("x", x, None)?, number("y", y, None)?);
    let (z_m, height_above_ground) = height_of(z.unwrap_or("+0"))?;
    let (yaw_deg, scale) = (number("yaw", yaw, Some(0.0))?, number("scale", scale, Some(1.0))?);
    let at_m = DVec3::new(x_m, y_m, z_m);
    check_stance(at_m, yaw_deg, scale).map_err(|(key, cause)| match key.as_str() {
        "at" => format!("x, y and z must be within ±{} m", super::camera::LARGEST_COORDINATE_M),
        "yaw_deg" => format!("yaw: {cause}"),
        _ => format!("{key}: {cause}"),
    })?;
    Ok(MeshRow { place: MeshPlace { at_m, height_above_ground }, yaw_deg, scale })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error_of(text: &str) -> String {
        let error = parse(Path::new("huts.csv"), text).unwrap_err().to_string();
        assert!(!error.contains('\n'), "{error}");
        error
    }

    #[test]
    fn columns_come_in_any_order_and_may_be_missing() {
        let rows = parse(Path::new("huts.csv"), "scale,y,x,z,yaw\n2,-40,120,+1.5,30\n# no row\n,1,2,300,\n").unwrap();
        let at = |x, y, z, height_above_ground| MeshPlace { at_m: DVec3::new(x, y, z), height_above_ground };
        assert_eq!(rows[0], MeshRow { place: at(120.0, -40.0, 1.5, true), yaw_deg: 30.0, scale: 2.0 });
        assert_eq!(rows[1], MeshRow { place: at(2.0, 1.0, 300.0, false), yaw_deg: 0.0, scale: 1.0 });
        let short = parse(Path::new("huts.csv"), "\u{feff}x, y\n5, 6\n").unwrap();
        assert_eq!(short, [MeshRow { place: at(5.0, 6.0, 0.0, true), yaw_deg: 0.0, scale: 1.0 }]);
        assert!(parse(Path::new("huts.csv"), "x,y\n").unwrap().is_empty());
    }

    #[test]
    fn errors_are_one_line_with_file_and_row() {
        for (text, cause) in [
            ("\n# nothing\n", "huts.csv:1: the header is missing"),
            ("x,z\n1,2\n", "huts.csv:1: the header is `x,z`; it must name x and y"),
            ("x,y,colour\n1,2,3\n", "huts.csv:1: unknown column \"colour\""),
            ("x,y,x\n1,2,3\n", "huts.csv:1: the header names \"x\" twice"),
            ("x,y\n1,2\n1\n", "huts.csv:3: found 1 fields, but the header has 2"),
            ("x,y\n1,2\n\n1,b\n", "huts.csv:4: y is \"b\": not a number"),
            ("x,y\n1,\n", "huts.csv:2: y is missing"),
            ("x,y\n1,nan\n", "huts.csv:2: x, y and z must be within ±"),
            ("x,y,z\n1,2,++3\n", "huts.csv:2: z is \"++3\""),
            ("x,y,yaw\n1,2,inf\n", "huts.csv:2: yaw: "),
            ("x,y,scale\n1,2,0\n", "huts.csv:2: scale: "),
        ] {
            assert!(error_of(text).starts_with(cause), "{}", error_of(text));
        }
        let many = "0,0\n".repeat(MAX_INSTANCES as usize);
        assert!(parse(Path::new("huts.csv"), &format!("x,y\n{many}")).is_ok());
        assert!(error_of(&format!("x,y\n{many}0,0\n")).ends_with(":65538: there are more than 65536 places"));
    }
}
