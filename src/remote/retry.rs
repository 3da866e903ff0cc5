//! Trying again: after a pause that doubles, of which chance takes a part, so that many readers do not knock together.

use std::hash::{BuildHasher, RandomState};
use std::time::{Duration, Instant};

use super::transport::NoAnswer;
use super::{Cancelled, RemoteError, Settings};

/// How often a pause looks whether the bytes are still wanted.
const LOOK: Duration = Duration::from_millis(20);

/// Makes a request until it is answered, cannot be, or was made often enough. `failed` hears of each try in vain.
pub fn persistently<T>(
    name: &str,
    settings: &Settings,
    cancelled: Cancelled<'_>,
    mut request: impl FnMut() -> Result<T, NoAnswer>,
    failed: impl Fn(&str),
) -> Result<T, RemoteError> {
    let mut pause = settings.first_pause;
    let mut tries = 0;
    loop {
        if cancelled() {
            return Err(RemoteError::Cancelled);
        }
        tries += 1;
        let cause = match request() {
            Ok(answer) => return Ok(answer),
            Err(NoAnswer::Never(error)) => return Err(error),
            Err(NoAnswer::Again(cause)) => cause,
        };
        failed(&cause);
        if tries >= settings.tries {
            return Err(RemoteError::Failed { name: name.to_owned(), tries, cause });
        }
        let end = Instant::now() + pause.mul_f64(1.0 - 0.5 * chance());
        while let Some(left) = end.checked_duration_since(Instant::now()) {
            if cancelled() {
                return Err(RemoteError::Cancelled);
            }
            std::thread::sleep(left.min(LOOK));
        }
        pause = (pause * 2).min(settings.longest_pause);
    }
}

/// A number from 0 to 1. The standard library's hasher has a key from the system's chance.
fn chance() -> f64 {
    (RandomState::new().hash_one(0) >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    #[test]
    fn gives_up_in_time() {
        let settings = Settings {
            first_pause: Duration::from_millis(2),
            longest_pause: Duration::from_millis(5),
            ..Settings::default()
        };
        let told = Cell::new(0);
        let again = || Err::<(), _>(NoAnswer::Again("no".into()));
        let error = persistently("it", &settings, &crate::remote::never, again, |_| told.set(told.get() + 1));
        assert_eq!(error.unwrap_err().to_string(), "it: no answer after 6 tries: no");
        assert_eq!(told.get(), 6);
        let mut left = 3;
        let later = || {
            left -= 1;
            if left == 0 { Ok(5) } else { Err(NoAnswer::Again(String::new())) }
        };
        assert_eq!(persistently("it", &settings, &crate::remote::never, later, |_| {}).unwrap(), 5);
        let patient = Settings { first_pause: Duration::from_secs(60), ..settings };
        let start = Instant::now();
        let soon = move || start.elapsed() > Duration::from_millis(50);
        let stopped = persistently("it", &patient, &soon, again, |_| {});
        assert!(matches!(stopped, Err(RemoteError::Cancelled)) && start.elapsed() < Duration::from_secs(5));
    }
}
