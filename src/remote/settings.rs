//! Settings of reading: deadlines, retries and cache sizes.

use std::path::PathBuf;
use std::time::Duration;

/// Settings for reading a file. The defaults suit interactive flying; tests use shorter times.
#[derive(Clone)]
pub struct Settings {
    /// Folder for blocks of remote files; `None` disables the disk cache.
    pub cache: Option<PathBuf>,
    /// Size limit of the disk cache in bytes; default 4 GiB.
    pub cache_bytes: u64,
    /// Size limit of the blocks of one file in memory, in bytes; default 32 MiB.
    pub memory_bytes: usize,
    /// Deadline for connecting to a server; default 5 s.
    pub connect_timeout: Duration,
    /// Longest wait for data, before the first byte of an answer or between two; default 10 s.
    pub idle_timeout: Duration,
    /// Deadline for a complete answer; default 20 s.
    pub request_timeout: Duration,
    /// How long a file may keep its reader waiting over all requests, less the time that arriving bytes give back;
    /// default 45 s.
    pub patience: Duration,
    /// Pause before the second try; default 0.1 s. Each further pause is twice as long; random jitter shortens it by up
    /// to half.
    pub first_pause: Duration,
    /// Longest pause between two tries; default 5 s.
    pub longest_pause: Duration,
    /// Largest number of tries of a request; default 6.
    pub tries: u32,
    /// The `AWS_*` environment variables.
    pub s3: Vec<(String, String)>,
    /// Whether answers are verified. Only tests switch this off, to prove that they would detect what the checks
    /// prevent.
    #[doc(hidden)]
    pub verify: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            cache: None,
            cache_bytes: 4 << 30,
            memory_bytes: 32 << 20,
            connect_timeout: Duration::from_secs(5),
            idle_timeout: Duration::from_secs(10),
            request_timeout: Duration::from_secs(20),
            patience: Duration::from_secs(45),
            first_pause: Duration::from_millis(100),
            longest_pause: Duration::from_secs(5),
            tries: 6,
            s3: std::env::vars_os()
                .filter_map(|(key, value)| Some((key.into_string().ok()?, value.into_string().ok()?)))
                .filter(|(key, _)| key.starts_with("AWS_"))
                .collect(),
            verify: true,
        }
    }
}
