//! The disk cache: a folder of blocks that were fetched over a network.
//!
//! Each block is one file, in a folder for each version of each remote file (URL, ETag, modification time, size):
//!
//! ```text
//! 8 bytes  "HACHBLK1"
//! u64      key of the file and its version
//! u64      index of the block
//! u32      number of bytes
//! u64      FNV-1a of the three numbers and the bytes
//! …        the bytes
//! ```
//!
//! A file is written under a temporary name and then renamed, but it is not synced to the disk: a crash of the machine
//! may leave a short file, or one with holes. Length and checksum reveal that when the file is read; it is then removed
//! and fetched again. A disk that is full or not writable is reported once, and reading continues without it.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use super::Fnv;
use super::blocks::Block;
use crate::file::atomic::{AtomicFile, Readers, named_in_temporary};
use crate::file::cache_folder;
use crate::file::unnamed::head;

const MAGIC: &[u8; 8] = b"HACHBLK1";
const HEAD_BYTES: usize = 8 + 8 + 8 + 4 + 8;
/// Largest file that is read, in bytes; blocks are much smaller.
const LARGEST_BYTES: u64 = 64 << 20;

/// Time for which the disk is not written to after a failed write.
const REST: Duration = Duration::from_secs(60);
/// Smallest interval between two updates of a block's time of use.
const TOUCH_AFTER: Duration = Duration::from_secs(60 * 60);
/// Age at which a temporary file belongs to no running program.
const ABANDONED_AFTER: Duration = Duration::from_secs(60 * 60);

/// The open caches, one for each folder, so that the size of a folder is counted once.
static FOLDERS: Mutex<Vec<Arc<DiskCache>>> = Mutex::new(Vec::new());

/// A cache folder of blocks.
pub(super) struct DiskCache {
    folder: PathBuf,
    limit: u64,
    state: Mutex<State>,
    warned: AtomicBool,
    met_damage: AtomicBool,
}

#[derive(Default)]
struct State {
    /// Bytes of all blocks; `None` until the folder has been scanned.
    bytes: Option<u64>,
    rests_until: Option<Instant>,
}

impl DiskCache {
    /// Opens the cache in `folder` with a size limit of `limit` bytes.
    pub(super) fn open(folder: &Path, limit: u64) -> Arc<Self> {
        let mut folders = FOLDERS.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(open) = folders.iter().find(|open| open.folder == folder && open.limit == limit) {
            return open.clone();
        }
        let opened = Arc::new(Self {
            folder: folder.to_owned(),
            limit,
            state: Mutex::default(),
            warned: AtomicBool::new(false),
            met_damage: AtomicBool::new(false),
        });
        folders.push(opened.clone());
        opened
    }

    fn path(&self, key: u64, index: u64) -> PathBuf {
        self.folder.join(format!("{key:016x}")).join(format!("{index:08x}.block"))
    }

    /// Returns the block of `length` bytes, if it is cached and complete. Without `verify` its checksum is not checked.
    pub(super) fn get(&self, key: u64, index: u64, length: usize, verify: bool) -> Option<Vec<u8>> {
        let path = self.path(key, index);
        let file = cache_folder::read(&path, LARGEST_BYTES)?;
        match parse(&file, verify) {
            Some((found_key, found, bytes)) if (found_key, found, bytes.len()) == (key, index, length) => {
                touch(&path);
                Some(bytes.to_vec())
            }
            _ => {
                // Only the first damaged block is a warning: a bad disk damages many.
                if self.met_damage.swap(true, Ordering::Relaxed) {
                    tracing::debug!("{}: this cached block is damaged and is fetched again", path.display());
                } else {
                    tracing::warn!("a cached block of a remote file is damaged and is fetched again");
                }
                self.remove(key, index);
                None
            }
        }
    }

    /// Caches a block, if the disk can be written.
    pub(super) fn put(&self, key: u64, block: &Block) {
        let bytes = {
            let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
            if state.rests_until.is_some_and(|until| Instant::now() < until) {
                return;
            }
            state.rests_until = None;
            *state.bytes.get_or_insert_with(|| survey(&self.folder).iter().map(|file| file.bytes).sum())
        };
        if bytes > self.limit {
            self.trim();
        }
        let path = self.path(key, block.index);
        if let Err(error) = write(&path, key, block) {
            let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
            state.rests_until = Some(Instant::now() + REST);
            if !self.warned.swap(true, Ordering::Relaxed) {
                let folder = self.folder.display();
                tracing::warn!(
                    "{folder}: the cache cannot be written, so nothing is cached ({error}); HACHURE_CACHE sets another folder"
                );
            }
            return;
        }
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(bytes) = &mut state.bytes {
            *bytes += (HEAD_BYTES + block.bytes.len()) as u64;
        }
    }

