//! Counts how often the caches of a renderer had what a frame requested.

/// Hits and misses of one cache.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CacheCounts {
    /// Requests that found what they wanted.
    pub hits: u64,
    /// Requests after which it had to be made.
    pub misses: u64,
}

impl CacheCounts {
    /// Counts a request.
    pub(crate) fn count(&mut self, is_hit: bool) {
        self.hits += u64::from(is_hit);
        self.misses += u64::from(!is_hit);
    }

    /// Returns the counts since an earlier state.
    pub(crate) fn since(self, before: Self) -> Self {
        Self { hits: self.hits - before.hits, misses: self.misses - before.misses }
    }
}
