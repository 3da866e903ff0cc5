//! Memory of this process.

/// Returns the resident memory of this process in bytes, from Linux's `/proc/self/status`; `None` elsewhere.
pub fn rss_bytes() -> Option<u64> {
    rss_in(&std::fs::read_to_string("/proc/self/status").ok()?)
}

fn rss_in(status: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rss_is_found_or_none() {
        assert_eq!(rss_in("Name:\tx\nVmRSS:\t   1234 kB\nThreads: 1\n"), Some(1234 * 1024));
        assert_eq!(rss_in("Name:\tx\n"), None);
        assert_eq!(rss_in("VmRSS: many kB\n"), None);
    }
}