    /// Removes a block.
    pub(super) fn remove(&self, key: u64, index: u64) {
        let path = self.path(key, index);
        let bytes = fs::metadata(&path).map_or(0, |metadata| metadata.len());
        if fs::remove_file(&path).is_ok() {
            let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
            state.bytes = state.bytes.map(|all| all.saturating_sub(bytes));
        }
    }

    /// Removes the least recently used blocks until nine tenths of the limit are left.
    fn trim(&self) {
        // Blocks that other processes write meanwhile are trimmed the next time.
        let mut files = survey(&self.folder);
        files.sort_by_key(|file| file.used);
        let mut total: u64 = files.iter().map(|file| file.bytes).sum();
        for file in files {
            if total <= self.limit / 10 * 9 {
                break;
            }
            if head(&file.path, MAGIC.len()) == MAGIC && fs::remove_file(&file.path).is_ok() {
                total -= file.bytes;
                if let Some(folder) = file.path.parent() {
                    // This removes the folder only if it is empty.
                    let _ = fs::remove_dir(folder);
                }
            }
        }
        self.state.lock().unwrap_or_else(PoisonError::into_inner).bytes = Some(total);
    }
}

struct File {
    path: PathBuf,
    bytes: u64,
    used: SystemTime,
}

/// Lists all blocks in the folder. Removes abandoned temporary files.
fn survey(folder: &Path) -> Vec<File> {
    let mut files = Vec::new();
    let folders = fs::read_dir(folder).into_iter().flatten().flatten();
    for entry in folders.filter_map(|entry| fs::read_dir(entry.path()).ok()).flatten().flatten() {
        let (path, Ok(metadata)) = (entry.path(), entry.metadata()) else { continue };
        let used = metadata.modified().unwrap_or(UNIX_EPOCH);
        let name = entry.file_name().to_string_lossy().into_owned();
        if !metadata.is_file() {
            continue;
        }
        if is_block(&name) {
            files.push(File { path, bytes: metadata.len(), used });
        } else if named_in_temporary(&name).is_some_and(is_block)
            && used.elapsed().is_ok_and(|age| age > ABANDONED_AFTER)
        {
            let _ = fs::remove_file(&path);
        }
    }
    files
}

/// Returns whether a name is that of a block: its index in hexadecimal digits.
fn is_block(name: &str) -> bool {
    let index = name.strip_suffix(".block").unwrap_or_default();
    index.len() >= 8 && index.bytes().all(|byte| byte.is_ascii_hexdigit())
}

fn write(path: &Path, key: u64, block: &Block) -> io::Result<()> {
    if let Some(folder) = path.parent() {
        cache_folder::create_within(folder)?;
    }
    let mut file = AtomicFile::create_for(path, Readers::Owner)?;
    file.writer().write_all(&head_of(key, block))?;
    file.writer().write_all(&block.bytes)?;
    file.commit_unsynced()
}

fn checksum(key: u64, index: u64, bytes: &[u8]) -> u64 {
    let length = (bytes.len() as u32).to_le_bytes();
    Fnv::new().add(&key.to_le_bytes()).add(&index.to_le_bytes()).add(&length).add(bytes).finish()
}

/// Returns the bytes of a file before those of the block.
fn head_of(key: u64, block: &Block) -> Vec<u8> {
    let mut head = Vec::with_capacity(HEAD_BYTES);
    head.extend_from_slice(MAGIC);
    head.extend_from_slice(&key.to_le_bytes());
    head.extend_from_slice(&block.index.to_le_bytes());
    head.extend_from_slice(&(block.bytes.len() as u32).to_le_bytes());
    head.extend_from_slice(&checksum(key, block.index, &block.bytes).to_le_bytes());
    head
}

