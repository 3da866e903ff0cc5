//! Classification of files that are dropped on the window or chosen in its dialog.

use std::path::Path;

use super::recent::names_no_file;
use crate::file::input::{LARGEST_SCENE_BYTES, read_text};
use crate::file::{toml_text, unnamed};
use crate::scene::embedded;

/// Bytes at the beginning of a CSV file that are searched for its header.
const HEAD_BYTES: usize = 1 << 14;

/// The use of a file that is dropped or chosen, by its name and content.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum FileKind {
    /// A scene, a DEM, a folder, a baked pyramid, a model, or an address: its world is shown.
    World,
    /// A style file: the current world is drawn with it.
    Style,
    /// A camera path: it is flown.
    CameraPath,
    /// A file that cannot be opened by itself, with the reason in one line.
    Refused(String),
}

/// Classifies a file by its name and content. Errors in a file are reported when it is opened.
pub(crate) fn file_kind(name: &str) -> FileKind {
    let path = Path::new(name);
    if embedded::path(path).is_some() {
        return FileKind::CameraPath;
    }
    if names_no_file(name) || path.is_dir() {
        return FileKind::World;
    }
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    match &*ending {
        "toml" if is_scene(path) => FileKind::World,
        "toml" => FileKind::Style,
        _ if is_camera_path(path) => FileKind::CameraPath,
        _ if unnamed::is_drawing(path) => FileKind::Refused(unnamed::is_no_world(path)),
        _ => FileKind::World,
    }
}

/// Returns whether a TOML file is a scene: it names its world. In a file that is not valid, a line has the table's name.
fn is_scene(path: &Path) -> bool {
    let text = read_text(path, LARGEST_SCENE_BYTES).unwrap_or_default();
    match toml_text::keys(&path.to_string_lossy(), &text) {
        Ok(keys) => keys.iter().any(|key| key == "world"),
        Err(_) => text.lines().any(|line| line.trim_start().starts_with("[world]")),
    }
}

/// Returns whether a file has the header of a camera path, or one that is meant as such.
fn is_camera_path(path: &Path) -> bool {
    let head = unnamed::head(path, HEAD_BYTES);
    let head = String::from_utf8_lossy(&head);
    let header = head.lines().find(|line| !line.starts_with('#')).unwrap_or_default().to_lowercase();
    let columns: Vec<&str> = header.trim_start_matches('\u{feff}').split(',').map(str::trim).collect();
    columns.contains(&"yaw") && columns.contains(&"pitch")
}

/// Returns a path that begins with `~/` with the user's folder in its place.
pub(crate) fn expand_home(name: &str) -> String {
    let rest = name.strip_prefix("~/").filter(|_| !Path::new(name).exists());
    let home = rest.and_then(|rest| Some(directories::BaseDirs::new()?.home_dir().join(rest)));
    home.map_or_else(|| name.to_owned(), |path| path.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;
    use crate::file::atomic;

    #[test]
    fn each_file_does_what_its_kind_suggests() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str, text: &str| {
            let path = folder.path().join(name);
            atomic::write(&path, text.as_bytes()).unwrap();
            path.display().to_string()
        };
        assert_eq!(file_kind(&at("a.toml", "[world]\nfile = \"dem.tif\"\n")), FileKind::World);
        assert_eq!(file_kind(&at("b.toml", "extends = \"pen\"\n")), FileKind::Style);
        assert_eq!(file_kind(&at("c.toml", "name = 3 =")), FileKind::Style, "the style says what is wrong");
        let broken = at("c-scene.toml", "[world]\nfile = \"dem.tif\n");
        assert_eq!(file_kind(&broken), FileKind::World, "the scene says what is wrong");
        assert_eq!(file_kind(&at("d.csv", "# mine\nt,x,y,z,yaw,pitch,fov\n0,0,0,+9,0,0,50\n")), FileKind::CameraPath);
        // A header with a mistake is reported as that of a path.
        assert_eq!(file_kind(&at("e.csv", "time, x, y, z, Yaw, Pitch\n")), FileKind::CameraPath);
        assert_eq!(file_kind(&at("f.csv", "0,0,5\n1,0,6\n0,1,5\n1,1,7\n")), FileKind::World, "points with heights");
        assert_eq!(file_kind(&at("g.tif", "II*\0")), FileKind::World);
        assert_eq!(file_kind(&folder.path().display().to_string()), FileKind::World);
        assert_eq!(file_kind("https://example.org/a.obj"), FileKind::World);
        assert_eq!(file_kind("continent"), FileKind::World);
        assert_eq!(file_kind("tour"), FileKind::CameraPath);
        assert_eq!(file_kind("no such file"), FileKind::World, "its error names it");
        assert_eq!(file_kind(&at("h.OBJ", "v 0 0 0\n")), FileKind::World, "a model, whatever is in it");
    }

    #[test]
    fn a_path_may_begin_at_home() {
        assert_eq!(expand_home("/data/a.tif"), "/data/a.tif");
        assert_eq!(expand_home("a~/b"), "a~/b");
        if let Some(home) = directories::BaseDirs::new() {
            assert_eq!(expand_home("~/a.tif"), home.home_dir().join("a.tif").to_string_lossy());
        }
    }
}
