//! Files that only an imprint names: their errors do not quote them.

use std::path::PathBuf;

use anyhow::anyhow;

use crate::commands::misuse::Misuse;
use crate::file::message::named;

/// Files that an imprint names and the command line does not. Whoever made the picture may not be allowed to read them,
/// and hachure may run for somebody else who may. So an error never quotes them: it says only that the file is not what
/// it should be.
#[derive(Clone, Debug, Default)]
pub(in crate::commands::render) struct Names {
    pub(super) like: PathBuf,
    pub(super) world: Option<PathBuf>,
    pub(super) water: Option<PathBuf>,
    pub(super) layers: Vec<PathBuf>,
    pub(super) images: Vec<PathBuf>,
    pub(super) path: Option<PathBuf>,
    pub(super) labels: Option<PathBuf>,
}

impl Names {
    /// Replaces the error of a world that the imprint names, or of its water, layers or images.
    pub(in crate::commands::render) fn world<T, E: Into<anyhow::Error>>(
        &self,
        result: Result<T, E>,
    ) -> anyhow::Result<T> {
        let world = self.world.iter().map(|file| ("world", file));
        let others = self.water.iter().map(|file| ("water", file));
        let layers = self.layers.iter().map(|file| ("layer", file));
        let images = self.images.iter().map(|file| ("image", file));
        let files = world.chain(others).chain(layers).chain(images);
        let files = files.map(|(what, file)| format!("its {what} {}", named(file)));
        self.hidden(result, &files.collect::<Vec<_>>().join(" or "), "as WORLD, or by --water, --layer or --drape")
    }

    /// Replaces the error of a camera path that the imprint names.
    pub(in crate::commands::render) fn path<T, E: Into<anyhow::Error>>(
        &self,
        result: Result<T, E>,
    ) -> anyhow::Result<T> {
        let file = self.path.as_ref().map(|file| format!("its path {}", named(file)));
        self.hidden(result, &file.unwrap_or_default(), "by --path")
    }

    /// Replaces the error of a file of names that the imprint names.
    pub(in crate::commands::render) fn labels<T, E: Into<anyhow::Error>>(
        &self,
        result: Result<T, E>,
    ) -> anyhow::Result<T> {
        let file = self.labels.as_ref().map(|file| format!("its file of names {}", named(file)));
        self.hidden(result, &file.unwrap_or_default(), "by --names")
    }

    /// Returns whether the command line names the file of names.
    pub(in crate::commands::render) fn has_own_labels(&self) -> bool {
        self.labels.is_none()
    }

    fn hidden<T, E: Into<anyhow::Error>>(&self, result: Result<T, E>, files: &str, how: &str) -> anyhow::Result<T> {
        match files {
            "" => result.map_err(Into::into),
            _ => result.map_err(|error| match error.into() {
                // The error is about an option that was typed, such as --seed, and quotes no file.
                error if error.is::<Misuse>() => error,
                _ => {
                    anyhow!(
                        "{}: {files} cannot be used; name it {how} on the command line to read why",
                        named(&self.like)
                    )
                }
            }),
        }
    }
}
