//! What a scene file may name: files beside and below it. A scene from somebody else can then neither show other files
//! of this machine nor make hachure contact servers. The user lifts the restriction for scenes that are trusted.

use std::path::{Component, Path, PathBuf};

use super::scene_file::SceneError;
use super::{Scene, World};
use crate::remote;
use crate::source::{self, Kind};

/// How far the names in a scene file may lead.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reach {
    /// To the folder of the scene file and what lies below it. Links that lead out of it count as outside.
    #[default]
    SceneFolder,
    /// Anywhere on this machine, and to the network.
    Anywhere,
}

impl Reach {
    /// As the command line says it.
    #[must_use]
    pub fn trusting(trusts: bool) -> Self {
        if trusts { Self::Anywhere } else { Self::SceneFolder }
    }
}

/// Tiles lie so deep in their folder: `z/x/y.png`.
const TILE_LEVELS: usize = 3;

impl Scene {
    /// Whether all that the scene file at `file` names may be reached.
    ///
    /// # Errors
    /// [`SceneError::Outside`], with the name that leads out.
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
            World::Url(url) => return Err(outside("world.dem", remote::name_of(url), "is an address on the network")),
            World::Procedural { .. } | World::Continent { .. } => {}
        }
        for (key, path) in self.forest.iter().flat_map(|forest| forest.cover.files()) {
            check(key, path)?;
            source::files_of(path).iter().try_for_each(|other| check(key, other))?;
        }
        for (key, path) in self.water.files() {
            check(key, path)?;
            source::files_of(path).iter().try_for_each(|other| check(key, other))?;
        }
        let mut trees = self.forest.iter().flat_map(|forest| &forest.models);
        trees.try_for_each(|model| check("forest.species.file", &model.file))?;
        self.meshes.iter().try_for_each(|mesh| check("meshes.file", &mesh.file))?;
        self.mesh_lists().try_for_each(|list| check("meshes.instances", list))
    }
}

/// A folder that paths may not leave.
struct Inside {
    /// Without links; none where the folder is not there.
    real: Option<PathBuf>,
    /// By its name alone.
    named: PathBuf,
}

impl Inside {
    fn of(folder: &Path) -> Self {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        Self { real: folder.canonicalize().ok(), named: without_dots(folder) }
    }

    /// An existing file is judged by its place after all links, a missing one by its name.
    fn holds(&self, path: &Path) -> bool {
        match (path.canonicalize(), &self.real) {
            (Ok(place), Some(real)) => place.starts_with(real),
            _ => without_dots(path).starts_with(&self.named),
        }
    }
}

/// An absolute path in which `..` has taken away what stands before it.
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

/// The links among all that is looked at when a folder of height files, or of tiles, is read.
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

/// The links in a folder and in the folders in it, `levels` deep.
fn links_in(folder: &Path, levels: usize) -> Vec<PathBuf> {
    let mut links = Vec::new();
    // What cannot be read fails when it is opened.
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        match entry.file_type() {
            Ok(kind) if kind.is_symlink() => links.push(entry.path()),
            Ok(kind) if kind.is_dir() && levels > 1 => links.extend(links_in(&entry.path(), levels - 1)),
            _ => {}
        }
    }
    links
}
