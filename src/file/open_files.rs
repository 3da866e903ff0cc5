//! The number of files that may be open at once. A world may have thousands of height files, each of which is open while
//! it is used, but many systems allow a program 1024 or 256 until it requests more.

/// Number of open files that is requested, unless the system allows fewer.
#[cfg(unix)]
const OPEN_FILES: u64 = 1 << 16;
/// The most that macOS allows, whatever its limit says.
#[cfg(unix)]
const OPEN_FILES_OF_MACOS: u64 = 10_240;

/// Raises the soft limit of open files, as far as the hard limit allows. A failure leaves it as it is: then opening a
/// file too many fails, and says why.
pub fn raise_file_limit() {
    #[cfg(unix)]
    {
        use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
        let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
        for wish in [OPEN_FILES, OPEN_FILES_OF_MACOS] {
            let wish = maximum.map_or(wish, |maximum| wish.min(maximum));
            let is_more = current.is_some_and(|current| current < wish);
            if !is_more || setrlimit(Resource::Nofile, Rlimit { current: Some(wish), maximum }).is_ok() {
                return;
            }
        }
    }
}
