//! Counts how often a frame found a requested value in the caches of a renderer.

/// Hits and misses of one cache.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CacheCounts {
    /// Requests that found the value in the cache.
    pub hits: u64,
    /// Requests after which the value had to be made.
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
