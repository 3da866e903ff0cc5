//! Random access to a remote or local file.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::blocks::{BLOCK_BYTES, Block, Blocks};
use super::disk::DiskCache;
use super::patience::Patience;
use super::retry::with_retries;
use super::traffic::Counters;
use super::transport::{Answer, NoAnswer, Transport};
use super::url::RemoteUrl;
use super::{Cancelled, Fnv, RemoteError, Settings, Traffic, never};

/// Bytes of the first request: they contain the headers and directories of most files.
const FIRST_BYTES: u64 = 4 * BLOCK_BYTES;
/// Largest number of blocks per request.
const MAX_BLOCKS: u64 = 64;
/// Time for which a thread waits for another thread's block before it checks again.
const LOOK: Duration = Duration::from_millis(20);

/// An open file. All methods may be called from several threads at once.
pub struct RemoteFile {
    url: RemoteUrl,
    settings: Settings,
    transport: Transport,
    size: u64,
    version: Option<String>,
    key: u64,
    blocks: Mutex<Blocks>,
    arrived: Condvar,
    disk: Option<Arc<DiskCache>>,
    counters: Counters,
    patience: Arc<Patience>,
    twice: AtomicBool,
}

/// Blocks that stay in memory as long as this value exists.
#[derive(Clone, Debug, Default)]
pub struct HeldBlocks {
    _blocks: Vec<Arc<Block>>,
}

impl RemoteFile {
    /// Opens `location`: a path, `http://`, `https://` or `s3://bucket/key`. The first request returns the size, the
    /// version and the beginning, which is read twice (see [`RemoteFile::read_twice`], which is on afterwards).
    ///
    /// # Errors
    /// Fails if the URL cannot be parsed, if there is no such file, or if the server does not answer.
    pub fn open(location: &str, settings: Settings) -> Result<Arc<Self>, RemoteError> {
        let patience = Patience::new(settings.patience, settings.idle_timeout);
        Self::open_with_patience(location, settings, patience)
    }

    /// Opens a file that is read together with this one; both share one time limit for waiting.
    ///
    /// # Errors
    /// The same as [`RemoteFile::open`].
    pub fn open_sidecar(&self, location: &str, settings: Settings) -> Result<Arc<Self>, RemoteError> {
        Self::open_with_patience(location, settings, Arc::clone(&self.patience))
    }

    fn open_with_patience(
        location: &str,
        settings: Settings,
        patience: Arc<Patience>,
    ) -> Result<Arc<Self>, RemoteError> {
        let url = RemoteUrl::parse(location)?;
        let transport = Transport::open(&url, &settings)?;
        let counters = Counters::default();
        let mut file = Self {
            size: u64::MAX,
            version: None,
            key: 0,
            blocks: Mutex::new(Blocks::new(settings.memory_bytes)),
            arrived: Condvar::new(),
            disk: None,
            counters,
            patience,
            twice: AtomicBool::new(true),
            url,
            settings,
            transport,
        };
        let answer = file.fetch(0..FIRST_BYTES, &never)?;
        if answer.size == 0 {
            return Err(RemoteError::Unusable { name: file.url.name, cause: "is empty".into() });
        }
        file.size = answer.size;
        file.key = Fnv::new()
            .add(location.as_bytes())
            .add(format!("\n{}\n{:?}", answer.size, answer.version).as_bytes())
            .finish();
        // Without a version there is no way to know whether the cached blocks belong to this file or to its
        // predecessor.
        if file.transport.is_remote() && answer.version.is_some() {
            let settings = &file.settings;
            file.disk = settings.cache.as_deref().map(|folder| DiskCache::open(folder, settings.cache_bytes));
        }
        file.version = answer.version;
        let mut blocks = file.lock();
        for (index, bytes) in (0..).zip(answer.bytes.chunks(BLOCK_BYTES as usize)) {
            blocks.insert(&Arc::new(Block { index, bytes: bytes.to_vec() }));
            blocks.be_careful(index);
        }
        drop(blocks);
        Ok(Arc::new(file))
    }

    /// Returns the URL without secrets.
    pub fn name(&self) -> &str {
        &self.url.name
    }

    /// Returns the size in bytes.
    pub fn size(&self) -> u64 {
        self.size
    }

    /// Returns whether the file is on another machine.
    pub fn is_remote(&self) -> bool {
        self.transport.is_remote()
    }

    /// Returns the network traffic so far.
    pub fn traffic(&self) -> Traffic {
        self.counters.traffic()
    }