/// Returns the key, the block index and the bytes of a block file; `None` if anything is wrong.
fn parse(file: &[u8], verify: bool) -> Option<(u64, u64, &[u8])> {
    let (head, bytes) = file.split_at_checked(HEAD_BYTES)?;
    let number = |at: usize| Some(u64::from_le_bytes(head.get(at..at + 8)?.try_into().ok()?));
    let (key, index, sum) = (number(8)?, number(16)?, number(28)?);
    let length = u32::from_le_bytes(head.get(24..28)?.try_into().ok()?);
    let whole = &head[..8] == MAGIC && bytes.len() == length as usize;
    (whole && (!verify || sum == checksum(key, index, bytes))).then_some((key, index, bytes))
}

/// Sets the modification time of a block to its last use, roughly. It is only a hint for [`DiskCache::trim`].
fn touch(path: &Path) {
    let Ok(metadata) = fs::metadata(path) else { return };
    if metadata.modified().is_ok_and(|used| used.elapsed().is_ok_and(|age| age > TOUCH_AFTER)) {
        let _ = fs::File::options().append(true).open(path).and_then(|file| file.set_modified(SystemTime::now()));
    }
}

/// A file in the cache folder, as a reader would find it.
#[derive(Clone, Debug)]
pub struct CachedBlock {
    pub path: PathBuf,
    /// Index and bytes of the block; `None` if a reader would discard the file.
    pub block: Option<(u64, Vec<u8>)>,
}

/// Lists the files of a cache folder, for tests and diagnosis.
pub fn inspect(folder: &Path) -> Vec<CachedBlock> {
    let found = survey(folder).into_iter().map(|file| {
        let bytes = fs::read(&file.path).unwrap_or_default();
        let block = parse(&bytes, true).map(|(_, index, bytes)| (index, bytes.to_vec()));
        CachedBlock { path: file.path, block }
    });
    found.collect()
}

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "a test may write damaged files")]
mod tests {
    use super::*;

    #[test]
    fn damaged_blocks_are_not_used() {
        let folder = tempfile::tempdir().unwrap();
        let cache = DiskCache::open(folder.path(), 1 << 20);
        let block = Block { index: 7, bytes: (0..1000).map(|i| i as u8).collect() };
        cache.put(3, &block);
        assert_eq!(cache.get(3, 7, 1000, true), Some(block.bytes.clone()));
        let path = cache.path(3, 7);
        let whole = fs::read(&path).unwrap();
        for cut in (0..whole.len()).step_by(37) {
            fs::write(&path, &whole[..cut]).unwrap();
            assert_eq!(cache.get(3, 7, 1000, true), None, "{cut}");
            assert!(!path.exists());
        }
        for flipped in (0..whole.len()).step_by(29).chain(0..HEAD_BYTES) {
            let mut bytes = whole.clone();
            bytes[flipped] ^= 1 << (flipped % 8);
            fs::write(&path, &bytes).unwrap();
            assert_eq!(cache.get(3, 7, 1000, true), None, "{flipped}");
        }
        // A block of another file, or with another index, is rejected.
        fs::write(cache.path(3, 7), &whole).unwrap();
        fs::copy(&path, cache.path(3, 8)).unwrap();
        assert_eq!(cache.get(3, 8, 1000, true), None);
        assert_eq!(cache.get(3, 7, 999, true), None);
    }

    #[test]
    fn the_oldest_files_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let cache = DiskCache::open(folder.path(), 50_000);
        for index in 0..100 {
            cache.put(1, &Block { index, bytes: vec![0; 1000] });
            let path = cache.path(1, index);
            let time = UNIX_EPOCH + Duration::from_secs(1_000_000 + index);
            fs::File::options().append(true).open(path).unwrap().set_modified(time).unwrap();
        }
        let left = survey(folder.path());
        assert!(left.iter().map(|file| file.bytes).sum::<u64>() <= 52_000);
        assert!(cache.get(1, 99, 1000, true).is_some() && cache.get(1, 0, 1000, true).is_none());
    }

    #[test]
    fn a_folder_that_cannot_be_written_is_passed_over() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("in the way");
        fs::write(&file, b"x").unwrap();
        let cache = DiskCache::open(&file, 1 << 20);
        cache.put(1, &Block { index: 0, bytes: vec![1] });
        cache.put(1, &Block { index: 1, bytes: vec![1] });
        assert_eq!(cache.get(1, 0, 1, true), None);
    }
}
