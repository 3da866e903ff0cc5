//! How patient a reader is, and how much it keeps.

use std::path::PathBuf;
use std::time::Duration;

/// How a file is read. The default is for flying; tests are less patient.
#[derive(Clone)]
pub struct Settings {
    /// The folder for blocks of files on other machines; none keeps nothing on disk.
    pub cache: Option<PathBuf>,
    /// How much the folder may hold, in bytes: 4 GiB.
    pub cache_bytes: u64,
    /// How much of a file stays in memory, in bytes: 32 MiB.
    pub memory_bytes: usize,
    /// Until a server must have taken the connection: 5 s.
    pub connect_timeout: Duration,
    /// No answer may stop for longer, before its first byte or between two: 10 s.
    pub idle_timeout: Duration,
    /// Until an answer must be there, whole: 20 s.
    pub request_timeout: Duration,
    /// How long a file may keep its reader waiting over all requests, less what the bytes that came gave back: 45 s.
    pub patience: Duration,
    /// The pause before the second try: 0.1 s. Each further one is twice as long; chance takes up to half of it away.
    pub first_pause: Duration,
    /// No pause is longer: 5 s.
    pub longest_pause: Duration,
    /// How often a request is made in all: 6.
    pub tries: u32,
    /// What the `AWS_*` variables say.
    pub s3: Vec<(String, String)>,
    /// Only tests switch it off, to see that they would find what the checks keep away.
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