    /// While this is on, every block that is read is requested twice, now and whenever it is fetched over the network
    /// again, and the answers must agree. It is for bytes without a checksum: two answers with the same corruption are
    /// unlikely.
    pub fn read_twice(&self, twice: bool) {
        self.twice.store(twice, Ordering::Relaxed);
    }

    /// Reads the bytes of a range.
    ///
    /// # Errors
    /// Fails if the range is not inside the file, or after all retries; returns [`RemoteError::Cancelled`] if
    /// `cancelled` returns true.
    pub fn read(&self, offset: u64, length: usize, cancelled: Cancelled<'_>) -> Result<Vec<u8>, RemoteError> {
        let range = self.checked(offset, length as u64)?;
        let mut bytes = Vec::with_capacity(length);
        for block in self.bring(std::slice::from_ref(&range), cancelled)? {
            let start = block.index * BLOCK_BYTES;
            let from = range.start.saturating_sub(start) as usize;
            let to = ((range.end - start) as usize).min(block.bytes.len());
            bytes.extend_from_slice(&block.bytes[from..to]);
        }
        Ok(bytes)
    }

    /// Loads the blocks of all ranges into memory, where they stay as long as the returned value exists. Parts of
    /// ranges beyond the end of the file are ignored.
    ///
    /// # Errors
    /// The same as [`RemoteFile::read`].
    pub fn hold(&self, ranges: &[Range<u64>], cancelled: Cancelled<'_>) -> Result<HeldBlocks, RemoteError> {
        Ok(HeldBlocks { _blocks: self.bring(ranges, cancelled)? })
    }

    /// Drops the blocks of a range from memory and disk, because their content is invalid: the next read requests them
    /// again.
    pub fn invalidate(&self, range: Range<u64>) {
        for index in self.indices(&range) {
            // The generation changes before the disk is cleaned: a thread that reads the disk meanwhile notices the new
            // generation and reads again.
            self.lock().forget(index);
            if let Some(disk) = &self.disk {
                disk.remove(self.key, index);
            }
            self.lock().forget(index);
            self.counters.invalidated.add(1);
        }
    }

    /// Drops all blocks from memory.
    pub fn forget(&self) {
        self.lock().clear();
    }

    fn lock(&self) -> MutexGuard<'_, Blocks> {
        // A poisoned lock guards only data that can be fetched again.
        self.blocks.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn checked(&self, offset: u64, length: u64) -> Result<Range<u64>, RemoteError> {
        let end = offset.checked_add(length).filter(|&end| end <= self.size);
        let (name, size) = (&self.url.name, self.size);
        end.map(|end| offset..end).ok_or_else(|| RemoteError::OutOfRange { name: name.clone(), offset, length, size })
    }

    fn indices(&self, range: &Range<u64>) -> Range<u64> {
        let end = range.end.min(self.size);
        if range.start >= end { 0..0 } else { range.start / BLOCK_BYTES..end.div_ceil(BLOCK_BYTES) }
    }

    fn block_length(&self, index: u64) -> usize {
        (self.size - index * BLOCK_BYTES).min(BLOCK_BYTES) as usize
    }

    /// Returns the blocks of all ranges, in order.
    fn bring(&self, ranges: &[Range<u64>], cancelled: Cancelled<'_>) -> Result<Vec<Arc<Block>>, RemoteError> {
        let mut wanted: BTreeMap<u64, Option<Arc<Block>>> =
            ranges.iter().flat_map(|range| self.indices(range)).map(|index| (index, None)).collect();
        if self.twice.load(Ordering::Relaxed) {
            let mut blocks = self.lock();
            wanted.keys().for_each(|&index| blocks.be_careful(index));
        }
        loop {
            let mut claims = Claims { file: self, indices: Vec::new(), generation: 0 };
            let mut missing = false;
            {
                let mut blocks = self.lock();
                claims.generation = blocks.generation();
                for (&index, found) in wanted.iter_mut().filter(|(_, found)| found.is_none()) {
                    *found = blocks.get(index);
                    if found.is_some() {
                        self.counters.memory_hits.add(1);
                    } else if blocks.claim(index) {
                        claims.indices.push(index);
                    } else {
                        missing = true;
                    }
                }
            }
            if !claims.indices.is_empty() {
                for block in self.bring_claimed(claims, cancelled)? {
                    wanted.insert(block.index, Some(block));
                }
            } else if missing {
                if cancelled() {
                    return Err(RemoteError::Cancelled);
                }
                // Another thread is fetching them.
                let waited = self.arrived.wait_timeout(self.lock(), LOOK);
                drop(waited.unwrap_or_else(PoisonError::into_inner));
            } else {
                return Ok(wanted.into_values().flatten().collect());
            }
        }
    }

