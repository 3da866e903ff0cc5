//! The memory that a case needed: the peak resident size of the process, which Linux reports and allows to be reset.

/// Resets the peak; returns the current resident size in bytes.
pub(crate) fn reset() -> Option<u64> {
    // 5 resets the peak to the current size: see proc_pid_clear_refs(5).
    std::fs::write("/proc/self/clear_refs", "5").ok()?;
    peak_bytes()
}

/// Returns the peak resident size since the last reset, in bytes.
pub(crate) fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let (_, rest) = status.split_once("VmHWM:")?;
    let kilobytes = rest.split_whitespace().next()?.parse::<u64>().ok()?;
    Some(kilobytes * 1024)
}

pub(crate) fn is_measured() -> bool {
    reset().is_some()
}
