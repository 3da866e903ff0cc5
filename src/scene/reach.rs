//! The files that a scene file may name: those in its folder and below. So a scene from somebody else can neither show
//! other files of this machine nor make hachure contact servers. The user lifts the restriction for scenes that are
//! trusted.

use std::path::{Component, Path, PathBuf};

use super::scene_file::SceneError;
use super::{Scene, World};
use crate::remote;
use crate::source::{self, Kind};

/// The files that names in a scene file may lead to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reach {
    /// The folder of the scene file and everything below it. Symbolic links that lead out of it count as outside.
    #[default]
    SceneFolder,
    /// Anywhere on this machine, and on the network.
    Anywhere,
}

impl Reach {
    /// Returns the reach for the command line's `--trust-scene`.
    #[must_use]
    pub(crate) fn trusting(trusts: bool) -> Self {
        if trusts { Self::Anywhere } else { Self::SceneFolder }
    }
}

/// Depth of folders of tiles, `z/x/y.png`.
const TILE_LEVELS: usize = 3;

impl Scene {
    /// Checks that everything that the scene file at `file` names is within reach.
    ///
    /// # Errors
    /// [`SceneError::Outside`], with the first name that leads out.
    pub fn check_reach(&self, file: &Path, reach: Reach) -> Result<(), SceneError> {
        if reach == Reach::Anywhere {
            return Ok(());
        }
        let outside = |key: &'static str, name: String, what: &'static str| SceneError::Outside {
            path: file.to_owned(),
            key,
            name,
            what,
        };
        let folder = Inside::of(file.parent().unwrap_or(Path::new("")));
        let check = |key: &'static str, path: &Path| match folder.holds(path) {
            true => Ok(()),
            false => Err(outside(key, path.display().to_string(), "is outside the scene's folder")),
        };
        let check_dem = |path: &Path| {
            check("world.dem", path)?;
            let mut others = source::files_of(path);
            others.extend(links_read_in(path));
            others.iter().try_for_each(|other| check("world.dem", other))
        };
        match &self.world {
            World::File(path) => check_dem(path)?,
            World::Files(paths) => paths.iter().try_for_each(|path| check_dem(path))?,
            World::Url(url) => return Err(outside("world.dem", remote::name_of(url), "is a URL")),
            World::Procedural { .. } | World::Continent { .. } | World::Model(_) | World::Memory => {}
        }
        for (key, path) in self.forest.iter().flat_map(|forest| forest.cover.files()) {
            check(key, path)?;
            source::files_of(path).iter().try_for_each(|other| check(key, other))?;
        }
        for (key, path) in self.water.files() {
            check(key, path)?;
            source::files_of(path).iter().try_for_each(|other| check(key, other))?;
        }
        self.features.iter().try_for_each(|file| check("features.file", &file.path))?;
        self.images.iter().try_for_each(|file| check("images.file", &file.path))?;
        let mut trees = self.forest.iter().flat_map(|forest| &forest.models);
        trees.try_for_each(|model| check("forest.species.file", &model.file))?;
        self.meshes.iter().try_for_each(|mesh| check("meshes.file", &mesh.file))?;
        self.mesh_lists().try_for_each(|list| check("meshes.instances", list))
    }
}

/// A folder that paths may not leave.
struct Inside {
    /// The path with links resolved; `None` if the folder does not exist.
    real: Option<PathBuf>,
    /// The absolute path with `..` resolved by name alone.
    named: PathBuf,
}

impl Inside {
    fn of(folder: &Path) -> Self {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        Self { real: folder.canonicalize().ok(), named: without_dots(folder) }
    }

    /// Whether a path is inside. Links are resolved for an existing file; a missing one is judged by its name.
    fn holds(&self, path: &Path) -> bool {
        match (path.canonicalize(), &self.real) {
            (Ok(place), Some(real)) => place.starts_with(real),
            _ => without_dots(path).starts_with(&self.named),
        }
    }
}

/// Returns the absolute path with `.` and `..` resolved by name alone.
fn without_dots(path: &Path) -> PathBuf {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    absolute.components().fold(PathBuf::new(), |mut whole, part| {
        match part {
            Component::ParentDir => {
                whole.pop();
            }
            Component::CurDir => {}
            part => whole.push(part),
        }
        whole
    })
}

/// Returns the symbolic links among the files that are read when a folder of height files, or of tiles, is opened.
fn links_read_in(folder: &Path) -> Vec<PathBuf> {
    match source::kind_of(folder) {
        Kind::File => Vec::new(),
        Kind::TileFolder => links_in(folder, TILE_LEVELS),
        Kind::Folder => {
            let mut links = links_in(folder, 1);
            for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
                let levels = if source::kind_of(&entry.path()) == Kind::TileFolder { TILE_LEVELS } else { 1 };
                links.extend(links_in(&entry.path(), levels));
            }
            links
        }
    }
}

/// Returns the symbolic links in a folder and its subfolders, `levels` deep.
fn links_in(folder: &Path, levels: usize) -> Vec<PathBuf> {
    let mut links = Vec::new();
    // Unreadable folders fail later, when they are opened.
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        match entry.file_type() {
            Ok(kind) if kind.is_symlink() => links.push(entry.path()),
            Ok(kind) if kind.is_dir() && levels > 1 => links.extend(links_in(&entry.path(), levels - 1)),
            _ => {}
        }
    }
    links
}
