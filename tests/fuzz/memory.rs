//! How much memory a case took: the highest share of the machine's memory that the process had, which Linux tells and
//! lets one reset.

/// Begins anew; the memory that is there now in bytes.
pub fn reset() -> Option<u64> {
    // 5 sets the peak to what is there: see proc_pid_clear_refs(5).
    std::fs::write("/proc/self/clear_refs", "5").ok()?;
    peak_bytes()
}

/// The most that there was since.
pub fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let (_, rest) = status.split_once("VmHWM:")?;
    let kilobytes = rest.split_whitespace().next()?.parse::<u64>().ok()?;
    Some(kilobytes * 1024)
}

pub fn is_measured() -> bool {
    reset().is_some()
}
