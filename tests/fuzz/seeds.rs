//! Groups of files, the damage to one of them, and their repair.

use std::fs;
use std::path::{Path, PathBuf};

use super::mutate::{self, Random};

/// Valid files of a kind, some of which belong together.
pub(crate) struct Seed {
    pub folder: PathBuf,
    /// The path to open: the name of a file in the folder, or empty for the folder itself.
    pub entry: String,
    files: Vec<(String, Vec<u8>)>,
}

impl Seed {
    /// Creates a seed of all files in a folder and its subfolders.
    pub(crate) fn of(folder: &Path, entry: &str) -> Self {
        let mut files = Vec::new();
        let mut folders = vec![folder.to_owned()];
        while let Some(inner) = folders.pop() {
            for entry in fs::read_dir(inner).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    folders.push(path);
                } else {
                    let name = path.strip_prefix(folder).unwrap().to_str().unwrap().to_owned();
                    files.push((name, fs::read(path).unwrap()));
                }
            }
        }
        // A folder lists its files in any order, but a case must be the same each time.
        files.sort();
        assert!(!files.is_empty(), "{}: holds no files", folder.display());
        Self { folder: folder.to_owned(), entry: entry.to_owned(), files }
    }

    pub(crate) fn entry(&self) -> PathBuf {
        match self.entry.as_str() {
            "" => self.folder.clone(),
            name => self.folder.join(name),
        }
    }

    /// Returns the names of which a message must contain one.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        let folder = self.folder.file_name().and_then(|name| name.to_str()).filter(|_| self.entry.is_empty());
        self.files.iter().map(|(name, _)| name.as_str()).chain(folder)
    }

    /// Damages one of the files on disk.
    pub(crate) fn mutate(&self, donor: &Self, random: &mut Random) {
        let (name, bytes) = &self.files[random.below(self.files.len())];
        let (_, donor) = &donor.files[random.below(donor.files.len())];
        fs::write(self.folder.join(name), mutate::damaged(bytes, donor, random)).unwrap();
    }

    /// Restores all files.
    pub(crate) fn restore(&self) {
        for (name, bytes) in &self.files {
            let path = self.folder.join(name);
            if fs::read(&path).ok().as_ref() != Some(bytes) {
                fs::write(path, bytes).unwrap();
            }
        }
    }

    /// Copies the current files to a folder that outlives the test.
    pub(crate) fn keep(&self, kind: &str, run_seed: u64, number: u64) -> PathBuf {
        let kept = std::env::temp_dir().join(format!("hachure-fuzz-{kind}-{run_seed}-{number}"));
        for (name, _) in &self.files {
            let to = kept.join(name);
            fs::create_dir_all(to.parent().unwrap()).unwrap();
            fs::copy(self.folder.join(name), to).unwrap();
        }
        kept
    }
}