    /// Fetches the claimed blocks from disk or the transport. Blocks from disk that were invalidated meanwhile are left
    /// out; the caller tries again.
    fn bring_claimed(&self, mut claims: Claims<'_>, cancelled: Cancelled<'_>) -> Result<Vec<Arc<Block>>, RemoteError> {
        let mut brought = Vec::with_capacity(claims.indices.len());
        let mut absent = Vec::new();
        for index in std::mem::take(&mut claims.indices) {
            let cached = self
                .disk
                .as_ref()
                .and_then(|disk| disk.get(self.key, index, self.block_length(index), self.settings.verify));
            match cached {
                Some(bytes) => {
                    let block = Arc::new(Block { index, bytes });
                    let mut blocks = self.lock();
                    if blocks.generation() == claims.generation {
                        blocks.insert(&block);
                        self.counters.disk_hits.add(1);
                        brought.push(block);
                    }
                    blocks.release(index);
                }
                None => absent.push(index),
            }
        }
        self.arrived.notify_all();
        claims.indices = absent;
        while let Some(&first) = claims.indices.first() {
            let adjoining = (first..first + MAX_BLOCKS).zip(&claims.indices).take_while(|(a, b)| a == *b).count();
            let start = first * BLOCK_BYTES;
            let end = ((first + adjoining as u64) * BLOCK_BYTES).min(self.size);
            let answer = self.fetch(start..end, cancelled)?;
            for (index, bytes) in (first..).zip(answer.bytes.chunks(BLOCK_BYTES as usize)) {
                let block = Arc::new(Block { index, bytes: bytes.to_vec() });
                // The block is stored on disk first: as soon as it is in memory, another thread may decode and
                // invalidate it.
                if let Some(disk) = &self.disk {
                    disk.put(self.key, &block);
                }
                let mut blocks = self.lock();
                blocks.insert(&block);
                blocks.release(index);
                brought.push(block);
            }
            claims.indices.drain(..adjoining);
            self.arrived.notify_all();
        }
        Ok(brought)
    }

    /// Fetches a range with one request, or with two if it must be verified; retries after failures.
    fn fetch(&self, range: Range<u64>, cancelled: Cancelled<'_>) -> Result<Answer, RemoteError> {
        let careful = self.twice.load(Ordering::Relaxed) || self.lock().is_careful(self.indices(&range));
        let twice = careful && self.transport.is_remote() && self.settings.verify;
        let request = || {
            let answer = self.request(range.clone(), cancelled)?;
            if twice {
                let again = self.request(range.clone(), cancelled)?;
                if again.bytes != answer.bytes || again.version != answer.version {
                    return Err(NoAnswer::Again("two answers to the same request differ".into()));
                }
            }
            Ok(answer)
        };
        let failed = |cause: &str| {
            tracing::debug!("{}: {cause}", self.url.name);
            self.counters.retries.add(1);
        };
        let fetched = with_retries(&self.url.name, &self.settings, &self.patience, cancelled, request, failed);
        if matches!(fetched, Err(RemoteError::Failed { .. } | RemoteError::GivenUp { .. })) {
            // The read as a whole has failed: no further try follows.
            self.counters.failures.add(1);
        }
        fetched
    }

    fn request(&self, range: Range<u64>, cancelled: Cancelled<'_>) -> Result<Answer, NoAnswer> {
        self.counters.requests.add(1);
        let is_over = || cancelled() || self.patience.remaining().is_zero();
        let answer = self.transport.get(range, &self.url, &is_over)?;
        self.counters.bytes.add(answer.bytes.len() as u64);
        self.patience.add_received(answer.bytes.len() as u64);
        if self.size != u64::MAX && (answer.size != self.size || answer.version != self.version) {
            return Err(NoAnswer::Never(RemoteError::Changed { name: self.url.name.clone() }));
        }
        Ok(answer)
    }
}

/// Claims that are released when this is dropped.
struct Claims<'a> {
    file: &'a RemoteFile,
    indices: Vec<u64>,
    generation: u64,
}

impl Drop for Claims<'_> {
    fn drop(&mut self) {
        if self.indices.is_empty() {
            return;
        }
        let mut blocks = self.file.lock();
        for &index in &self.indices {
            blocks.release(index);
        }
        drop(blocks);
        self.file.arrived.notify_all();
    }
}
